"""The pair cache against all bodies with all others, while they move, come, go and change."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiction.core import pairs as p
from stiction.core import state
from stiction.core.pairs import (
    PairCache,
    drop_slot,
    forget_body,
    give_slot,
    make_pair_cache,
    resize_pair_cache,
    touch_body,
    update_pairs,
)
from stiction.core.tree import NONE, Tree, check, grow_tree, make_tree

from .support import Array, compiled, matrix_of, random_unit

DT = 1.0 / 60.0


class Scene:
    """Some bodies, their tree and their pairs; bounds are boxes of the bodies' sizes at their positions."""

    def __init__(self, n: int, room: int = 4096) -> None:
        self.bodies, self.kinds = state.make_bodies(n)
        self.kinds[:, state.LAYER], self.kinds[:, state.MASK] = 1, -1
        self.tree, self.cache = make_tree(n), make_pair_cache(n, room, room)
        self.before: list[tuple[int, int]] = []
        self.live: set[int] = set()
        self.looked_at: dict[int, Any] = {}

    def add(self, i: int, position: Any, half: Any = (0.5, 0.5, 0.5), mobility: int = state.DYNAMIC) -> None:
        self.kinds[i, state.SHAPE], self.kinds[i, state.MOBILITY] = state.BOX, mobility
        self.bodies[i, state.POSITION : state.POSITION + 3] = position
        self.bodies[i, state.SIZE : state.SIZE + 3] = half
        self.bodies[i, state.V : state.W + 3] = 0.0
        self.live.add(i)
        compiled(touch_body)(self.cache, i)

    def add_plane(self, i: int, normal: Any, offset: float, mobility: int = state.STATIC) -> None:
        self.kinds[i, state.SHAPE], self.kinds[i, state.MOBILITY] = state.PLANE, mobility
        self.bodies[i, state.SIZE : state.SIZE + 4] = *normal, offset
        self.live.add(i)
        compiled(touch_body)(self.cache, i)

    def forget(self, i: int) -> list[tuple[int, int]]:
        self.live.discard(i)
        self.before = self.pairs
        count = compiled(forget_body)(self.tree, self.cache, i)
        assert self.cache.counts[p.ENDED] == count
        assert self.cache.counts[p.BEGUN] == 0
        return self.ended

    def set_bounds(self) -> None:
        position = self.bodies[:, state.POSITION : state.POSITION + 3]
        size = self.bodies[:, state.SIZE : state.SIZE + 3]
        self.bodies[:, state.BOUNDS : state.BOUNDS + 3] = position - size
        self.bodies[:, state.BOUNDS + 3 : state.BOUNDS + 6] = position + size

    def update(self, awake: Iterable[int] | None = None) -> int:
        """One update; without a list, everything that is no static body or plane is awake."""
        self.set_bounds()
        if awake is None:
            awake = [i for i in sorted(self.live) if self.kinds[i, state.MOBILITY] != state.STATIC]
        listed = np.array([*awake, -1], np.int64)
        self.before = self.pairs
        needed = compiled(update_pairs)(self.tree, self.cache, self.bodies, self.kinds, listed, len(listed) - 1, DT)
        return int(needed)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """All pairs."""
        return couples(self.cache.pairs, int(self.cache.counts[p.PAIRS]))

    @property
    def begun(self) -> list[tuple[int, int]]:
        """Those that are new."""
        return couples(self.cache.begun, int(self.cache.counts[p.BEGUN]))

    @property
    def ended(self) -> list[tuple[int, int]]:
        """Those that are gone."""
        return [self.before[k] for k in self.cache.ended[: self.cache.counts[p.ENDED]]]

    @property
    def slots(self) -> dict[tuple[int, int], int]:
        """The slots of the pairs that have one."""
        rows = self.cache.pairs[: self.cache.counts[p.PAIRS]]
        return {(int(a), int(b)): int(slot) for a, b, slot in rows[:, : p.DUE] if slot != NONE}

    def give_slots(self, rng: np.random.Generator, share: float = 0.3) -> None:
        """To some of the pairs that have none, after some have been taken back."""
        chosen = np.flatnonzero(rng.random(len(self.pairs)) < share)
        has = self.cache.pairs[chosen, p.SLOT] != NONE
        for k in chosen[has].tolist():
            compiled(drop_slot)(self.cache, k)
        for k in chosen[~has].tolist():
            compiled(give_slot)(self.cache, k)


