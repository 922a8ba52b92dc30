"""Whether the shapes of two bodies have a point in common."""

from __future__ import annotations

from stiction.core.collide.gjk import closest
from stiction.core.collide.hulls import convex_of, support
from stiction.core.jit import jit
from stiction.core.query import TOUCHING, world_plane
from stiction.core.state import PLANE, POSITION, SHAPE
from stiction.core.vec import Vec3, dot, vec3


@jit
def bodies_overlap(bodies, kinds, hulls, a, b, points):
    """Whether bodies a and b, not both planes, overlap or touch; ``points`` is scratch, (SCRATCH, 5)."""
    if kinds[a, SHAPE] == PLANE:
        a, b = b, a
    still = Vec3(0.0, 0.0, 0.0)
    # near the origin, so that places far away cost no digits
    A = convex_of(bodies, kinds, a, still, hulls)
    pa = vec3(bodies, a, POSITION)
    if kinds[b, SHAPE] == PLANE:
        n, offset = world_plane(bodies, b)
        return dot(n, support(A, hulls, -n)) - A.radius <= offset - dot(n, pa) + TOUCHING
    d = vec3(bodies, b, POSITION) - pa
    B = convex_of(bodies, kinds, b, d, hulls)
    limit = A.radius + B.radius + TOUCHING
    apart, bound, _, _, _ = closest(A, B, hulls, still, d, limit, TOUCHING, 1e-12)
    return not apart or bound <= limit
