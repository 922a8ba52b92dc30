"""What two shapes touch each other with, once the normal is known: a face and what lies over it, or two lines.

Clipping after Sutherland and Hodgman, "Reentrant polygon clipping", Comm. ACM 17, 1974.
"""

from __future__ import annotations

import math

from stiction.core.collide.hulls import (
    POINT,
    SEGMENT,
    corner,
    corner_count,
    face_plane,
    facing,
    is_ellipsoid,
    number_of_two,
    support,
    two_best,
    vertex,
)
from stiction.core.collide.manifold import ENDLESS, ROUND, put_radii
from stiction.core.jit import inlined, jit
from stiction.core.vec import Vec3, column, cross, dot, length, put_vec3, transpose, vec3

BUFFER = 64
"""Rows of each of the two buffers."""
FLAT = 1e-3
"""A cap that is tilted by less (rad) lies flat: it touches with four points fixed to it, else with its lowest one."""
FLAT_COSINE = 1.0 - 0.5 * FLAT * FLAT
UPRIGHT = 0.7
"""A cylinder whose axis has a larger cosine with the normal touches with a cap, else with its side."""
BORDER = 1e-6
"""Points beyond the border of a face by this part of the shape's least width are over it still, so that two faces with
a common border keep their corners."""
PARALLEL = 0.02
"""Lines whose directions differ by less (rad) touch with two points."""


@jit
def lowest(X, n):
    """The direction in the caps of a cylinder in which they reach farthest against n; the body's x axis if flat."""
    axis = column(X.R, 2)
    d = axis * dot(axis, n) - n
    size = length(d)
    return column(X.R, 0) if size < FLAT else d * (1.0 / size)


@inlined
def clip_face(F, f, n, X, owner, hulls, margin, points):
    """Points of X over face f of F, whose outward normal is n, up to the margin; returns their number.

    They fill the first rows of ``points``. Feature: whose face, which, the face of X over it, and the corner of that
    one or the side that cuts it.
    """
    _, offset = face_plane(F, hulls, f)
    base = (owner << 32) | (f << 20)

    # the face of X that looks at f, or its lowest line or point
    found, g = 1, -1
    if X.hull <= POINT and X.hull >= SEGMENT:
        first = hulls.spans[X.hull, 0]
        found = hulls.spans[X.hull, 1]
        for k in range(found):
            put_vec3(points, k, 0, vertex(X, hulls, first + k))
    elif is_ellipsoid(X):
        put_vec3(points, 0, 0, support(X, hulls, -n))
    else:
        u = Vec3(0.0, 0.0, 0.0)
        if X.round:
            u = lowest(X, n)
        if X.round and abs(dot(column(X.R, 2), n)) < UPRIGHT:
            found = 2
            for k in range(2):
                put_vec3(points, k, 0, corner(X, hulls, k, 0, u))
        else:
            g = facing(X, hulls, -n)
            found = corner_count(X, hulls, g)
            for k in range(found):
                put_vec3(points, k, 0, corner(X, hulls, g, k, u))
    if g >= 0 and (F.round or X.round):
        m, h = face_plane(X, hulls, g)
        if dot(m, n) < -FLAT_COSINE:
            if F.round and _covers(X, g, m, F.p + n * offset, F.scale.x, hulls):
                return _disc(F, F.p + n * offset, n, X.p, m, h, margin, base, points)
            if X.round and _covers(F, f, n, X.p + m * h, X.scale.x, hulls):
                return _disc(X, X.p + m * h, n, F.p, n, offset, margin, base, points)

    for k in range(found):
        points[k, 3] = dot(n, vec3(points, k, 0) - F.p) - offset - X.radius
        points[k, 4] = k
    source = 0
    sides = corner_count(F, hulls, f)
    start = column(F.R, 0)
    here = corner(F, hulls, f, sides - 1, start)
    for k in range(sides):
        there = corner(F, hulls, f, k, start)
        s = cross(there - here, n)
        found = _cut(points, source, found, g >= 0, s, dot(s, here) + BORDER * F.small * length(s), 2 * k)
        source = BUFFER - source
        here = there

    base |= (g + 1) << 8
    touching = 0
    for row in range(source, source + found):
        separation = points[row, 3]
        if separation <= margin:
            # half way between the face and the surface of X
            put_vec3(points, touching, 0, vec3(points, row, 0) - n * (X.radius + 0.5 * separation))
            points[touching, 3], points[touching, 4] = separation, base | int(points[row, 4])
            touching += 1
    return touching


