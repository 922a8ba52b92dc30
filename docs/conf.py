"""How Sphinx builds these pages: MyST Markdown, furo, API from docstrings. Nothing here needs the network."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from stiction import __version__

project = "stiction"
author = "stiction developers"
copyright = "2026, stiction developers"
release = __version__
version = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx-mathjax-offline",  # MathJax travels with the pages: formulas need no network
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]

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

    sys.path.insert(0, str(Path(__file__).parent / "figures"))
    import gallery

    gallery.draw(logging.getLogger(__name__).info)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("builder-inited", _draw_figures)
    app.connect("autodoc-process-docstring", _prepare_docstring, priority=400)
