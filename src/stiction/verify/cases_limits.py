"""What some solvers cannot do by their nature: run and measured like everything else, listed with size and reason.

A case here is a closed form like any other, and a better solver passes it. What makes it a known limit is its
``known_limit``, which names the solver. A known limit that passes all of a sudden is reported, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    Array,
    G,
    Slope,
    arrival,
    box_inertia,
    make_world,
    solver_tolerance,
    steps_for,
)

LAWS = "Newton's second law and Coulomb's law"


class CreepBelowThreshold(Case):
    """Static friction means rest, not slow motion."""

    name = "creep-below-threshold"
    title = "a crate on a slope at 99.8 % of the angle of friction stands still"
    formula = "v = 0 while tan(theta) < mu_s"
    source = LAWS
    tolerance = "2 eps"
    tolerance_reason = "a solver that has converged leaves its tolerance, and no more"
    known_limit: ClassVar = {
        "micro": (
            "directions are resolved to within eps as well, so that at a creep of c the corners, all of them on their "
            "cones, may pull in directions eps / c apart and hold less in sum: c is at most eps / sqrt(2 (1 - 0.998))"
        ),
    }
    STATIC: ClassVar = 0.5
    SHARE: ClassVar = 0.998

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Mean speed from the first second to the fifth, the worst of four crates."""
        speeds = []
        for k in range(4):
            world = make_world(solver, dt, static=self.STATIC)
            slope = Slope(math.atan(self.SHARE * self.STATIC), azimuth=0.8 * k)
            slope.add_to(world)
            crate = slope.add_box(world, (1.0, 1.0, 0.5), yaw=0.3 * k)
            world.run(1.0)
            start, began = crate.position, world.time
            world.run(4.0)
            speeds.append(float(np.linalg.norm(crate.position - start)) / (world.time - began))
        yield Measurement("creep, worst of 4", 0.0, max(speeds), 2.0 * solver_tolerance(solver), "m/s")


class SlideAndSpin(Case):
    """Spin takes friction away from sliding, for each corner brakes against its own velocity."""

    name = "slide-and-spin"
    title = "a thin slab that slides and spins goes as far as its four corners allow"
    formula = "m v' = -(mu m g / 4) sum u_i / |u_i|,  I w' = -(mu m g / 4) sum r_i x u_i / |u_i|"
    source = LAWS + " at four equally loaded points, integrated here (Runge-Kutta, fourth order)"
    tolerance = "0.5 %"
    tolerance_reason = (
        "friction of a step points against the corner's velocity at its end, which takes a little too much; solvers "
        "that share the load evenly are within 0.4 %"
    )
    known_limit: ClassVar = {
        "micro": (
            "the load of four corners is indeterminate, and resolving the worst contact first leaves it on two of "
            "them, not always the same two: the distance is wrong by up to 4 %"
        ),
    }
    SPEED: ClassVar = 3.0
    DYNAMIC: ClassVar = 0.3
    SPINS: ClassVar = (5.0, 7.0, 10.0, 14.0, 20.0, 28.0)
    SIZE: ClassVar = (1.0, 1.0, 0.002)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Six spins, one world."""
        world = make_world(solver, dt, static=self.DYNAMIC)
        world.add(st.Plane(), static=True)
        slabs = [
            world.add(
                st.Box(self.SIZE), position=(0, 20.0 * k, 0.5 * self.SIZE[2]),
                velocity=(self.SPEED, 0, 0), angular_velocity=(0, 0, w),
            )
            for k, w in enumerate(self.SPINS)
        ]  # fmt: skip
        world.step(steps_for(5.0, dt))
        rows = []
        for k, (slab, w) in enumerate(zip(slabs, self.SPINS, strict=True)):
            d = self._reference(w, float(box_inertia(1.0, self.SIZE)[2]))
            path = float(np.linalg.norm(slab.position[:2] - (0.0, 20.0 * k)))
            rows.append((abs(path / d - 1.0), d, path, w))
        _, d, path, w = max(rows)
        yield Measurement(f"distance, worst of 6 spins (the one of {w:g} rad/s)", d, path, 0.005, "m", "relative")

    def _reference(self, spin: float, inertia: float, h: float = 2e-3) -> float:
        """Length of the way of the slab's centre, m; ``inertia`` is I / m."""
        half = 0.5 * self.SIZE[0]
        corners = half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])

        def rate(s: Array) -> Array:
            _, _, a, vx, vy, w = s
            c, q = math.cos(a), math.sin(a)
            r = corners @ np.array([[c, q], [-q, c]])
            u = np.array([vx, vy]) + w * np.stack([-r[:, 1], r[:, 0]], axis=1)
            f = -0.25 * self.DYNAMIC * G * u / np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-9)
            torque = float(np.sum(r[:, 0] * f[:, 1] - r[:, 1] * f[:, 0]))
            return np.array([vx, vy, w, *f.sum(axis=0), torque / inertia])

        s = np.array([0.0, 0.0, 0.0, self.SPEED, 0.0, spin])
        while np.hypot(s[3], s[4]) > 2.0 * self.DYNAMIC * G * h:
            k1 = rate(s)
            k2 = rate(s + 0.5 * h * k1)
            k3 = rate(s + 0.5 * h * k2)
            k4 = rate(s + h * k3)
            s = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return float(np.hypot(s[0], s[1]))


