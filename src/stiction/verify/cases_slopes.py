"""Blocks on slopes: the threshold angle, sliding down, sliding across, two coefficients, tipping, a ladder."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    GRAVITY,
    G,
    Slope,
    about,
    begin_error,
    delay,
    distance_error,
    make_world,
    rounding,
    slip_speed,
    speed_error,
    steps_for,
    substep,
    turned_by,
)

LAWS = "Newton's second law and Coulomb's law"
TENTH = 0.1
"""Step of the angles in a search for a threshold, degrees."""


def largest_that_holds(moves: Callable[[float], bool], threshold_deg: float) -> tuple[float, float]:
    """Search an angle in steps of 0.1 degrees from both sides of where a threshold should be.

    Args:
        moves: whether something gives way at an angle (degrees).
        threshold_deg: where the formula puts it; the search starts 0.5 degrees away from it on either side.

    Returns:
        The largest angle that holds when coming from below, and the smallest that gives way when coming from above,
        in degrees; NaN where the side on which the search starts is already wrong.
    """
    nearest = math.floor(threshold_deg / TENTH)
    holds, gives = math.nan, math.nan
    for k in range(nearest - 5, nearest + 7):
        if moves(TENTH * k):
            break
        holds = TENTH * k
    for k in range(nearest + 6, nearest - 6, -1):
        if not moves(TENTH * k):
            break
        gives = TENTH * k
    return holds, gives


def threshold_rows(what: str, moves: Callable[[float], bool], threshold_deg: float) -> Iterator[Measurement]:
    """Two rows: the multiples of 0.1 degrees next to the threshold, as the formula and as the search have them."""
    below = math.floor(threshold_deg / TENTH) * TENTH
    holds, gives = largest_that_holds(moves, threshold_deg)
    yield Measurement(f"{what}: largest angle that holds, from below", below, holds, 0.5 * TENTH, "deg")
    yield Measurement(f"{what}: smallest angle that gives way, from above", below + TENTH, gives, 0.5 * TENTH, "deg")


class ThresholdAngle(Case):
    """Slopes in steps of 0.1 degrees, each towards another side and with another yaw of the crate."""

    name = "threshold-angle"
    title = "a crate holds below and slides above the angle of friction, from both sides in steps of 0.1 degrees"
    formula = "tan(theta) = mu_s"
    source = LAWS + "; the lecture's slide 'Static friction - Part 2'"
    tolerance = "0.05 deg: the neighbours of the threshold among the multiples of 0.1 deg, exactly"
    tolerance_reason = (
        "a crate counts as sliding when after 2 s it is faster than a quarter of what the formula gives it at the "
        "first multiple above the threshold, whatever dt is; below the threshold it may creep, which "
        "'creep-below-threshold' measures"
    )
    STATIC: ClassVar = (0.15, 0.5, 0.8, 1.1)
    SECONDS: ClassVar = 2.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Two rows a coefficient."""
        for k, mu in enumerate(self.STATIC):
            threshold = math.degrees(math.atan(mu))
            above = math.radians((math.floor(threshold / TENTH) + 1) * TENTH)
            limit = 0.25 * G * (math.sin(above) - mu * math.cos(above)) * self.SECONDS

            def slides(degrees: float, mu: float = mu, k: int = k, limit: float = limit) -> bool:
                world = make_world(solver, dt, static=mu)
                slope = Slope(math.radians(degrees), azimuth=0.7 + 2.0 * k)
                slope.add_to(world)
                crate = slope.add_box(world, (1.0, 0.8, 0.3), yaw=0.4 * k)
                world.run(self.SECONDS)
                return float(crate.velocity @ slope.down) > limit

            yield from threshold_rows(f"mu_s = {mu:g}", slides, threshold)


