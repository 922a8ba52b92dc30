"""Laws of a pair beyond two constants: tyre curves on a rig, Stribeck's curve, the ellipse of a grain, adhesion."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    GRAVITY,
    Array,
    G,
    Slope,
    arrival,
    begin_error,
    box_compliance,
    distance_error,
    lean,
    rounding,
    sink,
    solver_tolerance,
    speed_error,
    steps_for,
    stop_error,
    substep,
)

LAWS = "Newton's second law and Coulomb's law"


def law_world(solver: str, dt: float, **properties: Any) -> st.World:
    """A world in which everything is of one material with these properties."""
    table = st.MaterialTable()
    table.set_pair("default", "default", **properties)
    return st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)


class _TyreCurve(Case):
    """A wheel on a rig that holds speed and spin, so that the slip stays what it is; the rig's force is read."""

    solvers = ("soft",)
    tolerance = "mu'(sigma) u + sqrt(2) (eps / dt + u v / h) / g"
    tolerance_reason = (
        "the slip is known to single precision (u = 2^-24), and what the rig must add in a step, in each of two "
        "directions, to the solver's tolerance and to what that precision makes of the speed v in each substep"
    )
    PEAK: ClassVar = 0.9
    SPEED: ClassVar = 20.0
    RADIUS: ClassVar = 0.3
    SLIPS: ClassVar = ((0.02, 0.0), (0.0, 0.05), (0.06, -0.08), (-0.1, 0.0), (0.25, 0.0), (0.0, 0.5))
    """Braking, cornering, both at once, driving; past the end of what grips."""

    @abstractmethod
    def law(self) -> st.FrictionLaw:
        """The pair's law."""

    @abstractmethod
    def curve(self, slip: float) -> float:
        """mu(sigma), written out here."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Force against the slip and across it, over the load."""
        v, d = self.SPEED, 1e-6
        for slip in self.SLIPS:
            size = math.hypot(*slip)
            along = np.array([*slip, 0.0]) / size
            force = self._rig(solver, dt, np.array(slip))
            slope = abs(self.curve(size + d) - self.curve(size - d)) / (2.0 * d)
            slack = slope * 2.0**-24 + math.sqrt(2.0) * (solver_tolerance(solver) + rounding(solver, v, dt, dt)) / (
                G * dt
            )
            how = f"slip ({slip[0]:g}, {slip[1]:g})"
            yield Measurement(
                f"force against the slip over load, {how}", self.curve(size), -float(force @ along), slack
            )
            across = float(force[1] * along[0] - force[0] * along[1])
            yield Measurement(f"force across the slip over load, {how}", 0.0, across, slack)

    def _rig(self, solver: str, dt: float, slip: Array) -> Array:
        """Friction over load (3,): minus the force that keeps a wheel at its speed, found step after step.

        In each step the rig pushes as hard as the road braked in the one before. With k = g mu' dt / (2 v), which is
        below 0.1, what is left of a wrong force after a step is a share of k: 12 steps leave 1e-12.
        """
        v, r = self.SPEED, self.RADIUS
        world = law_world(solver, dt, static=self.PEAK, dynamic=self.PEAK, law=self.law())
        world.add(st.Plane(), static=True)
        velocity = v * np.array([math.sqrt(1.0 - slip[1] ** 2), slip[1], 0.0])
        wheel = world.add(
            st.Sphere(r), mass=10.0, inertia=(1e6, 1e6, 1e6), position=(0, 0, r), velocity=(v, 0, 0),
            angular_velocity=(0, v / r, 0),
        )  # fmt: skip
        world.run(0.5)  # free rolling, until it has sunk in
        spin = np.array([0.0, (velocity[0] - slip[0] * v) / r, 0.0])
        push = np.zeros(3)
        for _ in range(12):
            wheel.velocity, wheel.angular_velocity = velocity, spin
            wheel.apply_force(push)
            world.step()
            push = push - wheel.mass / dt * (wheel.velocity - velocity) * (1.0, 1.0, 0.0)
        return -push / (wheel.mass * G)


