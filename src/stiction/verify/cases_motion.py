"""Free motion and the ledger of energy: parabolas, constant forces, tops, and where the energy goes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    WEIGHTLESS,
    G,
    about,
    box_inertia,
    make_world,
    matrix,
    rounding,
    speed_error,
    steps_for,
)


class FreeFall(Case):
    """A throw; the ball spins, which must not matter."""

    name = "free-fall"
    title = "a thrown body follows its parabola exactly, and so does its energy"
    formula = "x = x0 + v0 t + g t^2 / 2, v = v0 + g t"
    source = "Galilei, 'Discorsi' (1638); Newton's second law"
    tolerance = "1e-11 t / dt, relative to the distance fallen"
    tolerance_reason = (
        "the mean of old and new velocity is exact for a constant force: only rounding is left, once a step"
    )
    SECONDS: ClassVar = 3.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Position, velocity and energy at the end."""
        world = make_world(solver, dt)
        x0, v0 = np.array([1.0, -2.0, 50.0]), np.array([3.0, 4.0, 12.0])
        ball = world.add(st.Sphere(0.1), mass=0.3, position=x0, velocity=v0, angular_velocity=(3, -2, 9))
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        world.step(steps)
        fallen = 0.5 * G * t * t
        slack = 1e-11 * steps * fallen
        expected = x0 + v0 * t - (0, 0, fallen)
        for k, axis in enumerate("xyz"):
            yield Measurement(f"position {axis}", expected[k], float(ball.position[k]), slack, "m")
        yield Measurement("velocity z", v0[2] - G * t, float(ball.velocity[2]), 1e-11 * steps * G * t, "m/s")
        energy = world.energy()
        drift = energy.kinetic + energy.potential - energy.initial
        yield Measurement("change of energy", 0.0, drift, 1e-11 * steps * energy.initial, "J")


class ConstantForce(Case):
    """Force at a point off the centre, about a principal axis: an acceleration and a spin at once."""

    name = "constant-force"
    title = "a constant force off the centre pushes and turns a free body"
    formula = "v = F t / m, x = F t^2 / (2 m); w = r F t / I"
    source = "Newton's second law and Euler's law"
    tolerance = "1e-11 t / dt, relative"
    tolerance_reason = (
        "the mean of old and new velocity is exact for a constant force: only rounding is left, once a step"
    )
    FORCE: ClassVar = 2.0
    ARM: ClassVar = 0.3
    SIZE: ClassVar = (0.8, 0.5, 0.3)
    MASS: ClassVar = 1.5

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The force keeps its direction and its arm about the vertical axis."""
        world = make_world(solver, dt, gravity=WEIGHTLESS)
        q = about((0, 0, 1), 0.5)
        box = world.add(st.Box(self.SIZE), mass=self.MASS, orientation=q)
        force = np.array([self.FORCE, 0.0, 0.0])
        steps = steps_for(1.0, dt)
        for _ in range(steps):
            box.apply_force(force, at=box.position - (0.0, self.ARM, 0.0))
            world.step()
        t = steps * dt
        inertia = float(box_inertia(self.MASS, self.SIZE)[2])
        slack = 1e-11 * steps
        a = self.FORCE / self.MASS
        yield Measurement("velocity", a * t, float(box.velocity[0]), slack, "m/s", "relative")
        yield Measurement("position", 0.5 * a * t * t, float(box.position[0]), slack, "m", "relative")
        spin = self.ARM * self.FORCE * t / inertia
        yield Measurement("spin", spin, float(box.angular_velocity[2]), slack, "rad/s", "relative")
        work = 0.5 * self.MASS * (a * t) ** 2 + 0.5 * inertia * spin**2
        yield Measurement("work in the ledger", work, world.energy().work, slack, "J", "relative")


class SpinningTop(Case):
    """About its middle axis a box tumbles over and over (Dzhanibekov), which takes an integrator to its limits."""

    name = "spinning-top"
    title = "a free asymmetric box that tumbles keeps its energy and its angular momentum"
    formula = "E = w . I w / 2 and L = I w do not change"
    source = "Euler's equations; Landau, Lifshitz, 'Mechanics', par. 37"
    tolerance = "1e-13 t / dt (E, |L|), relative; w dt / 2 (direction of L)"
    tolerance_reason = (
        "the implicit mid-point rule keeps both quadratic invariants, to rounding; the angular velocity of a step is"
        " held while the body turns by w dt, so the direction of L swings by a part of that, without growing"
    )
    other_tolerance: ClassVar = dict.fromkeys(
        ("soft", "exact"),
        (
            "1e-13 t / dt, relative",
            "the implicit mid-point rule keeps both quadratic invariants, and the rotation that belongs to it the "
            "direction of L, to rounding",
        ),
    )
    SIZE: ClassVar = (1.0, 0.6, 0.2)
    MASS: ClassVar = 3.0
    SPIN: ClassVar = (0.1, 5.0, 0.2)
    SECONDS: ClassVar = 20.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Worst over 20 s, which is about 30 turns and several flips."""
        world = make_world(solver, dt, gravity=WEIGHTLESS)
        box = world.add(st.Box(self.SIZE), mass=self.MASS, angular_velocity=self.SPIN)
        moments = box_inertia(self.MASS, self.SIZE)
        energy, momentum = [], []
        steps = steps_for(self.SECONDS, dt)
        for k in range(steps + 1):
            turn = matrix(box.orientation)
            w = turn.T @ box.angular_velocity
            energy.append(0.5 * float(w @ (moments * w)))
            momentum.append(turn @ (moments * w))
            if k < steps:
                world.step()
        l0 = momentum[0]
        size = float(np.linalg.norm(l0))
        lengths = [float(np.linalg.norm(x)) for x in momentum]
        slack = 1e-13 * steps
        yield Measurement("energy, worst", energy[0], _worst(energy), slack, "J", "relative")
        yield Measurement("|L|, worst", size, _worst(lengths), slack, "kg m^2/s", "relative")
        swing = max(float(np.linalg.norm(x - l0)) for x in momentum) / size
        held = 0.5 * dt * float(np.linalg.norm(self.SPIN))
        yield Measurement("direction of L, worst", 0.0, swing, held if solver == "micro" else slack, "rad")
        yield Measurement(
            "energy in the ledger that nobody put in", 0.0, world.energy().numerical, slack * energy[0], "J"
        )


