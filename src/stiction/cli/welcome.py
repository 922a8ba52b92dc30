"""``stiction`` alone: what one can do next."""

from __future__ import annotations

from stiction import __version__
from stiction.cli.console import out

NEXT: dict[str, dict[str, str]] = {
    "First steps": {
        "stiction run ramp": "simulate a built-in scene, print a table",
        "stiction scenes": "built-in scenes and what must happen",
        "stiction new my_scene.toml": "your own scene, with comments",
        "stiction check my_scene.toml": "its mistakes, with lines and advice",
    },
    "Look": {
        "stiction view ramp": "live in the browser: pull, tilt, shove",
        "stiction run pull --plot pull": "a figure: friction rises and lets go",
        "stiction run ramp --html ramp.html": "a page that plays the run, offline",
    },
    "Measure": {
        "stiction verify slide-to-roll": "a closed form beside what is measured",
        "stiction materials rubber concrete": "coefficients of a pair, and the source",
        "stiction bench --against none": "how fast the engine is here",
    },
    "Many runs": {
        "stiction sweep --list": "a scene over parameters: tables, maps",
        "stiction fit --help": "coefficients from measured motion",
    },
    "This machine": {
        "stiction warmup": "compile the kernels ahead, once",
        "stiction info": "versions, CPU, what is compiled",
        "stiction --install-completion": "names complete with the Tab key",
    },
}
"""Lines to type, in groups, and what they do."""


def show() -> None:
    """Print them."""
    from rich.table import Table

    grid = Table.grid(padding=(0, 2))
    grid.add_column(no_wrap=True)
    grid.add_column(style="dim")
    for group, lines in NEXT.items():
        grid.add_row(f"[bold]{group}[/]", "")
        for line, text in lines.items():
            grid.add_row(f"  {line}", text)
    out.print(f"[bold]stiction[/] {__version__}: rigid-body physics in which friction is right.\n")
    out.print(grid)
    out.print("\nAll commands: stiction --help. Options and examples of one: stiction COMMAND --help.")
