"""Which bodies are near each other: a sorted list of pairs that lives from step to step.

Every bounded body has a fat box in a tree (Catto's Box2D does the same). As long as its bounds stay inside, nothing is
done for it; when they leave, it gets a new fat box, grown ahead along its motion, and only then are its pairs looked at
again. A pair lives while the fat boxes overlap. Most never touch, and all that is known of those is in the list
(``apart.py``); the others have a slot as long as they touch (``slots.py``): what belongs to them (contact points,
impulses) stays in row ``slot`` of other arrays.

The set of pairs and their order are functions of the boxes alone, not of the tree's shape; a body that meets nobody
changes nothing for the others. Planes have no bounds and are not in the tree: a body meets a plane when its fat box
reaches it.

Costs for bodies that rest in columns: 4 ns each to see that nothing moved; 2 us for a body that left its box.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction.core.jit import jit
from stiction.core.memory import refilled, zeros
from stiction.core.state import (
    BOUNDS,
    DYNAMIC,
    LAYER,
    MASK,
    MOBILITY,
    ORIENTATION,
    PLANE,
    POSITION,
    SENSOR,
    SHAPE,
    SIZE,
    STATIC,
    V,
    W,
)
from stiction.core.tree import NONE, move, nodes_overlap, query, remove
from stiction.core.vec import dot, length, quat, rotation, vec3

FAT = 0.05
"""A fat box is larger than the bounds by this part of their longest side, on every side, ..."""
AHEAD = 3.0
"""... and reaches as far ahead as the body goes in so many steps."""
LOOSE = 3.0
"""A fat box with so many times the room that a new one would have is replaced: the body was fast and has slowed."""

PAIR_A, PAIR_B, SLOT, DUE, SEEN, HINT, PAIR_WIDTH = range(7)
"""Columns of a list of pairs: the bodies, lower one first; the row in which is kept what belongs to a pair that
touches, or NONE; and of one that does not, how far its bodies may have moved until it has to be looked at, how far they
had moved when it was, and the direction that was found (``apart.py``); 0 of a pair that is new."""

PAIRS, BEGUN, ENDED, SLOTS, FREE, TOUCHED, MOVED, PLANES, COUNTS_WIDTH = range(9)
"""Entries of a cache's counts: rows in use of pairs, begun and ended; slots ever handed out; free slots; bodies to be
looked at whether they moved or not; bodies whose pairs have to be looked at; planes."""

TOUCHED_LIST, MOVED_LIST, PLANES_LIST, FOUND, STACK, LISTS_WIDTH = range(6)
"""Rows of a cache's lists: the bodies that are touched, moved, and planes; scratch of queries."""

IS_TOUCHED, IS_MOVED, IS_PLANE, WAS_GOING = 1, 2, 4, 8
"""Bits of a body's mark: on the three lists; a plane that was moving when it was last looked at."""


class PairCache(NamedTuple):
    """The pairs of n bodies, with room for p of them, of which m touch."""

    pairs: np.ndarray  # (p, PAIR_WIDTH) int64 all pairs, sorted by a, then b
    begun: np.ndarray  # (p, 2) int32 bodies of those that are new since the update before, sorted
    ended: np.ndarray  # (p,) int32 rows that those had which are gone since then, in their order
    free: np.ndarray  # (m,) int64 stack of free slots
    marks: np.ndarray  # (n,) uint8
    lists: np.ndarray  # (LISTS_WIDTH, n) int64
    counts: np.ndarray  # (COUNTS_WIDTH,) int64


def make_pair_cache(n: int, p: int, m: int) -> PairCache:
    """No pairs yet, with room for n bodies and p pairs, of which m touch."""
    return PairCache(
        pairs=zeros((p, PAIR_WIDTH), np.int64),
        begun=zeros((p, 2), np.int32),
        ended=np.zeros(p, np.int32),
        free=np.zeros(m, np.int64),
        marks=np.zeros(n, np.uint8),
        lists=np.zeros((LISTS_WIDTH, n), np.int64),
        counts=np.zeros(COUNTS_WIDTH, np.int64),
    )


