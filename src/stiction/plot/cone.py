"""The friction cone with the impulses of every contact in it: in space, and from above along the normal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.plot import canvas
from stiction.plot.dots import MOST_POINTS, dot_size, opening, states, stride
from stiction.plot.points import Points
from stiction.plot.track import Track
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

RIM = 1.01
"""Shares of the static limit above this lie outside the cone."""
FAR = 1.3
"""The picture from above ends here; what lies farther out is counted in its title, and drawn at its edge."""


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: friction impulses over the static limit of their contact, so that one cone holds for all pairs.

    For arguments and errors see :func:`stiction.plot.dots.opening`.
    """
    figure, points = opening(track, bodies)
    points = points[points.coefficients[:, 0] > 0.0]
    share = shares(points)
    engine = figure.get_layout_engine()
    assert engine is not None  # the sheet has one
    engine.set(wspace=0.12)  # type: ignore[call-arg]  # the constrained one, whose own words these are
    grid = figure.add_gridspec(1, 2, width_ratios=(1.1, 1.0))
    _in_space(figure.add_subplot(grid[0], projection="3d"), points, share)
    flat = canvas.dress(figure.add_subplot(grid[1]))
    _from_above(flat, points, share)
    flat.set_title(_count(points, share), loc="left", fontsize=9.5, color=style.MUTED_INK)
    canvas.legend(figure, [*canvas.stick_and_slide(), *_circles()])
    return figure


def shares(points: Points) -> Array:
    """(r, 2) friction impulses over mu_s times the normal impulse: inside the unit circle where Coulomb's law holds."""
    limit = points.coefficients[:, 0] * points.rows["normal_impulse"]
    return np.asarray(points.tangential / limit[:, None])


def _count(points: Points, share: Array) -> str:
    """How many impulses there are, and how many lie outside.

    In ``soft`` some may, in steps of an impact: friction is limited by the load of a rigid contact, and impulses are
    those of a soft one.
    """
    outside = np.linalg.norm(share, axis=1) > RIM
    if not outside.any():
        return f"{len(points)} impulses, none outside"
    load = points.rows["normal_impulse"]
    part = 100.0 * float(load[outside].sum() / load.sum())
    return f"{len(points)} impulses, {int(outside.sum())} outside ({part:.2g} % of the load)"


def _circles() -> list[Any]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], **canvas.LIMITS["static"], label=r"static cone, $\mu_s g_n$"),
        Line2D([], [], **canvas.LIMITS["dynamic"], label=r"dynamic cone, $\mu_d g_n$"),
    ]


def _circle() -> Array:
    """(2, 181) the unit circle."""
    angle = np.radians(np.arange(0.0, 362.0, 2.0))
    return np.array([np.cos(angle), np.sin(angle)])


def _ratios(points: Points) -> list[float]:
    """The different mu_d / mu_s, at most three, those of the most contacts."""
    ratio = np.round(points.coefficients[:, 1] / points.coefficients[:, 0], 6)
    values, counts = np.unique(ratio, return_counts=True)
    return [float(v) for v in values[np.argsort(counts)[::-1][:3]] if v < 1.0]


def _from_above(axes: Axes, points: Points, share: Array) -> None:
    circle = _circle()
    axes.fill(*circle, color=style.GROUND, alpha=0.55, lw=0, zorder=0)
    step = stride(points)
    for state, color, mine in states(points):
        x, y = np.clip(share[mine][::step], -FAR, FAR).T
        axes.scatter(x, y, s=dot_size(points), color=color, alpha=0.5, lw=0, zorder=int(state))
    axes.plot(*circle, **canvas.LIMITS["static"], zorder=5)
    for ratio in _ratios(points):
        axes.plot(*(ratio * circle), **canvas.LIMITS["dynamic"], zorder=5)
    far = min(FAR, max(1.12, 1.05 * float(np.abs(share).max(initial=0.0))))
    axes.set(xlim=(-far, far), ylim=(-far, far), aspect="equal")
    axes.set_xlabel(r"$g_{t1}\,/\,\mu_s g_n$")
    axes.set_ylabel(r"$g_{t2}\,/\,\mu_s g_n$")


def _in_space(axes: Any, points: Points, share: Array) -> None:
    load = points.rows["normal_impulse"]
    top = 1.0
    if len(load):
        top = min(float(load.max()), 1.6 * float(np.percentile(load, 99.0)))
    unit, name = (1.0, "N s") if top >= 0.5 else (1000.0, "mN s")
    load, top = unit * load, unit * top
    circle, level = _circle(), np.linspace(0.0, 1.0, 2)
    axes.plot_surface(
        *(top * level[:, None] * circle[k] for k in (0, 1)), top * level[:, None] * np.ones_like(circle[0]),
        color=style.SERIES[0], alpha=0.10, lw=0, shade=False,
    )  # fmt: skip
    for height in (0.5, 1.0):
        axes.plot(*(top * height * circle), top * height, **canvas.LIMITS["static"])
    for ratio in _ratios(points)[:1]:
        axes.plot(*(ratio * top * circle), top, **canvas.LIMITS["dynamic"])
    step = stride(points, MOST_POINTS // 4)
    for _, color, mine in states(points):
        inside = mine & (load <= top)
        axes.scatter(
            *(load[inside, None] * share[inside])[::step].T, load[inside][::step], s=dot_size(points), color=color,
            alpha=0.45, lw=0, depthshade=False,
        )  # fmt: skip
    axes.set(xlim=(-top, top), ylim=(-top, top), zlim=(0.0, top))
    axes.set_xlabel(rf"$g_{{t1}}/\mu_s$ ({name})", fontsize=10, color=style.INK)
    axes.set_ylabel(rf"$g_{{t2}}/\mu_s$ ({name})", fontsize=10, color=style.INK)
    axes.set_zlabel(rf"$g_n$ ({name})", fontsize=10, color=style.INK)
    axes.tick_params(colors=style.MUTED_INK, labelsize=8.5, pad=0)
    axes.locator_params(nbins=5)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color(style.PAPER)
        # matplotlib has no public way to the lines of a grid in space
        axis._axinfo["grid"].update(color="#e8ecf0", linewidth=0.7)
    axes.view_init(elev=18.0, azim=-60.0)
    axes.set_box_aspect(None, zoom=0.9)
