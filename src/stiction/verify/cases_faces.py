"""Faces that slide, spin and are pushed askew; distances of braking for every row of the lecture's table."""

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
    distance_error,
    lean,
    make_world,
    sink,
    steps_for,
    stop_error,
)

LAWS = "Newton's second law and Coulomb's law"


class BrakeDistances(Case):
    """Rubber on concrete or ice on steel: one formula, nine numbers."""

    name = "brake-distances"
    title = "a block at 5 m/s stops after v^2 / (2 mu_d g) for each pair of the lecture's table"
    formula = "d = v^2 / (2 mu_d g)"
    source = LAWS + "; coefficients of the lecture's slide 'Some coefficients'"
    tolerance = "g dt^2 max(mu_d / 8, mu_s (mu_s - mu_d) / (2 mu_d)) + eps t sqrt(t / dt) + 1e-6 m mu_d"
    tolerance_reason = "as for 'stopping-distance', and the solver may leave a penetration of 1e-6 m"
    other_tolerance: ClassVar = {
        "soft": (
            "mu_d g h^2 / 8 + 7/4 (g / omega^2) (H / b + mu_d) + t (eps sqrt(t / dt) + u v t / h)",
            "as for 'stopping-distance'; and what a block sinks by while it brakes, m z'' = N - m g, takes as "
            "much times "
            "mu_d from its way, m x'' = -mu_d N, which shows where mu_d is large",
        ),
    }
    SPEED: ClassVar = 5.0
    SIZE: ClassVar = (0.4, 0.4, 0.1)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Nine pairs, a world each."""
        v = self.SPEED
        for row in st.MaterialTable.lecture().to_toml_rows():
            if "material" in row or row["a"] == row["b"] == "default":
                continue
            mu_s, mu_d = float(row["static"]), float(row["dynamic"])
            world = make_world(solver, dt, static=mu_s, dynamic=mu_d)
            world.add(st.Plane(), static=True)
            block = world.add(st.Box(self.SIZE), position=(0, 0, 0.05), velocity=(0.6 * v, 0.8 * v, 0))
            stop = v / (mu_d * G)
            world.run(1.1 * stop)
            slack = stop_error(solver, mu_s, mu_d, dt) + lean(solver, dt, self.SIZE[2], self.SIZE[0])
            slack += mu_d * sink(solver, dt, 7.0 / 4.0) + distance_error(solver, stop, dt, v)
            what = f"{row['a']} on {row['b']}, mu_d = {mu_d:g}"
            yield Measurement(what, 0.5 * v * stop, float(np.linalg.norm(block.position[:2])), slack, "m")


class DiscEndsTogether(Case):
    """Sliding and spinning brake each other in such a way that neither outlives the other."""

    name = "disc-ends-together"
    title = "a disc that slides and spins ends both at the same instant, at one ratio of its speeds"
    formula = "v / (R w) tends to 0.653; on the way as m v' = -mu m g <u / |u|>, I w' = -mu m g <r x u / |u|>"
    source = (
        LAWS
        + " under uniform pressure, integrated here; Farkas, Bartels, Unger and Wolf, 'Frictional coupling between "
        "sliding and spinning motion', Phys. Rev. Lett. 90, 248302 (2003)"
    )
    tolerance = "1 % (ratio), dt (between the ends)"
    tolerance_reason = (
        "a target: the ratio is driven by that of force and moment, which the fitted limit surface of a disc divides "
        "so that the ratio at the end is 0.2 % off; ends are seen once a step"
    )
    solvers = ("soft", "exact")
    SPEED: ClassVar = 3.0
    MU: ClassVar = 0.3
    RADIUS: ClassVar = 0.5
    SPINS: ClassVar = (5.0, 10.0, 20.0)
    LEFT: ClassVar = 0.05
    """Share of sqrt(v^2 + (R w)^2) that is left when the ratio is taken."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Three spins."""
        r = self.RADIUS
        for spin in self.SPINS:
            world = make_world(solver, dt, static=self.MU)
            world.add(st.Plane(), static=True)
            disc = world.add(
                st.Cylinder(r, 0.002), position=(0, 0, 0.001), velocity=(self.SPEED, 0, 0),
                angular_velocity=(0, 0, spin),
            )  # fmt: skip
            seen = [(self.SPEED, r * spin)]
            for _ in range(steps_for(4.0, dt)):
                world.step()
                seen.append((float(np.linalg.norm(disc.velocity[:2])), r * abs(float(disc.angular_velocity[2]))))
            speeds = np.array(seen)
            expected, measured = self._ratio(self._reference(spin, 1e-3)), self._ratio(speeds)
            what = f"v / (R w) at {100 * self.LEFT:g} % of the speed, {spin:g} rad/s"
            yield Measurement(what, expected, measured, 0.01, "", "relative")
            ends = [int(np.argmax(column < 1e-4 * column[0])) for column in speeds.T]
            apart = abs(ends[0] - ends[1]) * dt if min(ends) > 0 else math.nan
            yield Measurement(f"time between the ends, {spin:g} rad/s", 0.0, apart, 1.001 * dt, "s")

    def _ratio(self, speeds: Array) -> float:
        """Of v to R w, (n, 2), where both together have come down to the share that is asked for."""
        sizes = np.hypot(speeds[:, 0], speeds[:, 1]) / math.hypot(*speeds[0])
        k = int(np.argmax(sizes < self.LEFT))
        if k == 0:
            return math.nan
        share = (sizes[k - 1] - self.LEFT) / (sizes[k - 1] - sizes[k])
        v, w = (1.0 - share) * speeds[k - 1] + share * speeds[k]
        return float(v / w)

    def _reference(self, spin: float, h: float) -> Array:
        """Speeds v and R w, (n, 2), by Runge's method of second order; the disc's turn does not matter."""
        ring, spoke = (np.arange(40) + 0.5) / 40, (np.arange(40) + 0.5) / 40
        rho, angle = np.meshgrid(self.RADIUS * np.sqrt(ring), 2.0 * np.pi * spoke)
        x, y = (rho * np.cos(angle)).ravel(), (rho * np.sin(angle)).ravel()

        def rate(v: float, w: float) -> tuple[float, float]:
            ux, uy = v - w * y, w * x
            size = np.maximum(np.hypot(ux, uy), 1e-9)
            force = -self.MU * G * float(np.mean(ux / size))
            torque = -self.MU * G * float(np.mean((x * uy - y * ux) / size))
            return force, torque / (0.5 * self.RADIUS**2)

        v, w = self.SPEED, spin
        seen = [(v, self.RADIUS * w)]
        while math.hypot(*seen[-1]) > 0.5 * self.LEFT * math.hypot(*seen[0]):
            a, b = rate(v, w)
            a, b = rate(v + 0.5 * h * a, w + 0.5 * h * b)
            v, w = v + h * a, w + h * b
            seen.append((v, self.RADIUS * w))
        return np.array(seen)


