"""Which pairs touch: told to whoever follows contacts from step to step, and compiled only for them.

A pair is named by one number, :data:`SHIFT` bits of the lower body above those of the higher one, so that pairs sort as
the list of pairs does.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.contact_work import load_of
from stiction.core.jit import entry
from stiction.core.overlaps import bodies_overlap
from stiction.core.pairs import PAIR_A, PAIR_B, SLOT, is_sensed

SHIFT = 32
"""Bits of the higher body's number in a pair's name."""


@entry
def loaded_pairs(pairs, count, meta, reports, names, loads):
    """Pairs that carried load in their last step: their names, sorted, and the normal impulse, N s; returns how many.

    A pair that sleeps carries what it carried when it fell asleep. ``names`` and ``loads`` have room for ``count``.
    """
    found = 0
    for k in range(count):
        row = pairs[k, SLOT] + 1
        if meta[row, s.POINTS] == 0.0:
            continue
        load = load_of(meta, reports, row)
        if load > 0.0:
            names[found], loads[found] = (pairs[k, PAIR_A] << SHIFT) | pairs[k, PAIR_B], load
            found += 1
    return found


@entry
def sensed_pairs(bodies, kinds, hulls, pairs, count, points, names):
    """Pairs with a sensor whose shapes overlap where the bodies are now: their names, sorted; returns how many."""
    found = 0
    for k in range(count):
        a, b = pairs[k, PAIR_A], pairs[k, PAIR_B]
        if is_sensed(kinds, a, b) and bodies_overlap(bodies, kinds, hulls, a, b, points):
            names[found] = (a << SHIFT) | b
            found += 1
    return found
