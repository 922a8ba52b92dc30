"""Bodies as flat, shaded polygons, seen from afar: the farthest first, so that nearer ones lie over them.

Bodies are convex. Two that do not overlap have a plane between them, and whichever is on the viewer's side of it may be
in front of the other, never behind it. That puts bodies in order, which distances of their centres do not.
"""

from __future__ import annotations

import functools
import heapq
import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.scene.placing import turned
from stiction.shapes import Cylinder, Ellipsoid, Shape, Sphere
from stiction.view import style
from stiction.view.meshes import CREASE, ROUND, solid

Array = NDArray[np.float64]

VIEWS: dict[str, tuple[tuple[int, int, int], tuple[int, int, int]]] = {
    "side": ((1, 0, 0), (0, 0, 1)),
    "front": ((0, 1, 0), (0, 0, 1)),
    "top": ((1, 0, 0), (0, 1, 0)),
}
"""Directions in the world of what is to the right and what is up in the picture."""
LIGHT = np.array([-0.45, 0.7, 0.55])
"""Where light comes from: right, up, and towards the viewer, in the picture."""
BRIGHTEST, DARKEST = 0.45, 0.28
"""How much white there is in a face that looks into the light, how much black in one that looks away."""
TOUCHING = 0.02
"""Bodies overlap a little where they press; by up to that share of the smaller one they still have a plane between."""


def axes_of(view: str | tuple[float, float]) -> Array:
    """(3, 3) what is to the right, up, and towards the viewer, as rows in world axes.

    Args:
        view: ``"side"`` (x to the right, z up), ``"front"`` (y to the right, z up), ``"top"`` (x to the right, y up);
            or where the viewer is, as two angles in degrees: from the x axis towards the y axis, and above the ground.

    Raises:
        InvalidInputError: it is none of these.
    """
    if isinstance(view, str):
        right, up = (np.array(direction, np.float64) for direction in VIEWS[checks.one_of("view", view, tuple(VIEWS))])
        return np.array([right, up, np.cross(right, up)])
    try:
        azimuth, elevation = (math.radians(checks.number("view", angle)) for angle in view)
    except (TypeError, ValueError) as error:
        if isinstance(error, InvalidInputError):
            raise
        names = ", ".join(repr(name) for name in VIEWS)
        raise InvalidInputError(f"view must be one of {names} or two angles in degrees, got {view!r}.") from None
    cos = math.cos(elevation)
    toward = np.array([cos * math.cos(azimuth), cos * math.sin(azimuth), math.sin(elevation)])
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    return np.array([right, np.cross(toward, right), toward])


@dataclass(frozen=True)
class Outline:
    """A surface with what is drawn on it as lines.

    Attributes:
        vertices: (v, 3) m.
        faces: its flat faces, each by its vertices in order round it.
        normals: (f, 3) of the faces, outward.
        edges: (e, 2) vertices. sides: (e, 2) the two faces at each. creases: (e,) whether they meet at an angle.
    """

    vertices: Array
    faces: list[NDArray[np.int64]]
    normals: Array
    edges: NDArray[np.int64]
    sides: NDArray[np.int64]
    creases: NDArray[np.bool_]


@functools.lru_cache(maxsize=512)
def outline(shape: Shape) -> Outline:
    """The surface of a bounded shape, in its own frame."""
    mesh = solid(shape)
    _, first, number = np.unique(np.round(mesh.vertices, 9), axis=0, return_index=True, return_inverse=True)
    vertices, faces = mesh.vertices[first], number.ravel()[mesh.faces]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    flat = sizes > 1e-12 * sizes.max()
    faces, normals = faces[flat], normals[flat] / sizes[flat, None]
    normals, number = np.unique(np.round(normals, 6), axis=0, return_inverse=True)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    polygons = [_round(np.unique(faces[number.ravel() == k]), vertices, normal) for k, normal in enumerate(normals)]
    seen: dict[tuple[int, int], int] = {}
    edges, sides = [], []
    for k, polygon in enumerate(polygons):
        for i, j in pairwise([*polygon.tolist(), int(polygon[0])]):
            edge = (min(i, j), max(i, j))
            if edge in seen:
                edges.append(edge)
                sides.append((seen[edge], k))
            seen[edge] = k
    pairs = np.array(sides)
    creases = np.sum(normals[pairs[:, 0]] * normals[pairs[:, 1]], axis=1) < CREASE
    if isinstance(shape, Ellipsoid):  # its facets meet at any angle where it is pointed
        creases[:] = False
    return Outline(vertices, polygons, normals, np.array(edges), pairs, creases)


