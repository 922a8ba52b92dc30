"""The patch that the solver makes of a face, and by how much its friction differs from Coulomb's law integrated.

Compared are dissipations, friction . twist. As a function of all twists that is the support function of the limit
surface, so its error is that of every limit of force and torque, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction.core import soft_rows as s
from stiction.core.collide.manifold import ROUND, forget_face, reduce
from stiction.core.faces import measure_face, order_points, seen_from
from stiction.core.friction.lifting import Corners, with_lifting
from stiction.core.friction.patch import Surface, terms
from stiction.core.friction.pressure import Even, pressed, spread_of
from stiction.core.solve.normals import Four
from stiction.core.state import CONTACT_WIDTH, FEATURE, POINT, SCRATCH, TAGS_WIDTH
from stiction.core.vec import Vec3
from stiction.verify.limit_surface import (
    Array,
    directions,
    face_without_tension,
    friction_about,
    moments,
    rectangle,
    regular,
)

UP = Vec3(0.0, 0.0, 1.0)


class Patch(NamedTuple):
    """T_m, coefficients and axes (columns u, v)."""

    torque: float
    surface: Surface
    axes: Array


class Element:
    """A manifold over a polygon; ``kept`` are the points that carry its loads."""

    def __init__(self, polygon: Array, disc: bool = False) -> None:
        points, tags = np.zeros((SCRATCH, 5)), np.zeros((4, TAGS_WIDTH), np.int64)
        contacts, self.row = np.zeros((4, CONTACT_WIDTH)), np.zeros((1, s.MANIFOLD_WIDTH))
        self.corners = np.zeros((1, s.CORNERS_WIDTH))
        forget_face(points)
        points[: len(polygon), :2] = polygon
        n = reduce(points, len(polygon), UP)
        contacts[:n, POINT : POINT + 3] = points[:n, :3]
        tags[:n, FEATURE] = ROUND if disc else 0
        order_points(contacts, tags, n, UP)
        self.kept = contacts[:n, POINT : POINT + 2].copy()
        self.middle = self.kept.mean(axis=0)
        u, _ = measure_face(
            contacts,
            tags,
            n,
            Vec3(float(self.middle[0]), float(self.middle[1]), 0.0),
            UP,
            points,
            self.row,
            self.corners,
            0,
        )
        self.axes = np.array([[u.x, -u.y], [u.y, u.x]])

    def at(self, center: Array) -> Patch:
        """With the centre of pressure there."""
        px, py = (float(x) for x in self.axes.T @ (center - self.middle))
        even = Even(*(float(x) for x in self.row[0, s.EVEN : s.EVEN + 6]))
        is_round, many = self.row[0, s.KIND] == s.ELLIPSE, self.row[0, s.KIND] == s.EIGHT
        x, y = (Four(*(float(x) for x in self.row[0, k : k + 4])) for k in (s.PLACE_U, s.PLACE_V))
        seen = seen_from(self.row, self.corners, 0, even, px, py)
        spread = spread_of(seen, even, is_round)
        spread = with_lifting(spread, seen, even, x, y, self._eight(), px, py, many, is_round)
        patch = pressed(seen, even, is_round, spread)
        c, sine = patch.turn
        return Patch(patch.torque, patch.surface, self.axes @ np.array([[c, -sine], [sine, c]]))

    def _eight(self) -> Corners:
        u, v = (self.corners[0, k : k + 8].astype(float) for k in (s.CORNER_U, s.CORNER_V))
        return Corners(Four(*u[:4]), Four(*v[:4]), Four(*u[4:]), Four(*v[4:]))


def dissipation_error(patch: Patch, wrenches: Array) -> Array:
    """Relative error of the dissipation at the twists that have these exact wrenches about the centre, (n,).

    To first order the support function of a convex set changes by as much as its boundary moves along the ray to the
    point of contact: the exact wrench is put back onto the surface, s A + s^2 C + s^3 B = 1.
    """
    g = np.column_stack([wrenches[:, :2] @ patch.axes, wrenches[:, 2] / patch.torque])
    A = (g**2).sum(axis=1)
    C, B = terms(Vec3(*g.T), patch.surface)
    low, high = np.zeros(len(g)), 1.5 / A
    for _ in range(50):
        middle = 0.5 * (low + high)
        outside = middle * (A + middle * (C + middle * B)) > 1.0
        low, high = np.where(outside, low, middle), np.where(outside, middle, high)
    return np.asarray(np.sqrt(low) - 1.0)


def errors(polygon: Array, centers: Array, disc: bool = False) -> tuple[Array, Array, Array]:
    """Root mean square and largest error of the dissipation over all twists, and T_m over the exact one, a centre."""
    element = Element(regular(4) if disc else polygon, disc)
    rms: list[float] = []
    largest: list[float] = []
    torque: list[float] = []
    for center in centers:
        face = face_without_tension(polygon, center)
        spin = friction_about(face, center, np.array([[0.0, 0.0, 1.0]]))[0, 2]
        wrenches = friction_about(face, center, directions(200) / [1.0, 1.0, 1.07 * spin])
        patch = element.at(center)
        error = dissipation_error(patch, wrenches)
        rms.append(np.sqrt((error**2).mean()))
        largest.append(np.abs(error).max())
        torque.append(patch.torque / spin)
    return np.array(rms), np.array(largest), np.array(torque)


def quadrilaterals(n: int) -> list[Array]:
    """Irregular convex ones, the same at every call."""
    rng = np.random.default_rng(5)
    found: list[Array] = []
    while len(found) < n:
        angle, r = np.sort(rng.uniform(0, 2 * np.pi, 4)), rng.uniform(0.4, 1.0, 4)
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=1) * r[:, None] * [1.0, rng.uniform(0.4, 1.0)]
        sides = np.roll(corners, -1, axis=0) - corners
        after = np.roll(sides, -1, axis=0)
        if (sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]).min() > 0.05 * abs(moments(corners)[0]):
            found.append(corners)
    return found


SHAPES: dict[str, Array] = {
    **{f"{ratio}:1": rectangle(ratio, 1) for ratio in (1, 2, 5, 10, 20)},
    "equilateral triangle": regular(3),
    "right triangle": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    "slender triangle": np.array([[0.0, 0.0], [4.0, 0.0], [1.0, 0.6]]),
    "pentagon": regular(5), "hexagon": regular(6), "octagon": regular(8), "disc": regular(90),
    **{f"quadrilateral {k}": corners for k, corners in enumerate(quadrilaterals(12))},
}  # fmt: skip
