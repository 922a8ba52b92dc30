"""Contacts of capsules, cylinders, ellipsoids and hulls with everything: known places, brute force, fuzz, and rest.

The separation of two convex shapes along n is how far they are apart seen from the side of n. Its largest value over
all directions is their distance or, where they overlap, minus the least translation that frees them: no knowledge of
faces and edges goes into the brute force that looks for it.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

import stiction as st
from stiction.core import state
from stiction.core.collide.manifold import ROUND
from stiction.hulls import HullTable

from .support import BEYOND, Array, Manifold, Placed, box, contacts_of, matrix_of, plane, product, random_unit, sphere

TABLE = HullTable()
HULLS: dict[int, Array] = {}
"""Vertices of the hulls in the table, by row."""

UP = (1.0, 0.0, 0.0, 0.0)
LYING = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
"""Turns the z axis into x."""


def capsule(radius: float, half: float, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """A capsule by its radius and half the distance of its centres."""
    return Placed(state.CAPSULE, (radius, radius, half + radius, 0.0), position, orientation)


def cylinder(radius: float, half: float, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """A cylinder by its radius and half length."""
    return Placed(state.CYLINDER, (radius, radius, half, 0.0), position, orientation)


def ellipsoid(half: Any, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """An ellipsoid by its semi-axes."""
    return Placed(state.ELLIPSOID, (*(float(h) for h in half), 0.0), position, orientation)


def hull(points: Any, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """The hull of some points."""
    shape = st.ConvexHull(points)
    row = TABLE.add(shape)
    HULLS[row] = shape.points
    return Placed(state.HULL, (*np.abs(shape.points).max(axis=0), row), position, orientation)


def cube(half: Any, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """A box as a hull of eight points."""
    return hull(list(itertools.product(*((-h, h) for h in half))), position, orientation)


def touching(a: Placed, b: Placed, margin: float = 0.0) -> Manifold:
    """What the narrow phase finds."""
    return contacts_of(a, b, margin, hulls=TABLE.arrays)


# --- brute force ------------------------------------------------------------------------------------------------------


def support(placed: Placed, n: Array) -> Array:
    """How far a shape reaches along each direction n (k, 3)."""
    m, s = n @ placed.axes, placed.size
    reach = n @ np.asarray(placed.position)
    if placed.shape == state.SPHERE:
        return np.asarray(reach + s[0])
    if placed.shape == state.BOX:
        return np.asarray(reach + np.abs(m) @ np.array(s[:3]))
    if placed.shape == state.CAPSULE:
        return np.asarray(reach + np.abs(m[:, 2]) * (s[2] - s[0]) + s[0])
    if placed.shape == state.CYLINDER:
        return np.asarray(reach + np.hypot(m[:, 0], m[:, 1]) * s[0] + np.abs(m[:, 2]) * s[2])
    if placed.shape == state.ELLIPSOID:
        return np.asarray(reach + np.linalg.norm(m * s[:3], axis=1))
    return np.asarray(reach + (m @ HULLS[int(s[3])].T).max(axis=1))


def along(a: Placed, b: Placed, n: Array) -> Array:
    """Separation of two shapes seen along each direction n (k, 3)."""
    return -support(b, -n) - support(a, n)


def best_separation(rng: np.random.Generator, a: Placed, b: Placed) -> float:
    """The largest over ten thousand directions, and a random search about the best few of them.

    Two faces that pass into one another make a ridge, on which few steps go up. So the steps take after the best ones
    of those before: they grow long along the ridge.
    """
    n = rng.normal(size=(10_000, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    found = along(a, b, n)
    best = -math.inf
    for start in np.argsort(-found)[:4]:
        here, value, spread = n[start], found[start], 4e-4 * np.eye(3)
        for _ in range(1000):  # balls about one centre are as good as ever everywhere
            if np.trace(spread) <= 1e-16:
                break
            near = here + rng.normal(size=(50, 3)) @ np.linalg.cholesky(spread).T
            near /= np.linalg.norm(near, axis=1)[:, None]
            values = along(a, b, near)
            good = np.argsort(-values)[:12]
            steps = near[good] - here
            further = values[good[0]] > value
            spread = 0.3 * spread + (1.4 if further else 0.7) * steps.T @ steps / len(good)
            spread += 1e-8 * np.trace(spread) * np.eye(3)
            if further:
                here, value = near[good[0]], values[good[0]]
        best = max(best, float(value))
    return best


# --- random scenes ----------------------------------------------------------------------------------------------------

KINDS = ("sphere", "box", "capsule", "cylinder", "hull", "ellipsoid")
PAIRS = [p for p in itertools.combinations_with_replacement(KINDS, 2) if {*p} - {"sphere", "box"}]
every_pair = pytest.mark.parametrize("kinds", PAIRS, ids=" and ".join)


def random_shape(rng: np.random.Generator, kind: str) -> Placed:
    """A shape of that kind at the origin, of about half a metre."""
    q = random_unit(rng, 4)
    r, h = (float(x) for x in rng.uniform(0.2, 1.0, size=2))
    if kind == "sphere":
        return sphere(r, (0.0, 0.0, 0.0))
    if kind == "box":
        return box(rng.uniform(0.2, 1.0, size=3), orientation=q)
    if kind == "capsule":
        return capsule(r, h, orientation=q)
    if kind == "cylinder":
        return cylinder(r, h, orientation=q)
    if kind == "ellipsoid":
        return ellipsoid(rng.uniform(0.2, 1.0, size=3), orientation=q)
    if kind == "hull":
        return hull(0.5 * rng.normal(size=(int(rng.integers(5, 20)), 3)), orientation=q)
    return plane(random_unit(rng), 0.0)


def at_gap(rng: np.random.Generator, a: Placed, b: Placed, gap: float) -> Placed:
    """b moved away from a in some direction until they are ``gap`` apart, to a thousandth of their size.

    What a direction sees grows in proportion to the way, so each says how far b may go, and the least counts. Three
    thousand directions lie 0.05 apart, and metres of width times that are a wide miss: the search is repeated among
    directions ever nearer to the best one, too.
    """
    way, anywhere = random_unit(rng), rng.normal(size=(3000, 3))
    anywhere /= np.linalg.norm(anywhere, axis=1)[:, None]
    n, middle = anywhere, replace(b, position=np.asarray(a.position))
    for spread in (0.1, 0.02, 0.004, 0.0):
        n = n[n @ way > 1e-9]
        far = (gap - along(a, middle, n)) / (n @ way)
        best = n[far.argmin()]
        b = replace(b, position=middle.position + max(float(far.min()), 0.0) * way)
        near_it = best + spread * rng.normal(size=(1000, 3))
        near_it /= np.linalg.norm(near_it, axis=1)[:, None]
        n = np.vstack([best, near_it, anywhere])  # what is best near here need not be so farther out
    return b


def random_pair(rng: np.random.Generator, kinds: tuple[str, str], gap: float) -> tuple[Placed, Placed]:
    """Two shapes of these kinds, about ``gap`` apart."""
    a = replace(random_shape(rng, kinds[0]), position=rng.normal(size=3))
    return a, at_gap(rng, a, random_shape(rng, kinds[1]), gap)


def least_width(*shapes: Placed) -> float:
    """The smallest width of all, m."""
    widths = []
    for placed in shapes:
        if placed.shape == state.SPHERE:
            widths.append(2.0 * placed.size[0])
        elif placed.shape == state.HULL:
            row = int(placed.size[3])
            widths.append(2.0 * TABLE.arrays.breadths[row])
        else:
            widths.append(2.0 * min(placed.size[:3]))
    return min(widths)


# --- what holds for every pair ----------------------------------------------------------------------------------------


@every_pair
def test_the_separation_is_the_largest_over_all_directions(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """Apart or up to a tenth of a metre deep; a face may be preferred that is worse by a part of the least width."""
    for gap in (-0.1, -0.01, -1e-3, -1e-5, 1e-5, 1e-3, 0.01, 0.1, 0.5):
        for _ in range(3):
            a, b = random_pair(rng, kinds, gap)
            best = best_separation(rng, a, b)
            m = touching(a, b, 1.0)
            slack = 0.003 * least_width(a, b) + 2e-4
            assert len(m) > 0
            assert (m.normals == m.normals[0]).all()
            seen = along(a, b, m.normals[:1])[0]
            assert seen >= best - slack - (0.3 * max(-gap, 0.0) if gap < -0.05 else 0.0), (gap, a, b)
            assert m.separations.min() >= seen - 1e-9
            assert m.separations.min() <= best + 2.0 * slack + 0.1 * max(-gap, 0.0), (gap, a, b)


def look_at_points(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """No direction sees a point outside of either shape by more than half the separation and the slack."""
    n = rng.normal(size=(2000, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    for gap in (-0.02, -1e-4, 1e-4, 0.02):
        for _ in range(10):
            a, b = random_pair(rng, kinds, gap)
            m = touching(a, b, 0.05)
            slack = 0.01 * least_width(a, b) + 1e-5
            for point, separation in zip(m.points, m.separations, strict=True):
                for placed in (a, b):
                    outside = (n @ point - support(placed, n)).max()
                    assert outside <= 0.5 * abs(separation) + slack


@every_pair
def test_contact_points_lie_half_way_between_the_surfaces(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    look_at_points(rng, kinds)


def test_a_corner_below_a_face_touches_it_though_edges_beside_it_are_as_good() -> None:
    """Drawn once: edges that pass each other 6 cm apart have a normal that is nearly as good."""
    look_at_points(np.random.default_rng(1955808493), ("box", "hull"))


@every_pair
def test_nothing_beyond_the_margin_and_at_most_four(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    for _ in range(60):
        gap = float(rng.uniform(-0.1, 0.2))
        a, b = random_pair(rng, kinds, gap)
        margin = float(rng.uniform(0.0, 0.2))
        m = touching(a, b, margin)
        assert len(m) <= 4
        assert (m.separations <= margin + BEYOND).all()
        assert (m.bodies == (0, 1)).all()
        assert len(set(m.features.tolist())) == len(m)
        np.testing.assert_allclose(np.linalg.norm(m.normals, axis=1), 1.0, rtol=0, atol=1e-12)
        assert len(m) > 0 or best_separation(rng, a, b) > margin - 1e-3


@every_pair
def test_swapping_the_bodies_turns_the_normal(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    for _ in range(30):
        a, b = random_pair(rng, kinds, float(rng.uniform(-0.05, 0.05)))
        one, other = touching(a, b, 0.1), touching(b, a, 0.1)
        if kinds[0] != kinds[1]:
            assert len(one) == len(other)
            np.testing.assert_allclose(other.normals, -one.normals, rtol=0, atol=1e-9)
            np.testing.assert_allclose(other.points, one.points, rtol=0, atol=1e-9)
            np.testing.assert_allclose(other.separations, one.separations, rtol=0, atol=1e-9)
        elif len(one) and len(other):
            # faces of the first are preferred, so another one may be the reference
            seen = [along(a, b, n[None])[0] for n in (one.normals[0], -other.normals[0])]
            assert abs(seen[0] - seen[1]) <= 0.006 * least_width(a, b) + 2e-3


@every_pair
def test_turning_and_shifting_the_scene_turns_and_shifts_its_contacts(
    rng: np.random.Generator, kinds: tuple[str, str]
) -> None:
    same = 0
    for _ in range(40):
        a, b = random_pair(rng, kinds, float(rng.uniform(-0.02, 0.05)))
        q, shift = random_unit(rng, 4), 10.0 * rng.normal(size=3)
        R = matrix_of(q)
        here, there = touching(a, b, 0.1), touching(a.moved(shift, q), b.moved(shift, q), 0.1)
        if len(here) != len(there) or not len(here):
            continue
        same += np.abs(there.normals - here.normals @ R.T).max() < 1e-5 and (
            np.abs(there.points - here.points @ R.T - shift).max() < 1e-5
        )
    assert same >= 36  # ties are broken by rounding


# --- known places -----------------------------------------------------------------------------------------------------


def same_rows(found: Array, wanted: Any, atol: float = 1e-9) -> None:
    """The same points in any order."""
    wanted = np.array(wanted, float)
    assert len(found) == len(wanted)
    order = np.lexsort(np.round(found, 6).T), np.lexsort(np.round(wanted, 6).T)
    np.testing.assert_allclose(found[order[0]], wanted[order[1]], rtol=0, atol=atol)


FLOORS = {
    "plane": plane((0.0, 0.0, 1.0), 0.0),
    "box": box((3.0, 3.0, 0.5), (0.0, 0.0, -0.5)),
    "hull": cube((3.0, 3.0, 0.5), (0.0, 0.0, -0.5)),
    "cylinder": cylinder(3.0, 0.5, (0.0, 0.0, -0.5)),
}
every_floor = pytest.mark.parametrize("floor", FLOORS.values(), ids=FLOORS)


@every_floor
@pytest.mark.parametrize("gap", [-1e-3, 0.0, 1e-3])
def test_lying_on_a_floor(floor: Placed, gap: float) -> None:
    """Capsule and cylinder touch along a line, a box of points with four corners, a tetrahedron with three."""
    half = 0.5 * gap
    m = touching(floor, capsule(0.2, 0.5, (0.3, 0.1, 0.2 + gap), LYING), 0.01)
    same_rows(m.points, [(-0.2, 0.1, half), (0.8, 0.1, half)], 1e-8)
    np.testing.assert_allclose(m.separations, gap, atol=1e-9)
    np.testing.assert_allclose(m.normals, [(0, 0, 1)] * 2, atol=1e-9)

    m = touching(floor, cylinder(0.2, 0.5, (0.3, 0.1, 0.2 + gap), LYING), 0.01)
    same_rows(m.points, [(-0.2, 0.1, half), (0.8, 0.1, half)])
    np.testing.assert_allclose(m.separations, gap, atol=1e-9)

    m = touching(floor, cube((0.2, 0.3, 0.4), (0.3, 0.1, 0.4 + gap)), 0.01)
    same_rows(m.points, [(x, y, half) for x in (0.1, 0.5) for y in (-0.2, 0.4)])
    np.testing.assert_allclose(m.separations, gap, atol=1e-9)

    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, 1)]
    m = touching(floor, hull(corners, (0.3, 0.1, gap)), 0.01)
    same_rows(m.points, [(x + 0.3, y + 0.1, half) for x, y, _ in corners[:3]])
    np.testing.assert_allclose(m.separations, gap, atol=1e-9)


@every_floor
@pytest.mark.parametrize("gap", [-1e-3, 0.0, 1e-3])
def test_standing_on_a_cap_is_four_points_of_its_rim_that_turn_with_the_body(floor: Placed, gap: float) -> None:
    yaw = np.array([math.cos(0.2), 0.0, 0.0, math.sin(0.2)])
    m = touching(floor, cylinder(0.2, 0.5, (0.3, 0.1, 0.5 + gap), yaw), 0.01)
    rim = [
        (0.3 + 0.2 * math.cos(0.4 + t), 0.1 + 0.2 * math.sin(0.4 + t), 0.5 * gap) for t in np.arange(4) * math.pi / 2
    ]
    same_rows(m.points, rim)
    np.testing.assert_allclose(m.separations, gap, atol=1e-9)
    assert (m.features & ROUND == ROUND).all()
    again = touching(floor, cylinder(0.2, 0.5, (0.3, 0.1, 0.5 + gap), product(yaw, (1.0, 1e-5, 2e-5, 0.0))), 0.01)
    assert again.features.tolist() == m.features.tolist()


@every_floor
def test_a_tilted_cylinder_touches_with_the_lowest_point_of_its_rim(floor: Placed) -> None:
    """At any azimuth, and smoothly: the point is where the rim is lowest."""
    for tilt, azimuth in itertools.product((0.01, 0.3, 1.2), np.linspace(0.0, 6.0, 7)):
        c, s = math.cos(0.5 * tilt), math.sin(0.5 * tilt)
        q = product(
            (c, s * math.cos(azimuth), s * math.sin(azimuth), 0.0), (math.cos(azimuth), 0, 0, math.sin(azimuth))
        )
        height = 0.2 * math.sin(tilt) + 0.5 * math.cos(tilt)
        m = touching(floor, cylinder(0.2, 0.5, (0.1, 0.2, height - 1e-4), q), 0.0)
        axis = matrix_of(q)[:, 2]
        down = axis * axis[2] - (0, 0, 1)
        lowest = np.array((0.1, 0.2, height - 1e-4)) - 0.5 * axis + 0.2 * down / np.linalg.norm(down)
        assert m.separations.min() == pytest.approx(-1e-4, abs=1e-9)
        np.testing.assert_allclose(m.points[m.separations.argmin()], lowest + np.array([0, 0, 5e-5]), atol=1e-8)
        assert not (m.features & ROUND).any()


def test_a_cap_that_is_larger_than_a_face_touches_where_the_face_is() -> None:
    m = touching(box((0.2, 0.3, 0.5)), cylinder(2.0, 0.1, (0.1, 0.1, 0.6)), 1e-3)
    same_rows(m.points, [(x, y, 0.5) for x in (-0.2, 0.2) for y in (-0.3, 0.3)], 1e-6)
    assert not (m.features & ROUND).any()


@pytest.mark.parametrize("radius", [0.5, 0.3])
def test_cylinders_that_stand_on_one_another(radius: float) -> None:
    m = touching(cylinder(0.5, 0.2), cylinder(radius, 0.1, (0.0, 0.0, 0.299)), 1e-3)
    assert len(m) == 4
    np.testing.assert_allclose(np.hypot(*m.points[:, :2].T), radius, atol=1e-9)
    np.testing.assert_allclose(m.separations, -1e-3, atol=1e-9)
    assert (m.features & ROUND == ROUND).all()


@pytest.mark.parametrize("one", [capsule, cylinder])
@pytest.mark.parametrize("other", [capsule, cylinder])
def test_parallel_rollers_touch_along_what_they_have_in_common(one: Any, other: Any) -> None:
    m = touching(one(0.2, 0.5, orientation=LYING), other(0.3, 0.5, (0.4, 0.0, 0.499), LYING), 1e-3)
    same_rows(m.points, [(-0.1, 0.0, 0.1995), (0.5, 0.0, 0.1995)])
    np.testing.assert_allclose(m.separations, -1e-3, atol=1e-9)
    np.testing.assert_allclose(m.normals, [(0, 0, 1)] * 2, atol=1e-9)


@pytest.mark.parametrize("one", [capsule, cylinder])
@pytest.mark.parametrize("other", [capsule, cylinder])
def test_crossed_rollers_touch_in_one_point(one: Any, other: Any) -> None:
    crossed = product((math.cos(0.4), 0.0, 0.0, math.sin(0.4)), LYING)
    m = touching(one(0.2, 0.5, orientation=LYING), other(0.3, 0.5, (0.0, 0.0, 0.499), crossed), 1e-3)
    same_rows(m.points, [(0.0, 0.0, 0.1995)], 1e-6)
    assert m.separations[0] == pytest.approx(-1e-3, abs=1e-9)
    np.testing.assert_allclose(m.normals, [(0, 0, 1)], atol=1e-6)


def test_a_sphere_beside_a_cylinder() -> None:
    """At the side, over a cap, off the rim, and with its centre inside."""
    c = cylinder(0.5, 1.0)
    d = 0.1 / math.sqrt(2)
    for centre, n, separation in (
        ((0.6, 0, 0.3), (1, 0, 0), 0.0),
        ((0.1, 0.2, 1.1), (0, 0, 1), 0.0),
        ((0, 0.5 + d, 1.0 + d), (0, math.sqrt(0.5), math.sqrt(0.5)), 0.0),
        ((0.4, 0, 0), (1, 0, 0), -0.2),
        ((0, 0.1, -0.9), (0, 0, -1), -0.2),
    ):
        m = touching(c, sphere(0.1, centre), 1e-3)
        np.testing.assert_allclose(m.normals, [n], atol=1e-12)
        assert m.separations[0] == pytest.approx(separation, abs=1e-12)
        np.testing.assert_allclose(m.points[0], np.array(centre) - np.array(n) * (0.1 + 0.5 * separation), atol=1e-12)


def test_a_hull_of_a_box_touches_as_the_box_does(rng: np.random.Generator) -> None:
    """Same normal and depth as the kernel for two boxes."""
    for _ in range(200):
        half = rng.uniform(0.2, 1.0, size=3)
        a, b = random_pair(rng, ("box", "box"), float(rng.choice([-0.02, -1e-3, 1e-3])))
        b = box(half, b.position, b.orientation)
        b = at_gap(rng, a, b, -0.01)
        one = contacts_of(a, b, 0.1)
        other = touching(a, cube(half, b.position, b.orientation), 0.1)
        seen = [along(a, b, m.normals[:1])[0] for m in (one, other)]
        assert abs(seen[0] - seen[1]) <= 0.006 * least_width(a, b)
        assert abs(one.separations.min() - other.separations.min()) <= 0.01 * least_width(a, b)


def test_the_edges_of_two_boxes_are_told_apart() -> None:
    """A beam that is crossed by another one at four heights and sides: four features."""
    tilt = np.array([math.cos(math.pi / 8), math.sin(math.pi / 8), 0, 0])
    across = product((math.sqrt(0.5), 0, 0, math.sqrt(0.5)), tilt)
    reach = 2.0 * math.sqrt(0.5) - 1e-3
    features = set()
    for make in (box, cube):
        found = [
            touching(make((2.0, 0.5, 0.5), orientation=tilt), make((2.0, 0.5, 0.5), (0, 0, side), across))
            for side in (reach, -reach)
        ]
        assert [len(m) for m in found] == [1, 1]
        features.update(int(m.features[0]) for m in found)
    assert len(features) == 4


# --- degenerate input -------------------------------------------------------------------------------------------------

SIZES = some.sampled_from([1e-5, 1e-3, 0.1, 1.0, 1e3])
TURNS = some.sampled_from(
    [
        UP,
        LYING,
        (0.0, 1.0, 0.0, 0.0),
        (math.cos(1e-9), math.sin(1e-9), 0.0, 0.0),
        (0.5, 0.5, 0.5, 0.5),
        (0.8, 0, 0.6, 0),
    ]
)


@some.composite
def strange_shapes(draw: Any) -> Placed:
    """Needles, sheets and dust, in special poses."""
    kind = draw(some.sampled_from(KINDS))
    x, y, z = (draw(SIZES) for _ in range(3))
    position = draw(some.tuples(*[some.sampled_from([0.0, 0.5, 1.0, -1.0, x, 2.0 * y, 1e-12])] * 3))
    turn = draw(TURNS)
    if kind == "sphere":
        return sphere(x, position)
    if kind == "box":
        return box((x, y, z), position, turn)
    if kind == "capsule":
        return capsule(x, y, position, turn)
    if kind == "cylinder":
        return cylinder(x, y, position, turn)
    if kind == "ellipsoid":
        return ellipsoid((x, y, z), position, turn)
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), *draw(some.sampled_from([[(1, 1, 1)], []]))], float)
    return hull(points * (x, y, z), position, turn)


@given(strange_shapes(), strange_shapes(), some.sampled_from([0.0, 1e-3, 10.0]))
def test_strange_shapes_give_finite_contacts_or_none(a: Placed, b: Placed, margin: float) -> None:
    m = touching(a, b, margin)
    assert np.isfinite(m.points).all()
    assert np.isfinite(m.separations).all()
    np.testing.assert_allclose(np.linalg.norm(m.normals, axis=1), 1.0, atol=1e-6)
    assert len(m) <= 4


@every_pair
def test_shapes_with_one_centre_are_told_a_way_out(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """As short as any, within a factor of two."""
    for _ in range(10):
        a, b = (random_shape(rng, kind) for kind in kinds)
        m = touching(a, b, 0.0)
        best = best_separation(rng, a, b)
        if best > -0.02:
            continue  # a hull need not hold its origin
        assert along(a, b, m.normals[:1])[0] >= 2.0 * best


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1)])
def test_a_ball_in_the_middle_of_a_capsule_is_told_to_leave_across_it(axis: tuple[float, float, float]) -> None:
    world = st.World(solver="micro", gravity=(0, 0, 0))
    turn = {(1, 0, 0): (1, 0, 1, 0), (0, 1, 0): (1, 1, 0, 0), (0, 0, 1): (1, 0, 0, 0)}[axis]
    world.add(st.Capsule(0.3, 1.0), static=True, orientation=turn)
    world.add(st.Sphere(0.2))
    world.step()
    assert abs(world.contacts()["normal"][0] @ axis) < 1e-12


# --- at rest and rolling ----------------------------------------------------------------------------------------------

BODIES = {
    "capsule": st.Capsule(0.2, 0.5),
    "cylinder": st.Cylinder(0.2, 0.5),
    "coin": st.Cylinder(0.3, 0.05),
    "tetrahedron": st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]),
    "stone": st.ConvexHull(np.random.default_rng(5).normal(size=(20, 3)) * 0.3),
}


@pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")
@pytest.mark.parametrize("floor", ["plane", "box"])
@pytest.mark.parametrize("shape", BODIES.values(), ids=BODIES)
def test_a_dropped_body_comes_to_rest_and_does_not_sink(rng: np.random.Generator, shape: st.Shape, floor: str) -> None:
    world = st.World(solver="micro", dt=1 / 240)
    ground = (st.Plane(), (0, 0, 0)) if floor == "plane" else (st.Box((6, 6, 1)), (0, 0, -0.5))
    world.add(ground[0], static=True, position=ground[1])
    body = world.add(shape, position=(0, 0, 1.0), orientation=random_unit(rng, 4))
    start = sum(world.energy()[:2])
    for _ in range(48):
        world.step(30)
        energy = world.energy()
        assert energy.kinetic + energy.potential <= start + 1e-9
        contacts = world.contacts()
        assert len(contacts) == 0 or contacts["separation"].min() > -1e-3
    rolls = isinstance(shape, (st.Capsule, st.Cylinder))
    assert np.linalg.norm(body.velocity) < (0.5 if rolls else 1e-4)
    # a coin may still wobble, as Euler's disc does for minutes
    assert abs(body.velocity[2]) < (0.05 if shape is BODIES["coin"] else 1e-3)


@pytest.mark.parametrize("floor", ["plane", "box"])
def test_a_cylinder_that_rolls_keeps_its_speed(floor: str) -> None:
    world = st.World(solver="micro", dt=1 / 240)
    ground = (st.Plane(), (0, 0, 0)) if floor == "plane" else (st.Box((9, 3, 1)), (0, 0, -0.5))
    world.add(ground[0], static=True, position=ground[1])
    q = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
    body = world.add(
        st.Cylinder(0.2, 0.5), position=(-1, 0, 0.2), orientation=q, velocity=(1, 0, 0), angular_velocity=(0, 5, 0)
    )
    world.run(2.0)
    np.testing.assert_allclose(body.velocity, (1, 0, 0), atol=1e-4)
    np.testing.assert_allclose(body.position, (1, 0, 0.2), atol=1e-3)
