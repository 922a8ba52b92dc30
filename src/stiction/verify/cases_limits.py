"""What some solvers cannot do by their nature: run and measured like everything else, listed with size and reason.

A case here is a closed form like any other, and a better solver passes it. What makes it a known limit is its
``known_limit``, which names the solver. A known limit that passes all of a sudden is reported, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

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
    speed_error,
    steps_for,
)

Points = NDArray[np.complex128]
"""Of a plane."""

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


class SlideAndSpinOnCorners(Case):
    """Spin takes friction away from sliding, for each corner brakes against its own velocity.

    A face under uniform pressure goes elsewhere: ``slide-and-spin-of-a-face``.
    """

    name = "slide-and-spin-on-corners"
    title = "a thin slab that slides and spins goes as far as its four corners allow"
    formula = "m v' = -(mu m g / 4) sum u_i / |u_i|,  I w' = -(mu m g / 4) sum r_i x u_i / |u_i|"
    source = LAWS + " at four equally loaded points, integrated here (Runge-Kutta, fourth order)"
    tolerance = "0.5 %"
    tolerance_reason = (
        "friction of a step points against the corner's velocity at its end, which takes a little too much; solvers "
        "that share the load evenly are within 0.4 %"
    )
    solvers = ("micro",)
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

        return slide_until_stop(
            rate, np.array([0.0, 0.0, 0.0, self.SPEED, 0.0, spin]), inertia, 2.0 * self.DYNAMIC * G * h, h
        )


class SlideAndSpinOfAFace(Case):
    """Spin takes friction away from sliding, for each point of a face brakes against its own velocity."""

    name = "slide-and-spin-of-a-face"
    title = "a thin plate that slides and spins goes as far as a face under uniform pressure does"
    formula = "m v' = -mu m g <u / |u|>,  I w' = -mu m g <r x u / |u|>, means over the face"
    source = LAWS + " under uniform pressure, integrated here (Runge-Kutta, fourth order)"
    tolerance = "0.1 % (square), 0.3 % (disc), 0.3 % (5:1), relative"
    tolerance_reason = (
        "friction of a patch is one element whose limit surface is fitted to the exact one "
        "(docs/design/limit-surface.md), and to these distances among other things: three of a disc and of rectangles "
        "depend on two and five coefficients"
    )
    solvers = ("soft", "exact")
    SPEED: ClassVar = 3.0
    DYNAMIC: ClassVar = 0.3
    SPINS: ClassVar = (5.0, 10.0, 20.0)
    THICKNESS: ClassVar = 0.002
    GRID: ClassVar = 32

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A square, a disc and an oblong plate at three spins, one world."""
        flat = self.THICKNESS
        plates = (
            ("square", st.Box((1.0, 1.0, flat)), self._rectangle(1.0, 1.0), 1.0 / 6.0, 0.001),
            ("disc", st.Cylinder(0.5, flat), self._disc(0.5), 0.125, 0.003),
            ("plate of 5:1", st.Box((2.0, 0.4, flat)), self._rectangle(2.0, 0.4), 4.16 / 12.0, 0.003),
        )
        world = make_world(solver, dt, static=self.DYNAMIC)
        world.add(st.Plane(), static=True)
        bodies = {}
        for i, (name, shape, *_) in enumerate(plates):
            for k, w in enumerate(self.SPINS):
                bodies[name, w] = world.add(
                    shape,
                    position=(20.0 * i, 20.0 * k, 0.5 * flat),
                    velocity=(self.SPEED, 0, 0),
                    angular_velocity=(0, 0, w),
                )
        starts = world.positions.copy()
        world.step(steps_for(5.0, dt))
        for name, _, points, inertia, slack in plates:
            for w in self.SPINS:
                d = self._reference(points, w, inertia)
                body = bodies[name, w]
                path = float(np.linalg.norm((body.position - starts[body.index])[:2]))
                yield Measurement(f"distance of a {name} at {w:g} rad/s", d, path, slack, "m", "relative")

    def _rectangle(self, a: float, b: float) -> Points:
        """Mid-points of a grid of equal parts, as complex numbers, (n,)."""
        grid = (np.arange(self.GRID) + 0.5) / self.GRID - 0.5
        x, y = np.meshgrid(a * grid, b * grid)
        return (x + 1j * y).ravel()

    def _disc(self, radius: float) -> Points:
        """The same of a disc, in rings of equal area."""
        ring, spoke = (np.arange(self.GRID) + 0.5) / self.GRID, np.arange(self.GRID) / self.GRID
        r, angle = np.meshgrid(radius * np.sqrt(ring), 2.0 * np.pi * spoke)
        points: Points = r * np.exp(1j * angle)
        return points.ravel()

    def _reference(self, points: Points, spin: float, inertia: float, h: float = 4e-3) -> float:
        """Length of the way of the plate's centre, m; ``inertia`` is I / m."""

        def rate(s: Array) -> Array:
            _, _, a, vx, vy, w = s
            r = points * complex(math.cos(a), math.sin(a))
            u = complex(vx, vy) + 1j * w * r
            direction = u / np.maximum(np.abs(u), 1e-9)
            force = -self.DYNAMIC * G * complex(np.mean(direction))
            torque = -self.DYNAMIC * G * float(np.mean((np.conj(r) * direction).imag))
            return np.array([vx, vy, w, force.real, force.imag, torque / inertia])

        return slide_until_stop(
            rate, np.array([0.0, 0.0, 0.0, self.SPEED, 0.0, spin]), inertia, 2.0 * self.DYNAMIC * G * h, h
        )


