"""What the commands print: results on standard output, everything else on standard error."""

from __future__ import annotations

import json
import math
import shutil
import sys
from typing import TYPE_CHECKING, Any

from rich.console import Console

if TYPE_CHECKING:
    from rich.table import Table


def _width() -> int | None:
    """Tables are never squeezed below 110 columns when the output is a file or a log."""
    return None if sys.stdout.isatty() else max(110, shutil.get_terminal_size((120, 24)).columns)


out = Console(width=_width(), highlight=False)
err = Console(stderr=True, highlight=False)


class _Talk:
    """Whether commands tell what is going on."""

    quiet = False


def hush(quiet: bool) -> None:
    """Say nothing but results, warnings and errors from now on, or talk again."""
    _Talk.quiet = quiet


def is_quiet() -> bool:
    """Whether ``--quiet`` was given."""
    return _Talk.quiet


def complain(text: str) -> None:
    """One line on standard error, never wrapped or coloured: a warning or an error, told in any case."""
    print(f"stiction: {text}", file=sys.stderr)


def say(text: str) -> None:
    """What is going on, on standard error; nothing with ``--quiet``."""
    if not is_quiet():
        err.print(text, soft_wrap=True)


def print_json(value: Any) -> None:
    """JSON on standard output, and nothing else; numbers that are not finite, unknown to JSON, become null."""
    print(json.dumps(_finite(value), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(title: str, columns: list[str], *, right: tuple[str, ...] = (), caption: str | None = None) -> Table:
    """An empty table in the style of all commands; columns named in ``right`` are numbers."""
    from rich.table import Table

    made = Table(title=title, title_justify="left", title_style="bold", caption=caption, caption_justify="left")
    for column in columns:
        made.add_column(column, justify="right" if column in right else "left", overflow="fold")
    return made
