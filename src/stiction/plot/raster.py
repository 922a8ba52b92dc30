"""The stick-slip raster: a row for every two bodies that touch, time to the right, colours for stick and slip."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.plot import canvas
from stiction.plot.dots import chosen_numbers
from stiction.plot.points import contact_points
from stiction.plot.track import Track
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_ROWS = 400
MOST_NAMES = 16
"""Rows up to which each has its name beside it."""
APART, HELD, SLIPS = 0, 1, 2


def states(track: Track, bodies: list[int] | None = None) -> tuple[list[tuple[int, int]], NDArray[np.uint8]]:
    """Pairs of bodies that touch at some time, p of them, and their state (p, f) at each frame.

    A pair slips (2) if one of its loaded contact points slips, is held (1) if all of them hold, and is apart (0) if
    there are none. Pairs are in the order in which they first touch.

    Args:
        track: the run.
        bodies: numbers of bodies; only pairs with one of them. All of them if left out.
    """
    points = contact_points(track.frames, track.pairs, bodies)
    points = points[points.rows["normal_impulse"] > 0.0]
    ends = np.stack([points.rows["body_a"], points.rows["body_b"]], axis=1)
    pairs, begins, inverse = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(begins, kind="stable")
    row = np.argsort(order)[inverse.ravel()]
    raster = np.zeros((len(pairs), len(track.frames)), np.uint8)
    np.maximum.at(raster, (row, points.frame), np.where(points.rows["sticking"], HELD, SLIPS).astype(np.uint8))
    return [(int(a), int(b)) for a, b in pairs[order]], raster


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: the raster, and above it the share of contacts that slip.

    Args:
        track: the run.
        bodies: names of the bodies whose contacts are shown; all of them if left out.

    Raises:
        InvalidInputError: ``bodies`` is empty or names a body that is not there.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    frames = track.frames
    pairs, raster = states(track, chosen_numbers(frames, bodies))
    remark = f"  ({MOST_ROWS} of {len(pairs)} pairs)" if len(pairs) > MOST_ROWS else ""
    pairs, raster = pairs[:MOST_ROWS], raster[:MOST_ROWS]

    figure = canvas.sheet(frames.title + remark)
    grid = figure.add_gridspec(2, 1, height_ratios=(1, 3))
    upper, lower = (canvas.dress(figure.add_subplot(grid[row])) for row in (0, 1))
    upper.sharex(lower)

    touching = np.maximum(1, np.sum(raster != APART, axis=0))
    # a frame lasts until the next one
    edges = np.append(frames.times, 2.0 * frames.times[-1] - frames.times[-2] if len(frames) > 1 else frames.dt)
    slipping = np.sum(raster == SLIPS, axis=0) / touching
    upper.stairs(100.0 * slipping, edges, fill=True, color=style.MOTION_COLORS[Motion.SLIDING], alpha=0.8)
    upper.set_ylim(0.0, 105.0)
    upper.set_ylabel("slipping (%)")
    upper.tick_params(labelbottom=False)

    colors = [style.PAPER, style.MOTION_COLORS[Motion.STICKING], style.MOTION_COLORS[Motion.SLIDING]]
    norm = BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3)
    rows = np.arange(len(pairs) + 1) - 0.5
    if len(pairs):
        lower.pcolormesh(edges, rows, raster, cmap=ListedColormap(colors), norm=norm, rasterized=True)
        lower.set_ylim(len(pairs) - 0.5, -0.5)
    lower.set_xlim(edges[0], edges[-1])
    lower.set_xlabel("time (s)")
    if 0 < len(pairs) <= MOST_NAMES:
        names = [body.name for body in frames.bodies]
        lower.set_yticks(range(len(pairs)), [canvas.short(f"{names[a]} – {names[b]}") for a, b in pairs])
        lower.hlines(rows[1:-1], edges[0], edges[-1], color=style.PAPER, lw=3)
    else:
        lower.set_ylabel("pair of bodies")
    figure.align_ylabels([upper, lower])
    canvas.legend(
        figure,
        [Patch(color=colors[HELD], lw=0, label="sticking"), Patch(color=colors[SLIPS], lw=0, label="slipping")],
    )
    return figure
