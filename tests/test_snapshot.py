"""Snapshots: a world that is put back goes on as the one that they were taken of."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError
from stiction.core import pairs
from stiction.snapshot import NOT_KEPT, SCRATCH, put, settings_of, take
from stiction.soft_store import BY_SLOT


def heap(solver: str = "soft") -> st.World:
    """Boxes and spheres that fall on each other."""
    world = st.World(solver=solver)
    world.add(st.Plane(), static=True)
    for k in range(12):
        shape = st.Box((1, 1, 1)) if k % 2 else st.Sphere(0.5)
        world.add(shape, position=(0.3 * (k % 3), 0.2 * (k % 4), 0.6 + 1.05 * k))
    return world


@pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")
@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_a_world_goes_on_as_it_did(solver: str) -> None:
    world, other = heap(solver), heap(solver)
    world.step(40)
    snapshot = take(world)
    world.step(40)
    end, contacts = world.state_hash(), world.contacts()
    other.step(3)
    for target in (other, world):
        put(target, snapshot)
        assert target.steps == 40
        target.step(40)
        assert target.state_hash() == end
        np.testing.assert_array_equal(target.contacts(), contacts)
        assert target.energy() == world.energy()


@pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")
@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_contacts_and_energy_are_there_at_once(solver: str) -> None:
    world, other = heap(solver), heap(solver)
    world.step(90)
    put(other, take(world))
    np.testing.assert_array_equal(other.contacts(), world.contacts())
    assert other.energy() == world.energy()
    assert [body.awake for body in other] == [body.awake for body in world]


def test_a_snapshot_is_a_copy() -> None:
    world = heap()
    world.step(5)
    snapshot = take(world)
    before = {name: array.copy() for name, array in snapshot.items()}
    put(world, snapshot)
    world.step(5)
    world.positions[1] = 9.0
    for name, array in snapshot.items():
        np.testing.assert_array_equal(array, before[name])


def test_what_a_pair_left_behind_is_not_kept_and_not_missed() -> None:
    """Balls that roll through each other's neighbourhood begin and end pairs all the time."""
    worlds = [st.World() for _ in range(2)]
    for world in worlds:
        world.add(st.Plane(), static=True)
        for k in range(16):
            world.add(st.Sphere(0.5), position=(1.2 * k, 0.3 * (k % 3), 0.5), velocity=(12.0 - 1.5 * k, k % 2, 0))
    world, other = worlds
    world.step(120)
    snapshot = take(world)
    counts = snapshot["cache.counts"]
    free = snapshot["cache.free"][: counts[pairs.FREE]] + 1
    left_behind = world._store.soft.meta[free]
    assert len(free) > 2 and left_behind.any(), "or there would be nothing to leave out"
    assert not any(snapshot[f"soft.{name}"][free].any() for name in BY_SLOT)
    assert counts[pairs.PAIRS] > 10 and snapshot["cache.pairs"][: counts[pairs.PAIRS]].any(axis=1).all()
    put(other, snapshot)
    for _ in range(60):
        world.step(2)
        other.step(2)
        assert other.state_hash() == world.state_hash()


def test_sleepers_and_edits_that_wait_are_kept() -> None:
    worlds = [st.World(), st.World()]
    for world in worlds:
        world.add(st.Plane(), static=True)
        world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
        world.add(st.Box((1, 1, 1)), position=(0, 0, 1.5))
    world, other = worlds
    world.step(200)
    assert not any(body.awake for body in world)
    world.bodies[2].apply_force((300, 0, 4000))
    put(other, take(world))
    for one in worlds:
        one.step(30)
    assert other.state_hash() == world.state_hash()
    assert world.bodies[2].awake


def test_every_attribute_of_a_store_is_kept_or_known_to_follow_from_the_others() -> None:
    """An attribute that somebody adds makes `take` fail, unless it is an array or a number, and then it is kept."""
    store = heap()._store
    names = {name.split(".")[0] for name in take(heap())}
    assert set(vars(store)) - NOT_KEPT <= names
    for name in SCRATCH:
        part = store
        for step in name.split("."):
            part = getattr(part, step)
        assert isinstance(part, np.ndarray)
    store.novelty = object()  # type: ignore[attr-defined]  # what a later version may add
    world = heap()
    world._store = store
    with pytest.raises(TypeError, match="a snapshot knows no attribute 'novelty'"):
        take(world)


def narrower(snapshot: dict[str, np.ndarray]) -> None:
    snapshot["bodies"] = snapshot["bodies"][:, :-1]


def other_type(snapshot: dict[str, np.ndarray]) -> None:
    snapshot["soft.manifolds"] = snapshot["soft.manifolds"].astype(np.float64)


def missing(snapshot: dict[str, np.ndarray]) -> None:
    del snapshot["tree.leaf"]


def fewer(snapshot: dict[str, np.ndarray]) -> None:
    snapshot["n"] = np.array(3)


@pytest.mark.parametrize("spoil", [narrower, other_type, missing, fewer])
def test_a_snapshot_that_does_not_fit_changes_nothing(spoil: Callable[[dict[str, np.ndarray]], None]) -> None:
    world, other = heap(), heap()
    world.step(10)
    snapshot = take(world)
    spoil(snapshot)
    before = other.state_hash()
    with pytest.raises(InvalidInputError, match=r"^snapshot must .*\.$"):
        put(other, snapshot)
    assert other.state_hash() == before
    other.step(10)
    assert other.state_hash() == world.state_hash()


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"solver": "micro", "micro_literal": True, "iterations": 7},
        {"solver": "exact", "tolerance": 1e-6, "substeps": 2},
        {"substeps": 4, "precision": "double", "sleeping": False, "threads": 2, "gravity": (1, 2, 3), "dt": 0.01},
    ],
)
def test_settings_make_a_world_of_the_same_settings(arguments: dict[str, object]) -> None:
    world = st.World(**arguments)  # type: ignore[arg-type]  # of several kinds
    settings = settings_of(world)
    for name, value in arguments.items():
        np.testing.assert_array_equal(settings[name], value)
    assert settings_of(st.World(**settings)) == settings
    assert st.World(**settings)._settings == world._settings
