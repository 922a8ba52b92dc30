"""How a convex shape is curved where it touches: its radii, for manifolds that are taken along (``going_on``).

A corner of a core has no radius and an edge an infinite one along it; what grows the core adds its own to both. A face
is flat. The rim of a cylinder turns around its axis with the radius of the cylinder, seen at a slant.
"""

from __future__ import annotations

import math

from stiction.core.collide.clip import UPRIGHT
from stiction.core.collide.hulls import SEGMENT, corner, corner_count, is_ellipsoid, number_of_two, vertex
from stiction.core.collide.manifold import ENDLESS, UNKNOWN, put_radii
from stiction.core.jit import jit
from stiction.core.vec import Vec3, column, cross, dot, length, transpose, vec3

SAME_HEIGHT = 1e-6
"""Of the least half width: vertices that reach as far along the normal as others; also the cosine of a cylinder's axis
with the normal below which its side touches."""
TINY = 1e-300


@jit
def feature_at(X, hulls, n, w, first, points):
    """The vertex, or the first two, or the part of a cylinder, that reaches farthest along n, with its nearest point w;
    and its lead: the bodies may move so far against each other until another one may reach farther, or they are nearest
    beyond its end, m. How X is curved there is put into ``points`` as that of the ``first`` body of the pair, or of the
    second.

    When the normal turns by an angle, something at the distance 2 r, the diameter, gains twice as much as r times it.
    """
    m, s = transpose(X.R) @ n, X.scale
    if X.round:
        axis = column(X.R, 2)
        if abs(m.z) <= SAME_HEIGHT:
            put_radii(points, first, axis, ENDLESS, s.x)
            return 2, s.z - abs(dot(w - X.p, axis))
        _put_rim(X, n, first, points)
        lead = min(s.x * math.sqrt(max(1.0 - m.z * m.z, 0.0)), s.z * abs(m.z))
        return 0 if m.z > 0.0 else 1, lead
    if is_ellipsoid(X):
        put_radii(points, first, n, UNKNOWN, UNKNOWN)
        return 0, 0.0
    m = Vec3(m.x * s.x, m.y * s.y, m.z * s.z)
    v = hulls.vertices
    row, number = hulls.spans[X.hull, 0], hulls.spans[X.hull, 1]
    high = -math.inf
    for i in range(row, row + number):
        high = max(high, m.x * v[i, 0] + m.y * v[i, 1] + m.z * v[i, 2])
    level, next_high = high - SAME_HEIGHT * X.small, -math.inf
    one, other, many = -1, -1, False
    for i in range(row, row + number):
        h = m.x * v[i, 0] + m.y * v[i, 1] + m.z * v[i, 2]
        if h < level:
            next_high = max(next_high, h)
        elif one < 0:
            one = i
        elif other < 0:
            other = i
        else:
            many = True
    lead = 0.5 * (high - next_high)
    if many:
        put_radii(points, first, n, ENDLESS, ENDLESS)
        lead = 0.0
    elif other >= 0:
        p, q = vertex(X, hulls, one), vertex(X, hulls, other)
        put_radii(points, first, q - p, ENDLESS, X.radius)
        lead = min(lead, min(length(w - p), length(w - q)))
    else:
        put_radii(points, first, n, X.radius, X.radius)
    return number_of_two(one - row, (other if other >= 0 else one) - row), lead


@jit
def radii_over_face(X, n, found, first, points):
    """The same where X touches a face, whose outward normal is n, with one or two points. What lies along the face does
    not roll in that direction."""
    if is_ellipsoid(X):
        put_radii(points, first, n, UNKNOWN, UNKNOWN)
    elif X.round:
        if abs(dot(column(X.R, 2), n)) < UPRIGHT:
            put_radii(points, first, column(X.R, 2), 0.0, X.scale.x)
        else:
            _put_rim(X, n, first, points)
    elif X.hull == SEGMENT and found == 2:
        put_radii(points, first, column(X.R, 2), 0.0, X.radius)
    else:
        put_radii(points, first, n, X.radius, X.radius)


@jit
def _put_rim(X, n, first, points):
    """The rim of a cylinder that is tilted against the normal."""
    tangent = cross(column(X.R, 2), n)
    slant = length(tangent)
    if slant > SAME_HEIGHT:
        put_radii(points, first, tangent, X.scale.x / slant, 0.0)
    else:
        put_radii(points, first, n, ENDLESS, ENDLESS)


@jit
def inside_of(F, face, n, found, hulls, points):
    """How far the first ``found`` points are within the border of a face of F with the outward normal n, m. What has
    come nearer than other points may then be over the face has been found with them: they are no matter."""
    start, sides = column(F.R, 0), corner_count(F, hulls, face)
    here, least = corner(F, hulls, face, sides - 1, start), math.inf
    for k in range(sides):
        there = corner(F, hulls, face, k, start)
        out = cross(there - here, n)
        out = out * (1.0 / max(length(out), TINY))
        for i in range(found):
            least = min(least, dot(out, here - vec3(points, i, 0)))
        here = there
    return max(least, 0.0)