class TyreBrush(_TyreCurve):
    """Bristles that stick at the front of the contact and slide at its end."""

    name = "tyre-curve-brush"
    title = "a wheel at a fixed slip brakes, drives and corners as the brush model says"
    formula = "mu = D (3 q - 3 q^2 + q^3), q = C sigma / (3 D) < 1; D beyond; against the slip"
    source = "Pacejka, 'Tire and Vehicle Dynamics', 3rd ed. (2012), section 3.2"
    STIFFNESS: ClassVar = 15.0

    def law(self) -> st.FrictionLaw:
        """C = 15."""
        return st.BrushTyre(self.STIFFNESS)

    def curve(self, slip: float) -> float:
        """The polynomial."""
        q = min(self.STIFFNESS * slip / (3.0 * self.PEAK), 1.0)
        return self.PEAK * (3.0 * q - 3.0 * q * q + q**3)


class TyreMagic(_TyreCurve):
    """Beyond its peak the force falls, and so a real wheel locks."""

    name = "tyre-curve-magic"
    title = "a wheel at a fixed slip brakes, drives and corners as the magic formula says, past its peak, too"
    formula = "mu = D sin(C atan(B s - E (B s - atan(B s)))), s = sigma; against the slip"
    source = "Pacejka and Bakker, 'The magic formula tyre model', Vehicle System Dynamics 21 (1992)"
    B: ClassVar = 10.0
    C: ClassVar = 1.6
    E: ClassVar = 0.5

    def law(self) -> st.FrictionLaw:
        """B = 10, C = 1.6, E = 0.5."""
        return st.MagicFormula(self.B, self.C, self.E)

    def curve(self, slip: float) -> float:
        """The formula."""
        x = self.B * slip
        return self.PEAK * math.sin(self.C * math.atan(x - self.E * (x - math.atan(x))))


