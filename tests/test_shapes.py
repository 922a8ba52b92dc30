"""Shapes: volume, centre of mass and inertia against sums over small cubes, and against each other."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from numpy.typing import NDArray

from stiction.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    MassProperties,
    Plane,
    Shape,
    Sphere,
    describe,
)

Array = NDArray[np.float64]
lengths = some.floats(0.01, 100.0)


def by_small_cubes(
    inside: Callable[[Array], Array], half: tuple[float, float, float], cells: int = 80
) -> MassProperties:
    """Mass properties of a solid of density 1, by summing over the cells of a grid whose middle lies inside."""
    axes = [(np.arange(cells) + 0.5) / cells * 2 * h - h for h in half]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    x = x[inside(x)]
    cell = math.prod(2 * h / cells for h in half)
    volume, center = len(x) * cell, x.mean(axis=0)
    second = (x - center).T @ (x - center) * cell
    return MassProperties(volume, center, np.trace(second) * np.eye(3) - second)


def compare(found: MassProperties, wanted: MassProperties, tolerance: float) -> None:
    """All three, relative to the size of the solid."""
    assert found.volume == pytest.approx(wanted.volume, rel=tolerance)
    size = math.sqrt(np.trace(wanted.inertia) / wanted.volume)
    np.testing.assert_allclose(found.center_of_mass, wanted.center_of_mass, rtol=0, atol=tolerance * size)
    np.testing.assert_allclose(found.inertia, wanted.inertia, rtol=0, atol=tolerance * np.trace(wanted.inertia))


@pytest.mark.parametrize(
    ("shape", "inside", "half"),
    [
        (Sphere(0.5), lambda x: (x**2).sum(axis=1) < 0.25, (0.5, 0.5, 0.5)),
        (Box((1, 2, 3)), lambda x: np.ones(len(x), bool), (0.5, 1.0, 1.5)),
        (Cylinder(0.5, 2), lambda x: (x[:, :2] ** 2).sum(axis=1) < 0.25, (0.5, 0.5, 1.0)),
        (
            Capsule(0.5, 2),
            lambda x: (x[:, :2] ** 2).sum(axis=1) + np.maximum(np.abs(x[:, 2]) - 1.0, 0.0) ** 2 < 0.25,
            (0.5, 0.5, 1.5),
        ),
        (Ellipsoid((0.5, 1, 2)), lambda x: ((x / (0.5, 1, 2)) ** 2).sum(axis=1) < 1.0, (0.5, 1.0, 2.0)),
    ],
    ids=describe,
)
def test_mass_properties_are_sums_over_small_cubes(
    shape: Shape, inside: Callable[[Array], Array], half: tuple[float, float, float]
) -> None:
    compare(shape.mass_properties, by_small_cubes(inside, half), 3e-3)


@given(lengths)
def test_a_sphere(r: float) -> None:
    """V = 4/3 pi r^3, I = 2/5 m r^2."""
    p = Sphere(r).mass_properties
    assert p.volume == pytest.approx(4 / 3 * math.pi * r**3)
    np.testing.assert_allclose(p.inertia, 0.4 * p.volume * r**2 * np.eye(3))


@given(lengths)
def test_an_ellipsoid_with_three_equal_semi_axes_is_a_sphere(r: float) -> None:
    compare(Ellipsoid((r, r, r)).mass_properties, Sphere(r).mass_properties, 1e-12)


@given(lengths, lengths)
def test_a_short_capsule_is_nearly_a_sphere_and_a_long_one_nearly_a_cylinder(r: float, length: float) -> None:
    """As its length goes to 0 the capsule's tensor goes to the sphere's; a cylinder is the capsule without its ends."""
    compare(Capsule(r, 1e-9 * r).mass_properties, Sphere(r).mass_properties, 1e-8)
    compare(Capsule(r, 1e5 * r).mass_properties, Cylinder(r, 1e5 * r).mass_properties, 1e-4)
    # scaling all lengths by s scales volume by s^3 and inertia by s^5
    one, two = Capsule(r, length).mass_properties, Capsule(2 * r, 2 * length).mass_properties
    assert two.volume == pytest.approx(8 * one.volume)
    np.testing.assert_allclose(two.inertia, 32 * one.inertia)


# --- hulls ------------------------------------------------------------------------------------------------------------


def corners(size: tuple[float, float, float]) -> Array:
    """The eight corners of a box about the origin."""
    return np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size


@given(*[some.floats(0.1, 10.0)] * 3, some.tuples(*[some.floats(-10, 10)] * 3))
def test_the_hull_of_a_boxs_corners_is_the_box(x: float, y: float, z: float, shift: tuple[float, float, float]) -> None:
    """Wherever its frame is: the tensor is about the centre of mass."""
    hull = ConvexHull(corners((x, y, z)) + shift)
    box = Box((x, y, z)).mass_properties
    size = max(x, y, z, *np.abs(shift)) / min(x, y, z)
    compare(hull.mass_properties, MassProperties(box.volume, np.array(shift), box.inertia), 1e-13 * size**3 + 1e-12)


def test_the_hull_of_many_points_of_a_sphere_is_nearly_the_sphere() -> None:
    k = np.arange(4000)
    z = 1 - (2 * k + 1) / 4000
    angle = math.pi * (1 + math.sqrt(5)) * k
    rim = np.sqrt(1 - z * z)
    hull = ConvexHull(np.column_stack([rim * np.cos(angle), rim * np.sin(angle), z]))
    compare(hull.mass_properties, Sphere(1).mass_properties, 3e-3)


def test_a_tetrahedron_by_its_textbook_formula() -> None:
    """The corner of a cube of side 1: V = 1/6, centre (1/4, 1/4, 1/4), integral of x^2 = 1/60, of x y = 1/120."""
    p = ConvexHull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).mass_properties
    assert p.volume == pytest.approx(1 / 6)
    np.testing.assert_allclose(p.center_of_mass, [0.25] * 3)
    second = np.full((3, 3), 1 / 120) + np.eye(3) / 120 - np.full((3, 3), 1 / 96)
    np.testing.assert_allclose(p.inertia, np.trace(second) * np.eye(3) - second, atol=1e-15)


def test_points_inside_a_hull_are_dropped_and_its_faces_look_outwards(rng: np.random.Generator) -> None:
    outer = corners((2, 2, 2))
    hull = ConvexHull(np.vstack([0.3 * rng.uniform(-1, 1, size=(20, 3)), outer]))
    np.testing.assert_array_equal(hull.points, outer)
    for face in hull.faces:
        a, b, c = hull.points[face]
        assert np.cross(b - a, c - a) @ a > 0.0
    assert len(hull.faces) == 12
    for array in (hull.points, hull.faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


# --- as values --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape",
    [
        Sphere(1),
        Box((1, 2, 3)),
        Capsule(0.5, 1),
        Cylinder(0.5, 1),
        Ellipsoid((1, 2, 3)),
        ConvexHull(corners((1, 2, 3))),
    ],
    ids=describe,
)
def test_every_solid_has_a_tensor_that_a_body_can_have(shape: Shape) -> None:
    """Symmetric, positive, and no principal moment above the sum of the other two."""
    p = shape.mass_properties
    np.testing.assert_array_equal(p.inertia, p.inertia.T)
    low, middle, high = np.linalg.eigvalsh(p.inertia)
    assert 0.0 < low
    assert high <= (low + middle) * (1 + 1e-12)
    assert p is shape.mass_properties  # computed once


def test_shapes_are_values() -> None:
    assert Sphere(1) == Sphere(1.0)
    assert hash(Box((1, 2, 3))) == hash(Box([1.0, 2.0, 3.0]))
    assert Sphere(1) != Sphere(2)
    shapes: list[Shape] = [Capsule(1, 2), Cylinder(1, 2)]
    assert shapes[0] != shapes[1]
    assert Plane() == Plane((0, 0, 2))
    hull = ConvexHull(corners((1, 1, 1)))
    assert hull != ConvexHull(corners((1, 1, 1)))  # arrays: the same object or another one
    for shape, name in (
        (Sphere(1), "radius"),
        (Box((1, 1, 1)), "size"),
        (Ellipsoid((1, 1, 1)), "half_extents"),
        (Plane(), "offset"),
    ):
        with pytest.raises(AttributeError):
            setattr(shape, name, 2.0)


@given(some.tuples(*[some.floats(-10, 10)] * 3).filter(lambda n: math.hypot(*n) > 1e-3), some.floats(-10, 10))
def test_a_planes_normal_is_normalised_and_its_offset_is_not_scaled(n: tuple[float, ...], offset: float) -> None:
    plane = Plane(n, offset)
    np.testing.assert_allclose(np.cross(plane.normal, n), 0.0, atol=1e-14)
    assert math.hypot(*plane.normal) == pytest.approx(1.0, abs=1e-15)
    assert np.dot(plane.normal, n) > 0.0
    assert plane.offset == offset
    assert not plane.bounded


@pytest.mark.parametrize(
    ("shape", "text"),
    [
        (Sphere(0.25), "Sphere r 0.25 m"),
        (Box((1, 1, 2)), "Box 1 x 1 x 2 m"),
        (Capsule(0.5, 1), "Capsule r 0.5 m, 1 m"),
        (Cylinder(0.5, 1), "Cylinder r 0.5 m, 1 m"),
        (Ellipsoid((0.2, 0.03, 0.02)), "Ellipsoid semi-axes 0.2 x 0.03 x 0.02 m"),
        (ConvexHull(corners((1, 1, 1))), "ConvexHull of 8 points"),
        (Plane(), "Plane"),
    ],
)
def test_a_short_text_for_tables(shape: Shape, text: str) -> None:
    assert describe(shape) == text


def test_what_is_no_solid_has_no_mass_properties() -> None:
    for shape in (Plane(), Shape()):
        with pytest.raises(NotImplementedError):
            _ = shape.mass_properties
    assert describe(Shape()) == "Shape"
