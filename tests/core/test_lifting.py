"""A face of which a part lifts off: one step of Newton's method, against the pressure that cannot pull."""

from __future__ import annotations

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.faces import seen_from
from stiction.core.friction.lifting import Corners, Line, line_of, part_of, part_of_eight, spread_over, with_lifting
from stiction.core.friction.pressure import Even, Spread, Turn, place_in, polar_of, pressed, spread_of
from stiction.core.lanes import Lanes
from stiction.core.solve.normals import Four
from stiction.verify.limit_surface import face_without_tension, moments, pressure_moments, rectangle, regular
from stiction.verify.patch_errors import Element, quadrilaterals

from .support import Array

FLAT = Turn(1.0, 0.0)


def four(polygon: Array) -> tuple[Four, Four]:
    """The corners of a quadrilateral."""
    return Four(*polygon[:, 0]), Four(*polygon[:, 1])


def over_the_part(polygon: Array, center: Array, slope: Array) -> Spread:
    """After one step from the line 1 + slope . (x - center) = 0.

    As in ``line_of``, b is along the axis nearer to the line: oblique axes that nearly coincide lose digits.
    """
    su, sv = (float(x) for x in slope)
    line = Line(su, sv, 0.0, np.copysign(1.0, su)) if abs(su) > abs(sv) else Line(su, sv, -np.copysign(1.0, sv), 0.0)
    part = part_of(line, FLAT, *four(polygon), *center)
    return spread_over(part, line)


@pytest.mark.parametrize("polygon", quadrilaterals(12))
def test_the_right_line_stays(polygon: Array, rng: np.random.Generator) -> None:
    """And the moments over it are those of the pressure, wherever its centre is."""
    for weights in rng.dirichlet(np.full(4, 0.7), size=5):
        center = 0.97 * weights @ polygon + 0.03 * moments(polygon)[1]
        face = face_without_tension(polygon, center)
        slope = face.slope / (face.p0 + face.slope @ center)
        found = over_the_part(polygon, center, slope)
        wanted = pressure_moments(face, center)
        scale = np.trace(wanted)
        np.testing.assert_allclose(
            [found.uu, found.uv, found.vv], wanted[[0, 0, 1], [0, 1, 1]], rtol=1e-9, atol=1e-9 * scale
        )
        assert found.det == pytest.approx(np.linalg.det(wanted), rel=1e-9)
        np.testing.assert_allclose([found.gu, found.gv], slope, rtol=0, atol=1e-9 * np.abs(slope).max())


def test_while_all_of_a_face_carries_any_line_beyond_it_is_right() -> None:
    """The step is Newton's on what is then a quadratic problem."""
    polygon = quadrilaterals(3)[2]
    center = moments(polygon)[1] + [0.05, -0.03]
    wanted = pressure_moments(face_without_tension(polygon, center), center)
    for slope in ([0.3, 0.0], [-0.2, 0.2], [0.01, -0.4]):
        found = over_the_part(polygon, center, np.array(slope))
        np.testing.assert_allclose([found.uu, found.uv, found.vv], wanted[[0, 0, 1], [0, 1, 1]], rtol=1e-6, atol=1e-9)


def test_a_side_along_the_line_is_no_trouble() -> None:
    """A strip three times as wide as its load is far from the side."""
    found = over_the_part(rectangle(2, 1), np.array([0.9, 0.0]), np.array([1.0 / 0.2, 0.0]))
    assert found.uu == pytest.approx(0.3**2 / 18)
    assert found.vv == pytest.approx(1 / 12)
    assert found.uv == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("polygon", quadrilaterals(12))
def test_the_guess_is_near_enough(polygon: Array, rng: np.random.Generator) -> None:
    """What a mean arm takes of the moments, the root of their trace, is right within three per cent."""
    element = Element(polygon)
    even = Even(*(float(x) for x in element.row[0, s.EVEN : s.EVEN + 6]))
    x, y = (Four(*(float(x) for x in element.row[0, k : k + 4])) for k in (s.PLACE_U, s.PLACE_V))
    for weights in rng.dirichlet(np.full(4, 0.7), size=20):
        center = 0.97 * weights @ polygon + 0.03 * moments(polygon)[1]
        px, py = (float(x) for x in element.axes.T @ (center - element.middle))
        seen = seen_from(element.row, element.corners, 0, even, px, py)
        if place_in(seen)[0] < 0.1:
            continue
        line = line_of(seen, even, spread_of(seen, even, False))
        found = spread_over(part_of(line, seen.turn, x, y, px, py), line)
        wanted = pressure_moments(face_without_tension(polygon, center), center)
        assert np.sqrt((found.uu + found.vv) / np.trace(wanted)) == pytest.approx(1.0, abs=0.04)


