"""``--plot`` of ``stiction run``, and ``stiction plot`` for recordings."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stiction.plot import KINDS

from .support import call

SHORT = ("--seconds", "0.1")


def test_run_draws_kinds_and_files_in_any_mixture(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    plots = ("--plot", "raster", "--plot", "energy=new/e.svg", "--plot", "r.png", "--plot", "pull=a=b.png")
    assert call(monkeypatch, "run", "pull", *SHORT, *plots, "--body", "crate", "--html", "page.html") == 0
    printed = capsys.readouterr().err
    for name in ("pull-raster.png", "new/e.svg", "r.png", "a=b.png", "page.html"):
        assert (tmp_path / name).stat().st_size > 5000
        assert name in printed


def test_a_recording_is_drawn_and_run_again_where_it_must_be(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call(monkeypatch, "run", "pull", *SHORT, "--record", "run.h5") == 0
    assert call(monkeypatch, "plot", "run.h5", "cone", "run=x.pdf", "--body", "crate") == 0
    assert (tmp_path / "run-cone.png").exists() and (tmp_path / "x.pdf").exists()
    assert call(monkeypatch, "plot", "run.h5", "hodograph", "--repeat") == 0
    assert (tmp_path / "run-hodograph.png").exists()


def test_figures_of_what_is_recorded_run_nothing_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, *options in (("bare",), ("contacts", "--record-contacts")):
        assert call(monkeypatch, "run", "pull", *SHORT, "--record", f"{name}.h5", *options) == 0
    monkeypatch.setattr("stiction.store.Store.step", lambda *_: pytest.fail("something ran"))
    assert call(monkeypatch, "plot", "bare.h5", *(kind for kind in KINDS if not KINDS[kind].contacts)) == 0
    assert {path.name for path in tmp_path.glob("bare-*.png")} == {"bare-energy.png", "bare-hodograph.png"}
    assert call(monkeypatch, "plot", "contacts.h5", *KINDS) == 0
    assert len(list(tmp_path.glob("contacts-*.png"))) == len(KINDS)


def test_kinds_are_listed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(monkeypatch, "plot", "--list", "--json") == 0
    assert [row["kind"] for row in json.loads(capsys.readouterr().out)] == list(KINDS)
    assert call(monkeypatch, "plot", "--list") == 0
    assert KINDS["cone"].text in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("run", "pull", "--plot", "hodograf"), "(did you mean 'hodograph'?)"),
        (("run", "pull", "--plot", "hodograf=a.png"), "--plot must be one of run, pull"),
        (("run", "pull", "--plot", "cone=a.exe"), "--plot must end in one of"),
        (("run", "pull", "--plot", "cone=/proc/none/a.png"), "--plot must be a file that can be written"),
        (("run", "pull", "--plot", "phase=/tmp/a.png", "--body", "crat"), "(did you mean 'crate'?)"),
        (("plot",), "recording must be given, unless --list is"),
        (("plot", "none.h5", "cone"), "recording must be a file that exists, got 'none.h5'"),
        (("plot", "none.h5"), "figures must be given: one or more of run, pull"),
    ],
)
def test_bad_input_ends_with_one_sentence_before_anything_runs(
    arguments: tuple[str, ...],
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("stiction.store.Store.step", lambda *_: pytest.fail("something ran"))
    assert call(monkeypatch, *arguments) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("stiction: error: ") and printed.err.count("\n") == 1
    assert sentence in printed.err
    assert not list(tmp_path.iterdir())
