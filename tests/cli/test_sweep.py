"""``stiction sweep`` as a user gives it: plan, table, map, JSON, and sentences for what is wrong."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from .support import call as call_command

SPEC = """
title = "A crate that slides"

[map]
x = "v"
y = "mass"
classes = [{ label = "far", when = "way > 0.1" }, { label = "near", when = "way <= 0.1" }]

[scene]
duration = 0.2
materials = { base = "empty", pairs = [{ a = "a", b = "b", static = 0.4 }] }
bodies = [
    { name = "floor", shape = { type = "plane" }, static = true, material = "a" },
    { name = "crate", shape = { type = "box", size = [1, 1, 0.5] }, mass = 1, material = "b", position = [0, 0, 0.25] },
]

[[parameters]]
key = "bodies.crate.velocity[0]"
name = "v"
linspace = [0.1, 1, 3]

[[parameters]]
key = "bodies.crate.mass"
values = [1, -1, 2]

[[metrics]]
name = "way"
value = "slip_distance('crate')"
"""


def call(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Exit status of ``stiction sweep ARGUMENTS``, run in this process."""
    return call_command(monkeypatch, "sweep", *arguments)


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "crate.toml").write_text(SPEC)
    monkeypatch.chdir(tmp_path)
    return "crate.toml"


def test_a_sweep_prints_a_summary_and_writes_table_and_map(
    spec: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert call(monkeypatch, spec, "--backend", "inline", "--table", "new/table.csv") == 0
    printed = capsys.readouterr()
    assert "9 of 9 runs finished, 3 failed" in printed.out
    assert "a run failed: bodies[1].mass: must be above 0 kg, got -1." in printed.err
    with (tmp_path / "new" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["mass"] for row in rows] == ["1.0", "-1.0", "2.0"] * 3
    assert (tmp_path / "crate.sweep" / "map.png").stat().st_size > 10_000

    assert call(monkeypatch, spec, "--resume", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["found"], result["done"], result["failed"], result["workers"]) == (9, 9, 3, 0)
    assert result["metrics"]["way"]["none"] == 3 and result["closed_form"] is None
    assert Path(result["table"]).name == "table.parquet"

    assert call(monkeypatch, spec) == 2
    assert "go on with --resume, or name another folder." in capsys.readouterr().err


def test_a_plan_says_how_many_how_long_and_how_large(
    spec: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert call(monkeypatch, spec, "--plan", "--workers", "3", "--json") == 0
    plan = json.loads(capsys.readouterr().out)
    assert (plan["runs"], plan["steps"], plan["workers"], plan["tried"]) == (9, 12, 3, 9)
    assert plan["parameters"] == {"v": 3, "mass": 3} and plan["failed"] == 3
    assert plan["seconds"] > 9 * plan["seconds_per_run"] / 3 / 2 and plan["table_bytes"] > 0
    assert call(monkeypatch, spec, "--plan") == 0
    printed = capsys.readouterr()
    for word in ("9 (v: 3, mass: 3)", "together", "journals"):
        assert word in printed.out
    assert [path.name for path in tmp_path.iterdir()] == ["crate.toml"], "a plan leaves nothing behind"


@pytest.mark.filterwarnings("ignore")  # the command shows warnings in its own way
def test_lists(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "--list") == 0
    assert "slip-tip-hold" in capsys.readouterr().out
    assert call(monkeypatch, "slip-tip-hold", "--show") == 0
    assert capsys.readouterr().out.startswith("#")
    assert call(monkeypatch, "--functions") == 0
    assert "slip_distance(body)" in capsys.readouterr().out
    assert call(monkeypatch, "--functions", "--json") == 0
    assert "tipped" in json.loads(capsys.readouterr().out)["measures"]
    assert call(monkeypatch, "--schema") == 0
    assert "metrics" in json.loads(capsys.readouterr().out)["properties"]
    assert call(monkeypatch, "--help") == 0
    assert "stiction sweep my.toml --resume" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "SPEC must be a TOML file or one of slip-tip-hold, got nothing."),
        (("nowhere.toml",), "sweep file must exist, got 'nowhere.toml'."),
        (("slip-tip-hld",), "(did you mean 'slip-tip-hold'?)."),
        (
            ("crate.toml", "--backend", "rai"),
            "--backend must be one of local, ray, inline, got 'rai' (did you mean 'ray'?",
        ),
        (("crate.toml", "--workers", "0"), "--workers must be a whole number, 1 or more, got 0."),
        (("crate.toml", "--address", "auto"), "--address goes with --backend ray, got 'auto' with 'local'."),
        (("crate.toml", "--retry"), "--retry goes with --resume."),
        (("crate.toml", "--table", "t.xls"), "--table must end in .parquet or .csv, got 't.xls'."),
        (("crate.toml", "--map", "m.xyz"), "--map must end in one of "),
        (("crate.toml", "--set", "bodies.crte.mass=2"), "(did you mean 'crate'?)."),
    ],
)
def test_what_is_wrong_is_said_before_the_work(
    arguments: tuple[str, ...],
    sentence: str,
    spec: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    assert call(monkeypatch, *arguments) == 2
    assert sentence in capsys.readouterr().err
    assert list((tmp_path / "crate.sweep" / "runs").glob("*")) == [], "no run was begun"
