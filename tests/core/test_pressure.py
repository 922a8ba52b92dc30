"""A patch as the solver has it, from the points of a manifold and the centre of their loads, against Coulomb's law
integrated over the face with the pressure that cannot pull."""

from __future__ import annotations

import numpy as np
import pytest

from stiction.verify.limit_surface import moments, rectangle, regular
from stiction.verify.patch_errors import SHAPES, Element, errors


@pytest.mark.parametrize("name", SHAPES)
def test_an_even_load(name: str) -> None:
    polygon = SHAPES[name]
    rms, largest, torque = errors(polygon, moments(polygon)[1][None], name == "disc")
    assert rms[0] < 0.008
    assert largest[0] < 0.0355
    assert torque[0] == pytest.approx(1.0, abs=6e-4)


@pytest.mark.parametrize("name", SHAPES)
def test_a_load_anywhere(name: str, rng: np.random.Generator) -> None:
    """In the kern and beyond it: where the points of the manifold can carry it."""
    polygon = SHAPES[name]
    middle = moments(polygon)[1]
    kept = Element(polygon).kept if name != "disc" else regular(4)
    centers = [middle + 0.96 * (rng.dirichlet(np.full(len(kept), 0.6)) @ kept - middle) for _ in range(8)]
    rms, largest, torque = errors(polygon, np.array(centers), name == "disc")
    assert rms.mean() < 0.025
    assert rms.max() < 0.03
    assert largest.max() < 0.1
    assert np.abs(torque - 1.0).max() < 0.045


def test_there_is_no_leap_when_a_corner_of_a_face_leaves() -> None:
    """A square whose fourth corner has no load is nearly the triangle of the other three."""
    square = rectangle(1, 1)
    four, three = Element(square), Element(square[:3])
    center = square[:3].mean(axis=0)
    assert four.at(center).torque == pytest.approx(three.at(center).torque, rel=0.05)


def test_a_short_side_makes_no_difference() -> None:
    """A triangle whose tip is cut off by a hair is that triangle."""
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.5, 1.0]])
    cut = np.vstack([triangle[:2], triangle[2] + [1e-4 * 1.5, -1e-4], triangle[2] - [1e-4 * 0.5, 1e-4]])
    whole, other = Element(triangle), Element(cut)
    for weights in ([1, 1, 1], [4, 1, 1], [1, 1, 3], [0.1, 1, 1]):
        center = np.array(weights) / sum(weights) @ triangle
        assert other.at(center).torque == pytest.approx(whole.at(center).torque, rel=2e-3)
        np.testing.assert_allclose(other.at(center).surface, whole.at(center).surface, atol=2e-2)


def test_an_edge_of_a_face_is_a_line() -> None:
    """Two corners that carry all: the mean arm of a line with the pressure that cannot pull."""
    element = Element(rectangle(2, 1))
    x = np.linspace(-1.0, 1.0, 4001)
    for shift in (0.0, 0.2, 0.5, 0.8):
        p = 1.0 + 3.0 * shift * x if shift <= 1 / 3 else np.maximum(0.0, x - 1.0 + 3.0 * (1.0 - shift))
        wanted = (p * np.abs(x - (p * x).sum() / p.sum())).sum() / p.sum()
        assert element.at(np.array([shift, -0.5])).torque == pytest.approx(wanted, rel=0.03)


def test_it_follows_any_turn_of_the_face(rng: np.random.Generator) -> None:
    polygon = SHAPES["quadrilateral 3"]
    center = rng.dirichlet(np.ones(4)) @ polygon
    here = Element(polygon).at(center)
    for angle in rng.uniform(0, 2 * np.pi, size=8):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        there = Element(np.roll(polygon @ turn.T, rng.integers(4), axis=0)).at(turn @ center)
        assert there.torque == pytest.approx(here.torque, rel=1e-9)
        np.testing.assert_allclose(np.abs(there.surface), np.abs(here.surface), rtol=0, atol=1e-7)
        assert abs((turn @ here.axes)[:, 0] @ there.axes[:, 0]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("corners", [3, 4, 6])
def test_corners_in_the_same_place_are_one(corners: int) -> None:
    """A thin sheet touches with the corners of its upper face as well."""
    polygon = regular(corners) * [1.0, 0.5]
    one, two = Element(polygon), Element(np.vstack([polygon, polygon + 1e-9]))
    for part in (0.0, 0.3, 0.7):
        center = part * (one.kept[0] - one.kept.mean(axis=0)) + one.kept.mean(axis=0)
        assert two.at(center).torque == pytest.approx(one.at(center).torque, rel=1e-6)


def test_a_quadrilateral_with_two_corners_in_the_same_place_is_a_triangle() -> None:
    triangle = regular(3)
    one, two = Element(triangle), Element(np.vstack([triangle, triangle[2]]))
    center = np.array([0.2, 0.1])
    assert two.at(center).torque == pytest.approx(one.at(center).torque, rel=1e-9)
