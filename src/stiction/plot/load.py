"""Friction against load: every contact of a run as a point below its Coulomb limits, the cone seen from the side.

A contact is a face here: the points at which two bodies touch are taken together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction.motion import Motion
from stiction.plot import canvas
from stiction.plot.points import Points, contact_points, faces, loaded
from stiction.plot.track import Track
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 20_000
"""Points that are drawn; of more, every so many-th is taken."""
DOT, FEW = 8.0, 3000
"""Size of a dot, and how many of them are few enough to be drawn three times as large."""
MOST_LIMITS = 3
"""Pairs of coefficients whose lines are drawn."""


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: one point a contact and frame, in N, with lines of slope mu_s and mu_d.

    Args:
        track: the run.
        bodies: names of the bodies whose contacts are shown; all of them if left out.

    Raises:
        InvalidInputError: ``bodies`` is empty or names a body that is not there.
    """
    points = chosen_points(track, bodies)
    figure = canvas.sheet(track.frames.title)
    axes = canvas.dress(figure.add_subplot())
    load = points.rows["normal_impulse"] / track.frames.dt
    friction = np.linalg.norm(points.rows["friction_impulse"], axis=1) / track.frames.dt
    # an impact may stick out of the picture, or all else would lie in the corner
    usual = 1.6 * float(np.percentile(load, 99.0)) if len(load) else 1.0
    right = min(usual, float(load.max())) if len(load) else 1.0
    for state, color, mine in states(points):
        step = max(1, -(-len(points) // MOST_POINTS))
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


def chosen_points(track: Track, bodies: list[str] | None) -> Points:
    """The loaded faces of all bodies, or of those that are named."""
    frames = track.frames
    numbers = None if bodies is None else canvas.choose(frames, bodies, len(frames.bodies))[0]
    return loaded(faces(contact_points(frames, track.pairs, numbers)))


def dot_size(points: Points) -> float:
    """Size of a dot in square points."""
    return DOT if len(points) > FEW else 3.0 * DOT


def states(points: Points) -> list[tuple[Motion, str, np.ndarray]]:
    """The two states of a contact, each with its colour and which points are in it."""
    held = points.rows["sticking"]
    return [(m, style.MOTION_COLORS[m], held == (m == Motion.STICKING)) for m in (Motion.STICKING, Motion.SLIDING)]


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
