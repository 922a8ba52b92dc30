"""A contact manifold: up to four points of one pair of bodies that share a normal."""

from __future__ import annotations

import math

from stiction.core.jit import inlined, jit
from stiction.core.state import BODY_A, BODY_B, FACE, FEATURE, LARGEST_FACE, LEAD, NORMAL, POINT, RADII, SEPARATION
from stiction.core.vec import Vec3, cross, dot, put_vec3

POINTS = 4
CLEARLY = 1.01
"""A candidate must be better than an earlier one by this factor."""
SAME_DEPTH = 0.01
"""Separations that differ by less than this part of the patch's size are the same."""
SAME_PLACE2 = 1e-4
"""Points nearer than the root of this part of it are in the same place."""
LASTS, TURNED = 0.1, 1e-5
"""The face along which contact was found before is kept unless another direction is better by this part of the depth;
it was that face if the normal has turned by less than this since, 1 - cosine."""
ENDLESS, UNKNOWN = math.inf, -1.0
"""Radii of curvature of what is flat, and of what it is not known of."""
ROUND = 1 << 40
"""Bit of the feature of four points that stand for a whole disc: they lie on its rim, 90 degrees apart."""


@inlined
def emit(contacts, tags, count, a, b, point, normal, separation, feature):
    """Write one contact point, with the lower body first, and return the new count.

    Beyond the capacity nothing is written, but counting goes on, so that the caller knows how much room is needed.
    """
    if count < contacts.shape[0]:
        if a < b:
            tags[count, BODY_A] = a
            tags[count, BODY_B] = b
            put_vec3(contacts, count, NORMAL, normal)
        else:
            tags[count, BODY_A] = b
            tags[count, BODY_B] = a
            put_vec3(contacts, count, NORMAL, -normal)
        put_vec3(contacts, count, POINT, point)
        contacts[count, SEPARATION] = separation
        tags[count, FEATURE] = feature
    return count + 1


@jit
def lasting(hint, normal, depth, small):
    """By how much, m, another direction must be better than the face with this normal because contact was found along
    it a moment ago, in the direction ``hint``, of any length, or zero; ``small`` is the least half width.

    Where loads press shapes into each other by millimetres, a turn of a milliradian decides whether a face or a pair of
    edges is the shallower way out: contact that jumps between them never comes to rest.
    """
    if depth <= 0.0 or dot(hint, normal) <= (1.0 - TURNED) * math.sqrt(dot(hint, hint)):
        return 0.0
    return LASTS * min(depth, small)


@jit
def reduce(points, n, normal):
    """Choose four of n candidate points so that the patch keeps its depth and its area; they end up in rows 0 to 3.

    ``points`` is (k, 5): x, y, z, separation, feature. Of the deepest points the outermost one, the one farthest from
    it in the plane, and on either side of the line between them the one that spans the largest triangle. Depths are
    told apart only by ``SAME_DEPTH`` of the patch's size, and a point must be better than an earlier one by
    ``CLEARLY``: so the choice does not flip while a body rocks by micrometres, and yet a thin sheet does not stand on
    the corners of its upper face. Of more than four points that are equally deep, all are remembered beside: they are
    the face, of which friction wants the moments.
    """
    if n <= POINTS:
        return n
    origin, size2 = Vec3(points[0, 0], points[0, 1], points[0, 2]), 0.0
    middle = Vec3(0.0, 0.0, 0.0)
    for i in range(n):
        d = _in_plane(points, i, origin, normal)
        size2 = max(size2, dot(d, d))
        middle = middle + d * (1.0 / n)
    same = _sort_by_depth(points, n, normal, size2)
    _remember(points, same)
    outermost, best = 0, 0.0
    for i in range(same):
        d = _in_plane(points, i, origin, normal) - middle
        if dot(d, d) > best * CLEARLY:
            outermost, best = i, dot(d, d)
    _swap(points, 0, outermost)

    origin = Vec3(points[0, 0], points[0, 1], points[0, 2])
    farthest, best = 1, 0.0
    for i in range(1, n):
        d = _in_plane(points, i, origin, normal)
        if dot(d, d) > best * CLEARLY:
            farthest, best = i, dot(d, d)
    _swap(points, 1, farthest)

    line = _in_plane(points, 1, origin, normal)
    kept = 2
    for side in (1.0, -1.0):
        widest, best = -1, 1e-12
        for i in range(kept, n):
            area = side * dot(cross(line, _in_plane(points, i, origin, normal)), normal)
            if area > best * CLEARLY:
                widest, best = i, area
        if widest >= 0:
            _swap(points, kept, widest)
            kept += 1
    return kept


@jit
def forget_face(points):
    """Before a pair is looked at: no face is known of it, nor how it is curved."""
    if points.shape[0] > RADII:
        points[FACE, 0] = 0.0
        points[RADII, 3] = UNKNOWN
        points[LEAD, 0] = 0.0


@inlined
def put_radii(points, first, direction, along, across):
    """Remember how the first body of a pair is curved where it touches, or the second: the radius in a ``direction`` of
    its surface (world axes) and across it, m; ``ENDLESS`` of what is flat."""
    if points.shape[0] > RADII:
        row = RADII if first else RADII + 1
        put_vec3(points, row, 0, direction)
        points[row, 3], points[row, 4] = along, across


@inlined
def put_lead(points, lead):
    """Remember how far the bodies may move against each other until they touch with other features, m."""
    if points.shape[0] > LEAD:
        points[LEAD, 0] = lead


@jit
def remembered(points):
    """How many corners of the face of the pair that was looked at last are in scratch, 0 or more than four."""
    return int(points[FACE, 0]) if points.shape[0] > FACE else 0


@jit
def _remember(points, n):
    """Keep the first n points as a face; of many, every second or third."""
    if points.shape[0] <= FACE or n <= POINTS:
        return
    every = (n + LARGEST_FACE - 1) // LARGEST_FACE
    kept = 0
    for i in range(0, n, every):
        for k in range(3):
            points[FACE + 1 + kept, k] = points[i, k]
        kept += 1
    points[FACE, 0] = kept if kept > POINTS else 0


@jit
def _in_plane(points, i, origin, normal):
    d = Vec3(points[i, 0], points[i, 1], points[i, 2]) - origin
    return d - normal * dot(normal, d)


@jit
def _sort_by_depth(points, n, normal, size2):
    """Insertion sort by depth, equal ones in their order; returns how many are as deep as the deepest.

    Of two points in the same place of the plane the deeper one comes first, however little deeper.
    """
    deepest = points[0, 3]
    for i in range(1, n):
        deepest = min(deepest, points[i, 3])
    unit = SAME_DEPTH * math.sqrt(size2) + 1e-12
    for i in range(1, n):
        j = i
        while j > 0 and _is_before(points, j, j - 1, normal, size2, deepest, unit):
            _swap(points, j, j - 1)
            j -= 1
    same = 1
    while same < n and points[same, 3] - deepest < unit:
        same += 1
    return same


@jit
def _is_before(points, i, j, normal, size2, deepest, unit):
    depth_i, depth_j = math.floor((points[i, 3] - deepest) / unit), math.floor((points[j, 3] - deepest) / unit)
    if depth_i != depth_j:
        return depth_i < depth_j
    d = _in_plane(points, i, Vec3(points[j, 0], points[j, 1], points[j, 2]), normal)
    return dot(d, d) < SAME_PLACE2 * size2 and points[i, 3] < points[j, 3]


@jit
def _swap(points, i, j):
    for k in range(points.shape[1]):
        points[i, k], points[j, k] = points[j, k], points[i, k]
