"""Bodies that begin in each other: they come apart, and are hardly faster for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st

GENTLE = 0.0201
"""m/s, as fast as contact may push what is deeper than its load presses it in."""

SOLVERS = ["soft", "exact"]
both = pytest.mark.parametrize("solver", SOLVERS)
shapes = pytest.mark.parametrize(
    "shape", [st.Box((1, 1, 1)), st.Sphere(0.5), st.Capsule(0.5, 1.0), st.Cylinder(0.5, 1.0)], ids=lambda s: s.kind
)


def fastest(world: st.World, seconds: float) -> float:
    """The highest speed that a body had after a step, m/s."""
    speeds = []
    for _ in range(round(seconds / world.dt)):
        world.step()
        speeds.append(np.linalg.norm(world.velocities, axis=1).max())
    return float(max(speeds))


@both
@shapes
@pytest.mark.parametrize("depth", [0.01, 0.1, 0.3])
def test_what_begins_in_the_floor_does_not_jump(solver: str, shape: st.Shape, depth: float) -> None:
    """A spring of that stiffness would throw a crate that is 10 cm deep up by 40 cm."""
    world = st.World(solver=solver)
    world.add(st.Plane(), static=True)
    height = 1.0 if isinstance(shape, st.Capsule) else 0.5  # it stands
    body = world.add(shape, density=1000, position=(0, 0, height - depth))
    assert fastest(world, 3.0) < GENTLE
    assert body.position[2] == pytest.approx(height, abs=5e-3)


@both
@shapes
def test_what_begins_in_each_other_parts_slowly_in_space(solver: str, shape: st.Shape) -> None:
    """Momentum is kept, though the two have been moved."""
    world = st.World(solver=solver, gravity=(0, 0, 0))
    a = world.add(shape, mass=1.0, position=(0, 0, 0))
    b = world.add(shape, mass=3.0, position=(0.1, 0.05, 0.8))
    middle = (a.position + 3.0 * b.position) / 4.0
    assert fastest(world, 2.0) < GENTLE
    gap = b.position - a.position
    assert np.linalg.norm(gap) > 0.9
    np.testing.assert_allclose((a.position + 3.0 * b.position) / 4.0, middle, atol=1e-5)


def test_a_light_body_between_heavy_ones_is_not_thrown() -> None:
    """Each contact in turn would push it on by as much as it pushes two alike apart."""
    world = st.World(gravity=(0, 0, 0))
    for k, mass in enumerate((1e4, 1.0, 1e4, 1.0, 1e4)):
        world.add(st.Sphere(0.5), mass=mass, position=(0.02 * k, 0.0, 0.7 * k))
    assert fastest(world, 3.0) < 5.0 * GENTLE


def test_a_deep_body_carries_a_load_as_any_other() -> None:
    """What is dug out bears what lies on it meanwhile, and a fast one is stopped."""
    world = st.World()
    world.add(st.Plane(), static=True)
    low = world.add(st.Box((1, 1, 1)), density=1000, position=(0, 0, 0.4))
    high = world.add(st.Box((1, 1, 1)), density=1000, position=(0, 0, 1.4))
    falling = world.add(st.Box((1, 1, 1)), density=1000, position=(0, 0, 3.5))
    world.step(240)
    for k, body in enumerate((low, high, falling)):
        np.testing.assert_allclose(body.position, (0, 0, 0.5 + k), atol=3e-3)
    assert np.linalg.norm(world.velocities) < 1e-3


def test_a_tilted_body_is_dug_out_without_a_spin() -> None:
    world = st.World(gravity=(0, 0, 0))
    world.add(st.Plane(), static=True)
    angle = math.radians(10.0)
    body = world.add(
        st.Box((1, 1, 1)), mass=1.0, position=(0, 0, 0.3), orientation=(math.cos(angle / 2), math.sin(angle / 2), 0, 0)
    )  # fmt: skip
    world.step(120)
    assert np.linalg.norm(body.velocity) < 2.0 * GENTLE
    assert np.linalg.norm(body.angular_velocity) < 4.0 * GENTLE
    w, x, y, z = body.orientation
    up = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
    assert body.position[2] - 0.5 * np.abs(up).sum() > -2e-3, "its lowest corner"


def test_digging_does_not_depend_on_threads_or_on_what_is_elsewhere() -> None:
    """Blocks have other neighbours then, and bodies the same bits."""

    def pile(world: st.World) -> list[st.Body]:
        rng = np.random.default_rng(5)
        return [
            world.add(st.Box((1, 1, 1)) if k % 2 else st.Sphere(0.5), density=500, position=rng.uniform(-1.2, 1.2, 3))
            for k in range(24)
        ]

    results = []
    for threads, others in ((1, 0), (2, 0), (1, 7)):
        world = st.World(threads=threads)
        world.add(st.Plane(), static=True, position=(0, 0, -2))
        for k in range(others):
            world.add(st.Box((1, 1, 1)), density=500, position=(100 + 0.7 * k, 0, -1.6))
        bodies = pile(world)
        world.step(90)
        results.append(np.array([[*b.position, *b.orientation, *b.velocity, *b.angular_velocity] for b in bodies]))
    np.testing.assert_array_equal(results[1], results[0])
    np.testing.assert_array_equal(results[2], results[0])
