"""Contacts of two convex shapes that have no formula of their own: polytopes, cylinders, ellipsoids, and what rounds
their corners.

First the direction along which they are farthest apart, or least deep in each other (``directions``); then a face that
is as good as the best direction, or was a moment ago, is the reference, and what lies over it is clipped to it.

A pair that was looked at a moment ago has a direction to begin with. All faces that could be better than it are tried;
and if the deepest of the points that lie over the best face is as deep as the shapes are along its normal, this may be
the best direction far and wide: with x the point of the one shape and f the foot below it, in the other shape, at
height h = n . (x - f), sigma(m) <= m . (x - f) = h m . n <= |h| for any m. If they overlap by more than what is slack
anyway, it is the best if x is as far from all of the other's border: sigma(m) <= -d if a ball of radius d about x is
in it. Else one climbs from there; the edges of polytopes need not be tried in pairs.
"""

from __future__ import annotations

import math

from stiction.core.collide.capsule import perpendicular
from stiction.core.collide.clip import clip_face, clip_lines
from stiction.core.collide.curved import feature_at, inside_of, radii_over_face
from stiction.core.collide.directions import (
    LEAST_LIFT,
    LIFT,
    TOUCHING,
    along,
    best_edges,
    best_face,
    climb,
    look_around,
)
from stiction.core.collide.ellipsoid import is_smooth, sharpen
from stiction.core.collide.gjk import closest
from stiction.core.collide.hulls import NOTHING, POINT, depth_in, face_below, support
from stiction.core.collide.manifold import ENDLESS, emit, lasting, put_lead, put_radii, reduce
from stiction.core.jit import jit
from stiction.core.vec import Vec3, column, dot, length, vec3

FACE_PREFERENCE = 0.005
"""Two edges must be better than the best face by this part of the least half width."""
ROUND_PREFERENCE = 0.001
"""The same where something round touches, and for the face of the one shape before that of the other."""
FINE = 1e-11
"""Part of the distance by which it may exceed its bound: for a normal good to a few microradians."""
GOOD = 1e-8
"""The same for a direction that is improved a little in every step."""
MOST_EDGE_PAIRS = 16384
"""Larger hulls are lifted instead of trying all pairs of edges."""
DEEP = 0.1
"""Shapes that overlap by more than this part of the least half width are looked at from all sides, ..."""
CLIMBS, NEARLY = 6, 1e-5
"""... else improving a direction that is known takes so many steps, or ends with a gain below this part of it."""


