"""Islands in pieces: no island is cut, and no bit depends on it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import stiction as st
from stiction.core.pieces import COUNT, FIRST, PIECE, PIECE_WIDTH, cut, room_for_pieces
from stiction.core.state import DYNAMIC, KINDS_WIDTH, MOBILITY, STATIC
from stiction.errors import SimulationError

from .support import compiled


@pytest.mark.parametrize("seed", range(6))
def test_cut_keeps_islands_whole_and_in_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, count = 3000, int(rng.integers(600, 4000))
    kinds = np.zeros((n, KINDS_WIDTH), np.int64)
    kinds[:, MOBILITY] = np.where(rng.random(n) < 0.1, STATIC, DYNAMIC)
    near = int(rng.integers(2, 40))
    a = rng.integers(0, n - near, count)
    b = a + rng.integers(1, near, count)
    moves = kinds[:, MOBILITY] != STATIC
    a, b = (x[moves[a] | moves[b]] for x in (a, b))
    active = np.column_stack((a, b, np.arange(len(a)), np.zeros(len(a), np.int64)))
    count = len(active)
    ordered, pieces = np.zeros_like(active), np.zeros((room_for_pieces(count), PIECE_WIDTH), np.int64)
    lists = np.zeros((2, n), np.int64)
    made = compiled(cut)(kinds, n, active, count, lists[0], lists[1], ordered, pieces)

    both = moves[a] & moves[b]
    graph = coo_array((np.ones(both.sum()), (a[both], b[both])), shape=(n, n))
    _, island = connected_components(graph, directed=False)
    of = np.where(moves[active[:, 0]], island[active[:, 0]], island[active[:, 1]])
    sizes = np.bincount(of)
    assert pieces[:made, COUNT].sum() == count
    if made == 1:
        assert sizes.max() > PIECE or count <= PIECE or np.count_nonzero(sizes) == 1
        return
    home: dict[int, int] = {}
    rows: list[int] = []
    for k, (first, size) in enumerate(pieces[:made, [FIRST, COUNT]].tolist()):
        here = ordered[first : first + size, 2]
        assert (np.diff(here) > 0).all()
        rows.extend(here.tolist())
        inside = np.unique(of[here])
        assert size <= PIECE or len(inside) == 1
        for one in inside.tolist():
            assert home.setdefault(one, k) == k
    assert sorted(rows) == list(range(count))


def columns(count: int, threads: int = 1) -> st.World:
    """Columns of three boxes, a few of them on a turning plate."""
    world = st.World(threads=threads, sleeping=False)
    world.add(st.Plane(), static=True)
    plate = world.add(st.Box((12.0, 12.0, 0.2)), position=(0.0, 0.0, 0.5), kinematic=True)
    plate.angular_velocity = (0.0, 0.0, 0.2)
    for k in range(count):
        row, place = divmod(k, 40)
        x, y, base = (2.0 * place - 4.0, 2.0 * row - 2.0, 0.6) if k < 3 else (2.0 * place - 40.0, 2.0 * row + 12.0, 0.0)
        for level in range(3):
            world.add(st.Box((1.0, 1.0, 1.0)), position=(x, y, base + level + 0.5), velocity=(0.01 * (k % 7), 0.0, 0.0))
    return world


def test_a_column_has_the_bits_that_it_has_alone() -> None:
    many, few = columns(400), columns(20)
    for world in (many, few):
        world.step(40)
    n = len(few.bodies)
    assert many.residual() == pytest.approx(few.residual(), rel=1e-2)
    np.testing.assert_array_equal(many.positions[:n], few.positions)
    np.testing.assert_array_equal(many.velocities[:n], few.velocities)
    np.testing.assert_array_equal(many.angular_velocities[:n], few.angular_velocities)


def test_pieces_are_the_same_with_two_threads() -> None:
    hashes = []
    for threads in (1, 2):
        world = columns(400, threads)
        world.step(40)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


def test_a_world_that_blows_up_goes_back_whole() -> None:
    """A piece before the one with the body that is pushed too hard has been solved by then."""
    world = columns(400)
    world.step(20)
    before = [a.copy() for a in (world.positions, world.orientations, world.velocities, world.angular_velocities)]
    friction = world.energy().friction
    world.bodies[-1].apply_force((1e38, 0.0, 0.0))
    with pytest.raises(SimulationError, match="no longer finite"):
        world.step()
    for kept, now in zip(
        before, (world.positions, world.orientations, world.velocities, world.angular_velocities), strict=True
    ):
        np.testing.assert_array_equal(now, kept)
    assert world.energy().friction == friction
    world.step(20)
    assert world.steps == 40
    assert np.isfinite(world.positions).all()
