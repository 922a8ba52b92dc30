"""Sleep: what is at rest falls asleep, what only seems to be never does, and whatever is touched wakes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.core.sleep import PERIOD, REST_TIME


def table(static: float = 0.6, dynamic: float = 0.5, **more: float) -> st.MaterialTable:
    result = st.MaterialTable()
    result.set_pair("default", "default", static=static, dynamic=dynamic, **more)
    return result


def floor(materials: st.MaterialTable | None = None, **given: Any) -> st.World:
    """A world with a ground called ``floor``."""
    world = st.World(materials=table() if materials is None else materials, **given)
    world.add(st.Plane(), static=True, name="floor")
    return world


def stack(n: int = 3, x: float = 0.0, **given: Any) -> st.World:
    """n crates on top of each other."""
    world = floor(**given)
    for k in range(n):
        world.add(st.Box((1, 1, 1)), position=(x, 0, 0.5 + k), name=f"crate {k}")
    return world


def asleep(world: st.World) -> list[str]:
    """Names of the dynamic bodies that sleep."""
    return [body.name for body in world if body.mobility == "dynamic" and not body.awake]


def sleeping_stack(n: int = 3) -> st.World:
    world = stack(n)
    world.run(6.0)
    assert len(asleep(world)) == n
    return world


# --- falling asleep ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 3, 6])
def test_a_stack_at_rest_falls_asleep_as_a_whole(n: int) -> None:
    world = stack(n)
    counts = []
    for _ in range(600):
        world.step()
        counts.append(len(asleep(world)))
    assert set(counts) == {0, n}
    assert counts.index(n) >= REST_TIME * 60 - PERIOD
    assert counts == sorted(counts)


def test_what_sleeps_does_not_move_by_a_bit() -> None:
    world = sleeping_stack()
    before = world.positions.copy(), world.orientations.copy()
    world.run(5.0)
    np.testing.assert_array_equal(world.positions, before[0])
    np.testing.assert_array_equal(world.orientations, before[1])
    assert not world.velocities.any()
    assert not world.angular_velocities.any()
    # what it weighs is still told
    assert world.contacts()["normal_impulse"].sum() > 0.0


def test_a_stack_of_ten_sleeps_in_the_end_and_where_it_stood() -> None:
    world = stack(10)
    world.run(20.0)
    assert len(asleep(world)) == 10
    assert np.abs(world.positions[1:, :2]).max() < 1e-4


def test_sleeping_can_be_switched_off() -> None:
    world = stack(2, sleeping=False)
    world.run(5.0)
    assert asleep(world) == []


def test_each_island_sleeps_for_itself() -> None:
    """One is shaken; the other does not care."""
    world = stack(2)
    world.add(st.Box((1, 1, 1)), position=(9, 0, 0.5), name="shaken")
    for _ in range(400):
        world["shaken"].apply_force((0, 500 * np.sin(20 * world.time), 0))
        world.step()
    assert asleep(world) == ["crate 0", "crate 1"]


# --- what never sleeps ------------------------------------------------------------------------------------------------


def held_at(speed: float, shape: st.Shape, height: float, **materials: float) -> st.World:
    """A body that moves at a constant speed: without friction, or rolling, nothing stops it."""
    world = floor(table(**materials))
    radius = getattr(shape, "radius", 0.0)
    spin = (0, speed / radius, 0) if materials["static"] and radius else (0, 0, 0)
    world.add(shape, position=(0, 0, height), velocity=(speed, 0, 0), angular_velocity=spin, name="body")
    return world


def test_a_crate_that_slides_at_a_millimetre_a_second_never_sleeps() -> None:
    world = held_at(1e-3, st.Box((1, 1, 1)), 0.5, static=0.0, dynamic=0.0)
    for _ in range(40):
        world.step(30)
        assert asleep(world) == []
    assert world["body"].position[0] == pytest.approx(1e-3 * world.time, rel=1e-3)


def test_a_crate_at_rest_falls_asleep_without_friction_too() -> None:
    world = held_at(0.0, st.Box((1, 1, 1)), 0.5, static=0.0, dynamic=0.0)
    world.run(5.0)
    assert asleep(world) == ["body"]


def test_a_ball_that_rolls_at_a_millimetre_a_second_never_sleeps() -> None:
    world = held_at(1e-3, st.Sphere(0.5), 0.5, static=0.5, dynamic=0.5)
    for _ in range(40):
        world.step(30)
        assert asleep(world) == []
    assert world["body"].velocity[0] > 0.9e-3


def test_a_top_that_turns_slowly_on_the_spot_never_sleeps() -> None:
    world = floor(table(0.0, 0.0))
    world.add(st.Cylinder(0.5, 0.2), position=(0, 0, 0.1), angular_velocity=(0, 0, 1e-3), name="top")
    world.run(10.0)
    assert asleep(world) == []
    assert world["top"].angular_velocity[2] == pytest.approx(1e-3, rel=1e-3)


def test_a_crate_on_a_belt_or_a_turntable_never_sleeps() -> None:
    """It may stand still against it, and it may stand still in the world."""
    materials = table(0.0, 0.0)
    materials.set_pair("rough", "rough", static=0.6, dynamic=0.5)
    world = st.World(materials=materials)
    world.add(st.Box((4, 4, 1)), static=True, position=(0, 0, -0.5), surface_velocity=(1, 0, 0))
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5), name="on the belt")
    world.add(st.Box((4, 4, 1)), kinematic=True, position=(9, 0, -0.5), angular_velocity=(0, 0, 1))
    world.add(st.Box((1, 1, 1)), position=(9, 0, 0.5), name="on the turntable")
    world.add(st.Box((4, 4, 1)), static=True, position=(18, 0, -0.5), material="rough")
    world.add(st.Box((1, 1, 1)), position=(18, 0, 0.5), name="on the ground", material="rough")
    world.run(5.0)
    assert asleep(world) == ["on the ground"]


def test_a_ball_that_turns_over_at_the_top_of_its_way_does_not_fall_asleep_there() -> None:
    """At rest for an instant only."""
    world = floor(table(restitution=0.9))
    world.add(st.Sphere(0.2), position=(0, 0, 1.2), name="ball")
    for _ in range(200):
        world.step()
        assert asleep(world) == []


# --- waking -----------------------------------------------------------------------------------------------------------


def test_what_is_hit_wakes_with_its_whole_island() -> None:
    world = sleeping_stack()
    world.add(st.Sphere(0.2), position=(-2, 0, 0.5), velocity=(6, 0, 0), name="ball")
    awake = []
    for _ in range(40):
        world.step()
        awake.append(3 - len(asleep(world)))
    assert set(awake) == {0, 3}
    assert awake.index(3) > 5, "not before it is there"
    assert np.abs(world["crate 0"].position[0]) > 1e-4


def test_what_passes_by_wakes_nothing() -> None:
    world = sleeping_stack()
    world.add(st.Sphere(0.2), position=(-2, 2, 0.5), velocity=(6, 0, 0))
    world.run(0.7)
    assert len(asleep(world)) == 3


def test_another_island_is_left_asleep() -> None:
    world = stack(2)
    world.add(st.Box((1, 1, 1)), position=(9, 0, 0.5), name="far")
    world.run(6.0)
    assert len(asleep(world)) == 3
    world["crate 1"].velocity = (0, 0, 1)
    world.step()
    assert asleep(world) == ["far"]


EDITS: dict[str, Callable[[st.World], Any]] = {
    "a velocity": lambda world: world["crate 2"].__setattr__("velocity", (0.5, 0, 0)),
    "a position": lambda world: world["crate 2"].__setattr__("position", (0.2, 0, 2.6)),
    "an impulse": lambda world: world["crate 1"].apply_impulse((500, 0, 0)),
    "a force": lambda world: world["crate 0"].apply_force((20000, 0, 0)),
    "a torque": lambda world: world["crate 0"].apply_torque((0, 0, 20000)),
    "a mass": lambda world: world["crate 0"].__setattr__("mass", 3000.0),
    "a view of the velocities": lambda world: world.velocities.__setitem__((2, 0), 0.5),
    "a view of the positions": lambda world: world.positions.__setitem__((3, 2), 2.7),
    "the floor below": lambda world: world["floor"].__setattr__("position", (0, 0, -0.5)),
    "the floor below, by a view": lambda world: world.positions.__setitem__((0, 2), -0.5),
    "the floor becomes a belt": lambda world: world["floor"].__setattr__("surface_velocity", (1, 0, 0)),
}
"""Changes from outside."""


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS.keys())
def test_an_edit_wakes_the_whole_island(edit: Callable[[st.World], Any]) -> None:
    world = sleeping_stack()
    edit(world)
    world.step()
    assert asleep(world) == []


def test_taking_the_floor_away_lets_sleepers_fall() -> None:
    """What they had sunk into each other pushes them apart at a centimetre a second."""
    world = sleeping_stack()
    world["floor"].position = (0, 0, -100)
    world.run(0.5)
    np.testing.assert_allclose(world.velocities[1:, 2], -9.81 * world.dt * 30, atol=0.03)


def test_looking_wakes_nothing() -> None:
    world = sleeping_stack()
    for _ in range(30):
        world.positions, world.velocities, world.state_hash(), world.energy(), world.contacts()
        world.step()
        assert len(asleep(world)) == 3


def test_a_woken_stack_falls_asleep_again() -> None:
    world = sleeping_stack()
    world["crate 2"].velocity = (0, 0, 1)
    world.step()
    assert asleep(world) == []
    world.run(8.0)
    assert len(asleep(world)) == 3
