"""A run as a figure: speed and friction force of every body over time, with the Coulomb limits drawn in.

The picture shows the law at work: while a body sticks, friction is whatever holds it, anywhere below the static limit
mu_s N; while it slides, friction lies on the dynamic limit mu_d N.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.plot.canvas import LIMITS, check_path, choose, dress, limit_lines, save
from stiction.plot.points import Pairs, contact_points
from stiction.record.frames import Frames
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiction.plot.track import Track

Array = NDArray[np.float64]

MOST_BODIES = 9
COLUMNS = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 7: 4, 8: 4, 9: 3}
"""Columns of the grid by number of bodies."""
SIZE = (13.333, 7.5)
"""Inches: a slide of 16 to 9."""
LEAST_SPEED = 0.05
"""The speed axis reaches at least this far, in m/s, so that rounding at rest does not look like motion."""
LINE = 90
"""Letters that fit above a row of axes beside the coefficients."""
KILO_FROM = 5000.0
"""Forces above this many newtons are shown in kN."""


@dataclass(frozen=True)
class BodyForces:
    """Contact forces on one body, each (f,) in N.

    Attributes:
        friction: size of the sum of the friction forces at all its contact points.
        static_limit: sum of mu_s N over its contact points.
        dynamic_limit: sum of mu_d N over its contact points.
        coefficients: the pairs (static, dynamic) that occur at its contacts.
    """

    friction: Array
    static_limit: Array
    dynamic_limit: Array
    coefficients: set[tuple[float, float]]


def plot_run(frames: Frames, pairs: Pairs, path: str | Path, *, bodies: list[str] | None = None) -> Path:
    """Writes speed and friction force of up to nine moving bodies over time as a picture that fits on a slide.

    Args:
        frames: the run.
        pairs: gives for the names of two materials what has ``static`` and ``dynamic``, their coefficients.
        path: of the picture; the ending (png, svg, pdf) chooses the format, its folder must exist.
        bodies: names of the bodies to show; by default the first nine that can move.

    Returns:
        The path of the picture.

    Raises:
        InvalidInputError: see :func:`run_figure`.
        OutputError: the picture cannot be written, or its ending names no known format; found out before any work.
    """
    target = check_path("path", path)
    return save(run_figure(frames, pairs, bodies=bodies), target)


def run_figure(frames: Frames, pairs: Pairs, *, bodies: list[str] | None = None) -> Figure:
    """The figure of :func:`plot_run`: two axes a body, speed above and friction force below.

    Raises:
        InvalidInputError: ``frames`` is empty or nothing in it can move, or ``bodies`` is empty, names a body that
            is not there, or has more than nine names.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    chosen, note = choose(frames, bodies, MOST_BODIES)
    layout = ConstrainedLayoutEngine(h_pad=0.03, w_pad=0.08, hspace=0.0, wspace=0.03)
    figure = Figure(figsize=SIZE, layout=layout, facecolor=style.PAPER)
    figure.suptitle(frames.title + note, x=0.012, ha="left", fontsize=17, fontweight="bold", color=style.INK)
    columns = COLUMNS[len(chosen)]
    rows = -(-len(chosen) // columns)
    grid = figure.add_gridspec(rows, columns)

    speeds = {n: np.linalg.norm(frames.velocities[:, n], axis=1) for n in chosen}
    forces = {n: body_forces(frames, pairs, n) for n in chosen}
    top_speed = max(float(speed.max()) for speed in speeds.values())
    unit, name = (1000.0, "kN") if max(_force_top(force) for force in forces.values()) >= KILO_FROM else (1.0, "N")

    for place, n in enumerate(chosen):
        row, column = divmod(place, columns)
        cell = grid[row, column].subgridspec(2, 1, hspace=0.0)
        upper = figure.add_subplot(cell[0])
        lower = figure.add_subplot(cell[1], sharex=upper)
        for axes in (upper, lower):
            _dress(axes, frames.times, frames.motion[:, n])
        _draw_speed(upper, frames.times, speeds[n], top_speed)
        _draw_forces(lower, frames.times, forces[n], unit)
        upper.tick_params(labelbottom=False)
        upper.set_title(frames.bodies[n].name, loc="left", fontsize=11, fontweight="bold", color=style.INK, pad=4)
        # a long name needs the room for itself
        if len(forces[n].coefficients) == 1 and len(frames.bodies[n].name) * columns <= LINE:
            static, dynamic = next(iter(forces[n].coefficients))
            text = rf"$\mu_s$ = {static:g}, $\mu_d$ = {dynamic:g}"
            upper.set_title(text, loc="right", fontsize=9.5, color=style.MUTED_INK, pad=4)
        if column == 0:
            upper.set_ylabel("speed\n(m/s)")
            lower.set_ylabel(f"friction\n({name})")
            figure.align_ylabels([upper, lower])
        if place + columns >= len(chosen):
            lower.set_xlabel("time (s)")
    _add_legend(figure, {Motion(int(m)) for m in np.unique(frames.motion[:, chosen])})
    return figure


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure of :func:`plot_run` for a track."""
    return run_figure(track.frames, track.pairs, bodies=bodies)


def body_forces(frames: Frames, pairs: Pairs, body: int) -> BodyForces:
    """Friction on a body and its Coulomb limits, frame by frame.

    A contact's impulses (N s) act on its second body and, reversed, on its first; divided by the time step they are the
    mean forces of that step. Forces add as vectors, limits as numbers: between two surfaces that pull in opposite
    directions a body can feel no friction although both are at their limits.

    Args:
        frames: the run.
        pairs: gives for the names of two materials what has ``static`` and ``dynamic``, their coefficients.
        body: number of the body.
    """
    points = contact_points(frames, pairs, [body])
    rows = points.rows
    sign = np.where(rows["body_b"] == body, 1.0, -1.0)
    friction = np.zeros((len(frames), 3))
    np.add.at(friction, points.frame, sign[:, None] * rows["friction_impulse"] / frames.dt)
    limits = np.zeros((len(frames), 2))
    np.add.at(limits, points.frame, points.coefficients * rows["normal_impulse"][:, None] / frames.dt)
    occurring = {(float(static), float(dynamic)) for static, dynamic in np.unique(points.coefficients, axis=0)}
    return BodyForces(np.linalg.norm(friction, axis=1), limits[:, 0], limits[:, 1], occurring)


# --- drawing ----------------------------------------------------------------------------------------------------------


def _dress(axes: Axes, times: Array, motion: NDArray[np.uint8]) -> None:
    """Frame, ticks, and the phases of motion as a coloured ground."""
    dress(axes, 9)
    axes.locator_params(axis="y", nbins=3)
    axes.locator_params(axis="x", nbins=6)
    # as high as the axes, whatever the numbers on them
    full_height = axes.get_xaxis_transform()
    for state in np.unique(motion).tolist():
        color = style.MOTION_COLORS[Motion(state)]
        spans = phases(times, motion == state)
        axes.broken_barh(spans, (0.0, 1.0), transform=full_height, color=color, alpha=0.25, lw=0, zorder=0)
    axes.set_xlim(times[0], times[-1] if times[-1] > times[0] else times[0] + 1.0)


def phases(times: Array, holds: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Start and length of every stretch of frames for which something holds; a frame lasts until the next one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(int)))
    ends = np.append(times, times[-1])
    return [(float(times[a]), float(ends[b] - times[a])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _draw_speed(axes: Axes, times: Array, speed: Array, top: float) -> None:
    axes.plot(times, speed, color=style.INK, lw=2.0, solid_capstyle="round")
    top = max(top, LEAST_SPEED)
    axes.set_ylim(-0.04 * top, 1.12 * top)


def _draw_forces(axes: Axes, times: Array, forces: BodyForces, unit: float) -> None:
    # limits over the force, so that they can be seen where it lies on one
    axes.plot(times, forces.friction / unit, color=style.FRICTION, lw=2.6, solid_capstyle="round", zorder=2)
    axes.plot(times, forces.static_limit / unit, **LIMITS["static"], zorder=3)
    axes.plot(times, forces.dynamic_limit / unit, **LIMITS["dynamic"], zorder=3)
    top = _force_top(forces) / unit
    axes.set_ylim(-0.04 * top, 1.15 * top)


def _force_top(forces: BodyForces) -> float:
    """Largest force to show in N: an impact may stick out of the picture, or all else would be flat."""
    both = np.concatenate([forces.static_limit, forces.dynamic_limit, forces.friction])
    both = both[both > 0.0]
    if not len(both):
        return 1.0
    usual, most = 1.5 * float(np.percentile(both, 95)), float(both.max())
    return min(usual, most)


def _add_legend(figure: Figure, states: set[Motion]) -> None:
    """One legend for all axes, below them."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], color=style.INK, lw=2.0, label="speed"),
        Line2D([], [], color=style.FRICTION, lw=2.6, label="friction force"),
        *limit_lines(),
    ]
    handles += [Patch(color=style.MOTION_COLORS[s], alpha=0.35, lw=0, label=s.word) for s in sorted(states)]
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=len(handles),
        frameon=False,
        fontsize=10.5,
        labelcolor=style.INK,
        handlelength=2.0,
        columnspacing=1.6,
    )
