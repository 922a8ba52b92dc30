"""Triangles for the shapes: a solid and, over it, its edges in ink.

A ball or a roller of one colour does not show that it turns, and boxes of one colour run into each other, so every
shape comes with a second mesh of thin bars: edges of boxes and hulls, three great circles on a sphere or an ellipsoid,
rims and spokes on a cylinder. Corners are repeated where the surface has a crease, because the viewer smooths over
shared corners.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Shape, Sphere
from stiction.view import style

Array = NDArray[np.float64]

ROUND = 40
"""Segments of a full circle."""
CREASE = math.cos(math.radians(10.0))
"""Two faces of a hull whose normals agree better than this have no edge drawn between them."""


@dataclass(frozen=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (v, 3) in m.
        faces: (t, 3) rows of vertices, counter-clockwise seen from outside.
    """

    vertices: Array
    faces: NDArray[np.int64]


def solid(shape: Shape) -> Mesh:
    """Closed surface of a bounded shape, in the shape's frame."""
    match shape:
        case Box():
            return _box(np.array(shape.size))
        case Sphere():
            return sphere(shape.radius)
        case Ellipsoid():
            ball = sphere(1.0)
            return Mesh(ball.vertices * shape.half_extents, ball.faces)
        case Cylinder():
            r, h = shape.radius, shape.length / 2
            # three pieces, so that the rims stay sharp
            return join([_revolve([(0.0, -h), (r, -h)]), _revolve([(r, -h), (r, h)]), _revolve([(r, h), (0.0, h)])])
        case Capsule():
            r, h = shape.radius, shape.length / 2
            return _revolve([*_arc(r, -h, -90.0, 0.0), *_arc(r, h, 0.0, 90.0)])
        case ConvexHull():
            corners = shape.points[shape.faces]
            return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    raise TypeError(f"no mesh for a {type(shape).__name__}")


def edges(shape: Shape) -> Mesh:
    """Thin bars that show the outline of a bounded shape and, for round ones, that it turns."""
    low, high = bounds(shape)
    size = high - low
    width = min(style.EDGE_WIDTH * float(size.mean()), 0.12 * float(size.min()))
    match shape:
        case Box():
            return join([_bar(p, q, width) for p, q in _box_edges(low, high)])
        case Sphere():
            ring = _ring(shape.radius, 0.0, width)
            return join([ring, _turned(ring, 0), _turned(ring, 1)])
        case Ellipsoid():
            a, b, c = shape.half_extents
            return join([_oval(a, b, width), _turned(_oval(b, c, width), 0), _turned(_oval(c, a, width), 1)])
        case Cylinder():
            r, h = shape.radius, shape.length / 2
            x, y = np.array([r, 0.0, 0.0]), np.array([0.0, r, 0.0])
            bars = [_ring(r, -h, width), _ring(r, h, width)]
            for z in (np.array([0.0, 0.0, -h]), np.array([0.0, 0.0, h])):
                bars += [_bar(z - x, z + x, width), _bar(z - y, z + y, width)]
            up = np.array([0.0, 0.0, h])
            bars += [_bar(p - up, p + up, width) for p in (x, -x, y, -y)]
            return join(bars)
        case Capsule():
            r, h = shape.radius, shape.length / 2
            path = [(a, 0.0, b) for a, b in [*_arc(r, -h, -90.0, 0.0), *_arc(r, h, 0.0, 90.0)]]
            meridian = join([_bar(np.array(p), np.array(q), width) for p, q in pairwise(path)])
            half_turn = Mesh(meridian.vertices * (-1.0, -1.0, 1.0), meridian.faces)
            quarters = [Mesh(m.vertices[:, [1, 0, 2]] * (-1.0, 1.0, 1.0), m.faces) for m in (meridian, half_turn)]
            return join([_ring(r, -h, width), _ring(r, h, width), meridian, half_turn, *quarters])
        case ConvexHull():
            return join([_bar(p, q, width) for p, q in _hull_edges(shape)])
    raise TypeError(f"no edges for a {type(shape).__name__}")


def bounds(shape: Shape) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of a bounded shape in its own frame, in m."""
    match shape:
        case Box():
            half = np.array(shape.size) / 2
        case Sphere():
            half = np.full(3, shape.radius)
        case Ellipsoid():
            half = np.array(shape.half_extents)
        case Cylinder():
            half = np.array([shape.radius, shape.radius, shape.length / 2])
        case Capsule():
            half = np.array([shape.radius, shape.radius, shape.length / 2 + shape.radius])
        case ConvexHull():
            return shape.points.min(axis=0), shape.points.max(axis=0)
        case _:
            raise TypeError(f"no bounds for a {type(shape).__name__}")
    return -half, half


def height(shape: Shape, rotation: Array) -> float:
    """How far a bounded shape reaches above its frame's origin in m, turned by a rotation matrix (3, 3)."""
    up = rotation[2]
    match shape:
        case Box():
            return float(np.abs(up) @ np.array(shape.size) / 2)
        case Sphere():
            return shape.radius
        case Ellipsoid():
            return float(np.linalg.norm(up * shape.half_extents))
        case Cylinder():
            return float(abs(up[2]) * shape.length / 2 + math.hypot(up[0], up[1]) * shape.radius)
        case Capsule():
            return float(abs(up[2]) * shape.length / 2 + shape.radius)
        case ConvexHull():
            return float((shape.points @ up).max())
    raise TypeError(f"no height for a {type(shape).__name__}")


