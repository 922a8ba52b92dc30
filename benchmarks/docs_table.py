"""Writes what a benchmark has made into a page of the manual, between two comments."""

from __future__ import annotations

from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def write_between(page: str, name: str, made: str) -> None:
    """Replace what stands between ``<!-- NAME: begin … -->`` and ``<!-- NAME: end -->`` in docs/``page``."""
    file = DOCS / page
    text = file.read_text(encoding="utf-8")
    before, rest = text.split(f"<!-- {name}: begin", 1)
    head, rest = rest.split("-->", 1)
    _, after = rest.split(f"<!-- {name}: end -->", 1)
    file.write_text(f"{before}<!-- {name}: begin{head}-->\n{made}\n<!-- {name}: end -->{after}", encoding="utf-8")
