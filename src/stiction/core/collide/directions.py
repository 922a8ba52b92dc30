"""The direction along which two convex shapes that overlap are least deep in each other.

The separation along a direction n is sigma(n) = min of n . (b - a) over the points of both shapes. Its largest value
over all directions is the distance of shapes that are apart, and minus the least translation out of those that overlap.

Apart, GJK finds it. Two polytopes that overlap have it along the normal of a face, or of two edges whose arcs cross on
the sphere of normals (Gregorius, "The separating axis test between convex polyhedra", GDC 2013). From a direction n
that is good already one climbs by GJK: B moved out along n until it is a little apart, the direction n' of the
distance is at least as good, for if the gap of the moved shapes along n is d,

    sigma(n') >= d - (d - sigma(n)) n . n' >= sigma(n).

Where the surface is flat one step is enough; where it is curved the error shrinks by (depth + d) / (radius + d) a step.
"""

from __future__ import annotations

import math

from stiction.core.collide.capsule import nearest_on_segments, perpendicular
from stiction.core.collide.gjk import closest
from stiction.core.collide.hulls import (
    POINT,
    SEGMENT,
    is_ellipsoid,
    number_of_two,
    reach_point,
    shrunk,
    support,
    two_best,
    vertex,
)
from stiction.core.jit import inlined, jit
from stiction.core.vec import Vec3, column, cross, dot, length, transpose, vec3

LIFT = 0.1
LEAST_LIFT = 1e-2
"""Gap to which shapes are moved apart, in parts of the least half width, first and then."""
FINE, COARSE = 1e-11, 1e-5
"""Parts of the distance by which it may exceed its bound: for a normal good to a few microradians, and on the way."""
LIFTS = 6
STALLED = 1e-10
"""Progress below this part of the least half width ends it."""
SHRINKS = (0.9, 0.5, 0.25)
"""Cylinders that overlap are shrunk to these parts, for directions to begin with, ..."""
TRIED = 2
"""... and so many steps up from each tell which is best: the deepest of the starts may lead highest."""
SHALLOW = 1e-3
"""Unless the best direction so far gives a smaller overlap than this part of the least half width."""
ON_SIDE = 0.01
"""A cylinder whose axis has a larger cosine with the direction is near with a rim, else with its side."""
NEWTONS = 8
TOUCHING = 1e-9
"""Polytopes that are closer than this part of the least half width overlap, for GJK."""


@inlined
def along(A, B, hulls, n):
    """sigma(n) of the cores."""
    return dot(n, support(B, hulls, -n) - support(A, hulls, n))


@jit
def climb(A, B, hulls, n, sigma, wa, wb, lift, floor, fine, stalled, lifts):
    """Improve n, along which the cores are ``sigma`` apart at wa and wb, until a step gains less than ``stalled``.

    Returns whether they are more than ``floor`` apart (what is found then is their distance, if ``floor`` is not
    negative), the direction, sigma, and the nearest points. ``lift`` is the gap of the first step, ``fine`` the part of
    the distance by which the last one's may exceed its bound.
    """
    small = min(A.small, B.small)
    gap = lift
    apart = False
    for _ in range(lifts):
        apart = sigma > floor
        shift = Vec3(0.0, 0.0, 0.0) if apart else n * (gap - sigma)
        tolerance = COARSE if gap > LEAST_LIFT * small and not apart else fine
        gap = LEAST_LIFT * small
        proven, straight, bound, m, wa, wb = between_lines(A, B, hulls, shift, n, tolerance)
        if not proven:
            _, bound, m, wa, wb = closest(A, B, hulls, shift, n, math.inf, 0.0, tolerance)
        bound -= dot(shift, m)
        before = sigma
        if bound > sigma:
            n, sigma = m, bound
        if apart or straight or (tolerance == fine and bound <= before + stalled):
            break
    return apart, n, sigma, wa, wb


