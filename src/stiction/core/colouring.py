"""Which manifolds are solved at the same time: greedy graph colouring, then blocks of eight of the same colour.

Manifolds of one colour share no body that can move, so the eight lanes of a block write eight different rows. A
manifold gets the lowest colour that neither of its bodies has yet, in the order of the sorted pairs: what it gets is a
function of its own neighbourhood, and bodies elsewhere change nothing (Catto's Box2D v3 colours alike).

Within a colour the order is free, for a lane asks nothing of the others. So points and faces, which are solved
differently, are in blocks of their own; and manifolds that want the same work lie together: a block in which nothing
slides, or nothing carries a load, leaves out what only others would need.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import row_number
from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.state import DYNAMIC, MOBILITY

COLOURS = 63
"""A body with more contacts than this has the rest in blocks of their own, one manifold each."""
FACE, POINT, SORTS = range(3)
"""What a manifold is: a face that resists turning, or a single point without any such resistance."""
SLIDES, STICKS, OPEN, WAYS = range(4)
"""What a manifold did in the step before, in the order in which they lie within a colour: slide under a load; stick
under one; carry none."""
GROUPS = SORTS * COLOURS + 1
"""Manifolds of a colour and a sort; the last group are those that have no colour."""


@jit
def colour_manifolds(active, m, kinds, used, sizes, starts, points):
    """Give each of the m active manifolds (rows: a, b, slot, what it is and did) its colour, and count its group in
    ``sizes`` (GROUPS,), and with what it did in ``starts`` (WAYS x GROUPS,). ``used`` (n,) int64 is scratch. The last
    column becomes its place: WAYS x group + what it did. Unless there are ``points``, all are solved as faces.

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
        what = active[k, 3] if points else active[k, 3] % WAYS
        place = WAYS * SORTS * c + what
        if c == COLOURS:
            # what has no colour shares bodies, and keeps its order
            place = WAYS * SORTS * COLOURS
            active[k, 3] = place + what // WAYS
        else:
            active[k, 3] = place
        starts[place] += 1
        sizes[place // WAYS] += 1


@jit
def way_of(manifolds, row):
    """What a manifold is and did in the step before: WAYS x sort + way."""
    load = manifolds[row, s.LOAD] + manifolds[row, s.LOAD + 1] + manifolds[row, s.LOAD + 2]
    way = OPEN
    if load + manifolds[row, s.LOAD + 3] > 0.0:
        way = SLIDES if manifolds[row, s.STATE] == s.SLIDING else STICKS
    turns = manifolds[row, s.TORSIONAL] + manifolds[row, s.ROLLING] == 0.0
    return WAYS * (POINT if manifolds[row, s.COUNT] == 1.0 and turns else FACE) + way


@jit
def forget_colours(sizes, starts):
    """Count no manifold."""
    for group in range(GROUPS):
        sizes[group] = 0
    for place in range(WAYS * GROUPS):
        starts[place] = 0


@jit
def count_colours(sizes):
    """How many colours are in use."""
    colours = 0
    while colours < COLOURS and sizes[SORTS * colours + FACE] + sizes[SORTS * colours + POINT] > 0:
        colours += 1
    return colours


@jit
def blocks_of_colour(sizes, c):
    """How many blocks so many manifolds of a colour fill."""
    faces, points = sizes[SORTS * c + FACE], sizes[SORTS * c + POINT]
    return blocks_for(faces) + blocks_for(points)


@jit
def blocks_for(manifolds):
    """How many blocks so many manifolds fill that may lie side by side."""
    return (manifolds + LANES - 1) // LANES


@jit
def count_blocks(sizes):
    """How many blocks so many manifolds of each group fill."""
    blocks = sizes[GROUPS - 1]
    for c in range(count_colours(sizes)):
        blocks += blocks_of_colour(sizes, c)
    return blocks


@jit
def count_rows(sizes, blocks):
    """How many rows so many blocks have, whose manifolds are these."""
    points = 0
    for c in range(count_colours(sizes)):
        points += blocks_for(sizes[SORTS * c + POINT])
    return (blocks - points) * s.FIELDS + points * s.POINT_FIELDS


@jit
def empty_blocks(sizes, starts, index, count):
    """``count`` blocks with nobody in them, and where in each group begins what did the same, instead of how much.

    Rows count from 1: row 0 is nobody's, and fills the lanes that are left over.
    """
    for i in range(s.MEMBERS * count):
        for lane in range(LANES):
            index[i, lane] = 0
    place, row = 0, 0
    for group in range(SORTS * count_colours(sizes)):
        lane = place
        for k in range(WAYS * group, WAYS * (group + 1)):
            here = starts[k]
            starts[k] = lane
            lane += here
        blocks = blocks_for(sizes[group])
        for i in range(place // LANES, place // LANES + blocks):
            index[i + 4 * count, 0], index[i + 4 * count, 1] = group % SORTS, row
            row += s.POINT_FIELDS if group % SORTS == POINT else s.FIELDS
        place += blocks * LANES
    starts[WAYS * (GROUPS - 1)] = place
    for i in range(place // LANES, count):
        index[i + 4 * count, 1] = row
        row += s.FIELDS


@jit
def fill_blocks(active, m, starts, index, count, world, bodies, manifolds):
    """Write the rows of bodies and manifolds of a world into the lanes of its colours; of those of several worlds,
    which lie one after the other, it has so many."""
    for k in range(m):
        place = active[k, 3]
        alone = place >= WAYS * (GROUPS - 1)
        cursor = WAYS * (GROUPS - 1) if alone else place
        i, lane = starts[cursor] // LANES, starts[cursor] % LANES
        starts[cursor] += LANES if alone else 1
        index[i, lane] = world * bodies + active[k, 0] + 1
        index[i + count, lane] = world * bodies + active[k, 1] + 1
        index[i + 2 * count, lane] = world * manifolds + active[k, 2] + 1
        index[i + 3 * count, lane] = world
        if alone:
            index[i + 4 * count, 0] = place - cursor


@jit
def first_row(index, i, count):
    """Where block i, of ``count``, begins among the rows of all."""
    return row_number(index[i + 4 * count, 1])


@jit
def is_point_block(index, i, count):
    """Whether the manifolds of block i, of ``count``, are points."""
    return index[i + 4 * count, 0] == POINT
