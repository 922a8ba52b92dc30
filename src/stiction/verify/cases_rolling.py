"""Balls: sliding into rolling, backspin, rolling down a slope, rolling and torsional resistance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    G,
    Slope,
    arrival,
    begin_error,
    delay,
    distance_error,
    make_world,
    rounding,
    speed_error,
    steps_for,
    stop_error,
)

LAWS = "Newton's second law and Coulomb's law"
K = 0.4
"""I / (m r^2) of a solid sphere."""
ROUNDED = "as for micro, and single precision (u = 2^-24) rounds velocities in each substep, the same way"


def _ball(world: st.World, radius: float, **state: object) -> st.Body:
    """A ball on the level floor at the origin."""
    world.add(st.Plane(), static=True)
    return world.add(st.Sphere(radius), position=(0, 0, radius), **state)  # type: ignore[arg-type]  # velocities by name


class SlideToRoll(Case):
    """A bowling ball: thrown without spin, friction turns it until the lowest point stands still."""

    name = "slide-to-roll"
    title = "a ball thrown without spin slides, then rolls with 5/7 of its speed, whichever way it goes"
    formula = "v = 5/7 v0, t = 2 v0 / (7 mu_d g), d = 12 v0^2 / (49 mu_d g)"
    source = LAWS + "; Coriolis, 'Theorie mathematique des effets du jeu de billard' (1835)"
    tolerance = "eps (speed), 10 eps / (mu_d g) (time), mu_d g dt^2 / 8 (distance)"
    tolerance_reason = (
        "one contact is resolved at once, so only the solver's tolerance is left; friction ceases within a step, not"
        " at its end, which moves the ball by mu_d g dt^2 / 8 at most"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "e (speed), that over mu_d g (time), mu_d g h^2 / 8 and that times t (distance); "
            "e = eps sqrt(t / dt) + u v0 t / h",
            ROUNDED,
        ),
    }
    SPEED: ClassVar = 7.0
    MU: ClassVar = 0.2
    RADIUS: ClassVar = 0.11

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Thrown 25 degrees off the x axis."""
        v0, mu, r = self.SPEED, self.MU, self.RADIUS
        direction = np.array([math.cos(0.44), math.sin(0.44), 0.0])
        world = make_world(solver, dt, static=mu)
        ball = _ball(world, r, velocity=v0 * direction)
        roll = K * v0 / ((1.0 + K) * mu * G)
        slip, x, began = [v0], [0.0], 0
        for k in range(1, steps_for(1.3 * roll, dt) + 1):
            world.step()
            lowest = ball.velocity + np.cross(ball.angular_velocity, (0.0, 0.0, -r))
            slip.append(float(np.linalg.norm(lowest)))
            x.append(float(ball.position @ direction))
            if not began and slip[-1] < 1e-3 * v0:
                began = k
        eps = speed_error(solver, dt, dt)
        short = rounding(solver, v0, roll, dt)
        v = v0 / (1.0 + K)
        yield Measurement("speed when rolling", v, float(ball.velocity @ direction), eps + short, "m/s")
        spin = float(ball.angular_velocity @ np.cross((0.0, 0.0, 1.0), direction))
        yield Measurement("surface speed r w when rolling", v, spin * r, eps + short, "m/s")
        yield Measurement("time until it rolls", roll, arrival(slip, dt), (10 * eps + short) / (mu * G), "s")
        # where it has begun to roll, at the end of that step; on from the exact point it goes with v
        d = v0 * roll - 0.5 * mu * G * roll * roll
        measured = x[began] - v * (began * dt - roll) if began else math.nan
        slack = stop_error(solver, mu, mu, dt) + eps + short * roll
        yield Measurement("distance until it rolls", d, measured, slack, "m")


