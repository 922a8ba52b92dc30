"""Recordings in files: what went in comes out, whatever ended the run; other files are refused with one sentence."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError, OutputError, SimulationError
from stiction.motion import Motion
from stiction.record import columns, worker
from stiction.record import writer as writer_module
from stiction.record.bodies import info_from_dict, info_to_dict, shape_from_dict, shape_to_dict
from stiction.record.frames import CONTACT_DTYPE, BodyInfo, Frames
from stiction.record.hdf5 import RecordingWriter, load_frames, restore
from stiction.record.recorder import Recorder
from stiction.record.run import run, summary
from stiction.scene import Scene, Simulation, load

ARRAYS = ("times", "positions", "orientations", "velocities", "angular_velocities", "motion", "contacts")


def crates() -> Simulation:
    """Three crates for a second: they stick, slide and stop."""
    return Simulation(load("push-and-release", ["duration=1.0", "pushes[2].until=0.5"]))


def assert_same(a: Frames, b: Frames, first: int | None = None) -> None:
    """The same frames to the last bit, or the same ``first`` ones."""
    for name in ARRAYS[:-1]:
        np.testing.assert_array_equal(getattr(a, name)[:first], getattr(b, name)[:first], strict=True)
    for number in range(len(a.times[:first])):
        np.testing.assert_array_equal(a.contacts_of(number), b.contacts_of(number), strict=True)
    assert a.bodies == b.bodies
    assert (a.title, a.dt) == (b.title, b.dt)


def test_a_file_holds_what_memory_holds(tmp_path: Path) -> None:
    simulation = crates()
    recorder = Recorder(simulation.world, simulation.scene.title, every=3)
    with RecordingWriter(tmp_path / "run.h5", simulation, 3, True, precision="full") as writer:
        run(simulation, recorder=recorder, writer=writer)
    assert len(writer) == len(recorder) == 68  # 0, 3, … 198, and the last step, 200
    frames = load_frames(tmp_path / "run.h5")
    assert_same(frames, recorder.frames())
    assert frames.contacts.dtype == CONTACT_DTYPE
    assert frames.meta["outcome"] == "complete"
    assert frames.meta["stiction_version"] == st.__version__
    assert frames.meta["scene"] == simulation.scene.to_dict()


def test_frames_are_written_in_many_pieces_alike(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer_module, "BATCH_STEPS", 7)
    monkeypatch.setattr(columns, "PIECE_FRAMES", (4, 5))
    monkeypatch.setattr(columns, "PIECE_BODIES", 3)
    monkeypatch.setattr(worker, "COMMIT_SECONDS", 0.0)
    simulation = crates()
    recorder = Recorder(simulation.world, simulation.scene.title)
    with RecordingWriter(tmp_path / "run.h5", simulation, 1, True, precision="full") as writer:
        run(simulation, recorder=recorder, writer=writer, chunk=1)
    assert_same(load_frames(tmp_path / "run.h5"), recorder.frames())


def test_frames_for_the_eye_are_near_those_in_memory(tmp_path: Path) -> None:
    """Positions in float32, orientations in 16 bits, velocities in float16."""
    simulation = crates()
    simulation.world.bodies[1].angular_velocity = (0, 0, 1)
    recorder = Recorder(simulation.world, simulation.scene.title)
    with RecordingWriter(tmp_path / "run.h5", simulation, 1, True) as writer:
        run(simulation, recorder=recorder, writer=writer)
    file, memory = load_frames(tmp_path / "run.h5"), recorder.frames()
    np.testing.assert_allclose(file.positions, memory.positions, rtol=6e-8, atol=1e-30)
    np.testing.assert_allclose(file.orientations, memory.orientations, rtol=0, atol=3.1e-5)
    np.testing.assert_allclose(file.velocities, memory.velocities, rtol=5e-4, atol=6.2e-5)
    np.testing.assert_allclose(file.angular_velocities, memory.angular_velocities, rtol=5e-4, atol=6.2e-5)
    np.testing.assert_allclose(np.linalg.norm(file.orientations, axis=2), 1.0, rtol=1e-12)
    np.testing.assert_array_equal(file.motion, memory.motion)
    np.testing.assert_array_equal(file.contact_offsets, memory.contact_offsets)
    np.testing.assert_allclose(file.contacts["normal_impulse"], memory.contacts["normal_impulse"], rtol=1e-6)


def test_contacts_can_be_left_out_of_a_file(tmp_path: Path) -> None:
    simulation = crates()
    with RecordingWriter(tmp_path / "run.h5", simulation, 10) as writer:
        run(simulation, writer=writer)
    frames = load_frames(tmp_path / "run.h5")
    assert len(frames) == 21
    assert len(frames.contacts) == 0 and frames.contact_offsets.tolist() == [0] * 22
    assert frames.meta["contacts"] is False
    assert set(frames.motion.ravel().tolist()) == {Motion.FIXED, Motion.FREE}


def test_a_scene_without_bodies_can_be_recorded(tmp_path: Path) -> None:
    simulation = Simulation(Scene.from_dict({"title": "t", "expect": "e.", "duration": 0.1}))
    with RecordingWriter(tmp_path / "run.h5", simulation, 1) as writer:
        run(simulation, writer=writer)
    frames = load_frames(tmp_path / "run.h5")
    assert frames.positions.shape == (7, 0, 3) and frames.bodies == []
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.check().same
    assert restore(tmp_path / "run.h5").total_steps == 6


@pytest.mark.parametrize(
    "shape",
    [
        st.Sphere(0.1),
        st.Box((0.1, 1 / 3, 3)),
        st.Plane((1, 2, 3), 0.1),
        st.Capsule(0.1, 0.7),
        st.Cylinder(0.1, 0.7),
        st.Ellipsoid((0.1, 1 / 3, 3)),
        st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1 / 3)]),
    ],
)
def test_a_body_survives_the_way_through_json(shape: st.Shape) -> None:
    again = shape_from_dict(json.loads(json.dumps(shape_to_dict(shape))))
    assert type(again) is type(shape)
    if isinstance(shape, st.ConvexHull):
        np.testing.assert_array_equal(again.points, shape.points)  # type: ignore[attr-defined]  # a Shape of that kind
    elif isinstance(shape, st.Plane):
        np.testing.assert_allclose(again.normal, shape.normal, rtol=1e-15)  # type: ignore[attr-defined]  # a Shape of that kind
    else:
        assert again == shape
    for mass, fixed in ((2.5, False), (float("inf"), True)):
        info = BodyInfo("a name", st.Sphere(1), "wood", mass, fixed)
        assert info_from_dict(json.loads(json.dumps(info_to_dict(info), allow_nan=False))) == info


# --- restoring --------------------------------------------------------------------------------------------------------


def test_what_was_changed_before_the_run_is_restored_to_the_last_bit(tmp_path: Path) -> None:
    simulation = crates()
    crate = simulation.world["resting, 440 N"]
    crate.velocity = (0.1 + 0.2, 0, 0)
    crate.orientation = (1, 0, 0, 1e-3)
    simulation.world.positions[1] += 1e-17
    begin = simulation.world.state_hash()
    with RecordingWriter(tmp_path / "run.h5", simulation) as writer:
        run(simulation, writer=writer)
    restored = restore(tmp_path / "run.h5")
    assert restored.scene.name == "push-and-release"
    assert restored.world.state_hash() == begin != crates().world.state_hash()
    restored.advance(restored.total_steps)
    assert restored.world.state_hash() == simulation.world.state_hash()


def test_a_recording_of_another_scenes_bodies_is_not_restored(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "run.h5", crates()):
        pass
    with h5py.File(tmp_path / "run.h5", "a") as file:
        del file["scene"]
        file.create_dataset("scene", data=json.dumps(load("ball").to_dict()), dtype=h5py.string_dtype())
    with pytest.raises(InvalidInputError, match="holds other bodies than its scene"):
        restore(tmp_path / "run.h5")


# --- runs that end early ----------------------------------------------------------------------------------------------


def full_frames() -> Frames:
    simulation = crates()
    recorder = Recorder(simulation.world, simulation.scene.title, every=2)
    run(simulation, recorder=recorder)
    return recorder.frames()


def interrupt_at(step: int) -> Any:
    def on_progress(done: int, total: int) -> None:
        if done >= step:
            raise KeyboardInterrupt

    return on_progress


def test_ctrl_c_leaves_a_file_with_the_frames_up_to_there_and_a_simulation_that_goes_on(tmp_path: Path) -> None:
    simulation = crates()
    start = simulation.world.positions.copy()
    with (
        pytest.raises(KeyboardInterrupt),
        RecordingWriter(tmp_path / "run.h5", simulation, 2, True, precision="full") as writer,
    ):
        run(simulation, writer=writer, on_progress=interrupt_at(101), chunk=3)
    frames = load_frames(tmp_path / "run.h5")
    assert frames.meta["outcome"] == "interrupted"
    stopped = simulation.step_index
    assert 101 <= stopped <= 104
    kept = stopped // 2 + 1
    assert len(frames) == kept + stopped % 2  # the step at which it was interrupted is kept as well
    assert_same(frames, full_frames(), first=kept)
    assert len(summary(simulation, start)) == 3

    run(simulation)
    other = crates()
    other.advance(other.total_steps)
    assert simulation.world.state_hash() == other.world.state_hash()


def test_a_signal_in_the_middle_of_a_run_does_the_same(tmp_path: Path) -> None:
    simulation = crates()

    def press_ctrl_c(done: int, total: int) -> None:
        if done >= 50:
            os.kill(os.getpid(), signal.SIGINT)

    with (
        pytest.raises(KeyboardInterrupt),
        RecordingWriter(tmp_path / "run.h5", simulation, 2, True, precision="full") as writer,
    ):
        run(simulation, writer=writer, on_progress=press_ctrl_c)
    frames = load_frames(tmp_path / "run.h5")
    assert frames.meta["outcome"] == "interrupted"
    assert len(frames) > 20
    assert_same(frames, full_frames(), first=simulation.step_index // 2 + 1)


@pytest.mark.parametrize("place", ["stream_columns", "_moment", "_hand_over", "step"])
def test_ctrl_c_in_the_middle_of_noting_a_step_loses_nothing(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The step was taken, so it is in the recording, and it is so once."""
    simulation = crates()
    monkeypatch.setattr(writer_module, "BATCH_STEPS", 10)
    with (
        pytest.raises(KeyboardInterrupt),
        RecordingWriter(tmp_path / "run.h5", simulation, 2, True, precision="full") as writer,
    ):
        owners = {"step": simulation.world._store, "stream_columns": writer_module}
        owner, calls = owners.get(place, writer), [0]
        real = getattr(owner, place)

        def interrupted_once(*arguments: Any) -> Any:
            calls[0] += 1
            result = real(*arguments)
            if calls[0] == 12:
                raise KeyboardInterrupt
            return result

        monkeypatch.setattr(owner, place, interrupted_once)
        run(simulation, writer=writer)
    frames = load_frames(tmp_path / "run.h5")
    stopped = simulation.step_index
    assert 0 < stopped < 200
    assert_same(frames, full_frames(), first=stopped // 2 + 1)
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.last_step == stopped
        assert recording.check().same


def test_a_world_that_blows_up_leaves_the_frames_up_to_there(tmp_path: Path) -> None:
    ball = {"name": "ball", "shape": {"type": "sphere", "radius": 1.0}, "velocity": [1e153, 0, 0]}
    data = {"title": "t", "expect": "e.", "duration": 99.0, "world": {"dt": 1.0, "gravity": [0, 0, 0]}}
    simulation = Simulation(Scene.from_dict({**data, "bodies": [ball]}))
    with (
        pytest.raises(SimulationError),
        RecordingWriter(tmp_path / "run.h5", simulation, 1, precision="full") as writer,
    ):
        run(simulation, writer=writer)
    frames = load_frames(tmp_path / "run.h5")
    assert len(frames) == simulation.step_index + 1 > 1
    assert np.isfinite(frames.positions).all()
    assert frames.meta["outcome"].startswith("failed: step ")
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert recording.check().same


def test_any_other_error_is_written_down_too(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), RecordingWriter(tmp_path / "run.h5", crates()) as writer:
        _ = 1 // 0
    frames = load_frames(tmp_path / "run.h5")
    assert len(frames) == 1
    assert frames.meta["outcome"].startswith("stopped by ZeroDivisionError")
    writer.close()  # closing again does nothing
    writer.flush()


def test_a_writer_that_is_closed_by_hand_says_how_far_the_run_came(tmp_path: Path) -> None:
    simulation = crates()
    writer = RecordingWriter(tmp_path / "run.h5", simulation)
    writer.close()
    assert load_frames(tmp_path / "run.h5").meta["outcome"] == "stopped early"


# --- files that are not what they should be ---------------------------------------------------------------------------


def test_a_path_that_cannot_be_written_is_known_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "notes.toml").write_text("precious")
    for path in (tmp_path, tmp_path / "file" / "run.h5", tmp_path / "notes.toml"):
        simulation = crates()
        with pytest.raises(OutputError, match=r"^recording .*\.$"):
            RecordingWriter(path, simulation)
        assert simulation.step_index == 0
    assert (tmp_path / "notes.toml").read_text() == "precious"


