"""Contacts as dots: which of a run are drawn, how large, and in which colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.plot import canvas
from stiction.plot.points import Points, contact_points, faces, loaded
from stiction.plot.track import Track
from stiction.record.frames import Frames
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 20_000
"""Points that are drawn; of more, every so many-th is taken."""
DOT, FEW = 8.0, 3000
"""Size of a dot, and how many of them are few enough to be drawn three times as large."""


def opening(track: Track, bodies: list[str] | None) -> tuple[Figure, Points]:
    """An empty sheet for a figure of contacts, and the contacts.

    Args:
        track: the run.
        bodies: names of the bodies whose contacts are shown; all of them if left out.

    Raises:
        InvalidInputError: ``bodies`` is empty or names a body that is not there.
    """
    return canvas.sheet(track.frames.title), chosen_points(track, bodies)


def chosen_numbers(frames: Frames, bodies: list[str] | None) -> list[int] | None:
    """Numbers of the bodies that are named, or None for all of them.

    Raises:
        InvalidInputError: ``bodies`` is empty or names a body that is not there.
    """
    return None if bodies is None else canvas.choose(frames, bodies, len(frames.bodies))[0]


def chosen_points(track: Track, bodies: list[str] | None) -> Points:
    """The loaded faces of all bodies, or of those that are named."""
    return loaded(faces(contact_points(track.frames, track.pairs, chosen_numbers(track.frames, bodies))))


def stride(points: Points, most: int = MOST_POINTS) -> int:
    """Every so many-th of the points is drawn, so that they are ``most`` at most."""
    return max(1, -(-len(points) // most))


def dot_size(points: Points) -> float:
    """Size of a dot in square points."""
    return DOT if len(points) > FEW else 3.0 * DOT


def states(points: Points) -> list[tuple[Motion, str, NDArray[np.bool_]]]:
    """The two states of a contact, each with its colour and which points are in it."""
    held = points.rows["sticking"]
    return [(m, style.MOTION_COLORS[m], held == (m == Motion.STICKING)) for m in (Motion.STICKING, Motion.SLIDING)]