class StribeckStop(Case):
    """Friction that rises as the block slows down: the last centimetres are the shortest."""

    name = "stribeck-stop"
    title = "a block whose friction falls with its speed stops where the integral says"
    formula = "d = int v dv / (g mu(v)), t = int dv / (g mu(v)), mu = mu_d + (mu_s - mu_d) exp(-(v / v_s)^n) + c v"
    source = (
        LAWS + "; Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2; integrated here "
        "(Simpson)"
    )
    tolerance = "int v |1 / mu(v + 2 mu g h) - 1 / mu(v)| dv / g, and t without the v; and as for 'stopping-distance'"
    tolerance_reason = (
        "the coefficient of a substep h is that of the speed at the end of the one before, while the block goes with "
        "speeds lower by up to 2 mu g h"
    )
    solvers = ("soft",)
    STATIC: ClassVar = 0.6
    DYNAMIC: ClassVar = 0.3
    SPEED: ClassVar = 3.0
    SIZE: ClassVar = (1.0, 0.8, 0.2)
    LAWS_TRIED: ClassVar = ((0.5, 0.0, 2.0), (0.5, 0.05, 1.0), (0.1, 0.0, 2.0))
    """v_s in m/s, c in s/m, n."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Three laws."""
        for v_s, viscous, exponent in self.LAWS_TRIED:
            world = law_world(
                solver, dt, static=self.STATIC, dynamic=self.DYNAMIC, law=st.Stribeck(v_s, viscous, exponent)
            )
            world.add(st.Plane(), static=True)
            block = world.add(
                st.Box(self.SIZE), position=(0, 0, 0.1), velocity=(0.6 * self.SPEED, -0.8 * self.SPEED, 0)
            )

            mu = partial(self._mu, v_s=v_s, viscous=viscous, exponent=exponent)
            d, t, off, late = self._stop(mu, 2.0 * G * substep(solver, dt))
            speeds = [self.SPEED]
            for _ in range(steps_for(1.2 * t, dt)):
                world.step()
                speeds.append(float(np.linalg.norm(block.velocity)))
            how = f"v_s = {v_s:g} m/s, c = {viscous:g} s/m, n = {exponent:g}"
            slack = off + stop_error(solver, self.STATIC, self.STATIC, dt) + lean(solver, dt, 0.2, self.SIZE[1])
            slack += self.STATIC * sink(solver, dt, 7.0 / 4.0) + distance_error(solver, t, dt, self.SPEED)
            path = float(np.linalg.norm(block.position[:2]))
            yield Measurement(f"distance, {how}", d, path, slack, "m")
            late += speed_error(solver, t, dt, self.SPEED) / (self.DYNAMIC * G)
            # the speed does not fall in a straight line within the last step: its slope changes by less than this share
            slow = mu(np.array([0.0, self.STATIC * G * dt]))
            bend = abs(float(slow[1] / slow[0]) - 1.0)
            yield Measurement(f"time, {how}", t, arrival(speeds, dt), late + bend * dt, "s")

    def _mu(self, v: Array, v_s: float, viscous: float, exponent: float) -> Array:
        fade = np.exp(-((v / v_s) ** exponent))
        return np.asarray(self.DYNAMIC + (self.STATIC - self.DYNAMIC) * fade + viscous * v)

    def _stop(self, mu: Callable[[Array], Array], lag: float, n: int = 20_000) -> tuple[float, float, float, float]:
        """Distance (m) and time (s) by Simpson's rule over the speed, and by how much a coefficient of the speed
        ``lag`` (s) times the deceleration over g higher changes them at most."""
        v = np.linspace(0.0, self.SPEED, n + 1)
        weights = np.full(n + 1, 2.0)
        weights[1:-1:2], weights[0], weights[-1] = 4.0, 1.0, 1.0
        weights *= self.SPEED / n / 3.0 / G
        slowness = 1.0 / mu(v)
        change = np.abs(1.0 / mu(v + lag * mu(v)) - slowness)
        d, t, off, late = (float(weights @ x) for x in (slowness * v, slowness, change * v, change))
        return d, t, off, late


