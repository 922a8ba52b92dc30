"""A contact manifold: up to four points of one pair of bodies that share a normal."""

from __future__ import annotations

from stiction.core.jit import jit
from stiction.core.state import BODY_A, BODY_B, FEATURE, NORMAL, POINT, SEPARATION
from stiction.core.vec import Vec3, cross, dot, put_vec3

POINTS = 4


@jit
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
def reduce(points, n, normal):
    """Choose four of n candidate points so that the patch keeps its depth and its area; they end up in rows 0 to 3.

    ``points`` is (k, 5): x, y, z, separation, feature. The deepest point, the one farthest from it, and on either side
    of the line between them the one that spans the largest triangle. Ties go to the earlier row, so the choice is
    stable.
    """
    if n <= POINTS:
        return n
    deepest = 0
    for i in range(1, n):
        if points[i, 3] < points[deepest, 3] - 1e-9:
            deepest = i
    _swap(points, 0, deepest)

    origin = Vec3(points[0, 0], points[0, 1], points[0, 2])
    farthest, best = 1, -1.0
    for i in range(1, n):
        d = Vec3(points[i, 0], points[i, 1], points[i, 2]) - origin
        if dot(d, d) > best + 1e-12:
            farthest, best = i, dot(d, d)
    _swap(points, 1, farthest)

    line = Vec3(points[1, 0], points[1, 1], points[1, 2]) - origin
    kept = 2
    for side in (1.0, -1.0):
        widest, best = -1, 1e-12
        for i in range(kept, n):
            d = Vec3(points[i, 0], points[i, 1], points[i, 2]) - origin
            area = side * dot(cross(line, d), normal)
            if area > best + 1e-12:
                widest, best = i, area
        if widest >= 0:
            _swap(points, kept, widest)
            kept += 1
    return kept


@jit
def _swap(points, i, j):
    for k in range(points.shape[1]):
        points[i, k], points[j, k] = points[j, k], points[i, k]
