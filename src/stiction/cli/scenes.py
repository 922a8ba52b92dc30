"""``stiction scenes``: what can be run out of the box."""

from __future__ import annotations

from typing import Annotated

import typer

from stiction.cli.console import out, print_json, table


def scenes(
    name: Annotated[str | None, typer.Argument(help="Print this scene's file, to start your own from.")] = None,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON schema of scene files.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """List the built-in scenes, each with one sentence that says what must happen.

    \b
    Examples:
      stiction scenes
      stiction scenes ramp > my.toml    # a file to start your own from
      stiction scenes --schema > scene.schema.json    # for an editor
    """
    from stiction.scene import builtin_names, builtin_text, json_schema, load

    if schema:
        print_json(json_schema())
        return
    if name is not None:
        print(builtin_text(name), end="")
        return
    loaded = {key: load(key) for key in builtin_names()}
    if json:
        print_json([{"name": key, "title": s.title, "expect": s.expect} for key, s in loaded.items()])
        return
    made = table("Built-in scenes", ["scene", "what must happen"], caption="Run one with: stiction run SCENE")
    for key, scene in loaded.items():
        made.add_row(f"[bold]{key}[/]", scene.expect)
    out.print(made)
