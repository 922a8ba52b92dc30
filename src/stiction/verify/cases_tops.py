"""The tippe top: a ball that is heavier on one side, spun fast, turns over by friction alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import Array, G, about, make_world, matrix, solver_tolerance, steps_for


class TippeTop(Case):
    """It lifts its centre of mass, and spins slower for it. Large, so that a step is a small part of a turn."""

    name = "tippe-top"
    title = "a ball with its centre of mass below the middle, spun on the floor, turns upside down"
    formula = "J = L . a does not change (a from the centre of mass to the contact); at last w = -J / (I3 (r + e))"
    source = (
        "Jellett, 'A treatise on the theory of friction' (1872), ch. 8; Bou-Rabee, Marsden and Romero, 'Tippe top "
        "inversion as a dissipation-induced instability', SIAM J. Appl. Dyn. Syst. 3 (2004)"
    )
    tolerance = "(m g e^2 / J) int |(e3 x e3')_z| dt dt / 2 (J), the same and k e / (r + e) (w); k = 0.05 (cosine)"
    tolerance_reason = (
        "the arm of a contact is held while the body turns during a step, so the load m g acts e e3' dt / 2 away from "
        "where it should, on average, which changes L . a at the rate m g e^2 (e3 x e3')_z dt / 2; at last it rolls, "
        "and friction takes away no more of its tilt, so k is a target; with w along e3 that changes w by k e / (r + e)"
    )
    solvers = ("soft", "exact")
    RADIUS: ClassVar = 20.0
    OFFSET: ClassVar = 6.0
    SPIN: ClassVar = 6.5
    TILT: ClassVar = 0.2
    MU: ClassVar = 0.3
    SECONDS: ClassVar = 200.0
    TILT_LEFT: ClassVar = 0.05
    """1 + the cosine of the tilt."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Until it spins on its head."""
        r, e, m = self.RADIUS, self.OFFSET, 1.0
        inertia = 0.4 * m * r * r  # about each axis through the centre of mass
        world = make_world(solver, dt, static=self.MU)
        world.add(st.Plane(), static=True)
        q = about((1, 2, 0), self.TILT)
        top = world.add(
            st.Sphere(r), mass=m, inertia=(inertia,) * 3, center_of_mass=(0, 0, -e), position=(0, 0, r),
            orientation=q, angular_velocity=self.SPIN * matrix(q)[:, 2],
        )  # fmt: skip

        def axis() -> Array:
            return matrix(top.orientation)[:, 2]

        def jellett() -> float:
            return inertia * float(top.angular_velocity @ (e * axis() - (0.0, 0.0, r)))

        first, worst, before, swept = jellett(), 0.0, axis(), 0.0
        often = steps_for(0.05, dt)  # a small part of a turn
        for _ in range(round(self.SECONDS / (often * dt))):
            world.step(often)
            now = axis()
            swept += abs(float(before[0] * now[1] - before[1] * now[0]))
            worst = max(worst, abs(jellett() / first - 1.0))
            before = now
        slack = m * G * e * e * swept * 0.5 * dt / abs(first)
        slack += solver_tolerance(solver) / (r * self.SPIN)
        yield Measurement("change of J, worst", 0.0, worst, slack)
        yield Measurement("cosine of its tilt at last", -1.0, float(now[2]), self.TILT_LEFT)
        slack += self.TILT_LEFT * e / (r + e)
        final = -first / (inertia * (r + e))
        yield Measurement("spin at last", final, float(top.angular_velocity[2]), slack, "rad/s", "relative")
