"""Contacts of a box with a plane: the corners that touch it, at most four."""

from __future__ import annotations

from stiction.core.collide.manifold import emit, reduce
from stiction.core.jit import jit
from stiction.core.vec import Vec3, dot, rotation


@jit
def box_plane(contacts, tags, count, a, pa, qa, half, b, n, offset, margin, points):
    """Feature of a point: the number of the corner, a bit an axis. ``points`` is scratch, (16, 5)."""
    R = rotation(qa)
    found = 0
    for corner in range(8):
        local = Vec3(
            half.x if corner & 1 else -half.x, half.y if corner & 2 else -half.y, half.z if corner & 4 else -half.z
        )  # fmt: skip
        p = pa + R @ local
        separation = dot(n, p) - offset
        if separation <= margin:
            p = p - n * (0.5 * separation)
            points[found, 0], points[found, 1], points[found, 2] = p.x, p.y, p.z
            points[found, 3], points[found, 4] = separation, corner
            found += 1
    found = reduce(points, found, n)
    for i in range(found):
        p = Vec3(points[i, 0], points[i, 1], points[i, 2])
        count = emit(contacts, tags, count, a, b, p, -n, points[i, 3], int(points[i, 4]))
    return count