class InclineSliding(Case):
    """Four crates that differ in where downhill is and how they are turned."""

    name = "incline-sliding"
    title = "a crate slides down a steep slope with constant acceleration, straight, whatever its yaw"
    formula = "a = g (sin(theta) - mu_d cos(theta)), d = a t^2 / 2, v = a t"
    source = LAWS
    tolerance = "eps t sqrt(t / dt) (distance), eps sqrt(t / dt) (speed)"
    tolerance_reason = "constant forces are integrated exactly, which leaves the solver's tolerance"
    other_tolerance: ClassVar = {
        "soft": (
            "e t + a h dt / 2 (distance), e = eps sqrt(t / dt) + u v t / h (speed)",
            "single precision rounds the speed in each substep, the same way; and in the step in which a crate begins "
            "to slide it moves with new velocities instead of the mean",
        ),
    }
    ANGLE_DEG: ClassVar = 35.0
    SECONDS: ClassVar = 2.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Distance, speed and deviation from the line of fall."""
        mu_s, mu_d = 0.5, 0.4
        angle = math.radians(self.ANGLE_DEG)
        far, fast, aside = [], [], []
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        for k in range(4):
            world = make_world(solver, dt, static=mu_s, dynamic=mu_d)
            slope = Slope(angle, azimuth=0.3 + 1.7 * k)
            slope.add_to(world)
            crate = slope.add_box(world, (1.0, 0.6, 0.4), yaw=math.radians(20.0 * k))
            start = crate.position
            world.step(steps)
            path = crate.position - start
            far.append(float(path @ slope.down))
            fast.append(float(crate.velocity @ slope.down))
            aside.append(abs(float(path @ slope.across)))
        a = G * (math.sin(angle) - mu_d * math.cos(angle))
        d = 0.5 * a * t * t
        slack = distance_error(solver, t, dt, a * t) + begin_error(solver, a, dt)
        yield Measurement("distance, worst of 4", d, max(far, key=lambda x: abs(x - d)), slack, "m")
        worst = max(fast, key=lambda x: abs(x - a * t))
        yield Measurement("speed, worst of 4", a * t, worst, speed_error(solver, t, dt, a * t), "m/s")
        yield Measurement("distance off the line of fall, worst of 4", 0.0, max(aside), slack, "m")


class InclineSideways(Case):
    """Friction acts along the velocity alone, so a push across the slope takes away the grip that held the body up."""

    name = "incline-sideways"
    title = "pushed across a slope on which it would just keep its speed, a body bends downhill and loses half of it"
    formula = "|v| + v_down = v0 while mu_d = tan(theta), so v -> v0 / 2"
    source = LAWS + "; Irodov, 'Problems in General Physics', part 1 (disc on an incline with k = tan(alpha))"
    tolerance = "g sin(theta) dt / 2 (on the way), half of that (at the end)"
    tolerance_reason = (
        "friction of a step points against the velocity at its end, which takes (g sin(theta) sin(phi) dt)^2 / (2 "
        "|v|) too much at the angle phi from downhill; summed up from phi = 90 deg to 0 that is g sin(theta) dt / 2"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "g sin(theta) h / 2 + 2 e (on the way), half of that (at the end), e = eps sqrt(t / dt) + u v t / h",
            "as in micro, but in substeps; and single precision rounds the velocity in each of them, the same way",
        ),
    }
    SPEED: ClassVar = 2.0
    TAN: ClassVar = 0.4

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A flat block for 4 s, in which it bends all the way downhill."""
        world = make_world(solver, dt, static=self.TAN)
        slope = Slope(math.atan(self.TAN), azimuth=0.5)
        slope.add_to(world)
        block = slope.add_box(world, (0.5, 0.5, 0.1), yaw=0.3)
        block.velocity = self.SPEED * slope.across
        invariant = []
        for _ in range(steps_for(4.0, dt)):
            world.step()
            v = block.velocity
            invariant.append(float(np.linalg.norm(v) + v @ slope.down))
        slack = 0.5 * G * math.sin(slope.angle) * substep(solver, dt) + 2.0 * rounding(solver, self.SPEED, 4.0, dt)
        worst = max(invariant, key=lambda x: abs(x - self.SPEED))
        yield Measurement("|v| + v_down on the way, worst of 4 s", self.SPEED, worst, slack, "m/s")
        yield Measurement(
            "speed at the end", 0.5 * self.SPEED, float(np.linalg.norm(block.velocity)), 0.5 * slack, "m/s"
        )


