"""Manifolds that are taken along are where the narrow phase would find them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core import state
from stiction.core.collide.manifold import forget_face
from stiction.core.collide.narrow import pair_contacts
from stiction.core.going_on import is_kept, rolls_on
from stiction.core.manifolds import clear_manifold, take_points
from stiction.core.vec import Vec3

from .support import Array, Placed, box, compiled, matrix_of, product, random_unit, rows_of
from .test_collide_shapes import KINDS, TABLE, along, least_width, random_pair

FAR = 0.02
"""m, how far ahead points are looked for."""
CHEAP = {frozenset({"sphere", other}) for other in ("sphere", "box", "capsule", "cylinder")} | {frozenset({"capsule"})}
"""Pairs that are looked for anew in every step: that costs as little."""
SHAPES = tuple(kind for kind in KINDS if kind != "ellipsoid")
PAIRS = [(a, b) for k, a in enumerate(SHAPES) for b in SHAPES[k:] if frozenset({a, b}) not in CHEAP]
every_pair = pytest.mark.parametrize("kinds", PAIRS, ids=" and ".join)


class Pair:
    """Two bodies and the one manifold that they have, if any."""

    def __init__(self, a: Placed, b: Placed) -> None:
        self.placed = [a, b]
        self.soft = s.make_soft(2, 1)
        compiled(clear_manifold)(self.soft.manifolds, self.soft.meta, self.soft.reports, 1)
        self.scratch = np.full((state.SCRATCH, 5), math.nan)
        self.table = np.ones((1, 1, 8))
        self._place()

    def _place(self) -> None:
        self.bodies, self.kinds = rows_of(*self.placed)
        self.kinds[:, state.MOBILITY] = state.DYNAMIC
        pose = self.soft.pose
        for i, one in enumerate(self.placed):
            pose[i + 1, s.POSE_X : s.POSE_X + 3] = one.position
            pose[i + 1, s.POSE_ROTATION : s.POSE_ROTATION + 9] = one.axes.ravel()
            pose[i + 1, s.POSE_REACH] = np.linalg.norm(one.size[:3])

    def search(self, hint: Any = (0.0, 0.0, 0.0)) -> tuple[Array, Any]:
        """Contact points from nothing but the poses and a direction to begin with."""
        contacts, tags = state.make_contacts(8)
        compiled(forget_face)(self.scratch)
        n = Vec3(*(float(c) for c in hint))
        found, _, _ = compiled(pair_contacts)(
            self.bodies, self.kinds, 0, 1, FAR, n, contacts, tags, 0, self.scratch, 1, TABLE.arrays
        )
        return contacts[:found], tags

    def take(self) -> int:
        """Make the manifold from a search; returns its number of points."""
        contacts, tags = self.search()
        if len(contacts):
            compiled(take_points)(
                self.bodies, self.kinds, 0, 1, self.soft, 1, contacts, tags, len(contacts), self.scratch, self.table,
                0.01,
            )  # fmt: skip
        return len(contacts)

    def move(self, i: int, shift: Array, turn: Array, motion: float) -> None:
        """Move body i by a shift and a small rotation vector."""
        q = np.array([1.0, *(0.5 * turn)])
        one = self.placed[i]
        self.placed[i] = replace(
            one,
            position=np.asarray(one.position) + shift,
            orientation=product(q / np.linalg.norm(q), one.orientation),
        )
        self._place()
        self.soft.pose[i + 1, s.POSE_MOTION] += motion

    def go_on(self) -> bool:
        """Take the manifold along."""
        soft = self.soft
        rolled: bool = compiled(rolls_on)(
            self.kinds, 0, 1, soft.pose, soft.manifolds, soft.meta, soft.corners, 1, FAR
        )  # fmt: skip
        return rolled

    @property
    def normal(self) -> Array:
        """In the world."""
        return self.placed[0].axes @ self.soft.manifolds[1, s.NORMAL_A : s.NORMAL_A + 3].astype(float)

    @property
    def anchors(self) -> tuple[Array, Array]:
        """Of either body, in the world."""
        meta = self.soft.meta[1]
        a, b = self.placed
        return (
            np.asarray(a.position) + a.axes @ meta[s.ANCHOR_A : s.ANCHOR_A + 3],
            np.asarray(b.position) + b.axes @ meta[s.ANCHOR_B : s.ANCHOR_B + 3],
        )


def wander(rng: np.random.Generator, pair: Pair, way: float) -> None:
    """Move both bodies by so much, hardly towards each other."""
    for i in range(2):
        shift = way * random_unit(rng)
        shift -= 0.99 * pair.normal * (pair.normal @ shift)
        pair.move(i, shift, way * random_unit(rng), 2.0 * way)


@every_pair
def test_what_is_taken_along_is_what_would_be_found(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """Bodies of half a metre that move by 0.2 mm and 0.2 mrad a step, each a way of its own."""
    angles, gaps = [], []
    for gap in (-1e-3, -1e-5, 1e-5, 1e-3):
        for _ in range(15):
            pair = Pair(*random_pair(rng, kinds, gap))
            points = pair.take()
            if not 1 <= points <= 2:
                continue
            for _ in range(12):
                wander(rng, pair, 2e-4)
                if not pair.go_on():
                    break
                contacts, _ = pair.search(pair.normal)
                if len(contacts) != points:
                    break
                n = contacts[0, state.NORMAL : state.NORMAL + 3]
                kept = pair.soft.manifolds[1, s.GAP : s.GAP + points]
                angles.append(float(np.linalg.norm(np.cross(n, pair.normal))))
                if angles[-1] > 2e-4:
                    # a search may choose a face that is as good as the edges, but for a part of its preference
                    found, taken = along(*pair.placed, np.array([n, pair.normal]))
                    assert abs(found - taken) < 0.012 * least_width(*pair.placed)
                gaps.append(abs(float(contacts[:, state.SEPARATION].min() - kept.min())))
                assert np.allclose(*pair.anchors, atol=1e-12)
    assert len(gaps) > 200
    assert np.quantile(angles, 0.97) < 2e-4
    assert np.quantile(gaps, 0.97) < 1e-6 and max(gaps) < 1e-3


@every_pair
def test_what_was_looked_for_once_lasts_for_a_lead(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
    """And no longer than its bodies may go; an edited body, or one that has turned a corner, is looked for at once."""
    lasted = 0
    for _ in range(12):
        pair = Pair(*random_pair(rng, kinds, 1e-4))
        if not 1 <= pair.take() <= 2:
            continue
        lead, steps = float(pair.soft.meta[1, s.LEAD]), 0
        assert lead > 0.0
        while steps < 200:
            before = pair.soft.meta.copy()
            wander(rng, pair, 1e-4)
            if not pair.go_on():
                assert (pair.soft.meta == before).all()
                break
            steps += 1
            assert pair.soft.meta[1, s.LEAD] < before[1, s.LEAD]
        lasted += steps
        assert steps < 200
        pair.take()
        pair.move(0, np.zeros(3), np.zeros(3), 1.0)
        assert not pair.go_on()
    assert lasted > 12


def box_on_box(rng: np.random.Generator) -> Pair:
    """A face of four points, anywhere."""
    q, shift = random_unit(rng, 4), 10.0 * random_unit(rng)
    pair = Pair(box((0.5, 0.4, 0.3)).moved(shift, q), box((0.2, 0.3, 0.1), (0.1, 0.0, 0.4001)).moved(shift, q))
    assert pair.take() == 4
    return pair


def keeps(pair: Pair) -> bool:
    """Whether the face is kept as it is."""
    soft = pair.soft
    kept: bool = compiled(is_kept)(pair.kinds, 0, 1, soft.pose, soft.manifolds, soft.meta, 1)
    return kept


def test_a_face_is_kept_while_its_bodies_move_together(rng: np.random.Generator) -> None:
    """Half a metre to and fro in steps of 10 mm, turning by a tenth of a radian on the way."""
    pair = box_on_box(rng)
    x = np.asarray(pair.placed[0].position)
    for _ in range(40):
        shift, turn = 0.01 * random_unit(rng), 0.01 * random_unit(rng)
        q = np.array([1.0, *(0.5 * turn)])
        R = matrix_of(q / np.linalg.norm(q))
        for i in range(2):
            d = np.asarray(pair.placed[i].position) - x
            pair.move(i, shift + R @ d - d, turn, 0.01)
        x = x + shift
        assert keeps(pair)
    pair.move(0, np.zeros(3), np.zeros(3), 1.0)
    assert not keeps(pair)


@pytest.mark.parametrize("way", ["shift", "turn"])
def test_a_face_is_made_anew_when_its_bodies_have_moved_against_each_other(rng: np.random.Generator, way: str) -> None:
    """By half a millimetre."""
    for far, kept in ((3e-4, True), (9e-4, False)):
        pair = box_on_box(rng)
        reach = pair.soft.pose[2, s.POSE_REACH]
        by = far * random_unit(rng)
        none = np.zeros(3)
        pair.move(1, *((by, none) if way == "shift" else (none, by / reach)), 10.0 * far)
        if way == "turn":  # it turns about its middle, and the face goes aside
            pair.move(1, -np.cross(by / reach, -0.1 * pair.placed[1].axes[:, 2]), none, 0.0)
        assert keeps(pair) == kept
