"""``stiction replay`` and ``stiction export``: what they print, what they write, and how they end."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import pytest

import stiction as st
from stiction.record.input_numbers import InputNumbers, decode_numbers

from .support import call


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """Two boxes, one pushed at 0.5 s."""
    path = tmp_path / "run.h5"
    world = st.World()
    world.add(st.Plane(), static=True)
    for k in range(2):
        world.add(st.Box((1, 1, 1)), position=(2 * k, 0, 0.5), name=f"box {k}")
    with world.record(path, title="two boxes", meta={"seed": 7}):
        world.step(30)
        world["box 1"].apply_impulse((3000, 0, 0))
        world.step(30)
    return path


def spoil(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        rows, stored = file["inputs/rows"][:], file["inputs/numbers"]
        numbers = decode_numbers(rows, stored[:])
        numbers[0] = 1.0
        stored[:] = InputNumbers().encode(rows, numbers)


def test_a_recording_that_was_run_with_a_scene_is_the_same_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = str(tmp_path / "run.h5")
    options = ("--set", "duration=0.4", "--record-contacts", "--record-full")
    assert call(monkeypatch, "run", "push-and-release", "--record", path, *options) == 0
    assert call(monkeypatch, "replay", path, "--check") == 0
    assert "same: steps 0 to 80 (0 to 0.4 s) end in the very bits" in capsys.readouterr().out
    assert call(monkeypatch, "replay", path) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "full precision" in told and "kept" in told and "complete" in told


def test_a_recording_tells_what_it_holds(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "replay", str(record)) == 0
    told = capsys.readouterr()
    assert "two boxes" in told.out and "0 to 1 s in 60 steps" in told.out and "seed" in told.out
    assert "--check" in told.err
    assert call(monkeypatch, "replay", str(record), "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["steps"], facts["bodies"], facts["inputs"], facts["outcome"]) == (60, 3, 2, "closed")
    assert facts["bytes"] == record.stat().st_size and facts["meta"] == {"seed": 7}


def test_a_difference_ends_with_status_1_and_names_step_and_body(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil(record)
    assert call(monkeypatch, "replay", str(record), "--check") == 1
    told = capsys.readouterr().out
    assert "step 31 (0.516667 s) is the first that differs" in told
    assert "First seen after step 32" in told and "box 1" in told and "box 0" not in told
    assert call(monkeypatch, "replay", str(record), "--check", "--json") == 1
    result = json.loads(capsys.readouterr().out)
    assert (result["same"], result["differs_at"], result["bodies"][0]["name"]) == (False, 31, "box 1")
    assert result["bodies"][0]["velocity"] == pytest.approx(2.0, rel=0.1)  # it got 3 m/s, and 1 m/s now
    assert call(monkeypatch, "replay", str(record), "--check", "--to", "0.5") == 0


def test_what_cannot_be_replayed_is_bad_input(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    text = tmp_path / "notes.txt"
    text.write_text("no recording")
    wrong = {
        "it is no HDF5 file": ("replay", str(text), "--check"),
        "--from must be 0 to 1 s, the time of the recording, got 2.0": ("replay", str(record), "--from", "2"),
        "OUT must end in .glb, .parquet, .nc": ("export", str(record), str(tmp_path / "x.stl")),
        "must be a file that exists": ("export", str(tmp_path / "none.h5"), str(tmp_path / "x.glb")),
    }
    for sentence, arguments in wrong.items():
        assert call(monkeypatch, *arguments) == 2
        assert sentence in capsys.readouterr().err
    assert not (tmp_path / "x.glb").exists()


def test_an_animation_is_exported(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "new" / "run.glb"
    assert call(monkeypatch, "export", str(record), str(out), "--from", "0.5") == 0
    assert out.read_bytes().startswith(b"glTF")
    assert str(out) in capsys.readouterr().err
