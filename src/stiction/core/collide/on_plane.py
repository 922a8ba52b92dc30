"""Contacts with a plane of what is neither sphere nor box: capsules, hulls and cylinders."""

from __future__ import annotations

from stiction.core.collide.clip import FLAT, UPRIGHT, lowest
from stiction.core.collide.hulls import vertex
from stiction.core.collide.manifold import POINTS, ROUND, emit, reduce
from stiction.core.jit import jit
from stiction.core.vec import column, cross, dot, length, put_vec3, vec3

ROOM = 16


@jit
def hull_plane(contacts, tags, count, a, A, b, n, offset, origin, hulls, margin, points):
    """The lowest vertices, at most four; of a capsule, its ends. Feature: the number of the vertex.

    ``offset`` is the height of the origin over the plane, negated.
    """
    first = hulls.spans[A.hull, 0]
    found = 0
    for i in range(hulls.spans[A.hull, 1]):
        p = vertex(A, hulls, first + i)
        separation = dot(n, p) - offset - A.radius
        if separation <= margin:
            if found == ROOM:
                found = reduce(points, found, n)
            put_vec3(points, found, 0, p - n * (A.radius + 0.5 * separation))
            points[found, 3], points[found, 4] = separation, i
            found += 1
    found = reduce(points, found, n)
    for i in range(found):
        count = emit(contacts, tags, count, a, b, origin + vec3(points, i, 0), -n, points[i, 3], int(points[i, 4]))
    return count


@jit
def cylinder_plane(contacts, tags, count, a, A, b, n, offset, origin, margin):
    """A cap that lies flat: four points of its rim, fixed to the body. A tilted cap: its lowest point, then those
    across and opposite as far as they are within the margin. The side: the lowest point of either rim.

    The lowest points move smoothly round the rim as the cylinder rolls. Feature: 0, 1 for the rims' lowest points, 2 to
    4 for the others, 8 to 11 for those of a flat cap.
    """
    axis = column(A.R, 2)
    c = dot(axis, n)
    down = lowest(A, n)
    across = cross(axis, down)
    low = -1.0 if c > 0.0 else 1.0
    cap = A.p + axis * (low * A.scale.z)
    d = axis * c - n
    tilt = length(d)
    flat = tilt < FLAT
    whole = ROUND if flat and dot(n, cap) - offset + A.scale.x * tilt <= margin else 0
    points = 2 if abs(c) < UPRIGHT else POINTS
    for k in range(points):
        p = cap
        feature = 0 if low > 0.0 else 1
        if points == 2:
            p = p + down * A.scale.x
            if k == 1:
                p = p - axis * (2.0 * low * A.scale.z)
                feature = 1 - feature
        else:
            r = A.scale.x if k < 2 else -A.scale.x
            p = p + (down if k & 1 == 0 else across) * r
            feature = whole | (8 + k) if flat else (feature if k == 0 else 1 + k)
        separation = dot(n, p) - offset
        if separation <= margin:
            count = emit(
                contacts, tags, count, a, b, origin + p - n * (0.5 * separation), -n, separation, feature
            )  # fmt: skip
    return count
