"""What is left out as nothing would come of it: pairs that are not due, and passes over manifolds that are open."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.core import soft_rows as s
from stiction.core.pairs import DUE, PAIRS, SLOT

GAP, RADIUS = 1e-3, 0.5


def poured(rng: np.random.Generator, count: int) -> st.World:
    """Spheres and boxes that fall on each other, with a few that are thrown."""
    world = st.World(sleeping=False)
    world.add(st.Plane(), static=True)
    for i in range(count):
        x, y, z = i % 4, i // 4 % 4, i // 16
        world.add(
            st.Sphere(0.25) if i % 2 else st.Box((0.5, 0.4, 0.3)),
            position=np.array([x, y, 1 + z]) * 0.6 + rng.uniform(-0.1, 0.1, 3),
            orientation=rng.normal(size=4),
            velocity=rng.normal(size=3) * (8.0 if i % 7 == 0 else 0.5),
            angular_velocity=rng.normal(size=3),
        )
    return world


def pairs_of(world: st.World) -> np.ndarray:
    """The rows of the list of pairs."""
    cache = world._store.cache
    return np.asarray(cache.pairs[: cache.counts[PAIRS]])


@pytest.mark.parametrize("seed", range(3))
def test_pairs_that_are_not_due_have_no_points(seed: int) -> None:
    """A world in which every pair is looked at in every step ends in the same bits."""
    lazy, eager = (poured(np.random.default_rng(seed), 64) for _ in range(2))
    passed_over = 0
    for _ in range(120):
        pairs_of(eager)[:, DUE] = 0
        passed_over += np.count_nonzero(pairs_of(lazy)[:, DUE])
        lazy.step()
        eager.step()
    assert lazy.state_hash() == eager.state_hash()
    assert passed_over > 1000


def test_a_pair_is_looked_at_when_its_body_is_put_elsewhere() -> None:
    world = poured(np.random.default_rng(5), 64)
    world.step(60)
    far = next(row for row in pairs_of(world) if row[DUE] > 0 and row[0] > 0)
    pair = int(far[0]), int(far[1])  # the list's rows move
    a, b = world.bodies[pair[0]], world.bodies[pair[1]]
    b.position = a.position + np.array([0.0, 0.0, 0.3])
    world.step()
    names = {(contact["body_a"], contact["body_b"]) for contact in world.contacts()}
    assert pair in names


def couples(count: int, closing: float) -> st.World:
    """``count`` couples of spinning balls a millimetre apart, of which the last one closes, in free space."""
    world = st.World(gravity=(0, 0, 0), sleeping=False)
    for i in range(count):
        y = 3.0 * (i + 1 - count)
        speed = 0.5 * closing if i == count - 1 else 0.0
        for side in (-1.0, 1.0):
            world.add(
                st.Sphere(RADIUS),
                position=(side * (RADIUS + 0.5 * GAP), y, 0),
                velocity=(1.0 - side * speed, 0.0, 0.0),
                angular_velocity=(0.0, 0.5 * side, 0.0),
            )
    return world


def test_balls_that_do_not_meet_fly_on_as_if_alone() -> None:
    world = couples(12, 0.0)
    before = world.velocities.copy(), world.angular_velocities.copy()
    world.step(3)
    manifolds = world._store.soft.meta[pairs_of(world)[:, SLOT] + 1]
    assert np.count_nonzero(manifolds[:, s.POINTS]) == 12
    # they roll on each other where they are near, and friction without a load may be as much as the rounding of nothing
    np.testing.assert_allclose(world.velocities, before[0], rtol=0, atol=1e-26)
    np.testing.assert_allclose(world.angular_velocities, before[1], rtol=0, atol=1e-26)


@pytest.mark.parametrize("closing", [0.07, 0.1, 0.3, 2.0])
def test_who_meets_within_a_step_is_caught_beside_others_that_stay_open(closing: float) -> None:
    """The gap is a millimetre: it closes between the first substep and the last one, and the impulse is the same bits
    in a block that is full of open manifolds and in one that is empty."""
    alone, beside = couples(1, closing), couples(12, closing)
    for _ in range(6):
        alone.step()
        beside.step()
        np.testing.assert_array_equal(beside.velocities[-2:], alone.velocities)
        np.testing.assert_array_equal(beside.angular_velocities[-2:], alone.angular_velocities)
    approach = alone.velocities[0, 0] - alone.velocities[1, 0]
    assert abs(approach) < 0.05 * closing
    assert np.linalg.norm(alone.positions[1] - alone.positions[0]) > 2.0 * RADIUS - 1e-4
