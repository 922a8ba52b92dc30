"""Contacts that are looked for from a direction known before are those that are found without it."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
import pytest

from stiction.core import state
from stiction.core.collide.narrow import pair_contacts
from stiction.core.vec import Vec3

from .support import Array, Placed, matrix_of, random_unit, rows_of
from .test_collide_shapes import KINDS, TABLE, along, best_separation, least_width, random_pair

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


@every_pair
def test_a_hint_loses_no_contact_and_finds_as_good_a_normal(rng: np.random.Generator, kinds: tuple[str, str]) -> None:
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
                one, two = (
                    float(along(a, b, rows[:1, state.NORMAL : state.NORMAL + 3])[0]) for rows in (plain, hinted)
                )
                assert two >= one - slack, (kinds, gap, angle, one, two)
                depths = [rows[:, state.SEPARATION].min() for rows in (plain, hinted)]
                assert depths[1] <= depths[0] + slack, (kinds, gap, angle, depths)
                assert depths[1] >= depths[0] - slack, (kinds, gap, angle, depths)


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
