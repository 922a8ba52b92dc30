"""Fingerprints notice every bit; the cryptographic hash is what it always was."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.hashing import PARTS, STATE_WIDTH, Fingerprint, state_hash


def test_every_single_bit_changes_a_fingerprint(rng: np.random.Generator) -> None:
    state, fingerprint = rng.normal(size=(4, STATE_WIDTH)), Fingerprint()
    seen = {fingerprint(7, state)}
    for k in range(state.size):
        for bit in range(64):
            other = state.copy()
            other.reshape(-1).view(np.uint64)[k] ^= np.uint64(1 << bit)
            seen.add(fingerprint(7, other))
    assert len(seen) == 1 + 64 * state.size


def test_signs_steps_places_and_numbers_of_bodies_count(rng: np.random.Generator) -> None:
    state, fingerprint = rng.normal(size=(3, STATE_WIDTH)), Fingerprint()
    mirrored, swapped = state.copy(), state[[1, 0, 2]]
    mirrored[:, [0, 7]] *= -1.0  # high bits alone, in pairs
    zeros = np.zeros((3, STATE_WIDTH))
    found = [
        fingerprint(1, state), fingerprint(2, state), fingerprint(1, mirrored), fingerprint(1, swapped),
        fingerprint(1, state[:2].copy()), fingerprint(1, zeros), fingerprint(1, -zeros), fingerprint(1, zeros[:2]),
        fingerprint(0, zeros[:0]), fingerprint(1, zeros[:0]),
    ]  # fmt: skip
    assert len(set(found)) == len(found)
    assert fingerprint(1, state) == found[0] == Fingerprint()(1, state)
    assert all(0 <= one < 2**64 for one in found)


def test_the_hash_of_a_world_is_that_of_its_state() -> None:
    world = st.World()
    world.add(st.Sphere(1), position=(1, 2, 3), velocity=(4, 5, 6))
    world.step(3)
    state = np.concatenate([getattr(world, name) for name in PARTS], axis=1)
    assert state.shape == (1, STATE_WIDTH)
    assert world.state_hash() == state_hash(3, state) != state_hash(4, state)


@pytest.mark.parametrize("name", PARTS)
def test_parts_of_a_state_have_the_width_of_the_worlds_arrays(name: str) -> None:
    world = st.World()
    world.add(st.Sphere(1))
    assert getattr(world, name).shape[1] == PARTS[name].stop - PARTS[name].start