class Backspin(Case):
    """Spin above 5/2 v0 / r outlives the slide forwards, so the ball comes back."""

    name = "backspin"
    title = "a ball with backspin: slower, stopped dead, or back to where it came from"
    formula = "v = (5 v0 - 2 r w0) / 7, t = 2 (v0 + r w0) / (7 mu_d g)"
    source = LAWS + "; Coriolis, 'Theorie mathematique des effets du jeu de billard' (1835)"
    tolerance = "eps (speed), 10 eps / (mu_d g) (time)"
    tolerance_reason = "one contact is resolved at once, so only the solver's tolerance is left"
    other_tolerance: ClassVar = {
        "soft": (
            "e (speed), that over mu_d g (time); e = eps sqrt(t / dt) + u V t / h, V = v0 + r w0",
            ROUNDED,
        ),
    }
    SPEED: ClassVar = 2.0
    MU: ClassVar = 0.3
    RADIUS: ClassVar = 0.05
    RATIOS: ClassVar = (1.0, 2.5, 6.0)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """r w0 is 1, 5/2 and 6 times v0."""
        v0, mu, r = self.SPEED, self.MU, self.RADIUS
        for ratio in self.RATIOS:
            world = make_world(solver, dt, static=mu)
            ball = _ball(world, r, velocity=(v0, 0, 0), angular_velocity=(0, -ratio * v0 / r, 0))
            roll = K * (1.0 + ratio) * v0 / ((1.0 + K) * mu * G)
            slip = [(1.0 + ratio) * v0]
            for _ in range(steps_for(1.2 * roll, dt)):
                world.step()
                slip.append(float(ball.velocity[0] - r * ball.angular_velocity[1]))
            eps = speed_error(solver, dt, dt)
            short = rounding(solver, slip[0], roll, dt)
            v = (1.0 - K * ratio) * v0 / (1.0 + K)
            what = f"r w0 = {ratio:g} v0"
            yield Measurement(f"speed when rolling, {what}", v, float(ball.velocity[0]), eps + short, "m/s")
            yield Measurement(
                f"time until it rolls, {what}", roll, arrival(slip, dt), (10 * eps + short) / (mu * G), "s"
            )


class RollingDown(Case):
    """Rolling needs a grip of 2/7 tan(theta); with less the ball slips, and spins up with what there is."""

    name = "rolling-down"
    title = "a ball rolls down a slope without slip below tan(theta) = 7/2 mu and slips above"
    formula = (
        "a = 5/7 g sin(theta) if tan(theta) < 7/2 mu; else a = g (sin(theta) - mu cos(theta)), r w' = 5/2 mu g "
        "cos(theta)"
    )
    source = LAWS
    tolerance = "eps sqrt(t / dt) (speeds), eps t sqrt(t / dt) (distance)"
    tolerance_reason = "constant forces are integrated exactly, which leaves the solver's tolerance"
    other_tolerance: ClassVar = {
        "soft": (
            "e + 4 h |a' - a| (speeds), that times t (distance); e = eps sqrt(t / dt) + u v t / "
            "h, a' the acceleration by the other formula",
            ROUNDED + "; and just above the threshold the ball rolls for up to 4 h until it is seen to slip",
        ),
    }
    MU: ClassVar = 0.2
    RADIUS: ClassVar = 0.3
    SECONDS: ClassVar = 2.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Rolling, 0.5 % below and above the threshold, and far above it."""
        mu, r = self.MU, self.RADIUS
        limit = mu * (1.0 + K) / K
        for tan in (0.3, 0.995 * limit, 1.005 * limit, 1.2):
            world = make_world(solver, dt, static=mu)
            slope = Slope(math.atan(tan), azimuth=0.6)
            slope.add_to(world)
            ball = slope.add_sphere(world, r)
            start = ball.position
            steps = steps_for(self.SECONDS, dt)
            t = steps * dt
            world.step(steps)
            pull, grip = G * math.sin(slope.angle), mu * G * math.cos(slope.angle)
            rolls = tan < limit
            a, spin_up = (pull / (1.0 + K),) * 2 if rolls else (pull - grip, grip / K)
            how = f"tan(theta) = {tan:.4g} ({'rolls' if rolls else 'slips'})"
            eps = speed_error(solver, t, dt, max(a, spin_up) * t)
            if limit < tan < 1.05 * limit:
                rolling = pull / (1.0 + K)
                eps += delay(solver, dt) * max(abs(rolling - a), abs(rolling - spin_up))
            d = float((ball.position - start) @ slope.down)
            yield Measurement(f"distance, {how}", 0.5 * a * t * t, d, eps * t, "m")
            yield Measurement(f"speed, {how}", a * t, float(ball.velocity @ slope.down), eps, "m/s")
            spin = float(ball.angular_velocity @ np.cross(slope.normal, slope.down))
            yield Measurement(f"surface speed r w, {how}", spin_up * t, spin * r, eps, "m/s")


class SlowRoll(Case):
    """What pushes or brakes a ball by a micrometre of arm shows only where the ball is slow."""

    name = "slow-roll"
    title = "a ball that rolls at 1 mm/s goes on at 1 mm/s"
    formula = "v = v0, d = v0 t"
    source = LAWS
    tolerance = "eps sqrt(t / dt) (speed), that times t (distance)"
    tolerance_reason = "nothing acts along the floor, which leaves the solver's tolerance"
    other_tolerance: ClassVar = {
        "soft": (
            "e (speed), that times t (distance); e = eps sqrt(t / dt) + u v0 t / h",
            ROUNDED,
        ),
    }
    SPEED: ClassVar = 1e-3
    RADIUS: ClassVar = 0.25
    SECONDS: ClassVar = 5.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Five seconds, in which the ball turns by a degree."""
        v, r = self.SPEED, self.RADIUS
        world = make_world(solver, dt, static=0.5)
        ball = _ball(world, r, velocity=(v, 0, 0), angular_velocity=(0, v / r, 0))
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        world.step(steps)
        slack = speed_error(solver, t, dt, v)
        yield Measurement("speed", v, float(ball.velocity[0]), slack, "m/s")
        yield Measurement("distance", v * t, float(ball.position[0]), slack * t, "m")


