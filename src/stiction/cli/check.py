"""``stiction check``: every mistake of scene files, with line and suggestion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiction.cli.console import out, print_json

if TYPE_CHECKING:
    from stiction.scene.check import Finding


def check(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE ...", help="TOML files of scenes or sweeps, or built-in scenes.")
    ],
    strict: Annotated[bool, typer.Option("--strict", help="Warnings count as mistakes.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print what was found as JSON.")] = False,
) -> None:
    """Explain every mistake of a scene or a sweep: the line, what is wrong, what is allowed, and what may be meant.

    Warnings tell what is allowed but may not be meant, such as bodies that begin inside one another. Exit status 1 if
    there are mistakes.

    \b
    Examples:
      stiction check my_scene.toml
      stiction check *.toml --strict
      stiction check my_scene.toml --json
    """
    texts = {file: _read(file) for file in files}
    found = {file: _look(text, file) for file, text in texts.items()}
    if json:
        print_json([{"file": file, "findings": [one.as_dict() for one in ones]} for file, ones in found.items()])
    else:
        for file, ones in found.items():
            _print(file, texts[file], ones)
    if any(one.error or strict for ones in found.values() for one in ones):
        raise typer.Exit(1)


def _read(file: str) -> str:
    from stiction.scene.load import builtin_text, is_path, read_text

    return read_text(Path(file), "scene file") if is_path(file) else builtin_text(file)


def _look(text: str, file: str) -> list[Finding]:
    from stiction.scene.check import check_scene
    from stiction.sweep.check import check_sweep, is_sweep

    return check_sweep(text, file) if is_sweep(text) else check_scene(text, file)


def _print(file: str, text: str, found: list[Finding]) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    lines = text.splitlines()
    errors = sum(one.error for one in found)
    for one in found:
        color, word = ("red", "error") if one.error else ("yellow", "warning")
        where = f"{file}:{one.place.line}:{one.place.column}" if one.place else file
        path = f"[bold]{escape(one.path)}[/]: " if one.path else ""
        out.print(f"[{color}]{word}[/] {escape(where)}", soft_wrap=True)
        if one.place and one.place.line <= len(lines):
            line, column, length = one.place
            shown = lines[line - 1].expandtabs(1)
            out.print(f"[dim]{line:5} │[/] {escape(shown)}", soft_wrap=True)
            out.print(f"[dim]      │[/] {' ' * (column - 1)}[{color}]{'^' * length}[/]", soft_wrap=True)
        out.print(Padding(f"{path}{escape(one.text)}", (0, 0, 0, 8), expand=False))
        if one.suggestion and one.suggestion not in one.text:
            out.print(Padding(f"[cyan]{escape(one.suggestion)}.[/]", (0, 0, 0, 8), expand=False))
        out.print()
    if not found:
        out.print(f"[green]{escape(file)}[/]: no mistakes.")
        return
    counted = [
        f"{n} {word}{'s' if n != 1 else ''}" for n, word in ((errors, "mistake"), (len(found) - errors, "warning"))
    ]
    out.print(f"{escape(file)}: {', '.join(part for part in counted if not part.startswith('0'))}.")
