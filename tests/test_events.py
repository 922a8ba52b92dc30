"""Contacts that begin and end, as they are recorded from step to step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.events import EVENT_DTYPE, TOUCHING_DTYPE

SOLVERS = ["soft", "micro"]
BEGIN, END = st.EventKind.BEGIN, st.EventKind.END
pytestmark = pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")


def world_of(restitution: float = 0.0, **more: Any) -> st.World:
    """A floor, recorded from the beginning."""
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.5, dynamic=0.5, restitution=restitution)
    world = st.World(materials=table, **more)
    world.add(st.Plane(), static=True, name="floor")
    world.record_events = True
    return world


def changes(world: st.World) -> list[tuple[int, int, int, int]]:
    """(step, kind, a, b) of each event of the last call."""
    rows = world.contact_events().changes
    return [(int(r["step"]), int(r["kind"]), int(r["body_a"]), int(r["body_b"])) for r in rows]


def touching(world: st.World) -> list[tuple[int, int]]:
    rows = world.contact_events().touching
    return list(zip(rows["body_a"].tolist(), rows["body_b"].tolist(), strict=True))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_ball_that_lands_begins_to_touch_once(solver: str) -> None:
    world = world_of(solver=solver)
    ball = world.add(st.Sphere(0.5), position=(0, 0, 1.0))
    assert len(world.contact_events().changes) == len(world.contact_events().touching) == 0
    world.step(60)
    [(step, kind, a, b)] = changes(world)
    assert kind == BEGIN
    assert (a, b) == (0, 1)
    # it falls half a metre; contact is found when it is there, or a step ahead
    assert step * world.dt == pytest.approx((2 * 0.5 / 9.81) ** 0.5, abs=1.5 * world.dt)
    [impulse] = world.contact_events().changes["normal_impulse"]
    assert 0.0 < impulse < 1.3 * ball.mass * (2 * 9.81 * 0.5) ** 0.5
    assert touching(world) == [(0, 1)]
    world.step(60)
    assert changes(world) == []
    assert touching(world) == [(0, 1)]
    ball.velocity = (0, 0, 5)
    world.step(10)
    [(step, kind, a, b)] = changes(world)
    assert kind == END
    assert step <= 2
    assert (a, b) == (0, 1)
    assert touching(world) == []
    assert world.contact_events().changes.dtype == EVENT_DTYPE
    assert world.contact_events().touching.dtype == TOUCHING_DTYPE


@pytest.mark.parametrize("solver", SOLVERS)
def test_one_call_or_many_tell_the_same(solver: str) -> None:
    """And so does the touching of each step, worked out from its contacts."""

    def build() -> st.World:
        world = world_of(0.5, solver=solver)
        for k in range(5):
            world.add(st.Sphere(0.5), position=(0.3 * k, 0, 1.0 + 1.2 * k), velocity=(0, 0, -k))
        return world

    together, single, found, expected = build(), build(), [], []
    together.step(80)
    before: set[tuple[int, int]] = set()
    for step in range(1, 81):
        single.step()
        found += [(step, *row[1:]) for row in changes(single)]
        rows = single.contacts()
        rows = rows[rows["normal_impulse"] > 0.0]
        now = set(zip(rows["body_a"].tolist(), rows["body_b"].tolist(), strict=True))
        expected += [(step, int(END), *pair) for pair in sorted(before - now)]
        expected += [(step, int(BEGIN), *pair) for pair in sorted(now - before)]
        assert touching(single) == sorted(now)
        before = now
    assert changes(together) == found == expected
    assert len(found) > 10


@pytest.mark.parametrize("solver", SOLVERS)
def test_recording_changes_nothing_else(solver: str) -> None:
    worlds = [world_of(solver=solver) for _ in range(2)]
    worlds[1].record_events = False
    for world in worlds:
        for k in range(4):
            world.add(st.Box((1, 1, 1)), position=(0.1 * k, 0, 0.7 + 1.1 * k))
        world.step(50)
    assert worlds[0].state_hash() == worlds[1].state_hash()


def test_no_event_is_lost_when_hundreds_begin_at_once() -> None:
    world = world_of()
    for x in range(20):
        for y in range(20):
            world.add(st.Sphere(0.4), position=(x, y, 0.45))
    world.step(30)
    rows = changes(world)
    assert sorted((a, b) for _, kind, a, b in rows if kind == BEGIN) == [(0, k) for k in range(1, 401)]
    assert touching(world) == [(0, k) for k in range(1, 401)]


def test_sleeping_bodies_go_on_touching() -> None:
    world = world_of()
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    world.add(st.Box((1, 1, 1)), position=(0, 0, 1.5))
    world.step(400)
    assert not world["box 1"].awake
    world.step(10)
    assert changes(world) == []
    assert touching(world) == [(0, 1), (1, 2)]


def test_a_sensor_tells_who_comes_and_goes() -> None:
    """A ball falls through a gate from 2 to 1 m; a sleeper that was in it all along is told once."""
    world = world_of()
    gate = world.add(st.Box((10, 10, 1)), static=True, sensor=True, position=(0, 0, 1.5))
    column = world.add(st.Box((1, 1, 1.5)), position=(4, 0, 0.75))
    ball = world.add(st.Sphere(0.25), position=(0, 0, 4.0))
    world.step(200)
    rows = [row for row in world.contact_events().changes if row["sensor"]]
    told = [(int(r["body_a"]), int(r["body_b"]), int(r["kind"])) for r in rows]
    assert told == [
        (gate.index, column.index, BEGIN), (gate.index, ball.index, BEGIN), (gate.index, ball.index, END)
    ]  # fmt: skip
    for row, height in zip(rows[1:], (2.25, 0.75), strict=True):
        assert row["step"] * world.dt == pytest.approx((2 * (4.0 - height) / 9.81) ** 0.5, abs=1.01 * world.dt)
        assert row["normal_impulse"] == 0.0
    assert not column.awake
    at_the_end = world.contact_events().touching
    assert at_the_end[at_the_end["sensor"]].tolist() == [(gate.index, column.index, True)]
    assert world.overlaps(gate) == [column]


@pytest.mark.parametrize("solver", SOLVERS)
def test_events_after_a_removal_name_the_bodies_that_are_left(solver: str) -> None:
    world = world_of(solver=solver)
    balls = [world.add(st.Sphere(0.5), position=(2 * k, 0, 0.505)) for k in range(3)]
    world.step(20)
    assert touching(world) == [(0, 1), (0, 2), (0, 3)]
    world.remove(balls[1])
    assert touching(world) == [(0, 1), (0, 2)]
    assert [row[2:] for row in changes(world)] == [(0, 1), (0, 2)]
    world.step(5)
    assert changes(world) == []
    assert touching(world) == [(0, 1), (0, 2)]


def test_recording_that_begins_late_knows_who_touches() -> None:
    world = world_of()
    world.record_events = False
    world.add(st.Sphere(0.5), position=(0, 0, 0.5))
    world.step(30)
    world.record_events = True
    assert touching(world) == [(0, 1)]
    world.step(5)
    assert changes(world) == []


def test_events_of_steps_that_were_not_recorded_cannot_be_asked_for() -> None:
    world = st.World()
    assert not world.record_events
    with pytest.raises(st.InvalidInputError, match=r"^record_events must be set to True before the steps whose"):
        world.contact_events()
    with pytest.raises(st.InvalidInputError, match=r"^record_events must be True or False, got 1.$"):
        world.record_events = 1  # type: ignore[assignment]  # that is the point
    world.record_events = True
    world.step(3)
    assert len(world.contact_events().changes) == 0
    assert np.array_equal(world.contact_events().touching, np.zeros(0, TOUCHING_DTYPE))
