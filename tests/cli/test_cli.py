"""The commands as a user gives them: what they print, what they write, and how they end."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stiction import InvalidInputError, Recording
from stiction.problems import ContactProblem
from stiction.record.hdf5 import load_frames

from .support import call


def test_run_prints_a_table_and_writes_what_was_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """In a folder that is not there yet."""
    out = tmp_path / "new"
    files = ("--html", str(out / "a.html"), "--plot", str(out / "a.png"), "--record", str(out / "a.h5"))
    assert call(monkeypatch, "run", "ball", *files) == 0
    printed = capsys.readouterr()
    assert "rolling" in printed.out and re.search(r"2\.(4999|5000)", printed.out)
    assert "the ledger closes" in " ".join(printed.out.split())
    for name in ("a.html", "a.png", "a.h5"):
        assert (out / name).stat().st_size > 10_000
        assert name in printed.err
    assert len(load_frames(out / "a.h5")) > 50


def test_run_as_json_is_json_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "run", "ball", "--json", "--set", "bodies.ball.velocity=[2.8,0,0]") == 0
    result = json.loads(capsys.readouterr().out)
    (ball,) = result["bodies"]
    assert ball["speed"] == pytest.approx(2.0, rel=1e-4)
    assert ball["motion"] == "rolling"
    assert abs(result["energy"]["residual"]) < 1e-9
    assert len(result["state_hash"]) == 32


def test_run_exports_the_contact_problem_of_the_step_that_would_come(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "new" / "a.hdf5"
    options = ("--seconds", "0.1", "--json", "--export-problem", str(file))
    assert call(monkeypatch, "run", "push-and-release", *options) == 0
    assert json.loads(capsys.readouterr().out)["time"] == pytest.approx(0.1)
    assert ContactProblem.read(file).contacts == 12
    assert call(monkeypatch, "run", "ball", "--export-problem", str(tmp_path / "a.csv")) == 2
    assert "--export-problem must end in .hdf5" in capsys.readouterr().err


def test_seconds_replace_the_scenes_own_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "run", "ball", "--json", "--seconds", "0.5") == 0
    assert json.loads(capsys.readouterr().out)["time"] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run", "rmap"), "(did you mean 'ramp'?)"),
        (("run", "ball", "--set", "world.dtt=1"), "(did you mean 'dt'?)"),
        (("run", "ball", "--seconds", "-1"), "duration"),
        (("run", "ball", "--plot", "a.exe"), "--plot must end in one of"),
        (("run", "ball", "--html", "/proc/none/a.html"), "--html must be a file that can be written"),
        (("run", "ball", "--record", "/proc/none/a.h5"), "--record must be a file that can be written"),
        (("materials", "rubbr", "concrete"), "(did you mean 'rubber'?)"),
        (("materials", "rubber"), "named in pairs"),
        (("materials", "--table", "lectur"), "(did you mean 'lecture'?)"),
        (("scenes", "nothing like it"), "one of"),
        (("verify", "free-fal"), "(did you mean 'free-fall'?)"),
        (("verify", "--dt", "0"), "dt must be above 0 s"),
        (("verify", "--solver", "exakt"), "(did you mean 'exact'?)"),
    ],
)
def test_bad_input_ends_with_one_sentence_before_anything_runs(
    arguments: tuple[str, ...],
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("stiction.store.Store.step", lambda *_: pytest.fail("something ran"))
    assert call(monkeypatch, *arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("stiction: error: ") and printed.err.count("\n") == 1
    assert sentence in printed.err


def test_a_toml_error_names_its_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scene = tmp_path / "bad.toml"
    scene.write_text('title = "x"\n[world\n')
    assert call(monkeypatch, "run", str(scene)) == 2
    assert "bad.toml, line 2" in capsys.readouterr().err


def test_a_blow_up_ends_with_status_3_and_keeps_the_recording(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    record = tmp_path / "run.h5"
    arguments = ("run", "ball", "--set", "world.gravity=[0,0,1e160]", "--record", str(record))
    assert call(monkeypatch, *arguments) == 3
    assert "is no longer finite" in capsys.readouterr().err
    assert len(load_frames(record)) >= 1


def _frames_so_far(record: Path) -> int:
    """Of a recording that is being written; none as long as it cannot be opened yet."""
    try:
        with Recording.open(record) as recording:
            return len(recording)
    except InvalidInputError:
        return 0


def test_ctrl_c_leaves_a_recording_that_opens(tmp_path: Path) -> None:
    record = tmp_path / "run.h5"
    command = [
        sys.executable,
        "-m",
        "stiction.cli.main",
        "run",
        "push-and-release",
        "--seconds",
        "6000",
        "--record",
        str(record),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 120.0
        while time.monotonic() < deadline and not (record.exists() and _frames_so_far(record) > 10):
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted at " in errors and str(record) in errors
    assert len(load_frames(record)) > 10


def test_scenes_lists_and_prints_them(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "scenes") == 0
    listed = capsys.readouterr().out
    for name in ("ramp", "push-and-release", "ball", "billiards", "pyramid", "dominoes", "conveyor"):
        assert name in listed
    assert call(monkeypatch, "scenes", "ramp") == 0
    assert "[[bodies]]" in capsys.readouterr().out
    assert call(monkeypatch, "scenes", "--schema") == 0
    assert "properties" in json.loads(capsys.readouterr().out)


def test_materials_names_the_source(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "materials", "concrete", "rubber", "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["static"], row["dynamic"]) == (1.0, 0.8)
    assert "Some coefficients" in row["source"]
    assert call(monkeypatch, "materials", "--table", "lecture", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)) == 10  # the nine rows of the slides, and the default


def test_verify_asks_other_engines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    page, words = tmp_path / "a.html", tmp_path / "a.md"
    given = ("verify", "slide-to-roll", "--against", "none", "--html", str(page), "--markdown", str(words))
    assert call(monkeypatch, *given) == 0
    assert "1 of 1" in capsys.readouterr().out
    assert "slide-to-roll" in page.read_text(encoding="utf-8")
    assert "slide-to-roll" in words.read_text(encoding="utf-8")
    assert call(monkeypatch, "verify", "--against", "none", "--list") == 0
    assert "balls-on-a-box" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--plot", "a.png"), "go with --against"),
        (("--against", "mujoko"), "did you mean 'mujoco'"),
        (("slide-to-rol", "--against", "none"), "did you mean 'slide-to-roll'"),
        (("--against", "none", "--html", "/no/such/folder/a.html"), "--html"),
    ],
)
def test_verify_against_says_what_is_wrong(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], given: tuple[str, ...], message: str
) -> None:
    assert call(monkeypatch, "verify", *given) == 2
    assert message in capsys.readouterr().err


def test_verify_prints_what_it_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "verify", "free-fall", "spin-down-of-a-face", "--solver", "micro", "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    keys = {"case", "formula", "expected", "measured", "error", "tolerance", "passed", "solver"}
    assert all(keys <= set(row) for row in rows)
    assert {row["passed"] for row in rows if row["case"] == "free-fall"} == {True}
    assert {row["passed"] for row in rows if row["case"] == "spin-down-of-a-face"} == {False}, "a known limit"
    assert call(monkeypatch, "verify", "free-fall") == 0
    assert "5 passed, 0 failed" in capsys.readouterr().out


def test_warmup_says_where_the_kernels_are(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "warmup") == 0
    assert "kernels ready in" in capsys.readouterr().out


def test_version(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--version") == 0
    assert capsys.readouterr().out.startswith("stiction 0.")
