"""Contacts of spheres, boxes and planes against brute force: closest points, least penetration, corners.

A contact point lies half way between the two surfaces along its normal, which points from the first body to the second;
separation is negative where they overlap.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial import ConvexHull, HalfspaceIntersection

from stiction.core import state
from stiction.core.collide.box_box import FACE_PREFERENCE
from stiction.core.collide.manifold import SAME_DEPTH, reduce
from stiction.core.collide.narrow import find_contacts

from .support import (
    BEYOND,
    Array,
    Manifold,
    Placed,
    box,
    compiled,
    contacts_of,
    matrix_of,
    plane,
    product,
    random_unit,
    sphere,
    vec,
)

# --- brute force ------------------------------------------------------------------------------------------------------


def signed_distance(placed: Placed, x: Array) -> float:
    """Distance of a point from a shape's surface, negative inside."""
    local = placed.axes.T @ (x - np.asarray(placed.position))
    if placed.shape == state.SPHERE:
        return float(np.linalg.norm(local) - placed.size[0])
    if placed.shape == state.PLANE:
        return float(np.array(placed.size[:3]) @ local - placed.size[3])
    beyond = np.abs(local) - np.array(placed.size)
    return float(np.linalg.norm(np.maximum(beyond, 0.0)) + min(beyond.max(), 0.0))


def distance_of_boxes(a: Placed, b: Placed) -> float:
    """Least distance of two boxes that do not overlap, by bounded least squares over a point in each."""
    M = np.hstack([a.axes, -b.axes])
    bounds = np.array([*a.size, *b.size])
    found = lsq_linear(M, np.asarray(b.position) - np.asarray(a.position), bounds=(-bounds, bounds), tol=1e-14)
    return float(np.linalg.norm(M @ found.x - (np.asarray(b.position) - np.asarray(a.position))))


def gap_along(a: Placed, b: Placed, n: Array) -> float:
    """Gap between two boxes seen along a direction: how far one must be pushed along it to come free, times -1."""
    reach = np.array(a.size) @ np.abs(a.axes.T @ n) + np.array(b.size) @ np.abs(b.axes.T @ n)
    return float(abs((np.asarray(b.position) - np.asarray(a.position)) @ n) - reach)


def separations_on_axes(a: Placed, b: Placed) -> Array:
    """The gap along each of the 15 axes (faces of a, faces of b, pairs of edges); -inf for parallel edges."""
    axes, reach = axes_and_reach(a, b)
    return np.asarray(np.abs(axes @ (np.asarray(b.position) - np.asarray(a.position))) - reach)


def axes_and_reach(a: Placed, b: Placed) -> tuple[Array, Array]:
    """The 15 axes (15, 3), and along each the distance of the centres (15,) below which the boxes overlap."""
    Ra, Rb = a.axes, b.axes
    axes = np.vstack([Ra.T, Rb.T, np.cross(Ra.T[:, None], Rb.T[None]).reshape(9, 3)])
    size = np.linalg.norm(axes, axis=1)
    parallel = size < 1e-4
    axes /= np.where(parallel, 1.0, size)[:, None]
    reach = np.abs(axes @ Ra) @ np.array(a.size) + np.abs(axes @ Rb) @ np.array(b.size)
    return axes, np.where(parallel, np.inf, reach)


def slack(a: Placed, b: Placed) -> float:
    """How much worse than the best axis the chosen one may be, m."""
    return FACE_PREFERENCE * min(*a.size, *b.size)


# --- random scenes ----------------------------------------------------------------------------------------------------


def random_shape(rng: np.random.Generator, kind: str) -> Placed:
    """A shape of that kind, anywhere near the origin."""
    where, q = rng.uniform(-1.0, 1.0, size=3), random_unit(rng, 4)
    if kind == "sphere":
        return Placed(state.SPHERE, (float(rng.uniform(0.2, 1.0)),), where, q)
    if kind == "box":
        return box(rng.uniform(0.3, 1.5, size=3), where, q)
    return plane(random_unit(rng), float(rng.uniform(-1.0, 1.0)), where, q)