@jit
def between_lines(A, B, hulls, shift, n, tolerance):
    """The distance of A from B moved by ``shift``, if they are nearest to each other with the edges, or the sides or a
    rim of cylinders, that reach farthest along n: as :func:`closest`, but first whether it is proven.

    It is if the cores are as far apart along the line between the nearest points as these points are, but for a part
    ``tolerance``. Then comes whether they are nearest somewhere within two straight lines: the direction is across both
    then, wherever B is moved to.
    """
    if is_ellipsoid(A) or is_ellipsoid(B):
        return False, False, 0.0, n, A.p, B.p
    p, u, ra = _line_at(A, hulls, n)
    q, v, rb = _line_at(B, hulls, -n)
    q = q + shift
    tilt_a = dot(column(A.R, 2), n) if A.round else 0.0
    tilt_b = dot(column(B.R, 2), n) if B.round else 0.0
    s, t, straight = 0.5, 0.5, False
    if abs(tilt_a) > ON_SIDE:
        if abs(tilt_b) > ON_SIDE:
            return False, False, 0.0, n, p, q
        side = math.copysign(1.0, tilt_a)
        t, x = _rim_and_line(p + u if tilt_a > 0.0 else p, column(A.R, 2) * side, ra, q, v)
        y, ra = q + v * t, 0.0
    elif abs(tilt_b) > ON_SIDE:
        side = math.copysign(1.0, tilt_b)
        s, y = _rim_and_line(q if tilt_b > 0.0 else q + v, column(B.R, 2) * -side, rb, p, u)
        x, rb = p + u * s, 0.0
    else:
        s, t = nearest_on_segments(p, u, q, v)
        x, y = p + u * s, q + v * t
        straight = 0.0 < s < 1.0 and 0.0 < t < 1.0
    size = length(y - x)
    if size <= ra + rb or (A.round and not 0.0 < s < 1.0) or (B.round and not 0.0 < t < 1.0):
        return False, False, 0.0, n, x, y
    m = (y - x) * (1.0 / size)
    upper, bound = size - ra - rb, along(A, B, hulls, m) + dot(shift, m)
    proven = upper - bound <= tolerance * upper
    return proven, proven and straight, bound, m, x + m * ra, y - m * rb - shift


@jit
def _rim_and_line(c, out, radius, p, u):
    """Where p + t u, t in 0 to 1, comes nearest to a rim about c from outside: t, and the point of the rim.
    ``out``: the normal of the disc, on the side of the line.

    Newton on the derivative of half the squared distance, which is convex where the line is not over the disc. So it
    begins where the line is nearest to the axis, or if that is over the disc, where the line leaves it on its way down.
    """
    uu, rise = dot(u, u), dot(u, out)
    w = u - out * rise
    ww = dot(w, w)
    t, x = 0.5, c
    if ww > 0.0:
        d = p - c
        d = d - out * dot(d, out)
        part = dot(d, w)
        over = part * part - ww * (dot(d, d) - radius * radius)
        t = (-part - math.copysign(math.sqrt(max(over, 0.0)), rise)) / ww
        t = min(max(t, 0.0), 1.0)
    for _ in range(NEWTONS):
        y = p + u * t
        d = y - c
        d = d - out * dot(d, out)
        size = length(d)
        if size <= 0.0:
            break
        d = d * (1.0 / size)
        x = c + d * radius
        part = dot(d, w)
        slope = uu - radius / size * (ww - part * part)
        if slope <= 1e-12 * uu:
            break
        before = t
        t = min(max(t - dot(u, y - x) / slope, 0.0), 1.0)
        # an edge that is not quite across the direction costs the bound its length
        if abs(t - before) <= 1e-14:
            break
    return t, x


