"""Pages that are written in part by scripts: what stands between two markers is replaced, the rest is left as it is."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def replace(page: Path, name: str, lines: Iterable[str]) -> None:
    """Write lines between ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->`` of a page.

    Raises:
        SystemExit: the page has no such markers.
    """
    page.write_text(replaced(page.read_text(encoding="utf-8"), name, lines, page.name), encoding="utf-8")


def replaced(text: str, name: str, lines: Iterable[str], page: str) -> str:
    """The text of a page with other lines between two of its markers."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
    before, _, rest = text.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise SystemExit(f"{page} has no markers for {name!r}.")
    return f"{before}{begin}\n" + "\n".join(lines) + f"\n\n{end}{after}"
