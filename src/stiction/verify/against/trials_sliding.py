"""Trials of sliding and holding: slopes, directions, two coefficients, pushes, spinning faces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stiction.bench import rotations
from stiction.bench.scene import BenchBody, BenchScene, Vector, ground, quaternion
from stiction.shapes import Box, Cylinder
from stiction.verify.against.trial import LAWS, Array, G, Reading, Track, Trial, stops

CREEP = 1e-3 / 60.0
"""m/s: a millimetre a minute is what "at rest" may mean."""
CREEP_REASON = "a millimetre a minute; rest is not slow motion"
CRATE = (1.0, 1.0, 0.5)
AZIMUTHS_DEG = (0.0, 22.5, 45.0)
"""Directions downhill, seen from the crate: a cone that is not round shows in them."""


def on_slope(tan: float, azimuth_deg: float = 0.0) -> Vector:
    """Gravity as a crate on level ground feels it when the world is tilted instead of the ground."""
    angle, azimuth = math.atan(tan), math.radians(azimuth_deg)
    along = G * math.sin(angle)
    return (along * math.cos(azimuth), along * math.sin(azimuth), -G * math.cos(angle))


def downhill(track: Track, gravity: Vector) -> float:
    """How far body 1 has gone in the direction of gravity on the ground, m."""
    way = np.array(gravity[:2]) / math.hypot(*gravity[:2])
    return float(track.moved()[:2] @ way)


def crate(**given: object) -> BenchBody:
    """On the ground."""
    return BenchBody(Box(CRATE), (0.0, 0.0, 0.5 * CRATE[2]), **given)  # type: ignore[arg-type]  # passed on


class Slope(Trial):
    """A crate on a slope that falls away in three directions, for coefficients and a slope to be named."""

    STATIC: ClassVar[float]
    DYNAMIC: ClassVar[float]
    TAN: ClassVar[float]

    def scenes(self) -> list[BenchScene]:
        """Gravity leans in three directions."""
        return [
            BenchScene(
                "slope", (ground(), crate()), friction=self.STATIC, dynamic_friction=self.DYNAMIC, gravity=gravity
            )
            for gravity in (on_slope(self.TAN, azimuth) for azimuth in AZIMUTHS_DEG)
        ]


class Holds(Slope):
    """What holds does not creep."""

    formula = "v = 0 while tan(theta) < mu_s"
    unit = "mm/s"
    relative = False
    tolerance = 1e3 * CREEP
    tolerance_reason = CREEP_REASON
    seconds = 5.0

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Mean speed from the first second on."""
        return Reading(0.0, tuple(1e3 * track.creep(1.0) for track in tracks))


class Slides(Slope):
    """What slides goes at once."""

    formula = "d = g (sin(theta) - mu_d cos(theta)) t^2 / 2"
    unit = "m"

    def read(self, tracks: Sequence[Track]) -> Reading:
        """How far downhill."""
        angle = math.atan(self.TAN)
        a = G * (math.sin(angle) - self.DYNAMIC * math.cos(angle))
        t = (len(tracks[0].positions) - 1) * tracks[0].dt
        gravities = [on_slope(self.TAN, azimuth) for azimuth in AZIMUTHS_DEG]
        return Reading(0.5 * a * t * t, tuple(downhill(*pair) for pair in zip(tracks, gravities, strict=True)))


class HoldsBelow(Holds):
    """0.2 % below the angle of friction."""

    name = "hold-below-limit"
    title = "a crate on a slope of tan 0.499 stands still where mu is 0.5"
    STATIC = DYNAMIC = 0.5
    TAN = 0.499


class SlidesAbove(Slides):
    """0.2 % above it: the difference of two large forces."""

    name = "slide-above-limit"
    title = "on a slope of tan 0.501 it slides, slowly, from the start"
    seconds = 5.0
    STATIC = DYNAMIC = 0.5
    TAN = 0.501


class HoldsOnStatic(Holds):
    """Held by mu_s, which is half as much again as mu_d."""

    name = "static-holds"
    title = "with mu_s = 0.6 and mu_d = 0.4 a crate stands still at tan 0.599"
    source = LAWS + " with two coefficients"
    STATIC, DYNAMIC = 0.6, 0.4
    TAN = 0.599


class SlidesOnDynamic(Slides):
    """Once it goes, mu_d counts."""

    name = "dynamic-slides"
    title = "with mu_s = 0.6 and mu_d = 0.4 it goes at tan 0.601, and at once with mu_d"
    source = LAWS + " with two coefficients"
    STATIC, DYNAMIC = 0.6, 0.4
    TAN = 0.601