@inlined
def _line_at(X, hulls, n):
    """The edge with which X reaches farthest along n, or the axis of a cylinder: an end, the way to the other one, and
    the radius of what is around it. An edge is between the best vertex and the next best."""
    s = X.scale
    if X.round or X.hull == SEGMENT:
        h = column(X.R, 2) * s.z
        return X.p - h, h * 2.0, s.x
    m = transpose(X.R) @ n
    if X.hull <= POINT:
        p = reach_point(X, hulls, m)
        x, y, z = abs(m.x * s.x), abs(m.y * s.y), abs(m.z * s.z)
        u = Vec3(0.0, 0.0, -2.0 * p.z)
        if x <= y and x <= z:
            u = Vec3(-2.0 * p.x, 0.0, 0.0)
        elif y <= z:
            u = Vec3(0.0, -2.0 * p.y, 0.0)
        return X.p + X.R @ p, X.R @ u, 0.0
    one, other = two_best(hulls, X.hull, Vec3(m.x * s.x, m.y * s.y, m.z * s.z))
    p = vertex(X, hulls, one)
    return p, vertex(X, hulls, other) - p, 0.0


@jit
def look_around(A, B, hulls, n, sigma, wa, wb):
    """The best direction for cores that overlap or nearly touch one of which is curved: n or better.

    Guesses, then GJK for shrunken shapes, and from the best of them a climb.
    """
    small = min(A.small, B.small)
    for c in range(8):
        m = _guess(A, B, c)
        bound = along(A, B, hulls, m)
        if bound > sigma:
            n, sigma = m, bound
    for factor in SHRINKS:
        if sigma > -SHALLOW * small:
            break
        P, Q = shrunk(A, hulls, factor), shrunk(B, hulls, factor)
        clear, _, m, _, _ = closest(P, Q, hulls, Vec3(0.0, 0.0, 0.0), B.p - A.p, math.inf, TOUCHING * small, COARSE)
        if clear:
            bound = along(A, B, hulls, m)
            gap, stalled = LEAST_LIFT * small, SHALLOW * small
            _, m, bound, _, _ = climb(A, B, hulls, m, bound, wa, wb, gap, math.inf, COARSE, stalled, TRIED)
            if bound > sigma:
                n, sigma = m, bound
    return climb(A, B, hulls, n, sigma, wa, wb, LIFT * small, math.inf, FINE, STALLED * small, LIFTS)


@jit
def best_face(A, B, hulls, wa, wb, least, slack):
    """The face along whose normal the cores are farthest apart, farther than ``least``: its number, whose it is (0 or
    1), the normal from A to B, and how far. -1 if there are none. Faces of A are better by ``slack`` than those of B.

    Any point of the other shape bounds how far it is from a face: what is bounded by less than the best so far is
    passed over. So wa and wb, points of A and of B, should be deep in the other shape.
    """
    face, owner, n, best = -1, 0, Vec3(0.0, 0.0, 0.0), -math.inf
    f, m, s = _best_of(A, B, hulls, wb, least)
    if f >= 0:
        face, n, best = f, m, s
    f, m, s = _best_of(B, A, hulls, wa, max(least, best + slack))
    if f >= 0:
        face, owner, n, best = f, 1, -m, s
    return face, owner, n, best


@jit
def _best_of(F, X, hulls, w, least):
    """The same for the faces of F alone: number, outward normal, and how far X is along it; -1 if none is better."""
    w, s = transpose(F.R) @ (w - F.p), F.scale
    face, n, best = -1, w, least
    if F.round:
        for f in range(2):
            side = 1.0 - 2.0 * f
            if side * w.z - s.z > best:
                m = column(F.R, 2) * side
                h = dot(m, support(X, hulls, -m) - F.p) - s.z
                if h > best:
                    face, n, best = f, m, h
        return face, n, best
    planes = hulls.planes
    first = hulls.spans[F.hull, 2]
    for i in range(first, first + hulls.spans[F.hull, 3]):
        m = Vec3(planes[i, 0], planes[i, 1], planes[i, 2])
        # only the cube is scaled, and its normals are axes
        offset = planes[i, 3] * (m.x * m.x * s.x + m.y * m.y * s.y + m.z * m.z * s.z)
        if dot(m, w) - offset > best:
            m = F.R @ m
            h = dot(m, support(X, hulls, -m) - F.p) - offset
            if h > best:
                face, n, best = i - first, m, h
    return face, n, best


