"""``stiction fit`` as a user gives it: table, JSON, figure, and sentences for what is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .support import call as call_command

SCENE = """
title = "A crate that slides"
expect = "It slides and stops."
duration = 0.5
materials = { base = "empty", pairs = [{ a = "a", b = "b", static = 0.4, dynamic = 0.3 }] }
bodies = [
    { name = "floor", shape = { type = "plane" }, static = true, material = "a" },
    { name = "crate", shape = { type = "box", size = [1, 1, 0.5] }, material = "b", position = [0, 0, 0.25] },
]
"""
KEY = "materials.pairs.a-b.dynamic"


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Exit status of ``stiction fit ARGUMENTS``, run in this process."""
    return call_command(monkeypatch, "fit", *arguments)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene and its data: v t - mu g t^2 / 2 with mu = 0.25, to the tenth of a millimetre."""
    (tmp_path / "crate.toml").write_text(SCENE)
    times = [0.05 * k for k in range(10)]
    rows = [f"{t:.2f},{2 * t - 0.125 * 9.81 * t * t:.4f}" for t in times]
    (tmp_path / "slide.csv").write_text("\n".join(["# by hand", "t,x", *rows]))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.filterwarnings("ignore")  # the command shows warnings in its own way
def test_a_fit_prints_values_with_intervals_and_draws(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    thrown = ("--set", "bodies.crate.velocity=[2, 0, 0]")
    arguments = ("slide.csv", "crate.toml", *thrown, "--free", f"{KEY}=0.1:0.5", "--starts", "1")
    assert call(monkeypatch, *arguments, "--plot", "new/left.png") == 0
    printed = capsys.readouterr()
    for words in ("a-b.dynamic", "90 % interval", "10 numbers", "root mean square"):
        assert words in printed.out
    assert (here / "new" / "left.png").stat().st_size > 10_000

    assert call(monkeypatch, *arguments, "--json") == 0
    result = json.loads(capsys.readouterr().out)
    (found,) = result["parameters"]
    assert found["value"] == pytest.approx(0.25, rel=1e-3) and found["keys"] == [KEY]
    assert found["low"] < found["value"] < found["high"] and found["seen"]
    assert result["rms_position_m"] < 1e-4 and result["rms_angle_rad"] is None


def test_help_has_examples_and_units(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--help") == 0
    printed = capsys.readouterr().out
    assert "stiction fit pull.csv pull" in printed and "time in s" in printed and "position in m" in printed


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("none.csv", "crate.toml", "--free", KEY), "data file must exist, got 'none.csv'."),
        (("slide.csv", "crate.toml"), "--free must name at least one key"),
        (("slide.csv", "crate.toml", "--free", "materials.pairs.a-b.dinamic"), "(did you mean 'dynamic'?)"),
        (("slide.csv", "crate.toml", "--free", KEY, "--loss", "l1"), "--loss must be one of linear, soft_l1"),
        (("slide.csv", "crate.toml", "--free", KEY, "--starts", "0"), "--starts must be 1 or more, got 0."),
        (("slide.csv", "crate.toml", "--free", KEY, "--plot", "left.xyz"), "--plot must end in one of "),
        (("slide.csv", "crate.toml", "--free", KEY, "--set", "duration=0.2"), "data must end with the scene"),
        (("slide.csv", "crate.toml", "--free", KEY, "--sigma-mm", "0"), "sigma must be above 0 m, got 0.0."),
    ],
)
@pytest.mark.usefixtures("here")
def test_what_is_wrong_is_said_in_one_sentence(
    arguments: tuple[str, ...], sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, *arguments) == 2
    assert sentence in capsys.readouterr().err
