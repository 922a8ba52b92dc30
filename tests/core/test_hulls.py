"""The table of convex hulls: triangles joined to faces, edges between two faces, equal hulls kept once."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

import stiction as st
from stiction.core.collide.hulls import CUBE, NOTHING, POINT, PRIMITIVES, SEGMENT, Hulls
from stiction.hulls import HullTable, polygons

from .support import Array, matrix_of, random_unit


def prism(corners: int, turn: float = 0.0) -> st.ConvexHull:
    """A right prism over a regular polygon, turned about an axis that is none of its own."""
    angles = np.arange(corners) * 2.0 * math.pi / corners
    flat = np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.vstack([np.column_stack([flat, np.full(corners, z)]) for z in (-0.5, 0.5)])
    q = np.array([math.cos(turn), 0.6 * math.sin(turn), 0.8 * math.sin(turn), 0.0])
    return st.ConvexHull(points @ matrix_of(q).T)


def loops_of(table: Hulls, row: int) -> list[list[int]]:
    """Corners of each face of a hull, as rows of its own vertices."""
    first, count = table.spans[row, 2], table.spans[row, 3]
    return [
        (table.corners[start : start + n] - table.spans[row, 0]).tolist()
        for start, n in table.loops[first : first + count]
    ]


def check(hulls: HullTable, row: int) -> None:
    """Whatever holds for every closed convex polyhedron."""
    table = hulls.arrays
    v0, nv, f0, nf, e0, ne = table.spans[row]
    vertices = table.vertices[v0 : v0 + nv]
    planes = table.planes[f0 : f0 + nf]
    edges = table.edges[e0 : e0 + ne]
    size = np.ptp(vertices, axis=0).max()
    loops = loops_of(table, row)
    used = {corner for loop in loops for corner in loop}
    assert len(used) - ne + nf == 2  # Euler
    assert sum(len(loop) for loop in loops) == 2 * ne
    np.testing.assert_allclose(np.linalg.norm(planes[:, :3], axis=1), 1.0, atol=1e-12)
    heights = vertices @ planes[:, :3].T - planes[:, 3]
    assert heights.max() <= 1e-12 * size
    for f, loop in enumerate(loops):
        assert np.abs(heights[loop, f]).max() <= 4e-6 * size
        d = np.roll(vertices[loop], -1, axis=0) - vertices[loop]
        turns = np.cross(d, np.roll(d, -1, axis=0)) @ planes[f, :3]
        assert (turns >= -1e-6 * size**2).all()  # counter-clockwise from outside
    for u, v, f, g in edges:
        for face in (f, g):
            assert {u - v0, v - v0} <= set(loops[face - f0])
    assert table.breadths[row] == pytest.approx(0.5 * np.ptp(vertices @ planes[:, :3].T, axis=0).min())


@pytest.mark.parametrize("corners", [3, 4, 6, 50])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_the_triangles_of_a_flat_face_become_one_polygon(corners: int, turn: float) -> None:
    table = HullTable()
    row = table.add(prism(corners, turn))
    check(table, row)
    sizes = sorted(len(loop) for loop in loops_of(table.arrays, row))
    assert sizes == sorted([4] * corners + [corners] * 2)


def test_a_cube_of_points_with_some_in_its_faces_and_edges_is_a_cube() -> None:
    grid = list(itertools.product((-1.0, 0.0, 1.0), repeat=3))
    table = HullTable()
    row = table.add(st.ConvexHull(grid))
    check(table, row)
    assert table.arrays.spans[row, 3] == 6
    assert sorted(table.arrays.planes[-6:, 3]) == [1.0] * 6


def test_random_hulls_are_closed(rng: np.random.Generator) -> None:
    table = HullTable()
    for n in (4, 5, 8, 20, 200):
        for squeeze in (1.0, 1e-3):
            points = rng.normal(size=(n, 3)) * (1.0, 1.0, squeeze) + rng.normal(size=3)
            check(table, table.add(st.ConvexHull(points)))


@given(
    some.lists(some.tuples(*[some.integers(-3, 3)] * 3), min_size=4, max_size=30),
    some.sampled_from([1.0, 1e-4, 1e4]),
)
def test_hulls_of_lattice_points_are_closed(points: list[tuple[int, int, int]], scale: float) -> None:
    """Full of coplanar triangles and collinear points."""
    try:
        hull = st.ConvexHull(scale * np.array(points, float))
    except st.InvalidInputError:
        return
    table = HullTable()
    check(table, table.add(hull))


def test_slightly_bent_faces_stay_apart() -> None:
    """A roof of one degree is two faces, one of a tenth of a microradian is one."""
    for slope, faces in ((math.radians(1.0), 7), (1e-7, 6)):
        ridge = [(x, 0.0, 1.0 + math.tan(slope)) for x in (-1.0, 1.0)]
        hull = st.ConvexHull([*itertools.product((-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)), *ridge])
        assert len(polygons(hull.points, hull.faces)) == faces


def test_equal_hulls_share_a_row_and_rows_stay_as_they_are() -> None:
    table = HullTable()
    one, other = prism(5), prism(6)
    rows = [table.add(h) for h in (one, other, prism(5), one)]
    assert rows == [PRIMITIVES, PRIMITIVES + 1, PRIMITIVES, PRIMITIVES]
    before: Any = [a.copy() for a in table.arrays]
    table.add(prism(7))
    for old, new in zip(before, table.arrays, strict=True):
        np.testing.assert_array_equal(new[: len(old)], old)


def test_the_primitives_are_always_there() -> None:
    check(HullTable(), CUBE)
    table = HullTable().arrays
    assert table.spans[[CUBE, SEGMENT, POINT, NOTHING]][:, [1, 3, 5]].tolist() == [
        [8, 6, 12], [2, 0, 1], [1, 0, 0], [0, 0, 0],
    ]  # fmt: skip
    assert table.vertices[8:11].tolist() == [[0, 0, -1], [0, 0, 1], [0, 0, 0]]


def test_a_world_keeps_each_hull_once(rng: np.random.Generator) -> None:
    world = st.World()
    shape = prism(3)
    for k in range(3):
        world.add(shape, position=(3.0 * k, 0, 0), orientation=random_unit(rng, 4))
    assert len(world._store.hulls.arrays.spans) == PRIMITIVES + 1


def test_joining_changes_no_area(rng: np.random.Generator) -> None:
    points: Array = rng.normal(size=(12, 3))
    hull = st.ConvexHull(points)
    faces = polygons(hull.points, hull.faces)
    area = sum(area_of(hull.points[face]) for face in faces)
    assert area == pytest.approx(sum(area_of(hull.points[face]) for face in hull.faces))


def area_of(corners: Array) -> float:
    """Area of a flat polygon, by triangles around its first corner."""
    d = corners - corners[0]
    return float(0.5 * np.linalg.norm(np.cross(d[:-1], d[1:]).sum(axis=0)))
