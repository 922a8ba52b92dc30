"""The room of a world's arrays: what a busier time has needed is given back."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.core import soft_rows
from stiction.core.pairs import FREE, PAIRS, SLOT, SLOTS
from stiction.core.tree import NONE


def scattered() -> st.World:
    """Columns of boxes that fall apart."""
    world = st.World()
    world.add(st.Plane(), static=True)
    for k in range(64):
        at = (0.9 * (k % 4), 0.9 * (k // 4 % 4), 0.5 + 1.1 * (k // 16))
        world.add(st.Box((1, 1, 1)), position=at, velocity=(k % 3 - 1, k % 5 - 2, 0))
    world.step(20)
    return world


def test_room_is_given_back_and_no_bit_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the middle of a run, while bodies go on touching and parting, and pairs keep what they know of each other."""
    kept, trimmed = scattered(), scattered()
    before = trimmed._store.cache
    monkeypatch.setattr("stiction.soft_store.MANY_PAIRS", 1)
    monkeypatch.setattr("stiction.soft_store._is_wasted", lambda room, number: room > number + number // 16 + 16)
    for _ in range(40):
        trimmed.step()
    monkeypatch.undo()
    kept.step(40)
    assert len(trimmed._store.cache.pairs) < len(before.pairs)
    assert len(trimmed._store.cache.free) < len(before.free)
    assert trimmed.state_hash() == kept.state_hash()
    for name in ("normal_impulse", "friction_impulse"):
        np.testing.assert_array_equal(trimmed.contacts()[name], kept.contacts()[name])


def test_only_pairs_that_touch_have_a_slot() -> None:
    """Neighbours that are near each other and apart take no rows of the solver."""
    world = scattered()
    world.step(300)
    cache, meta = world._store.cache, world._store.soft.meta
    pairs = cache.pairs[: cache.counts[PAIRS]]
    slots = pairs[pairs[:, SLOT] != NONE, SLOT]
    assert len(world.contacts()) / 4 <= len(slots) < len(pairs)
    assert (meta[slots + 1, soft_rows.POINTS] > 0).all()
    free = cache.free[: cache.counts[FREE]]
    assert sorted([*slots, *free]) == list(range(cache.counts[SLOTS]))
    assert len(cache.free) < len(cache.pairs)
