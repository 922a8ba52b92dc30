"""Which manifolds have points: the narrow phase over all pairs whose bodies take part, by one worker or by several."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import DOUBLE, MANY, SINGLE, SOON, ask_for, ask_for_row, row_number
from stiction.core.apart import as_hint, hint_of, is_due, look_of, margin_of, see_nothing
from stiction.core.collide.manifold import forget_face
from stiction.core.collide.narrow import pair_contacts
from stiction.core.colouring import way_of
from stiction.core.going_on import is_kept, rolls_on
from stiction.core.jit import jit
from stiction.core.manifolds import refresh_manifold, take_points
from stiction.core.pairs import DUE, PAIR_A, PAIR_B, SLOT, is_sensed
from stiction.core.sleep import wake_island
from stiction.core.slots import DUE_LIST, FOUND, LOST, NOTHING, WANTS
from stiction.core.state import ASLEEP, DYNAMIC, MOBILITY, NORMAL, POSITION, SEPARATION, SIZE
from stiction.core.team import take_piece
from stiction.core.vec import vec3


@jit
def is_awake(kinds, i):
    """Whether contacts of body i have to be solved on its account."""
    return kinds[i, MOBILITY] == DYNAMIC and not kinds[i, ASLEEP]


@jit
def update_manifolds(
    bodies, kinds, pairs, npairs, again, soft, looked, contacts, tags, points, table, slow, dt, boxes_meet, hulls, team
):  # fmt: skip
    """Bring the manifolds of all pairs up to date that have a body that is awake, and note which have points; or,
    ``again``, of those that have just got a slot.

    A manifold depends on its two bodies and on itself, so it does not matter which worker takes it. ``contacts``,
    ``tags`` and ``points`` are the worker's own scratch.
    """
    manifolds, meta, reports, pose = soft.manifolds, soft.meta, soft.reports, soft.pose
    piece = 0
    first, last = take_piece(team, piece, npairs)
    while first < last:
        due = list_slotted(looked, first, last) if again else list_due(kinds, pairs, first, last, pose, looked)
        for j in range(due):
            k = row_number(looked[first + j, DUE_LIST])
            a, b = row_number(pairs[k, PAIR_A]), row_number(pairs[k, PAIR_B])
            row = row_number(pairs[k, SLOT] + 1)
            if npairs > 2 * MANY:
                ahead = looked[first + min(j + SOON, due - 1), DUE_LIST]
                soon, other = pairs[ahead, SLOT] + 1, pairs[ahead, PAIR_B]
                ask_for_row(meta, soon, s.META_WIDTH, DOUBLE)
                ask_for_row(manifolds, soon, s.MANIFOLD_WIDTH, SINGLE)
                ask_for_row(reports, soon, s.REPORT_WIDTH, SINGLE)
                ask_for(soft.corners, soon, 0)
                ask_for(pose, other + 1, s.POSE_ROTATION)
                ask_for(bodies, other, POSITION)
                ask_for(bodies, other, SIZE)
            if row == 0 or not (
                is_kept(kinds, a, b, pose, manifolds, meta, row)
                or rolls_on(kinds, a, b, pose, manifolds, meta, soft.corners, row, margin_of(pose, kinds, a, b))
            ):
                needed = margin_of(pose, kinds, a, b)
                margin = needed + look_of(pose, kinds, a, b)
                if row > 0 and meta[row, s.POINTS] > 0.0:
                    hint = as_hint(pose, kinds, a, b, meta[row, s.MADE], vec3(manifolds, row, s.NORMAL_A))
                else:
                    hint = hint_of(pose, kinds, a, b, pairs, k)
                forget_face(points)
                found, toward, nearest = pair_contacts(
                    bodies, kinds, a, b, margin, hint, contacts, tags, 0, points, boxes_meet, hulls
                )
                if found > 0:
                    nearest, toward = margin, vec3(contacts, 0, NORMAL)
                    for c in range(found):
                        nearest = min(nearest, contacts[c, SEPARATION])
                if found == 0 or nearest > needed:
                    see_nothing(pose, kinds, a, b, pairs, k, nearest, toward)
                    looked[k, FOUND] = LOST if row > 0 else NOTHING
                    continue
                if row == 0:
                    looked[k, FOUND] = WANTS
                    continue
                pairs[k, DUE] = 0
                take_points(bodies, kinds, a, b, soft, row, contacts, tags, found, points, table, slow)
            refresh_manifold(bodies, kinds, a, b, manifolds, meta, reports, pose, soft.aux, row, dt)
            looked[k, FOUND] = 1 + way_of(manifolds, row)
        piece += 1
        first, last = take_piece(team, piece, npairs)


@jit
def list_due(kinds, pairs, first, last, pose, looked):
    """Which of the pairs from ``first`` to before ``last`` have to be looked at: listed from row ``first`` on. Nothing
    is found of any of them by now. Returns their number."""
    due = 0
    for k in range(first, last):
        a, b = row_number(pairs[k, PAIR_A]), row_number(pairs[k, PAIR_B])
        looked[k, FOUND] = NOTHING
        if last - first > 2 * MANY:
            ask_for(pose, pairs[min(k + SOON, last - 1), PAIR_B] + 1, s.POSE_MOTION)
        if (
            is_due(pose, a, b, pairs[k, DUE])
            and (is_awake(kinds, a) or is_awake(kinds, b))
            and not is_sensed(kinds, a, b)
        ):
            looked[first + due, DUE_LIST] = k
            due += 1
    return due


@jit
def list_slotted(looked, first, last):
    """The same of those that wanted a slot and have got one."""
    due = 0
    for k in range(first, last):
        if looked[k, FOUND] == WANTS:
            looked[first + due, DUE_LIST] = k
            due += 1
    return due


@jit
def list_manifolds(bodies, kinds, n, pairs, npairs, looked, active):
    """List the manifolds with points; returns their number, and whether a body woke.

    Where a body that is awake touches one that sleeps, the latter's island wakes.
    """
    count, woke = 0, False
    for k in range(npairs):
        if looked[k, FOUND] > NOTHING:
            a, b = pairs[k, PAIR_A], pairs[k, PAIR_B]
            if kinds[a, ASLEEP] or kinds[b, ASLEEP]:
                wake_island(bodies, kinds, n, a if kinds[a, ASLEEP] else b)
                woke = True
            way = looked[k, FOUND] - 1
            active[count, 0], active[count, 1], active[count, 2], active[count, 3] = a, b, pairs[k, SLOT], way
            count += 1
    return count, woke
