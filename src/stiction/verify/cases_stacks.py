"""Stacks of soft contacts: how far they give way, and that nothing in them moves after that.

Only ``soft`` is asked, for these are its springs, and targets that it was made for; ``tower-of-ten`` and
``heavy-on-light`` have both solvers side by side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import Array, G, about, box_compliance, make_world, substep

CUBE = (1.0, 1.0, 1.0)


class SinkOfSoftContacts(Case):
    """What a contact gives way by is no accident: it is a spring whose stiffness follows from masses and dt."""

    name = "sink-of-soft-contacts"
    title = "a body sinks into what carries it by its load over the stiffness of their contact"
    formula = "s = load / (m_c omega^2), 1 / m_c = c sum 1 / m, omega h = 0.65 (1.3 on what cannot move), h = dt / 8"
    source = (
        "Hooke's law; Catto, 'Soft constraints', GDC 2011; c is 1 for a ball and for the even load of a cube's corners"
    )
    tolerance = "1 % and 1e-8 m (dropped), 1e-8 m (put down)"
    tolerance_reason = (
        "arms are those of the start of a step, and penetrations shorten them by s / size; single precision holds gaps "
        "of millimetres to 1e-9 m. What is put down without a fall has the load of its contact found before it moves, "
        "and its springs are set up so that they carry it where it is"
    )
    solvers = ("soft",)
    FALL: ClassVar = 2e-4
    """m"""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """A ball, a thin sheet, a tower of ten, a ton on 10 kg; none may sleep before it is down."""
        stiff = G * (substep(solver, dt) / 1.3) ** 2
        sheet = (1.0, 1.0, 0.02)
        for fall in (0.0, self.FALL):
            world = make_world(solver, dt, static=0.6, sleeping=False)
            world.add(st.Plane(), static=True)
            ball = world.add(st.Sphere(0.2), position=(0, 0, 0.2 + fall))
            flat = world.add(st.Box(sheet), position=(5, 0, 0.01 + fall))
            # the top of a tower touches only when all below it is down
            tower = [world.add(st.Box(CUBE), position=(10, 0, k + 0.5 + (k + 1) * fall)) for k in range(10)]
            world.run(10.0)
            sunk = [0.2 - float(ball.position[2]), 0.01 - float(flat.position[2])]
            expected = [0.0, 0.0] if fall == 0.0 else [stiff, box_compliance(sheet) * stiff]
            how = "put down" if fall == 0.0 else "dropped"
            for what, s, measured in zip(("a ball", "a thin sheet"), expected, sunk, strict=True):
                yield Measurement(f"{what} that is {how}", s, measured, 0.01 * s + 1e-8, "m")
        # k cubes on a cube: load k m g, 1 / m_c = 2 / m, and a spring four times as soft as on the floor
        s = sum(8.0 * k * stiff for k in range(1, 10)) + 10.0 * stiff
        top = 9.5 - float(tower[-1].position[2])
        yield Measurement("the top of a tower of ten cubes, dropped", s, top, 0.01 * s + 1e-8, "m")

        world = make_world(solver, dt, static=0.6, sleeping=False)
        world.add(st.Plane(), static=True)
        world.add(st.Box(CUBE), mass=10.0, position=(0, 0, 0.5 + self.FALL))
        heavy = world.add(st.Box(CUBE), mass=1000.0, position=(0, 0, 1.5 + 2.0 * self.FALL))
        world.run(10.0)
        # masses that differ by more than 30 take half the substep
        s = (4.0 * 101.0 + 101.0) * stiff / 4.0
        yield Measurement("1000 kg on 10 kg, dropped", s, 1.5 - float(heavy.position[2]), 0.01 * s + 1e-8, "m")


class CrookedTower(Case):
    """Real towers are never straight."""

    name = "crooked-tower"
    title = "a tower of ten cubes stands although each was put down 5 mm and 0.05 rad askew"
    formula = "v = 0: the centre of mass of what lies above stays over each face"
    source = "statics"
    tolerance = "1 mm/s (speed), 10 mm (drift)"
    tolerance_reason = (
        "targets: after ten seconds the tower must be at rest, and leaning by no more than a cube's hundredth"
    )
    solvers = ("soft", "exact")
    SEEDS: ClassVar = (1, 2, 3, 4)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Four towers, normal deviates of 5 mm along either axis and 0.05 rad about the vertical."""
        for seed in self.SEEDS:
            world = make_world(solver, dt, static=0.6)
            world.add(st.Plane(), static=True)
            random = np.random.default_rng(seed)
            for k in range(10):
                x, y = 0.005 * random.standard_normal(2)
                yaw = about((0, 0, 1), 0.05 * float(random.standard_normal()))
                world.add(st.Box(CUBE), position=(x, y, k + 0.5), orientation=yaw)
            starts = world.positions.copy()
            world.run(10.0)
            yield Measurement(f"fastest cube at 10 s, seed {seed}", 0.0, fastest_of(world), 1e-3, "m/s")
            yield Measurement(f"farthest drift sideways, seed {seed}", 0.0, drift_of(world, starts), 0.01, "m")


