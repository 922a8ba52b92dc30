"""Which manifolds are solved at the same time: greedy graph colouring, then blocks of eight of the same colour.

Manifolds of one colour share no body that can move, so the eight lanes of a block write eight different rows. A
manifold gets the lowest colour that neither of its bodies has yet, in the order of the sorted pairs: what it gets is a
function of its own neighbourhood, and bodies elsewhere change nothing (Catto's Box2D v3 colours alike).
"""

from __future__ import annotations

from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.state import DYNAMIC, MOBILITY

COLOURS = 63
"""A body with more contacts than this has the rest in blocks of their own, one manifold each."""


@jit
def colour_manifolds(active, m, kinds, used, sizes):
    """Give each of the m active manifolds (rows: a, b, slot, colour) its colour; returns the number of blocks.

    ``used`` (n,) int64 is scratch, ``sizes`` (COLOURS + 1,) gets the number of manifolds of each colour.
    """
    for c in range(COLOURS + 1):
        sizes[c] = 0
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
        active[k, 3] = c
        sizes[c] += 1
    blocks = sizes[COLOURS]
    for c in range(COLOURS):
        blocks += (sizes[c] + LANES - 1) // LANES
    return blocks


@jit
def fill_blocks(active, m, sizes, starts, index, count):
    """Write the rows of bodies and manifolds into the lanes of ``count`` blocks, colour by colour.

    Rows count from 1: row 0 is nobody's, and fills the lanes that are left over.
    """
    for i in range(3 * count):
        for lane in range(LANES):
            index[i, lane] = 0
    place = 0
    for c in range(COLOURS):
        starts[c] = place
        place += (sizes[c] + LANES - 1) // LANES * LANES
    starts[COLOURS] = place
    for k in range(m):
        c = active[k, 3]
        i, lane = starts[c] // LANES, starts[c] % LANES
        starts[c] += 1 if c < COLOURS else LANES
        index[i, lane] = active[k, 0] + 1
        index[i + count, lane] = active[k, 1] + 1
        index[i + 2 * count, lane] = active[k, 2] + 1
