"""Distance of two convex cores: Gilbert, Johnson, Keerthi, "A fast procedure for computing the distance between complex
objects in three-dimensional space", IEEE J. Robotics and Automation 4, 1988.

The point of the difference C = B - A that is nearest to the origin is sought on a simplex of at most four points of C.
The nearest part of the simplex is found by trying all that hold the newest point: dearer than a walk through Voronoi
regions, but it has no case that rounding could send astray (van den Bergen, "Collision detection in interactive 3D
environments", 2003, calls it the backup procedure). Only faces of a tetrahedron that have the origin clearly on their
inner side are left out. Everything is in the axes of A, and nothing of it in memory.
"""

from __future__ import annotations

import math

from stiction.core.collide.hulls import reach_point
from stiction.core.jit import inlined, jit
from stiction.core.vec import Vec3, cross, dot, transpose

ITERATIONS = 64
INNER = 1e-9
"""A face is left out if the origin's share of the corner opposite to it is larger."""


@jit
def closest(A, B, hulls, shift, start, limit, floor, tolerance):
    """Distance of A from B moved by ``shift``; ``start`` is a guess of its direction.

    Returns whether they are more than ``floor`` apart, a lower bound of the distance, the direction n along which it
    holds, and the nearest points of A and of B where it stands. Stops early once they are known to be more than
    ``limit`` apart, or when the distance exceeds the bound by no more than a part ``tolerance``. The bound is exact
    for its n.
    """
    to_a = transpose(A.R)
    R, d = to_a @ B.R, to_a @ ((B.p - A.p) + shift)
    to_b = transpose(R)
    v = to_a @ start if dot(start, start) > 0.0 else Vec3(1.0, 0.0, 0.0)
    n, bound = v, -math.inf
    pa = Vec3(0.0, 0.0, 0.0)
    # the simplex, and the points of A that its corners were made from
    w0 = w1 = w2 = a0 = a1 = a2 = pa
    k, vv = 0, math.inf
    apart = True
    for _ in range(ITERATIONS):
        a = reach_point(A, hulls, v)
        w = d + R @ reach_point(B, hulls, -(to_b @ v)) - a
        size = math.sqrt(dot(v, v))
        h = dot(v, w) / size
        if h > bound:
            bound, n = h, v * (1.0 / size)
        if bound > limit or (k > 0 and size - h <= tolerance * size):
            break
        v, kept, x, y, z = nearest(k, w, w0, w1, w2)
        pa = a0 * x + a1 * y + a2 * z + a * (1.0 - x - y - z)
        if kept == 3:
            w2, a2, k = w, a, 3
        elif kept == 5:
            w1, a1, w2, a2, k = w2, a2, w, a, 3
        elif kept == 6:
            w0, a0, w1, a1, w2, a2, k = w1, a1, w2, a2, w, a, 3
        elif kept == 1:
            w1, a1, k = w, a, 2
        elif kept == 2:
            w0, a0, w1, a1, k = w1, a1, w, a, 2
        elif kept == 4:
            w0, a0, w1, a1, k = w2, a2, w, a, 2
        else:
            w0, a0, k = w, a, 1
        if dot(v, v) <= floor * floor:
            apart = False
            break
        if dot(v, v) >= vv:
            break
        vv = dot(v, v)
    pa = A.p + A.R @ pa
    # rounding may have ended it early: without a bound they count as touching
    return apart and bound > floor, bound, A.R @ n, pa, pa + A.R @ v - shift


@inlined
def nearest(m, p, a, b, c):
    """The point nearest to the origin on the simplex of p, which is new, and the first m of a, b, c.

    Returns it, which of a, b, c span it together with p (bits), and their shares; p has the rest.
    """
    v, best, chosen = p, dot(p, p), 0
    x, y, z = 0.0, 0.0, 0.0
    if m == 0:
        return v, chosen, x, y, z
    ea = a - p
    q, t, found = _on_edge(p, ea)
    if found and dot(q, q) < best:
        v, best, chosen, x = q, dot(q, q), 1, t
    if m == 1:
        return v, chosen, x, y, z
    eb = b - p
    q, t, found = _on_edge(p, eb)
    if found and dot(q, q) < best:
        v, best, chosen, x, y = q, dot(q, q), 2, 0.0, t
    nc = cross(ea, eb)
    if m == 2:
        q, s, t, found = _on_face(p, ea, eb, nc)
        if found and dot(q, q) < best:
            v, chosen, x, y = q, 3, s, t
        return v, chosen, x, y, z
    ec = c - p
    q, t, found = _on_edge(p, ec)
    if found and dot(q, q) < best:
        v, best, chosen, x, y, z = q, dot(q, q), 4, 0.0, 0.0, t
    na, nb = cross(eb, ec), cross(ec, ea)
    volume = dot(nc, ec)
    r, s, t = -1.0, -1.0, -1.0
    if abs(volume) > 1e-14 * math.sqrt(dot(nc, nc) * dot(ec, ec)):
        r, s, t = -dot(p, na) / volume, -dot(p, nb) / volume, -dot(p, nc) / volume
        if r >= 0.0 and s >= 0.0 and t >= 0.0 and r + s + t <= 1.0:
            return Vec3(0.0, 0.0, 0.0), 7, r, s, t
    if t <= INNER:
        q, f, g, found = _on_face(p, ea, eb, nc)
        if found and dot(q, q) < best:
            v, best, chosen, x, y, z = q, dot(q, q), 3, f, g, 0.0
    if s <= INNER:
        q, f, g, found = _on_face(p, ec, ea, nb)
        if found and dot(q, q) < best:
            v, best, chosen, x, y, z = q, dot(q, q), 5, g, 0.0, f
    if r <= INNER:
        q, f, g, found = _on_face(p, eb, ec, na)
        if found and dot(q, q) < best:
            v, best, chosen, x, y, z = q, dot(q, q), 6, 0.0, f, g
    return v, chosen, x, y, z


@inlined
def _on_edge(p, e):
    """The point of the line p + t e nearest to the origin, t, and whether it lies between the ends."""
    ee, t = dot(e, e), -dot(p, e)
    if not 0.0 < t < ee:
        return p, 0.0, False
    t /= ee
    return p + e * t, t, True


@inlined
def _on_face(p, e, f, n):
    """The point of the plane p + s e + t f, whose normal is n = e x f, nearest to the origin; s, t, and whether it lies
    inside the triangle."""
    nn = dot(n, n)
    if nn <= 1e-28 * dot(e, e) * dot(f, f):
        return p, 0.0, 0.0, False
    one = 1.0 / nn
    s, t = -dot(cross(p, f), n) * one, -dot(cross(e, p), n) * one
    return n * (dot(p, n) * one), s, t, s > 0.0 and t > 0.0 and s + t < 1.0