@jit
def convex_convex(contacts, tags, count, a, A, b, B, origin, hint, hulls, margin, points):
    """Up to four points. The coordinates of A and B are relative to ``origin``; ``hint`` is a direction in which B may
    be found, of any length, or zero.

    Returns the new count; and, with no new point, a direction along which they are apart, and how far.
    """
    zero = Vec3(0.0, 0.0, 0.0)
    r, small = A.radius + B.radius, min(A.small, B.small)
    round_one = A.hull == NOTHING or B.hull == NOTHING
    curved = round_one or hulls.spans[A.hull, 5] * hulls.spans[B.hull, 5] > MOST_EDGE_PAIRS
    slack = (ROUND_PREFERENCE if round_one or r > 0.0 else FACE_PREFERENCE) * small
    # nearer than this, GJK is not asked for the distance as it is
    floor = LIFT * small if curved else TOUCHING * small

    n, sigma, wa, wb, feature = zero, -math.inf, zero, zero, -1
    known, apart = dot(hint, hint) > 0.0, False
    if A.hull == POINT and B.hull > NOTHING:
        sigma, n = face_below(B, hulls, A.p)
        apart, n = sigma > floor, -n
        wa, wb = A.p, A.p + n * sigma
    if apart:
        known = False
        if sigma - r > margin:
            return count, n, sigma - r
    elif known:
        n = hint * (1.0 / length(hint))
        wa, wb = support(A, hulls, n), support(B, hulls, -n)
        sigma = dot(n, wb - wa)
        if sigma - r > margin:
            return count, n, sigma - r
        known = sigma > -DEEP * small
    if not known and not apart:
        apart, sigma, n, wa, wb = closest(A, B, hulls, zero, B.p - A.p, margin + r, floor, FINE)
        if sigma - r > margin:
            return count, n, sigma - r
        if not apart:
            sigma = -math.inf

    face, owner, face_n, face_sigma, found, deepest = -1, 0, zero, -math.inf, 0, math.inf
    # a sphere that is outside touches with the point that GJK finds
    if not (A.hull == POINT and (apart or sigma > floor)):
        face, owner, face_n, face_sigma = best_face(
            A, B, hulls, wa, wb, sigma - slack if known else -math.inf, ROUND_PREFERENCE * small
        )
        if face_sigma - r > margin:
            return count, face_n, face_sigma - r
    keep = slack + lasting(hint, face_n, r - face_sigma, small)
    F, X, out = A, B, face_n
    if owner == 1:
        F, X, out = B, A, -face_n
    if face >= 0 and face_sigma >= sigma - keep:
        found = clip_face(F, face, out, X, owner, hulls, margin, points)
        found = reduce(points, found, out)
        for i in range(found):
            deepest = min(deepest, points[i, 3])
    sure = known and found > 0 and deepest <= face_sigma - r + slack
    if sure and face_sigma < -0.5 * slack:
        x = _middle(points, found, out, X.radius, deepest + slack)
        sure = depth_in(F, hulls, x) >= -face_sigma - slack
    if not sure and not apart:
        if known:
            gap, enough = LEAST_LIFT * small, NEARLY * small
            apart, n, sigma, wa, wb = climb(A, B, hulls, n, sigma, wa, wb, gap, floor, GOOD, enough, CLIMBS)
            if face_sigma > sigma:
                apart, n, sigma, wa, wb = climb(
                    A, B, hulls, face_n, face_sigma, wa, wb, gap, floor, GOOD, enough, CLIMBS
                )
        elif curved:
            if face_sigma > sigma:
                n, sigma = face_n, face_sigma
            _, n, sigma, wa, wb = look_around(A, B, hulls, n, sigma, wa, wb)
        else:
            n, sigma, wa, wb, feature = best_edges(A, B, hulls)
    if found == 0 and sigma > -math.inf and is_smooth(A) and is_smooth(B):
        n, sigma, wa, wb = sharpen(A, B, n)

    normal = n
    if sure:
        normal = face_n
    elif face >= 0 and face_sigma >= sigma - keep:
        normal = face_n
        if deepest > max(sigma, face_sigma) - r + 2.0 * keep:
            found = 0  # the nearest place lies beside the face
        if found == 0 and face_sigma > sigma:
            # the face of X that looks at this one lies beside it: X touches with its lowest point
            n, sigma, feature = face_n, face_sigma, -1
            p = support(X, hulls, -out)
            wa, wb = (p - n * sigma, p) if owner == 0 else (p, p + n * sigma)
    else:
        found = 0
        if sigma == -math.inf:
            # cores without a face that overlap
            n = perpendicular(column(A.R, 2))
            sigma = along(A, B, hulls, n)
    if found == 0:
        normal = n
        if sigma - r > margin:
            return count, n, sigma - r
        if (apart or round_one) and A.hull != POINT:
            found = clip_lines(A, B, n, sigma - r, a < b, hulls, margin, points)
    elif found <= 2:
        put_radii(points, (owner == 0) == (a < b), n, ENDLESS, ENDLESS)
        radii_over_face(X, out, found, (owner == 1) == (a < b), points)
        put_lead(points, inside_of(F, face, out, found, hulls, points))
    for i in range(found):
        count = emit(contacts, tags, count, a, b, origin + vec3(points, i, 0), normal, points[i, 3], int(points[i, 4]))
    if found == 0:
        point = (wa + n * A.radius + wb - n * B.radius) * 0.5
        if feature < 0:
            fa, lead_a = feature_at(A, hulls, n, wa, a < b, points)
            fb, lead_b = feature_at(B, hulls, -n, wb, b < a, points)
            put_lead(points, min(lead_a, lead_b))
            feature = (1 << 36) | (fa << 18) | fb
        count = emit(contacts, tags, count, a, b, origin + point, n, sigma - r, feature)
    return count, n, sigma - r


@jit
def _middle(points, found, n, radius, most):
    """The mean of the points of a core that lie over a face with the normal n, of those no higher than ``most``."""
    p, number = Vec3(0.0, 0.0, 0.0), 0.0
    for i in range(found):
        if points[i, 3] <= most:
            p, number = p + vec3(points, i, 0) + n * (radius + 0.5 * points[i, 3]), number + 1.0
    return p * (1.0 / number)