def _worst(values: list[float]) -> float:
    return max(values, key=lambda x: abs(x - values[0]))


class TumblingPeriod(Case):
    """How often the box of 'spinning-top' flips is told by an elliptic integral, and by nothing simpler."""

    name = "tumbling-period"
    title = "a box thrown about its middle axis flips over with the period of Euler's solution"
    formula = "T / 2 = 2 K(k) sqrt(I1 I2 I3 / ((I3 - I2) (L^2 - 2 E I1))), or with 1 and 3 exchanged"
    source = "Landau, Lifshitz, 'Mechanics', par. 37 (Euler's solution in Jacobi's elliptic functions)"
    tolerance = "(w dt)^2 / 4, relative"
    tolerance_reason = (
        "the implicit mid-point rule is of second order; near the separatrix it slows down by more than its own error"
    )
    SIZE: ClassVar = (1.0, 0.6, 0.2)
    MASS: ClassVar = 3.0
    SPIN: ClassVar = (0.5, 5.0, 0.2)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The time between flips, over four of them."""
        world = make_world(solver, dt, gravity=WEIGHTLESS)
        box = world.add(st.Box(self.SIZE), mass=self.MASS, angular_velocity=self.SPIN)
        moments = box_inertia(self.MASS, self.SIZE)
        low, middle, high = (float(x) for x in moments)  # sizes fall, so moments rise
        w = np.array(self.SPIN)
        energy2 = float(w @ (moments * w))
        momentum2 = float(np.sum((moments * w) ** 2))
        if momentum2 < energy2 * middle:
            low, high = high, low
        k2 = (middle - low) * (energy2 * high - momentum2) / ((high - middle) * (momentum2 - energy2 * low))
        stretch = math.sqrt(low * middle * high / ((high - middle) * (momentum2 - energy2 * low)))
        half = 2.0 * complete_elliptic(k2) * stretch

        crossings: list[float] = []
        before = self.SPIN[1]
        for k in range(1, steps_for(6.0 * half, dt) + 1):
            world.step()
            now = float((matrix(box.orientation).T @ box.angular_velocity)[1])
            if before * now < 0.0:
                crossings.append((k - now / (now - before)) * dt)
            before = now
        flips = len(crossings) - 1
        measured = (crossings[-1] - crossings[0]) / flips if flips >= 4 else math.nan
        slack = 0.25 * (float(np.linalg.norm(w)) * dt) ** 2
        yield Measurement("time between flips", half, measured, slack, "s", "relative")


def complete_elliptic(k2: float) -> float:
    """K(k) of the first kind by the arithmetic-geometric mean (Gauss)."""
    a, b = 1.0, math.sqrt(1.0 - k2)
    while a - b > 1e-15 * a:
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return 0.5 * math.pi / a


class Precession(Case):
    """Seen from outside, the axis of a free symmetric top goes round L at the rate |L| / I_1."""

    name = "precession"
    title = "the axis of a free plate goes round its angular momentum, about twice as fast as the plate spins"
    formula = "rate = |L| / I_1 at a constant angle to L"
    source = "Euler's equations; Landau, Lifshitz, 'Mechanics', par. 33; Feynman's plate"
    tolerance = "(rate dt)^2 / 12 + w dt / (rate t) (rate), w dt / 4 (angle)"
    tolerance_reason = (
        "the mid-point rule turns too little by a third-order term; and the direction of L swings within w dt / 2 "
        "(see 'spinning-top')"
    )
    other_tolerance: ClassVar = dict.fromkeys(
        ("soft", "exact"),
        (
            "(rate dt)^2 / 12 + w dt / (rate t) (rate), 1e-13 t / dt (angle)",
            "the mid-point rule turns too little by a third-order term; L and the energy it keeps to rounding",
        ),
    )
    SIZE: ClassVar = (1.0, 1.0, 0.2)
    MASS: ClassVar = 3.0
    SPIN: ClassVar = (0.8, 0.0, 5.0)
    SECONDS: ClassVar = 10.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Turns of the axis about L, and its angle to L."""
        world = make_world(solver, dt, gravity=WEIGHTLESS)
        plate = world.add(st.Box(self.SIZE), mass=self.MASS, angular_velocity=self.SPIN)
        moments = box_inertia(self.MASS, self.SIZE)
        momentum = moments * np.array(self.SPIN)
        size = float(np.linalg.norm(momentum))
        n = momentum / size
        e1 = np.array([0.0, 1.0, 0.0])  # L starts in the x z plane
        e2 = np.cross(n, e1)

        def seen() -> tuple[float, float]:
            axis = matrix(plate.orientation)[:, 2]
            return math.atan2(float(axis @ e2), float(axis @ e1)), math.acos(min(float(axis @ n), 1.0))

        last, tilt0 = seen()
        turned, tilts = 0.0, []
        steps = steps_for(self.SECONDS, dt)
        for _ in range(steps):
            world.step()
            now, tilt = seen()
            turned += math.remainder(now - last, 2.0 * math.pi)
            last = now
            tilts.append(tilt)
        rate, t = size / float(moments[0]), steps * dt
        w = float(np.linalg.norm(self.SPIN))
        slack = (rate * dt) ** 2 / 12.0 + w * dt / (rate * t)
        yield Measurement("rate", rate, turned / t, slack, "rad/s", "relative")
        worst = max(tilts, key=lambda x: abs(x - tilt0))
        held = 0.25 * w * dt if solver == "micro" else 1e-13 * steps
        yield Measurement("angle to L, worst", math.acos(float(n[2])), worst, held, "rad")


