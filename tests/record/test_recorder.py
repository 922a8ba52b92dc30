"""Frames in memory: what they hold is what the world held, and what bodies are doing is told rightly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError, Motion
from stiction.record.classify import classify, fixed_bodies
from stiction.record.recorder import Recorder, capture


def sliding_world() -> st.World:
    world = st.World(dt=0.01, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete", name="floor")
    world.add(st.Box((1, 1, 1)), material="wood", mass=5.0, position=(0, 0, 0.5), velocity=(1, 0, 0), name="crate")
    world.add(st.Sphere(0.5), material="wood", position=(0, 5, 3), name="ball")
    return world


# --- frames -----------------------------------------------------------------------------------------------------------


def test_a_capture_is_a_copy_of_what_the_world_holds() -> None:
    world = sliding_world()
    world.step(3)
    frame = capture(world)
    assert (frame.step, frame.time) == (3, world.time)
    for name in ("positions", "orientations", "velocities", "angular_velocities"):
        np.testing.assert_array_equal(getattr(frame, name), getattr(world, name))
    np.testing.assert_array_equal(frame.contacts, world.contacts())
    np.testing.assert_array_equal(frame.motion, classify(world))
    before = frame.positions.copy()
    world.step(3)
    np.testing.assert_array_equal(frame.positions, before)
    assert len(capture(world, contacts=False).contacts) == 0


def test_a_capture_lets_steps_go_on_as_fast_as_before() -> None:
    world = sliding_world()
    world.step(3)
    capture(world)
    # nobody but the capture has seen the world's arrays, so no step has to look for changes of them
    assert not world._store.watched
    assert world.positions.shape == (3, 3)
    assert world._store.watched


def test_frames_hold_every_third_step_and_the_contacts_of_each() -> None:
    world = sliding_world()
    recorder = Recorder(world, "three", every=3)
    seen: list[dict[str, Any]] = []
    for step in range(101):
        assert recorder.capture() == (step % 3 == 0)
        if step % 3 == 0:
            arrays = {name: getattr(world, name).copy() for name in ("positions", "orientations", "velocities")}
            seen.append({"time": world.time, "contacts": world.contacts(), "motion": classify(world), **arrays})
        world.step()
    frames = recorder.frames()
    assert len(frames) == len(recorder) == len(seen) == 34
    assert (frames.title, frames.dt, frames.meta["every"]) == ("three", 0.01, 3)
    assert len({len(old["contacts"]) for old in seen}) > 1, "the ball lands, so the number of contacts changes"
    for number, old in enumerate(seen):
        assert frames.times[number] == old["time"]
        np.testing.assert_array_equal(frames.positions[number], old["positions"])
        np.testing.assert_array_equal(frames.orientations[number], old["orientations"])
        np.testing.assert_array_equal(frames.velocities[number], old["velocities"])
        np.testing.assert_array_equal(frames.motion[number], old["motion"])
        np.testing.assert_array_equal(frames.contacts_of(number), old["contacts"])
    assert frames.contact_offsets[0] == 0 and frames.contact_offsets[-1] == len(frames.contacts)
    assert [(b.name, b.fixed, b.mass) for b in frames.bodies][:2] == [("floor", True, math.inf), ("crate", False, 5.0)]


def test_a_step_gives_one_frame_at_most_and_the_last_can_be_forced() -> None:
    world = sliding_world()
    recorder = Recorder(world, "t", every=5)
    assert recorder.capture()
    assert not recorder.capture()
    world.step(7)
    assert not recorder.capture()
    assert recorder.capture(force=True)
    assert not recorder.capture(force=True)
    np.testing.assert_allclose(recorder.frames().times, [0, 0.07])


def test_a_recorder_that_kept_nothing_gives_no_frames_of_the_right_shape() -> None:
    frames = Recorder(sliding_world(), "t").frames()
    assert len(frames) == 0
    assert frames.positions.shape == (0, 3, 3) and frames.orientations.shape == (0, 3, 4)
    assert frames.motion.shape == (0, 3) and frames.contact_offsets.tolist() == [0]


def test_contacts_can_be_left_out() -> None:
    world = sliding_world()
    recorder = Recorder(world, "t", contacts=False)
    world.step()
    recorder.capture()
    frames = recorder.frames()
    assert len(frames.contacts) == 0
    assert frames.motion[0, 1] == Motion.SLIDING, "but what bodies do is known all the same"


def test_motion_can_be_left_out() -> None:
    world = st.World()
    world.add(st.Plane(), static=True)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    recorder, plain = Recorder(world, "run"), Recorder(world, "run", motion=False)
    world.step()
    for one in (recorder, plain):
        one.capture()
    assert recorder.frames().motion.tolist() == [[Motion.FIXED, Motion.STICKING]]
    assert plain.frames().motion.tolist() == [[Motion.FREE, Motion.FREE]]
    assert np.array_equal(plain.frames().contacts, recorder.frames().contacts)


def test_a_recording_refuses_what_it_cannot_hold() -> None:
    world = sliding_world()
    for every in (0, -1, 1.5, True):
        with pytest.raises(InvalidInputError, match="every must be a whole number, 1 or more"):
            Recorder(world, "t", every=every)  # type: ignore[arg-type]  # wrong on purpose
    recorder = Recorder(world, "t")
    world.add(st.Sphere(1.0))
    with pytest.raises(InvalidInputError, match="a recording of 3 bodies must keep them, and the world has 4 now"):
        recorder.capture()


# --- what bodies are doing --------------------------------------------------------------------------------------------


def motions(world: st.World) -> list[Motion]:
    return [Motion(int(m)) for m in classify(world)]


def test_a_crate_slides_and_then_sticks_while_the_floor_is_fixed_and_the_ball_flies() -> None:
    world = sliding_world()
    assert motions(world) == [Motion.FIXED, Motion.FREE, Motion.FREE], "before the first step nothing is known"
    world.step()
    assert motions(world) == [Motion.FIXED, Motion.SLIDING, Motion.FREE]
    world.run(0.5)
    assert motions(world)[1] == Motion.STICKING


def test_a_ball_slides_until_it_rolls_and_rolls_in_every_direction() -> None:
    for angle in np.linspace(0, 2 * math.pi, 7):
        world = st.World(dt=0.01, materials=st.MaterialTable.lecture())
        world.add(st.Plane(), static=True, material="concrete")
        velocity = (math.cos(angle), math.sin(angle), 0)
        world.add(st.Sphere(0.2), material="wood", position=(0, 0, 0.2), velocity=velocity)
        world.step()
        assert motions(world)[1] == Motion.SLIDING
        world.run(1.0)
        assert motions(world)[1] == Motion.ROLLING


def test_a_ball_that_spins_on_the_spot_sticks() -> None:
    world = st.World(dt=0.01, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete")
    world.add(st.Sphere(0.2), material="wood", position=(0, 0, 0.2), angular_velocity=(0, 0, 30))
    world.step(10)
    assert motions(world)[1] == Motion.STICKING
    np.testing.assert_allclose(world.angular_velocities[1], [0, 0, 30])


def test_a_crate_on_a_turntable_sticks_although_it_turns() -> None:
    world = st.World(dt=0.005, materials=st.MaterialTable.lecture())
    table = st.Box((4, 4, 0.2))
    world.add(table, kinematic=True, material="concrete", position=(0, 0, -0.1), angular_velocity=(0, 0, 1))
    crate = world.add(
        st.Box((0.4, 0.4, 0.4)), material="wood", position=(1, 0, 0.2), velocity=(0, 1, 0), angular_velocity=(0, 0, 1)
    )
    world.run(1.0)
    assert motions(world) == [Motion.FIXED, Motion.STICKING]
    assert np.linalg.norm(crate.velocity) > 0.9


def test_a_crate_on_a_table_that_tilts_sticks_although_both_turn() -> None:
    world = st.World(dt=0.005, materials=st.MaterialTable.lecture())
    world.add(st.Box((2, 2, 0.2)), kinematic=True, material="concrete", angular_velocity=(0, 0.5, 0))
    w = np.array([0, 0.5, 0])
    crate = world.add(
        st.Box((0.4, 0.4, 0.2)),
        material="rubber",
        position=(0, 0, 0.2),
        velocity=np.cross(w, (0, 0, 0.2)),
        angular_velocity=w,
    )
    world.run(0.4)
    np.testing.assert_allclose(crate.angular_velocity, w, atol=1e-4)
    assert motions(world) == [Motion.FIXED, Motion.STICKING]


def test_a_domino_that_tips_over_its_edge_turns_over_a_contact_that_holds() -> None:
    world = st.World(dt=0.005, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete")
    w = 1.2  # about the edge at x = 0.04, so the centre moves with w x r
    world.add(
        st.Box((0.08, 0.24, 0.48)),
        material="rubber",
        position=(0, 0, 0.24),
        velocity=(w * 0.24, 0, w * 0.04),
        angular_velocity=(0, w, 0),
    )
    world.step(20)
    assert motions(world)[1] == Motion.ROLLING


def test_what_is_fixed_can_be_told_ahead() -> None:
    world = sliding_world()
    world.step(5)
    fixed = fixed_bodies(world)
    assert fixed.tolist() == [True, False, False]
    np.testing.assert_array_equal(capture(world, fixed=fixed).motion, classify(world))
    assert classify(world).dtype == np.uint8
    assert classify(st.World()).shape == (0,)
