"""``stiction bench`` as a user gives it: tables, JSON, plots, and sentences for what is wrong."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stiction.bench import Outcome, Plan, Row, Table, report, run_plan
from stiction.bench.single import Task
from stiction.bench.stability import Stability
from stiction.bench.worker import run_apart

from .support import call as call_command

TINY = ("--against", "none", "--steps", "3", "--settle", "2", "--runs", "2", "--in-process")


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Exit status of ``stiction bench ARGUMENTS``, run in this process."""
    return call_command(monkeypatch, "bench", *arguments)


@pytest.mark.filterwarnings("ignore")
def test_a_tiny_run_prints_a_table(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "pyramid", "tower", "--sizes", "3", *TINY) == 0
    printed = capsys.readouterr()
    for word in ("pyramid", "tower", "ms/step", "stands", "cores"):  # a narrow terminal breaks the engines' names
        assert word in printed.out
    assert "pyramid 3, stiction, run 2 of 2" in printed.err


@pytest.mark.filterwarnings("ignore")
def test_json_is_json_and_has_each_run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "pyramid", "--sizes", "1,3", "--json", "--profile", *TINY) == 0
    result = json.loads(capsys.readouterr().out)
    assert [row["bodies"] for row in result["rows"]] == [1, 3]
    for row in result["rows"]:
        assert row["wall_ms_per_step"] > 0.0
        assert row["ratio_to_fastest_peer"] is None
        assert len(row["runs"]) == 2
        assert row["runs"][0]["steps"] == 3
        assert row["stability"]["stands"] is True
    assert result["settings"]["steps"] == 3
    assert result["machine"]["cores"] >= 1
    assert result["interrupted"] is False


