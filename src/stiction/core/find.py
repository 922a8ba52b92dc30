"""Which manifolds have points: the narrow phase over all pairs whose bodies take part, by one worker or by several."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import DOUBLE, MANY, SINGLE, SOON, ask_for, ask_for_row, row_number
from stiction.core.collide.manifold import forget_face
from stiction.core.collide.narrow import pair_contacts
from stiction.core.colouring import way_of
from stiction.core.jit import jit
from stiction.core.manifolds import (
    due_of,
    hint_of,
    is_due,
    is_kept,
    look_of,
    margin_of,
    refresh_manifold,
    see_nothing,
    take_points,
)
from stiction.core.pairs import DUE, PAIR_A, PAIR_B, SLOT, is_sensed
from stiction.core.sleep import wake_island
from stiction.core.state import ASLEEP, DYNAMIC, MOBILITY, NORMAL, POSITION, SEPARATION, SIZE
from stiction.core.team import take_piece
from stiction.core.vec import vec3

HAS_POINTS = 3
"""Column of the active manifolds in which those of all pairs say whether they have any: 0, or 1 more than what they did
(``colouring.way_of``). Later it is their place in the blocks."""
DUE_LIST = 0
"""Column of them that lists the pairs to be looked at, until it names the bodies of those with points."""


@jit
def is_awake(kinds, i):
    """Whether contacts of body i have to be solved on its account."""
    return kinds[i, MOBILITY] == DYNAMIC and not kinds[i, ASLEEP]


@jit
def update_manifolds(
    bodies, kinds, pairs, npairs, soft, active, contacts, tags, points, table, slow, dt, boxes_meet, hulls, team
):  # fmt: skip
    """Bring the manifolds of all pairs up to date that have a body that is awake, and mark those with points.

    A manifold depends on its two bodies and on itself, so it does not matter which worker takes it. ``contacts``,
    ``tags`` and ``points`` are the worker's own scratch.
    """
    manifolds, meta, reports, pose = soft.manifolds, soft.meta, soft.reports, soft.pose
    piece = 0
    first, last = take_piece(team, piece, npairs)
    while first < last:
        due = list_due(kinds, pairs, first, last, pose, active)
        for j in range(due):
            k = row_number(active[first + j, DUE_LIST])
            a, b = row_number(pairs[k, PAIR_A]), row_number(pairs[k, PAIR_B])
            row = row_number(pairs[k, SLOT]) + 1
            if npairs > 2 * MANY:
                ahead = active[first + min(j + SOON, due - 1), DUE_LIST]
                slot, other = pairs[ahead, SLOT] + 1, pairs[ahead, PAIR_B]
                ask_for_row(meta, slot, s.META_WIDTH, DOUBLE)
                ask_for_row(manifolds, slot, s.MANIFOLD_WIDTH, SINGLE)
                ask_for_row(reports, slot, s.REPORT_WIDTH, SINGLE)
                ask_for(pose, other + 1, s.POSE_ROTATION)
                ask_for(bodies, other, POSITION)
                ask_for(bodies, other, SIZE)
            if not is_kept(kinds, a, b, pose, meta, row):
                needed = margin_of(pose, kinds, a, b)
                margin = needed + look_of(pose, kinds, a, b)
                hint = hint_of(kinds, a, b, manifolds, meta, pose, row)
                forget_face(points)
                found, toward, nearest = pair_contacts(
                    bodies, kinds, a, b, margin, hint, contacts, tags, 0, points, boxes_meet, hulls
                )
                if found > 0:
                    nearest, toward = margin, vec3(contacts, 0, NORMAL)
                    for c in range(found):
                        nearest = min(nearest, contacts[c, SEPARATION])
                if found == 0 or nearest > needed:
                    see_nothing(manifolds, meta, reports, pose, a, b, row, nearest, toward)
                else:
                    take_points(bodies, kinds, a, b, soft, row, contacts, tags, found, points, table, slow)
            if meta[row, s.POINTS] > 0.0:
                refresh_manifold(bodies, kinds, a, b, manifolds, meta, reports, pose, row, dt)
                active[k, HAS_POINTS] = 1 + way_of(manifolds, row)
            pairs[k, DUE] = due_of(pose, kinds, a, b, meta, row)
        piece += 1
        first, last = take_piece(team, piece, npairs)


@jit
def list_due(kinds, pairs, first, last, pose, active):
    """Which of the pairs from ``first`` to before ``last`` have to be looked at: listed among the active manifolds from
    ``first`` on, where none of these pairs has any points by now; returns their number."""
    due = 0
    for k in range(first, last):
        a, b = row_number(pairs[k, PAIR_A]), row_number(pairs[k, PAIR_B])
        active[k, HAS_POINTS] = 0
        if last - first > 2 * MANY:
            ask_for(pose, pairs[min(k + SOON, last - 1), PAIR_B] + 1, s.POSE_MOTION)
        if (
            is_due(pose, a, b, pairs[k, DUE])
            and (is_awake(kinds, a) or is_awake(kinds, b))
            and not is_sensed(kinds, a, b)
        ):
            active[first + due, DUE_LIST] = k
            due += 1
    return due


@jit
def list_manifolds(bodies, kinds, n, pairs, npairs, active):
    """List the manifolds with points in the first rows; returns their number, and whether a body woke.

    Where a body that is awake touches one that sleeps, the latter's island wakes.
    """
    count, woke = 0, False
    for k in range(npairs):
        if active[k, HAS_POINTS]:
            a, b = pairs[k, PAIR_A], pairs[k, PAIR_B]
            if kinds[a, ASLEEP] or kinds[b, ASLEEP]:
                wake_island(bodies, kinds, n, a if kinds[a, ASLEEP] else b)
                woke = True
            way = active[k, HAS_POINTS] - 1
            active[count, 0], active[count, 1], active[count, 2], active[count, 3] = a, b, pairs[k, SLOT], way
            count += 1
    return count, woke