@jit
def _guess(A, B, c):
    """Directions from which to improve: between the origins, across each axis, and across both; either way."""
    d = B.p - A.p
    x, y = column(A.R, 2), column(B.R, 2)
    m = d
    if c >> 1 == 1:
        m = d - x * dot(d, x)
    elif c >> 1 == 2:
        m = d - y * dot(d, y)
    elif c >> 1 == 3:
        m = cross(x, y)
    size = length(m)
    m = m * (1.0 / size) if size > 1e-9 * length(d) and size > 1e-9 else perpendicular(x)
    return m if c & 1 else -m


@jit
def best_edges(A, B, hulls):
    """The two edges along whose common normal the cores are farthest apart: the normal, how far, the nearest points of
    the edges, and the feature. Works in the axes of B."""
    R = transpose(B.R) @ A.R
    d = transpose(B.R) @ (A.p - B.p)
    h = hulls
    n, best, wa, wb, feature = d, -math.inf, d, d, -1
    va, fb = h.spans[A.hull, 0], h.spans[B.hull, 0]
    for i in range(h.spans[A.hull, 4], h.spans[A.hull, 4] + h.spans[A.hull, 5]):
        p = d + R @ scaled_vertex(A, h, h.edges[i, 0])
        u = d + R @ scaled_vertex(A, h, h.edges[i, 1]) - p
        bounded_a = h.edges[i, 2] >= 0
        a0 = R @ vec3(h.planes, h.edges[i, 2], 0) if bounded_a else u
        a1 = R @ vec3(h.planes, h.edges[i, 3], 0) if bounded_a else u
        for j in range(h.spans[B.hull, 4], h.spans[B.hull, 4] + h.spans[B.hull, 5]):
            q = scaled_vertex(B, h, h.edges[j, 0])
            v = scaled_vertex(B, h, h.edges[j, 1]) - q
            # the arc of normals of either edge must cross the plane of the other's: then the arcs may cross
            if bounded_a and dot(a0, v) * dot(a1, v) >= 0.0:
                continue
            bounded_b = h.edges[j, 2] >= 0
            b0 = vec3(h.planes, h.edges[j, 2], 0) if bounded_b else v
            b1 = vec3(h.planes, h.edges[j, 3], 0) if bounded_b else v
            if bounded_b and dot(b0, u) * dot(b1, u) >= 0.0:
                continue
            m = cross(u, v)
            size = length(m)
            if size <= 1e-6 * length(u) * length(v):
                continue
            # out of A, into B
            side = dot(m, a0 + a1) if bounded_a else (-dot(m, b0 + b1) if bounded_b else -dot(m, p))
            m = m * (math.copysign(1.0, side) / size)
            if bounded_a and bounded_b and dot(m, b0 + b1) >= 0.0:
                continue
            s = dot(m, q - p)
            if s > best:
                n, best = m, s
                s, t = nearest_on_segments(p, u, q, v)
                wa, wb = p + u * s, q + v * t
                feature = (
                    (1 << 36)
                    | (number_of_two(h.edges[i, 0] - va, h.edges[i, 1] - va) << 18)
                    | number_of_two(h.edges[j, 0] - fb, h.edges[j, 1] - fb)
                )
    return B.R @ n, best, B.p + B.R @ wa, B.p + B.R @ wb, feature


@jit
def scaled_vertex(X, hulls, i):
    """Vertex of row i, in the axes of the shape."""
    v = hulls.vertices
    return Vec3(v[i, 0] * X.scale.x, v[i, 1] * X.scale.y, v[i, 2] * X.scale.z)
