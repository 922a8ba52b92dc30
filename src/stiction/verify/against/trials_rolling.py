"""Trials of rolling, of impacts, of what moves beneath, and of a spring: balls, belts, plates, throws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from stiction.bench.scene import BenchBody, BenchScene, Gliding, Vector, ground
from stiction.shapes import Box, Sphere
from stiction.verify.against.trial import LAWS, Array, G, Reading, Track, Trial
from stiction.verify.against.trials_sliding import on_slope

K = 0.4
"""I / (m r^2) of a solid sphere."""
WEIGHTLESS: Vector = (0.0, 0.0, 0.0)


def ball(radius: float = 0.2, **given: object) -> BenchBody:
    """On the ground."""
    return BenchBody(Sphere(radius), (0.0, 0.0, radius), **given)  # type: ignore[arg-type]  # passed on


def plate() -> BenchBody:
    """Ground that is driven."""
    return BenchBody(Box((100.0, 100.0, 2.0)), (0.0, 0.0, -1.0), density=None, kinematic=True)


class SlideToRoll(Trial):
    """A bowling ball."""

    name = "slide-to-roll"
    title = "a ball that is thrown sliding rolls in the end with 5/7 of its speed"
    formula = "v = 5/7 v0"
    unit = "m/s"
    SPEED: ClassVar = 7.0
    MU: ClassVar = 0.2

    def scenes(self) -> list[BenchScene]:
        """Along an axis and askew."""
        return [
            BenchScene(
                "ball",
                (ground(), ball(velocity=(self.SPEED * math.cos(a), self.SPEED * math.sin(a), 0.0))),
                friction=self.MU,
            )
            for a in (0.0, math.radians(30.0))
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed after two seconds."""
        return Reading(
            self.SPEED / (1.0 + K), tuple(float(np.linalg.norm(track.velocities[-1, 1])) for track in tracks)
        )


class SlideToRollTime(SlideToRoll):
    """Coulomb's friction ends the slide at once; a regularised one lets it fade."""

    name = "slide-to-roll-time"
    title = "and rolls after the time that Coulomb's friction takes"
    formula = "t = 2 v0 / (7 mu g)"
    unit = "s"

    def read(self, tracks: Sequence[Track]) -> Reading:
        """When slip ends, by a straight line through where it is between 90 % and 5 % of what it was."""
        found = []
        for track in tracks:
            spin = track.spins[:, 1]
            slip = track.velocities[:, 1, :2] + 0.2 * np.stack([-spin[:, 1], spin[:, 0]], axis=1)
            sizes = np.linalg.norm(slip, axis=1) / self.SPEED
            chosen = (sizes < 0.9) & (sizes > 0.05)
            times = np.arange(len(sizes)) * track.dt
            if chosen.sum() < 2:
                found.append(math.nan)
                continue
            slope, start = np.polyfit(times[chosen], sizes[chosen], 1)
            found.append(float(-start / slope))
        return Reading(2.0 * self.SPEED / (7.0 * self.MU * G), tuple(found))


