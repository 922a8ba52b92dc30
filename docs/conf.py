"""How Sphinx builds these pages: MyST Markdown, furo, API from docstrings. Nothing here needs the network."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "figures")]

import gallery  # noqa: E402  # in docs/figures, which is on the path now
import scene_reference  # noqa: E402  # beside this file

from stiction import __version__  # noqa: E402  # after the path

project = "stiction"
author = "stiction developers"
copyright = "2026, stiction developers"
release = __version__
version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx-mathjax-offline",  # MathJax travels with the pages: formulas need no network
    "sphinx.ext.doctest",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "sg_execution_times.rst", "gallery/**/sg_execution_times.rst"]

# So that a page can find its own examples, and what it writes does not lie about.
doctest_global_setup = f"""
import os
import tempfile
from pathlib import Path

DOCS = Path({str(HERE)!r})
before, folder = os.getcwd(), tempfile.TemporaryDirectory()
os.chdir(folder.name)
"""
doctest_global_cleanup = """
os.chdir(before)
folder.cleanup()
"""
EXAMPLES = "../examples"
STAMP = HERE / "_build" / "examples-made-from"
"""Says what the pictures of the examples were made with: another package makes them anew, not only another example."""


def _with_this_package() -> bool:
    return STAMP.exists() and STAMP.read_text() == gallery.state_of_package()


sphinx_gallery_conf = {
    "examples_dirs": EXAMPLES,
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "subsection_order": [f"{EXAMPLES}/{name}" for name in ("sliding", "rolling", "standing", "grains", "machines")],
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "run_stale_examples": not _with_this_package(),
    "remove_config_comments": True,
    "min_reported_time": 1000,
    "show_signature": False,
    "show_memory": False,
    "download_all_examples": False,
}

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings give shape and unit, which says more than ArrayLike
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_title = f"stiction {release}"


def _prepare_docstring(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Read docstrings as they are meant, before napoleon sees them.

    Bars are absolute values, |g_t| <= mu g_n, not substitutions. And a property's first line may have a colon in it
    that does not part a type from a description; napoleon looks for one in the first line only, here an empty comment.
    """
    for i, line in enumerate(lines):
        parts = re.split("(``.*?``)", line)
        lines[i] = "".join(part if part.startswith("``") else part.replace("|", "\\|") for part in parts)
    if what in ("property", "attribute", "data") and lines and ":" in lines[0]:
        lines[:0] = ["..", ""]


def _draw_figures(app: Any) -> None:
    """Draw the contact sheet of figures before pages are read, if the package or its commands have changed."""
    from sphinx.util import logging

    gallery.draw(logging.getLogger(__name__).info)


def _write_reference(app: Any) -> None:
    """Write the reference of scene files out of their models."""
    scene_reference.write()


def _stamp_examples(app: Any, exception: Exception | None) -> None:
    """Remember with which package the examples have run."""
    if exception is None:
        STAMP.write_text(gallery.state_of_package())


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("builder-inited", _draw_figures)
    app.connect("builder-inited", _write_reference)
    app.connect("build-finished", _stamp_examples)
    app.connect("autodoc-process-docstring", _prepare_docstring, priority=400)