def at_gap(a: Placed, b: Placed, direction: Array, gap: float) -> Placed:
    """Box b shifted from a along a direction until the largest gap of the 15 axes is ``gap``."""
    axes, reach = axes_and_reach(a, b)
    along = np.abs(axes @ direction)
    ways = (gap + reach)[along > 1e-9] / along[along > 1e-9]
    return box(b.size, np.asarray(a.position) + direction * ways.min(), b.orientation)


def box_pairs(rng: np.random.Generator, n: int, gap: Callable[[], float]) -> Iterator[tuple[Placed, Placed]]:
    """Pairs of random boxes in random poses at a given gap."""
    for _ in range(n):
        a = box(rng.uniform(0.3, 1.5, size=3), rng.normal(size=3), random_unit(rng, 4))
        b = box(rng.uniform(0.3, 1.5, size=3), np.zeros(3), random_unit(rng, 4))
        yield a, at_gap(a, b, random_unit(rng), gap())


def overlapping(rng: np.random.Generator) -> Callable[[], float]:
    """Penetrations from a micrometre to a tenth of a metre."""
    return lambda: -float(10.0 ** rng.uniform(-6.0, -1.0))


PAIRS = [("sphere", "sphere"), ("sphere", "box"), ("sphere", "plane"), ("box", "plane"), ("box", "box")]
both_ways = pytest.mark.parametrize("kinds", [*PAIRS, *(p[::-1] for p in PAIRS if p[0] != p[1])], ids=" and ".join)


def random_pair(rng: np.random.Generator, kinds: tuple[str, str]) -> tuple[Placed, Placed]:
    """Two shapes of these kinds that lie about one metre or less from each other."""
    a, b = (random_shape(rng, kind) for kind in kinds)
    if kinds == ("box", "box"):
        b = at_gap(a, b, random_unit(rng), float(rng.uniform(-0.2, 0.4)))
    return a, b


# --- what holds for every pair ----------------------------------------------------------------------------------------


@both_ways
def test_nothing_lies_beyond_the_margin_and_the_lower_body_comes_first(
    rng: np.random.Generator, kinds: tuple[str, str]
) -> None:
    found = 0
    for _ in range(300):
        a, b = random_pair(rng, kinds)
        margin = float(rng.uniform(0.0, 0.5))
        manifold = contacts_of(a, b, margin)
        found += len(manifold)
        assert len(manifold) <= 4
        assert (manifold.separations <= margin + BEYOND).all()
        assert (manifold.bodies == (0, 1)).all()
        np.testing.assert_allclose(np.linalg.norm(manifold.normals, axis=1), 1.0, rtol=0, atol=1e-14)
        assert len(set(manifold.features.tolist())) == len(manifold)
    assert found > 50


@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-8])
@pytest.mark.parametrize("swapped", [False, True])
def test_a_corner_near_a_corner_has_a_normal_of_length_one(rng: np.random.Generator, gap: float, swapped: bool) -> None:
    """However near, and though a hundred metres from the origin their distance is a difference of large numbers."""
    for _ in range(20):
        q, where = random_unit(rng, 4), rng.uniform(-100.0, 100.0, size=3)
        size_a, size_b = rng.uniform(0.3, 1.5, size=(2, 3))
        way = np.abs(random_unit(rng)) + 0.05
        a = box(size_a, where, q)
        b = box(size_b, where + matrix_of(q) @ (size_a + size_b + gap * way / np.linalg.norm(way)), q)
        manifold = contacts_of(b, a, 0.1) if swapped else contacts_of(a, b, 0.1)
        assert len(manifold) == 1
        np.testing.assert_allclose(np.linalg.norm(manifold.normals, axis=1), 1.0, rtol=0, atol=1e-14)