def slide_until_stop(rate: Callable[[Array], Array], s: Array, inertia: float, slow: float, h: float) -> float:
    """Distance from the origin at which a state (x, y, angle, v_x, v_y, w) has come down to the speed ``slow``, m.

    Its spin counts, as sqrt(I / m) w: near the end of a slide a body may turn and hardly move, and yet go on moving.
    """
    while np.hypot(s[3], s[4]) + math.sqrt(inertia) * abs(s[5]) > slow:
        k1 = rate(s)
        k2 = rate(s + 0.5 * h * k1)
        k3 = rate(s + 0.5 * h * k2)
        k4 = rate(s + h * k3)
        s = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return float(np.hypot(s[0], s[1]))


class SpinDownOfAFace(Case):
    """Corners brake with their full arm; the points of a face have, on average, little more than half of it."""

    name = "spin-down-of-a-face"
    title = "a body spinning on its face stops as a face does, not as four corners do"
    formula = "t = I w / T, T = mu_d m g <r>, <r> the mean arm: 0.38260 a (square), 2/3 r (disc)"
    source = LAWS + " under uniform pressure; the integral of the arm over the face"
    tolerance = "2e-4, relative, and e I / (T r) with e = eps sqrt(t / dt) + u r w t / h and r the longest arm"
    tolerance_reason = (
        "the mean arm of an element of friction is a fit by the patch's second moments, within 2e-4; and single "
        "precision (u = 2^-24) rounds the spin in each substep, the same way"
    )
    known_limit: ClassVar = {
        "micro": (
            "it has the four corners of a face as contact points, as the lecture does, and so 1.85 times the moment:"
            " 'spin-down-on-corners' is what it can be compared with"
        ),
    }
    SPIN: ClassVar = 10.0
    MU: ClassVar = 0.3

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A cube of 1 m, a disc and an oblong plate, at 10 rad/s, mu_d = 0.3."""
        bodies = (
            ("cube of 1 m", st.Box((1, 1, 1)), 0.5, 1.0 / 6.0, mean_arm(1.0, 1.0), math.sqrt(0.5)),
            ("disc of 1 m", st.Cylinder(0.5, 0.2), 0.1, 0.125, 1.0 / 3.0, 0.5),
            (
                "plate of 2 m x 0.4 m",
                st.Box((2.0, 0.4, 0.1)),
                0.05,
                4.16 / 12.0,
                mean_arm(2.0, 0.4),
                math.hypot(1.0, 0.2),
            ),
        )
        w = self.SPIN
        for name, shape, z, inertia, arm, longest in bodies:
            world = make_world(solver, dt, static=self.MU)
            world.add(st.Plane(), static=True)
            body = world.add(shape, position=(0, 0, z), angular_velocity=(0, 0, w))
            brake = self.MU * G * arm / inertia
            stop = w / brake
            spins = [w]
            for _ in range(steps_for(1.3 * stop, dt)):
                world.step()
                spins.append(float(body.angular_velocity[2]))
            slack = 2e-4 * stop + speed_error(solver, stop, dt, w * longest) / (longest * brake)
            yield Measurement(f"time to stop, {name}", stop, arrival(spins, dt), slack, "s")


def mean_arm(a: float, b: float) -> float:
    """Mean distance of the points of a rectangle from its centre, m."""
    d = math.hypot(a, b)
    return d / 6.0 + a * a / (12.0 * b) * math.asinh(b / a) + b * b / (12.0 * a) * math.asinh(a / b)


class TowerOfTen(Case):
    """Nothing acts on it but its weight."""

    name = "tower-of-ten"
    title = "a tower of ten cubes stands still for ten seconds"
    formula = "v = 0"
    source = "statics"
    tolerance = "2 eps (speed), 2 eps t (drift), 1.2e-5 m (sinking)"
    tolerance_reason = "a solver that has converged leaves its tolerance, and penetrations of 1e-6 m a contact"
    other_tolerance: ClassVar = {
        "soft": (
            "1 mm/s (speed), 1 mm (drift), 10 mm (sinking)",
            "targets: contacts of 'soft' are springs, and ten of them give way by 9.3 mm at dt = 1/60 s "
            "('sink-of-soft-contacts'), which must not become a motion",
        ),
    }
    known_limit: ClassVar = {
        "micro": (
            "an impulse travels up a tower one contact at a time, forty contacts need more than 100 visits each, and"
            " nothing is remembered from step to step: the tower jitters"
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cubes of 1 m."""
        eps = solver_tolerance(solver)
        still, near, low = {"micro": (2.0 * eps, 20.0 * eps, 1.2e-5)}.get(solver, (1e-3, 1e-3, 0.01))
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        cubes = [world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5)) for k in range(10)]
        starts = world.positions.copy()
        world.step(steps_for(9.0, dt))
        fastest = 0.0
        for _ in range(steps_for(1.0, dt)):
            world.step()
            fastest = max(fastest, float(np.max(np.linalg.norm(world.velocities, axis=1))))
        drift = np.linalg.norm((world.positions - starts)[1:, :2], axis=1)
        yield Measurement("fastest cube in the tenth second", 0.0, fastest, still, "m/s")
        yield Measurement("farthest drift sideways after 10 s", 0.0, float(np.max(drift)), near, "m")
        sunk = float(starts[cubes[-1].index][2] - cubes[-1].position[2])
        # micro: the slop of ten contacts, 1e-6 m each, may be used up
        yield Measurement("how far the top has sunk", 0.0, sunk, low, "m")


