"""Slots: rows for what belongs to pairs that touch, given when they begin to and taken back when they end.

Several workers look at pairs at the same time, and which of them comes first must not matter: so they say only what
they saw, and slots change hands afterwards, in the order of the pairs.
"""

from __future__ import annotations

from stiction.core.jit import jit
from stiction.core.manifolds import clear_manifold
from stiction.core.pairs import FREE, SLOTS, drop_slot, give_slot

FOUND, DUE_LIST, LOOKED_WIDTH = range(3)
"""Columns of what is noted of the pairs in a step: what was found of each; and a list of those to be looked at."""

NOTHING, WANTS, LOST = 0, -1, -2
"""What was found of a pair: no points; points, but it has no slot; no points, but it has one. Above 0 it has points and
a slot, and the number is 1 more than what it did (``colouring.way_of``)."""


@jit
def hand_out(cache, looked, npairs, soft):
    """Take back the slots of pairs that no longer touch, and give some to those that begin to.

    Returns how many these are, and for how many slots there has to be room: if that is more than there is, none of them
    has got one.
    """
    wanted = 0
    for k in range(npairs):
        if looked[k, FOUND] == LOST:
            drop_slot(cache, k)
            looked[k, FOUND] = NOTHING
        wanted += looked[k, FOUND] == WANTS
    needed = cache.counts[SLOTS] + max(0, wanted - cache.counts[FREE])
    if 0 < wanted and needed <= cache.free.shape[0]:
        for k in range(npairs):
            if looked[k, FOUND] == WANTS:
                clear_manifold(soft.manifolds, soft.meta, soft.reports, give_slot(cache, k) + 1)
    return wanted, needed
