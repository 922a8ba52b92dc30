"""The contact sheet of the documentation: a picture for each kind of figure, each with a command that makes it."""

from __future__ import annotations

import importlib.util
import shlex
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from stiction.plot import KINDS
from stiction.scene import builtin_names

FILE = Path(__file__).parents[2] / "docs" / "figures" / "gallery.py"


def load_gallery() -> ModuleType:
    spec = importlib.util.spec_from_file_location("gallery", FILE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


GALLERY = load_gallery()
TEXT = GALLERY.PAGE.read_text(encoding="utf-8")


def test_every_kind_is_shown_and_every_picture_has_its_command() -> None:
    made = {
        f"{shlex.split(command)[0]}-{kind}.png" for command, kinds in GALLERY.commands(TEXT).items() for kind in kinds
    }
    assert made == GALLERY.pictures(TEXT)
    assert {name.removesuffix(".png").rpartition("-")[2] for name in made} == set(KINDS)
    assert {shlex.split(command)[0] for command in GALLERY.commands(TEXT)} <= set(builtin_names())


def test_commands_of_one_scene_are_run_once() -> None:
    lines = ("a --set x=1 --plot cone", "a --set x=1 --plot load", "a --plot run")
    text = "".join(f"    stiction run {line}\n" for line in lines)
    assert GALLERY.commands(text) == {"a --set x=1": ["cone", "load"], "a": ["run"]}


def test_pictures_are_drawn_once_and_again_when_a_command_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, folder, said = tmp_path / "page.md", tmp_path / "figures", []
    monkeypatch.setattr(GALLERY, "PAGE", page)
    monkeypatch.setattr(GALLERY, "FOLDER", folder)
    page.write_text("![a](_build/figures/pull-energy.png)\n\n    stiction run pull --seconds 0.1 --plot energy\n")
    for times in (1, 1):
        GALLERY.draw(said.append)
        assert len(said) == times
        assert (folder / "pull-energy.png").stat().st_size > 5000
    page.write_text(page.read_text().replace("0.1", "0"))
    failed = SimpleNamespace(returncode=2, stderr="duration: must be above 0 s")
    monkeypatch.setattr(GALLERY.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(RuntimeError, match="stiction run pull --seconds 0 failed: duration: must be above 0 s"):
        GALLERY.draw(said.append)
    assert not (folder / GALLERY.STAMP).exists(), "what failed is tried again"