class EnergyLedger(Case):
    """A pile-up: balls and boxes that fall, bounce, slide and roll on a slope and on each other."""

    name = "energy-ledger"
    title = "kinetic and potential energy change by what forces put in and what friction and impacts take, to rounding"
    formula = "E_kin + E_pot = E_0 + work + edits + numerical - dissipated"
    source = "conservation of energy; first law"
    tolerance = "1e-11 of the energy turned over (sum); 1e-4 m v^2 / 2 (one slide)"
    tolerance_reason = "an identity, step by step, so rounding is all that is left; a slide ends within a step"

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The sum in a lively scene, each single entry in a simple one."""
        world = make_world(solver, dt, static=0.4, dynamic=0.3, restitution=0.5, rolling=1e-3, torsional=1e-3)
        world.add(st.Plane((0.1, 0.0, 1.0)), static=True)
        world.add(st.Box((2.0, 2.0, 0.2)), kinematic=True, position=(0, 0, 0.4), angular_velocity=(0, 0, 1.0))
        for k in range(12):
            shape = st.Sphere(0.15) if k % 2 else st.Box((0.3, 0.25, 0.2))
            world.add(
                shape, position=(0.3 * (k % 4) - 0.4, 0.3 * (k // 4) - 0.3, 1.2 + 0.4 * k), angular_velocity=(k, 1, -k)
            )
        first = world.bodies[2]
        for _ in range(steps_for(1.5, dt)):
            first.apply_force((3.0, 0.0, 1.0), at=first.position + np.array([0.0, 0.1, 0.0]))
            world.step()
        first.velocity = (1.0, 0.0, 0.0)
        world.step()
        energy = world.energy()
        turned_over = energy.initial + energy.dissipated + abs(energy.work)
        yield Measurement("what is missing, lively scene", 0.0, energy.residual, 1e-11 * turned_over, "J")

        m, v, mu = 2.0, 3.0, 0.3
        world = make_world(solver, dt, static=mu)
        world.add(st.Plane(), static=True)
        crate = world.add(st.Box((0.5, 0.5, 0.3)), mass=m, position=(0, 0, 0.15), velocity=(v, 0, 0))
        world.run(1.5 * v / (mu * G))
        energy = world.energy()
        heat = 0.5 * m * v * v
        yield Measurement("heat of friction of a crate that stops", heat, energy.friction, 1e-4 * heat, "J")
        yield Measurement("the same, booked to the crate", heat, crate.friction_work, 1e-4 * heat, "J")
        yield Measurement("energy of no known origin while it stops", 0.0, energy.numerical, 1e-5 * heat, "J")

        # an inelastic fall: all that is left when it lands goes into the impact
        world = make_world(solver, dt, static=mu)
        world.add(st.Plane(), static=True)
        world.add(st.Sphere(0.1), mass=m, position=(0, 0, 1.1))
        world.run(1.0)
        energy = world.energy()
        yield Measurement(
            "lost by a ball that drops 1 m and stays", m * G, energy.impacts - energy.numerical, 1e-4 * m * G, "J"
        )


class SlideToRollEnergy(Case):
    """Sliding into rolling loses 2/7 of the energy, and rolling itself loses none."""

    name = "slide-to-roll-energy"
    title = "a ball loses 2/7 of its energy until it rolls, and nothing after that"
    formula = "E = m v0^2 / 2 (1 - 2/7)"
    source = "Newton's second law and Coulomb's law"
    tolerance = "eps m v0 (sliding), eps sqrt(t / dt) m v0 (rolling)"
    tolerance_reason = "one contact is resolved at once, so only the solver's tolerance is left"
    other_tolerance: ClassVar = {
        "soft": (
            "m v0 e (energies), t e (way); e = eps sqrt(t / dt) + u v0 t / h",
            "as for micro, and single precision (u = 2^-24) rounds velocities in each substep",
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Energy when it has begun to roll, and ten seconds later."""
        m, v0, mu, r = 5.0, 4.0, 0.25, 0.1
        world = make_world(solver, dt, static=mu)
        world.add(st.Plane(), static=True)
        ball = world.add(st.Sphere(r), mass=m, position=(0, 0, r), velocity=(v0, 0, 0))
        world.run(1.1 * 2.0 * v0 / (7.0 * mu * G))
        e0 = 0.5 * m * v0 * v0
        slack = m * v0 * (speed_error(solver, dt, dt) + rounding(solver, v0, world.time, dt))
        yield Measurement("energy when rolling", e0 * 5.0 / 7.0, ball.kinetic_energy, slack, "J")
        yield Measurement("heat of friction", e0 * 2.0 / 7.0, world.energy().friction, slack, "J")
        x, t0 = float(ball.position[0]), world.time
        world.run(10.0)
        t = world.time - t0
        eps = speed_error(solver, t, dt, v0)
        slack = m * v0 * eps
        yield Measurement("energy 10 s later", e0 * 5.0 / 7.0, ball.kinetic_energy, slack, "J")
        far = float(ball.position[0]) - x
        yield Measurement("way in these 10 s", 5.0 / 7.0 * v0 * t, far, eps * t, "m")