class GrainOnSlope(Case):
    """Skis that point askew do not run straight downhill: they run more along themselves."""

    name = "grain-on-slope"
    title = "a crate whose grain lies askew on a slope slides in a straight line off downhill"
    formula = "a_i = g sin(theta) d_i / (1 + c e_i^2), c |E a| = mu g cos(theta); E = diag(1, mu_across / mu)"
    source = (
        "friction of greatest dissipation within an ellipse, f = -mu N E E v / |E v|: Goyal, Ruina and Papadopoulos, "
        "'Planar sliding with dry friction', Wear 143 (1991)"
    )
    tolerance = "a h dt / 2 + t (eps sqrt(t / dt) + u a t^2 / h), in each direction"
    tolerance_reason = (
        "forces are constant and far above what static friction holds; but the crate moves with the velocity at the "
        "end of a substep in the step in which it begins, and single precision (u = 2^-24) rounds its speed"
    )
    solvers = ("soft",)
    ALONG: ClassVar = 0.2
    ACROSS: ClassVar = 0.4
    TAN: ClassVar = 0.7
    SECONDS: ClassVar = 2.0
    YAWS: ClassVar = (0.0, 0.3, 0.8, 1.3, 1.5)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Where five crates are after 2 s, downhill and sideways."""
        slope = Slope(math.atan(self.TAN), azimuth=0.9)
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        for yaw in self.YAWS:
            world = law_world(
                solver, dt, static=self.ALONG, dynamic=self.ALONG, static_across=self.ACROSS,
                dynamic_across=self.ACROSS,
            )  # fmt: skip
            slope.add_to(world)
            crate = world.add(
                st.Box((1.0, 1.0, 0.2)), position=0.1 * slope.normal, orientation=slope.orientation(yaw),
                grain=(1, 0, 0),
            )  # fmt: skip
            start = crate.position
            world.step(steps)
            way = crate.position - start
            a = self._acceleration(slope.angle, yaw)
            size = float(np.linalg.norm(a))
            slack = begin_error(solver, size, dt) + distance_error(solver, t, dt, size * t)
            how = f"grain {math.degrees(yaw):.3g} deg off downhill"
            yield Measurement(f"downhill, {how}", 0.5 * a[0] * t * t, float(way @ slope.down), slack, "m")
            yield Measurement(f"sideways, {how}", 0.5 * a[1] * t * t, float(way @ slope.across), slack, "m")

    def _acceleration(self, angle: float, yaw: float) -> Array:
        """(downhill, sideways), m/s^2: bisection for c, as c |E a| rises with c."""
        e2 = np.array([1.0, (self.ACROSS / self.ALONG) ** 2])
        pull = G * math.sin(angle) * np.array([math.cos(yaw), -math.sin(yaw)])  # along the grain, across it
        limit = self.ALONG * G * math.cos(angle)
        low, high = 0.0, 1e6
        for _ in range(200):
            c = 0.5 * (low + high)
            a = pull / (1.0 + c * e2)
            if c * math.sqrt(float(a @ (e2 * a))) < limit:
                low = c
            else:
                high = c
        return np.array([a[0] * math.cos(yaw) - a[1] * math.sin(yaw), a[0] * math.sin(yaw) + a[1] * math.cos(yaw)])


class PullOff(Case):
    """Tape, magnets and suction cups: a pull that grows slowly, until the crate comes off."""

    name = "pull-off"
    title = "a crate that sticks to the floor comes off when the pull exceeds weight and adhesion"
    formula = "F = m g + A, or m g + p a for a pressure p on an area a"
    source = "Newton's second law, with an adhesive force that holds until surfaces part"
    tolerance = "F' ((6 m s / F')^(1/3) + dt), s = 0.1 mm + 2 (g / omega^2) load / (m g)"
    tolerance_reason = (
        "adhesion holds on while the gap is below 0.1 mm, which a pull that grows at the rate F' takes (6 m s / "
        "F')^(1/3) to cross, from as far below as the springs of soft contacts (omega h = 1.3) were pressed, and back; "
        "and it grows once a step"
    )
    solvers = ("soft",)
    MASS: ClassVar = 50.0
    ADHESION: ClassVar = 300.0
    RATE: ClassVar = 6.0
    """N/s"""
    SIZE: ClassVar = (0.5, 0.4, 0.2)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """300 N, and as much by a pressure; then the same on half the area."""
        x, y, z = self.SIZE
        pressure = self.ADHESION / (x * y)
        for what, size, properties, force in (
            ("force", self.SIZE, {"adhesion": self.ADHESION}, self.ADHESION),
            ("pressure", self.SIZE, {"adhesion_pressure": pressure}, self.ADHESION),
            ("pressure, half the area", (0.5 * x, y, z), {"adhesion_pressure": pressure}, 0.5 * self.ADHESION),
        ):
            world = law_world(solver, dt, static=0.5, dynamic=0.5, **properties)
            world.add(st.Plane(), static=True)
            crate = world.add(st.Box(size), mass=self.MASS, position=(0, 0, 0.5 * z))
            world.run(0.5)
            limit = self.MASS * G + force
            pull, off = limit - self.RATE, math.nan
            for _ in range(steps_for(3.0, dt)):
                pull += self.RATE * dt
                crate.apply_force((0, 0, pull))
                world.step()
                if not len(world.contacts()):
                    off = pull
                    break
            depth = 1e-4 + 2.0 * sink(solver, dt, box_compliance(size)) * limit / (self.MASS * G)
            slack = self.RATE * ((6.0 * self.MASS * depth / self.RATE) ** (1.0 / 3.0) + dt)
            yield Measurement(f"pull when it comes off, {what}", limit, off, slack, "N")
