"""Contacts of two convex shapes that have no formula of their own: polytopes, cylinders, and what rounds their corners.

The separation along a direction n is sigma(n) = min of n . (b - a) over the points of both shapes. Its largest value
over all directions is the distance of shapes that are apart, and minus the least translation out of those that overlap.

Apart, GJK finds it. Two polytopes that overlap have it along the normal of a face, or of two edges whose arcs cross on
the sphere of normals (Gregorius, "The separating axis test between convex polyhedra", GDC 2013). For a cylinder that
overlaps or nearly touches, the best of a few directions n is improved by GJK: B moved out along n until it is a little
apart, the direction n' of the distance is at least as good, for if the gap of the moved shapes along n is d,

    sigma(n') >= d - (d - sigma(n)) n . n' >= sigma(n).

Where the surface is flat one step is enough; where it is curved the error shrinks by (depth + d) / (radius + d) a step.

With the normal, a face that is as good as the best direction is the reference, and what lies over it is clipped to it.
"""

from __future__ import annotations

import math

from stiction.core.collide.capsule import nearest_on_segments, perpendicular
from stiction.core.collide.clip import clip_face, clip_lines
from stiction.core.collide.gjk import closest
from stiction.core.collide.hulls import POINT, face_count, face_plane, shrunk, support
from stiction.core.collide.manifold import emit, reduce
from stiction.core.jit import bare
from stiction.core.vec import Vec3, column, cross, dot, length, transpose, vec3

FACE_PREFERENCE = 0.005
"""Two edges must be better than the best face by this part of the least half width."""
ROUND_PREFERENCE = 0.001
"""The same where something round touches, and for the face of the one shape before that of the other."""
LIFT = 0.1
LEAST_LIFT = 1e-2
"""Gap to which shapes are moved apart, in parts of the least half width, first and then."""
FINE, COARSE = 1e-11, 1e-5
"""Parts of the distance by which it may exceed its bound: for a normal good to a few microradians, and on the way."""
LIFTS = 6
STALLED = 1e-10
"""Progress below this part of the least half width ends it."""
SHRINKS = 2
SHRINK = 0.5
"""Cylinders that overlap are shrunk to this part, then to its square, for a direction to begin with."""
SHALLOW = 1e-3
"""Unless the best direction so far gives a smaller overlap than this part of the least half width."""
TOUCHING = 1e-9
"""Polytopes that are closer than this part of the least half width overlap, for GJK."""
MOST_EDGE_PAIRS = 16384
"""Larger hulls are lifted instead of trying all pairs of edges."""


@bare
def convex_convex(contacts, tags, count, a, A, b, B, origin, hulls, margin, points):
    """Up to four points. The coordinates of A and B are relative to ``origin``."""
    zero = Vec3(0.0, 0.0, 0.0)
    r, small = A.radius + B.radius, min(A.small, B.small)
    round_one = A.round or B.round
    curved = round_one or hulls.spans[A.hull, 5] * hulls.spans[B.hull, 5] > MOST_EDGE_PAIRS
    gap = LIFT * small

    n, sigma, wa, wb, feature = zero, -math.inf, zero, zero, -1
    face, owner, face_n, face_sigma = -1, 0, zero, -math.inf
    apart, limit, floor = False, margin + r, gap if curved else TOUCHING * small
    for k in range(1 + SHRINKS + LIFTS):
        factor, shift, start, tolerance = 1.0, zero, B.p - A.p, FINE
        if k > SHRINKS:
            shift, start, floor = n * (gap - sigma), n, 0.0
            tolerance = COARSE if gap > LEAST_LIFT * small else FINE
            gap = LEAST_LIFT * small
        elif k > 0:
            if sigma > -SHALLOW * small:
                continue
            factor, tolerance = SHRINK**k, COARSE
        P, Q = (A, B) if factor == 1.0 else (shrunk(A, hulls, factor), shrunk(B, hulls, factor))
        clear, bound, m, pa, pb = closest(P, Q, hulls, shift, start, limit, floor, tolerance, points)
        bound -= dot(shift, m)
        if k == 0:
            if bound - r > margin:
                return count
            if clear:
                apart, n, sigma, wa, wb = True, m, bound, pa, pb
            if not (apart and A.hull == POINT):
                face, owner, face_n, face_sigma = _best_face(A, B, hulls, ROUND_PREFERENCE * small)
                if face_sigma - r > margin:
                    return count
            if not curved and not apart:
                n, sigma, wa, wb, feature = _best_edges(A, B, hulls)
            if apart or not curved:
                break
            n, sigma = face_n, face_sigma
            for c in range(8):
                m = _guess(A, B, c)
                bound = _along(A, B, hulls, m)
                if bound > sigma:
                    n, sigma = m, bound
            limit, floor = math.inf, TOUCHING * small
        elif k <= SHRINKS:
            if clear:
                bound = _along(A, B, hulls, m)
                if bound > sigma:
                    n, sigma = m, bound
        else:
            wa, wb = pa, pb
            before = sigma
            if bound > sigma:
                n, sigma = m, bound
            if tolerance == FINE and bound <= before + STALLED * small:
                break

    found, normal = 0, n
    slack = (ROUND_PREFERENCE if round_one or r > 0.0 else FACE_PREFERENCE) * small
    if face >= 0 and face_sigma >= sigma - slack:
        normal = face_n
        F, X, out = A, B, face_n
        if owner == 1:
            F, X, out = B, A, -face_n
        found = clip_face(F, face, out, X, owner, hulls, margin, points)
        found = reduce(points, found, out)
        deepest = math.inf
        for i in range(found):
            deepest = min(deepest, points[i, 3])
        if (apart or round_one) and deepest > sigma - r + 2.0 * slack:
            found = 0  # the nearest place lies beside the face
        if found == 0 and face_sigma > sigma + slack:
            # the face of X that looks at this one lies beside it: X touches with its lowest point
            n, sigma, feature = face_n, face_sigma, -1
            p = support(X, hulls, -out)
            wa, wb = (p - n * sigma, p) if owner == 0 else (p, p + n * sigma)
    elif sigma == -math.inf:
        # cores without a face that overlap
        n = perpendicular(column(A.R, 2))
        sigma = _along(A, B, hulls, n)
    if found == 0:
        normal = n
        if sigma - r > margin:
            return count
        if apart or round_one:
            found = clip_lines(A, B, n, sigma - r, hulls, margin, points)
    for i in range(found):
        count = emit(contacts, tags, count, a, b, origin + vec3(points, i, 0), normal, points[i, 3], int(points[i, 4]))
    if found == 0:
        point = (wa + n * A.radius + wb - n * B.radius) * 0.5
        if feature < 0:
            feature = (1 << 36) | (_feature(A, hulls, n) << 18) | _feature(B, hulls, -n)
        count = emit(contacts, tags, count, a, b, origin + point, n, sigma - r, feature)
    return count