def _round(corners: NDArray[np.int64], vertices: Array, normal: Array) -> NDArray[np.int64]:
    """The corners of a convex face in order, counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull

    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    flat = vertices[corners] @ np.column_stack([across, np.cross(normal, across)])
    return np.asarray(corners[ConvexHull(flat).vertices])


@dataclass(frozen=True)
class Solid:
    """A shape where it is.

    Attributes:
        shape: what it looks like. color: ``#rrggbb``.
        position: (3,) m. orientation: (4,) unit quaternion.
        vertices: (v, 3) m in the world; of a sphere, its centre. reach: radius of a sphere, or 0.
        normals, offsets: (f, 3), (f,) planes of its faces; none of a sphere.
    """

    shape: Shape
    color: str
    position: Array
    orientation: Array
    vertices: Array
    reach: float
    normals: Array
    offsets: Array


def place(shape: Shape, position: Array, orientation: Array, color: str) -> Solid:
    """A bounded shape, put where it is."""
    if isinstance(shape, Sphere):
        none = np.zeros((0, 3))
        return Solid(shape, color, position, orientation, position[None], shape.radius, none, none[:, 0])
    form = outline(shape)
    vertices = turned(orientation, form.vertices) + position
    normals = turned(orientation, form.normals)
    offsets = np.sum(normals * vertices[[face[0] for face in form.faces]], axis=1)
    return Solid(shape, color, position, orientation, vertices, 0.0, normals, offsets)


def in_order(solids: list[Solid], view: Array) -> list[int]:
    """Their numbers, the farthest first.

    Args:
        solids: convex and, but for contact, apart from each other.
        view: from :func:`axes_of`.
    """
    n = len(solids)
    flat = [one.vertices @ view.T for one in solids]
    low = np.array([p.min(axis=0) - one.reach for p, one in zip(flat, solids, strict=True)]).reshape(n, 3)
    high = np.array([p.max(axis=0) + one.reach for p, one in zip(flat, solids, strict=True)]).reshape(n, 3)
    depth = 0.5 * (low[:, 2] + high[:, 2])
    before: list[int] = [0] * n
    after: list[list[int]] = [[] for _ in range(n)]
    for i in range(n):
        meets = np.all((low[i, :2] < high[i + 1 :, :2]) & (high[i, :2] > low[i + 1 :, :2]), axis=1)
        for j in (i + 1 + np.flatnonzero(meets)).tolist():
            nearer = _nearer(solids[i], solids[j], view[2], depth[j] - depth[i])
            if nearer:
                first, second = (i, j) if nearer > 0 else (j, i)
                after[first].append(second)
                before[second] += 1
    ready = [(depth[i], i) for i in range(n) if not before[i]]
    heapq.heapify(ready)
    waiting = {i for i in range(n) if before[i]}
    result: list[int] = []
    while ready or waiting:
        if not ready:  # a ring of bodies each in front of the next: cut it at the farthest
            i = min(waiting, key=lambda k: depth[k])
            waiting.discard(i)
        else:
            i = heapq.heappop(ready)[1]
        result.append(i)
        for j in after[i]:
            before[j] -= 1
            if before[j] == 0 and j in waiting:
                waiting.discard(j)
                heapq.heappush(ready, (depth[j], j))
    return result


def _nearer(a: Solid, b: Solid, toward: Array, deeper: float) -> float:
    """Above 0 if b may cover a, below 0 if a may cover b, 0 if neither; ``deeper``, how much nearer b's middle is."""
    gaps, normals = [], []
    for one, other, sign in ((a, b, 1.0), (b, a, -1.0)):
        if len(one.normals):
            gap = (one.normals @ other.vertices.T).min(axis=1) - other.reach - one.offsets
            best = int(np.argmax(gap))
            gaps.append(float(gap[best]))
            normals.append(sign * one.normals[best])
    if not normals:  # two spheres
        return deeper
    best = int(np.argmax(gaps))
    size = min(float(np.ptp(one.vertices, axis=0).max()) + 2.0 * one.reach for one in (a, b))
    if gaps[best] < -TOUCHING * size:
        return deeper
    facing = float(normals[best] @ toward)
    return facing if abs(facing) > 1e-6 else 0.0