class TwoCoefficients(Case):
    """Deciding for mu_d corner by corner lets a crate go at tan 0.55 though mu_s is 0.6."""

    name = "two-coefficients"
    title = "a crate with two coefficients holds up to mu_s and, once it goes, goes with mu_d"
    formula = "holds while tan(theta) < mu_s; then d = g (sin(theta) - mu_d cos(theta)) t^2 / 2"
    source = LAWS + " with two coefficients; the lecture's slides 'Static friction' and 'Dynamic friction'"
    tolerance = "20 eps t (held), eps t sqrt(t / dt) (sliding)"
    tolerance_reason = (
        "a crate that holds may creep with the solver's tolerance; constant forces are integrated exactly"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "20 eps t (held), 4 h a t + a h dt / 2 + t (eps sqrt(t / dt) + u v t / h) (sliding)",
            "a crate that is beyond the limit by less than an eighth lets go when that has been seen in three substeps "
            "running, which is up to 4 h late; otherwise as for 'incline-sliding'",
        ),
    }
    STATIC: ClassVar = 0.6
    DYNAMIC: ClassVar = 0.4
    SECONDS: ClassVar = 2.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Two slopes below mu_s, two above."""
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        for tan in (0.5, 0.55, 0.59, 0.62, 0.65):
            world = make_world(solver, dt, static=self.STATIC, dynamic=self.DYNAMIC)
            slope = Slope(math.atan(tan), azimuth=1.0)
            slope.add_to(world)
            crate = slope.add_box(world, (1.0, 1.0, 0.5), yaw=0.2)
            start = crate.position
            world.step(steps)
            d = float((crate.position - start) @ slope.down)
            if tan < self.STATIC:
                yield Measurement(
                    f"distance at tan(theta) = {tan:g}", 0.0, d, 20 * speed_error(solver, dt, dt) * t, "m"
                )
            else:
                a = G * (math.sin(slope.angle) - self.DYNAMIC * math.cos(slope.angle))
                slack = distance_error(solver, t, dt, a * t) + begin_error(solver, a, dt) + delay(solver, dt) * a * t
                yield Measurement(f"distance at tan(theta) = {tan:g}", 0.5 * a * t * t, d, slack, "m")


class BreakAway(Case):
    """Above mu_s there is nothing to wait for."""

    name = "break-away"
    title = "a crate just above the angle of static friction goes at once, with mu_d"
    formula = "d = g (sin(theta) - mu_d cos(theta)) t^2 / 2 from t = 0 if tan(theta) > mu_s"
    source = LAWS + " with two coefficients"
    tolerance = "2 (dt + s / (g (sin(theta) - mu_s cos(theta)))) / t, relative"
    tolerance_reason = (
        "a crate may let go in the second step instead of the first, and a solver takes a slip below s (m/s) for none; "
        "a delay costs its share of the way at the final speed 2 d / t"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "8 h / t, relative",
            "it lets go when three substeps running have seen it beyond the limit, up to 4 h late; a delay costs its "
            "share of the way at the final speed 2 d / t",
        ),
    }
    SECONDS: ClassVar = 4.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """tan(theta) = 0.601 where mu_s = 0.6 and mu_d = 0.4."""
        world = make_world(solver, dt, static=0.6, dynamic=0.4)
        slope = Slope(math.atan(0.601))
        slope.add_to(world)
        crate = slope.add_box(world, (1.0, 1.0, 0.5))
        start = crate.position
        steps = steps_for(self.SECONDS, dt)
        world.step(steps)
        t = steps * dt
        d = 0.5 * G * (math.sin(slope.angle) - 0.4 * math.cos(slope.angle)) * t * t
        gone = float((crate.position - start) @ slope.down)
        excess = G * (math.sin(slope.angle) - 0.6 * math.cos(slope.angle))
        late = dt + slip_speed() / excess if solver == "micro" else delay(solver, dt)
        yield Measurement("distance at tan(theta) = 0.601", d, gone, 2.0 * late / t, "m", "relative")


class TipOrSlide(Case):
    """Width b, height h. On a slope the line of weight leaves the base at b / h, whatever the coefficient is."""

    name = "tip-or-slide"
    title = "a tall box on a slope tips at tan = b / h if it grips, and slides first if it does not"
    formula = "tips iff tan(theta) > b / h (if mu_s > b / h); slides first if mu_s < b / h"
    source = "balance of moments about the lower edge, and Coulomb's law"
    tolerance = "0.05 deg: the neighbours of the threshold among the multiples of 0.1 deg, exactly; 1e-3 rad (tilt)"
    tolerance_reason = (
        "tipping from rest grows like a cosh, so after 2 s a box beyond the threshold has tipped by many degrees; "
        "below it the tilt stays at the penetration that the solver leaves"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "0.05 deg: as the tolerance of micro; 1e-3 rad (tilt); a h dt / 2 + t (eps sqrt(t / dt) + u v t / h) "
            "(distance)",
            "as for micro: an edge sinks by 7/2 g / omega^2 at most, which tilts the box by 2e-4 rad and moves the "
            "threshold by 0.01 deg; distances as for 'incline-sliding'",
        ),
    }
    WIDTH: ClassVar = 0.45
    HEIGHT: ClassVar = 1.0
    SECONDS: ClassVar = 2.0

    def _run(self, solver: str, dt: float, mu: float, degrees: float) -> tuple[float, float, float]:
        """Tilt (rad), distance down the slope (m) and time (s)."""
        world = make_world(solver, dt, static=mu)
        slope = Slope(math.radians(degrees))
        slope.add_to(world)
        box = slope.add_box(world, (self.WIDTH, 0.7, self.HEIGHT))
        start, upright = box.position, box.orientation
        world.run(self.SECONDS)
        return turned_by(upright, box.orientation), float((box.position - start) @ slope.down), world.time

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """With mu_s above b / h the threshold of tipping, with mu_s below it a slide without tilt."""
        grip, slip = 0.8, 0.35

        def tips(degrees: float) -> bool:
            return self._run(solver, dt, grip, degrees)[0] > 0.02

        yield from threshold_rows(f"tipping, mu_s = {grip:g}", tips, math.degrees(math.atan(self.WIDTH / self.HEIGHT)))
        angle = math.radians(22.0)
        tilt, d, t = self._run(solver, dt, slip, 22.0)
        a = G * (math.sin(angle) - slip * math.cos(angle))
        yield Measurement(f"tilt at 22 deg, mu_s = {slip:g}", 0.0, tilt, 1e-3, "rad")
        slack = distance_error(solver, t, dt, a * t) + begin_error(solver, a, dt)
        yield Measurement(f"distance at 22 deg, mu_s = {slip:g}", 0.5 * a * t * t, d, slack, "m")


class Ladder(Case):
    """A board, not a line: its thickness w moves the centre of mass off the line between its two edges of contact."""

    name = "ladder"
    title = "a ladder against a wall holds down to the angle at which floor and wall both give way"
    formula = "tan(theta) = (1 - mu_f mu_w) / (2 mu_f + (1 + mu_f mu_w) w / L)"
    source = "balance of forces and moments with Coulomb's law at both ends; w = 0 is the textbook's ladder"
    tolerance = "0.05 deg: the neighbours of the threshold among the multiples of 0.1 deg, exactly"
    tolerance_reason = "a ladder that slips has moved by centimetres after 1 s, one that holds by micrometres"
    LENGTH: ClassVar = 4.0
    THICKNESS: ClassVar = 0.12
    PAIRS: ClassVar = ((0.4, 0.0), (0.35, 0.25))

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A smooth wall and a rough one; angles are from the horizontal, so it holds *above* the threshold."""
        length, w = self.LENGTH, self.THICKNESS
        for floor, wall in self.PAIRS:
            both = floor * wall
            threshold = math.degrees(math.atan((1.0 - both) / (2.0 * floor + (1.0 + both) * w / length)))

            def slips(lean: float, floor: float = floor, wall: float = wall) -> bool:
                return self._slips(solver, dt, floor, wall, math.radians(90.0 - lean))

            yield from threshold_rows(f"mu_f = {floor:g}, mu_w = {wall:g}, from upright", slips, 90.0 - threshold)

    def _slips(self, solver: str, dt: float, floor: float, wall: float, angle: float) -> bool:
        table = st.MaterialTable()
        table.set_pair("ladder", "floor", static=floor)
        table.set_pair("ladder", "wall", static=wall)
        world = st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)
        world.add(st.Plane(), static=True, material="floor")
        world.add(st.Plane((-1, 0, 0)), static=True, material="wall")
        # both contacts are on the under side: its lower edge on the floor, its upper edge at the wall x = 0
        length, w = self.LENGTH, self.THICKNESS
        middle = np.array([-0.5 * length * math.cos(angle), 0.0, 0.5 * length * math.sin(angle)])
        middle += 0.5 * w * np.array([-math.sin(angle), 0.0, math.cos(angle)])
        ladder = world.add(
            st.Box((length, 0.5, w)),
            position=middle,
            orientation=about((0, 1, 0), -angle),
            material="ladder",
            mass=10.0,
        )
        world.run(1.0)
        return float(np.linalg.norm(ladder.position - middle)) > 1e-3
