"""A batch: each world ends in the bits in which it ends alone, and looks after itself."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.scene import load

WORLDS = 5


def make_world(mu: float = 0.5, restitution: float = 0.0, spheres: bool = False) -> st.World:
    """Six bodies that fall on each other and on the floor."""
    table = st.MaterialTable()
    table.set_pair("floor", "thing", static=mu, dynamic=0.8 * mu, restitution=restitution)
    table.set_pair("thing", "thing", static=mu, dynamic=0.8 * mu)
    table.set_pair("floor", "floor", static=0.4)
    world = st.World(materials=table)
    world.add(st.Plane(), static=True, material="floor")
    for k in range(5):
        shape = st.Sphere(0.4) if spheres and k % 2 == 0 else st.Box((1.0, 0.8, 0.5))
        world.add(shape, mass=2.0, material="thing", position=(0.3 * k, 0.1 * k, 0.6 + 0.9 * k), name=f"thing {k}")
    return world


MUS = np.linspace(0.1, 0.9, WORLDS)
MASSES = np.linspace(0.7, 9.0, WORLDS)
GRAVITIES = np.stack([np.zeros(WORLDS), np.linspace(0, 1, WORLDS), -np.linspace(2, 15, WORLDS)], axis=1)
SPEEDS = np.linspace(-1.0, 2.0, WORLDS)


def vary(batch: st.Batch, numbers: np.ndarray) -> None:
    """World k of the batch becomes number ``numbers[k]`` of the varied worlds."""
    batch.set_pair("floor", "thing", static=MUS[numbers], dynamic=0.8 * MUS[numbers])
    batch.set_mass("thing 2", MASSES[numbers])
    batch.gravity = GRAVITIES[numbers]
    batch.velocities[:, 3, 0] = SPEEDS[numbers]


def alone(number: int, restitution: float, spheres: bool) -> st.World:
    """One of them by itself."""
    world = make_world(restitution=restitution, spheres=spheres)
    world.materials.set_pair("floor", "thing", static=MUS[number], dynamic=0.8 * MUS[number])
    world["thing 2"].mass = MASSES[number]
    world.gravity = GRAVITIES[number]
    world.velocities[3, 0] = SPEEDS[number]
    return world


# a pile that falls at once is more than its impacts may be looked at; the bits count here
@pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")
@pytest.mark.parametrize(("restitution", "spheres"), [(0.0, False), (0.5, True)])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_world_of_a_batch_ends_in_the_bits_in_which_it_ends_alone(
    restitution: float, spheres: bool, threads: int
) -> None:
    numbers = np.array([3, 0, 4, 1, 2, 2, 0])
    batch = st.Batch(make_world(restitution=restitution, spheres=spheres), len(numbers), threads=threads)
    vary(batch, numbers)
    push = np.array([1.0, -2.0, 3.0])
    batch.step(70)
    batch.step(20, forces=push)
    batch.step(30)
    hashes = batch.hashes()
    for number in range(WORLDS):
        world = alone(number, restitution, spheres)
        world.step(70)
        for _ in range(20):
            for body in world.bodies[1:]:
                body.apply_force(push)
            world.step()
        world.step(30)
        for k in np.flatnonzero(numbers == number):
            assert hashes[k] == world.state_hash()
        mine = batch.world(int(np.flatnonzero(numbers == number)[0]))
        assert mine.time == world.time
        np.testing.assert_array_equal(mine.contacts(), world.contacts())
        mine.step(25)
        world.step(25)
        assert mine.state_hash() == world.state_hash()


def driven_world(late: float) -> st.World:
    """A turntable that carries a box, a box that falls asleep on the floor, and one that lands on it later."""
    world = st.World()
    world.add(st.Plane(), static=True)
    world.add(st.Box((4.0, 4.0, 0.2)), kinematic=True, position=(0, 0, 0.3), angular_velocity=(0, 0, 0.5))
    world.add(st.Box((0.5, 0.5, 0.5)), position=(1.0, 0, 0.65), name="rides")
    world.add(st.Box((1.0, 1.0, 1.0)), position=(9.0, 0, 0.5), name="sleeps")
    world.add(st.Box((0.5, 0.5, 0.5)), position=(9.2, 0, 10.0 + late), name="falls")
    return world


def test_worlds_with_driven_and_sleeping_bodies_end_in_the_bits_in_which_they_end_alone() -> None:
    heights = np.array([2.0, 0.0, 7.0])
    batch = st.Batch(driven_world(0.0), len(heights), threads=1)
    batch.positions[:, 4, 2] += heights
    asleep = False
    for _ in range(4):
        batch.step(45)
        worlds = [batch.world(k) for k in range(len(heights))]
        asleep |= any(not world["sleeps"].awake for world in worlds)
        batch.step(5)
        for world, expected in zip(worlds, batch.hashes(), strict=True):
            world.step(5)
            assert world.state_hash() == expected
    assert asleep
    for k, height in enumerate(heights):
        world = driven_world(height)
        world.step(200)
        assert world.state_hash() == batch.hashes()[k]
        assert not world["falls"].position[2] > 5.0


def test_four_boxes_on_the_ground_take_less_than_8_kB() -> None:
    world = st.World()
    world.add(st.Box((20.0, 20.0, 1.0)), static=True, position=(0, 0, -0.5))
    for k in range(4):
        world.add(st.Box((1.0, 1.0, 1.0)), position=(1.5 * k, 0, 0.5))
    assert st.Batch(world, 64).nbytes / 64 < 8000.0


def test_reset_brings_chosen_worlds_back_and_leaves_the_others() -> None:
    batch = st.Batch(make_world(), WORLDS, threads=1)
    batch.step(40)
    at_40 = batch.hashes()
    mask = np.array([False, True, False, True, False])
    assert batch.reset(mask).tolist() == [1, 3]
    assert batch.steps.tolist() == [40, 0, 40, 0, 40]
    np.testing.assert_array_equal(batch.positions[1], make_world().positions)
    batch.step(40)
    hashes = batch.hashes()
    assert hashes[1] == hashes[3] == at_40[0]
    assert hashes[0] == hashes[2] == hashes[4] != at_40[0]


def test_reset_keeps_what_the_worlds_are() -> None:
    batch = st.Batch(make_world(), WORLDS)
    batch.set_mass("thing 1", MASSES)
    batch.set_pair("floor", "thing", static=MUS, dynamic=0.5 * MUS)
    batch.gravity = GRAVITIES
    batch.step(3)
    batch.reset()
    np.testing.assert_array_equal(batch.masses[:, 2], MASSES)
    np.testing.assert_array_equal(batch.pair("thing", "floor")["dynamic"], 0.5 * MUS)
    np.testing.assert_array_equal(batch.gravity, GRAVITIES)


def test_states_are_gone_back_to_to_the_last_bit() -> None:
    batch = st.Batch(make_world(), WORLDS)
    vary(batch, np.arange(WORLDS))
    batch.step(50)
    state = batch.state()
    batch.step(30)
    after = batch.hashes()
    batch.set_state(state)
    np.testing.assert_array_equal(batch.positions, state.positions)
    np.testing.assert_array_equal(batch.velocities, state.velocities)
    batch.step(30)
    assert batch.hashes() == after
    batch.reset()
    batch.set_state(batch.state([0]), [2, 4])
    assert len(set(batch.hashes())) == 1


def test_a_state_fits_a_batch_that_has_needed_less_room() -> None:
    batch = st.Batch(make_world(), 2)
    batch.step(60)
    state = batch.state()
    batch.step(10)
    other = st.Batch(make_world(), 2)
    other.set_state(state)
    other.step(10)
    assert other.hashes() == batch.hashes()


@pytest.mark.parametrize("between", [True, False], ids=["between steps", "within a step"])
@pytest.mark.parametrize("threads", [1, 2])
def test_a_world_that_blows_up_is_frozen_and_the_others_go_on(between: bool, threads: int) -> None:
    batch, fine = (st.Batch(make_world(), 4, threads=threads) for _ in range(2))
    batch.step(5)
    where = batch.positions[2].copy()
    if between:
        batch.velocities[2, 4] = np.nan
    else:
        batch.forces[2, 4] = 1e300
    batch.step(6)
    fine.step(11)
    assert batch.failed.tolist() == [False, False, True, False]
    assert batch.failures == ["world 2, step 6: the state of body 'thing 3' is no longer finite."]
    assert batch.steps.tolist() == [11, 11, 5, 11]
    np.testing.assert_array_equal(batch.positions[2], where)
    assert batch.hashes([0, 1, 3]) == fine.hashes([0, 1, 3])
    batch.reset(batch.failed)
    assert not batch.failed.any()
    assert batch.failures == []
    batch.step(11)
    assert batch.hashes([2]) == fine.hashes([2])


def test_arrays_are_views_for_others_too() -> None:
    batch = st.Batch(make_world(), 3)
    theirs = np.from_dlpack(batch.positions)
    theirs[1, 2] = 7.0, 8.0, 9.0
    assert batch.positions[1, 2].tolist() == [7.0, 8.0, 9.0]


def test_contacts_are_those_of_the_worlds() -> None:
    batch = st.Batch(make_world(), 3)
    batch.gravity = GRAVITIES[1:4]
    batch.step(80)
    worlds, rows = batch.contacts()
    for k in range(3):
        np.testing.assert_array_equal(rows[worlds == k], batch.world(k).contacts())
    only, some = batch.contacts([1])
    assert set(only.tolist()) == {1}
    np.testing.assert_array_equal(some, rows[worlds == 1])


def test_what_a_world_draws_does_not_depend_on_the_others() -> None:
    few, many = st.Batch(make_world(), 2, seed=3), st.Batch(make_world(), 6, seed=3)
    many.uniform(0.0, 1.0, [5])
    low, high = np.zeros((2, 3)), np.full((2, 3), 2.0)
    first, second = few.uniform(low, high), many.uniform(low, high, [1, 0])
    assert first.shape == (2, 2, 3)
    assert ((0.0 <= first) & (first < 2.0)).all()
    np.testing.assert_array_equal(first, second[::-1])
    assert (first[0] != first[1]).all()
    np.testing.assert_array_equal(few.normal(1.0, 2.0), many.normal(1.0, 2.0, [0, 1]))


def test_a_scene_can_be_copied() -> None:
    batch = st.Batch("ramp", 3)
    batch.step(30)
    world = load("ramp").build()
    world.step(30)
    assert set(batch.hashes()) == {world.state_hash()}


def test_the_world_that_was_copied_stays_as_it_was() -> None:
    world = make_world()
    before = world.state_hash()
    batch = st.Batch(world, 2)
    batch.set_pair("floor", "thing", static=0.9, dynamic=0.9)
    batch.step(10)
    assert world.state_hash() == before
    assert world.materials.pair("floor", "thing").static == 0.5
    world.remove(world["thing 0"])
    assert len(batch.bodies) == 6


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda b: st.Batch(make_world(), 0), "worlds must be a whole number, 1 or more"),
        (lambda b: st.Batch(st.World(), 3), "world must have a body"),
        (lambda b: st.Batch(7, 3), "world must be a World or a scene"),
        (lambda b: st.Batch(st.World(solver="micro"), 3), "solver must be 'soft'"),
        (lambda b: st.Batch("pull", 3), "must not have pushes"),
        (lambda b: b.step(0), "n must be"),
        (lambda b: b.step(1, forces=np.ones((2, 2))), "forces must be an array of shape"),
        (lambda b: b.step(1, torques=np.inf), "torques must be finite"),
        (lambda b: b.reset([0, 0]), "worlds must be a mask"),
        (lambda b: b.reset([9]), "worlds must be a mask"),
        (lambda b: b.set_mass("thing 1", -1.0), "mass must be more than 0"),
        (lambda b: b.set_mass("thing 1", [1.0, 2.0]), "mass must be a number"),
        (lambda b: b.set_mass("plane 0", 1.0), "mass must not be set"),
        (lambda b: b.set_pair("floor", "thin", static=0.1), "material must be one of"),
        (lambda b: b.set_pair("floor", "thing", static=0.2, dynamic=-0.1), "dynamic friction of floor - thing must be"),
        (lambda b: b.set_pair("floor", "thing", restitution=1.5), "must be between 0 and 1"),
        (lambda b: setattr(b, "gravity", np.zeros((2, 3))), "gravity must be"),
        (lambda b: b.set_state(make_world()), "state must be a BatchState"),
        (lambda b: b.set_state(b.state([0, 1])), "state must be of 3 worlds"),
    ],
)
def test_bad_input_gets_one_sentence_and_changes_nothing(change: object, words: str) -> None:
    batch = st.Batch(make_world(), 3)
    before, pair = batch.hashes(), batch.pair("floor", "thing")
    with pytest.raises((st.InvalidInputError, st.NotYetError)) as raised:
        change(batch)  # type: ignore[operator]  # a lambda of the table above
    assert words in str(raised.value)
    assert "\n" not in str(raised.value)
    assert batch.hashes() == before
    for name, numbers in batch.pair("floor", "thing").items():
        np.testing.assert_array_equal(numbers, pair[name])