class BreakAwayWithTorque(Case):
    """A push beside the centre needs less force than one through it."""

    name = "break-away-with-torque"
    title = "a square face pushed and twisted at once gives way where Coulomb's law over the face says"
    formula = "F = mu m g <u_y>, T = mu m g <x u_y - y u_x>, u the directions of turning about a point at a distance c"
    source = (
        LAWS + " under uniform pressure; Goyal, Ruina and Papadopoulos, 'Planar sliding with dry friction', Wear 143 "
        "(1991): force and torque that turn a face about a point lie on the limit surface"
    )
    tolerance = "holds at 0.99 of both, gives way at 1.01 of both: 1 %; 1e-4 m and rad"
    tolerance_reason = (
        "the limit surface of a square is fitted within 0.5 % in any direction; beyond it by 1 % the face goes by "
        "millimetres in two seconds, and what holds stays where it is"
    )
    solvers = ("soft", "exact")
    MU: ClassVar = 0.5
    MASS: ClassVar = 10.0
    CENTERS: ClassVar = (0.1, 0.3, 0.6, 1.5)
    """m, distance of the point about which the face would turn."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Four mixtures of force and torque, from nearly all torque to nearly all force; just below and just above."""
        n = 200
        grid = (np.arange(n) + 0.5) / n - 0.5
        x, y = np.meshgrid(grid, grid)
        for c in self.CENTERS:
            # turning about (-c, 0): u is at right angles to the way from there
            ux, uy = -y, x + c
            size = np.hypot(ux, uy)
            load = self.MU * self.MASS * G
            force = load * float(np.mean(uy / size))
            torque = load * float(np.mean((x * uy - y * ux) / size))
            moved = {share: self._push(solver, dt, share * force, share * torque) for share in (0.99, 1.01)}
            yield Measurement(f"moved in 2 s at 99 %, c = {c:g} m", 0.0, moved[0.99], 1e-4, "m")
            gives = 1.01 if moved[1.01] > 1e-3 else math.nan
            yield Measurement(f"share that moves it, c = {c:g} m", 1.01, gives, 0.005)

    def _push(self, solver: str, dt: float, force: float, torque: float) -> float:
        """How far the slab has gone in 2 s, m; or turned, rad, if that is more."""
        world = make_world(solver, dt, static=self.MU)
        world.add(st.Plane(), static=True)
        slab = world.add(st.Box((1.0, 1.0, 0.01)), mass=self.MASS, position=(0, 0, 0.005))
        for _ in range(steps_for(2.0, dt)):
            slab.apply_force((0.0, force, 0.0))
            slab.apply_torque((0.0, 0.0, torque))
            world.step()
        w, _, _, z = slab.orientation
        return max(float(np.linalg.norm(slab.position[:2])), 2.0 * abs(math.atan2(z, w)))