class HeavyOnLight(Case):
    """A ton on a tea chest."""

    name = "heavy-on-light"
    title = "a block stands still on one of a hundredth of its mass"
    formula = "v = 0"
    source = "statics"
    tolerance = "2 eps (speed), 2e-6 m (sinking)"
    tolerance_reason = "a solver that has converged leaves its tolerance, and penetrations of 1e-6 m a contact"
    other_tolerance: ClassVar = {
        "soft": (
            "1 mm/s (speed), 20 mm (sinking)",
            "targets: contacts of 'soft' are springs, which give way by 3.2 mm here at dt = 1/60 s "
            "('sink-of-soft-contacts'), which must not become a motion",
        ),
    }
    known_limit: ClassVar = {
        "micro": (
            "the light block must pass on a hundred times its own weight, and each visit to a contact passes on a "
            "share of about 1 / 100: it takes more visits than a step has (with iterations=10000 it stands still)"
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cubes of 1 m, 10 kg and 1000 kg, for 5 s."""
        still, low = {"micro": (2.0 * solver_tolerance(solver), 2e-6)}.get(solver, (1e-3, 0.02))
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        world.add(st.Box((1, 1, 1)), mass=10.0, position=(0, 0, 0.5))
        heavy = world.add(st.Box((1, 1, 1)), mass=1000.0, position=(0, 0, 1.5))
        world.step(steps_for(4.0, dt))
        fastest = 0.0
        for _ in range(steps_for(1.0, dt)):
            world.step()
            fastest = max(fastest, float(np.max(np.linalg.norm(world.velocities, axis=1))))
        yield Measurement("fastest block in the fifth second", 0.0, fastest, still, "m/s")
        yield Measurement("how far the heavy one has sunk", 0.0, 1.5 - float(heavy.position[2]), low, "m")