def resize_pair_cache(cache: PairCache, n: int, p: int, m: int) -> PairCache:
    """The same pairs with room for n bodies and p pairs, of which m touch, in new arrays."""
    resized: PairCache = refilled(make_pair_cache(n, p, m), cache)
    return resized


# --- who may meet whom ------------------------------------------------------------------------------------------------


@jit
def layers_agree(kinds, a, b):
    """Whether a layer of each body is in the other one's mask."""
    return kinds[a, LAYER] & kinds[b, MASK] != 0 and kinds[b, LAYER] & kinds[a, MASK] != 0


@jit
def is_sensed(kinds, a, b):
    """Whether one of the two is a sensor: such a pair overlaps and pushes nothing."""
    return kinds[a, SENSOR] | kinds[b, SENSOR] != 0


@jit
def may_meet(kinds, a, b):
    """Whether bodies a and b are a pair when they are near each other. The only place that decides this.

    Layers have to agree, and one of the two has to be dynamic, or a sensor where the other one moves; sensors do not
    see each other. What this reads may change only for a body that is then touched: its pairs are looked at again.
    """
    if not layers_agree(kinds, a, b):
        return False
    if kinds[a, SHAPE] == PLANE and kinds[b, SHAPE] == PLANE:
        return False
    if kinds[a, SENSOR] != 0 and kinds[b, SENSOR] != 0:
        return False
    if kinds[a, MOBILITY] == DYNAMIC or kinds[b, MOBILITY] == DYNAMIC:
        return True
    return (kinds[a, SENSOR] != 0 and kinds[b, MOBILITY] != STATIC) or (
        kinds[b, SENSOR] != 0 and kinds[a, MOBILITY] != STATIC
    )


@jit
def _is_going(bodies, i):
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    return dot(v, v) + dot(w, w) > 0.0


@jit
def _reaches_plane(tree, bodies, i, plane, dt):
    """Whether the fat box of body i reaches into a plane's half space, wherever the plane is ``AHEAD`` steps on."""
    boxes, leaf = tree.boxes, tree.leaf[i]
    low, high = vec3(boxes, leaf, 0), vec3(boxes, leaf, 3)
    center, half = (low + high) * 0.5, (high - low) * 0.5
    arm = center - vec3(bodies, plane, POSITION)
    n = rotation(quat(bodies, plane, ORIENTATION)) @ vec3(bodies, plane, SIZE)
    ahead = AHEAD * dt * length(vec3(bodies, plane, V))
    ahead += AHEAD * dt * length(vec3(bodies, plane, W)) * (length(arm) + length(half))
    nearest = dot(n, arm) - abs(n.x) * half.x - abs(n.y) * half.y - abs(n.z) * half.z
    return nearest <= bodies[plane, SIZE + 3] + ahead


@jit
def _are_near(tree, bodies, kinds, a, b, dt):
    """Whether a fat box overlaps another one or reaches into a plane; not both are planes."""
    if kinds[a, SHAPE] == PLANE:
        a, b = b, a
    if tree.leaf[a] == NONE:
        return False
    if kinds[b, SHAPE] == PLANE:
        return _reaches_plane(tree, bodies, a, b, dt)
    return tree.leaf[b] != NONE and nodes_overlap(tree.boxes, tree.leaf[a], tree.leaf[b])


# --- fat boxes --------------------------------------------------------------------------------------------------------


@jit
def _append(cache, count, row, bit, i):
    """Put body i on a list unless its mark says that it is there."""
    if not cache.marks[i] & bit:
        cache.marks[i] |= bit
        cache.lists[row, cache.counts[count]] = i
        cache.counts[count] += 1


@jit
def _drop(cache, count, row, bit, i):
    """Take body i off a list, and keep the order of the others."""
    if cache.marks[i] & bit:
        cache.marks[i] &= 255 - bit
        kept = 0
        for k in range(cache.counts[count]):
            other = cache.lists[row, k]
            if other != i:
                cache.lists[row, kept] = other
                kept += 1
        cache.counts[count] = kept


