"""Phase portraits: speed against place along the line on which a body moves most. Stick-slip is a loop in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.plot import canvas
from stiction.plot.track import Track
from stiction.record.frames import Frames
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MOST_BODIES = 9
COLUMNS = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 7: 3, 8: 3, 9: 3}
"""Columns of the grid by number of bodies."""


def along(frames: Frames, body: int) -> tuple[Array, Array]:
    """Place and speed of a body along its main direction, (f,) in m and m/s, the place counted from the first frame.

    The main direction is that of the largest variance of its positions, pointing where its largest part is positive.
    """
    x = frames.positions[:, body] - frames.positions[0, body]
    _, _, directions = np.linalg.svd(x - x.mean(axis=0), full_matrices=False)
    direction = directions[0]
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    return x @ direction, frames.velocities[:, body] @ direction


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: a panel a body, its path coloured by what it is doing.

    Raises:
        InvalidInputError: ``bodies`` is empty, names a body that is not there, or has more than nine names; or nothing
            can move.
    """
    from matplotlib.collections import LineCollection

    frames = track.frames
    chosen, remark = canvas.choose(frames, bodies, MOST_BODIES)
    figure = canvas.sheet(frames.title + remark)
    columns = COLUMNS[len(chosen)]
    rows = -(-len(chosen) // columns)
    first = None
    for place, body in enumerate(chosen):
        axes = figure.add_subplot(rows, columns, place + 1, sharex=first, sharey=first)
        canvas.dress(axes, 10.5 if rows == 1 else 9.0)
        first = first or axes
        path = np.stack(along(frames, body), axis=1)
        pieces = np.stack([path[:-1], path[1:]], axis=1)
        colors = [style.MOTION_COLORS[Motion(m)] for m in frames.motion[1:, body].tolist()]
        axes.add_collection(LineCollection(list(pieces), colors=colors, lw=1.8, capstyle="round"))
        axes.plot(*path[0], marker="o", ms=6, mfc=style.PAPER, mec=style.INK, zorder=4)
        axes.axhline(0.0, color=style.GRID_LINE, lw=0.8, zorder=0)
        if len(chosen) > 1:
            axes.set_title(canvas.short(frames.bodies[body].name), loc="left", fontsize=11, color=style.INK)
        if place % columns == 0:
            axes.set_ylabel("speed (m/s)")
        if place + columns >= len(chosen):
            axes.set_xlabel("place (m)")
    if first is not None:
        first.margins(0.06)
        first.autoscale_view()
    seen = [Motion(m) for m in np.unique(frames.motion[1:, chosen]).tolist()]
    canvas.legend(figure, [*(canvas.dot(style.MOTION_COLORS[m], m.word) for m in seen), _beginning()])
    return figure


def _beginning() -> object:
    from matplotlib.lines import Line2D

    return Line2D([], [], ls="", marker="o", ms=6, mfc=style.PAPER, mec=style.INK, label="beginning")
