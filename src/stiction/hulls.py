"""The table of a world's convex hulls: faces, their corners and edges, made from the triangles of a ConvexHull."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.core.collide.hulls import PRIMITIVES, Hulls
from stiction.shapes import ConvexHull

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FLAT = 1e-6
"""Triangles belong to one face if they lie in its plane up to this part of the hull's size."""


class HullTable:
    """Hulls that grow in number; equal ones share a row."""

    def __init__(self) -> None:
        self._rows: dict[bytes, int] = {}
        self._spans: list[tuple[int, ...]] = []
        self._parts: tuple[list[NDArray[Any]], ...] = ([], [], [], [], [], [], [])
        self._lengths = np.zeros(3, dtype=np.int64)
        self._corners = 0
        self._arrays: Hulls | None = None
        signs = np.array([[1 if k & bit else -1 for bit in (1, 2, 4)] for k in range(8)], dtype=np.float64)
        cube = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
        self._append(signs, [np.array(loop) for loop in cube])
        self._append(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]), [])
        self._append(np.zeros((1, 3)), [])
        self._append(np.zeros((0, 3)), [])
        assert len(self._spans) == PRIMITIVES

    def add(self, hull: ConvexHull) -> int:
        """The row of a hull, new only if no equal one has been added."""
        key = hull.points.tobytes()
        if key not in self._rows:
            self._rows[key] = self._append(hull.points, polygons(hull.points, hull.faces))
        return self._rows[key]

    def points(self) -> list[Array]:
        """Points (v, 3) of the hulls that were added, in the order of their rows, m."""
        return [np.frombuffer(key, np.float64).reshape(-1, 3) for key in self._rows]

    @property
    def arrays(self) -> Hulls:
        """The table as kernels take it."""
        if self._arrays is None:
            spans = np.array(self._spans, dtype=np.int64)
            self._arrays = Hulls(spans, *(np.ascontiguousarray(np.concatenate(part)) for part in self._parts))
        return self._arrays

    def _append(self, vertices: Array, loops: list[Integers]) -> int:
        """Append vertices (v, 3) and the corners of each face; returns the row."""
        breadths, middles, points, planes, starts, corners, edges = self._parts
        first_vertex, first_face, first_edge = self._lengths.tolist()
        plane = np.zeros((len(loops), 4))
        breadth = 0.0
        for f, loop in enumerate(loops):
            plane[f, :3] = _area(vertices[loop])
            plane[f, :3] /= np.linalg.norm(plane[f, :3])
            heights = vertices @ plane[f, :3]
            plane[f, 3] = heights.max()
            breadth = min(breadth or np.inf, 0.5 * float(np.ptp(heights)))
        number = np.array([len(loop) for loop in loops], dtype=np.int64)
        edge = _edges(loops)
        if not loops and len(vertices) == 2:
            edge = np.array([[0, 1, -1, -1]])
        self._spans.append((first_vertex, len(vertices), first_face, len(loops), first_edge, len(edge)))
        breadths.append(np.array([breadth]))
        middles.append(vertices.mean(axis=0, keepdims=True) if len(vertices) else np.zeros((1, 3)))
        points.append(vertices.reshape(-1, 3))
        planes.append(plane)
        start = np.cumsum(number) - number + self._corners
        starts.append(np.column_stack([start, number]).astype(np.int64).reshape(-1, 2))
        corners.append(np.concatenate([*loops, np.zeros(0, np.int64)]).astype(np.int64) + first_vertex)
        shift = np.array([first_vertex, first_vertex, first_face, first_face])
        edges.append(np.where(edge < 0, -1, edge + shift).astype(np.int64).reshape(-1, 4))
        self._lengths += (len(vertices), len(loops), len(edge))
        self._corners += int(number.sum())
        self._arrays = None
        return len(self._spans) - 1


def _area(corners: Array) -> Array:
    """Twice the area vector of a polygon (Newell): its length is twice the area, its direction the normal."""
    d = corners - corners[0]
    return np.asarray(np.cross(d[:-1], d[1:]).sum(axis=0))


def _edges(loops: list[Integers]) -> Integers:
    """(e, 4) two vertices and the two faces that meet there."""
    left: dict[tuple[int, int], int] = {}
    for f, loop in enumerate(loops):
        for u, v in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True):
            left[u, v] = f
    rows = [(u, v, f, left[v, u]) for (u, v), f in left.items() if u < v and (v, u) in left]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


def polygons(points: Array, triangles: Integers) -> list[Integers]:
    """The faces of a hull (v, 3) given by outward triangles (t, 3): corners counter-clockwise seen from outside.

    Around the largest triangle first, neighbours are joined as long as they lie in its plane and look the same way; a
    triangle so thin that it has no direction goes with either neighbour.
    """
    tolerance = FLAT * float(np.ptp(points, axis=0).max())
    area = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    size = np.linalg.norm(area, axis=1)
    sides = points[triangles] - points[np.roll(triangles, -1, axis=1)]
    sliver = size <= tolerance * np.linalg.norm(sides, axis=2).max(axis=1)
    across = {(int(t[i]), int(t[i - 2])): k for k, t in enumerate(triangles) for i in range(3)}

    taken = np.zeros(len(triangles), dtype=bool)
    faces: list[Integers] = []
    for seed in np.argsort(-size, kind="stable"):
        if taken[seed] or size[seed] == 0.0:
            continue
        n = area[seed] / size[seed]
        inside = np.abs((points[triangles] - points[triangles[seed, 0]]) @ n).max(axis=1) <= tolerance
        inside &= sliver | (area @ n > 0.9 * size)
        group, front = [int(seed)], [int(seed)]
        taken[seed] = True
        while front:
            t = triangles[front.pop()]
            for i in range(3):
                other = across.get((int(t[i - 2]), int(t[i])), -1)
                if other >= 0 and inside[other] and not taken[other]:
                    taken[other] = True
                    group.append(other)
                    front.append(other)
        loop = _outline(triangles[group])
        faces.extend([loop] if loop is not None else [triangles[k] for k in group if size[k] > 0.0])
    return faces


def _outline(triangles: Integers) -> Integers | None:
    """The closed line around joined triangles; None if it is not one line without a knot."""
    directed = {(int(t[i - 1]), int(t[i])) for t in triangles for i in range(3)}
    border = {u: v for u, v in directed if (v, u) not in directed}
    if len(border) < 3 or len(border) != sum((v, u) not in directed for u, v in directed):
        return None
    start = min(border)
    loop = [start]
    while border[loop[-1]] != start:
        loop.append(border[loop[-1]])
        if len(loop) > len(border) or loop[-1] not in border:
            return None
    return np.array(loop, dtype=np.int64) if len(loop) == len(border) else None