@both_ways
def test_the_normal_points_from_the_first_body_to_the_second(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """Move the second along it by a little, and every separation grows by as much."""
    tried = 0
    for _ in range(200):
        a, b = random_pair(rng, kinds)
        before = contacts_of(a, b, 1.0)
        if not len(before):
            continue
        n, h = before.normals[0], 1e-7
        np.testing.assert_array_equal(before.normals, np.broadcast_to(n, before.normals.shape))
        moved = Placed(b.shape, b.size, np.asarray(b.position) + h * n, b.orientation)
        after = contacts_of(a, moved, 1.0)
        if len(after) != len(before) or (after.features != before.features).any():
            continue
        tried += 1
        np.testing.assert_allclose((after.separations - before.separations) / h, 1.0, rtol=0, atol=1e-5)
    assert tried > 50


@pytest.mark.parametrize("kinds", PAIRS, ids=" and ".join)
def test_swapping_the_bodies_turns_the_normal_and_nothing_else(
    rng: np.random.Generator, kinds: tuple[str, str]
) -> None:
    tried = 0
    for _ in range(300):
        a, b = random_pair(rng, kinds)
        if kinds == ("box", "box") and not has_clear_axis(a, b):
            continue
        one, other = contacts_of(a, b, 0.3), contacts_of(b, a, 0.3)
        assert len(one) == len(other)
        if not len(one):
            continue
        tried += 1
        order = [int(np.abs(other.points - p).sum(axis=1).argmin()) for p in one.points]
        assert sorted(order) == list(range(len(one)))
        np.testing.assert_allclose(other.points[order], one.points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(other.normals[order], -one.normals, rtol=0, atol=1e-12)
        np.testing.assert_allclose(other.separations[order], one.separations, rtol=0, atol=1e-12)
    assert tried > 30


def has_clear_axis(a: Placed, b: Placed) -> bool:
    """Whether one axis is better than all others by more than the slack, so that no tie has to be broken."""
    ordered = np.sort(separations_on_axes(a, b))
    return bool(ordered[-1] - ordered[-2] > 2.0 * slack(a, b))


@both_ways
def test_turning_and_shifting_the_scene_turns_and_shifts_its_contacts(
    rng: np.random.Generator, kinds: tuple[str, str]
) -> None:
    tried = 0
    for _ in range(200):
        a, b = random_pair(rng, kinds)
        if kinds == ("box", "box") and not has_clear_axis(a, b):
            continue
        q, shift = random_unit(rng, 4), rng.normal(size=3)
        here, there = contacts_of(a, b, 0.3), contacts_of(a.moved(shift, q), b.moved(shift, q), 0.3)
        if not len(here):
            continue
        tried += 1
        R = matrix_of(q)
        np.testing.assert_array_equal(there.features, here.features)
        np.testing.assert_allclose(there.points, here.points @ R.T + shift, rtol=0, atol=1e-11)
        np.testing.assert_allclose(there.normals, here.normals @ R.T, rtol=0, atol=1e-11)
        np.testing.assert_allclose(there.separations, here.separations, rtol=0, atol=1e-11)
    assert tried > 20


# --- a sphere and anything --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("other", ["sphere", "box", "plane"])
def test_a_sphere_touches_where_the_other_shape_is_nearest(rng: np.random.Generator, other: str) -> None:
    """Separation is the centre's distance less the radius, inside or outside, and both surfaces are met half way."""
    inside = 0
    for _ in range(500):
        a, b = random_pair(rng, ("sphere", other))
        m = contacts_of(a, b, 10.0)
        (separation,), (n,), (point,) = m.separations, m.normals, m.points
        distance = signed_distance(b, np.asarray(a.position))
        inside += distance < 0.0
        assert separation == pytest.approx(distance - a.size[0], abs=1e-12)
        assert signed_distance(a, point - 0.5 * separation * n) == pytest.approx(0.0, abs=1e-12)
        assert signed_distance(b, point + 0.5 * separation * n) == pytest.approx(0.0, abs=1e-12)
    assert inside > 10


def test_the_nearest_point_of_a_box_by_least_squares(rng: np.random.Generator) -> None:
    """An optimiser that knows nothing of faces and corners finds the same point."""
    for _ in range(50):
        a, b = random_pair(rng, ("sphere", "box"))
        offset = np.asarray(a.position) - np.asarray(b.position)
        half = np.array(b.size)
        nearest = lsq_linear(b.axes, offset, bounds=(-half, half), tol=1e-14)
        distance = np.linalg.norm(b.axes @ nearest.x - offset)
        if distance < 1e-3:
            continue
        m = contacts_of(a, b, 10.0)
        assert m.separations[0] == pytest.approx(distance - a.size[0], abs=1e-7)
        np.testing.assert_allclose(-m.normals[0] * distance, offset - b.axes @ nearest.x, atol=1e-6)


def test_spheres_with_one_centre_get_some_normal() -> None:
    m = contacts_of(sphere(1.0, (1, 2, 3)), sphere(0.5, (1, 2, 3)), 0.0)
    assert m.separations.tolist() == [-1.5]
    assert np.linalg.norm(m.normals[0]) == 1.0


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_sphere_inside_a_box_leaves_through_the_nearest_face(axis: int, side: float) -> None:
    centre = np.zeros(3)
    centre[axis] = 0.9 * side
    m = contacts_of(sphere(0.25, centre), box((1.0, 1.0, 1.0)), 0.0)
    assert m.separations[0] == pytest.approx(-0.35)
    wanted = np.zeros(3)
    wanted[axis] = -side
    np.testing.assert_array_equal(m.normals[0], wanted)


# --- a box and a plane ------------------------------------------------------------------------------------------------


def test_a_box_meets_a_plane_with_its_lowest_corners(rng: np.random.Generator) -> None:
    """Each contact is one of the eight corners, found by trying all; the deepest is among them."""
    for _ in range(500):
        a, b = random_pair(rng, ("box", "plane"))
        n = b.axes @ np.array(b.size[:3])
        heights = (a.corners() - np.asarray(b.position)) @ n - b.size[3]
        m = contacts_of(a, b, 0.3)
        # between margin and margin + BEYOND a corner may count or not
        near, may = int((heights <= 0.3).sum()), int((heights <= 0.3 + BEYOND).sum())
        assert min(4, near) <= len(m) <= min(4, may) or (may > 4 and 0 < len(m) <= 4)
        for separation, corner, point, normal in zip(m.separations, m.features, m.points, m.normals, strict=True):
            assert separation == pytest.approx(heights[corner], abs=1e-12)
            np.testing.assert_allclose(normal, -n, atol=1e-14)
            np.testing.assert_allclose(point, a.corners()[corner] - 0.5 * separation * n, atol=1e-12)
        if len(m):
            # depths are told apart by a hundredth of the patch only
            assert m.separations.min() <= heights.min() + SAME_DEPTH * 2.0 * float(np.linalg.norm(a.size[:3])) + 1e-8


@pytest.mark.parametrize("yaw", [0.0, 0.3, math.pi / 4])
def test_a_flat_box_stands_on_the_four_corners_of_its_lower_face(yaw: float) -> None:
    q = (math.cos(0.5 * yaw), 0, 0, math.sin(0.5 * yaw))
    for margin in (0.01, 5.0):  # a fast box looks so far ahead that its upper corners come into reach
        m = contacts_of(box((1.0, 0.5, 0.2), (3, 4, 0.2), q), plane((0, 0, 1), 0.0), margin)
        assert sorted(m.features.tolist()) == [0, 1, 2, 3]
        np.testing.assert_allclose(m.separations, 0.0, atol=1e-15)


# --- two boxes --------------------------------------------------------------------------------------------------------


def test_overlapping_boxes_always_touch_and_leave_the_shortest_way(rng: np.random.Generator) -> None:
    """The depth is the least over all 15 axes, up to the preference for faces; pushed out by it they come free."""
    for a, b in box_pairs(rng, 400, overlapping(rng)):
        m = contacts_of(a, b, 0.0)
        best = separations_on_axes(a, b).max()
        assert len(m) > 0
        depth, n = m.separations.min(), m.normals[0]
        # the corner that is deepest below a face which is preferred to a better edge may lie beside it
        assert depth <= best + slack(a, b) + 1e-9
        assert gap_along(a, b, n) >= best - slack(a, b) - 1e-9
        assert gap_along(a, b, n) - 1e-9 <= depth <= gap_along(a, b, n) + slack(a, b) + 1e-9
        free = box(b.size, np.asarray(b.position) - gap_along(a, b, n) * n, b.orientation)
        assert -1e-9 <= separations_on_axes(a, free).max() <= slack(a, b) + 1e-9


@pytest.mark.parametrize(
    ("first", "second", "q", "position"),
    [
        ((0.8, 0.6, 0.4), (0.7, 0.6, 0.9), (0.14, 0.69, -0.59, -0.4), (0.579, 1.368, -1.224)),
        ((1.0, 0.7, 0.6), (0.9, 0.6, 0.5), (0.37, 0.0, 0.56, 0.74), (1.532, 0.442, 1.655)),
        ((0.9, 0.7, 0.8), (0.5, 1.0, 1.0), (0.35, -0.31, -0.84, -0.28), (-1.623, 1.521, 0.568)),
    ],
)
def test_crossing_edges_touch_even_where_a_face_is_nearly_as_good(
    first: Any, second: Any, q: Any, position: Any
) -> None:
    """1 to 2 mm deep. The preferred face has no corner of the other box over it: then the edges have to do."""
    a, b = box(first), box(second, position, np.array(q) / np.linalg.norm(q))
    separations = separations_on_axes(a, b)
    assert separations.argmax() >= 6
    assert -0.0021 < separations.max() < -0.00098
    m = contacts_of(a, b, 0.0)
    assert len(m) > 0
    assert m.separations.min() == pytest.approx(separations.max(), abs=slack(a, b))


def test_no_direction_at_all_is_a_shorter_way_out(rng: np.random.Generator) -> None:
    """Brute force that knows nothing of axes: ten thousand directions on the sphere."""
    directions = rng.normal(size=(10_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for a, b in box_pairs(rng, 30, overlapping(rng)):
        reach = np.abs(directions @ a.axes) @ np.array(a.size) + np.abs(directions @ b.axes) @ np.array(b.size)
        ways = reach - np.abs(directions @ (np.asarray(b.position) - np.asarray(a.position)))
        m = contacts_of(a, b, 0.0)
        assert -gap_along(a, b, m.normals[0]) <= ways.min() + slack(a, b) + 1e-9


def test_contact_points_lie_in_both_boxes(rng: np.random.Generator) -> None:
    """Up to half the depth and the slack. A point outside would give an impulse an arm that no body has there."""
    for a, b in box_pairs(rng, 2000, overlapping(rng)):
        m = contacts_of(a, b, 0.0)
        allowed = np.abs(m.separations) + slack(a, b) + 1e-9
        outside = np.array([max(signed_distance(a, p), signed_distance(b, p)) for p in m.points])
        assert (outside <= allowed).all(), (a, b, m.points, outside)


def test_an_edge_contact_is_that_of_the_best_pair_of_edges() -> None:
    """Two pairs of edges are nearly as good, 0.54 and 1.9 mm deep; the lines of the second meet 0.2 m off the boxes."""
    q = np.array([0.27, 0.34, 0.9, -0.1])
    a = box((0.5, 0.7, 0.5))
    b = box((0.4, 0.3, 0.4), (-0.482, -1.116, 0.666), q / np.linalg.norm(q))
    separations = separations_on_axes(a, b)
    assert separations.argmax() >= 6
    m = contacts_of(a, b, 0.0)
    assert len(m) == 1
    assert m.separations[0] == pytest.approx(separations.max(), abs=1e-9)
    assert signed_distance(a, m.points[0]) <= 1e-9
    assert signed_distance(b, m.points[0]) <= 1e-9


def test_boxes_apart_are_no_nearer_than_they_are(rng: np.random.Generator) -> None:
    """Reported gaps are never below the gap seen along the best axis; boxes beyond the margin give nothing."""
    touching = 0
    for a, b in box_pairs(rng, 200, lambda: float(rng.uniform(0.01, 0.3))):
        best = separations_on_axes(a, b).max()
        assert best <= distance_of_boxes(a, b) + 1e-6
        assert len(contacts_of(a, b, 0.99 * best)) == 0
        m = contacts_of(a, b, best + 0.1)
        touching += len(m) > 0
        if len(m):
            assert m.separations.min() >= best - slack(a, b) - 1e-9
        for point, separation, n in zip(m.points, m.separations, m.normals, strict=True):
            if m.features[0] >> 8 < 6:  # a face: the two surface points are real, so the boxes are no farther apart
                ends = point - 0.5 * separation * n, point + 0.5 * separation * n
                assert signed_distance(a, ends[0]) == pytest.approx(0.0, abs=1e-9)
                assert signed_distance(b, ends[1]) == pytest.approx(0.0, abs=1e-9)
    assert touching > 50


def test_boxes_that_are_apart_meet_where_they_are_nearest(rng: np.random.Generator) -> None:
    """Also where that is a corner beside all faces, and where lines of edges cross beyond the ends of the edges."""
    for k in range(400):
        a = box(rng.uniform(0.3, 1.5, size=3), rng.normal(size=3), random_unit(rng, 4))
        q = random_unit(rng, 4)
        if k % 2:  # faces nearly parallel, edges too or not
            yaw, tilt = rng.uniform(0.0, math.pi) if k % 4 == 1 else 0.0, np.zeros(4)
            tilt[:] = 1.0, *(10.0 ** rng.uniform(-5.0, -1.0) * random_unit(rng))
            q = product(a.orientation, product((math.cos(0.5 * yaw), 0, 0, math.sin(0.5 * yaw)), tilt))
            q /= np.linalg.norm(q)
        b = box(rng.uniform(0.3, 1.5, size=3), np.zeros(3), q)
        b = at_gap(a, b, random_unit(rng), float(rng.uniform(0.01, 0.1)))
        distance = distance_of_boxes(a, b)
        m = contacts_of(a, b, distance + 0.1)
        assert len(m) > 0
        assert distance - 2.0 * slack(a, b) <= m.separations.min() <= distance + slack(a, b) + 1e-6
        assert gap_along(a, b, m.normals[0]) >= distance - 2.0 * slack(a, b) - 1e-6
        for point, separation in zip(m.points, m.separations, strict=True):
            assert max(signed_distance(a, point), signed_distance(b, point)) <= 0.5 * separation + 1e-9


@pytest.mark.parametrize("gap", [-0.01, 0.0, 0.01])
def test_face_on_face_gives_the_four_corners_of_the_overlap(gap: float) -> None:
    lower, upper = box((1.0, 1.0, 0.5)), box((1.0, 0.5, 0.25), (0.5, 0.25, 0.75 + gap))
    m = contacts_of(lower, upper, 0.02)
    np.testing.assert_allclose(m.separations, gap, atol=1e-15)
    np.testing.assert_array_equal(m.normals, [[0.0, 0.0, 1.0]] * 4)
    corners = sorted((round(x, 12), round(y, 12)) for x, y, _ in m.points)
    assert corners == [(-0.5, -0.25), (-0.5, 0.75), (1.0, -0.25), (1.0, 0.75)]
    np.testing.assert_allclose(m.points[:, 2], 0.5 + 0.5 * gap, atol=1e-15)


def test_an_edge_on_a_face_gives_two_points_and_a_corner_one() -> None:
    floor = box((2.0, 2.0, 0.5))
    s = math.sqrt(0.5)
    on_edge = box((0.5, 0.5, 0.5), (0, 0, 0.5 + s - 0.001), (math.cos(math.pi / 8), math.sin(math.pi / 8), 0, 0))
    m = contacts_of(floor, on_edge, 0.0)
    assert sorted(round(x, 12) for x in m.points[:, 0]) == [-0.5, 0.5]
    np.testing.assert_allclose(m.points[:, 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(m.separations, -0.001, atol=1e-12)

    # a cube on its corner: the long diagonal is vertical
    axis, angle = np.array([1.0, -1.0, 0.0]) / math.sqrt(2), math.acos(1 / math.sqrt(3))
    q = (math.cos(angle / 2), *(axis * math.sin(angle / 2)))
    on_corner = box((0.5, 0.5, 0.5), (0.3, -0.2, 0.5 + math.sqrt(0.75) - 0.001), q)
    m = contacts_of(floor, on_corner, 0.0)
    assert len(m) == 1
    np.testing.assert_allclose(m.points[0], (0.3, -0.2, 0.4995), atol=1e-9)


@pytest.mark.parametrize("turn", [0.3, math.pi / 4, math.pi / 2])
def test_two_crossing_edges_give_one_point_where_they_cross(turn: float) -> None:
    """The upper edge of a lying prism along x, the lower edge of one turned about z: they cross on the z axis."""
    tilt = np.array([math.cos(math.pi / 8), math.sin(math.pi / 8), 0, 0])
    yaw = np.array([math.cos(turn / 2), 0, 0, math.sin(turn / 2)])
    s = math.sqrt(0.5)
    lower = box((2.0, 0.5, 0.5), (0.4, 0, 0), tilt)
    upper = box((2.0, 0.5, 0.5), (0, 0, 2 * s - 0.002), product(yaw, tilt))
    m = contacts_of(lower, upper, 0.0)
    assert len(m) == 1
    assert m.separations[0] == pytest.approx(-0.002, abs=1e-12)
    np.testing.assert_allclose(m.normals[0], (0, 0, 1), atol=1e-12)
    np.testing.assert_allclose(m.points[0], (0, 0, s - 0.001), atol=1e-12)


def test_features_stay_when_a_body_moves_a_little(rng: np.random.Generator) -> None:
    """A box that lies on another one, well inside its face or over one edge, pushed about by micrometres."""
    lower, half = box((1.0, 0.8, 0.5)), (0.45, 0.3, 0.2)
    for where in ((0.1, -0.1, 0.7), (0.9, 0.0, 0.7)):
        for _ in range(25):
            yaw = rng.uniform(0.1, math.pi / 4 - 0.1)
            q = np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)])
            first = contacts_of(lower, box(half, where, q), 1e-3)
            for again in pushed_about(rng, lower, half, where, q):
                # over the edge there are five corners to choose four from, and which is deepest changes
                if where[0] < 0.5:
                    assert sorted(again.features.tolist()) == sorted(first.features.tolist())
                for feature, point in zip(again.features, again.points, strict=True):
                    same = first.points[first.features == feature]
                    if len(same):
                        np.testing.assert_allclose(point, same[0], rtol=0, atol=2e-5)


def pushed_about(rng: np.random.Generator, lower: Placed, half: Any, where: Any, q: Array) -> Iterator[Manifold]:
    """Contacts after ten different motions by micrometres and microradians."""
    for _ in range(10):
        turn = np.array([1.0, *rng.uniform(-1e-6, 1e-6, size=3)])
        shift = rng.uniform(-1e-6, 1e-6, size=3)
        yield contacts_of(lower, box(half, np.array(where) + shift, product(turn / np.linalg.norm(turn), q)), 1e-3)


def overlap_area(lower: Placed, upper: Placed) -> float:
    """Area common to the faces of two boxes whose z axes are parallel."""
    planes = []
    for placed in (lower, upper):
        for k in range(2):
            n = placed.axes[:2, k]
            c = n @ np.asarray(placed.position)[:2]
            planes += [[*n, -c - placed.size[k]], [*-n, c - placed.size[k]]]
    inside = 0.5 * (np.asarray(lower.position) + np.asarray(upper.position))[:2]
    return float(ConvexHull(HalfspaceIntersection(np.array(planes), inside).intersections).volume)


def test_reduction_keeps_most_of_the_area(rng: np.random.Generator) -> None:
    """Two faces askew overlap in up to eight corners. Four of them remain, with most of the area."""
    ratios = []
    for _ in range(300):
        yaw = rng.uniform(0.0, math.pi)
        q = np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)])
        lower, upper = box((*rng.uniform(0.5, 1.0, size=2), 0.5)), None
        upper = box((*rng.uniform(0.5, 1.0, size=2), 0.5), (*rng.uniform(-0.3, 0.3, size=2), 0.999), q)
        m = contacts_of(lower, upper, 0.0)
        ratios.append(ConvexHull(m.points[:, :2]).volume / overlap_area(lower, upper))
    assert min(ratios) >= 0.4
    assert np.mean(ratios) > 0.8


