"""``stiction view``: a scene or a recording, live in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiction.cli.console import say

if TYPE_CHECKING:
    from stiction.view.session import Session


def view(
    scene: Annotated[
        str, typer.Argument(metavar="SCENE|RECORDING", help="A built-in scene, a TOML file, or a recording.")
    ],
    host: Annotated[str, typer.Option(help="Address to listen at; others than this one let other machines in.")] = (
        "127.0.0.1"
    ),
    port: Annotated[int, typer.Option(help="Where to listen; if it is taken, at a free port.")] = 8080,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a value of the scene; repeatable.")
    ] = None,
    speed: Annotated[float, typer.Option(help="How fast time runs, as a multiple of real time.")] = 1.0,
    paused: Annotated[bool, typer.Option("--paused", help="Wait for the play button.")] = False,
) -> None:
    """Show a scene live in the browser: pull bodies, tilt gravity, change friction while it runs. Ctrl-C ends it.

    \b
    Examples:
      stiction view ramp
      stiction view heap --speed 0.5 --port 9000
      stiction run ramp --record ramp.h5 && stiction view ramp.h5
    """
    from stiction.view.open import is_recording, open_recording, open_scene
    from stiction.view.server import Viewer

    session: Session = open_recording(Path(scene), set_) if is_recording(scene) else open_scene(scene, list(set_ or []))
    session.speed = speed
    session.playing = not paused
    with Viewer(session, host=host, port=port) as viewer:
        if viewer.port != port:
            say(f"port {port} is taken.")
        say(f"{session.title} (Ctrl-C ends it):")
        print(viewer.url, flush=True)
        if session.playing:
            say("Time runs while a browser is connected.")
        viewer.wait()
