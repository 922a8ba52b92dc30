"""What all commands have in common: examples in their help, --quiet, exit status, completion, and the first screen."""

from __future__ import annotations

import io
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.console import Console

from stiction import SimulationError, StictionError
from stiction.cli import command as commands
from stiction.cli import complete, console, progress, welcome
from stiction.cli import main as cli
from stiction.plot import KINDS
from stiction.scene import builtin_names

from .support import call

GROUP: Any = typer.main.get_command(cli.app)
COMMANDS: dict[str, Any] = GROUP.commands


def lines_of(name: str) -> list[list[str]]:
    """The calls of stiction in the examples of a command, as words."""
    found = []
    for line, _ in COMMANDS[name].examples:
        for part in line.split("&&"):
            words = shlex.split(part)
            assert words[0] == "stiction", line
            found.append(words[1 : words.index(">")] if ">" in words else words[1:])
    return found


def parsed(words: list[str]) -> dict[str, Any]:
    """The values of a call, without making it; a usage error is raised."""
    if not words or words[0].startswith("--"):
        return dict(GROUP.make_context("stiction", list(words), resilient_parsing=True).params)
    return dict(COMMANDS[words[0]].make_context(words[0], words[1:]).params)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_a_command_ends_in_examples_that_can_be_called(name: str) -> None:
    calls = lines_of(name)
    assert any(words[0] == name for words in calls)
    for words in calls:
        parsed(words)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_examples_are_the_last_thing_in_the_help(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch, name, "--help") == 0
    shown = capsys.readouterr().out
    first = COMMANDS[name].examples[0].line
    assert shown.index("Options") < shown.index("─ Examples") < shown.rindex(first[:40])
    assert "Examples:" not in shown, "they are shown once"


def test_an_example_with_an_option_that_is_not_there_would_be_found() -> None:
    with pytest.raises(Exception, match="No such option"):
        parsed(["run", "ramp", "--htlm", "a.html"])


def test_a_docstring_is_taken_apart() -> None:
    said, legend, examples = commands.parts(
        "Do it.\n\n\b\nExamples (of all):\n  stiction a # b\n  stiction c \\\n   d\n"
    )
    assert (said, legend) == ("Do it.", "(of all)")
    assert examples == [("stiction a", "b"), ("stiction c d", "")]
    assert commands.parts("Do it.") == ("Do it.", "", [])


