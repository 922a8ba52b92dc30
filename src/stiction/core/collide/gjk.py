"""Distance of two convex cores: Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance between complex
objects in three-dimensional space", IEEE J. Robotics and Automation 4, 1988.

The point of the difference C = B - A that is nearest to the origin is sought on a simplex of at most four points of C.
The nearest face of the simplex is found by trying all that hold the newest point: dearer than a walk through Voronoi
regions, but it has no case that rounding could send astray (van den Bergen, "Collision detection in interactive 3D
environments", 2003, calls it the backup procedure).
"""

from __future__ import annotations

import math

from stiction.core.collide.hulls import support
from stiction.core.jit import bare
from stiction.core.vec import Vec3, cross, dot, length, put_vec3, vec3

ITERATIONS = 64
SIMPLEX = 128
"""Row of the scratch in which the simplex begins: a point of C and its weight, then the point of A it was made from."""


@bare
def closest(A, B, hulls, shift, start, limit, floor, tolerance, points):
    """Distance of A from B moved by ``shift``; ``start`` is a guess of its direction.

    Returns whether they are more than ``floor`` apart, a lower bound of the distance, the direction n along which it
    holds, and the nearest points of A and of B where it stands. Stops early once they are known to be more than
    ``limit`` apart, or when the distance exceeds the bound by no more than a part ``tolerance``. The bound is exact
    for its n.
    """
    v = start if dot(start, start) > 0.0 else Vec3(1.0, 0.0, 0.0)
    n, bound = v, -math.inf
    k, vv = 0, math.inf
    apart = True
    for _ in range(ITERATIONS):
        a = support(A, hulls, v)
        w = support(B, hulls, -v) + shift - a
        s = length(v)
        h = dot(v, w) / s
        if h > bound:
            bound, n = h, v * (1.0 / s)
        if bound > limit or (k > 0 and s - h <= tolerance * s):
            break
        put_vec3(points, SIMPLEX + 2 * k, 0, w)
        put_vec3(points, SIMPLEX + 2 * k + 1, 0, a)
        k, v = _nearest(points, k)
        if dot(v, v) <= floor * floor:
            apart = False
            break
        if dot(v, v) >= vv:
            break
        vv = dot(v, v)

    pa = Vec3(0.0, 0.0, 0.0)
    for i in range(k):
        pa = pa + vec3(points, SIMPLEX + 2 * i + 1, 0) * points[SIMPLEX + 2 * i, 3]
    # rounding may have ended it early: without a bound they count as touching
    return apart and bound > floor, bound, n, pa, pa + v - shift


@bare
def _nearest(points, m):
    """The point nearest to the origin on the simplex of m old points and the newest one, row m; what does not hold it
    is dropped. Returns how many points remain, and that point."""
    p = vec3(points, SIMPLEX + 2 * m, 0)
    v, best, chosen = p, dot(p, p), 0
    x, y, z = 0.0, 0.0, 0.0
    for mask in range(1, 1 << m):
        i = 0 if mask & 1 else (1 if mask & 2 else 2)
        rest = mask & ~(1 << i)
        e0 = vec3(points, SIMPLEX + 2 * i, 0) - p
        if rest == 0:
            ee, t = dot(e0, e0), -dot(p, e0)
            if 0.0 < t < ee:
                t /= ee
                q = p + e0 * t
                if dot(q, q) < best:
                    v, best, chosen = q, dot(q, q), mask
                    x, y, z = t, 0.0, 0.0
            continue
        e1 = vec3(points, SIMPLEX + 2 * (1 if rest & 2 else 2), 0) - p
        N = cross(e0, e1)
        if mask < 7:
            NN = dot(N, N)
            if NN > 1e-28 * dot(e0, e0) * dot(e1, e1):
                s = -dot(cross(p, e1), N) / NN
                t = -dot(cross(e0, p), N) / NN
                q = N * (dot(p, N) / NN)
                if s > 0.0 and t > 0.0 and s + t < 1.0 and dot(q, q) < best:
                    v, best, chosen = q, dot(q, q), mask
                    x, y, z = s, t, 0.0
            continue
        e2 = vec3(points, SIMPLEX + 4, 0) - p
        volume = dot(N, e2)
        if abs(volume) > 1e-14 * math.sqrt(dot(N, N) * dot(e2, e2)):
            s, t, u = -dot(p, cross(e1, e2)) / volume, -dot(p, cross(e2, e0)) / volume, -dot(p, N) / volume
            if s >= 0.0 and t >= 0.0 and u >= 0.0 and s + t + u <= 1.0:
                v, best, chosen = Vec3(0.0, 0.0, 0.0), 0.0, mask
                x, y, z = s, t, u

    points[SIMPLEX + 2 * m, 3] = 1.0 - x - y - z
    kept = 0
    for i in range(m + 1):
        if i == m or chosen >> i & 1:
            if i < m:
                points[SIMPLEX + 2 * i, 3] = x if kept == 0 else (y if kept == 1 else z)
            for c in range(4):
                points[SIMPLEX + 2 * kept, c] = points[SIMPLEX + 2 * i, c]
                points[SIMPLEX + 2 * kept + 1, c] = points[SIMPLEX + 2 * i + 1, c]
            kept += 1
    return kept, v
