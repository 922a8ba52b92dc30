"""The face of a manifold: which polygon its points stand for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.faces import measure_face, order_points, seen_from
from stiction.core.friction.pressure import Even, pressed, spread_of
from stiction.core.state import CONTACT_WIDTH, FACE, POINT, SCRATCH, TAGS_WIDTH
from stiction.core.vec import Vec3

from .support import Array, compiled

UP = Vec3(0.0, 0.0, 1.0)


def face_of(contacts: Any, tags: Any, found: int, points: Any, manifolds: Any, corners: Any) -> None:
    """As the manifold of a new set of points does it."""
    order_points(contacts, tags, found, UP)
    x, y = 0.0, 0.0
    for k in range(found):
        x, y = x + contacts[k, POINT] / found, y + contacts[k, POINT + 1] / found
    measure_face(contacts, tags, found, Vec3(x, y, 0.0), UP, points, manifolds, corners, 0)


def measured(places: Array, face: Array | None = None) -> tuple[Array, Array]:
    """The manifold of points (n, 2) in a plane, and its own corners (8, 2), from the mean of the points; ``face``: what
    the narrow phase remembers of them."""
    contacts, tags = np.zeros((4, CONTACT_WIDTH)), np.zeros((4, TAGS_WIDTH), np.int64)
    contacts[: len(places), POINT : POINT + 2] = places
    manifolds, corners = np.zeros((1, s.MANIFOLD_WIDTH)), np.zeros((1, s.CORNERS_WIDTH))
    points = np.zeros((SCRATCH, 5))
    if face is not None:
        points[FACE, 0] = len(face)
        points[FACE + 1 : FACE + 1 + len(face), :2] = face
    compiled(face_of)(contacts, tags, len(places), points, manifolds, corners)
    return manifolds[0], corners[0].reshape(2, 8).T


def test_a_point_between_the_others_is_no_corner(rng: np.random.Generator) -> None:
    """The deepest of four points may be one; a polygon that turns back has no arm and no surface."""
    for _ in range(500):
        triangle = rng.normal(size=(3, 2))
        a, b = triangle[1] - triangle[0], triangle[2] - triangle[0]
        if abs(a[0] * b[1] - a[1] * b[0]) < 0.1:
            continue
        places = np.vstack([triangle, rng.dirichlet([2.0, 2.0, 2.0]) @ triangle])
        manifold, corners = measured(rng.permutation(places))
        wanted, _ = measured(triangle)
        assert manifold[s.KIND] == s.EIGHT
        assert manifold[s.COUNT] == 4
        x, y = corners.T
        area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        np.testing.assert_allclose(area, 0.5 * abs(a[0] * b[1] - a[1] * b[0]), rtol=1e-9)
        assert np.isfinite(manifold).all()
        assert abs(manifold[s.ARM]) < 0.3
        assert abs(wanted[s.ARM]) < 0.3


def test_a_quadrilateral_is_its_own_face(rng: np.random.Generator) -> None:
    """In whatever order its corners were found."""
    for _ in range(200):
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, size=4))
        places = np.column_stack([np.cos(angles), np.sin(angles)])
        if np.diff(angles, append=angles[0] + 2.0 * np.pi).min() < 0.2:
            continue
        manifold, _ = measured(rng.permutation(places))
        assert manifold[s.KIND] == s.FOUR
        assert abs(manifold[s.ARM]) < 0.3


def test_what_is_left_of_five_corners_is_the_face_though_it_is_four() -> None:
    """Two in one place: what was known of those four was taken for that of the points, from which they may differ."""
    points = np.array([[-4.0, -1.0], [4.0, -1.5], [5.0, 2.0], [-3.0, 2.5]])
    four = np.array([[-1.0, -0.5], [1.0, -0.5], [1.2, 0.5], [-1.0, 0.7]])
    manifold, corners = measured(points, np.vstack([four, four[-1] + 1e-4]))
    assert manifold[s.KIND] == s.EIGHT
    for corner in four - points.mean(axis=0):
        assert np.linalg.norm(np.linalg.norm(corners, axis=1) - np.linalg.norm(corner), ord=-np.inf) < 1e-3


def even_load(manifolds: Any, row: int) -> tuple[float, float]:
    """Of a face that is pressed evenly: the first element of the inverse of its moments, 1/m^2, and its mean arm, m."""
    even = Even(
        manifolds[row, s.EVEN], manifolds[row, s.EVEN + 1], manifolds[row, s.EVEN + 2], manifolds[row, s.ARM], 0.0, 0.0
    )
    seen = seen_from(manifolds, manifolds, row, even, 0.0, 0.0)
    spread = spread_of(seen, even, False)
    c, sn = seen.turn.c, seen.turn.s
    inverse = (c * c * spread.vv + 2.0 * c * sn * spread.uv + sn * sn * spread.uu) / spread.det
    return inverse, pressed(seen, even, False, spread).torque


@pytest.mark.parametrize("size", [1e-3, 0.37, 1.0, 20.0])
def test_two_points_are_a_line_with_an_even_load(size: float) -> None:
    """The moment of a line is size^2 / 12, its mean arm size / 4."""
    manifold, _ = measured(np.array([[-0.3, -0.4], [0.3, 0.4]]) * size)
    inverse, arm = compiled(even_load)(manifold[None], 0)
    np.testing.assert_allclose([inverse * size**2, arm / size], [12.0, 0.25], rtol=1e-12)