@inlined
def _cut(points, source, n, closed, s, limit, side):
    """Cut a polygon, or an open line, by the half space s . x <= limit into the other buffer; returns its new size."""
    target = BUFFER - source
    kept = 0
    for q in range(n):
        here = source + q
        there = source + (q + 1 if q + 1 < n else 0)
        d0 = dot(s, vec3(points, here, 0)) - limit
        d1 = dot(s, vec3(points, there, 0)) - limit
        if d0 <= 0.0 and kept < BUFFER:
            for c in range(5):
                points[target + kept, c] = points[here, c]
            kept += 1
        if (d0 <= 0.0) != (d1 <= 0.0) and (closed or q + 1 < n) and kept < BUFFER:
            t = d0 / (d0 - d1)
            for c in range(4):
                points[target + kept, c] = points[here, c] + t * (points[there, c] - points[here, c])
            points[target + kept, 4] = BUFFER + side + (1 if d1 > 0.0 else 0)
            kept += 1
    return kept


@jit
def _covers(X, g, m, center, radius, hulls):
    """Whether a disc lies within face g of X, whose normal is m."""
    if X.round:
        d = center - X.p
        d = d - m * dot(m, d)
        return length(d) + radius <= X.scale.x * (1.0 + FLAT)
    sides = corner_count(X, hulls, g)
    here = corner(X, hulls, g, sides - 1, m)
    for k in range(sides):
        there = corner(X, hulls, g, k, m)
        s = cross(there - here, m)
        if dot(s, center - here) > -radius * (1.0 - FLAT) * length(s):
            return False
        here = there
    return True


@jit
def _disc(X, center, n, p, m, offset, margin, base, points):
    """Four points of the rim of X's disc against the plane m . (x - p) = offset, seen along n.

    They are fixed to X, so that they stay while it stands; n points out of the reference face.
    """
    found = 0
    for k in range(4):
        r = column(X.R, k & 1) * (X.scale.x if k < 2 else -X.scale.x)
        along = dot(m, n)
        separation = (dot(m, center + r - p) - offset) / abs(along)
        if separation <= margin:
            put_vec3(points, found, 0, center + r - n * (math.copysign(0.5, along) * separation))
            points[found, 3], points[found, 4] = separation, base | k
            found += 1
    if found == 4:
        for k in range(4):
            points[k, 4] = ROUND | int(points[k, 4])
    return found


@jit
def _line(X, hulls, n):
    """The line with which X reaches farthest along n: whether there is one, its ends, the radius about it, and which
    edge it is."""
    if is_ellipsoid(X):
        return False, X.p, X.p, 0.0, 0
    if X.round or X.hull == SEGMENT:
        axis = column(X.R, 2)
        h = axis * X.scale.z
        return abs(dot(axis, n)) < PARALLEL, X.p - h, X.p + h, X.scale.x if X.round else X.radius, 0
    m, s = transpose(X.R) @ n, X.scale
    one, other = two_best(hulls, X.hull, Vec3(m.x * s.x, m.y * s.y, m.z * s.z))
    one, other = min(one, other), max(one, other)
    first = hulls.spans[X.hull, 0]
    p, q = vertex(X, hulls, one), vertex(X, hulls, other)
    ok = one != other and abs(dot(n, q - p)) < PARALLEL * length(q - p)
    return ok, p, q, X.radius, number_of_two(one - first, other - first)


@jit
def clip_lines(A, B, n, sigma, first, hulls, margin, points):
    """The ends of what two nearly parallel lines have in common, if they touch along it; returns their number, 0 or 2.

    ``sigma`` is the separation of the shapes: lines that come nearest somewhere between the ends do not count. Feature:
    the edges, and whose end it is. ``first``: whether A is the first body of the pair.
    """
    one, p, q, ra, ea = _line(A, hulls, n)
    if not one:
        return 0
    other, u, v, rb, eb = _line(B, hulls, -n)
    if not other:
        return 0
    LA, LB = length(q - p), length(v - u)
    e = (q - p) * (1.0 / LA)
    if length(cross(e, v - u)) > PARALLEL * LB:
        return 0
    s0, s1 = dot(u - p, e), dot(v - p, e)
    low, high = max(0.0, min(s0, s1)), min(LA, max(s0, s1))
    if high - low < 0.01 * min(LA, LB):
        return 0
    base = (3 << 41) | (ea << 22) | (eb << 4)
    found, best = 0, math.inf
    for k in range(2):
        s = low if k == 0 else high
        a, b = p + e * s, u + (v - u) * ((s - s0) / (s1 - s0))
        h = dot(b - a, n)
        if ra + rb > 0.0 and h > 0.0:
            h = length(b - a)
        # a line that is slightly oblique is rounder than the shape about it, which is nowhere nearer than they are
        separation = max(h - ra - rb, sigma)
        best = min(best, separation)
        if separation <= margin:
            put_vec3(points, found, 0, (a + n * ra + b - n * rb) * 0.5)
            own = low == 0.0 if k == 0 else high == LA
            points[found, 3] = separation
            points[found, 4] = base | ((0 if own else 2) + ((k if s1 > s0 else 1 - k) if not own else k))
            found += 1
    if best > sigma + 0.01 * min(A.small, B.small):
        return 0
    # along the lines the normal follows A
    put_radii(points, first, e, ENDLESS, ra)
    put_radii(points, not first, e, 0.0, rb)
    return found