@jit
def _fits(tree, bodies, i, dt):
    """Whether the bounds of body i are inside its fat box, and this is not far too large."""
    leaf = tree.leaf[i]
    if leaf == NONE:
        return False
    room = longest = 0.0
    for k in range(3):
        low, high = bodies[i, BOUNDS + k], bodies[i, BOUNDS + 3 + k]
        fat_low, fat_high = tree.boxes[leaf, k], tree.boxes[leaf, k + 3]
        if not (fat_low <= low and high <= fat_high):
            return False
        room += (fat_high - fat_low) - (high - low)
        longest = max(longest, high - low)
    fair = 6.0 * FAT * longest
    if room <= LOOSE * fair:
        return True
    # only now is it worth while to fetch the velocity
    v = vec3(bodies, i, V)
    return room <= LOOSE * (fair + AHEAD * dt * (abs(v.x) + abs(v.y) + abs(v.z)))


@jit
def _refit(tree, bodies, kinds, i, dt):
    """A new fat box around the bounds of body i. Bounds that are not finite change nothing.

    A body that nothing moves needs no room to move in: a wide floor would meet all that flies above it.
    """
    low, high = vec3(bodies, i, BOUNDS), vec3(bodies, i, BOUNDS + 3)
    d = high - low
    if not (d.x < np.inf and d.y < np.inf and d.z < np.inf):
        return False
    grow = FAT * max(d.x, max(d.y, d.z)) if kinds[i, MOBILITY] != STATIC else 0.0
    way = vec3(bodies, i, V) * (AHEAD * dt)
    move(
        tree, i,
        low.x - grow + min(way.x, 0.0), low.y - grow + min(way.y, 0.0), low.z - grow + min(way.z, 0.0),
        high.x + grow + max(way.x, 0.0), high.y + grow + max(way.y, 0.0), high.z + grow + max(way.z, 0.0),
    )  # fmt: skip
    return True


@jit
def find_moved(tree, cache, bodies, kinds, awake, count, dt):
    """Give every body that left its fat box a new one; returns how many bodies' pairs have to be looked at.

    :func:`update_pairs` begins with this. Alone it brings the tree up to date for queries between steps.
    """
    counts, lists, touched = cache.counts, cache.lists, cache.counts[TOUCHED]
    for k in range(touched + count):
        is_touched = k < touched
        i = lists[TOUCHED_LIST, k] if is_touched else awake[k - touched]
        if is_touched:
            cache.marks[i] &= 255 - IS_TOUCHED
        elif _fits(tree, bodies, i, dt):
            continue
        if kinds[i, SHAPE] == PLANE:
            if is_touched:
                _append(cache, PLANES, PLANES_LIST, IS_PLANE, i)
                _append(cache, MOVED, MOVED_LIST, IS_MOVED, i)
        elif _refit(tree, bodies, kinds, i, dt):
            _append(cache, MOVED, MOVED_LIST, IS_MOVED, i)
    counts[TOUCHED] = 0
    for k in range(counts[PLANES]):
        i = lists[PLANES_LIST, k]
        going = _is_going(bodies, i)
        if going or cache.marks[i] & WAS_GOING:
            _append(cache, MOVED, MOVED_LIST, IS_MOVED, i)
            cache.marks[i] |= WAS_GOING
            if not going:
                cache.marks[i] &= 255 - WAS_GOING
    return counts[MOVED]


# --- pairs ------------------------------------------------------------------------------------------------------------


@jit
def find_pair(cache, a, b):
    """Row of the pair a < b in the list, or NONE."""
    pairs, low, high = cache.pairs, 0, cache.counts[PAIRS]
    while low < high:
        middle = (low + high) >> 1
        if pairs[middle, PAIR_A] < a or (pairs[middle, PAIR_A] == a and pairs[middle, PAIR_B] < b):
            low = middle + 1
        else:
            high = middle
    if low < cache.counts[PAIRS] and pairs[low, PAIR_A] == a and pairs[low, PAIR_B] == b:
        return low
    return NONE


