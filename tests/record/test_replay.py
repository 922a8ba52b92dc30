"""Recordings run again: whatever was done to a world, it ends in the same bits; what does not is found, and where."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError
from stiction.record.input_numbers import InputNumbers, decode_numbers
from stiction.record.inputs import COLUMNS, FRICTION, GRAVITY, KINDS, TEXT, VIEW
from stiction.record.layout import OPEN_OUTCOME
from stiction.record.replay import check
from stiction.record.writer import RecordingWriter

from .worlds import tower


def push(world: st.World) -> None:
    world["box 2"].apply_force((4000, 0, 0), at=world["box 2"].position + np.array((0, 0, 0.3)))
    world["box 1"].apply_torque((0, 0, 500))


def hit(world: st.World) -> None:
    world["box 3"].apply_impulse((900, 200, 0), at=(0, 0, 2.2))


def move(world: st.World) -> None:
    world["box 4"].position = (0.1, 0.2, 6.0)
    world["box 4"].orientation = (1, 0.1, 0.2, 0.3)
    world["box 4"].velocity = (0.1 + 0.2, 0, 0)
    world["box 4"].angular_velocity = (0, 1 / 3, 0)


def write_views(world: st.World) -> None:
    world.positions[2] += (0.1, 0, 0.5)
    world.velocities[3:] = (1, 1, 0)


def set_and_write(world: st.World) -> None:
    """The same body by its handle and then through a view that was taken before."""
    view = world.velocities
    world["box 2"].velocity = (5, 0, 0)
    view[2, 1] = 1.0


def weigh(world: st.World) -> None:
    world["box 1"].mass = 77.7
    world["box 2"].inertia = (100, 110, 120)


def run_a_belt(world: st.World) -> None:
    world["plane 0"].surface_velocity = (1, 0.5, 0)


def part_layers(world: st.World) -> None:
    world["box 1"].layer = -(2**62)
    world["box 2"].mask = 1


def tilt(world: st.World) -> None:
    world.gravity = (1, 2, -9.0)


def polish(world: st.World) -> None:
    world.materials.set_pair("default", "default", static=0.02, dynamic=0.01)


def add(world: st.World) -> None:
    world.add(st.Sphere(0.4), position=(0.5, 0, 7), orientation=(1, 2, 3, 4), density=500, name="late", grain=(1, 2, 0))
    world.add(st.Box((0.5, 1, 0.2)), position=(0, 1.5, 0.2), velocity=(1, 0, 0), material="ice")


def remove(world: st.World) -> None:
    world.positions[3] += (0, 0, 0.25)
    world.remove([world["box 1"], world["box 4"]])


def add_and_remove(world: st.World) -> None:
    add(world)
    remove(world)
    world["late"].velocity = (0, 0, -3)


CHANGES = (
    push, hit, move, write_views, set_and_write, weigh, run_a_belt, part_layers, tilt, polish, add, remove,
    add_and_remove,
)  # fmt: skip


@pytest.mark.parametrize("change", CHANGES)
def test_a_world_that_was_changed_comes_out_the_same(change: Callable[[st.World], None], tmp_path: Path) -> None:
    """And so it does when it is run from a snapshot before the change, at it, or after it."""
    world, untouched = tower(), tower()
    world.step(3)
    with RecordingWriter(tmp_path / "run.h5", world, every=4, checkpoint_steps=25):
        world.step(25)
        change(world)
        world.step(40)
    untouched.step(68)
    assert world.state_hash() != untouched.state_hash()
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.checkpoint_steps.tolist() == [3, 28, 53]
        assert len(recording.inputs()) > 0
        for start in (None, 30 / 60, 60 / 60):
            result = recording.check(start)
            assert result.same and result.notes == [], result
        again = recording.world()
        assert again.state_hash() == world.state_hash()
        assert again.energy() == world.energy()
        again.step(20)
        world.step(20)
        assert again.state_hash() == world.state_hash()


def test_every_kind_of_input_is_tried() -> None:
    """A new one must not be forgotten in the test above."""
    assert set(KINDS) == {*COLUMNS, VIEW, GRAVITY, TEXT, FRICTION}
    tried = {
        "position", "orientation", "velocity", "angular velocity", "surface velocity", "force", "torque", "mass",
        "inverse mass", "inertia", "inverse inertia",
    }  # fmt: skip
    assert set(COLUMNS) == tried


def test_a_drive_comes_out_the_same_when_the_road_turns_to_ice(tmp_path: Path) -> None:
    """Steering, throttle and brake are recorded as the forces that they come to, what the tyres take as friction."""
    world = st.World()
    world.materials.set_pair("tyre", "road", static=1.0, dynamic=0.9)
    world.add(st.Plane(), static=True, material="road")
    body = world.add(st.Box((4, 1.6, 0.5)), mass=1200, position=(0, 0, 0.55), velocity=(15, 0, 0), name="car")
    wheels = st.four_wheels(front=1.3, rear=-1.3, track=1.5, hub_height=-0.25, tyre="tyre")
    car = st.Vehicle(world, body, wheels, visible=False)
    with RecordingWriter(tmp_path / "drive.h5", world, every=4, checkpoint_steps=25):
        car.throttle, car.steer = 0.5, 0.1
        car.step(20)
        world.materials.set_pair("tyre", "road", static=0.15, dynamic=0.1)
        car.throttle, car.brake = 0.0, 1.0
        car.step(40)
    assert world.energy().friction > 1000.0
    assert body.friction_work > 1000.0
    with st.Recording.open(tmp_path / "drive.h5") as recording:
        assert "friction from outside" in {one.what for one in recording.inputs()}
        for start in (None, 30 / 60):
            assert recording.check(start).same
        again = recording.world()
        assert again.state_hash() == world.state_hash()
        assert again.energy() == world.energy()
        assert again["car"].friction_work == body.friction_work
        assert recording.energies["friction"][-1] == world.energy().friction


@pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")
@pytest.mark.parametrize("solver", ["micro", "soft"])
def test_a_run_goes_on_from_any_step(solver: str, tmp_path: Path) -> None:
    world = tower(3, solver)
    hashes = [world.state_hash()]
    with RecordingWriter(tmp_path / "run.h5", world, checkpoint_steps=20):
        for _ in range(50):
            world.step()
            hashes.append(world.state_hash())
    with st.Recording.open(tmp_path / "run.h5") as recording:
        for step in (0, 1, 19, 20, 21, 50):
            assert recording.world(step).state_hash() == hashes[step]
        assert recording.check().same
        for step in (-1, 51, 2.5):
            with pytest.raises(InvalidInputError, match=r"^step must be "):
                recording.world(step)  # type: ignore[arg-type]  # wrong on purpose


def test_forces_that_wait_when_the_recording_begins_act_again(tmp_path: Path) -> None:
    world = tower()
    world.step(5)
    push(world)
    with world.record(tmp_path / "run.h5"):
        world.step(30)
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.check().same


def test_a_step_that_failed_fails_again_and_the_run_goes_on(tmp_path: Path) -> None:
    world = tower()
    with world.record(tmp_path / "run.h5"):
        world.step(5)
        world["box 4"].velocity = (1e200, 0, 0)
        with pytest.raises(st.SimulationError):
            world.step()
        world["box 4"].velocity = (0, 0, 0)
        world.step(20)
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.check().same
        assert recording.world().state_hash() == world.state_hash()


def test_recording_changes_nothing(tmp_path: Path) -> None:
    worlds = tower(), tower()
    worlds[0].record_events = worlds[1].record_events = True
    with worlds[0].record(tmp_path / "run.h5", contacts=True):
        for world in worlds:
            world.step(40)
            push(world)
            world.step(40)
    assert worlds[0].state_hash() == worlds[1].state_hash()
    events = [world.contact_events() for world in worlds]
    np.testing.assert_array_equal(events[0].changes, events[1].changes)


# --- differences ------------------------------------------------------------------------------------------------------


def recorded(path: Path, precision: str = "display") -> None:
    """60 steps with one push, at step 20, and a snapshot at step 50."""
    world = tower()
    with RecordingWriter(path, world, every=10, precision=precision, checkpoint_steps=50):
        world.step(20)
        world["box 2"].apply_force((4000, 0, 0))
        world.step(40)


def set_first_number(path: Path, before: float, after: float) -> None:
    """Of the inputs of a recording: the push's x."""
    with h5py.File(path, "r+") as file:
        rows, stored = file["inputs/rows"][:], file["inputs/numbers"]
        numbers = decode_numbers(rows, stored[:])
        assert numbers[0] == before
        numbers[0] = after
        stored[:] = InputNumbers().encode(rows, numbers)


