"""``stiction check``, ``new`` and ``info``."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from stiction import __version__
from stiction.cli import info, kernels
from stiction.cli.new import starter_text
from stiction.scene import Simulation, builtin_names, load
from stiction.scene.check import check_scene

from .support import call

ROOT = Path(__file__).parents[2]
BAD = 'title = "t"\nexpect = "e."\nduration = -1\n[world]\ngravty = [0, 0, 0]\n'


def test_check_shows_line_and_marker_and_fails(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(BAD)
    assert call(monkeypatch, "check", str(file)) == 1
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert lines[0].endswith("bad.toml:3:12")
    assert lines[1] == "    3 │ duration = -1"
    assert lines[2] == "      │            ^^"
    assert "did you mean 'gravity'" in shown and "2 mistakes" in shown


def test_what_the_page_of_commands_shows_is_what_check_says(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    (body,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (said,) = re.findall(r"^```text\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    monkeypatch.chdir(tmp_path)
    Path("my_scene.toml").write_text(f'title = "t"\nexpect = "e."\nduration = 1\n\n{body}')
    assert call(monkeypatch, "check", "my_scene.toml") == 1
    assert capsys.readouterr().out == said


def test_check_as_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(BAD)
    assert call(monkeypatch, "check", str(file), "ball", "--json") == 1
    bad, ball = json.loads(capsys.readouterr().out)
    assert ball == {"file": "ball", "findings": []}
    assert [(one["line"], one["column"], one["path"], one["severity"]) for one in bad["findings"]] == [
        (3, 12, "duration", "error"),
        (5, 1, "world.gravty", "error"),
    ]
    assert bad["findings"][1]["suggestion"] == "gravity"


def test_warnings_fail_only_where_they_are_asked_to(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "odd.toml"
    file.write_text('title = "t"\nexpect = "e."\nduration = 1\n')
    assert call(monkeypatch, "check", str(file)) == 0
    assert "1 warning." in capsys.readouterr().out
    assert call(monkeypatch, "check", str(file), "--strict") == 1
    assert "has no bodies" in capsys.readouterr().out


def test_run_points_at_check(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(BAD)
    assert call(monkeypatch, "run", str(file)) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"stiction: error: {file}, line ")
    assert second == f"stiction: all mistakes of the file: stiction check {file}"


def test_a_file_that_is_not_there_is_bad_input(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, "check", "nowhere.toml") == 2
    assert call(monkeypatch, "check", "rmap") == 2
    assert "did you mean 'ramp'" in capsys.readouterr().err


def test_the_starter_is_written_checked_and_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "deep" / "my_scene.toml"
    assert call(monkeypatch, "new", str(file)) == 0
    assert f"stiction check {file}" in capsys.readouterr().err
    assert call(monkeypatch, "check", "--strict", str(file)) == 0
    capsys.readouterr()
    assert call(monkeypatch, "run", str(file), "--json") == 0
    result = json.loads(capsys.readouterr().out)
    first, second = result["bodies"]
    assert first["displacement"] < 1e-6
    # pushed for t = 0.5 s: a = F / m - mu_d g, then braked with mu_d g
    push, load_, t = 120.0 / 20.0, 0.4 * 9.81, 0.5
    speed = (push - load_) * t
    assert second["displacement"] == pytest.approx(0.5 * speed * t + speed**2 / (2.0 * load_), rel=0.02)
    assert second["speed"] < 1e-6


def test_the_starter_shows_every_section_and_has_a_pair_with_two_coefficients() -> None:
    data = tomllib.loads(starter_text())
    assert set(data) >= {"title", "expect", "duration", "world", "materials", "bodies", "pushes"}
    (pair,) = data["materials"]["pairs"]
    assert pair["static"] > pair["dynamic"] > 0.0
    assert max(map(len, starter_text().splitlines())) <= 100


def test_what_the_starter_has_in_comments_can_be_used() -> None:
    """Every commented key is a key, and every commented value is allowed, one at a time."""
    lines = starter_text().splitlines()
    tried = 0
    for number, line in enumerate(lines):
        bare = line.removeprefix("# ")
        if not line.startswith("# ") or " = " not in bare or not bare.split(" = ")[0].isidentifier():
            continue
        if bare.split(" = ")[0] in {"frame", "position"} or lines[number - 1] == "# [frames.slope]":
            continue  # they go together with the frame, below
        changed = [*lines[:number], bare, *lines[number + 1 :]]
        if bare.startswith("rotation") and lines[number - 1].startswith("# position"):
            continue
        tried += 1
        found = check_scene("\n".join(changed), "starter.toml")
        assert [one for one in found if one.error and "'first'" not in one.text] == [], bare
    assert tried >= 6
    text = starter_text()
    for part in ("[frames.slope]", "position = [0, 0, 1]", "rotation = { axis = [0, 1, 0]", 'frame = "slope"'):
        assert f"# {part}" in text
        text = text.replace(f"# {part}", part)
    assert [one for one in check_scene(text, "starter.toml") if one.error] == []


def test_new_does_not_write_over_a_file_unless_forced(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("mine")
    assert call(monkeypatch, "new", str(file)) == 2
    assert "--force" in capsys.readouterr().err and file.read_text() == "mine"
    assert call(monkeypatch, "new", str(file), "--from", "rmap", "--force") == 2
    assert file.read_text() == "mine"
    assert call(monkeypatch, "new", str(file), "--from", "ball", "--force") == 0
    assert load(file) == load("ball")
    assert call(monkeypatch, "new", str(tmp_path / "scene.txt")) == 2


def test_info_tells_what_is_here(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    Simulation(load("ball")).advance(1)
    monkeypatch.setattr("stiction.store.Store.step", lambda *_: pytest.fail("something ran"))
    assert call(monkeypatch, "info", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["stiction"] == __version__
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["builtin_scenes"] == builtin_names()
    assert facts["cpu"]["simd_bits"] in {128, 256}
    if facts["cache"]["folder"] is not None and facts["compiler"] == "on":
        names = {kernel["name"] for kernel in facts["cache"]["kernels"]}
        assert "soft_entry.soft_step" in names
        assert facts["cache"]["bytes"] > 100_000
    assert call(monkeypatch, "info") == 0
    shown = capsys.readouterr().out
    assert "Extras" in shown and np.__version__ in shown


def test_info_before_anything_is_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("stiction.core.jit.kernel_folder", lambda: tmp_path)
    (tmp_path / "odd.kernel-1.py311.nbi").write_bytes(b"not an index")
    assert call(monkeypatch, "info") == 0
    assert "No kernels are compiled yet" in capsys.readouterr().out


def test_the_extras_are_those_of_the_package() -> None:
    known = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = known["optional-dependencies"]
    for name, (packages, _) in info.EXTRAS.items():
        assert {line.split(">")[0] for line in extras[name]} == set(packages)
    assert {line.split(">")[0] for line in known["dependencies"]} <= {*info.PACKAGES, "llvmlite"}


def test_the_switches_of_a_part_are_told() -> None:
    from stiction.core import jit, soft_parts
    from stiction.core.parts import Variant, signature

    if jit.config.DISABLE_JIT:
        pytest.skip("nothing is compiled")
    both, one = (signature(soft_parts.find, Variant(False, False, on)) for on in (("boxes_meet", "hulls"), ("hulls",)))
    assert kernels._switches("soft_parts.find", [both, one]) == [["boxes_meet", "hulls"], ["hulls"]]
    assert kernels._switches("soft_parts.find", [one]) == [["hulls"]]
    team = signature(soft_parts.find, Variant(False, True))
    assert kernels._switches("soft_parts.find", [team, one]) == [["team"], ["hulls"]]


def test_what_a_child_has_compiled_is_noted_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from numba.core.event import Event, EventStatus, broadcast

    from stiction.core.side_by_side import COMPILED_ELSEWHERE

    monkeypatch.setattr("stiction.core.jit.kernel_folder", lambda: tmp_path)
    told = []
    with kernels.noting_times(lambda: told.append(1)):
        for seconds in (2.5, 1.0):
            said = {"kernel": "find", "module": "stiction.core.soft_parts", "seconds": seconds}
            broadcast(Event(COMPILED_ELSEWHERE, EventStatus.END, data=said))
    assert json.loads((tmp_path / kernels.TIMES).read_text()) == {"soft_parts.find": 3.5}
    assert not told  # it was over by then


def test_how_long_compiling_took_is_noted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    import numba

    if numba.config.DISABLE_JIT:
        pytest.skip("nothing is compiled")
    monkeypatch.setattr("stiction.core.jit.kernel_folder", lambda: tmp_path)
    told = []

    def twice(x: int) -> int:
        return 2 * x

    for _ in range(2):
        with kernels.noting_times(lambda: told.append(1)):
            assert numba.njit(twice)(2) == 4
    (name,) = noted = json.loads((tmp_path / kernels.TIMES).read_text())
    assert name == "test_check.twice" and noted[name] > 0.0
    assert told == [1, 1]
