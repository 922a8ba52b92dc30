"""Random scenes of every size, shape and mass ratio: no NaN, no crash, and no energy out of nothing.

The number of a scene is its seed. ``STICTION_FUZZ_SCENES`` says how many are tried (200), besides those in which bodies
once gained up to a thousand times what they had: needles that were turned round as they rolled fast or tumbled, and
bodies that began in each other.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

import stiction as st

ONCE_BAD = (201, 455, 491, 715, 1055, 1124, 1328, 1524, 1543, 1578, 1831, 1923, 1942, 1982, 2627, 3841, 5567, 21876)
SCENES = int(os.environ.get("STICTION_FUZZ_SCENES", "200"))
pytestmark = pytest.mark.filterwarnings("ignore::stiction.errors.IterationLimitWarning")


def shape(rng: np.random.Generator, size: float) -> st.Shape:
    """Any shape of about that size: ordinary, flat as a sheet or thin as a needle."""
    a, b, c = size * np.exp(rng.uniform(-0.7, 0.0, size=3))
    thin = rng.choice([1.0, 1.0, 0.1, 0.01])
    kind = rng.integers(7)
    if kind == 0:
        return st.Sphere(a / 2)
    if kind == 1:
        return st.Box((a, b, thin * c))
    if kind == 2:
        return st.Capsule(thin * a / 4, a)
    if kind == 3:
        return st.Cylinder(a / 2, thin * b)
    if kind == 4:
        return st.Cylinder(thin * a / 2, b)
    if kind == 5:
        return st.Ellipsoid((a / 2, b / 2, thin * c / 2))
    points = rng.normal(size=(int(rng.integers(5, 20)), 3)) * np.array([a, b, thin * c]) / 3
    return st.ConvexHull(points)


def scene(rng: np.random.Generator) -> st.World:
    """Some bodies over a floor, apart or into each other."""
    # never quite 0, so that all scenes run the same kernel
    restitution = float(rng.choice([1e-6, 1e-6, 0.5, 1.0]))
    dynamic = rng.uniform(0.0, 1.0)
    table = st.MaterialTable()
    table.set_pair(
        "default", "default", static=dynamic + rng.uniform(0.0, 0.5), dynamic=dynamic, restitution=restitution,
        rolling=float(rng.choice([1e-9, 1e-3])),
    )  # fmt: skip
    world = st.World(materials=table, sleeping=bool(rng.integers(2)))
    size = 10.0 ** rng.uniform(-3, 2)
    alike = bool(rng.integers(2))
    overlap = bool(rng.random() < 0.3)
    world.add(st.Plane(), static=True, position=(0, 0, -2 * size))
    if rng.random() < 0.3:
        world.add(st.Box((8 * size, 8 * size, size)), static=True, position=(0, 0, -2 * size))
    for k in range(int(rng.integers(2, 16))):
        own = size if alike else size * 10.0 ** rng.uniform(-1, 0)
        spread = 0.3 if overlap else 1.2
        world.add(
            shape(rng, own),
            position=size * np.array([*rng.uniform(-spread, spread, size=2), (0.2 if overlap else 1.5) * k]),
            orientation=rng.normal(size=4),
            velocity=np.sqrt(size) * rng.normal(size=3) * rng.choice([0.0, 1.0, 5.0]),
            angular_velocity=rng.normal(size=3) * rng.choice([0.0, 1.0]) / np.sqrt(size),
            mass=1000.0 * size**3 * 10.0 ** rng.uniform(-3, 3),
        )
    return world


@pytest.mark.parametrize("number", sorted({*range(SCENES), *ONCE_BAD}))
def test_a_random_scene_ends_without_nan_and_with_no_more_energy(number: int) -> None:
    world = scene(np.random.default_rng(number))
    floor = float(world.bodies[0].position[2])
    moving = [body for body in world.bodies if body.mobility == "dynamic"]

    def energy() -> float:
        """Kinetic, and potential above the floor."""
        now = world.energy()
        masses = sum(body.mass for body in moving)
        return float(now.kinetic + now.potential - masses * 9.81 * floor)

    world.step()
    start = energy()
    for _ in range(40):
        world.step(5)
        assert np.isfinite(world.positions).all() and np.isfinite(world.velocities).all()
        assert energy() <= (1.0 + 1e-5) * start