@jit
def _find_ended(tree, cache, bodies, kinds, dt):
    """List the rows of the pairs of moved bodies that are no longer near each other; returns their number."""
    pairs, ended, marks, found = cache.pairs, cache.ended, cache.marks, 0
    for k in range(cache.counts[PAIRS]):
        a, b = pairs[k, PAIR_A], pairs[k, PAIR_B]
        if (marks[a] | marks[b]) & IS_MOVED and not (
            may_meet(kinds, a, b) and _are_near(tree, bodies, kinds, a, b, dt)
        ):
            ended[found] = k
            found += 1
    return found


@jit
def candidates(tree, cache, kinds, i, near):
    """Who may be near body i, which moved, without regard to planes' places; returns their number."""
    if kinds[i, SHAPE] == PLANE:
        found = 0
        for j in range(tree.leaf.shape[0]):
            if tree.leaf[j] != NONE:
                near[found] = j
                found += 1
        return found
    low, high = vec3(tree.boxes, tree.leaf[i], 0), vec3(tree.boxes, tree.leaf[i], 3)
    found = query(tree, low.x, low.y, low.z, high.x, high.y, high.z, cache.lists[STACK], near)
    for k in range(cache.counts[PLANES]):
        near[found] = cache.lists[PLANES_LIST, k]
        found += 1
    return found


@jit
def _find_begun(tree, cache, bodies, kinds, dt):
    """List the new pairs of moved bodies, unsorted; returns their number, which may exceed the room.

    If both bodies of a pair moved, the lower one lists it.
    """
    begun, lists, marks, found = cache.begun, cache.lists, cache.marks, 0
    near = lists[FOUND]
    for k in range(cache.counts[MOVED]):
        i = lists[MOVED_LIST, k]
        for m in range(candidates(tree, cache, kinds, i, near)):
            j = near[m]
            if i == j or (j < i and marks[j] & IS_MOVED):
                continue
            if may_meet(kinds, i, j) and _are_near(tree, bodies, kinds, i, j, dt):
                a, b = min(i, j), max(i, j)
                if find_pair(cache, a, b) == NONE:
                    if found < begun.shape[0]:
                        begun[found, PAIR_A], begun[found, PAIR_B] = a, b
                    found += 1
    return found


@jit
def _sort(rows, n):
    """Shell's sort of the first n rows by their first two columns; gaps by Knuth (1973)."""
    g = 1
    while g < n:
        g = 3 * g + 1
    while g > 1:
        g //= 3
        for k in range(g, n):
            a, b, i = rows[k, PAIR_A], rows[k, PAIR_B], k - g
            while i >= 0 and (rows[i, PAIR_A] > a or (rows[i, PAIR_A] == a and rows[i, PAIR_B] > b)):
                rows[i + g, PAIR_A], rows[i + g, PAIR_B] = rows[i, PAIR_A], rows[i, PAIR_B]
                i -= g
            rows[i + g, PAIR_A], rows[i + g, PAIR_B] = a, b


@jit
def _move_row(pairs, to, k):
    for c in range(PAIR_WIDTH):
        pairs[to, c] = pairs[k, c]


@jit
def _take_out(cache, gone):
    """Free the slots of the pairs in the first ``gone`` rows of ``ended``, and close the gaps that they leave."""
    pairs, ended, counts = cache.pairs, cache.ended, cache.counts
    for j in range(gone - 1, -1, -1):  # so that the first one's slot is the first to be used again
        drop_slot(cache, ended[j])
    if gone > 0:
        kept, next_gone = ended[0], 0
        for k in range(ended[0], counts[PAIRS]):
            if next_gone < gone and k == ended[next_gone]:
                next_gone += 1
            else:
                _move_row(pairs, kept, k)
                kept += 1
        counts[PAIRS] = kept
    counts[ENDED] = gone