def sphere(radius: float) -> Mesh:
    """A ball about the origin."""
    return _revolve(_arc(radius, 0.0, -90.0, 90.0))


def prism(top: Array, bottom: Array) -> Mesh:
    """A block between two quadrilaterals (4, 3) with corners above each other, counter-clockwise seen from above."""
    quads = [top, bottom[::-1]]
    for k in range(4):
        after = (k + 1) % 4
        quads.append(np.array([bottom[k], bottom[after], top[after], top[k]]))
    return join([sheet(quad) for quad in quads])


def sheet(corners: Array) -> Mesh:
    """A flat quadrilateral (4, 3), counter-clockwise seen from the side that shows."""
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def join(parts: list[Mesh]) -> Mesh:
    """One mesh out of several."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=True)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def _box(size: Array) -> Mesh:
    vertices: list[Array] = []
    faces: list[tuple[int, int, int]] = []
    for axis, sign in product(range(3), (-1.0, 1.0)):
        n, u = np.zeros(3), np.zeros(3)
        n[axis], u[(axis + 1) % 3] = sign, 1.0
        v = np.cross(n, u)
        start = len(vertices)
        vertices += [(n + a * u + b * v) * size / 2 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        faces += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    return Mesh(np.array(vertices), np.array(faces))


def _box_edges(low: Array, high: Array) -> list[tuple[Array, Array]]:
    result = []
    for axis in range(3):
        for corner in product((0, 1), repeat=2):
            p = np.insert(np.array(corner), axis, 0)
            q = np.insert(np.array(corner), axis, 1)
            result.append((np.where(p, high, low), np.where(q, high, low)))
    return result


def _hull_edges(hull: ConvexHull) -> list[tuple[Array, Array]]:
    a, b, c = (hull.points[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen: dict[tuple[int, int], int] = {}
    result = []
    for k, face in enumerate(hull.faces):
        for i, j in ((0, 1), (1, 2), (2, 0)):
            edge = (int(min(face[i], face[j])), int(max(face[i], face[j])))
            if edge in seen and float(normals[k] @ normals[seen[edge]]) < CREASE:
                result.append((hull.points[edge[0]], hull.points[edge[1]]))
            seen[edge] = k
    return result


def _arc(radius: float, z: float, start_deg: float, stop_deg: float) -> list[tuple[float, float]]:
    """Points (distance from the axis, height) of a circle about (0, z), from one latitude to another."""
    steps = max(2, round(ROUND * (stop_deg - start_deg) / 360.0))
    angles = np.radians(np.linspace(start_deg, stop_deg, steps + 1))
    # exactly zero at the poles, where the ring shrinks to one vertex
    return [(max(0.0, round(math.cos(t), 12)) * radius, z + math.sin(t) * radius) for t in angles]


def _revolve(profile: list[tuple[float, float]]) -> Mesh:
    """A smooth surface about z from a profile (distance from the axis, height) that runs upwards on the outside."""
    turn = np.arange(ROUND) * (2 * math.pi / ROUND)
    vertices: list[Array] = []
    rings: list[NDArray[np.int64]] = []
    count = 0
    for r, z in profile:
        angles = turn if r else np.zeros(1)
        vertices.append(np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(len(angles), z)]))
        rings.append(count + np.arange(ROUND) % len(angles))
        count += len(angles)
    faces: list[NDArray[np.int64]] = []
    for lower, upper in pairwise(rings):
        l2, u2 = np.roll(lower, -1), np.roll(upper, -1)
        if lower[0] != lower[-1]:
            faces.append(np.column_stack([lower, l2, u2]))
        if upper[0] != upper[-1]:
            faces.append(np.column_stack([lower, u2, upper]))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def _ring(radius: float, z: float, width: float) -> Mesh:
    """A ring about z of square section, centred on the circle of that radius and height."""
    h = width / 2
    corners = [(radius - h, z - h), (radius + h, z - h), (radius + h, z + h), (radius - h, z + h), (radius - h, z - h)]
    return join([_revolve([p, q]) for p, q in pairwise(corners)])


def _oval(x: float, y: float, width: float) -> Mesh:
    """A ring about z at height 0, centred on an ellipse with these semi-axes."""
    ring = _ring(x, 0.0, width)
    sine = ring.vertices[:, 1] / np.linalg.norm(ring.vertices[:, :2], axis=1)
    return Mesh(ring.vertices + np.outer((y - x) * sine, (0.0, 1.0, 0.0)), ring.faces)


def _turned(mesh: Mesh, axis: int) -> Mesh:
    """A ring about z turned to lie about x (0) or y (1): a cyclic change of axes, which keeps the faces outward."""
    return Mesh(np.roll(mesh.vertices, axis + 1, axis=1), mesh.faces)


def _bar(start: Array, end: Array, width: float) -> Mesh:
    """A bar of square section from one point to another, half a width longer at both ends so that corners close."""
    along = (end - start) / float(np.linalg.norm(end - start))
    u = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    u /= np.linalg.norm(u)
    frame = np.column_stack([u, np.cross(along, u), along])
    mesh = _box(np.array([width, width, float(np.linalg.norm(end - start)) + width]))
    return Mesh(mesh.vertices @ frame.T + (start + end) / 2, mesh.faces)