@dataclass
class Strokes:
    """What a picture is made of, in the order in which it is drawn: polygons, and lines as polygons without a face."""

    paths: list[Array]
    faces: list[str]
    lines: list[str]
    widths: list[float]

    def fill(self, path: Array, color: str) -> None:
        """A polygon (p, 2); its rim has its colour, so that neighbours leave no gap."""
        self._add(path, color, color, 0.4)

    def line(self, path: Array, width: float, color: str = style.INK) -> None:
        """A line (p, 2) of that width in points."""
        self._add(path, "none", color, width)

    def _add(self, path: Array, face: str, line: str, width: float) -> None:
        self.paths.append(path)
        self.faces.append(face)
        self.lines.append(line)
        self.widths.append(width)


def paint(one: Solid, view: Array, strokes: Strokes, width: float) -> None:
    """Draw a solid: its faces in light and shade, its edges, and marks that show how a round one has turned."""
    if isinstance(one.shape, Sphere):
        _paint_sphere(one, view, strokes, width)
        return
    form = outline(one.shape)
    seen = one.normals @ view[2] > 1e-9
    flat = one.vertices @ view[:2].T
    light = one.normals @ (LIGHT @ view / np.linalg.norm(LIGHT))
    for k in np.flatnonzero(seen).tolist():
        strokes.fill(flat[form.faces[k]], shaded(one.color, float(light[k])))
    sides = seen[form.sides]
    drawn = np.where(form.creases, sides.any(axis=1), sides[:, 0] != sides[:, 1])
    for edge in form.edges[drawn].tolist():
        strokes.line(flat[edge], width)
    if isinstance(one.shape, Ellipsoid):
        _draw_rings(one, view, strokes, width, one.shape.half_extents)
    if isinstance(one.shape, Cylinder):
        r, h = one.shape.radius, one.shape.length / 2
        for z in (-h, h):
            if float(turned(one.orientation, np.array([0.0, 0.0, z])) @ view[2]) > 1e-9 * h:
                spoke = turned(one.orientation, np.array([[0.0, 0.0, z], [r, 0.0, z]])) + one.position
                strokes.line(spoke @ view[:2].T, width)


def _paint_sphere(one: Solid, view: Array, strokes: Strokes, width: float) -> None:
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    centre, r = view[:2] @ one.position, one.reach
    for share, light in ((1.0, -0.35), (0.88, 0.1), (0.6, 0.35), (0.3, 0.6)):
        at = centre + (1.0 - share) * 0.75 * r * LIGHT[:2] / np.linalg.norm(LIGHT[:2])
        strokes.fill(at + share * r * circle, shaded(one.color, light))
    _draw_rings(one, view, strokes, width, (r, r, r))
    strokes.line(centre + r * circle, width)


def _draw_rings(
    one: Solid, view: Array, strokes: Strokes, width: float, half_extents: tuple[float, float, float]
) -> None:
    """Two great circles of a ball, or what an ellipsoid has instead of them, where they can be seen."""
    turn = np.linspace(0.0, 2.0 * math.pi, ROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    for k in range(2):
        ring = np.insert(circle, k * 2, 0.0, axis=1)
        front = turned(one.orientation, ring / half_extents) @ view[2] > 0.0  # by the normals
        ring = turned(one.orientation, ring * half_extents)
        if front.any() and not front.all():  # begin at the rim, so that what is seen is in one piece
            begin = -int(np.argmin(front[:-1]))
            ring, front = np.roll(ring[:-1], begin, axis=0), np.roll(front[:-1], begin)
        if front.any():
            strokes.line((ring[front] + one.position) @ view[:2].T, 0.6 * width)


def shaded(color: str, light: float) -> str:
    """A colour in light (1: it looks into it) or in shade (-1: it looks away), as ``#rrggbb``."""
    rgb = np.array(style.rgb(color), np.float64)
    mixed = rgb + (255.0 - rgb) * BRIGHTEST * light if light > 0.0 else rgb * (1.0 + DARKEST * light)
    r, g, b = np.clip(np.round(mixed), 0, 255).astype(int).tolist()
    return f"#{r:02x}{g:02x}{b:02x}"
