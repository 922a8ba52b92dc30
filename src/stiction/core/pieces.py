"""Islands in pieces: what the nearest caches hold is solved to the end of a step before what comes next.

Bodies that touch each other, through others too, are an island; a static body joins nobody. Islands ask nothing of each
other, so all substeps of some of them can be taken before the first one of the others, and none of the bits change. A
substep of 16,000 boxes at once goes through 12 MB, eight times a step; of a piece of them, through what is still there.
All pieces are solved in the same blocks, one after the other.
"""

from __future__ import annotations

from stiction.core.islands import join
from stiction.core.jit import jit
from stiction.core.state import MOBILITY, STATIC

PIECE = 512
"""Manifolds of a piece: more only if one island has more. Blocks and rows of bodies take 0.8 kB each."""

UNCUT_FOR = 16
"""Steps that a world of one piece waits until it is looked at again: to find islands costs as much as a colour."""

NOBODY = -1
"""The island of a static body."""

FIRST, COUNT, BLOCK, BLOCKS, MOVER, MOVERS, PIECE_WIDTH = range(7)
"""Columns of the pieces: where its manifolds begin in their order, and how many they are; where the members of its
blocks begin, and how many blocks it has; where the bodies that move in it begin in their list, and how many."""


def room_for_pieces(pairs: int) -> int:
    """How many pieces so many pairs can have: of two that follow each other one is more than half full."""
    return 2 * (pairs // PIECE) + 2


@jit
def cut(kinds, n, active, count, group, sizes, ordered, pieces):
    """Cut ``count`` active manifolds (rows: a, b, slot, what it is) of n bodies into pieces; returns how many.

    With more than one, ``ordered`` has the rows of ``active`` piece by piece; within one they keep their order.
    ``group`` and ``sizes`` (n,) int64 are scratch.
    """
    for i in range(n):
        group[i], sizes[i] = NOBODY if kinds[i, MOBILITY] == STATIC else i, 0
    for k in range(count):
        a, b = active[k, 0], active[k, 1]
        if group[a] != NOBODY and group[b] != NOBODY:
            join(group, a, b)
    for i in range(n):
        if group[i] != NOBODY:
            group[i] = group[group[i]]  # roots are lower, and point to themselves by now
    for k in range(count):
        sizes[_island_of(active, k, group)] += 1

    piece = 0
    pieces[0, COUNT] = 0
    for k in range(count):
        island = _island_of(active, k, group)
        if sizes[island] > 0:
            if pieces[piece, COUNT] > 0 and pieces[piece, COUNT] + sizes[island] > PIECE:
                piece += 1
                pieces[piece, COUNT] = 0
            pieces[piece, COUNT] += sizes[island]
            sizes[island] = -piece
    place = 0
    for j in range(piece + 1):
        pieces[j, FIRST] = place
        place += pieces[j, COUNT]
    if piece > 0:
        for k in range(count):
            j = -sizes[_island_of(active, k, group)]
            place = pieces[j, FIRST]
            for c in range(active.shape[1]):
                ordered[place, c] = active[k, c]
            pieces[j, FIRST] += 1
        for j in range(piece + 1):
            pieces[j, FIRST] -= pieces[j, COUNT]
    return piece + 1


@jit
def _island_of(active, k, group):
    """The island of an active manifold: that of its body which is not static."""
    return max(group[active[k, 0]], group[active[k, 1]])
