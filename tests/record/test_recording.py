"""Recordings in parts: bodies, times, contacts; while they are written, after a kill, and those of earlier versions."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError, OutputError
from stiction.record.file_writer import FileWriter
from stiction.record.hdf5 import load_frames, restore
from stiction.record.packed import PackedRows
from stiction.record.recorder import Recorder

from .worlds import tower

PAGE = Path(__file__).parents[2] / "docs" / "recordings.md"
VERSION_1 = Path(__file__).parent / "data" / "version-1.h5"
"""The first 0.2 s of push-and-release, every fifth step, as version 1 wrote them."""
VERSION_1_END = "push-and-release", ["duration=0.2"]
VERSION_2 = VERSION_1.with_name("version-2.h5")
"""40 steps of a ball that lands on a crate, every fifth step, with contacts, as version 2 wrote them; after 20 steps
the crate is pushed, and another one comes."""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """100 steps, every fifth one a frame; one body comes at step 30, another goes at step 60."""
    path = tmp_path_factory.mktemp("recording") / "run.h5"
    world = tower()
    with world.record(path, every=5, contacts=True, title="a tower", precision="full"):
        world.step(30)
        world.add(st.Sphere(0.3), position=(5, 5, 3), name="late")
        world.step(30)
        world.remove(world["box 1"])
        world.step(40)
    return path


def test_parts_of_a_recording_are_those_of_the_whole(path: Path) -> None:
    with st.Recording.open(path) as recording:
        frames = recording.frames()
        assert [body.name for body in recording.bodies] == ["plane 0", "box 1", "box 2", "box 3", "box 4", "late"]
        assert recording.times.tolist() == pytest.approx([k / 12 for k in range(21)])
        assert len(recording) == len(frames) == 21
        for name in ("positions", "orientations", "velocities", "angular_velocities"):
            read, whole = getattr(recording, name), getattr(frames, name)
            np.testing.assert_array_equal(read(), whole)
            np.testing.assert_array_equal(read("box 3"), whole[:, 3])
            np.testing.assert_array_equal(read(3), whole[:, 3])
            np.testing.assert_array_equal(read(start=0.5), whole[6:])
            np.testing.assert_array_equal(read("late", 0.5, 0.75), whole[6:10, 5])
            assert read(stop=-1.0).shape[0] == 0
        part = recording.frames(0.5, 0.75)
        np.testing.assert_array_equal(part.positions, frames.positions[6:10])
        for k in range(4):
            np.testing.assert_array_equal(part.contacts_of(k), frames.contacts_of(6 + k))


def test_where_a_body_is_not_there_frames_have_no_numbers(path: Path) -> None:
    with st.Recording.open(path) as recording:
        there = np.isfinite(recording.positions()).all(axis=2)
    # the step at which a body comes or goes was noted before it did
    assert there[:, 5].tolist() == [False] * 7 + [True] * 14
    assert there[:, 1].tolist() == [True] * 13 + [False] * 8
    assert there[:, [0, 2, 3, 4]].all()


def test_contacts_are_read_at_frames_and_found_again_between_them(path: Path) -> None:
    world = tower()
    world.step(20)
    with st.Recording.open(path) as recording:
        np.testing.assert_array_equal(recording.contacts(20), world.contacts())
        world.step(3)
        np.testing.assert_array_equal(recording.contacts(23), world.contacts())
        after = recording.contacts(99)
        assert 1 not in after["body_b"] and after["body_b"].max() >= 4, "bodies go by their place in the recording"
        with pytest.raises(InvalidInputError, match=r"^step must be 0 to 100, the steps of the recording, got 101\.$"):
            recording.contacts(101)


def test_energies_are_those_of_the_world(tmp_path: Path) -> None:
    world = tower()
    expected = [world.energy()]
    with world.record(tmp_path / "run.h5", every=10):
        for _ in range(4):
            world.step(10)
            expected.append(world.energy())
    with st.Recording.open(tmp_path / "run.h5") as recording:
        rows = recording.energies
        assert [st.Energy(*row) for row in rows.tolist()] == expected
        assert rows.dtype.names == st.Energy._fields
        assert len(recording.hashes) == 41


def test_energies_follow_what_changes_on_the_way(tmp_path: Path) -> None:
    world, expected = tower(), []
    crate = world.bodies[2]

    def turn() -> None:
        world.velocities[3, 0] += 1.0
        world.step(5)
        expected.append(world.energy())

    with world.record(tmp_path / "run.h5", every=5):
        changes = [
            lambda: None, lambda: setattr(crate, "mass", 5.0), lambda: setattr(crate, "inertia", 7.0 * crate.inertia),
            lambda: world.add(st.Box((1, 1, 1)), position=(5, 0, 3), angular_velocity=(1, 2, 3)),
            lambda: setattr(world, "gravity", (1.0, 0.0, -5.0)), lambda: world.remove(world.bodies[1]),
        ]  # fmt: skip
        for change in changes:
            change()
            turn()
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert [st.Energy(*row) for row in recording.energies.tolist()][1:] == expected
        assert len({row.kinetic for row in expected}) == len(changes)
        assert recording.check().same


def test_a_body_or_time_that_is_not_there_is_refused(path: Path) -> None:
    with st.Recording.open(path) as recording:
        with pytest.raises(InvalidInputError, match=r"^no body is called 'box 33' \(did you mean 'box 3'\?\)\.$"):
            recording.positions("box 33")
        with pytest.raises(InvalidInputError, match=r"^body must be a name or 0 to 5, got 6\.$"):
            recording.positions(6)
        with pytest.raises(InvalidInputError, match=r"^start must be a finite number"):
            recording.positions(start=float("nan"))
        assert "a tower" in repr(recording)
    recording.close()  # again


def test_a_recording_is_read_while_it_is_written(tmp_path: Path) -> None:
    world = tower()
    with world.record(tmp_path / "run.h5", every=2) as writer, st.Recording.open(tmp_path / "run.h5") as reader:
        assert (len(reader), reader.outcome) == (1, "not closed")
        world.step(20)
        world.add(st.Sphere(0.3), position=(5, 5, 3), name="late")
        world.step(20)
        writer.flush()
        assert len(reader) == 1, "what was read stays as it is until it is asked for"
        reader.refresh()
        assert (len(reader), reader.last_step, reader.bodies[-1].name) == (21, 40, "late")
        np.testing.assert_allclose(reader.positions("box 2")[-1], world["box 2"].position, rtol=1e-6, atol=1e-30)
        assert reader.check().same


def test_a_place_in_a_tail_that_is_used_again_while_it_is_read_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world, real, late = tower(2), PackedRows.keep, [True]
    with world.record(tmp_path / "run.h5", every=1) as writer:
        world.step(59)
        writer.flush()

        def keep(packed: PackedRows, length: int) -> None:
            if late.pop() if late else False:  # between the lengths and the rows that belong to them
                world.step(100)
                writer.flush()
            real(packed, length)

        monkeypatch.setattr(PackedRows, "keep", keep)
        with st.Recording.open(tmp_path / "run.h5") as reader:
            assert not late and len(reader) == 160 and len(reader) % 64 != 60 % 64
            seen = reader.positions()
    with st.Recording.open(tmp_path / "run.h5") as recording:
        np.testing.assert_array_equal(recording.positions(), seen)


def with_worlds(folder: Path) -> dict[str, str]:
    """The environment of a program that imports this project and, as ``tests_worlds``, worlds.py beside this file."""
    (folder / "tests_worlds.py").write_text((Path(__file__).parent / "worlds.py").read_text())
    folders = [str(folder), str(Path(st.__file__).parents[1])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}


KILLED = """
import sys
from tests_worlds import tower
world = tower()
with world.record(sys.argv[1], every=2) as writer:
    world.step(100)
    writer.flush()
    print(world.steps, flush=True)
    while True:  # until it is killed, somewhere
        world.step()
        if world.steps == 150:
            world["box 4"].velocity = (0, 0, 5)
        if world.steps % 7 == 0:
            writer.flush()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="only there can a process be killed without a word")
