"""Showing a world that somebody has at hand, in a notebook or from a program."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiction.view.server import HOST, PORT, Viewer
from stiction.view.session import LiveSession

if TYPE_CHECKING:
    from stiction.world import World


def show(world: World, *, title: str = "a world", host: str = HOST, port: int = PORT) -> Viewer:
    """A live view of a world; a notebook shows it in its cell. See :meth:`stiction.World.show`."""
    return Viewer(LiveSession(world, title), host=host, port=port)