class SpinDownOfAFace(Case):
    """Corners brake with their full arm; the points of a face have, on average, little more than half of it."""

    name = "spin-down-of-a-face"
    title = "a cube spinning on its square face stops as a face does, not as four corners do"
    formula = "t = I w / T, T = (sqrt(2) + ln(1 + sqrt(2))) / 6 mu_d m g a"
    source = LAWS + " under uniform pressure; the integral of the arm over a square of side a"
    tolerance = "1 %"
    tolerance_reason = "the accuracy that a description of the face by a few numbers can be asked for"
    known_limit: ClassVar = {
        "micro": (
            "it has the four corners of a face as contact points, as the lecture does, and so 1.85 times the moment:"
            " 'spin-down-on-corners' is what it can be compared with"
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A cube of 1 m at 10 rad/s, mu_d = 0.3."""
        side, w, mu = 1.0, 10.0, 0.3
        world = make_world(solver, dt, static=mu)
        world.add(st.Plane(), static=True)
        cube = world.add(st.Box((side, side, side)), position=(0, 0, 0.5 * side), angular_velocity=(0, 0, w))
        moment = (math.sqrt(2.0) + math.log(1.0 + math.sqrt(2.0))) / 6.0 * mu * cube.mass * G * side
        stop = float(box_inertia(cube.mass, (side, side, side))[2]) * w / moment
        spins = [w]
        for _ in range(steps_for(1.3 * stop, dt)):
            world.step()
            spins.append(float(cube.angular_velocity[2]))
        yield Measurement("time to stop", stop, arrival(spins, dt), 0.01, "s", "relative")


class TowerOfTen(Case):
    """Nothing acts on it but its weight."""

    name = "tower-of-ten"
    title = "a tower of ten cubes stands still for ten seconds"
    formula = "v = 0"
    source = "statics"
    tolerance = "2 eps (speed), 2 eps t (drift)"
    tolerance_reason = "a solver that has converged leaves its tolerance, and no more"
    known_limit: ClassVar = {
        "micro": (
            "an impulse travels up a tower one contact at a time, forty contacts need more than 100 visits each, and"
            " nothing is remembered from step to step: the tower jitters"
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cubes of 1 m."""
        eps = solver_tolerance(solver)
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        cubes = [world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5)) for k in range(10)]
        starts = world.positions.copy()
        fastest = 0.0
        for _ in range(steps_for(10.0, dt)):
            world.step()
            fastest = max(fastest, float(np.max(np.linalg.norm(world.velocities, axis=1))))
        drift = np.linalg.norm((world.positions - starts)[1:, :2], axis=1)
        yield Measurement("fastest cube, worst of 10 s", 0.0, fastest, 2.0 * eps, "m/s")
        yield Measurement("farthest drift sideways after 10 s", 0.0, float(np.max(drift)), 20.0 * eps, "m")
        sunk = float(starts[cubes[-1].index][2] - cubes[-1].position[2])
        # the slop of ten contacts, 1e-6 m each, may be used up
        yield Measurement("how far the top has sunk", 0.0, sunk, 1.2e-5, "m")


class HeavyOnLight(Case):
    """A ton on a tea chest."""

    name = "heavy-on-light"
    title = "a block stands still on one of a hundredth of its mass"
    formula = "v = 0"
    source = "statics"
    tolerance = "2 eps (speed), 2e-6 m (sinking)"
    tolerance_reason = "a solver that has converged leaves its tolerance, and penetrations of 1e-6 m a contact"
    known_limit: ClassVar = {
        "micro": (
            "the light block must pass on a hundred times its own weight, and each visit to a contact passes on a "
            "share of about 1 / 100: it takes more visits than a step has (with iterations=10000 it stands still)"
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cubes of 1 m, 10 kg and 1000 kg, for 5 s."""
        eps = solver_tolerance(solver)
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        world.add(st.Box((1, 1, 1)), mass=10.0, position=(0, 0, 0.5))
        heavy = world.add(st.Box((1, 1, 1)), mass=1000.0, position=(0, 0, 1.5))
        fastest = 0.0
        for _ in range(steps_for(5.0, dt)):
            world.step()
            fastest = max(fastest, float(np.max(np.linalg.norm(world.velocities, axis=1))))
        yield Measurement("fastest block, worst of 5 s", 0.0, fastest, 2.0 * eps, "m/s")
        yield Measurement("how far the heavy one has sunk", 0.0, 1.5 - float(heavy.position[2]), 2e-6, "m")
