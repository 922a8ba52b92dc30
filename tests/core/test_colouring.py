"""Colours of manifolds and blocks of eight: no two lanes of a block write the same body."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.core import state
from stiction.core.colouring import (
    COLOURS,
    FACE,
    GROUPS,
    OPEN,
    POINT,
    SLIDES,
    SORTS,
    STICKS,
    WAYS,
    colour_manifolds,
    count_blocks,
    count_rows,
    empty_blocks,
    fill_blocks,
    first_row,
    forget_colours,
)
from stiction.core.lanes import LANES
from stiction.core.soft_rows import FIELDS, MEMBERS, POINT_FIELDS

from .support import Array, compiled

PLACES = 5000
"""Rows of manifolds of a world."""

Pairs = list[tuple[int, int]]


class Coloured:
    """What the two kernels make of pairs of bodies, whose manifolds are faces that carry nothing unless ``ways`` says
    otherwise."""

    def __init__(self, pairs: Pairs, mobility: Any, worlds: int = 1, ways: Any = None, points: bool = True) -> None:
        m, n = len(pairs), len(mobility)
        kinds = state.make_bodies(n)[1]
        kinds[:, state.MOBILITY] = mobility
        self.active = np.zeros((max(m, 1), 4), np.int64)
        for k, (a, b) in enumerate(pairs):
            self.active[k, :3] = a, b, 100 + k
        sizes, starts = np.full(GROUPS, 5), np.full(WAYS * GROUPS, -7)  # of the step before
        compiled(forget_colours)(sizes, starts)
        used = np.full(n, -7)  # scratch, whatever was in it
        for _ in range(worlds):
            self.active[:m, 3] = OPEN if ways is None else ways
            compiled(colour_manifolds)(self.active, m, kinds, used, sizes, starts, points)
        self.blocks = int(compiled(count_blocks)(sizes))
        self.index = np.full((MEMBERS * self.blocks + 1, LANES), -7, np.int32)
        compiled(empty_blocks)(sizes, starts, self.index, self.blocks)
        for world in range(worlds):
            compiled(fill_blocks)(self.active, m, starts, self.index, self.blocks, world, n + 1, PLACES)
        assert (self.index[MEMBERS * self.blocks :] == -7).all()
        self.sorts: list[int] = self.index[4 * self.blocks : MEMBERS * self.blocks, 0].tolist()
        self.starts = [int(compiled(first_row)(self.index, i, self.blocks)) for i in range(self.blocks)]
        self.room = int(compiled(count_rows)(sizes, self.blocks))
        self.colours: Array = self.active[:m, 3] // (WAYS * SORTS)
        self.sizes = sizes

    def rows(self) -> list[list[tuple[int, int, int]]]:
        """(a, b, slot) of the lanes of each block, counted from 1, padding left out."""
        i = self.index[: 4 * self.blocks].reshape(4, self.blocks, LANES)
        return [[tuple(i[:3, k, lane]) for lane in range(LANES) if i[2, k, lane]] for k in range(self.blocks)]


def random_pairs(rng: np.random.Generator, n: int, m: int) -> Pairs:
    """m different pairs of n bodies, sorted as the pairs of a step are."""
    pairs: set[tuple[int, int]] = set()
    while len(pairs) < m:
        a, b = sorted(rng.choice(n, size=2, replace=False).tolist())
        pairs.add((a, b))
    return sorted(pairs)


def random_mobility(rng: np.random.Generator, n: int) -> Array:
    return np.asarray(rng.choice([state.STATIC, state.KINEMATIC, state.DYNAMIC], size=n, p=[0.1, 0.1, 0.8]))


@pytest.mark.parametrize(("n", "m"), [(2, 1), (10, 20), (60, 200), (300, 900)])
def test_no_block_has_a_movable_body_twice(rng: np.random.Generator, n: int, m: int) -> None:
    mobility = random_mobility(rng, n)
    found = Coloured(random_pairs(rng, n, m), mobility)
    for row in found.rows():
        movable = [i for a, b, _ in row for i in (a - 1, b - 1) if mobility[i] == state.DYNAMIC]
        assert len(movable) == len(set(movable))


@pytest.mark.parametrize(("n", "m"), [(2, 1), (10, 20), (60, 200), (300, 900)])
def test_every_manifold_is_in_one_lane_with_its_bodies(rng: np.random.Generator, n: int, m: int) -> None:
    pairs = random_pairs(rng, n, m)
    found = Coloured(pairs, random_mobility(rng, n))
    lanes = [lane for row in found.rows() for lane in row]
    assert len(lanes) == m
    assert {slot - 101: (a - 1, b - 1) for a, b, slot in lanes} == dict(enumerate(pairs))
    # what pads a block is nobody's in all three
    empty = found.index[2 * found.blocks : 3 * found.blocks] == 0
    assert (found.index[: found.blocks][empty] == 0).all()
    assert (found.index[found.blocks : 2 * found.blocks][empty] == 0).all()


def test_a_manifold_gets_the_lowest_colour_that_its_bodies_do_not_have(rng: np.random.Generator) -> None:
    n = 40
    pairs, mobility = random_pairs(rng, n, 150), random_mobility(rng, n)
    found, taken = Coloured(pairs, mobility), [set() for _ in range(n)]
    for (a, b), colour in zip(pairs, found.colours.tolist(), strict=True):
        bodies = [i for i in (a, b) if mobility[i] == state.DYNAMIC]
        forbidden = set().union(*(taken[i] for i in bodies))
        assert colour == min(set(range(COLOURS + 1)) - forbidden)
        for i in bodies:
            taken[i].add(colour)
    wanted = np.zeros(GROUPS, int)
    wanted[::SORTS] = np.bincount(found.colours, minlength=COLOURS + 1)
    np.testing.assert_array_equal(found.sizes, wanted)


def test_manifolds_elsewhere_change_no_colour(rng: np.random.Generator) -> None:
    """Bodies of another group before, between and after: a colour is a matter of the neighbourhood."""
    n = 30
    pairs, mobility = random_pairs(rng, n, 80), random_mobility(rng, n)
    alone = Coloured(pairs, mobility)
    # body i becomes body 2 i + 1, with other bodies at even numbers
    others = [(2 * a, 2 * b) for a, b in random_pairs(rng, n, 80)]
    ours = [(2 * a + 1, 2 * b + 1) for a, b in pairs]
    together = sorted(ours + others)
    mixed = Coloured(together, np.repeat(mobility, 2))
    colours = dict(zip(together, mixed.colours.tolist(), strict=True))
    assert [colours[pair] for pair in ours] == alone.colours.tolist()


def test_what_rests_on_the_same_floor_shares_a_colour() -> None:
    """A floor does not move: a thousand crates on it fill 125 blocks."""
    pairs = [(0, k) for k in range(1, 1001)]
    found = Coloured(pairs, [state.STATIC] + [state.DYNAMIC] * 1000)
    assert (found.colours == 0).all()
    assert found.blocks == 125


@pytest.mark.parametrize("m", [COLOURS - 1, COLOURS, COLOURS + 1, 100])
def test_a_body_with_more_contacts_than_colours_has_the_rest_one_by_one(m: int) -> None:
    """A ball in a heap of marbles: whatever has no colour left is solved alone, after the others."""
    found = Coloured([(0, k) for k in range(1, m + 1)], [state.DYNAMIC] * (m + 1))
    assert found.colours.tolist() == [min(k, COLOURS) for k in range(m)]
    assert found.blocks == m
    assert [len(row) for row in found.rows()] == [1] * m
    assert [slot for row in found.rows() for *_, slot in row] == [101 + k for k in range(m)]


def test_no_manifolds_make_no_blocks() -> None:
    found = Coloured([], [state.DYNAMIC] * 3)
    assert found.blocks == 0
    assert found.rows() == []


def test_worlds_side_by_side_share_blocks_and_keep_their_order(rng: np.random.Generator) -> None:
    n, m, worlds = 5, 6, 3
    mobility = np.full(n, state.DYNAMIC)
    pairs = random_pairs(rng, n, m)
    one, all_of_them = Coloured(pairs, mobility), Coloured(pairs, mobility, worlds)
    assert all_of_them.blocks <= worlds * one.blocks
    assert (all_of_them.sizes == worlds * one.sizes).all()
    alone = [row for block in one.rows() for row in block]
    of_world: list[list[tuple[int, int, int]]] = [[] for _ in range(worlds)]
    for row in (row for block in all_of_them.rows() for row in block):
        world = (row[2] - 1) // PLACES
        of_world[world].append((row[0] - world * (n + 1), row[1] - world * (n + 1), row[2] - world * PLACES))
    assert of_world == [alone] * worlds
    bodies = [{a for a, _, _ in block} | {b for _, b, _ in block} for block in all_of_them.rows()]
    assert all(len(both) == 2 * len(block) for both, block in zip(bodies, all_of_them.rows(), strict=True))


@pytest.mark.parametrize("worlds", [1, 3])
def test_what_does_the_same_lies_together_in_its_colour(rng: np.random.Generator, worlds: int) -> None:
    n, m = 300, 900
    pairs, mobility, ways = random_pairs(rng, n, m), random_mobility(rng, n), rng.integers(WAYS, size=m)
    plain, found = Coloured(pairs, mobility, worlds), Coloured(pairs, mobility, worlds, ways)
    assert (found.colours == plain.colours).all()
    assert found.blocks == plain.blocks
    slots = [((slot - 101) % PLACES, (slot - 101) // PLACES) for row in found.rows() for *_, slot in row]
    order = [(int(found.colours[k]), int(ways[k]), world, k) for k, world in slots]
    assert len(order) == worlds * m
    assert order == sorted(order)
    assert {way for _, way, _, _ in order} == {SLIDES, STICKS, OPEN}


@pytest.mark.parametrize("worlds", [1, 3])
def test_points_are_in_blocks_of_their_own(rng: np.random.Generator, worlds: int) -> None:
    """And what does the same lies together among them; unless all are to be solved as faces."""
    n, m = 300, 900
    pairs, mobility = random_pairs(rng, n, m), random_mobility(rng, n)
    ways = rng.integers(SORTS * WAYS, size=m)
    plain, found = Coloured(pairs, mobility, worlds), Coloured(pairs, mobility, worlds, ways)
    assert (found.colours == plain.colours).all()
    order = []
    for sort, row in zip(found.sorts, found.rows(), strict=True):
        members = [((slot - 101) % PLACES, (slot - 101) // PLACES) for *_, slot in row]
        assert {int(ways[k]) // WAYS for k, _ in members} == {sort}
        order += [(int(found.colours[k]), int(ways[k]), world, k) for k, world in members]
    assert len(order) == worlds * m
    assert order == sorted(order)
    faces = Coloured(pairs, mobility, worlds, ways, points=False)
    assert set(faces.sorts) == {FACE}
    assert faces.blocks == plain.blocks


def test_what_has_no_colour_keeps_its_order(rng: np.random.Generator) -> None:
    m = COLOURS + 50
    pairs, mobility, ways = [(0, k) for k in range(1, m + 1)], [state.DYNAMIC] * (m + 1), rng.integers(WAYS, size=m)
    found = Coloured(pairs, mobility, 1, ways)
    assert [slot for row in found.rows() for *_, slot in row] == [101 + k for k in range(m)]
    sorts = rng.integers(SORTS, size=m)
    found = Coloured(pairs, mobility, 1, WAYS * sorts + ways)
    assert [slot for row in found.rows() for *_, slot in row] == [101 + k for k in range(m)]
    assert found.sorts == sorts.tolist()
    assert POINT in found.sorts[COLOURS:]


def test_blocks_lie_one_behind_the_other(rng: np.random.Generator) -> None:
    """Those of points are shorter; but for the ones without a colour, of which nobody knows beforehand."""
    n, m = 300, 900
    ways = rng.integers(SORTS * WAYS, size=m)
    found = Coloured(random_pairs(rng, n, m), random_mobility(rng, n), 1, ways)
    widths = [POINT_FIELDS if sort == POINT else FIELDS for sort in found.sorts]
    assert found.starts == [sum(widths[:i]) for i in range(found.blocks)]
    assert found.room == sum(widths)
    assert 0 < found.sorts.count(POINT) < found.blocks

    m = COLOURS + 50
    found = Coloured([(0, k) for k in range(1, m + 1)], [state.DYNAMIC] * (m + 1), 1, np.full(m, POINT * WAYS))
    widths = [POINT_FIELDS] * COLOURS + [FIELDS] * 50
    assert found.starts == [sum(widths[:i]) for i in range(m)]
    assert found.room == sum(widths)
