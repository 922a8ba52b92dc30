"""Union-find: which bodies belong together (Tarjan, 1975; path halving, the lower index becomes the root)."""

from __future__ import annotations

from stiction.core.jit import jit
from stiction.core.state import DYNAMIC, MOBILITY


@jit
def find_group(group, i):
    """Root of the group of body i."""
    while group[i] != i:
        group[i] = group[group[i]]
        i = group[i]
    return i


@jit
def join(group, i, j):
    """Make one group of the groups of i and j."""
    ri, rj = find_group(group, i), find_group(group, j)
    if ri < rj:
        group[rj] = ri
    elif rj < ri:
        group[ri] = rj


@jit
def join_pairs(kinds, active, count, group):
    """Join the groups of both bodies of so many pairs, ``active`` (rows: a, b, ...), where both can move."""
    for k in range(count):
        a, b = active[k, 0], active[k, 1]
        if kinds[a, MOBILITY] == DYNAMIC and kinds[b, MOBILITY] == DYNAMIC:
            join(group, a, b)