@jit
def drop_slot(cache, k):
    """Free the slot of the pair in row k, if it has one."""
    if cache.pairs[k, SLOT] != NONE:
        cache.free[cache.counts[FREE]] = cache.pairs[k, SLOT]
        cache.counts[FREE] += 1
        cache.pairs[k, SLOT] = NONE


@jit
def give_slot(cache, k):
    """Give the pair in row k a slot; returns it. There has to be room."""
    if cache.counts[FREE] > 0:
        cache.counts[FREE] -= 1
        slot = cache.free[cache.counts[FREE]]
    else:
        slot = cache.counts[SLOTS]
        cache.counts[SLOTS] += 1
    cache.pairs[k, SLOT] = slot
    return slot


@jit
def _put_in(cache, new):
    """Sort the first ``new`` rows of ``begun`` and merge them into the list, from its end."""
    pairs, begun, counts = cache.pairs, cache.begun, cache.counts
    _sort(begun, new)
    old, to = counts[PAIRS] - 1, counts[PAIRS] + new - 1
    left = new - 1
    while left >= 0:
        a, b = begun[left, PAIR_A], begun[left, PAIR_B]
        if old >= 0 and (pairs[old, PAIR_A] > a or (pairs[old, PAIR_A] == a and pairs[old, PAIR_B] > b)):
            _move_row(pairs, to, old)
            old -= 1
        else:
            pairs[to, PAIR_A], pairs[to, PAIR_B], pairs[to, SLOT] = a, b, NONE
            pairs[to, DUE] = pairs[to, SEEN] = pairs[to, HINT] = 0
            left -= 1
        to -= 1
    counts[PAIRS] += new
    counts[BEGUN] = new


# --- what the world does with them ------------------------------------------------------------------------------------


@jit
def update_pairs(tree, cache, bodies, kinds, awake, count, dt):
    """Bring the pairs up to date with the bounds of the first ``count`` bodies of ``awake``; returns their number.

    ``begun`` and ``ended`` list what changed. If the number returned exceeds the room, then the pairs are as they were:
    with more room (:func:`resize_pair_cache`) a second call does what this one would have done.
    """
    counts = cache.counts
    counts[BEGUN] = counts[ENDED] = 0
    if find_moved(tree, cache, bodies, kinds, awake, count, dt) == 0:
        return counts[PAIRS]
    gone = _find_ended(tree, cache, bodies, kinds, dt)
    new = _find_begun(tree, cache, bodies, kinds, dt)
    needed = counts[PAIRS] - gone + new
    if needed > cache.pairs.shape[0]:
        return needed
    _take_out(cache, gone)
    _put_in(cache, new)
    for k in range(counts[MOVED]):
        cache.marks[cache.lists[MOVED_LIST, k]] &= 255 - IS_MOVED
    counts[MOVED] = 0
    return needed


@jit
def touch_body(cache, i):
    """Have body i looked at in the next update, awake or not: it is new, or was moved or changed from outside.

    Its bounds have to be right by then. Its pairs that are still near it live on.
    """
    _append(cache, TOUCHED, TOUCHED_LIST, IS_TOUCHED, i)


@jit
def forget_body(tree, cache, i):
    """Take body i out at once; returns how many pairs ended with it: they are listed in ``ended``, as by an update."""
    remove(tree, i)
    _drop(cache, TOUCHED, TOUCHED_LIST, IS_TOUCHED, i)
    _drop(cache, MOVED, MOVED_LIST, IS_MOVED, i)
    _drop(cache, PLANES, PLANES_LIST, IS_PLANE, i)
    cache.marks[i] = 0
    pairs, gone = cache.pairs, 0
    for k in range(cache.counts[PAIRS]):
        if pairs[k, PAIR_A] == i or pairs[k, PAIR_B] == i:
            cache.ended[gone] = k
            gone += 1
    _take_out(cache, gone)
    cache.counts[BEGUN] = 0
    return gone
