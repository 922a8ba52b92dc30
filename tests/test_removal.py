"""Bodies that are taken out of a running world: what becomes of the others, of names, and of what was asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.core.pairs import PAIR_A, PAIR_B, PAIRS
from stiction.core.tree import check

SOLVERS = ["soft", "micro"]
pytestmark = pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")


def no_bounce() -> st.MaterialTable:
    """Two bodies of the default material hold and do not bounce."""
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.5, dynamic=0.5)
    return table


def stack(solver: str = "soft", height: int = 4, **more: Any) -> tuple[st.World, list[st.Body]]:
    """A column of unit boxes on a floor."""
    world = st.World(solver=solver, materials=no_bounce(), **more)
    world.add(st.Plane(), static=True, name="floor")
    return world, [world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5 + k)) for k in range(height)]


def fall_asleep(world: st.World) -> None:
    """Step until nobody is awake."""
    for _ in range(100):
        world.step(10)
        if not any(body.awake for body in world):
            return
    raise AssertionError([body.name for body in world if body.awake])


def is_sound(world: st.World) -> None:
    """Tree, pairs and lists name the bodies that are there, and no others."""
    store: Any = world._store
    assert store.n == len(world)
    if world.solver != "soft":
        assert sorted(store.lists.order.tolist()) == list(range(len(store.lists.order)))
        return
    assert check(store.tree)
    pairs = store.cache.pairs[: store.cache.counts[PAIRS]]
    names = pairs[:, PAIR_A] * 10**6 + pairs[:, PAIR_B]
    assert (np.diff(names) > 0).all()
    assert (pairs[:, PAIR_A] < pairs[:, PAIR_B]).all()
    assert (pairs[:, PAIR_B] < len(world)).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_others_keep_their_order_and_their_state(solver: str) -> None:
    world = st.World(solver=solver)
    bodies = [world.add(st.Sphere(0.5), position=(2 * k, 0, 0), velocity=(0, k, 0), name=f"b{k}") for k in range(6)]
    world.step()
    positions = world.positions.copy()
    world.remove(bodies[1])
    world.remove([bodies[4], bodies[0]])
    assert [body.name for body in world] == ["b2", "b3", "b5"]
    assert [body.index for body in world] == [0, 1, 2]
    np.testing.assert_array_equal(world.positions, positions[[2, 3, 5]])
    np.testing.assert_array_equal(bodies[5].position, positions[5])
    world.step()
    np.testing.assert_allclose(bodies[5].velocity[1], 5.0)
    is_sound(world)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_removed_body_says_so_and_its_name_is_free(solver: str) -> None:
    world = st.World(solver=solver)
    body = world.add(st.Sphere(0.5), name="ball")
    world.remove(body)
    assert repr(body) == "<Body 'ball' (removed sphere, default)>"
    sentence = "^body 'ball' was removed from its world and can no longer be used.$"
    for use in (
        lambda: body.position,
        lambda: body.index,
        lambda: body.mobility,
        lambda: body.mass,
        lambda: body.awake,
        lambda: body.layer,
        lambda: body.apply_force((1, 0, 0)),
        lambda: setattr(body, "velocity", (1, 0, 0)),
        lambda: world.remove(body),
        lambda: world.contacts(body),
    ):
        with pytest.raises(st.InvalidInputError, match=sentence):
            use()
    with pytest.raises(st.InvalidInputError, match=r"no body is called 'ball'"):
        world["ball"]
    world.step()
    again = world.add(st.Sphere(0.5), name="ball", position=(1, 2, 3))
    assert world["ball"] is again
    world.step()
    assert len(world) == 1


def test_names_that_are_made_do_not_come_twice() -> None:
    world = st.World()
    first = world.add(st.Sphere(0.5))
    world.add(st.Sphere(0.5), position=(2, 0, 0))
    world.remove(first)
    world.add(st.Sphere(0.5), position=(4, 0, 0))
    assert [body.name for body in world] == ["sphere 1", "sphere 2"]


def test_bad_removals_change_nothing() -> None:
    world, boxes = stack()
    other = st.World().add(st.Sphere(1))
    for wrong, sentence in (
        (None, "^body must be a body of this world, got None.$"),
        ("box 1", "^body must be a body of this world, got 'box 1'.$"),
        (other, r"^body must be a body of this world, got <Body 'sphere 0' \(dynamic sphere, default\)>.$"),
        ([boxes[0], other], "^body must be a body of this world"),
        ([boxes[0], boxes[1], boxes[0]], "^body must not hold 'box 1' twice.$"),
    ):
        with pytest.raises(st.InvalidInputError, match=sentence):
            world.remove(wrong)  # type: ignore[arg-type]  # that is the point
    assert len(world) == 5
    assert boxes[0].index == 1
    world.remove([])
    assert len(world) == 5


@pytest.mark.parametrize("solver", SOLVERS)
def test_without_its_lowest_box_a_stack_comes_down(solver: str) -> None:
    world, boxes = stack(solver)
    world.step(20)
    world.remove(boxes[0])
    world.step(120)
    for k, box in enumerate(boxes[1:]):
        assert box.position[2] == pytest.approx(0.5 + k, abs=0.03)
    is_sound(world)


def test_removal_wakes_what_rested_on_it_and_nothing_else() -> None:
    world, boxes = stack()
    lonely = world.add(st.Box((1, 1, 1)), position=(30, 0, 0.5))
    fall_asleep(world)
    world.remove(boxes[3])
    assert [box.awake for box in boxes[:3]] == [True, True, True]
    assert not lonely.awake
    fall_asleep(world)
    world.remove(world["floor"])
    assert all(body.awake for body in world)
    world.step(10)
    assert all(body.velocity[2] < -1.0 for body in world)


def test_islands_still_wake_as_a_whole_after_the_rows_moved_up() -> None:
    world = st.World(materials=no_bounce())
    early = world.add(st.Sphere(0.5), position=(50, 0, 0.5))
    world.add(st.Plane(), static=True)
    piles = [[world.add(st.Box((1, 1, 1)), position=(5 * x, 0, 0.5 + z)) for z in range(3)] for x in range(3)]
    fall_asleep(world)
    world.remove(early)
    world.remove(piles[0])
    assert not any(box.awake for pile in piles[1:] for box in pile)
    piles[1][2].velocity = (0, 0, 1)
    world.step()
    assert all(box.awake for box in piles[1])
    assert not any(box.awake for box in piles[2])


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_body_that_comes_and_goes_far_away_changes_nothing(solver: str) -> None:
    """Bit for bit, with stacks, balls that roll, and bodies that fall asleep."""

    def run(disturb: bool) -> str:
        world = st.World(solver=solver, materials=no_bounce())
        far = [world.add(st.Box((1, 1, 1)), position=(900, 9 * k, 40)) for k in range(3)] if disturb else []
        world.add(st.Plane(), static=True)
        for x in range(3):
            for z in range(3):
                world.add(st.Box((1, 1, 1)), position=(1.5 * x, 0, 0.5 + z))
        world.add(st.Sphere(0.4), position=(-3, 0, 0.41), velocity=(4, 0.3, 0))
        if disturb:
            world.remove(far.pop())
        for k in range(12):
            world.step(5)
            if disturb and k in (2, 5):
                world.remove(far.pop())
            if disturb and k == 6:
                world.remove(world.add(st.Capsule(0.2, 1), position=(-900, 0, 5)))
        return world.state_hash()

    assert run(True) == run(False)


@pytest.mark.parametrize("solver", SOLVERS)
def test_random_comings_and_goings(rng: np.random.Generator, solver: str) -> None:
    """Bodies of some shapes rain on a floor and leave at random; everything stays sound and above the floor."""
    world = st.World(solver=solver, materials=no_bounce())
    world.add(st.Plane(), static=True)
    shapes: list[st.Shape] = [st.Sphere(0.4), st.Box((0.7, 0.8, 0.9))]
    for _ in range(40):
        for _ in range(int(rng.integers(0, 5))):
            place = (*rng.uniform(-2, 2, size=2), rng.uniform(2, 6))
            world.add(shapes[int(rng.integers(2))], position=place, orientation=rng.normal(size=4))
        world.step(int(rng.integers(1, 6)))
        leave = [body for body in world.bodies[1:] if rng.random() < 0.15]
        world.remove(leave)
        is_sound(world)
        assert [world[body.name] for body in world] == list(world)
        for row in world.contacts():
            assert 0 <= row["body_a"] < row["body_b"] < len(world)
    assert (world.positions[1:, 2] > 0.0).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_world_can_be_emptied_and_filled_again(solver: str) -> None:
    world, boxes = stack(solver)
    fresh, _ = stack(solver)
    world.step(20)
    world.remove(world.bodies)
    assert len(world) == 0
    assert world.positions.shape == (0, 3)
    assert len(world.contacts()) == 0
    world.step(5)
    world.add(st.Plane(), static=True, name="floor")
    for k in range(len(boxes)):
        world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5 + k))
    world.step(30)
    fresh.step(30)
    np.testing.assert_array_equal(world.positions, fresh.positions)
    np.testing.assert_array_equal(world.velocities, fresh.velocities)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_ledger_closes_when_a_body_goes(solver: str) -> None:
    world, boxes = stack(solver)
    world.step(10)
    before = world.energy()
    taken = boxes[3].mass * 9.81 * boxes[3].position[2] + boxes[3].kinetic_energy
    world.remove(boxes[3])
    after = world.energy()
    assert after.edits - before.edits == pytest.approx(-taken)
    world.step(10)
    assert abs(world.energy().residual) < 1e-6 * before.potential


def test_many_edits_of_one_body_do_not_drown_those_of_another() -> None:
    """Both a setter and a view, more often than there are bodies; the sleeping one notices."""
    world = st.World(materials=no_bounce())
    world.add(st.Plane(), static=True)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    sleeper = world.add(st.Box((1, 1, 1)), position=(9, 0, 0.5))
    for by_view in (False, True):
        fall_asleep(world)
        for _ in range(100):
            world.bodies[1].velocity = (0, 0, 0)
        if by_view:
            world.velocities[2] = (0, 0, 3)
        else:
            sleeper.velocity = (0, 0, 3)
        world.step()
        assert sleeper.awake
        assert sleeper.velocity[2] > 2.0
