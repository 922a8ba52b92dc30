"""Convex shapes as the narrow phase sees them: a core, which is a polytope, a cylinder or an ellipsoid, grown by a
radius.

A sphere is a point with a radius, a capsule a segment with a radius, a box the cube of the table, scaled by its half
lengths. So one support function, one distance and one clipping serve all pairs that have no formula of their own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stiction.core.jit import inlined, jit
from stiction.core.state import CAPSULE, CYLINDER, ELLIPSOID, HULL, ORIENTATION, SHAPE, SIZE, SPHERE
from stiction.core.vec import Mat33, Vec3, column, cross, dot, quat, rotation, transpose, vec3


class Hulls(NamedTuple):
    """All polytopes of a world. Numbers of vertices and faces are rows of these arrays."""

    spans: np.ndarray  # (h, 6) int64 a hull's first vertex, number of vertices, the same of faces, the same of edges
    breadths: np.ndarray  # (h,) half of the least width, m
    middles: np.ndarray  # (h, 3) mean of the vertices, m
    vertices: np.ndarray  # (v, 3) m, in the shape's frame
    planes: np.ndarray  # (f, 4) outward normal, and offset n . x, m
    loops: np.ndarray  # (f, 2) int64 a face's corners are corners[first : first + number]
    corners: np.ndarray  # (c,) int64 vertices, counter-clockwise seen from outside
    edges: np.ndarray  # (e, 4) int64 two vertices, two faces (-1 where there is none)


CUBE, SEGMENT, POINT, NOTHING, PRIMITIVES = range(5)
"""Rows of the table that are always there: [-1, 1]^3, (0, 0, -1) to (0, 0, 1), the origin, and none for a cylinder or
an ellipsoid."""


class Convex(NamedTuple):
    """One body's shape: what it takes to ask for its support."""

    p: Vec3  # origin of the shape's frame, m
    R: Mat33  # its axes
    scale: Vec3  # factors of the hull's vertices; radius, radius, half length of a cylinder; semi-axes, m
    radius: float  # by which the core is grown, m
    small: float  # half of the least width, m
    hull: int
    round: bool  # a cylinder


RIM = 16
"""Corners of the polygon that stands for a disc where it is clipped."""
RIM_X, RIM_Y = (np.array([f(2.0 * math.pi * k / RIM) for k in range(RIM)]) for f in (math.cos, math.sin))
MOST_CORNERS = 32
"""A face of more corners is clipped as the polygon of every second, third... of them."""


@jit
def convex_of(bodies, kinds, i, p, hulls):
    """Body i with the origin of its frame at p."""
    s = vec3(bodies, i, SIZE)
    R = rotation(quat(bodies, i, ORIENTATION))
    shape = kinds[i, SHAPE]
    radius, hull = 0.0, CUBE
    if shape == SPHERE:
        radius, hull = s.x, POINT
        s = Vec3(0.0, 0.0, 0.0)
    elif shape == CAPSULE:
        radius, hull = s.x, SEGMENT
        s = Vec3(0.0, 0.0, s.z - s.x)
    elif shape == CYLINDER or shape == ELLIPSOID:
        hull = NOTHING
    elif shape == HULL:
        hull = int(bodies[i, SIZE + 3])
        s = Vec3(1.0, 1.0, 1.0)
    small = radius
    if hull == CUBE or hull == NOTHING:
        small = min(s.x, min(s.y, s.z))
    elif shape == HULL:
        small = hulls.breadths[hull]
    return Convex(p, R, s, radius, small, hull, shape == CYLINDER)


@inlined
def is_ellipsoid(X):
    """Whether the core is an ellipsoid: it has neither corners nor faces."""
    return X.hull == NOTHING and not X.round


@inlined
def ellipsoid_point(s, m):
    """The point of an ellipsoid with semi-axes s that lies farthest along m, in its axes; 0 if it has no size."""
    x, y, z = s.x * m.x, s.y * m.y, s.z * m.z
    size = math.sqrt(x * x + y * y + z * z)
    f = 1.0 / size if size > 0.0 else 0.0
    return Vec3(s.x * (x * f), s.y * (y * f), s.z * (z * f))


@jit
def curved_point(s, m, is_round):
    """The same of a cylinder or an ellipsoid."""
    if not is_round:
        return ellipsoid_point(s, m)
    across = math.sqrt(m.x * m.x + m.y * m.y)
    f = s.x / across if across > 0.0 else 0.0
    return Vec3(m.x * f, m.y * f, math.copysign(s.z, m.z))


@inlined
def vertex(X, hulls, i):
    """Vertex of row i, where the shape is."""
    v = hulls.vertices
    return X.p + X.R @ Vec3(v[i, 0] * X.scale.x, v[i, 1] * X.scale.y, v[i, 2] * X.scale.z)


@jit
def shrunk(X, hulls, factor):
    """The core, smaller by a factor, about the middle of its vertices."""
    s, rest = X.scale, 1.0 - factor
    m = vec3(hulls.middles, X.hull, 0)
    p = X.p + X.R @ Vec3(m.x * s.x * rest, m.y * s.y * rest, m.z * s.z * rest)
    return Convex(p, X.R, s * factor, X.radius, X.small, X.hull, X.round)


@inlined
def reach_point(X, hulls, m):
    """The point of the core that lies farthest along m; both in the axes of the shape and from its origin.

    The cube, the segment and the point are the corners (+-1, +-1, +-1) of the scale.
    """
    s = X.scale
    if X.hull == NOTHING:
        return curved_point(s, m, X.round)
    if X.hull <= POINT:
        return Vec3(s.x if m.x > 0.0 else -s.x, s.y if m.y > 0.0 else -s.y, s.z if m.z > 0.0 else -s.z)
    x, y, z = m.x * s.x, m.y * s.y, m.z * s.z
    v = hulls.vertices
    first = hulls.spans[X.hull, 0]
    farthest, best = first, -math.inf
    for i in range(first, first + hulls.spans[X.hull, 1]):
        h = x * v[i, 0] + y * v[i, 1] + z * v[i, 2]
        farthest, best = (i, h) if h > best else (farthest, best)
    return Vec3(v[farthest, 0] * s.x, v[farthest, 1] * s.y, v[farthest, 2] * s.z)