def polygon(rng: np.random.Generator, n: int) -> Array:
    """Rows as ``reduce`` reads them: n corners of a convex polygon in a random plane, depths and features."""
    angles = np.sort(rng.uniform(0.0, 2 * math.pi, size=n))
    flat = np.column_stack([np.cos(angles), rng.uniform(0.3, 1.0) * np.sin(angles), np.zeros(n)])
    rows = np.zeros((16, 5))
    rows[:n, :3] = flat @ matrix_of(np.array([1.0, 0, 0, 0]))
    rows[:n, 3] = rng.uniform(-0.1, 0.0, size=n)
    rows[:n, 4] = np.arange(n)
    return rows


def test_reduction_keeps_the_deepest_point_and_a_good_quadrilateral(rng: np.random.Generator) -> None:
    """Against all choices of four: never below 30 % of the best area, and 80 % on average."""
    up = vec((0, 0, 1))
    ratios = []
    for _ in range(300):
        n = int(rng.integers(5, 9))
        rows = polygon(rng, n)
        before = rows[:n].copy()
        kept = compiled(reduce)(rows, n, up)
        chosen = rows[:kept]
        assert kept <= 4
        assert len({tuple(r) for r in chosen}) == kept
        assert {tuple(r) for r in chosen} <= {tuple(r) for r in before}
        size = np.linalg.norm(np.ptp(before[:, :2], axis=0))
        assert chosen[:, 3].min() <= before[:, 3].min() + SAME_DEPTH * size
        best = max(ConvexHull(before[list(four), :2]).volume for four in itertools.combinations(range(n), 4))
        ratios.append(ConvexHull(chosen[:, :2]).volume / best)
    assert min(ratios) >= 0.3
    assert np.mean(ratios) > 0.8