def test_eight_corners_are_as_good_as_four(rng: np.random.Generator) -> None:
    """If four of them are within the sides of the others."""
    polygon = quadrilaterals(1)[0]
    both = np.stack([polygon, 0.3 * polygon + 0.7 * np.roll(polygon, -1, axis=0)], axis=1).reshape(8, 2)
    line, center = Line(2.0, 0.5, 0.0, 1.0), 0.6 * polygon[0]
    eight = Corners(*four(both[:4]), *four(both[4:]))
    np.testing.assert_allclose(
        part_of_eight(line, FLAT, eight, *center), part_of(line, FLAT, *four(polygon), *center), rtol=1e-12, atol=1e-15
    )


def at_once(polygons: Array, centers: Array, precision: type) -> tuple[Array, Array]:
    """Mean arms of quadrilaterals (n, 4, 2), one a lane, and how much of them was found by way of the part."""
    n = len(polygons)
    x, y = (Four(*(Lanes(polygons[:, k, i].astype(precision)) for k in range(4))) for i in (0, 1))
    px, py = (Lanes(centers[:, i].astype(precision)) for i in (0, 1))
    none, no = Lanes(np.zeros(n, precision)), Lanes(np.zeros(n, bool))
    even = Even(none, none, none, none, none, none)
    seen = polar_of(x, y, px, py)
    spread = with_lifting(spread_of(seen, even, no), seen, even, x, y, Corners(x, y, x, y), px, py, no, no)
    return pressed(seen, even, no, spread).torque.values, spread.share.values


@pytest.mark.parametrize("inside", [0.9, 0.99, 0.999, 0.9999, 1.0])
def test_single_precision_is_enough(inside: float, rng: np.random.Generator) -> None:
    """Up to the border of slender quadrilaterals, and with loads right between two corners."""
    polygons = np.array([p - p.mean(axis=0) for p in quadrilaterals(40)]) * np.array([1.0, 0.1])
    side = np.where(rng.uniform(size=(40, 1)) < 0.5, rng.uniform(size=(40, 1)), 0.5)
    centers = inside * (side * polygons[:, 0] + (1.0 - side) * polygons[:, 1])
    double, share = at_once(polygons, centers, np.float64)
    single, _ = at_once(polygons, centers, np.float32)
    assert share.max() > 0.0 or inside > 0.999
    np.testing.assert_allclose(single, double, rtol=2e-3)


@pytest.mark.parametrize(
    ("polygon", "center", "lifts"),
    [
        (rectangle(2, 1), [0.9, 0.0], False),
        (rectangle(2, 1), [0.9, 0.45], True),
        (quadrilaterals(1)[0], moments(quadrilaterals(1)[0])[1], False),
        (np.vstack([regular(3), [[0.25, -0.4330127]]]), [0.7, 0.0], True),
    ],
)
def test_where_the_formula_is_good_it_stays(polygon: Array, center: Array, lifts: bool) -> None:
    """In a parallelogram everywhere but near its corners."""
    _, share = at_once(polygon[None], np.array([center]), np.float64)
    assert (share[0] > 0.0) == lifts


def test_a_sliver_that_is_loaded_at_its_tip_keeps_the_formula() -> None:
    """In single precision nothing is left of its M: 0.6 m long, 0.04 mm wide."""
    x = Four(*(np.float32(c) for c in (-0.45, 0.15, 0.15, 0.15)))
    y = Four(*(np.float32(c) for c in (1.7e-13, -3.4498e-5, 5.798e-6, 2.87e-5)))
    even = Even(*(np.float32(0.0) for _ in range(6)))
    seen = polar_of(x, y, x.a, y.a)
    formula = spread_of(seen, even, False)
    spread = with_lifting(formula, seen, even, x, y, Corners(x, y, x, y), x.a, y.a, False, False)
    assert spread == formula
    assert 0.0 < pressed(seen, even, False, spread).torque < 0.1