def test_an_input_that_is_another_one_is_found_at_its_step(tmp_path: Path) -> None:
    """Half a millionth of a force is seen by hashes at once; how much it makes, by the frames or snapshots after it."""
    path = tmp_path / "run.h5"
    recorded(path)
    set_first_number(path, 4000.0, 4000.002)
    with st.Recording.open(path) as recording:
        result = recording.check()
        assert not result.same
        assert result.differs_at == 21
        assert {one.step for one in result.bodies} <= {30, 40, 50} and result.bodies
        assert 0 < max(one.position for one in result.bodies) < 1e-3
        assert recording.check(stop=20 / 60).same, "up to there nothing differs"
    set_first_number(path, 4000.002, 8000.0)
    with st.Recording.open(path) as recording:
        result = recording.check()
        assert result.differs_at == 21
        pushed = next(one for one in result.bodies if one.name == "box 2")
        assert pushed.step == 30
        assert 1e-4 < pushed.position < 1.0 and pushed.velocity > 1e-4


def test_a_hash_that_is_another_one_is_told_without_a_body(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    recorded(path, "full")
    with h5py.File(path, "r+") as file:
        file["hashes"][55] ^= np.uint64(1)
    with st.Recording.open(path) as recording:
        calls: list[tuple[int, int]] = []
        result = check(recording, on_progress=lambda done, total: calls.append((done, total)))
        assert (result.differs_at, result.bodies) == (55, [])
        assert "no body differs by more than the precision of frames (full)" in result.notes[-1]
        assert calls == [(0, 60), (50, 60)]


def test_other_kernels_and_machines_are_told(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    recorded(path)
    with h5py.File(path, "r+") as file:
        file.attrs["kernels"], file.attrs["machine"] = "0123", "an abacus"
    with st.Recording.open(path) as recording:
        notes = recording.check().notes
    assert "with other kernels" in notes[0] and "another class of machine: an abacus" in notes[1]


def test_what_this_version_cannot_run_again_is_told_in_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    recorded(path)
    with h5py.File(path, "r+") as file:
        row = file["checkpoints/rows"][0]
        start = int(row["start"])
        file["checkpoints/data"][start : start + 40] = 0
    with st.Recording.open(path) as recording:
        with pytest.raises(InvalidInputError, match=r"^recording '.*run\.h5' is damaged: .*\.$"):
            recording.check()
        assert recording.check(start=55 / 60).same, "the other snapshot is whole"
        assert recording.outcome == "closed" != OPEN_OUTCOME
        with pytest.raises(InvalidInputError, match=r"^stop must be 0 to 1 s, the time of the recording, got 3\.$"):
            recording.check(stop=3)
        with pytest.raises(InvalidInputError, match=r"^stop must not be before start"):
            recording.check(0.5, 0.2)


def test_a_world_has_one_recording_at_a_time(tmp_path: Path) -> None:
    world = tower()
    with world.record(tmp_path / "a.h5"):
        with pytest.raises(InvalidInputError, match="one recording at a time"):
            world.record(tmp_path / "b.h5")
        world.step()
    with world.record(tmp_path / "b.h5", title="again", meta={"seed": 7}):
        world.step()
    with st.Recording.open(tmp_path / "b.h5") as recording:
        assert (recording.title, recording.metadata["meta"], recording.first_step) == ("again", {"seed": 7}, 1)
    for wrong in ({"every": 0}, {"precision": "half"}, {"contacts": 1}):
        with pytest.raises(InvalidInputError, match=f"^{next(iter(wrong))} must be "):
            world.record(tmp_path / "c.h5", **wrong)  # type: ignore[arg-type]  # wrong on purpose
    assert not (tmp_path / "c.h5").exists()