def couples(array: Any, count: int) -> list[tuple[int, int]]:
    """The first rows as tuples."""
    return [(int(a), int(b)) for a, b in array[:count, : p.SLOT]]


def meet(scene: Scene, a: int, b: int) -> bool:
    """What :func:`stiction.core.pairs.may_meet` decides, in other words."""
    kinds = scene.kinds
    if not kinds[a, state.LAYER] & kinds[b, state.MASK] or not kinds[b, state.LAYER] & kinds[a, state.MASK]:
        return False
    if kinds[a, state.SENSOR] and kinds[b, state.SENSOR]:
        return False
    mobilities = {int(kinds[a, state.MOBILITY]), int(kinds[b, state.MOBILITY])}
    if state.DYNAMIC in mobilities:
        return True
    return any(kinds[i, state.SENSOR] and kinds[j, state.MOBILITY] != state.STATIC for i, j in ((a, b), (b, a)))


def near(scene: Scene, a: int, b: int) -> bool:
    """Whether two fat boxes overlap, or one reaches a plane at rest."""
    shapes = scene.kinds[[a, b], state.SHAPE]
    if (shapes == state.PLANE).all():
        return False
    if (shapes == state.PLANE).any():
        plane, other = (a, b) if shapes[0] == state.PLANE else (b, a)
        row, box = scene.bodies[plane], scene.tree.boxes[scene.tree.leaf[other]]
        n = matrix_of(row[state.ORIENTATION : state.ORIENTATION + 4]) @ row[state.SIZE : state.SIZE + 3]
        corners = np.array(list(itertools.product(*box.reshape(2, 3).T)))
        depth = (corners - row[state.POSITION : state.POSITION + 3]) @ n - row[state.SIZE + 3]
        return bool(depth.min() <= 0.0)
    x, y = scene.tree.boxes[scene.tree.leaf[[a, b]]]
    return bool((x[:3] <= y[3:]).all() and (y[:3] <= x[3:]).all())


def brute_force(scene: Scene) -> list[tuple[int, int]]:
    """All pairs that may meet and whose fat boxes overlap."""
    return [(a, b) for a, b in itertools.combinations(sorted(scene.live), 2) if meet(scene, a, b) and near(scene, a, b)]


def assert_consistent(scene: Scene, slots: dict[tuple[int, int], int]) -> None:
    """Sorted, slots unique and in range, kept by those that live on; begun and ended are the difference."""
    cache, before, after = scene.cache, scene.before, scene.pairs
    assert check(scene.tree)
    assert after == sorted(set(after))
    assert all(a < b for a, b in after)
    assert scene.begun == sorted(set(after) - set(before))
    assert scene.ended == sorted(set(before) - set(after))
    assert scene.slots == {pair: slot for pair, slot in slots.items() if pair in after}
    free = cache.free[: cache.counts[p.FREE]].tolist()
    assert sorted([*scene.slots.values(), *free]) == list(range(int(cache.counts[p.SLOTS])))
    new = cache.pairs[[after.index(pair) for pair in scene.begun], p.SLOT :]
    assert (new == [NONE, 0, 0, 0]).all()


def random_scene(rng: np.random.Generator, n: int, planes: int = 2, room: int = 4096) -> Scene:
    """Bodies of all mobilities in a cube, some on other layers, some sensors, and static planes."""
    scene, size = Scene(n, room), 0.5 * n ** (1 / 3)
    for i in range(n):
        if i < planes:
            scene.add_plane(i, random_unit(rng), rng.normal() - 1.0)
            scene.bodies[i, state.ORIENTATION : state.ORIENTATION + 4] = random_unit(rng, 4)
            scene.bodies[i, state.POSITION : state.POSITION + 3] = rng.normal(size=3)
            continue
        mobility = int(rng.choice([state.STATIC, state.KINEMATIC, state.DYNAMIC], p=[0.2, 0.2, 0.6]))
        scene.add(i, rng.uniform(-size, size, size=3), rng.uniform(0.1, 0.5, size=3), mobility)
        scene.kinds[i, state.LAYER] = rng.choice([1, 1, 1, 2])
        scene.kinds[i, state.MASK] = rng.choice([-1, -1, 1])
        scene.kinds[i, state.SENSOR] = rng.random() < 0.2
    return scene


