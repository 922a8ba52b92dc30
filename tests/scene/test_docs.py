"""What docs/scenes.md shows is so."""

from __future__ import annotations

import doctest
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from stiction.record import recorder
from stiction.scene import Simulation, builtin_names, load

PAGE = Path(__file__).parents[2] / "docs" / "scenes.md"
TEXT = PAGE.read_text(encoding="utf-8")
COMMANDS = re.findall(r"^stiction run (.*)$", TEXT, re.MULTILINE)


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


def test_the_example_does_what_its_sentence_says(tmp_path: Path) -> None:
    (example,) = blocks("toml")
    (tmp_path / "my-scene.toml").write_text(example)
    simulation = Simulation(load(tmp_path / "my-scene.toml"))
    crate = simulation.world["crate"]
    start = crate.position
    simulation.advance(200)
    assert np.linalg.norm(crate.position - start) < 1e-5
    simulation.advance(100)
    assert np.linalg.norm(crate.velocity) > 0.5
    simulation.advance(1000)
    assert simulation.done
    assert np.linalg.norm(crate.position - start) > 0.1
    assert np.linalg.norm(crate.velocity) < 1e-4


def test_the_examples_in_python_give_what_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my-scene.toml").write_text(blocks("toml")[0])
    failed, tried = doctest.testfile(str(PAGE), module_relative=False, optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    assert (failed, tried) == (0, 6)


def test_the_recorders_example_gives_what_is_shown() -> None:
    failed, tried = doctest.testmod(recorder)
    assert failed == 0 and tried > 0


@pytest.mark.parametrize("command", COMMANDS)
def test_a_shown_override_changes_the_scene_and_the_world_takes_it(command: str) -> None:
    name, *options = shlex.split(command)
    if name == "SCENE" or name.endswith(".toml"):
        return
    assert options[::2] == ["--set"] * (len(options) // 2)
    scene = load(name, options[1::2])
    assert scene != load(name)
    scene.build()


def test_overrides_were_found() -> None:
    assert sum("--set" in command for command in COMMANDS) == 6


@pytest.mark.parametrize("name", builtin_names())
def test_the_list_has_the_sentence_of_each_scene(name: str) -> None:
    assert f"| `{name}` | {load(name).expect} |" in TEXT


@pytest.mark.parametrize("name", builtin_names())
def test_a_scene_file_suggests_an_override_that_works(name: str) -> None:
    from stiction.scene import builtin_text

    found = re.search(r"^# Try: stiction run (.*)$", builtin_text(name), re.MULTILINE)
    assert found
    suggested, option, *overrides = shlex.split(found[1])
    assert (suggested, option) == (name, "--set")
    load(name, overrides).build()