def test_stiction_alone_shows_lines_that_can_be_called(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(monkeypatch) == 0
    shown = capsys.readouterr().out
    groups = welcome.NEXT.values()
    lines = [line for group in groups for line in group]
    assert len(lines) > 10
    for line in lines:
        assert line in shown
        program, *words = shlex.split(line)
        assert program == "stiction"
        if "--help" not in words:
            parsed(words)
    assert max(map(len, shown.splitlines())) <= 90


def test_the_first_screen_fits_into_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = Console(width=80, file=io.StringIO())
    monkeypatch.setattr(welcome, "out", narrow)
    welcome.show()
    text = narrow.file.getvalue()  # type: ignore[attr-defined]  # a StringIO
    assert "…" not in text
    assert sum(line.startswith("  stiction") for line in text.splitlines()) == sum(map(len, welcome.NEXT.values()))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_can_be_told_to_be_quiet(name: str) -> None:
    assert {"--quiet", "-q"} <= {word for parameter in COMMANDS[name].params for word in parameter.opts}


def test_quiet_leaves_the_result_alone(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    given = ("run", "ball", "--seconds", "0.1", "--json")
    assert call(monkeypatch, "run", "ball", "--seconds", "0.1") == 0
    assert "simulating" in capsys.readouterr().err
    assert call(monkeypatch, *given, "--quiet") == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert json.loads(printed.out)["steps"] > 0
    assert call(monkeypatch, "warmup", "-q") == 0
    assert capsys.readouterr().err == ""
    assert not console.is_quiet() or call(monkeypatch, "--version") == 0
    assert not console.is_quiet(), "the next call talks again"


def test_quiet_tells_what_is_wrong(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "run", "rmap", "--quiet") == 2
    assert "did you mean 'ramp'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (StictionError("wrong."), 2, "wrong."),
        (SimulationError("blew up.", step=1, body="b", state={}), 3, "blew up."),
        (KeyboardInterrupt(), 130, "interrupted."),
        (ZeroDivisionError("division"), 70, "a fault of stiction itself"),
    ],
    ids=["bad input", "blow-up", "Ctrl-C", "fault"],
)
def test_what_goes_wrong_has_a_status_of_its_own(
    error: BaseException,
    status: int,
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("stiction.scene.builtin_names", fail)
    assert call(monkeypatch, "scenes") == status
    assert words in capsys.readouterr().err


def test_wrong_usage_is_bad_input(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "run", "--no-such-option") == 2
    assert call(monkeypatch, "rnu") == 2
    capsys.readouterr()


def test_the_page_of_commands_names_every_command_and_every_status() -> None:
    page = (Path(__file__).parents[2] / "docs" / "cli.md").read_text(encoding="utf-8")
    for name in COMMANDS:
        assert re.search(rf"^## `stiction {name}\b", page, re.MULTILINE), name
    for status in (0, 1, 2, 3, 70, 130):
        assert re.search(rf"^\| {status} \|", page, re.MULTILINE), status


# -- completion -------------------------------------------------------------------------------------------------------


def completed(shell: str, line: str) -> tuple[list[str], set[str]]:
    """What a shell is offered for a line, and the packages that were loaded for it."""
    words = line.split(" ")
    environment = {
        **os.environ,
        "_STICTION_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
        "_TYPER_COMPLETE_ARGS": line,
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    code = (
        "import atexit, sys; from stiction.cli.main import main\n"
        "atexit.register(lambda: print(*sorted({name.partition('.')[0] for name in sys.modules}), file=sys.stderr))\n"
        "main()"
    )
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    return result.stdout.split(), set(result.stderr.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_is_offered_names_without_loading_what_is_heavy(shell: str) -> None:
    offered, loaded = completed(shell, "stiction run push")
    assert any("push-and-release" in word for word in offered)
    assert "stiction" in loaded
    assert loaded & {"numba", "matplotlib", "h5py", "scipy", "viser"} == set()


@pytest.mark.parametrize("name", ["materials.a", "cases", "run.plot", "bench.names", "solver", "bench.against"])
def test_names_are_found_without_loading_what_is_heavy(name: str) -> None:
    code = (
        f"import sys; from stiction.cli.complete import COMPLETERS; assert COMPLETERS[{name!r}]('')\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(result.stdout.split()) & {"numba", "pydantic", "matplotlib", "h5py", "scipy", "viser"} == set()


def test_completions_are_the_names_that_there_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("mine.toml", "run.h5", "data.csv", "other.txt"):
        (tmp_path / name).touch()
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "deep.toml").touch()
    offer = complete.COMPLETERS
    assert offer["scene"]("") == [*builtin_names(), "mine.toml", "sub/"]
    assert offer["scene"]("sub/d") == ["sub/deep.toml"]
    assert offer["scene"]("nowhere/") == []
    assert offer["view.scene"]("ru") == ["run.h5"]
    assert offer["figures"]("") == list(KINDS)
    assert offer["cases"]("slide-to") == ["slide-to-roll", "slide-to-roll-energy"]
    assert offer["materials.a"]("rub") == ["rubber"]
    assert offer["bench.against"]("mujoco,rap") == ["mujoco,rapier3d"]
    assert offer["data"]("") == ["data.csv", "sub/"]


def test_every_completer_belongs_to_a_parameter() -> None:
    known = {f"{name}.{parameter.name}" for name, one in COMMANDS.items() for parameter in one.params}
    bare = {name.partition(".")[2] for name in known}
    assert {key for key in complete.COMPLETERS if key not in known | bare} == set()


# -- progress ---------------------------------------------------------------------------------------------------------


def test_a_pace_does_not_count_what_came_before() -> None:
    now = 100.0
    pace = progress.Pace(lambda: now)
    pace.note(10)
    assert pace.rate == 0.0
    now = 102.0
    pace.note(30)
    assert pace.rate == 10.0
    assert pace.left(50) == 5.0
    for later, done in ((104.0, 130), (106.0, 230), (108.0, 330), (110.0, 430)):
        now = later
        pace.note(done)
    assert pace.rate == pytest.approx(50.0, rel=0.2), "of late, not since the beginning"


def test_a_log_has_steps_a_second_simulated_time_and_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter((0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    ticks = iter((20.0, 40.0, 60.0))
    monkeypatch.setattr(progress.Pace.__init__, "__defaults__", (lambda: next(ticks),))
    with progress.progress("A run", dt=0.01, compiles=False) as on_progress:
        for done in (100, 300, 500):
            on_progress(done, 1000)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "  A run: simulating …"
    assert lines[-1] == "  A run: simulating: 500/1000 steps, 10 steps/s, 5.00 of 10.00 s, 50 s left"


def test_a_bar_has_them_too(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Console(width=100, file=io.StringIO(), force_terminal=True)
    monkeypatch.setattr(progress, "err", screen)
    ticks = iter((1.0, 2.0))
    monkeypatch.setattr(progress.Pace.__init__, "__defaults__", (lambda: next(ticks),))
    with progress.progress("A run", dt=0.01, compiles=False) as on_progress:
        for done in (100, 300):
            on_progress(done, 1000)
    text = screen.file.getvalue()  # type: ignore[attr-defined]  # a StringIO
    assert "300/1000 steps, 200 steps/s, 3.00 of 10.00 s, 3.5 s left" in text


def test_spans_of_time_have_a_unit_that_suits_them() -> None:
    given = (0.02, 3.0, 300.0, 86400.0, float("nan"))
    assert [progress.span(seconds) for seconds in given] == ["20 ms", "3 s", "5 min", "24 h", "?"]