class Pyramid(Case):
    """210 cubes."""

    name = "pyramid"
    title = "a pyramid of twenty cubes at its base stands"
    formula = "v = 0"
    source = "statics"
    tolerance = "1 mm/s (speed), 10 mm (drift)"
    tolerance_reason = "targets, as for 'crooked-tower'"
    solvers = ("soft", "exact")
    BASE: ClassVar = 20
    SECONDS: ClassVar = 20.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Twenty seconds; cubes of a row are 5 cm apart."""
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        for row in range(self.BASE):
            for k in range(self.BASE - row):
                world.add(st.Box(CUBE), position=(1.05 * (k + 0.5 * row), 0.0, row + 0.5))
        starts = world.positions.copy()
        world.run(self.SECONDS)
        yield Measurement(f"fastest cube at {self.SECONDS:g} s", 0.0, fastest_of(world), 1e-3, "m/s")
        yield Measurement("farthest drift sideways", 0.0, drift_of(world, starts), 0.01, "m")


class HeavyOnTop(Case):
    """The ratio of masses that impulse solvers fail at, over a height."""

    name = "heavy-on-top"
    title = "five cubes stand, the top one a hundred times as heavy as each of the others"
    formula = "v = 0"
    source = "statics"
    tolerance = "1 mm/s (speed), 1 mm (drift), 20 mm (sinking)"
    tolerance_reason = "targets; the springs give way by 18.6 mm at dt = 1/60 s, as 'sink-of-soft-contacts' has it"
    solvers = ("soft", "exact")

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cubes of 1 m, 10 kg each, and one of 1000 kg, for 10 s."""
        world = make_world(solver, dt, static=0.6)
        world.add(st.Plane(), static=True)
        for k in range(5):
            world.add(st.Box(CUBE), mass=1000.0 if k == 4 else 10.0, position=(0, 0, k + 0.5))
        starts = world.positions.copy()
        world.run(10.0)
        yield Measurement("fastest cube at 10 s", 0.0, fastest_of(world), 1e-3, "m/s")
        yield Measurement("farthest drift sideways", 0.0, drift_of(world, starts), 1e-3, "m")
        sunk = float(starts[5, 2] - world.positions[5, 2])
        yield Measurement("how far the top has sunk", 0.0, sunk, 0.02, "m")


def fastest_of(world: st.World) -> float:
    """Speed of the fastest body, m/s."""
    return float(np.max(np.linalg.norm(world.velocities, axis=1)))


def drift_of(world: st.World, starts: Array) -> float:
    """How far the body that has moved most has moved sideways, m; infinite if one has fallen by half a cube."""
    moved = world.positions - starts
    if float(np.min(moved[1:, 2])) < -0.5:
        return math.inf
    return float(np.max(np.linalg.norm(moved[1:, :2], axis=1)))
