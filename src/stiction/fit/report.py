"""A fit for the eye and for programs: plain data, and the figure of what is left over."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.fit.problem import Problem, rotation_between
from stiction.fit.solve import Fit
from stiction.plot.canvas import dress, legend, save, sheet, short
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXES = "xyz"
COLORS = ("#0072b2", "#e8590c", "#008f68", "#6a3d9a")
MOST_BODIES = 4
"""Bodies in a figure, a column each."""


def misfit(problem: Problem, made: Fit) -> dict[str, float | None]:
    """Root mean square of what is left over: ``position`` in m, ``angle`` in rad about each axis; None if not measured.

    Args:
        problem: what was fitted. made: the result.
    """
    f, turns = made.residuals, problem.angular
    place, angle = f[~turns], f[turns]
    return {
        "position": problem.sigma * float(np.sqrt(np.mean(place**2))) if len(place) else None,
        "angle": problem.sigma_angle * float(np.sqrt(np.mean(angle**2))) if len(angle) else None,
    }


def as_dict(problem: Problem, made: Fit, level: float) -> dict[str, Any]:
    """Everything that was found, as plain data in SI units.

    Args:
        problem: what was fitted. made: the result. level: of the intervals.
    """
    left = misfit(problem, made)
    return {
        "scene": problem.scene.name,
        "bodies": [track.body for track in problem.tracks],
        "numbers": problem.count,
        "level": level,
        "intervals": made.method,
        "parameters": [estimate.as_dict() for estimate in made.estimates],
        "correlation": made.correlation.tolist(),
        "rms_position_m": left["position"],
        "rms_angle_rad": left["angle"],
        "remarks": list(made.remarks),
        "simulations": problem.simulations,
        "seconds": made.seconds,
        "starts": [
            {"values": end.tolist(), "cost": float(cost)} for end, cost in zip(made.ends, made.costs, strict=True)
        ],
        "interrupted": made.interrupted,
    }


def draw(problem: Problem, made: Fit, path: str | Path) -> Path:
    """Measured and simulated motion, and below it their differences over time.

    Args:
        problem: what was fitted. made: the result. path: of the picture (png, svg or pdf).

    Returns:
        The path.

    Raises:
        OutputError: the picture cannot be written, or its ending names no known format.
    """
    from matplotlib.lines import Line2D

    motions = problem.simulate(made.x)
    shown = min(MOST_BODIES, len(problem.tracks))
    remark = f"  ({shown} of {len(problem.tracks)} bodies)" if shown < len(problem.tracks) else ""
    found = ",  ".join(f"{e.parameter.name} = {_value(e.value, e.error)}" for e in made.estimates[:2])
    more = " …" if len(made.estimates) > 2 else ""
    turned = any(track.orientations is not None for track in problem.tracks)
    figure = sheet(f"{problem.scene.title}: measured and fitted{remark}", (max(9.6, 4.2 * shown), 7.6 if turned else 6))
    grid = figure.subplots(
        3 if turned else 2, shown, sharex="col", squeeze=False, height_ratios=[2, 1, 1] if turned else [2, 1]
    )
    for k in range(shown):
        track, motion = problem.tracks[k], motions[k]
        top, below = dress(grid[0, k]), dress(grid[1, k])
        top.set_title(short(problem.names[k]), loc="left", fontsize=11, color=style.INK)
        origin = motion.positions[0]
        off = track.positions - motion.positions
        for axis in range(3):
            color = COLORS[axis]
            top.plot(track.times, track.positions[:, axis] - origin[axis], ".", ms=3, color=color, alpha=0.45)
            top.plot(track.times, motion.positions[:, axis] - origin[axis], "-", lw=1.5, color=color)
            below.plot(track.times, 1e3 * off[:, axis], ".", ms=3, color=color, alpha=0.6)
        _zero(below)
        last = below
        if turned:
            last = dress(grid[2, k])
            if track.orientations is not None:
                turn = np.degrees(rotation_between(motion.orientations, track.orientations))
                for axis in range(3):
                    last.plot(track.times, turn[:, axis], ".", ms=3, color=COLORS[axis], alpha=0.6)
            _zero(last)
        last.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("moved [m]")
    grid[1, 0].set_ylabel("left over [mm]")
    if turned:
        grid[2, 0].set_ylabel("left over [deg]")
    figure.align_ylabels(grid[:, 0])
    lines = [Line2D([], [], color=COLORS[k], lw=2, label=AXES[k]) for k in range(3)]
    marks = [
        Line2D([], [], ls="", marker=".", ms=7, color=style.INK, label="measured"),
        Line2D([], [], color=style.INK, lw=1.5, label="simulated"),
    ]
    legend(figure, [*lines, *marks])
    if shown == 1:  # beside the name of the only body there is room
        grid[0, 0].set_title(found + more, loc="right", fontsize=10, color=style.INK)
    return save(figure, path)


def _zero(axes: Axes) -> None:
    axes.axhline(0.0, color=style.GRID_SECTION, lw=1.0, zorder=0)


def _value(value: float, error: float) -> str:
    """A value with as many digits as its error leaves: ``0.4012 ± 0.0003``."""
    if not math.isfinite(error) or error <= 0.0:
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}"
