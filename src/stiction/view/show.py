"""Showing a world or a recording that somebody has at hand, in a notebook or from a program."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from stiction.view.html import page_of
from stiction.view.playback import Playback
from stiction.view.server import HOST, PORT, Viewer
from stiction.view.session import LiveSession

if TYPE_CHECKING:
    from stiction.record.frames import Frames
    from stiction.record.recording import Recording
    from stiction.world import World


def show(world: World, *, title: str = "a world", host: str = HOST, port: int = PORT) -> Viewer:
    """A live view of a world; a notebook shows it in its cell. See :meth:`stiction.World.show`."""
    return Viewer(LiveSession(world, title), host=host, port=port)


def playback_of(recording: Recording, start: float | None = None, stop: float | None = None) -> Playback:
    """A recording, or a part of it, as a session."""
    if recording.format_version == 1:
        return Playback(recording.frames(start, stop))
    rows = recording.energies[recording.span(start, stop)]
    dissipated = rows["friction"] + rows["rolling"] + rows["impacts"]
    energies = np.column_stack([rows["kinetic"], rows["potential"], dissipated])
    return Playback(recording.frames(start, stop), energies)


class Inline:
    """A run as a page that plays inside the notebook's own file, also where nothing of Python runs any more.

    Args:
        frames: the run. height: of the picture, pixels.
    """

    def __init__(self, frames: Frames, height: int = 480) -> None:
        self.page = page_of(frames)
        self.height = height

    def __repr__(self) -> str:
        return f"<Inline page of {len(self.page) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        text = html.escape(self.page, quote=True)
        return f'<iframe srcdoc="{text}" width="100%" height="{self.height}" style="border:1px solid #dee2e6"></iframe>'