class StoppingDistance(Trial):
    """Friction must be the same in all directions."""

    name = "stopping-distance"
    title = "a plank at 5 m/s stops after the same distance in twelve directions"
    formula = "d = v^2 / (2 mu g)"
    unit = "m"
    seconds = 2.2
    MU: ClassVar = 0.3
    SPEED: ClassVar = 5.0
    PLANK: ClassVar[Vector] = (2.0, 0.4, 0.2)
    COURSES: ClassVar = tuple((30.0 * k, 0.0) for k in range(12))
    """Directions and yaws, degrees."""

    def scenes(self) -> list[BenchScene]:
        """One plank each."""
        made = []
        for course, yaw in self.COURSES:
            angle = math.radians(course)
            plank = BenchBody(
                Box(self.PLANK),
                (0.0, 0.0, 0.5 * self.PLANK[2]),
                quaternion(rotations.about((0.0, 0.0, 1.0), math.radians(yaw))),
                velocity=(self.SPEED * math.cos(angle), self.SPEED * math.sin(angle), 0.0),
            )
            made.append(BenchScene("plank", (ground(), plank), friction=self.MU))
        return made

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Lengths of the ways."""
        d = self.SPEED**2 / (2.0 * self.MU * G)
        return Reading(d, tuple(float(np.linalg.norm(track.moved()[:2])) for track in tracks))


class PathAngle(StoppingDistance):
    """Friction points against the velocity, however hard the body turns one way and easily another."""

    name = "path-angle"
    title = "a plank that slides askew stays on the straight line"
    formula = "path parallel to v0"
    unit = "deg"
    relative = False
    tolerance = 0.1
    tolerance_reason = "a tenth of a degree: 7 mm on the way of 4.2 m"
    COURSES = tuple((course, yaw) for course in (30.0, 45.0) for yaw in (0.0, 10.0, 22.5, 60.0, 75.0))

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Angles between path and initial velocity."""
        found = []
        for (course, _), track in zip(self.COURSES, tracks, strict=True):
            x, y, _ = track.moved()
            off = math.degrees(math.atan2(y, x)) - course
            found.append((off + 180.0) % 360.0 - 180.0)
        return Reading(0.0, tuple(found))


class PushHeld(Trial):
    """Static friction answers a push with as much, and not with a creep."""

    name = "push-held"
    title = "a crate with mu_s = 0.9, mu_d = 0.3 that stood for half a second is pushed with 95 % of mu_s N and stays"
    formula = "v = 0 while F < mu_s m g"
    source = LAWS + " with two coefficients"
    unit = "mm/s"
    relative = False
    tolerance = 1e3 * CREEP
    tolerance_reason = CREEP_REASON
    seconds = 3.0
    SHARE: ClassVar = 0.95
    BEGIN: ClassVar = 0.5
    END: ClassVar = math.inf
    STATIC: ClassVar = 0.9
    DYNAMIC: ClassVar = 0.3
    MASS: ClassVar = 20.0
    SIZE: ClassVar[Vector] = (0.8, 0.6, 0.2)

    def scenes(self) -> list[BenchScene]:
        """Along and askew."""
        made = []
        for degrees in (0.0, 30.0):
            angle = math.radians(degrees)
            size = self.SHARE * self.STATIC * self.MASS * G
            pushing = size * np.array([[0.0, 0.0, 0.0], [math.cos(angle), math.sin(angle), 0.0]])

            def force(time: float, positions: Array, velocities: Array, pushing: Array = pushing) -> Array:
                return pushing if self.BEGIN < time + 1e-6 < self.END else np.zeros((2, 3))

            box = BenchBody(
                Box(self.SIZE), (0.0, 0.0, 0.5 * self.SIZE[2]), density=self.MASS / float(np.prod(self.SIZE))
            )
            made.append(
                BenchScene("push", (ground(), box), friction=self.STATIC, dynamic_friction=self.DYNAMIC, force=force)
            )
        return made

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Mean speed once it has been pushed for half a second."""
        return Reading(0.0, tuple(1e3 * track.creep(self.BEGIN + 0.5) for track in tracks))


class PushAndRelease(PushHeld):
    """The lecture's question: what happens when the push ends?"""

    name = "push-and-release"
    title = "pushed for a second with 5 % more than mu_s N it goes, and slows down with mu_d when let go"
    formula = "d = a t^2 / 2 + (a t)^2 / (2 mu_d g), a = F / m - mu_d g"
    unit = "m"
    relative = True
    tolerance = 0.01
    tolerance_reason = Trial.tolerance_reason
    seconds = 5.0
    SHARE = 1.05
    END = 1.5

    def read(self, tracks: Sequence[Track]) -> Reading:
        """All of the way."""
        a = G * (self.SHARE * self.STATIC - self.DYNAMIC)
        t = self.END - self.BEGIN
        d = 0.5 * a * t * t + (a * t) ** 2 / (2.0 * self.DYNAMIC * G)
        return Reading(d, tuple(float(np.linalg.norm(track.moved()[:2])) for track in tracks))


