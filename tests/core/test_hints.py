"""Contacts that are looked for from a direction known before are those that are found without it."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numba
import numpy as np
import pytest

from stiction.core import state
from stiction.core.collide.hulls import convex_of, depth_in
from stiction.core.collide.manifold import LASTS, TURNED
from stiction.core.collide.narrow import pair_contacts
from stiction.core.vec import Vec3

from .support import Array, Placed, box, matrix_of, product, random_unit, rows_of
from .test_collide_shapes import (
    HULLS,
    KINDS,
    TABLE,
    along,
    best_separation,
    cube,
    hull,
    least_width,
    random_pair,
    random_shape,
)

PAIRS = [(a, b) for k, a in enumerate(KINDS) for b in KINDS[k:]]
every_pair = pytest.mark.parametrize("kinds", PAIRS, ids=" and ".join)


@numba.njit(error_model="numpy")
def _look(bodies: Any, kinds: Any, margin: Any, hint: Any, contacts: Any, tags: Any, points: Any, hulls: Any) -> Any:
    n = Vec3(hint[0], hint[1], hint[2])
    return pair_contacts(bodies, kinds, 0, 1, margin, n, contacts, tags, 0, points, 1, hulls)


def look(a: Placed, b: Placed, margin: float, hint: Any = (0.0, 0.0, 0.0)) -> tuple[Array, Array, float]:
    """Rows of contacts, the direction to begin with the next time, and a lower bound of the separation if none."""
    bodies, kinds = rows_of(a, b)
    kinds[:, state.MOBILITY] = state.DYNAMIC
    contacts, tags = state.make_contacts(8)
    points = np.full((state.SCRATCH, 5), math.nan)
    found, toward, gap = _look(bodies, kinds, margin, np.array(hint, float), contacts, tags, points, TABLE.arrays)
    return contacts[:found], np.array(toward), float(gap)


def turned(rng: np.random.Generator, n: Array, angle: float) -> Array:
    """n after a rotation by an angle (rad) about a random axis."""
    return np.asarray(matrix_of(np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * random_unit(rng))])) @ n)


def find_with_hints(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """Hints as those of bodies that have turned by up to half a radian, and sometimes of nowhere."""
    margin = 0.02
    for gap in (-0.05, -0.01, -1e-3, -1e-5, 1e-5, 1e-3, 0.01, 0.04):
        for _ in range(12):
            a, b = random_pair(rng, kinds, gap)
            plain, toward, _ = look(a, b, margin)
            n = plain[0, state.NORMAL : state.NORMAL + 3] if len(plain) else toward
            for angle in (0.0, 1e-3, 0.05, 0.5):
                hint = turned(rng, n if n.any() else random_unit(rng), angle)
                hinted, other, far = look(a, b, margin, 3.0 * hint)
                slack = 0.012 * least_width(a, b) + 1e-6
                if not len(hinted):
                    assert far > margin
                    # the bound holds: no direction may be seen beyond the true distance
                    assert not len(plain) or plain[:, state.SEPARATION].min() > margin - 1e-5
                    assert not other.any() or far <= along(a, b, other[None])[0] + 1e-9
                    continue
                assert len(plain) or hinted[:, state.SEPARATION].min() > margin - 1e-3
                if not len(plain):
                    continue
                normals = [rows[:1, state.NORMAL : state.NORMAL + 3] for rows in (plain, hinted)]
                one, two = (float(along(a, b, normal)[0]) for normal in normals)
                if normals[1][0] @ hint > 1.0 - TURNED:  # a face that is kept though another way is a little better
                    slack += LASTS * max(-two, 0.0)
                assert two >= one - slack, (kinds, gap, angle, one, two)
                depths = [rows[:, state.SEPARATION].min() for rows in (plain, hinted)]
                assert depths[1] <= depths[0] + slack, (kinds, gap, angle, depths)
                assert depths[1] >= depths[0] - slack, (kinds, gap, angle, depths)


@every_pair
def test_a_hint_loses_no_contact_and_finds_as_good_a_normal(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    find_with_hints(rng, kinds)


@pytest.mark.parametrize(
    ("seed", "kinds"),
    [(748340348, ("box", "hull")), (3134012665, ("cylinder", "hull")), (14, ("hull", "hull"))],
    ids=["face", "climb", "kept"],
)
def test_hints_that_led_astray(seed: int, kinds: tuple[str, str]) -> None:
    """To a face beside whose border two edges are less deep; to a climb that began at the best face alone; and to a
    face that is kept though two edges are 5 mm of 5 cm less deep."""
    find_with_hints(np.random.default_rng(seed), kinds)


@every_pair
def test_the_separation_of_what_is_apart_is_a_lower_bound(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """And the direction that comes with it is one to begin with: it shows at once that there is nothing."""
    for _ in range(10):
        a, b = random_pair(rng, kinds, float(rng.uniform(0.03, 0.5)))
        best = best_separation(rng, a, b)
        for hint in (np.zeros(3), random_unit(rng)):
            found, toward, far = look(a, b, 0.01, hint)
            assert not len(found)
            assert 0.01 < far < best + 1e-3
            if toward.any():
                again = look(a, b, 0.01, toward)
                assert not len(again[0])
                assert again[2] >= far - 1e-9


@every_pair
def test_what_overlaps_has_a_point_as_deep_as_it_is(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """Also where points are looked for far ahead: those over the best face may all be far from it, while what overlaps
    lies beside it."""
    seen = 0
    for _ in range(60):
        a, b = random_pair(rng, kinds, -float(rng.uniform(1e-4, 0.02)))
        rows, _, _ = look(a, b, 0.1)
        if not len(rows):  # one is so thin that it cannot be as deep
            continue
        deep = float(along(a, b, rows[:1, state.NORMAL : state.NORMAL + 3])[0])
        assert rows[:, state.SEPARATION].min() <= deep + 0.012 * least_width(a, b) + 1e-6, kinds
        seen += 1
    assert seen > 20


def leaning_bar(lean: float, depth: float, as_hull: bool) -> tuple[Placed, Placed]:
    """A cube, and a bar that lies on it with one of its edges, ``depth`` (m) below the edge of the cube across which it
    hangs over by 10 cm and leans down by an angle (rad)."""
    sizes = (0.5, 0.5, 0.5), (0.1, 0.3, 0.1)
    on_edge, tipped = (np.array([math.cos(0.5 * t), *(math.sin(0.5 * t) * np.array(axis))]) for t, axis in (
        (0.25 * math.pi, (0.0, 1.0, 0.0)), (-lean, (1.0, 0.0, 0.0))
    ))  # fmt: skip
    height = 0.5 - depth + 0.1 * math.sqrt(2.0) * math.cos(lean) + 0.2 * math.sin(lean)
    place, turn = (0.0, 0.3, height), tuple(product(tipped, on_edge))
    shape = cube if as_hull else box
    return shape(sizes[0]), shape(sizes[1], place, turn)


@pytest.mark.parametrize("as_hull", [False, True], ids=["boxes", "hulls"])
def test_the_face_along_which_deep_contact_was_found_is_kept(as_hull: bool) -> None:
    """Where the crossing edges are a little less deep: contact would jump between them and the face with every turn."""

    def found(lean: float, depth: float, hint: Any = (0.0, 0.0, 0.0)) -> tuple[int, float]:
        """How many points, and how far their normal leans (rad)."""
        rows, _, _ = look(*leaning_bar(lean, depth, as_hull), 0.02, hint)
        n = rows[0, state.NORMAL : state.NORMAL + 3]
        return len(rows), math.atan2(math.hypot(n[0], n[1]), n[2])

    up = (0.0, 0.0, 1.0)
    assert found(0.003, 0.01) == found(0.003, 0.01, up) == (2, 0.0)
    assert found(0.01, 0.01) == pytest.approx((1, 0.01))
    assert found(0.01, 0.01, up) == (2, 0.0)
    # clearly better; hardly deep; found along the edges before
    assert found(0.03, 0.01, up) == pytest.approx((1, 0.03))
    assert found(0.01, 0.001, up) == pytest.approx((1, 0.01))
    assert found(0.01, 0.01, (0.0, math.sin(0.01), math.cos(0.01))) == pytest.approx((1, 0.01))


def test_points_over_a_face_are_none_where_what_overlaps_lies_beside_it() -> None:
    """A stone that a box meets at the edge of its face: 2 mm deep there, and 9 mm off where it is over the face."""
    stone = hull(
        [
            (-0.06, -0.021, -0.146), (-0.078, 0.126, -0.005), (0.035, -0.051, 0.174), (0.166, -0.126, 0.138),
            (0.043, 0.134, -0.112), (-0.073, 0.083, -0.096), (-0.036, 0.08, -0.126), (-0.057, 0.008, -0.143),
            (-0.037, -0.095, -0.153), (-0.113, 0.071, 0.037), (-0.044, 0.022, 0.143), (-0.051, -0.036, 0.147),
        ],
        (0.0, 0.0, 0.0),
        (-0.22404, -0.44982, -0.01007, 0.8645),
    )  # fmt: skip
    block = box((0.21425, 0.19297, 0.12201), (0.15686, 0.1923, 0.13125), (-0.7127, 0.59236, -0.24026, 0.28887))
    for margin in (1e-3, 0.02, 0.05):
        rows, _, _ = look(stone, block, margin)
        assert rows[:, state.SEPARATION].min() == pytest.approx(-0.0019, abs=5e-4)


@numba.njit(error_model="numpy")
def _depth_in(bodies: Any, kinds: Any, p: Any, hulls: Any) -> float:
    X = convex_of(bodies, kinds, 0, Vec3(0.0, 0.0, 0.0), hulls)
    return depth_in(X, hulls, Vec3(p[0], p[1], p[2]))


def border_of(placed: Placed) -> Array:
    """Planes (k, 4) of the convex hull of a shape's corners; the rim of a cylinder has 256."""
    from scipy.spatial import ConvexHull

    if placed.shape == state.HULL:
        corners = HULLS[int(placed.size[3])]
    elif placed.shape == state.CYLINDER:
        angles = np.arange(256) * 2.0 * math.pi / 256
        rim = placed.size[0] * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(256)])
        corners = np.vstack([rim + np.array([0.0, 0.0, z]) for z in (-placed.size[2], placed.size[2])])
    else:
        corners = np.array(list(itertools.product(*((-h, h) for h in placed.size[:3]))))
    return np.asarray(ConvexHull(corners @ placed.axes.T + placed.position).equations)


@pytest.mark.parametrize("kind", ["box", "cylinder", "hull"])
def test_a_point_is_as_deep_as_it_is_far_from_the_nearest_border(rng: np.random.Generator, kind: str) -> None:
    for _ in range(50):
        a = random_shape(rng, kind)
        bodies, kinds = rows_of(a)
        p, planes = 0.2 * rng.normal(size=3), border_of(a)
        deep = -float((planes[:, :3] @ p + planes[:, 3]).max())
        assert _depth_in(bodies, kinds, p, TABLE.arrays) == pytest.approx(deep, abs=2e-4)
