"""How deep bodies lie in each other, from their poses alone: the same yardstick for every engine.

Spheres and boxes against each other are exact (closest points; the fifteen separating axes of two boxes). For capsules,
cylinders, ellipsoids and hulls only the depth in the ground is measured, by their lowest point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.bench import rotations
from stiction.bench.scene import BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Shape, Sphere

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LARGE = 4.0
"""Bodies that reach this many times farther than the dynamic ones are compared with all, outside the search tree."""


class Solids(NamedTuple):
    """Spheres and boxes alike: a box of half lengths (n, 3) m, rounded by (n,) m, at (n, 3) m, turned by (n, 3, 3)."""

    half: Array
    radius: Array
    center: Array
    axes: Array

    def take(self, rows: Indices) -> Solids:
        """Some of them."""
        return Solids(self.half[rows], self.radius[rows], self.center[rows], self.axes[rows])


def reach(shape: Shape) -> float:
    """The farthest any point of the shape is from the origin of its frame, m."""
    match shape:
        case Sphere():
            return shape.radius
        case Box():
            return 0.5 * float(np.linalg.norm(shape.size))
        case Capsule():
            return 0.5 * shape.length + shape.radius
        case Cylinder():
            return float(np.hypot(0.5 * shape.length, shape.radius))
        case Ellipsoid():
            return max(shape.half_extents)
        case ConvexHull():
            return float(np.linalg.norm(shape.points, axis=1).max())
    raise TypeError(f"{type(shape).__name__} has no end")


def lowest(scene: BenchScene, positions: Array, orientations: Array) -> Array:
    """Height of the lowest point of each body, (n,) m."""
    R = rotations.matrix(orientations)
    down = R[:, 2, :]  # the world's z axis in each body's frame
    result = positions[:, 2].copy()
    for i, body in enumerate(scene.bodies):
        shape, z = body.shape, down[i]
        match shape:
            case Sphere():
                result[i] -= shape.radius
            case Box():
                result[i] -= 0.5 * float(np.abs(z) @ np.array(shape.size))
            case Capsule():
                result[i] -= 0.5 * shape.length * abs(z[2]) + shape.radius
            case Cylinder():
                result[i] -= 0.5 * shape.length * abs(z[2]) + shape.radius * float(np.hypot(z[0], z[1]))
            case Ellipsoid():
                result[i] -= float(np.linalg.norm(z * shape.half_extents))
            case ConvexHull():
                result[i] += float((shape.points @ z).min())
    return result


def overlap(scene: BenchScene, positions: Array, orientations: Array) -> float | None:
    """Depth of the deepest overlap of two spheres or boxes of which at least one is dynamic, m.

    0 if none overlaps, None if there is no dynamic sphere or box. Positions must be finite.
    """
    rows = [i for i, body in enumerate(scene.bodies) if isinstance(body.shape, (Sphere, Box))]
    moving = scene.dynamic[rows]
    if not moving.any():
        return None
    solids = _solids(scene, rows, positions, orientations)
    extent = np.linalg.norm(solids.half, axis=1) + solids.radius
    deepest = 0.0
    for a, b in _pairs(solids.center, extent, moving):
        deepest = max(deepest, float(_depths(solids.take(a), solids.take(b)).max(initial=0.0)))
    return deepest


def _solids(scene: BenchScene, rows: list[int], positions: Array, orientations: Array) -> Solids:
    half, radius = np.zeros((len(rows), 3)), np.zeros(len(rows))
    for k, i in enumerate(rows):
        shape = scene.bodies[i].shape
        if isinstance(shape, Sphere):
            radius[k] = shape.radius
        elif isinstance(shape, Box):
            half[k] = 0.5 * np.array(shape.size)
    return Solids(half, radius, positions[rows].astype(np.float64), rotations.matrix(orientations[rows]))


def _pairs(center: Array, extent: Array, moving: NDArray[np.bool_]) -> list[tuple[Indices, Indices]]:
    """Pairs that may touch, in bunches."""
    from scipy.spatial import cKDTree

    large = extent > LARGE * extent[moving].max()
    small_rows = np.flatnonzero(~large)
    tree = cKDTree(center[small_rows])
    near = tree.query_pairs(2.0 * float(extent[small_rows].max()), output_type="ndarray")
    a, b = small_rows[near[:, 0]], small_rows[near[:, 1]]
    close = (np.linalg.norm(center[a] - center[b], axis=1) < extent[a] + extent[b]) & (moving[a] | moving[b])
    bunches = [(a[close], b[close])]
    movers = np.flatnonzero(moving & ~large)
    bunches += [(np.full(len(movers), big), movers) for big in np.flatnonzero(large)]
    return bunches


def _depths(a: Solids, b: Solids) -> Array:
    """How deep each of the first lies in its partner among the second, (pairs,) m; negative if apart."""
    if not len(a.center):
        return np.zeros(0)
    depths = np.empty(len(a.center))
    ball_a, ball_b = a.radius > 0.0, b.radius > 0.0
    boxes = np.flatnonzero(~ball_a & ~ball_b)
    depths[boxes] = _box_box(a.take(boxes), b.take(boxes))
    first = np.flatnonzero(ball_a)
    depths[first] = _ball(a.take(first), b.take(first))
    second = np.flatnonzero(~ball_a & ball_b)
    depths[second] = _ball(b.take(second), a.take(second))
    return depths


def _ball(ball: Solids, other: Solids) -> Array:
    """Spheres against boxes or spheres (boxes of no size)."""
    local = np.einsum("nij,ni->nj", other.axes, ball.center - other.center)
    outside = np.abs(local) - other.half
    distance = np.linalg.norm(np.maximum(outside, 0.0), axis=1) + np.minimum(outside.max(axis=1), 0.0)
    return np.asarray(ball.radius + other.radius - distance)


def _box_box(a: Solids, b: Solids) -> Array:
    """The smallest overlap over the fifteen axes on which two boxes may be apart."""
    A, B, between = a.axes, b.axes, b.center - a.center
    cross = np.cross(A[:, :, :, None], B[:, :, None, :], axis=1).reshape(len(between), 3, 9)
    axes = np.concatenate([A, B, cross], axis=2)  # (pairs, 3, 15)
    length = np.linalg.norm(axes, axis=1, keepdims=True)
    usable = length[:, 0] > 1e-6  # edges that are parallel span no axis
    axes = axes / np.maximum(length, 1e-6)
    spread_a = np.einsum("nij,ni->nj", np.abs(np.einsum("nki,nkj->nij", A, axes)), a.half)
    spread_b = np.einsum("nij,ni->nj", np.abs(np.einsum("nki,nkj->nij", B, axes)), b.half)
    apart = np.abs(np.einsum("ni,nij->nj", between, axes))
    return np.asarray(np.where(usable, spread_a + spread_b - apart, np.inf).min(axis=1))