def drift(scene: Scene, rng: np.random.Generator, speed: float) -> None:
    """Move all that can move along new velocities."""
    moving = (scene.kinds[:, state.MOBILITY] != state.STATIC) & (scene.kinds[:, state.SHAPE] != state.PLANE)
    v = speed * rng.normal(size=(len(moving), 3)) * moving[:, None]
    scene.bodies[:, state.V : state.V + 3] = v
    scene.bodies[:, state.POSITION : state.POSITION + 3] += DT * v


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 50))
def test_the_pairs_are_those_of_all_against_all(seed: int, n: int) -> None:
    """Through slow and fast motion, with bodies that come, go, jump and change their layer."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, n, planes=min(n // 3, 2))
    for step in range(25):
        scene.give_slots(rng)
        before = scene.slots
        assert scene.update() == len(scene.pairs)
        assert_consistent(scene, before)
        assert scene.pairs == brute_force(scene)
        drift(scene, rng, 100.0 if step % 7 == 6 else 2.0)
        i = int(rng.integers(n))
        if scene.kinds[i, state.SHAPE] == state.PLANE:
            if rng.random() < 0.3:
                scene.bodies[i, state.SIZE + 3] += 0.3
                compiled(touch_body)(scene.cache, i)
        elif i not in scene.live:
            scene.add(i, rng.normal(size=3))
        elif rng.random() < 0.3:
            held = [(a, b) for a, b in scene.pairs if i in (a, b)]
            assert scene.forget(i) == held
            assert not any(i in (a, b) for a, b in scene.pairs)
            assert check(scene.tree)
        elif rng.random() < 0.3:
            scene.kinds[i, state.MASK] = rng.choice([-1, 0])
            compiled(touch_body)(scene.cache, i)
            compiled(touch_body)(scene.cache, i)  # twice does no harm


def test_nothing_moves_and_nothing_changes(rng: np.random.Generator) -> None:
    scene = random_scene(rng, 60)
    scene.update()
    held, boxes = scene.pairs, scene.tree.boxes.copy()
    scene.bodies[:, state.POSITION] += 1e-4
    scene.update()
    assert scene.pairs == held
    assert scene.cache.counts[p.BEGUN] == scene.cache.counts[p.ENDED] == 0
    np.testing.assert_array_equal(scene.tree.boxes, boxes)


def test_bodies_that_are_not_awake_are_not_looked_at() -> None:
    scene = Scene(3)
    scene.add(0, (0, 0, 0))
    scene.add(1, (5, 0, 0))
    scene.add(2, (9, 0, 0))
    assert scene.update() == 0
    scene.bodies[1, state.POSITION] = 0.9
    assert scene.update(awake=[0, 2]) == 0
    compiled(touch_body)(scene.cache, 1)
    assert scene.update(awake=[0, 2]) == 1
    scene.bodies[1, state.POSITION] = 5.0
    assert scene.update(awake=[1]) == 0


def test_the_box_is_fat_and_reaches_ahead() -> None:
    scene = Scene(1)
    scene.add(0, (0, 0, 0), half=(0.5, 0.1, 0.1))
    scene.bodies[0, state.V : state.V + 3] = (6.0, 0.0, -3.0)
    scene.update()
    grow, way = p.FAT * 1.0, p.AHEAD * DT * np.array([6.0, 0.0, -3.0])
    low = np.array([-0.5, -0.1, -0.1]) - grow + np.minimum(way, 0.0)
    high = np.array([0.5, 0.1, 0.1]) + grow + np.maximum(way, 0.0)
    np.testing.assert_allclose(scene.tree.boxes[scene.tree.leaf[0]], [*low, *high], rtol=1e-14)


def test_a_body_that_was_fast_gets_a_smaller_box_when_it_has_slowed() -> None:
    scene = Scene(2)
    scene.add(0, (0, 0, 0))
    scene.add(1, (8, 0, 0), mobility=state.STATIC)
    scene.bodies[0, state.V] = 200.0
    assert scene.update() == 1
    scene.bodies[0, state.V] = 150.0
    assert scene.update() == 1
    scene.bodies[0, state.V] = 0.0
    assert scene.update() == 0


@pytest.mark.parametrize("room", [1, 5, 40])
def test_too_little_room_changes_nothing_and_more_room_gives_the_same(rng: np.random.Generator, room: int) -> None:
    seed = int(rng.integers(2**32))
    ample = random_scene(np.random.default_rng(seed), 60)
    tight = random_scene(np.random.default_rng(seed), 60, room=room)
    for step in range(10):
        wanted = ample.update()
        before = tight.pairs
        needed = tight.update()
        while needed > len(tight.cache.pairs):
            assert tight.pairs == before
            assert tight.cache.counts[p.BEGUN] == tight.cache.counts[p.ENDED] == 0
            tight.cache = resize_pair_cache(tight.cache, 60, needed, needed)
            needed = tight.update()
        assert needed == wanted
        assert tight.pairs == ample.pairs
        assert tight.begun == ample.begun
        assert tight.ended == ample.ended
        for scene in (ample, tight):
            drift(scene, np.random.default_rng(seed + step), 30.0)


def test_a_body_may_go_while_there_is_too_little_room() -> None:
    scene = Scene(3, room=1)
    for i in range(3):
        scene.add(i, (0.1 * i, 0, 0))
    assert scene.update() == 3
    assert scene.forget(1) == []
    assert scene.update() == 1
    assert scene.pairs == [(0, 2)]


def test_bodies_are_added_to_grown_arrays(rng: np.random.Generator) -> None:
    small, large = Scene(2), Scene(3)
    for scene in (small, large):
        scene.add(0, (0, 0, 0))
        scene.add(1, (0.9, 0, 0))
        scene.update()
    small.tree, small.cache = grow_tree(small.tree, 3), resize_pair_cache(small.cache, 3, 4096, 4096)
    small.bodies, small.kinds = large.bodies.copy(), large.kinds.copy()
    for scene in (small, large):
        scene.add(2, (0, 0.9, 0))
        assert scene.update() == 3
    assert small.pairs == large.pairs == [(0, 1), (0, 2), (1, 2)]


def run_with(rng: np.random.Generator, far: bool, n: int = 40) -> list[Any]:
    """Pairs and changes of a world that moves, with or without another body far away that moves too."""
    scene = random_scene(rng, n)
    wide = Scene(n + 1)
    wide.bodies[:n], wide.kinds[:n] = scene.bodies, scene.kinds
    for i in range(n):
        wide.live.add(i)
        compiled(touch_body)(wide.cache, i)
    if far:
        wide.add(n, (1e4, 0, 0), mobility=state.KINEMATIC)
    history = []
    for _ in range(20):
        wide.update()
        changes = [wide.begun, wide.ended]
        history.append((wide.pairs, changes))
        drift(wide, rng, 20.0)
    return history


def test_a_body_far_away_changes_nothing() -> None:
    assert run_with(np.random.default_rng(5), far=False) == run_with(np.random.default_rng(5), far=True)


def test_the_order_in_which_bodies_are_listed_changes_nothing(rng: np.random.Generator) -> None:
    """The tree gets another shape, the pairs stay the same."""
    seed = int(rng.integers(2**32))
    one, other = (random_scene(np.random.default_rng(seed), 50) for _ in range(2))
    for step in range(10):
        one.update()
        awake = [i for i in range(50) if other.kinds[i, state.MOBILITY] != state.STATIC]
        other.update(awake=rng.permutation(awake))
        assert one.pairs == other.pairs
        for scene in (one, other):
            drift(scene, np.random.default_rng(seed + step), 20.0)


def test_a_plane_that_moves_meets_bodies_and_lets_them_go() -> None:
    """Up past a body and down again; at rest it keeps only what its half space reaches."""
    scene = Scene(3)
    scene.add_plane(0, (0, 0, 1), 0.0, mobility=state.KINEMATIC)
    scene.add(1, (0, 0, 2.0))
    scene.add(2, (0, 0, 50.0))
    assert scene.update() == 0
    scene.bodies[0, state.V + 2] = 0.6
    for step in range(200):
        scene.bodies[0, state.POSITION + 2] += DT * scene.bodies[0, state.V + 2]
        scene.update()
        reached = scene.bodies[0, state.POSITION + 2] >= 1.5 - p.FAT
        assert reached <= ((0, 1) in scene.pairs), step
        assert (0, 2) not in scene.pairs
    assert (0, 1) in scene.pairs
    scene.bodies[0, state.POSITION + 2] = 0.0
    scene.bodies[0, state.V + 2] = 0.0
    assert scene.update() == 0  # it came to rest far from where it was
    scene.bodies[0, state.W] = 60.0  # turning so fast that within the steps ahead it can be anywhere
    assert scene.update() == 2


def test_a_turned_plane_has_its_normal_turned() -> None:
    scene = Scene(2)
    scene.add_plane(0, (0, 0, 1), 1.0)
    half = np.sqrt(0.5)
    scene.bodies[0, state.ORIENTATION : state.ORIENTATION + 4] = (half, 0, half, 0)  # z becomes x
    scene.bodies[0, state.POSITION : state.POSITION + 3] = (2.0, 7.0, 7.0)
    scene.add(1, (3.49, 0, 0))
    assert scene.update() == 1
    scene.bodies[1, state.POSITION] = 3.7
    assert scene.update() == 0


def test_bounds_that_are_not_numbers_leave_the_tree_alone() -> None:
    scene = Scene(2)
    scene.add(0, (0, 0, 0))
    scene.add(1, (0.5, 0, 0))
    scene.update()
    scene.bodies[1, state.POSITION] = np.nan
    assert scene.update() == 1
    assert check(scene.tree)
    assert np.isfinite(scene.tree.boxes).all()


def test_removed_bodies_leave_the_lists(rng: np.random.Generator) -> None:
    """A plane too; and a row that is used again starts afresh."""
    scene = Scene(4)
    scene.add_plane(0, (0, 0, 1), 0.0)
    for i in range(1, 4):
        scene.add(i, (3.0 * i, 0, 0))
    assert scene.update() == 3
    assert scene.forget(0) == [(0, 1), (0, 2), (0, 3)]
    assert scene.cache.counts[p.PLANES] == 0
    assert scene.tree.leaf[0] == NONE
    scene.add(0, (3.0, 0.5, 0))
    assert scene.update() == 1
    assert scene.pairs == [(0, 1)]


def test_the_types_of_what_is_made() -> None:
    tree, cache = make_tree(3), make_pair_cache(3, 7, 4)
    assert isinstance(tree, Tree)
    assert isinstance(cache, PairCache)
    assert cache.pairs.shape == (7, p.PAIR_WIDTH)
    assert (len(cache.begun), len(cache.ended), len(cache.free)) == (7, 7, 4)
    assert cache.lists.shape == (p.LISTS_WIDTH, 3)


def test_slots_that_were_freed_are_used_again(rng: np.random.Generator) -> None:
    scene = random_scene(rng, 60, planes=0)
    most = 0
    for _ in range(50):
        scene.update()
        for share in (0.3, 0.3):
            scene.give_slots(rng, share)
            most = max(most, len(scene.slots))
        drift(scene, rng, 60.0)
    assert scene.cache.counts[p.SLOTS] <= most
    array: Array = scene.bodies
    assert np.isfinite(array).all()


@pytest.mark.parametrize("n", [0, 1, 2, 5, 14, 1000, 5000])
def test_pairs_are_sorted_by_both_columns(rng: np.random.Generator, n: int) -> None:
    unsorted = np.full((n + 2, p.PAIR_WIDTH), -7)
    unsorted[:n] = rng.integers(30 + n // 4, size=(n, p.PAIR_WIDTH))
    result = unsorted.copy()
    compiled(p._sort)(result, n)
    expected = unsorted[:n][np.lexsort((unsorted[:n, p.PAIR_B], unsorted[:n, p.PAIR_A]))]
    np.testing.assert_array_equal(result[:n, :2], expected[:, :2])
    np.testing.assert_array_equal(result[n:], unsorted[n:])