class Backspin(Trial):
    """It comes back."""

    name = "backspin"
    title = "a ball with enough backspin comes back"
    formula = "v = (5 v0 - 2 r w0) / 7"
    unit = "m/s"
    seconds = 3.0

    def scenes(self) -> list[BenchScene]:
        """2 m/s, and r w = 12 m/s."""
        return [
            BenchScene(
                "ball",
                (ground(), ball(velocity=(2.0, 0.0, 0.0), angular_velocity=(0.0, -60.0, 0.0))),
                friction=0.5,
            )
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed at the end."""
        return Reading((5.0 * 2.0 - 2.0 * 12.0) / 7.0, (float(tracks[0].velocities[-1, 1, 0]),))


class RollingDown(Trial):
    """Static friction turns the ball."""

    name = "rolling-down"
    title = "a ball rolls down a slope with 5/7 of what a frictionless one would have"
    formula = "v = 5/7 g sin(theta) t if tan(theta) < 7/2 mu"
    unit = "m/s"

    def scenes(self) -> list[BenchScene]:
        """Two directions."""
        return [
            BenchScene("ball", (ground(), ball()), friction=0.3, gravity=on_slope(0.8, azimuth))
            for azimuth in (0.0, 30.0)
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed at the end."""
        t = (len(tracks[0].positions) - 1) * tracks[0].dt
        speed = G * math.sin(math.atan(0.8)) * t / (1.0 + K)
        return Reading(speed, tuple(float(np.linalg.norm(track.velocities[-1, 1])) for track in tracks))


class RollingResistance(Trial):
    """A moment of at most delta N."""

    name = "rolling-resistance"
    title = "a rolling ball stops where its rolling resistance has taken its energy"
    formula = "d = 7/10 v^2 r / (delta g)"
    source = "energy: a moment delta N over the angle d / r takes 7/10 m v^2"
    unit = "m"
    seconds = 4.0
    LENGTH: ClassVar = 0.05

    def scenes(self) -> list[BenchScene]:
        """A ball of 0.5 m that rolls from the start, delta = 5 cm."""
        rolling = ball(0.5, velocity=(2.0, 0.0, 0.0), angular_velocity=(0.0, 4.0, 0.0))
        return [BenchScene("ball", (ground(), rolling), friction=0.5, rolling=self.LENGTH)]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Its way."""
        return Reading(0.7 * 4.0 * 0.5 / (self.LENGTH * G), (float(tracks[0].moved()[0]),))


class BouncingBall(Trial):
    """Once."""

    name = "bouncing-ball"
    title = "a ball dropped from a metre bounces to e^2 of it"
    formula = "h = e^2 h0"
    source = "Newton's law of restitution"
    unit = "m"
    seconds = 0.85
    RESTITUTION: ClassVar = 0.8

    def scenes(self) -> list[BenchScene]:
        """e = 0.8."""
        dropped = BenchBody(Sphere(0.1), (0.0, 0.0, 1.1))
        return [BenchScene("ball", (ground(), dropped), friction=0.3, restitution=self.RESTITUTION)]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """The highest it gets after it was lowest, by energy, so that it does not matter when it is seen."""
        track = tracks[0]
        height, speed = track.positions[:, 1, 2] - 0.1, track.velocities[:, 1, 2]
        lowest = int(np.argmin(height[: track.at(0.6)]))
        rising = [k for k in range(lowest, len(height)) if speed[k] > 0.5]
        top = height[rising[-1]] + speed[rising[-1]] ** 2 / (2.0 * G) if rising else 0.0
        return Reading(self.RESTITUTION**2, (float(top),))


class RoughBall(Trial):
    """Friction ends the slip within the impact."""

    name = "rough-ball"
    title = "a ball that hits a rough floor askew goes on with 5/7 of its speed along it"
    formula = "v_t = 5/7 v_t0 where mu is enough"
    source = "Coulomb's law for impulses; Brach, 'Mechanical Impact Dynamics' (1991), ch. 3"
    unit = "m/s"
    seconds = 1.0

    def scenes(self) -> list[BenchScene]:
        """Weightless, at 45 degrees, without restitution."""
        made = []
        for angle in (0.0, math.radians(30.0)):
            v = (2.0 * math.cos(angle), 2.0 * math.sin(angle), -2.0)
            thrown = BenchBody(Sphere(0.2), (0.0, 0.0, 0.7), velocity=v)
            made.append(BenchScene("ball", (ground(), thrown), friction=1.0, gravity=WEIGHTLESS))
        return made

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed along the floor."""
        return Reading(2.0 / (1.0 + K), tuple(float(np.linalg.norm(t.velocities[-1, 1, :2])) for t in tracks))


class BilliardThrow(Trial):
    """Friction between the balls takes the object ball off the line of centres."""

    name = "billiard-throw"
    title = "the object ball is thrown off the line of centres (cut angles 10, 20, 45 degrees)"
    formula = "tan(throw) = min(mu, tan(phi) / 7)"
    source = "Coulomb's law for impulses; Alciatore, 'The Illustrated Principles of Pool and Billiards'"
    unit = "of the throw"
    seconds = 0.5
    MU: ClassVar = 0.06
    CUTS_DEG: ClassVar = (10.0, 20.0, 45.0)

    def scenes(self) -> list[BenchScene]:
        """Weightless, e = 1; the balls touch."""
        made = []
        for cut in (math.radians(degrees) for degrees in self.CUTS_DEG):
            # they all but touch: an engine that looks once a step sees the line of centres where the step begins
            cue = BenchBody(Sphere(0.1), (-0.20001, 0.0, 0.0), velocity=(2.0 * math.cos(cut), 2.0 * math.sin(cut), 0.0))
            hit = BenchBody(Sphere(0.1), (0.0, 0.0, 0.0))
            made.append(
                BenchScene("balls", (ground(top=-5.0), hit, cue), friction=self.MU, restitution=1.0, gravity=WEIGHTLESS)
            )
        return made

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Each as a share of what it should be."""
        found = []
        for degrees, track in zip(self.CUTS_DEG, tracks, strict=True):
            x, y, _ = track.velocities[-1, 1]
            right = min(self.MU, math.tan(math.radians(degrees)) / 7.0)
            found.append(float(y / x) / right if x > 0.0 else math.nan)
        return Reading(1.0, tuple(found))


class BeltDrop(Trial):
    """How far a parcel slips."""

    name = "belt-drop"
    title = "a parcel put on a running belt slips until it goes along"
    formula = "slip = V^2 / (2 mu g)"
    unit = "m"
    BELT: ClassVar = 2.0
    MU: ClassVar = 0.35

    def scenes(self) -> list[BenchScene]:
        """The belt is a driven plate."""
        parcel = BenchBody(Box((0.4, 0.3, 0.2)), (0.0, 0.0, 0.1))
        return [BenchScene("belt", (plate(), parcel), friction=self.MU, gliding=Gliding((self.BELT, 0.0, 0.0)))]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Way of the belt less that of the parcel."""
        slip = tracks[0].moved(0)[0] - tracks[0].moved(1)[0]
        return Reading(self.BELT**2 / (2.0 * self.MU * G), (float(slip),))


class AcceleratingPlate(Trial):
    """The ball rolls backwards on it."""

    name = "accelerating-plate"
    title = "a ball on a plate that speeds up follows with 2/7 of its acceleration"
    formula = "v = 2/7 A t while 2/7 A < mu g"
    unit = "m/s"
    seconds = 1.5
    MU: ClassVar = 0.3
    SHARE: ClassVar = 0.8

    def scenes(self) -> list[BenchScene]:
        """A ball at four fifths of the acceleration at which it would slip."""
        a = self.SHARE * self.MU * G * (1.0 + K) / K
        driven = Gliding((0.0, 0.0, 0.0), (0.6 * a, 0.8 * a, 0.0))
        return [BenchScene("plate", (plate(), ball()), friction=self.MU, gliding=driven)]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed at the end."""
        t = (len(tracks[0].positions) - 1) * tracks[0].dt
        return Reading(self.SHARE * self.MU * G * t, (float(tracks[0].velocities[-1, 1] @ (0.6, 0.8, 0.0)),))


class LorrySlips(Trial):
    """Beyond the limit friction does what it can."""

    name = "crate-on-lorry"
    title = "a crate on a lorry that accelerates with 1.5 mu g follows with mu g"
    formula = "v = mu g t"
    unit = "m/s"
    seconds = 1.5
    MU: ClassVar = 0.3

    def scenes(self) -> list[BenchScene]:
        """Along and askew."""
        a = 1.5 * self.MU * G
        box = BenchBody(Box((1.0, 0.8, 0.3)), (0.0, 0.0, 0.15))
        return [
            BenchScene(
                "lorry",
                (plate(), box),
                friction=self.MU,
                gliding=Gliding((0.0, 0.0, 0.0), (a * math.cos(course), a * math.sin(course), 0.0)),
            )
            for course in (0.0, math.radians(30.0))
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Speed at the end."""
        t = (len(tracks[0].positions) - 1) * tracks[0].dt
        return Reading(self.MU * G * t, tuple(float(np.linalg.norm(k.velocities[-1, 1, :2])) for k in tracks))


class StickSlip(Trial):
    """Why chalk squeaks."""

    name = "stick-slip"
    title = "a block on a belt, held by a spring, sticks and slips in a period that two coefficients make"
    formula = "T = 2 D / V + (2 pi - 2 atan(D w / V)) / w, D = (mu_s - mu_d) m g / k, w^2 = k / m"
    source = LAWS + " with two coefficients"
    unit = "s"
    seconds = 12.0
    STATIC: ClassVar = 0.6
    DYNAMIC: ClassVar = 0.4
    BELT: ClassVar = 0.2
    STIFFNESS: ClassVar = 20.0

    def scenes(self) -> list[BenchScene]:
        """1 kg, 20 N/m, 0.2 m/s."""

        def spring(time: float, positions: Array, velocities: Array) -> Array:
            return np.array([[0.0, 0.0, 0.0], [-self.STIFFNESS * positions[1, 0], 0.0, 0.0]])

        size = (0.4, 0.4, 0.1)
        block = BenchBody(
            Box(size), (0.0, 0.0, 0.05), velocity=(self.BELT, 0.0, 0.0), density=1.0 / float(np.prod(size))
        )
        return [
            BenchScene(
                "spring",
                (plate(), block),
                friction=self.STATIC,
                dynamic_friction=self.DYNAMIC,
                gliding=Gliding((self.BELT, 0.0, 0.0)),
                force=spring,
            )
        ]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Mean time between turning points, the first left out."""
        w, lag = math.sqrt(self.STIFFNESS), (self.STATIC - self.DYNAMIC) * G / self.STIFFNESS
        period = 2.0 * lag / self.BELT + (2.0 * math.pi - 2.0 * math.atan(lag * w / self.BELT)) / w
        v, dt = tracks[0].velocities[:, 1, 0], tracks[0].dt
        # it turns back where its speed falls through zero with a bound below, not where it trembles
        turns = [
            dt * (k + v[k] / (v[k] - v[k + 1]))
            for k in range(len(v) - 1)
            if v[k] > 0.0 >= v[k + 1] and np.min(v[k : k + 30]) < -0.05
        ]
        measured = (turns[-1] - turns[1]) / (len(turns) - 2) if len(turns) > 2 else math.nan
        return Reading(period, (float(measured),))


class RollingBenchmark(Trial):
    """The rolling test of a published benchmark of physics engines, with its push at 60 degrees."""

    name = "balls-on-a-box"
    title = "25 balls of 1 kg roll on a box of 10 kg that is pushed at 60 degrees over the floor"
    formula = "f1 = mu1 (M + n m) g, f2 = (F - f1) / (M (7/2 / m + n / M)); box a = 7/2 f2 / m, balls f2 / m"
    source = (
        "Hwangbo, Kang, Hutter, SimBenchmark (ETH Zurich, 2018), test 'rolling': mean of |v_ball - exact|^2 + |v_box - "
        "exact|^2; a box that never moves has 3.15 (m/s)^2"
    )
    unit = "m²/s²"
    relative = False
    tolerance = 3.146e-4
    tolerance_reason = "the square of one per cent, of what standing still has"
    seconds = 4.0
    PUSH: ClassVar = 150.0
    BOX: ClassVar = 10.0
    SIDE: ClassVar = 5

    def scenes(self) -> list[BenchScene]:
        """mu is 0.4 between floor and box, 0.8 between box and balls."""
        n = self.SIDE**2
        angle = math.radians(60.0)
        push = np.zeros((2 + n, 3))
        push[1] = self.PUSH * np.array([math.cos(angle), math.sin(angle), 0.0])
        size = (20.0, 20.0, 1.0)
        box = BenchBody(Box(size), (0.0, 0.0, 0.5), density=self.BOX / float(np.prod(size)), surface="box")
        floor = ground()
        floor = BenchBody(floor.shape, floor.position, density=None, surface="floor")
        density = 1.0 / (4.0 / 3.0 * math.pi * 0.5**3)
        sphere = Sphere(0.5)
        middle = 0.5 * (self.SIDE - 1)
        balls = [
            BenchBody(sphere, (2.0 * (i - middle), 2.0 * (j - middle), 1.5), density=density, surface="ball")
            for i in range(self.SIDE)
            for j in range(self.SIDE)
        ]
        pairs = (("box", "floor", 0.4), ("ball", "box", 0.8))
        return [BenchScene("balls", (floor, box, *balls), pairs=pairs, force=lambda time, positions, velocities: push)]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """Mean over the frames, and over the balls."""
        n, direction = self.SIDE**2, np.array([0.5, math.sqrt(0.75), 0.0])
        f1 = 0.4 * (self.BOX + n) * G
        f2 = (self.PUSH - f1) / self.BOX / (3.5 + n / self.BOX)
        track = tracks[0]
        times = track.dt * np.arange(1, len(track.velocities))
        off_box = track.velocities[1:, 1] - 3.5 * f2 * times[:, None] * direction
        off_balls = track.velocities[1:, 2:] - (f2 * times[:, None] * direction)[:, None, :]
        score = np.mean(np.sum(off_box**2, axis=-1)) + np.mean(np.sum(off_balls**2, axis=-1))
        return Reading(0.0, (float(score),))


TRIALS: tuple[type[Trial], ...] = (
    SlideToRoll,
    SlideToRollTime,
    Backspin,
    RollingDown,
    RollingResistance,
    BouncingBall,
    RoughBall,
    BilliardThrow,
    BeltDrop,
    AcceleratingPlate,
    LorrySlips,
    StickSlip,
    RollingBenchmark,
)
