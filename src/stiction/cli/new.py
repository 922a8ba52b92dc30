"""``stiction new``: a scene to start from."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from stiction import outputs
from stiction.cli.console import say
from stiction.errors import InvalidInputError


def new(
    file: Annotated[Path, typer.Argument(help="The file to write; it ends in .toml.")],
    from_: Annotated[
        str | None, typer.Option("--from", metavar="NAME", help="A copy of a built-in scene instead of the starter.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
) -> None:
    """Write a scene to start from: every section is explained, with units, and it runs as it is.

    \b
    Examples:
      stiction new my_scene.toml
      stiction new my_ramp.toml --from ramp    # a copy of a built-in scene
      stiction new my_scene.toml --force       # begin again
    """
    from stiction.scene.load import SUFFIX, builtin_text

    if file.suffix != SUFFIX:
        raise InvalidInputError(f"FILE must end in {SUFFIX}, got {str(file)!r}.")
    text = starter_text() if from_ is None else builtin_text(from_)
    if file.exists() and not force:
        raise InvalidInputError(f"FILE must not exist yet unless --force is given, got {str(file)!r}.")
    outputs.writable("FILE", file, make_folder=True)
    file.write_text(text, encoding="utf-8")
    say(f"scene: {file}")
    for word, does in {"check": "its mistakes, if any", "run": "simulate it", "view": "see it live"}.items():
        say(f"  [bold]stiction {word} {file}[/]  [dim]{does}[/]")


def starter_text() -> str:
    """The file of the starter scene, comments included."""
    return resources.files("stiction.scene").joinpath("starter.toml").read_text(encoding="utf-8")
