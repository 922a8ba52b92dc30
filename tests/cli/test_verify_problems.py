"""``stiction verify --fclib`` as a user gives it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from stiction.problems import ContactProblem
from stiction.verify import problems

from .support import call


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    ContactProblem(np.diag([1.0, 1.0, 4.0]), [-1.0, 1.0, 1.0], 0.2).write(tmp_path / "first.hdf5")
    ContactProblem(np.eye(6), [-1.0, 1, 0, -2, 0, 0], [0.1, 0.7]).write(tmp_path / "second.dat")
    return tmp_path


def test_a_folder_becomes_a_table(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "bad.dat").write_text("3 1")
    assert call(monkeypatch, "verify", "--fclib", str(folder)) == 0
    printed = capsys.readouterr()
    for word in ("first", "second", "2 contacts", "mu 0.1 to 0.7", "secular", "clamp", "default", "converged"):
        assert word in printed.out
    assert "2 converged, 0 missed, 1 skipped" in printed.out
    assert "first …" in printed.err and "skipped:" in printed.err and "bad.dat is cut short" in printed.err


def test_as_json_it_is_json_and_nothing_else(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "bad.dat").write_text("3 1")
    assert call(monkeypatch, "verify", "--fclib", str(folder), "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert [row["problem"] for row in result["problems"]] == ["first", "second"]
    assert result["problems"][0]["errors"]["clamp"]["1000"] > 1e-2
    assert result["problems"][0]["error"] <= 1e-6 == result["tolerance"]
    assert [row["file"] for row in result["skipped"]] == ["bad.dat"] and result["interrupted"] is False


def test_a_miss_is_exit_status_1(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    limits = ("--tolerance", "1e-300", "--sweeps", "0", "--seconds", "1e-9")
    assert call(monkeypatch, "verify", "--fclib", str(folder), *limits) == 1
    assert "0 converged, 2 missed" in capsys.readouterr().out


def test_ctrl_c_keeps_what_is_done(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*arguments: object, **options: object) -> problems.ProblemResult:
        if arguments[1] == "second":
            raise KeyboardInterrupt
        return whole(*arguments, **options)  # type: ignore[arg-type]  # passed on

    whole = problems.measure
    monkeypatch.setattr(problems, "measure", interrupted)
    assert call(monkeypatch, "verify", "--fclib", str(folder)) == 130
    printed = capsys.readouterr()
    assert "first" in printed.out and "1 converged, 0 missed, 1 not measured" in printed.out
    assert "interrupted" in printed.err


BAD_CALLS = [
    (("--fclib", "no-such-folder"), "--fclib must be a folder, got 'no-such-folder'"),
    (("--fclib", ".", "ladder"), "name no cases"),
    (("--fclib", ".", "--list"), "--list"),
    (("--fclib", ".", "--solver", "micro"), "--solver"),
]


@pytest.mark.parametrize(("arguments", "says"), BAD_CALLS, ids=str)
def test_bad_calls_are_one_sentence(
    arguments: tuple[str, ...], says: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "verify", *arguments) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--tolerance", "--seconds"])
def test_limits_must_be_positive(
    option: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "verify", "--fclib", str(folder), option, "0") == 2
    assert f"{option[2:]} must be above 0" in capsys.readouterr().err