def test_an_older_recording_is_replaced(tmp_path: Path) -> None:
    for steps in (20, 10):
        simulation = crates()
        with RecordingWriter(tmp_path / "run.h5", simulation, 1):
            simulation.advance(steps - 1)
    assert len(load_frames(tmp_path / "run.h5")) == 10


def test_a_recording_must_begin_with_the_simulation(tmp_path: Path) -> None:
    simulation = crates()
    simulation.advance(3)
    with pytest.raises(InvalidInputError, match="must begin with the simulation, which is at step 3 already"):
        RecordingWriter(tmp_path / "run.h5", simulation)
    with pytest.raises(InvalidInputError, match="every must be a whole number"):
        RecordingWriter(tmp_path / "run.h5", crates(), 0)
    assert not (tmp_path / "run.h5").exists()


@pytest.mark.parametrize("read", [load_frames, restore])
def test_a_file_that_is_no_recording_is_refused_with_one_sentence(read: Any, tmp_path: Path) -> None:
    (tmp_path / "text.h5").write_text("no recording")
    (tmp_path / "empty.h5").write_bytes(b"")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 3
    for name in ("damaged", "newer", "whole"):
        with RecordingWriter(tmp_path / f"{name}.h5", crates()):
            pass
    with h5py.File(tmp_path / "damaged.h5", "a") as file:
        del file["frames/positions"]
    with h5py.File(tmp_path / "newer.h5", "a") as file:
        file.attrs["format_version"] = 99
    whole = (tmp_path / "whole.h5").read_bytes()
    (tmp_path / "half.h5").write_bytes(whole[: len(whole) // 2])
    expected = {
        "none": "recording must be a file that exists",
        "text": "is not a recording of stiction: it is no HDF5 file",
        "empty": "is not a recording of stiction: it is no HDF5 file",
        "other": "is not a recording of stiction, but another HDF5 file",
        "damaged": "is damaged: ",
        "newer": "must have format version 1, 2, 3, got 99",
        "half": "cannot be opened: ",
    }
    for name, sentence in expected.items():
        with pytest.raises(InvalidInputError) as caught:
            read(tmp_path / f"{name}.h5")
        assert sentence in str(caught.value)
        assert f"{name}.h5" in str(caught.value)
    with pytest.raises(InvalidInputError, match="must be a file that exists"):
        read(tmp_path)
    assert read(tmp_path / "whole.h5") is not None


@pytest.mark.parametrize("name", ["bodies", "commits", "checkpoints/rows"])
def test_a_recording_that_lost_an_array_is_refused_with_one_sentence(name: str, tmp_path: Path) -> None:
    """It says that it holds far more rows than fit into memory, or than it has; none of them was ever written."""
    with RecordingWriter(tmp_path / "run.h5", crates()):
        pass
    with h5py.File(tmp_path / "run.h5", "a") as file:
        lost, rows = file[name], 1 if name == "checkpoints/rows" else 1 << 60
        shape, dtype, notes = (rows, *lost.shape[1:]), lost.dtype, dict(lost.attrs)
        del file[name]
        file.create_dataset(name, shape, dtype, chunks=(1, *shape[1:])).attrs.update(notes)
    with pytest.raises(InvalidInputError) as caught:
        restore(tmp_path / "run.h5")
    assert str(caught.value).count("is damaged: ") == 1
    assert str(caught.value).endswith(".")