@pytest.mark.filterwarnings("ignore")
def test_a_plot_is_written(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "new" / "a.png"
    assert call(monkeypatch, "pyramid", "--sizes", "1,3", "--plot", str(picture), *TINY) == 0
    assert picture.stat().st_size > 10_000
    assert "a.png" in capsys.readouterr().err


@pytest.mark.filterwarnings("ignore")
def test_stages_are_shown_or_said_to_be_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from stiction.world import World

    monkeypatch.setattr(World, "profile", lambda self, steps: {"narrow_phase": 0.3, "solve": 0.1}, raising=False)
    assert call(monkeypatch, "pyramid", "--sizes", "1", "--profile", *TINY) == 0
    shown = capsys.readouterr().out
    assert "narrow phase" in shown and "75%" in shown
    monkeypatch.setattr(World, "profile", None, raising=False)
    assert call(monkeypatch, "pyramid", "--sizes", "1", "--profile", *TINY) == 0
    assert "no profile yet" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("pyramidd",), "(did you mean 'pyramid'?)"),
        (("--against", "mujocoo"), "(did you mean 'mujoco'?)"),
        (("--against", "none,mujoco"), "'none' alone or a list of engines"),
        (("--sizes", "many"), "--sizes must be whole numbers"),
        (("--sizes", "0"), "--sizes must be 1 or more"),
        (("--runs", "0"), "runs must be a whole number"),
        (("--steps", "0"), "steps must be a whole number"),
        (("--dt", "-1"), "dt must be above 0 s"),
        (("--solver", "sofft"), "(did you mean 'soft'?)"),
        (("--plot", "a.exe"), "--plot must end in one of"),
    ],
)
def test_bad_input_ends_with_one_sentence_before_anything_runs(
    arguments: tuple[str, ...],
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("stiction.bench.measure.run_here", lambda *_: pytest.fail("something ran"))
    given = arguments if "--against" in arguments else (*arguments, "--against", "none")
    assert call(monkeypatch, *given) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("stiction: error: ") and printed.err.count("\n") == 1
    assert sentence in printed.err


def test_an_engine_that_is_not_installed_is_named_and_left_out(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("stiction.bench.engines.base.Engine.available", classmethod(lambda _: False))
    monkeypatch.setattr("stiction.bench.measure.run_here", lambda task: Outcome(bodies=3, skipped="said so"))
    assert call(monkeypatch, "pyramid", "--against", "mujoco", *TINY[2:]) == 0
    printed = capsys.readouterr()
    assert "mujoco is left out: it is not installed" in printed.err
    assert "pyramid: skipped, said so" in printed.out


def test_ctrl_c_shows_what_was_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    calls: list[Task] = []

    def run(task: Task) -> Outcome:
        calls.append(task)
        if len(calls) > 2:
            raise KeyboardInterrupt
        return _outcome(1.25)

    monkeypatch.setattr("stiction.bench.measure.run_here", run)
    assert call(monkeypatch, "pyramid", "pile", *TINY) == 130
    printed = capsys.readouterr()
    assert "1.25" in printed.out
    assert "interrupted; what was measured" in printed.err


def test_ctrl_c_in_a_terminal_ends_the_run_that_goes_on() -> None:
    """With a process for each run: none may be left behind."""
    arguments = ("tower", "--sizes", "2", "--against", "none", "--runs", "500", "--steps", "2", "--settle", "1")
    command = [sys.executable, "-m", "stiction.cli.main", "bench", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if "run 3 of 500" in line:
                break
        process.send_signal(signal.SIGINT)
        printed, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted; what was measured" in errors
    assert "tower" in printed and "ms/step" in printed


def test_lists_name_scenes_and_engines(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--list") == 0
    shown = capsys.readouterr().out
    for word in ("card-house", "hopper", "robox3d", "sapien"):
        assert word in shown
    assert call(monkeypatch, "--list", "--json") == 0
    assert {row["name"] for row in json.loads(capsys.readouterr().out)["engines"]} >= {"stiction", "mujoco"}


# --- measuring --------------------------------------------------------------------------------------------------------


def _outcome(wall: float, bodies: int = 3) -> Outcome:
    end = Stability(0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, True)
    return Outcome(bodies=bodies, wall=wall, cpu=wall, steps=3, stability=end)


def test_engines_take_turns_and_the_median_is_compared_with_the_fastest_peer() -> None:
    times = {"stiction": [3.0, 2.0, 9.0], "mujoco": [4.0, 4.0, 4.0], "robox3d": [1.0, 1.5, 1.0]}
    order = []

    def run(task: Task) -> Outcome:
        order.append(task.engine)
        return _outcome(times[task.engine].pop(0))

    patch = pytest.MonkeyPatch()
    patch.setattr("stiction.bench.measure.run_here", run)
    table = Table()
    run_plan(Plan(scenes=("tower",), engines=tuple(times), isolated=False), table)
    patch.undo()
    assert order == ["stiction", "mujoco", "robox3d"] * 3
    assert [row.median() for row in table] == [3.0, 4.0, 1.0]
    assert [table.ratio(row) for row in table] == [3.0, 4.0, 1.0]


def test_the_slope_of_a_curve_is_the_power_of_n() -> None:
    table = Table(Row("stiction", "pile", n, [_outcome(0.01 * n**1.5, n)]) for n in (100, 400, 1600))
    sizes, _, slope = report.curves(table, "pile")["stiction"]
    assert sizes.tolist() == [100, 400, 1600]
    assert slope == pytest.approx(1.5)


def test_a_time_limit_stops_a_run_and_is_told() -> None:
    table = Table()
    plan = Plan(scenes=("tower",), engines=("stiction",), runs=1, isolated=False, limit=1e-9)
    run_plan(plan, table)
    (outcome,) = table[0].outcomes
    assert not outcome.complete and outcome.steps == 0
    assert "time limit" in report.cells(table, table[0])[-1]


def test_a_scene_that_still_settles_is_no_yardstick() -> None:
    unsettled = _outcome(0.1)
    unsettled.steps = 0
    table = Table([Row("stiction", "pile", 3, [_outcome(2.0)]), Row("mujoco", "pile", 3, [unsettled])])
    assert math.isnan(table.ratio(table[0])) and math.isnan(table.ratio(table[1]))
    table.append(Row("robox3d", "pile", 3, [_outcome(1.0)]))
    assert table.ratio(table[0]) == 2.0
    assert set(report.curves(table, "pile")) == {"stiction", "robox3d"}


def test_a_run_apart_gives_the_same_kind_of_outcome_and_a_crash_is_told() -> None:
    outcome = run_apart(Task("stiction", "tower", 2, settle=1, steps=2))
    assert outcome.failed is None
    assert outcome.steps == 2 and outcome.wall > 0.0 and math.isfinite(outcome.cpu)
    assert isinstance(outcome.stability, Stability) and outcome.stability.stands
    assert "must be" in (run_apart(Task("stiction", "tower", -1)).failed or "")