class RollingResistance(Case):
    """delta is a length; a ball of radius r has the textbook's dimensionless coefficient c = delta / r."""

    name = "rolling-resistance"
    title = "a rolling ball comes to rest: how far and how long"
    formula = "d = 7/10 v^2 r / (delta g), t = 7/5 v r / (delta g)"
    source = "Newton's second law with a moment of rolling resistance of at most delta N, delta a length"
    tolerance = "a dt^2 / 8 + eps t sqrt(t / dt), with a = 5/7 g delta / r"
    tolerance_reason = "the ball stops within a step, not at its end; and the solver's tolerance enters in every step"
    other_tolerance: ClassVar = {
        "soft": (
            "a h dt / 2 + t e (distance), e / a (time); e = eps sqrt(t / dt) + u v t / h",
            ROUNDED,
        ),
    }
    SPEED: ClassVar = 1.5
    DELTA: ClassVar = 0.01
    RADIUS: ClassVar = 0.2

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The ball rolls from the start."""
        v, delta, r = self.SPEED, self.DELTA, self.RADIUS
        world = make_world(solver, dt, static=0.6, rolling=delta)
        direction = np.array([0.6, -0.8, 0.0])
        ball = _ball(world, r, velocity=v * direction, angular_velocity=np.cross((0, 0, 1), direction) * (v / r))
        a = G * delta / (r * (1.0 + K))
        stop = v / a
        speeds = [v]
        for _ in range(steps_for(1.2 * stop, dt)):
            world.step()
            speeds.append(float(np.linalg.norm(ball.velocity)))
        eps = speed_error(solver, stop, dt, v)
        d = float(ball.position @ direction)
        within_step = a * dt * dt / 8.0 if solver == "micro" else begin_error(solver, a, dt)
        yield Measurement("distance", 0.5 * v * v / a, d, within_step + eps * stop, "m")
        yield Measurement("time to stop", stop, arrival(speeds, dt), eps / a, "s")


class RollingResistanceOnSlope(Case):
    """The moment delta N holds the ball as long as the line of weight passes within delta of the contact."""

    name = "rolling-resistance-on-slope"
    title = "a ball with rolling resistance holds on a slope up to tan(theta) = delta / r and rolls beyond"
    formula = "holds iff tan(theta) <= delta / r; a = 5/7 g (sin(theta) - (delta / r) cos(theta))"
    source = "Newton's second law with a moment of rolling resistance of at most delta N, delta a length"
    tolerance = "2 eps t (held), eps t sqrt(t / dt) (rolling)"
    tolerance_reason = (
        "a ball that is held may creep with the solver's tolerance; constant forces are integrated exactly"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "2 eps t (held), t (eps sqrt(t / dt) + u v t / h) (rolling)",
            ROUNDED,
        ),
    }
    DELTA: ClassVar = 0.02
    RADIUS: ClassVar = 0.25
    SECONDS: ClassVar = 3.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """1 % below, 1 % above, and well above the threshold."""
        c = self.DELTA / self.RADIUS
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        for ratio in (0.5, 0.99, 1.01, 2.0):
            world = make_world(solver, dt, static=0.5, rolling=self.DELTA)
            slope = Slope(math.atan(ratio * c), azimuth=2.5)
            slope.add_to(world)
            ball = slope.add_sphere(world, self.RADIUS)
            start = ball.position
            world.step(steps)
            d = float((ball.position - start) @ slope.down)
            what = f"distance at tan(theta) = {ratio:g} delta / r"
            if ratio < 1.0:
                yield Measurement(what, 0.0, d, 2.0 * speed_error(solver, dt, dt) * t, "m")
            else:
                a = G * (math.sin(slope.angle) - c * math.cos(slope.angle)) / (1.0 + K)
                slack = distance_error(solver, t, dt, a * t)
                yield Measurement(what, 0.5 * a * t * t, d, slack, "m")


class TorsionalResistance(Case):
    """A ball that spins about the vertical stands on one point: only torsional resistance stops it."""

    name = "torsional-resistance"
    title = "a ball spinning on the spot is stopped by torsional resistance, and not at all without it"
    formula = "t = 2/5 r^2 w / (tau g), turned by w t / 2"
    source = "Euler's law with a moment of torsional resistance of at most tau N, tau a length"
    tolerance = "(tau g / (2/5 r^2)) dt^2 / 8 + eps t sqrt(t / dt) / r"
    tolerance_reason = "the ball stops within a step, not at its end; and the solver's tolerance enters in every step"
    other_tolerance: ClassVar = {
        "soft": (
            "(tau g / (2/5 r^2)) dt^2 / 8 + t e / r (angle), e / r over the braking (time); e = eps sqrt(t / dt) + u "
            "r w t / h",
            "the ball stops within a step; and single precision (u = 2^-24) rounds its spin in each substep, the same "
            "way",
        ),
    }
    SPIN: ClassVar = 20.0
    TAU: ClassVar = 0.004
    RADIUS: ClassVar = 0.1

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """With and without resistance."""
        w, tau, r = self.SPIN, self.TAU, self.RADIUS
        brake = tau * G / (K * r * r)
        stop = w / brake
        world = make_world(solver, dt, static=0.5, torsional=tau)
        ball = _ball(world, r, angular_velocity=(0, 0, w))
        spins, angle = [w], 0.0
        for _ in range(steps_for(1.2 * stop, dt)):
            before = ball.orientation
            world.step()
            after = ball.orientation
            # angle about the vertical from the quaternions' w and z: the ball turns about nothing else
            half = math.atan2(after[3], after[0]) - math.atan2(before[3], before[0])
            angle += 2.0 * math.remainder(half, math.pi)
            spins.append(float(ball.angular_velocity[2]))
        eps = speed_error(solver, stop, dt, w * r) / r
        yield Measurement("time to stop", stop, arrival(spins, dt), eps / brake, "s")
        yield Measurement("angle turned", 0.5 * w * stop, angle, brake * dt * dt / 8.0 + eps * stop, "rad")
        free = make_world(solver, dt, static=0.5)
        ball = _ball(free, r, angular_velocity=(0, 0, w))
        free.run(2.0)
        yield Measurement("spin after 2 s without resistance", w, float(ball.angular_velocity[2]), 1e-9 * w, "rad/s")