class CrateSpins(Trial):
    """A face brakes with the mean arm of its points; four corners would with 1.85 times as much."""

    name = "spin-down-crate"
    title = "a cube spinning on its face at 10 rad/s stops as a face under even pressure does"
    formula = "t = I w / (0.38260 a mu m g) = 1.480 s"
    source = LAWS + " under uniform pressure; 0.38260 = (sqrt 2 + ln(1 + sqrt 2)) / 6"
    unit = "s"
    seconds = 3.0
    MU: ClassVar = 0.3
    SPIN: ClassVar = 10.0
    BODY: ClassVar = BenchBody(Box((1.0, 1.0, 1.0)), (0.0, 0.0, 0.5), angular_velocity=(0.0, 0.0, 10.0))
    INERTIA: ClassVar = 1.0 / 6.0
    ARM: ClassVar = (math.sqrt(2.0) + math.log(1.0 + math.sqrt(2.0))) / 6.0

    def scenes(self) -> list[BenchScene]:
        """One."""
        return [BenchScene("spin", (ground(), self.BODY), friction=self.MU)]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """When it stops."""
        track = tracks[0]
        return Reading(
            self.SPIN * self.INERTIA / (self.MU * G * self.ARM), (stops(np.abs(track.spins[:, 1, 2]), track.dt),)
        )


class DiscSpins(CrateSpins):
    """Round, and stands on all of its face."""

    name = "spin-down-disc"
    title = "a disc spinning on its face at 10 rad/s stops as a face under even pressure does"
    formula = "t = 3 w R / (4 mu g) = 1.274 s"
    source = LAWS + " under uniform pressure"
    BODY = BenchBody(Cylinder(0.5, 0.2), (0.0, 0.0, 0.1), angular_velocity=(0.0, 0.0, 10.0))
    INERTIA = 0.125
    ARM = 1.0 / 3.0


class SquareSlidesAndSpins(Trial):
    """Spin takes friction away from sliding."""

    name = "slide-and-spin-square"
    title = "a square plate at 3 m/s goes the farther the faster it spins (5, 10, 20 rad/s)"
    formula = "m v' = -mu m g <u / |u|>, I w' = -mu m g <r x u / |u|>: 1.9146, 2.9072, 5.2400 m"
    source = (
        LAWS
        + " under uniform pressure, integrated; Farkas, Bartels, Unger, Wolf, 'Frictional coupling between sliding "
        "and spinning motion', Phys. Rev. Lett. 90 (2003)"
    )
    unit = "of the way"
    tolerance_reason = "one per cent; a plate 2 cm thick leans on its front edge, which is worth 0.2 %"
    seconds = 4.5
    SPINS: ClassVar = (5.0, 10.0, 20.0)
    WAYS: ClassVar = (1.9146, 2.9072, 5.2400)
    SHAPE: ClassVar[Box | Cylinder] = Box((1.0, 1.0, 0.02))

    def scenes(self) -> list[BenchScene]:
        """Three spins."""
        return [
            BenchScene(
                "plate",
                (
                    ground(),
                    BenchBody(
                        self.SHAPE, (0.0, 0.0, 0.01), velocity=(3.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, spin)
                    ),
                ),
                friction=0.3,
            )
            for spin in self.SPINS
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Each way as a share of what it should be."""
        ways = [float(np.linalg.norm(track.moved()[:2])) for track in tracks]
        return Reading(1.0, tuple(way / right for way, right in zip(ways, self.WAYS, strict=True)))


class DiscSlidesAndSpins(SquareSlidesAndSpins):
    """The disc of the literature."""

    name = "slide-and-spin-disc"
    title = "a disc at 3 m/s goes the farther the faster it spins (5, 10, 20 rad/s)"
    formula = "m v' = -mu m g <u / |u|>, I w' = -mu m g <r x u / |u|>: 1.8148, 2.6301, 4.6185 m"
    WAYS = (1.8148, 2.6301, 4.6185)
    SHAPE = Cylinder(0.5, 0.02)


TRIALS: tuple[type[Trial], ...] = (
    HoldsBelow,
    SlidesAbove,
    HoldsOnStatic,
    SlidesOnDynamic,
    StoppingDistance,
    PathAngle,
    PushHeld,
    PushAndRelease,
    CrateSpins,
    DiscSpins,
    SquareSlidesAndSpins,
    DiscSlidesAndSpins,
)