@inlined
def support(X, hulls, n):
    """The point of the core that lies farthest along n (world axes, any length)."""
    return X.p + X.R @ reach_point(X, hulls, transpose(X.R) @ n)


@jit
def two_best(hulls, hull, m):
    """The vertices of a hull of the table, by row, that lie farthest and second farthest along m: the ends of an
    edge."""
    v = hulls.vertices
    first = hulls.spans[hull, 0]
    one, other, best, next_best = first, first, -math.inf, -math.inf
    for i in range(first, first + hulls.spans[hull, 1]):
        h = m.x * v[i, 0] + m.y * v[i, 1] + m.z * v[i, 2]
        if h > best:
            one, other, best, next_best = i, one, h, best
        elif h > next_best:
            other, next_best = i, h
    return one, other


@inlined
def face_count(X, hulls):
    """Flat faces: the two caps of a cylinder, those of the hull, none of a sphere and a capsule."""
    return 2 if X.round else hulls.spans[X.hull, 3]


@inlined
def face_plane(X, hulls, f):
    """Outward normal of face f in world axes, and its distance from the origin of the shape's frame."""
    if X.round:
        return column(X.R, 2) * (1.0 if f == 0 else -1.0), X.scale.z
    i = hulls.spans[X.hull, 2] + f
    m = vec3(hulls.planes, i, 0)
    # only the cube is scaled, and its normals are axes
    return X.R @ m, hulls.planes[i, 3] * (m.x * m.x * X.scale.x + m.y * m.y * X.scale.y + m.z * m.z * X.scale.z)


@jit
def facing(X, hulls, n):
    """The face whose normal is nearest to n, -1 if there are no faces."""
    m = transpose(X.R) @ n
    if X.round:
        return 0 if m.z > 0.0 else 1
    face, best = -1, -math.inf
    planes = hulls.planes
    first = hulls.spans[X.hull, 2]
    for i in range(first, first + hulls.spans[X.hull, 3]):
        h = planes[i, 0] * m.x + planes[i, 1] * m.y + planes[i, 2] * m.z
        face, best = (i - first, h) if h > best else (face, best)
    return face


@jit
def face_below(X, hulls, p):
    """The height of p over the polytope X, and the outward normal of the face that it is straight above: its distance,
    for it is as far from that face's plane as it is from a point of X. The height is negative if there is none."""
    m, planes, v = transpose(X.R) @ (p - X.p), hulls.planes, hulls.vertices
    face, best = -1, 0.0
    first = hulls.spans[X.hull, 2]
    for i in range(first, first + hulls.spans[X.hull, 3]):
        h = planes[i, 0] * m.x + planes[i, 1] * m.y + planes[i, 2] * m.z - planes[i, 3]
        face, best = (i, h) if h > best else (face, best)
    if face < 0:
        return -1.0, m
    n = vec3(planes, face, 0)
    start, sides = hulls.loops[face, 0], hulls.loops[face, 1]
    here = vec3(v, hulls.corners[start + sides - 1], 0)
    for k in range(start, start + sides):
        there = vec3(v, hulls.corners[k], 0)
        if dot(cross(n, there - here), m - here) < 0.0:
            return -1.0, m
        here = there
    return best, X.R @ n


@jit
def depth_in(X, hulls, p):
    """How far p, in a core with faces, is from the border of it; negative outside."""
    m = transpose(X.R) @ (p - X.p)
    if X.round:
        return min(X.scale.z - abs(m.z), X.scale.x - math.sqrt(m.x * m.x + m.y * m.y))
    if X.hull == CUBE:
        return min(X.scale.x - abs(m.x), min(X.scale.y - abs(m.y), X.scale.z - abs(m.z)))
    planes, least = hulls.planes, math.inf
    first = hulls.spans[X.hull, 2]
    for i in range(first, first + hulls.spans[X.hull, 3]):
        least = min(least, planes[i, 3] - planes[i, 0] * m.x - planes[i, 1] * m.y - planes[i, 2] * m.z)
    return least


@inlined
def corner_count(X, hulls, f):
    """Corners of face f, as it is clipped."""
    if X.round:
        return RIM
    m = hulls.loops[hulls.spans[X.hull, 2] + f, 1]
    stride = (m + MOST_CORNERS - 1) // MOST_CORNERS
    return (m + stride - 1) // stride


@inlined
def corner(X, hulls, f, k, u):
    """Corner k of face f, counter-clockwise seen from outside; u is the direction of a disc's corner 0."""
    if X.round:
        n, offset = face_plane(X, hulls, f)
        c, s = RIM_X[k] * X.scale.x, RIM_Y[k] * X.scale.x
        v = Vec3(n.y * u.z - n.z * u.y, n.z * u.x - n.x * u.z, n.x * u.y - n.y * u.x)
        return X.p + n * offset + u * c + v * s
    row = hulls.spans[X.hull, 2] + f
    m = hulls.loops[row, 1]
    return vertex(X, hulls, hulls.corners[hulls.loops[row, 0] + k * ((m + MOST_CORNERS - 1) // MOST_CORNERS)])


@jit
def number_of_two(i, j):
    """One number of two vertices, in either order; huge hulls repeat it."""
    return (min(i, j) & 511) << 9 | (max(i, j) & 511)