def test_after_a_kill_all_that_was_flushed_opens_and_its_hashes_hold(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    command = [sys.executable, "-c", KILLED, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=with_worlds(tmp_path)) as process:
        assert process.stdout is not None
        flushed = int(process.stdout.readline())
        seen = []
        with st.Recording.open(path) as recording:
            while recording.last_step < 700:  # while it is being written
                time.sleep(0.01)
                recording.refresh()
                seen.append(recording.positions())
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert process.returncode == -signal.SIGKILL
    with st.Recording.open(path) as recording:
        assert recording.last_step >= 700 > flushed == 100
        assert recording.outcome == "not closed"
        assert np.isfinite(recording.positions()).all()
        whole = recording.positions()
        assert len(whole) > 300
        for part in seen:
            np.testing.assert_array_equal(part, whole[: len(part)])
        assert recording.check(stop=400 / 60).same
        assert recording.check(start=(recording.last_step - 5) / 60).same
    size = path.stat().st_size
    cut = tmp_path / "cut.h5"
    cut.write_bytes(path.read_bytes()[: size // 2])
    with pytest.raises(InvalidInputError, match=r"cut\.h5' cannot be opened: it is cut off, .*\.$"):
        st.Recording.open(cut)


KILLS_ITSELF = """
import os, signal, sys
from tests_worlds import tower
world = tower()
writer = world.record(sys.argv[1], every=2, contacts=True)
for _ in range(5):
    world.step(37)
    world["box 4"].velocity = (0, 0, 1)
    writer.flush()
world.step()
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="only there can a process be killed without a word")
def test_frames_that_fill_no_piece_outlive_their_process(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    done = subprocess.run([sys.executable, "-c", KILLS_ITSELF, str(path)], env=with_worlds(tmp_path), check=False)
    assert done.returncode == -signal.SIGKILL
    world, expected = tower(), []
    for step in range(186):
        if step and step % 37 == 0:
            world["box 4"].velocity = (0, 0, 1)
        if step % 2 == 0:
            expected.append(world.positions.copy())
        world.step()
    with st.Recording.open(path) as recording:
        assert (len(recording), recording.last_step, recording.outcome) == (93, 185, "not closed")
        assert len(recording) % 64 > 0, "or nothing would be left over"
        np.testing.assert_allclose(recording.positions(), expected, rtol=6e-8, atol=1e-30)
        assert recording.frames().motion.shape == (93, 5)
        assert recording.check().same


def test_a_disk_that_takes_no_more_is_told_in_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    world = tower()
    writer = world.record(tmp_path / "run.h5")
    world.step(10)
    monkeypatch.setattr(FileWriter, "process", lambda *_: (_ for _ in ()).throw(OutputError("the disk is full.")))
    with pytest.raises(OutputError, match="the disk is full"):
        writer.flush()
    with pytest.raises(OutputError, match="the disk is full"):
        writer.close()
    world.step()
    monkeypatch.undo()
    with world.record(tmp_path / "other.h5"):
        world.step()
    with st.Recording.open(tmp_path / "run.h5") as recording:
        assert len(recording) == 1


def undone(dataset: h5py.Dataset) -> list[list[list[float]]]:
    """An array of frames as docs/recordings.md tells to read it, word by word, with whole numbers of Python."""
    kind, order = np.dtype(dataset.attrs["type"]), int(dataset.attrs["differences"])
    bits, rows, stored = 8 * kind.itemsize, dataset.chunks[0], dataset[:].tolist()
    whole, top = 1 << bits, 1 << (bits - 1)
    start = {"f4": 0x7FC00000, "f2": 0x7E00, "f8": 0x7FF8000000000000, "i2": 0}[kind.str[1:]]

    def number(code: int) -> float:
        signed = code - whole if code >= top else code
        if kind.kind == "i":
            return signed
        pattern = signed if signed >= 0 else signed ^ (top - 1)
        return float(np.array(pattern % whole, f"u{kind.itemsize}").view(kind))

    result = np.zeros(dataset.shape).tolist()
    for body in range(dataset.shape[1]):
        for axis in range(dataset.shape[2]):
            for k in range(len(stored)):
                folded = stored[k][body][axis]
                difference = folded // 2 if folded % 2 == 0 else -(folded + 1) // 2
                if k % rows == 0:
                    code, step = start + difference, 0
                else:
                    step = difference if order == 1 else step + difference
                    code += step
                code %= whole
                result[k][body][axis] = number(code)
    return result


@pytest.mark.parametrize("precision", ["display", "full"])
def test_the_page_on_recordings_tells_how_to_read_the_frames(precision: str, tmp_path: Path) -> None:
    world = tower(2)
    with world.record(tmp_path / "run.h5", every=1, precision=precision):
        world.step(40)
        world.add(st.Sphere(0.3), position=(-5, 5, 3))
        world.step(70)  # 111 frames: one piece and a part of one
    with st.Recording.open(tmp_path / "run.h5") as recording, h5py.File(tmp_path / "run.h5") as file:
        for name in ("positions", "orientations", "velocities", "angular_velocities"):
            np.testing.assert_array_equal(undone(file[f"frames/{name}"]), recording.stored(name, slice(0, 111)))
        if precision == "display":
            block = re.search(r"```python\n(import numpy as np\n\ndef undone.*?)```", PAGE.read_text(), re.DOTALL)
            assert block is not None
            names: dict[str, Any] = {}
            exec(block[1], names)  # the page's own function
            stored = file["frames/positions"][:]
            np.testing.assert_array_equal(names["undone"](stored[:64]), recording.stored("positions", slice(0, 64)))
            np.testing.assert_array_equal(names["undone"](stored[64:]), recording.stored("positions", slice(64, 111)))
        assert np.isnan(recording.positions(3)[:41]).all() and np.isfinite(recording.positions(3)[41:]).all()
        assert recording.frame_steps.tolist() == list(range(111))


# --- earlier versions -------------------------------------------------------------------------------------------------


def test_a_recording_of_version_2_still_opens(tmp_path: Path) -> None:
    """Its snapshots fit the engine of its time alone: what is asked here is that everything else is read as before."""
    with st.Recording.open(VERSION_2) as recording, h5py.File(VERSION_2) as file:
        assert (recording.format_version, recording.last_step, recording.precision) == (2, 40, "display")
        assert [body.name for body in recording.bodies] == ["plane 0", "crate", "ball", "late"]
        frames = recording.frames()
        assert frames.positions.shape == (9, 4, 3)
        for name in ("positions", "velocities", "angular_velocities"):
            np.testing.assert_array_equal(getattr(frames, name), file[f"frames/{name}"][:].astype(np.float64))
        np.testing.assert_array_equal(recording.positions("ball", 0.25, 0.5), frames.positions[3:7, 2])
        np.testing.assert_allclose(np.linalg.norm(frames.orientations[:, :3], axis=2), 1.0, rtol=1e-12)
        assert np.isfinite(recording.positions("late")).all(axis=1).tolist() == [False] * 5 + [True] * 4
        np.testing.assert_array_equal(frames.motion, file["frames/motion"][:, :, 0])
        assert len(recording.contacts(40)) == file["frames/contact_ends"][8] - file["frames/contact_ends"][7] > 0
        push, *_, added = recording.inputs()
        assert (push.step, push.what, push.numbers.tolist()) == (20, "force", [2000.0, 0.0, 0.0])
        assert added.text is not None and added.text["body"]["name"] == "late"
        assert len(recording.hashes) == 41 and recording.checkpoint_steps.tolist() == [0]
        recording.export(tmp_path / "ball.glb")


def test_a_recording_of_version_1_still_opens() -> None:
    from stiction.scene import Simulation, load

    simulation = Simulation(load(*VERSION_1_END))
    recorder = Recorder(simulation.world, simulation.scene.title, every=5)
    recorder.capture()
    while not simulation.done:
        simulation.advance()
        recorder.capture()
    memory, file = recorder.frames(), load_frames(VERSION_1)
    assert (file.title, file.dt, file.bodies) == (memory.title, memory.dt, memory.bodies)
    np.testing.assert_array_equal(file.times, memory.times)
    np.testing.assert_allclose(file.positions, memory.positions, atol=1e-3)
    np.testing.assert_array_equal(file.motion, memory.motion)
    assert file.meta["outcome"] == "complete"
    with st.Recording.open(VERSION_1) as recording:
        assert (recording.format_version, recording.last_step, recording.precision) == (1, 40, "full")
        np.testing.assert_array_equal(recording.positions(2), file.positions[:, 2])
        np.testing.assert_array_equal(recording.contacts(20), file.contacts_of(4))
        assert recording.world(20).steps == 20
        with pytest.raises(InvalidInputError, match="has no energies, for it is of format version 1"):
            _ = recording.energies
    assert restore(VERSION_1).world.positions.tolist() == file.positions[0].tolist()


def test_a_recording_of_version_1_can_be_compared_frame_by_frame(tmp_path: Path) -> None:
    """Whether its physics is still ours is not the question here, so the frames are made by what runs now."""
    path = tmp_path / "run.h5"
    path.write_bytes(VERSION_1.read_bytes())
    simulation = restore(path)
    with h5py.File(path, "r+") as file:
        for k in range(9):
            for name in ("positions", "orientations", "velocities", "angular_velocities"):
                file[f"frames/{name}"][k] = getattr(simulation.world, name)
            if k < 8:
                simulation.advance(5)
    with st.Recording.open(path) as recording:
        result = recording.check()
        assert result.same
        assert "frames were compared" in result.notes[0]
    with h5py.File(path, "r+") as file:
        file["frames/positions"][6, 2, 0] += 0.5
    with st.Recording.open(path) as recording:
        result = recording.check()
        assert (result.differs_at, result.bodies[0].name) == (30, recording.bodies[2].name)
        assert result.bodies[0].position == pytest.approx(0.5)


def test_solver_and_substeps_stay_while_a_world_is_recorded(tmp_path: Path) -> None:
    world = st.World()
    world.add(st.Sphere(0.5), position=(0, 0, 3))
    with world.record(tmp_path / "ball.h5"):
        with pytest.raises(st.InvalidInputError, match="substeps must not change while the world is being recorded"):
            world.substeps = 4
        with pytest.raises(st.InvalidInputError, match="solver must not change while the world is being recorded"):
            world.set_solver("micro")
        world.step()
    assert world.substeps == st.World().substeps
    world.substeps = 4
    assert world.substeps == 4
