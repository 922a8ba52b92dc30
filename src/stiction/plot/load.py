"""Friction against load: every contact of a run as a point below its Coulomb limits, the cone seen from the side.

A contact is a face here: the points at which two bodies touch are taken together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction.plot import canvas
from stiction.plot.dots import dot_size, opening, states, stride
from stiction.plot.points import Points
from stiction.plot.track import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LIMITS = 3
"""Pairs of coefficients whose lines are drawn."""


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: one point a contact and frame, in N, with lines of slope mu_s and mu_d.

    For arguments and errors see :func:`stiction.plot.dots.opening`.
    """
    figure, points = opening(track, bodies)
    axes = canvas.dress(figure.add_subplot())
    load = points.rows["normal_impulse"] / track.frames.dt
    friction = np.linalg.norm(points.rows["friction_impulse"], axis=1) / track.frames.dt
    # an impact may stick out of the picture, or all else would lie in the corner
    usual = 1.6 * float(np.percentile(load, 99.0)) if len(load) else 1.0
    right = min(usual, float(load.max())) if len(load) else 1.0
    for state, color, mine in states(points):
        step = stride(points)
        axes.scatter(
            load[mine][::step],
            friction[mine][::step],
            s=dot_size(points),
            color=color,
            alpha=0.5,
            lw=0,
            zorder=int(state),
        )
    axes.set_xlim(0.0, 1.12 * right)
    top = 1.08 * max([1e-12, *(1.05 * right * mu for mu in points.coefficients.max(axis=0, initial=0.0))])
    axes.set_ylim(0.0, top)
    _limits(axes, track, points, right, top)
    axes.set_xlabel("load on a contact (N)")
    axes.set_ylabel("friction there (N)")
    canvas.legend(figure, [*canvas.stick_and_slide(), *canvas.limit_lines()])
    return figure


def _limits(axes: Axes, track: Track, points: Points, right: float, top: float) -> None:
    """Lines of the pairs that carry most of the load, each with its coefficients at the end."""
    pairs, inverse = np.unique(points.coefficients, axis=0, return_inverse=True)
    weight = np.bincount(inverse.ravel(), points.rows["normal_impulse"], len(pairs))
    taken: list[float] = []
    for pair in np.argsort(weight)[::-1][:MOST_LIMITS].tolist():
        for key, symbol, mu in zip(("static", "dynamic"), "sd", pairs[pair].tolist(), strict=True):
            axes.plot([0.0, 1.05 * right], [0.0, 1.05 * right * mu], **canvas.LIMITS[key], zorder=5)
            end = 1.05 * right * mu / top
            if all(abs(end - other) > 0.045 for other in taken):
                taken.append(end)
                canvas.note(axes, rf"$\mu_{symbol}$ = {mu:g}", (1.06 * right, end * top), va="center", zorder=6)