def test_reduction_leaves_four_points_as_they_are(rng: np.random.Generator) -> None:
    for n in range(5):
        rows = polygon(rng, n) if n else np.zeros((16, 5))
        before = rows.copy()
        assert compiled(reduce)(rows, n, vec((0, 0, 1))) == n
        np.testing.assert_array_equal(rows, before)


# --- room -------------------------------------------------------------------------------------------------------------


def test_too_little_room_is_counted_and_not_written_over() -> None:
    """Four contacts, room for two: the kernel says four, so that the caller can grow and ask again."""
    bodies, kinds = state.make_bodies(2)
    bodies[:, state.SIZE : state.SIZE + 3] = 0.5
    bodies[1, state.POSITION + 2] = 1.0
    bodies[0, state.INVERSE_MASS] = 1.0
    kinds[:, :3] = (state.BOX, state.DYNAMIC, 0), (state.BOX, state.STATIC, 0)
    backing, tags = state.make_contacts(3)
    backing[2] = 7.0
    scratch = state.make_lists(2, 2, 1).points
    pairs = np.array([[0, 1]])
    found = compiled(find_contacts)(bodies, kinds, pairs, 1, backing[:2], tags[:2], 1e-3, 1.0, scratch, 1, None)
    assert found == 4
    assert (backing[2] == 7.0).all()
    full: Manifold = contacts_of(box((0.5,) * 3), box((0.5,) * 3, (0, 0, 1)), 1e-3)
    np.testing.assert_array_equal(backing[:2, state.POINT : state.POINT + 3], full.points[:2])


def test_worlds_whose_boxes_never_meet_skip_that_branch() -> None:
    """With None in place of the flag the kernel has no code for two boxes; all other pairs are found as before."""
    bodies, kinds = state.make_bodies(3)
    bodies[:, state.SIZE : state.SIZE + 3] = 0.5
    bodies[2, state.SIZE : state.SIZE + 4] = (0, 0, 1, -0.5)
    bodies[0, state.INVERSE_MASS] = 1.0
    kinds[:, :3] = (state.BOX, state.DYNAMIC, 0), (state.BOX, state.STATIC, 0), (state.PLANE, state.STATIC, 0)
    contacts, tags = state.make_contacts(16)
    scratch = state.make_lists(3, 16, 3).points
    pairs = np.array([[0, 1], [0, 2]])

    def found(flag: Any) -> int:
        return int(compiled(find_contacts)(bodies, kinds, pairs, 2, contacts, tags, 1e-3, 1.0, scratch, flag, None))

    assert found(None) == 4
    assert found(1) > 4
