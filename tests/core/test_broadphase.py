"""Sort and sweep against all pairs, and bounds against the shapes they bound."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from stiction.core import state
from stiction.core.broadphase import find_pairs, update_bounds

from .support import Array, Placed, compiled, matrix_of, random_unit

GRAVITY, DT = 9.81, 1.0 / 60.0


def random_bodies(rng: np.random.Generator, n: int, planes: int = 2) -> tuple[Array, Any]:
    """n bodies of every shape and mobility in a cube, some of which overlap, some at equal places."""
    bodies, kinds = state.make_bodies(n)
    kinds[:, state.LAYER], kinds[:, state.MASK] = 1, -1
    size = 0.4 * n ** (1 / 3)
    for i in range(n):
        shape = state.PLANE if i < planes else int(rng.choice([state.SPHERE, state.BOX]))
        mobility = int(rng.choice([state.STATIC, state.KINEMATIC, state.DYNAMIC], p=[0.2, 0.1, 0.7]))
        if shape == state.PLANE:
            mobility = state.STATIC
            bodies[i, state.SIZE : state.SIZE + 4] = *random_unit(rng), rng.normal()
        elif shape == state.SPHERE:
            bodies[i, state.SIZE] = rng.uniform(0.1, 0.5)
        else:
            bodies[i, state.SIZE : state.SIZE + 3] = rng.uniform(0.1, 0.5, size=3)
        kinds[i, :3] = shape, mobility, 0
        bodies[i, state.INVERSE_MASS] = mobility == state.DYNAMIC
        bodies[i, state.POSITION : state.POSITION + 3] = np.round(rng.uniform(-size, size, size=3), 1)
        bodies[i, state.ORIENTATION : state.ORIENTATION + 4] = random_unit(rng, 4)
        if mobility != state.STATIC:
            bodies[i, state.V : state.V + 3] = rng.normal(size=3)
            bodies[i, state.W : state.W + 3] = rng.normal(size=3)
    return bodies, kinds


def pairs_of(bodies: Array, kinds: Any, order: Any, room: int = 4096) -> set[tuple[int, int]]:
    """What the broad phase finds; ``order`` is kept from call to call."""
    n = len(bodies)
    compiled(update_bounds)(bodies, kinds, n, GRAVITY, DT)
    pairs = np.full((room, 2), -1)
    found = compiled(find_pairs)(bodies, kinds, n, order, pairs)
    assert found <= room
    result = [(int(a), int(b)) for a, b in pairs[:found]]
    assert len(set(result)) == len(result)
    assert all(a < b for a, b in result)
    return set(result)


def brute_force(bodies: Array, kinds: Any) -> set[tuple[int, int]]:
    """All pairs of which one is dynamic, and whose bounds overlap or one of which is a plane."""
    result = set()
    for i, j in itertools.combinations(range(len(bodies)), 2):
        if state.DYNAMIC not in (kinds[i, state.MOBILITY], kinds[j, state.MOBILITY]):
            continue
        low_i, high_i = bodies[i, state.BOUNDS : state.BOUNDS + 3], bodies[i, state.BOUNDS + 3 : state.BOUNDS + 6]
        low_j, high_j = bodies[j, state.BOUNDS : state.BOUNDS + 3], bodies[j, state.BOUNDS + 3 : state.BOUNDS + 6]
        planes = state.PLANE in (kinds[i, state.SHAPE], kinds[j, state.SHAPE])
        if planes or ((low_i <= high_j).all() and (low_j <= high_i).all()):
            result.add((i, j))
    return result


@pytest.mark.parametrize("n", [1, 2, 5, 40, 200])
def test_the_same_pairs_as_all_against_all(rng: np.random.Generator, n: int) -> None:
    for _ in range(5):
        bodies, kinds = random_bodies(rng, n, planes=min(2, n // 2))
        assert pairs_of(bodies, kinds, np.arange(n)) == brute_force(bodies, kinds)


def test_the_kept_order_stays_right_while_bodies_move(rng: np.random.Generator) -> None:
    """Slowly, then a jump through all others; the order itself depends on positions alone."""
    bodies, kinds = random_bodies(rng, 60)
    order = np.arange(60)
    for step in range(30):
        moving = kinds[:, state.SHAPE] != state.PLANE
        far = 5.0 if step % 10 == 9 else 0.05
        bodies[moving, state.POSITION : state.POSITION + 3] += far * rng.normal(size=(moving.sum(), 3))
        assert pairs_of(bodies, kinds, order) == brute_force(bodies, kinds)
        fresh = rng.permutation(60)
        pairs_of(bodies, kinds, fresh)
        np.testing.assert_array_equal(order, fresh)


def test_the_bounds_hold_the_shape_wherever_it_can_be_at_the_end_of_the_step(rng: np.random.Generator) -> None:
    """Corners of the turned box, at the velocity it has, with what gravity adds."""
    bodies, kinds = random_bodies(rng, 100)
    compiled(update_bounds)(bodies, kinds, 100, GRAVITY, DT)
    for i in np.flatnonzero(kinds[:, state.SHAPE] != state.PLANE):
        row = bodies[i]
        placed = Placed(
            int(kinds[i, state.SHAPE]),
            tuple(row[state.SIZE : state.SIZE + 3]),
            row[state.POSITION : state.POSITION + 3],
            row[state.ORIENTATION : state.ORIENTATION + 4],
        )
        low, high = row[state.BOUNDS : state.BOUNDS + 3], row[state.BOUNDS + 3 : state.BOUNDS + 6]
        if placed.shape == state.BOX:
            points = placed.corners()
        else:
            points = np.asarray(placed.position) + placed.size[0] * np.vstack([np.eye(3), -np.eye(3)])
        assert (points >= low).all()
        assert (points <= high).all()

        mobility = kinds[i, state.MOBILITY]
        if mobility == state.STATIC:
            continue
        v = row[state.V : state.V + 3] + (mobility == state.DYNAMIC) * GRAVITY * DT * random_unit(rng)
        w = row[state.W : state.W + 3] * DT
        angle = np.linalg.norm(w)
        q = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * w / angle)])
        arms = (points - placed.position) @ matrix_of(q).T if placed.shape == state.BOX else points - placed.position
        later = placed.position + v * DT + arms
        assert (later >= low).all()
        assert (later <= high).all()


def test_too_little_room_is_counted_and_not_written_over(rng: np.random.Generator) -> None:
    bodies, kinds = random_bodies(rng, 80)
    n, order = len(bodies), np.arange(80)
    wanted = len(pairs_of(bodies, kinds, order.copy()))
    assert wanted > 20
    backing = np.full((30, 2), -7)
    assert compiled(find_pairs)(bodies, kinds, n, order, backing[:10]) == wanted
    assert (backing[10:] == -7).all()
    assert (backing[:10] >= 0).all()
