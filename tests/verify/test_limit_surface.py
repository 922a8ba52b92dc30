"""The integral that the limit surface is compared with: sums over many points, and figures that are well known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.verify.limit_surface import (
    Face,
    directions,
    even_face,
    face_without_tension,
    friction_about,
    friction_of,
    mean_arm,
    moments,
    part_above,
    pressure_moments,
    rectangle,
    regular,
)

Array = Any
QUADRILATERAL = np.array([[0.0, 0.0], [2.2, 0.1], [1.6, 1.3], [0.3, 0.9]])


def points_of(face: Face, n: int = 700) -> tuple[Array, Array]:
    """A grid over a face, (k, 2), and the loads of its points."""
    low, high = face.polygon.min(axis=0), face.polygon.max(axis=0)
    axes = [low[k] + (high[k] - low[k]) * (np.arange(n) + 0.5) / n for k in (0, 1)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    inside = np.ones(len(points), bool)
    for a, b in zip(face.polygon, np.roll(face.polygon, -1, axis=0), strict=True):
        inside &= (b[0] - a[0]) * (points[:, 1] - a[1]) - (b[1] - a[1]) * (points[:, 0] - a[0]) >= 0
    loads = (face.p0 + points[inside] @ face.slope) * np.prod((high - low) / n)
    return points[inside], loads


FACES = {
    "square": even_face(rectangle(1, 1)),
    "5:1": even_face(rectangle(2, 0.4)),
    "sloping": face_without_tension(QUADRILATERAL, np.array([1.1, 0.55])),
    "partly lifted": face_without_tension(QUADRILATERAL, np.array([1.5, 0.4])),
}


@pytest.mark.parametrize("face", FACES.values(), ids=FACES.keys())
def test_the_integral_is_a_sum_over_many_points(face: Face) -> None:
    points, loads = points_of(face)
    twists = directions(12)
    twists[::3, 2] *= -1
    for twist, found in zip(twists, friction_of(face, twists), strict=True):
        slip = twist[:2] + twist[2] * np.stack([-points[:, 1], points[:, 0]], axis=1)
        unit = slip / np.linalg.norm(slip, axis=1)[:, None] * loads[:, None]
        torque = points[:, 0] * unit[:, 1] - points[:, 1] * unit[:, 0]
        np.testing.assert_allclose(found, [*unit.sum(axis=0), torque.sum()], atol=3e-3)


@pytest.mark.parametrize("face", FACES.values(), ids=FACES.keys())
def test_moments_of_the_pressure(face: Face) -> None:
    points, loads = points_of(face)
    center = loads @ points / loads.sum()
    wanted = (loads[:, None] * (points - center)).T @ (points - center)
    np.testing.assert_allclose(pressure_moments(face, center), wanted, atol=3e-3)
    assert loads.sum() == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize(
    ("polygon", "arm"),
    [(rectangle(1, 1), 0.38260), (regular(720), 2 / 3), (regular(3), 0.4601), (regular(6), 0.6080)],
    ids=["square", "disc", "triangle", "hexagon"],
)
def test_the_mean_arm_of_well_known_faces(polygon: Array, arm: float) -> None:
    """Torque of pure spinning per mu N."""
    assert mean_arm(even_face(polygon), np.zeros(2)) == pytest.approx(arm, rel=1e-4)


def test_the_pressure_has_the_centre_that_is_asked_for(rng: np.random.Generator) -> None:
    """And pulls nowhere, and its load is one."""
    for polygon in (rectangle(5, 1), regular(3), regular(8), QUADRILATERAL):
        for _ in range(10):
            center = rng.dirichlet(np.ones(len(polygon))) @ polygon
            face = face_without_tension(polygon, center)
            assert (face.p0 + face.polygon @ face.slope).min() > -1e-9
            area, middle, second = moments(face.polygon)
            mean = face.p0 + face.slope @ middle
            assert area * mean == pytest.approx(1.0, rel=1e-7)
            np.testing.assert_allclose(area * (mean * middle + second @ face.slope), center, atol=1e-6)


def test_pure_translation_has_no_torque_about_the_centre_of_pressure() -> None:
    center = np.array([1.5, 0.4])
    found = friction_about(face_without_tension(QUADRILATERAL, center), center, np.array([[0.6, 0.8, 0.02]]))[0]
    np.testing.assert_allclose(found, [0.6, 0.8, 0.0], atol=0.01)


def test_the_pressure_at_a_corner_is_a_triangle() -> None:
    """In the oblique axes of its sides its legs are four times the distances of P."""
    face = face_without_tension(rectangle(1, 1), np.array([0.5 - 0.05, 0.5 - 0.02]))
    assert moments(face.polygon)[0] == pytest.approx(0.5 * 0.2 * 0.08, rel=1e-9)


def test_a_strip_at_a_side_carries_what_is_loaded_off_the_kern() -> None:
    """Three times as wide as P is far from the side, and the variance is that of a triangle."""
    face = face_without_tension(rectangle(1, 1), np.array([0.4, 0.0]))
    assert moments(face.polygon)[0] == pytest.approx(0.3, rel=1e-9)
    np.testing.assert_allclose(
        pressure_moments(face, np.array([0.4, 0.0])), [[0.3**2 / 18, 0], [0, 1 / 12]], rtol=1e-9, atol=1e-12
    )


def test_a_centre_outside_the_face_is_refused() -> None:
    with pytest.raises(ValueError, match="not inside"):
        face_without_tension(rectangle(1, 1), np.array([0.7, 0.0]))


def test_a_part_of_a_polygon() -> None:
    assert moments(part_above(rectangle(2, 1), -0.5, np.array([1.0, 0.0])))[0] == pytest.approx(0.5)
    assert len(part_above(rectangle(2, 1), -5.0, np.array([1.0, 0.0]))) == 0
