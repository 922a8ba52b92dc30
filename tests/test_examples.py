"""The examples of the gallery: each has a title, a formula or a question, and a picture; the quickest ones run here.

The documentation's build runs them all, and fails if one fails.
"""

from __future__ import annotations

import ast
import re
import runpy
from pathlib import Path

import matplotlib as mpl
import pytest

FOLDER = Path(__file__).parent.parent / "examples"
EXAMPLES = sorted(FOLDER.rglob("*.py"))
QUICK = ("sliding/ramp_table", "sliding/round_cone", "sliding/tilt_test")


def name(path: Path) -> str:
    return path.relative_to(FOLDER).with_suffix("").as_posix()


def test_there_are_at_least_sixteen() -> None:
    assert len(EXAMPLES) >= 16


def test_every_folder_has_a_header() -> None:
    for folder in {path.parent for path in EXAMPLES} | {FOLDER}:
        assert (folder / "GALLERY_HEADER.rst").read_text(encoding="utf-8").strip()


@pytest.mark.parametrize("path", EXAMPLES, ids=name)
def test_an_example_has_a_title_a_text_and_a_picture(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, line, _, *rest = (ast.get_docstring(tree) or "").splitlines()
    assert set(line) == {"="} and len(line) == len(title)
    assert len(" ".join(rest)) > 200, "say what it shows"
    assert text.endswith("plt.show()\n"), "a picture ends it"
    begun = re.search(r"plt\.(subplots|figure)\(", text)
    assert "plt.style.use" in text and begun
    assert "# %%" not in text[begun.start() :], "the gallery takes a picture at the end of a block: draw it in one"
    assert "print(" in text, "say what was measured"
    assert len(text.splitlines()) <= 120


def test_titles_are_different() -> None:
    titles = [
        (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split("\n")[0] for path in EXAMPLES
    ]
    assert len(set(titles)) == len(titles)


@pytest.mark.parametrize("path", [FOLDER / f"{one}.py" for one in QUICK], ids=name)
def test_a_quick_example_runs_and_draws(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mpl.use("Agg", force=True)
    from matplotlib import pyplot as plt

    monkeypatch.setattr(plt, "show", lambda: None)
    with mpl.rc_context():
        runpy.run_path(str(path), run_name="__main__")
        figures = [plt.figure(number) for number in plt.get_fignums()]
        plt.close("all")
    assert len(figures) == 1
    assert all(axes.has_data() for axes in figures[0].axes)
    assert any(axes.get_title(loc="left") for axes in figures[0].axes)
    assert len(capsys.readouterr().out.splitlines()) >= 2
