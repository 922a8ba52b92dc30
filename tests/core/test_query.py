"""Rays and regions against convex functions of the shapes, by sampling, and against projections onto the shapes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

import stiction as st
from stiction.core import state
from stiction.core.pairs import make_pair_cache, touch_body, update_pairs
from stiction.core.query import HIT_DISTANCE, HIT_NORMAL, HIT_WIDTH, cast_ray, overlap_box, overlap_sphere
from stiction.core.tree import make_tree
from stiction.hulls import HullTable

from .support import Array, compiled, matrix_of, random_unit, vec

SHAPES = [state.SPHERE, state.BOX, state.PLANE, state.CAPSULE, state.CYLINDER, state.HULL, state.ELLIPSOID]
NAMES = ["sphere", "box", "plane", "capsule", "cylinder", "hull", "ellipsoid"]


def ellipsoid_root(p: Array, s: Array) -> Array:
    """(k,) t with which p / (1 + t / s^2) is the point of the surface that is nearest to p (k, 3), by bisection."""
    low, high = np.full(len(p), -(s.min() ** 2)), np.linalg.norm(p, axis=1) * s.max()
    for _ in range(100):
        t = 0.5 * (low + high)
        outside = np.sum((s * p / (t[:, None] + s**2)) ** 2, axis=1) > 1.0
        low, high = np.where(outside, t, low), np.where(outside, high, t)
    return np.asarray(high)


class Scene:
    """Bodies of every shape, the tree that holds them, and answers in plain numpy."""

    def __init__(self, rng: np.random.Generator, shapes: list[int], spread: float) -> None:
        n = len(shapes)
        self.bodies, self.kinds = state.make_bodies(n)
        self.kinds[:, state.LAYER], self.kinds[:, state.MASK] = 1, -1
        self.kinds[:, state.MOBILITY] = state.DYNAMIC
        self.table, self.points = HullTable(), {}
        self.tree, self.cache = make_tree(n), make_pair_cache(n, 64 * n, 1)
        for i, shape in enumerate(shapes):
            self.kinds[i, state.SHAPE] = shape
            self.bodies[i, state.POSITION : state.POSITION + 3] = rng.uniform(-spread, spread, size=3)
            self.bodies[i, state.ORIENTATION : state.ORIENTATION + 4] = random_unit(rng, 4)
            self.bodies[i, state.SIZE : state.SIZE + 4] = self.size(rng, i, shape)
            reach = 2.5 * np.ones(3)  # more than any shape's
            p = self.bodies[i, state.POSITION : state.POSITION + 3]
            self.bodies[i, state.BOUNDS : state.BOUNDS + 6] = *(p - reach), *(p + reach)
        self.refresh()

    def size(self, rng: np.random.Generator, i: int, shape: int) -> Any:
        """Random numbers for the columns of SIZE."""
        r, h = rng.uniform(0.2, 1.0, size=2)
        if shape == state.SPHERE:
            return r, 0, 0, 0
        if shape == state.PLANE:
            self.kinds[i, state.MOBILITY] = state.STATIC
            return *random_unit(rng), rng.normal() - 2.0
        if shape == state.CAPSULE:
            return r, r, h + r, 0
        if shape == state.CYLINDER:
            return r, r, h, 0
        if shape == state.HULL:
            hull = st.ConvexHull(rng.uniform(-1.0, 1.0, size=(12, 3)))
            self.points[i] = np.asarray(hull.points)
            return *np.abs(self.points[i]).max(axis=0), self.table.add(hull)
        return *rng.uniform(0.2, 1.0, size=3), 0

    def refresh(self) -> None:
        """All bodies into the tree, where they are now."""
        n = len(self.bodies)
        for i in range(n):
            compiled(touch_body)(self.cache, i)
        needed = compiled(update_pairs)(
            self.tree, self.cache, self.bodies, self.kinds, np.zeros(1, np.int64), 0, 1.0 / 60.0
        )
        assert needed <= len(self.cache.pairs)

    def axes(self, i: int) -> Array:
        return matrix_of(self.bodies[i, state.ORIENTATION : state.ORIENTATION + 4])

    def local(self, i: int, x: Array) -> Array:
        """Points (k, 3) in the axes of body i."""
        return np.asarray((x - self.bodies[i, state.POSITION : state.POSITION + 3]) @ self.axes(i))

    def depth(self, i: int, x: Array) -> Array:
        """(k,) a convex function of points (k, 3): negative inside body i, 0 on its surface, of slope 1."""
        p, s, shape = self.local(i, x), self.bodies[i, state.SIZE : state.SIZE + 4], self.kinds[i, state.SHAPE]
        if shape == state.SPHERE:
            return np.asarray(np.linalg.norm(p, axis=1) - s[0])
        if shape == state.PLANE:
            return np.asarray(p @ s[:3] - s[3])
        if shape == state.BOX:
            return np.asarray((np.abs(p) - s[:3]).max(axis=1))
        across = np.linalg.norm(p[:, :2], axis=1)
        if shape == state.CAPSULE:
            beyond = np.maximum(np.abs(p[:, 2]) - (s[2] - s[0]), 0.0)
            return np.asarray(np.hypot(across, beyond) - s[0])
        if shape == state.CYLINDER:
            return np.maximum(across - s[0], np.abs(p[:, 2]) - s[2])
        if shape == state.ELLIPSOID:
            t = ellipsoid_root(p, s[:3])
            away = p * t[:, None] / (t[:, None] + s[:3] ** 2)
            return np.asarray(np.sign(t) * np.linalg.norm(away, axis=1))
        arrays = self.table.arrays
        _, _, first, count, _, _ = arrays.spans[int(s[3])]
        planes = arrays.planes[first : first + count]
        return np.asarray((p @ planes[:, :3].T - planes[:, 3]).max(axis=1))

    def project(self, i: int, x: Array) -> Array:
        """The point of body i that is nearest to x (3,)."""
        p, s, shape = self.local(i, x[None])[0], self.bodies[i, state.SIZE : state.SIZE + 4], self.kinds[i, state.SHAPE]
        if shape == state.PLANE:
            q = p - max(p @ s[:3] - s[3], 0.0) * s[:3]
        elif shape == state.BOX:
            q = np.clip(p, -s[:3], s[:3])
        elif shape == state.CYLINDER:
            q = np.array([*p[:2] * min(1.0, s[0] / max(np.hypot(p[0], p[1]), 1e-300)), np.clip(p[2], -s[2], s[2])])
        elif shape == state.HULL:
            v = self.points[i]  # least squares over convex combinations; the weights' sum is enforced
            weights, _ = nnls(np.vstack([v.T, np.full(len(v), 1e4)]), np.append(p, 1e4))
            q = weights @ v
        elif shape == state.ELLIPSOID:
            q = p / (1.0 + max(0.0, ellipsoid_root(p[None], s[:3])[0]) / s[:3] ** 2)
        else:
            h = s[2] - s[0] if shape == state.CAPSULE else 0.0
            c = np.array([0.0, 0.0, np.clip(p[2], -h, h)])
            q = c + (p - c) * min(1.0, s[0] / max(np.linalg.norm(p - c), 1e-300))
        return np.asarray(self.bodies[i, state.POSITION : state.POSITION + 3] + self.axes(i) @ q)

    def cast(self, origin: Any, direction: Any, reach: float, room: int = 1, mask: int = -1) -> list[tuple[Any, ...]]:
        """(body, distance, normal (3,)) of every hit."""
        hits, found = np.full((room, HIT_WIDTH), np.nan), np.full(room, -7)
        count = compiled(cast_ray)(
            self.tree, self.cache, self.bodies, self.kinds, self.table.arrays,
            vec(origin), vec(direction), float(reach), mask, hits, found,
        )  # fmt: skip
        assert (found[count:] == -7).all()
        return [
            (int(i), float(row[HIT_DISTANCE]), row[HIT_NORMAL : HIT_NORMAL + 3])
            for i, row in zip(found[:count], hits[:count], strict=True)
        ]

    def overlap(self, question: Any, center: Any, size: Any, mask: int = -1, room: int = 64) -> list[int]:
        """Bodies in a region, sorted."""
        out, points = np.full(room, -7), np.zeros((state.SCRATCH, 5))
        count = compiled(question)(
            self.tree, self.cache, self.bodies, self.kinds, self.table.arrays, vec(center), size, mask, points, out
        )
        assert (out[count:] == -7).all()
        return sorted(out[:count].tolist())


@pytest.mark.parametrize("shape", SHAPES, ids=NAMES)
def test_a_ray_enters_where_the_shape_begins(rng: np.random.Generator, shape: int) -> None:
    """Samples before the hit are outside, the hit is on the surface, and the normal is its gradient."""
    hits = 0
    for k in range(60):
        scene = Scene(rng, [shape], 1.0)
        origin = rng.normal(size=3) * 3.0
        aim = scene.bodies[0, state.POSITION : state.POSITION + 3]  # within it, but for some hulls and planes
        if k % 3:
            aim = aim + 0.7 * rng.normal(size=3)
        d = (aim - origin) / np.linalg.norm(aim - origin)
        if rng.random() < 0.2:
            d = np.roll([0.0, 0.0, rng.choice([-1.0, 1.0])], rng.integers(3))
        t = np.linspace(0.0, 12.0, 4000)
        depth = scene.depth(0, origin + t[:, None] * d)
        found = scene.cast(origin, d, 12.0)
        if not found:
            assert (depth > 0.0).all()
            continue
        hits += 1
        body, distance, normal = found[0]
        point = origin + distance * d
        assert body == 0
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
        if depth[0] <= 0.0:
            assert distance == 0.0
            np.testing.assert_array_equal(normal, -d)
            continue
        assert (depth[t < distance - 1e-9] > 0.0).all()
        assert abs(scene.depth(0, point[None])[0]) < 1e-11
        assert normal @ d <= 1e-12
        assert scene.depth(0, (point + 1e-3 * normal)[None])[0] == pytest.approx(1e-3, abs=1e-9)
    assert hits > 8


@pytest.mark.parametrize("shape", SHAPES, ids=NAMES)
def test_a_ray_ends_at_its_reach(rng: np.random.Generator, shape: int) -> None:
    scene = Scene(rng, [shape], 1.0)
    target = scene.bodies[0, state.POSITION : state.POSITION + 3]
    if shape == state.HULL:  # of random points, which need not be all around its origin
        target = target + scene.axes(0) @ scene.points[0].mean(axis=0)
    if shape == state.PLANE:
        target = scene.project(0, target) - 0.1 * scene.axes(0) @ scene.bodies[0, state.SIZE : state.SIZE + 3]
    origin = target + 20.0 * random_unit(rng)
    if shape == state.PLANE:
        origin = target + 20.0 * scene.axes(0) @ scene.bodies[0, state.SIZE : state.SIZE + 3]
    d = (target - origin) / np.linalg.norm(target - origin)
    [(_, distance, _)] = scene.cast(origin, d, math.inf)
    assert scene.cast(origin, d, distance - 1e-9) == []
    assert len(scene.cast(origin, d, distance + 1e-9)) == 1
    assert scene.cast(origin, -d, math.inf) == []


def test_closed_forms() -> None:
    """A ray along x at the height 0.3 against shapes at the origin."""
    rng = np.random.default_rng(1)
    expected = {
        state.SPHERE: ((0.5, 0, 0, 0), 4.0 - math.sqrt(0.5**2 - 0.3**2), (-0.8, 0, 0.6)),
        state.BOX: ((0.5, 0.7, 0.4, 0), 3.5, (-1, 0, 0)),
        state.PLANE: ((-1, 0, 0, -0.25), 4.25, (-1, 0, 0)),
        state.CAPSULE: ((0.5, 0.5, 0.9, 0), 3.5, (-1, 0, 0)),
        state.ELLIPSOID: ((2.0, 0.7, 0.5, 0), 4.0 - 1.6, (-0.1 * math.sqrt(10), 0, 0.3 * math.sqrt(10))),
        state.CYLINDER: ((0.5, 0.5, 0.9, 0), 3.5, (-1, 0, 0)),
    }
    for shape, (size, distance, normal) in expected.items():
        scene = Scene(rng, [shape], 0.0)
        scene.bodies[0, state.SIZE : state.SIZE + 4] = size
        scene.bodies[0, state.ORIENTATION : state.ORIENTATION + 4] = (1, 0, 0, 0)
        scene.refresh()
        [(_, found, n)] = scene.cast((-4.0, 0, 0.3), (1, 0, 0), 10.0)
        assert found == pytest.approx(distance, abs=1e-14)
        np.testing.assert_allclose(n, normal, atol=1e-14)
    # along the axis of the cylinder, and past it
    [(_, found, n)] = scene.cast((0.3, 0.3, 5.0), (0, 0, -1), 10.0)
    assert found == pytest.approx(4.1)
    np.testing.assert_allclose(n, (0, 0, 1))
    assert scene.cast((0.4, 0.4, 5.0), (0, 0, -1), 10.0) == []


def test_a_ray_through_many_bodies_hits_those_that_each_alone_would_be(rng: np.random.Generator) -> None:
    """All hits, nearest first; with less room the nearest of them."""
    scene = Scene(rng, [s for s in SHAPES for _ in range(12)], 4.0)
    alone = [Scene(rng, [s], 0.0) for s in scene.kinds[:, state.SHAPE]]
    for i, one in enumerate(alone):
        one.bodies[0], one.table, one.points = scene.bodies[i], scene.table, {0: scene.points.get(i)}
        one.refresh()
    for _ in range(30):
        origin, d = rng.normal(size=3) * 5.0, random_unit(rng)
        expected = sorted((hit[1], i) for i, one in enumerate(alone) for hit in one.cast(origin, d, 20.0))
        found = scene.cast(origin, d, 20.0, room=100)
        assert [(t, i) for i, t, _ in found] == expected
        for room in (1, 3):
            assert [(t, i) for i, t, _ in scene.cast(origin, d, 20.0, room=room)] == expected[:room]


def test_masks_and_sensors(rng: np.random.Generator) -> None:
    scene = Scene(rng, [state.SPHERE] * 3, 0.0)
    scene.bodies[:, state.SIZE] = 0.5
    for i in range(3):
        scene.bodies[i, state.POSITION] = 3.0 * i
    scene.bodies[:, state.BOUNDS] += 3.0 * np.arange(3)
    scene.bodies[:, state.BOUNDS + 3] += 3.0 * np.arange(3)
    scene.kinds[:, state.LAYER] = 1, 2, 4
    scene.refresh()
    assert [hit[0] for hit in scene.cast((-3, 0, 0), (1, 0, 0), 99.0, room=9)] == [0, 1, 2]
    assert [hit[0] for hit in scene.cast((-3, 0, 0), (1, 0, 0), 99.0, room=9, mask=6)] == [1, 2]
    assert scene.overlap(overlap_sphere, (3, 0, 0), 9.0, mask=5) == [0, 2]
    scene.kinds[1, state.SENSOR] = 1
    assert [hit[0] for hit in scene.cast((-3, 0, 0), (1, 0, 0), 99.0, room=9)] == [0, 2]
    assert scene.overlap(overlap_box, (3, 0, 0), vec((9, 1, 1))) == [0, 2]


def test_balls_overlap_what_is_nearer_than_their_radius(rng: np.random.Generator) -> None:
    overlaps = 0
    for _ in range(20):
        scene = Scene(rng, SHAPES * 3, 2.0)
        center, radius = rng.normal(size=3), float(rng.uniform(0.05, 1.5))
        distance = np.array([np.linalg.norm(scene.project(i, center) - center) for i in range(len(scene.bodies))])
        assert np.abs(distance - radius).min() > 1e-7  # clear answers only
        expected = np.flatnonzero(distance < radius).tolist()
        overlaps += len(expected)
        assert scene.overlap(overlap_sphere, center, radius) == expected
    assert overlaps > 20


def test_boxes_overlap_what_comes_into_them(rng: np.random.Generator) -> None:
    """Alternating projections find a point of both, or a plane between: a shape lies beyond its nearest point."""
    overlaps, clear = 0, 0
    for _ in range(10):
        scene = Scene(rng, SHAPES * 2, 2.0)
        center, half = 0.7 * rng.normal(size=3), rng.uniform(0.1, 1.0, size=3)
        found = scene.overlap(overlap_box, center, vec(half))
        for i in range(len(scene.bodies)):
            x, apart = center.copy(), 0.0
            for _ in range(200):
                y = scene.project(i, x)
                gap = float(np.linalg.norm(x - y))
                if gap < 1e-9 or apart > 1e-6:
                    break
                apart = float((x - y) @ (center - y) - half @ np.abs(x - y)) / gap
                x = np.clip(y, center - half, center + half)
            if gap < 1e-9 or apart > 1e-6:
                clear += 1
                overlaps += gap < 1e-9
                assert (i in found) == (gap < 1e-9), (NAMES[int(scene.kinds[i, state.SHAPE])], gap)
    assert clear > 40
    assert overlaps > 5


def test_too_little_room_is_counted_and_not_written_over(rng: np.random.Generator) -> None:
    scene = Scene(rng, [state.BOX, state.PLANE] * 5, 0.5)
    out, points = np.full(6, -7), np.zeros((state.SCRATCH, 5))
    count = compiled(overlap_sphere)(
        scene.tree, scene.cache, scene.bodies, scene.kinds, scene.table.arrays, vec((0, 0, 0)), 9.0, -1, points, out[:4]
    )
    assert count == 10
    assert (out[4:] == -7).all()
    assert (out[:4] >= 0).all()


def test_an_empty_world_has_nothing_to_hit(rng: np.random.Generator) -> None:
    scene = Scene(rng, [state.SPHERE], 0.0)
    scene.tree, scene.cache = make_tree(1), make_pair_cache(1, 1, 1)
    assert scene.cast((0, 0, 0), (1, 0, 0), math.inf) == []
    assert scene.overlap(overlap_sphere, (0, 0, 0), 9.0) == []
