"""Pairs of bodies that are near each other and do not touch: until when nothing comes of them, and where to look first.

Of nine pairs of a body in a heap three touch. What is known of the others fits into the list of pairs, which is read in
its order in every step: so a pair that is not due costs a nanosecond, and no row of a manifold.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.jit import jit
from stiction.core.pairs import DUE, HINT, SEEN
from stiction.core.state import PLANE, SHAPE
from stiction.core.vec import Vec3, mat33, transpose

SPECULATIVE = 0.005
"""m, points are kept that far ahead besides what velocities ask for, or a twentieth of the smaller body if less."""
SMALL = 0.05
LOOK = 0.01
"""m, and they are looked for still farther ahead, or a tenth of the smaller body, to know for how long nothing will
come."""
EDITED_MOTION, FARTHEST = 1.0, 0.9
"""m, by which a body counts as moved that was changed from outside; a pair is looked at again after less, however far
apart it is."""
NANO, FARTHEST_DUE = 1e9, 9e9
"""Nanometres in a metre; m, what has moved farther is looked at in every step."""
FORGOTTEN = 0.5
"""Of the smaller body's reach: after so much motion the last direction of a pair is no hint any more."""
BITS = 21
"""Of each component of a hint, its sign among them."""
TINY = 1e-150
"""A direction whose components are smaller is none."""
ONE, MASK = 1 << (BITS - 1), (1 << BITS) - 1


@jit
def smaller_reach(pose, kinds, a, b):
    """Reach of the smaller of two bodies, m; a plane is larger than anything."""
    if kinds[a, SHAPE] == PLANE:
        return pose[b + 1, s.POSE_REACH]
    if kinds[b, SHAPE] == PLANE:
        return pose[a + 1, s.POSE_REACH]
    return min(pose[a + 1, s.POSE_REACH], pose[b + 1, s.POSE_REACH])


@jit
def speculative_of(pose, kinds, a, b):
    """How far ahead contact points are needed in any step, m."""
    return min(SPECULATIVE, SMALL * smaller_reach(pose, kinds, a, b))


@jit
def margin_of(pose, kinds, a, b):
    """How far ahead contact points are needed in this step, m."""
    return speculative_of(pose, kinds, a, b) + pose[a + 1, s.POSE_MARGIN] + pose[b + 1, s.POSE_MARGIN]


@jit
def look_of(pose, kinds, a, b):
    """How far beyond that contact points are looked for, m."""
    return min(LOOK, 2.0 * SMALL * smaller_reach(pose, kinds, a, b))


@jit
def is_due(pose, a, b, due):
    """Whether a pair has to be looked at: its bodies have moved, and may move in this step, as far as that."""
    far = pose[a + 1, s.POSE_MOTION] + pose[a + 1, s.POSE_MARGIN]
    far += pose[b + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MARGIN]
    return not far * NANO < due


@jit
def see_nothing(pose, kinds, a, b, pairs, k, gap, toward):
    """The bodies of pair k are ``gap`` apart at least, along ``toward``: it is not due until they have come so near
    that points are needed."""
    moved = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION]
    due = moved + min(gap, FARTHEST) - speculative_of(pose, kinds, a, b)
    pairs[k, DUE] = int(min(max(due, 0.0), FARTHEST_DUE) * NANO)
    pairs[k, SEEN] = int(min(moved, FARTHEST_DUE) * NANO)
    pairs[k, HINT] = pack(transpose(mat33(pose, a + 1, s.POSE_ROTATION)) @ toward)


@jit
def hint_of(pose, kinds, a, b, pairs, k):
    """The direction from a to b along which pair k was last seen to be apart, as by :func:`as_hint`."""
    if pairs[k, HINT] == 0:
        return Vec3(0.0, 0.0, 0.0)
    return as_hint(pose, kinds, a, b, pairs[k, SEEN] / NANO, unpack(pairs[k, HINT]))


@jit
def as_hint(pose, kinds, a, b, seen, direction):
    """A direction in the axes of a that was found when both bodies had moved by ``seen``, m, in world axes; zero if
    they have moved so far since that it says little."""
    moved = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION] - seen
    if moved > FORGOTTEN * smaller_reach(pose, kinds, a, b):
        return Vec3(0.0, 0.0, 0.0)
    return mat33(pose, a + 1, s.POSE_ROTATION) @ direction


@jit
def pack(v):
    """A direction as a number above 0, to a millionth; 0 of the zero vector, and of what is as good as that."""
    longest = max(abs(v.x), max(abs(v.y), abs(v.z)))
    if not longest > TINY:
        return 0
    v = v * ((ONE - 1) / longest)
    x, y, z = math.floor(v.x + 0.5) + ONE, math.floor(v.y + 0.5) + ONE, math.floor(v.z + 0.5) + ONE
    return (x << BITS | y) << BITS | z


@jit
def unpack(number):
    """The direction, its largest component 1 or -1."""
    scale = 1.0 / (ONE - 1)
    return Vec3(
        ((number >> (2 * BITS)) - ONE) * scale, ((number >> BITS & MASK) - ONE) * scale, ((number & MASK) - ONE) * scale
    )
