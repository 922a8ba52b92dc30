"""Which manifolds are solved at the same time: greedy graph colouring, then blocks of eight of the same colour.

Manifolds of one colour share no body that can move, so the eight lanes of a block write eight different rows. A
manifold gets the lowest colour that neither of its bodies has yet, in the order of the sorted pairs: what it gets is a
function of its own neighbourhood, and bodies elsewhere change nothing (Catto's Box2D v3 colours alike).

Within a colour the order is free, for a lane asks nothing of the others. So manifolds that want the same work lie
together: a block in which nothing slides, or nothing carries a load, leaves out what only others would need.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.state import DYNAMIC, MOBILITY

COLOURS = 63
"""A body with more contacts than this has the rest in blocks of their own, one manifold each."""
SLIDES, STICKS, OPEN, WAYS = range(4)
"""What a manifold did in the step before, in the order in which they lie within a colour: slide under a load; stick
under one; carry none."""


@jit
def colour_manifolds(active, m, kinds, used, sizes, starts):
    """Give each of the m active manifolds (rows: a, b, slot, what it did) its colour, and count it in ``sizes``
    (COLOURS + 1,), and with what it did in ``starts`` (WAYS x (COLOURS + 1),). ``used`` (n,) int64 is scratch. The
    last column becomes its place: WAYS x colour + what it did.

    Colours in use come first: whoever has one has neighbours with all lower ones.
    """
    for k in range(m):
        a, b = active[k, 0], active[k, 1]
        used[a] = used[b] = 0
    for k in range(m):
        a, b = active[k, 0], active[k, 1]
        taken = (used[a] if kinds[a, MOBILITY] == DYNAMIC else 0) | (used[b] if kinds[b, MOBILITY] == DYNAMIC else 0)
        c = 0
        while c < COLOURS and (taken >> c) & 1:
            c += 1
        if c < COLOURS:
            used[a] |= 1 << c
            used[b] |= 1 << c
        # what has no colour shares bodies, and keeps its order
        place = WAYS * c + (active[k, 3] if c < COLOURS else 0)
        active[k, 3] = place
        starts[place] += 1
        sizes[c] += 1


@jit
def way_of(manifolds, row):
    """What a manifold did in the step before."""
    load = manifolds[row, s.LOAD] + manifolds[row, s.LOAD + 1] + manifolds[row, s.LOAD + 2]
    if load + manifolds[row, s.LOAD + 3] > 0.0:
        return SLIDES if manifolds[row, s.STATE] == s.SLIDING else STICKS
    return OPEN


@jit
def forget_colours(sizes, starts):
    """Count no manifold."""
    for c in range(COLOURS + 1):
        sizes[c] = 0
    for place in range(WAYS * (COLOURS + 1)):
        starts[place] = 0


@jit
def count_colours(sizes):
    """How many colours are in use."""
    colours = 0
    while colours < COLOURS and sizes[colours] > 0:
        colours += 1
    return colours


@jit
def count_blocks(sizes):
    """How many blocks so many manifolds of each colour fill."""
    blocks = sizes[COLOURS]
    for c in range(count_colours(sizes)):
        blocks += (sizes[c] + LANES - 1) // LANES
    return blocks


@jit
def empty_blocks(sizes, starts, index, count):
    """``count`` blocks with nobody in them, and where in each colour begins what did the same, instead of how much.

    Rows count from 1: row 0 is nobody's, and fills the lanes that are left over.
    """
    for i in range(4 * count):
        for lane in range(LANES):
            index[i, lane] = 0
    place = 0
    for c in range(count_colours(sizes)):
        lane = place
        for k in range(WAYS * c, WAYS * (c + 1)):
            here = starts[k]
            starts[k] = lane
            lane += here
        place += (sizes[c] + LANES - 1) // LANES * LANES
    starts[WAYS * COLOURS] = place


@jit
def fill_blocks(active, m, starts, index, count, world, bodies, manifolds):
    """Write the rows of bodies and manifolds of a world into the lanes of its colours; of those of several worlds,
    which lie one after the other, it has so many."""
    for k in range(m):
        place = active[k, 3]
        i, lane = starts[place] // LANES, starts[place] % LANES
        starts[place] += 1 if place < WAYS * COLOURS else LANES
        index[i, lane] = world * bodies + active[k, 0] + 1
        index[i + count, lane] = world * bodies + active[k, 1] + 1
        index[i + 2 * count, lane] = world * manifolds + active[k, 2] + 1
        index[i + 3 * count, lane] = world