@bare
def _along(A, B, hulls, n):
    """sigma(n) of the cores."""
    return dot(n, support(B, hulls, -n) - support(A, hulls, n))


@bare
def _best_face(A, B, hulls, slack):
    """The face along whose normal the cores are farthest apart: its number, whose it is (0 or 1), the normal from A to
    B, and how far. -1 if there are none."""
    face, owner, n, best = -1, 0, Vec3(0.0, 0.0, 0.0), -math.inf
    for side in range(2):
        F, X = A, B
        if side == 1:
            F, X = B, A
        for f in range(face_count(F, hulls)):
            m, offset = face_plane(F, hulls, f)
            s = dot(m, support(X, hulls, -m) - F.p) - offset - side * slack
            if s > best:
                face, owner, n, best = f, side, m if side == 0 else -m, s
    return face, owner, n, best + owner * slack


@bare
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


@bare
def _best_edges(A, B, hulls):
    """The two edges along whose common normal the cores are farthest apart: the normal, how far, the nearest points of
    the edges, and the feature. Works in the axes of B."""
    R = transpose(B.R) @ A.R
    d = transpose(B.R) @ (A.p - B.p)
    h = hulls
    n, best, wa, wb, feature = d, -math.inf, d, d, -1
    va, fb = h.spans[A.hull, 0], h.spans[B.hull, 0]
    for i in range(h.spans[A.hull, 4], h.spans[A.hull, 4] + h.spans[A.hull, 5]):
        p = d + R @ _scaled(A, h, h.edges[i, 0])
        u = d + R @ _scaled(A, h, h.edges[i, 1]) - p
        bounded_a = h.edges[i, 2] >= 0
        a0 = R @ vec3(h.planes, h.edges[i, 2], 0) if bounded_a else u
        a1 = R @ vec3(h.planes, h.edges[i, 3], 0) if bounded_a else u
        for j in range(h.spans[B.hull, 4], h.spans[B.hull, 4] + h.spans[B.hull, 5]):
            q = _scaled(B, h, h.edges[j, 0])
            v = _scaled(B, h, h.edges[j, 1]) - q
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
                    | (_pair(h.edges[i, 0] - va, h.edges[i, 1] - va) << 18)
                    | _pair(h.edges[j, 0] - fb, h.edges[j, 1] - fb)
                )
    return B.R @ n, best, B.p + B.R @ wa, B.p + B.R @ wb, feature


@bare
def _scaled(X, hulls, i):
    v = hulls.vertices
    return Vec3(v[i, 0] * X.scale.x, v[i, 1] * X.scale.y, v[i, 2] * X.scale.z)


@bare
def _pair(i, j):
    """One number of two vertices, in either order; huge hulls repeat it."""
    return (min(i, j) & 511) << 9 | (max(i, j) & 511)


@bare
def _feature(X, hulls, n):
    """The vertex, or the first two, or the part of a cylinder, that reaches farthest along n."""
    if X.round:
        c = dot(column(X.R, 2), n)
        return 0 if c > 1e-6 else (1 if c < -1e-6 else 2)
    m = transpose(X.R) @ n
    first, number = hulls.spans[X.hull, 0], hulls.spans[X.hull, 1]
    high = dot(m, transpose(X.R) @ (support(X, hulls, n) - X.p)) - 1e-6 * X.small
    one, other = -1, -1
    for i in range(number):
        if dot(m, _scaled(X, hulls, first + i)) >= high:
            if one < 0:
                one = i
            elif other < 0:
                other = i
    return _pair(max(one, 0), other if other >= 0 else max(one, 0))
