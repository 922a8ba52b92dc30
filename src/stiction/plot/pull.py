"""Friction against the force that pulls: it answers with just as much, lets go at mu_s N, and drops to mu_d N."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.plot import canvas
from stiction.plot.run import body_forces
from stiction.plot.track import Track
from stiction.record.frames import Frames
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MOST_BODIES = 4
STEADY = 0.05
"""A limit that changes by no more than that share is drawn as one line."""
KILO_FROM = 5000.0
"""Forces above this many newtons are shown in kN."""


def pulling_force(track: Track, body: int) -> Array:
    """(f,) N: the size of everything but its contacts that drives a body along the surface that it touches.

    It is what Newton's second law leaves over, m a minus the forces of the contacts, without its share along the mean
    normal of the contacts; so gravity on a slope pulls, too. Exact where every step is a frame; where several steps
    are one, contacts are those of the last of them. 0 in the first frame, of which no acceleration is known; NaN where
    the body touches nothing, and where it has let go or come to rest in one of several steps of a frame.
    """
    frames = track.frames
    mass = frames.bodies[body].mass
    contact, normal = contact_forces(frames, body)
    acceleration = np.zeros_like(contact)
    acceleration[1:] = np.diff(frames.velocities[:, body], axis=0) / np.diff(frames.times)[:, None]
    driving = mass * acceleration - contact
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        n = normal / size
    along = np.asarray(np.linalg.norm(driving - n * np.sum(driving * n, axis=1, keepdims=True), axis=1))
    changed = frames.motion[1:, body] != frames.motion[:-1, body]
    along[1:][changed & (np.diff(frames.times) > 1.5 * frames.dt)] = np.nan
    along[0] = 0.0
    return along


def contact_forces(frames: Frames, body: int) -> tuple[Array, Array]:
    """Sum of all forces at the contacts of a body, and of their normal parts alone, each (f, 3) in N."""
    rows = frames.contacts
    frame = np.repeat(np.arange(len(frames)), np.diff(frames.contact_offsets))
    totals = np.zeros((2, len(frames), 3))
    for side, sign in (("body_b", 1.0), ("body_a", -1.0)):
        mine = rows[side] == body
        normal = sign / frames.dt * rows["normal"][mine] * rows["normal_impulse"][mine, None]
        friction = sign / frames.dt * rows["friction_impulse"][mine]
        np.add.at(totals[0], frame[mine], normal + friction)
        np.add.at(totals[1], frame[mine], normal)
    return totals[0], totals[1]


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: a panel a body, friction over pull, with the Coulomb limits.

    Raises:
        InvalidInputError: ``bodies`` is empty, names a body that is not there, or has more than four names; or nothing
            can move.
    """
    frames = track.frames
    chosen, remark = canvas.choose(frames, bodies, MOST_BODIES)
    figure = canvas.sheet(frames.title + remark)
    columns = 1 if len(chosen) == 1 else 2
    for place, body in enumerate(chosen):
        axes = canvas.dress(figure.add_subplot(-(-len(chosen) // columns), columns, place + 1))
        _panel(axes, track, body)
        if len(chosen) > 1:
            axes.set_title(canvas.short(frames.bodies[body].name), loc="left", fontsize=11, color=style.INK)
    handles = [canvas.dot(style.MOTION_COLORS[m], m.word) for m in _states(track, chosen)]
    canvas.legend(figure, [*handles, *canvas.limit_lines()])
    return figure


def _states(track: Track, bodies: list[int]) -> list[Motion]:
    return [Motion(m) for m in np.unique(track.frames.motion[:, bodies]).tolist() if m != Motion.FREE]


def _panel(axes: Axes, track: Track, body: int) -> None:
    frames = track.frames
    pull = pulling_force(track, body)
    forces = body_forces(frames, track.pairs, body)
    shown = np.isfinite(pull) & (np.arange(len(frames)) > 0)
    top = right = 1.0
    if shown.any():
        # an impact may stick out of the picture, or all else would be flat
        usual = float(np.percentile(forces.static_limit[shown], 95.0))
        top = max(1e-9, min(1.5 * usual, float(max(forces.static_limit[shown].max(), forces.friction[shown].max()))))
        right = max(1e-9, min(float(pull[shown].max()), 3.0 * top))
    unit, name = (1000.0, "kN") if max(top, right) >= KILO_FROM else (1.0, "N")
    top, right = top / unit, right / unit

    axes.plot([0.0, 2.0 * top], [0.0, 2.0 * top], color=style.GRID_LINE, lw=1.2, zorder=1)
    for key, limit in (("static", forces.static_limit), ("dynamic", forces.dynamic_limit)):
        _limit(axes, key, pull[shown] / unit, limit[shown] / unit)
    axes.plot(pull[shown] / unit, forces.friction[shown] / unit, color=style.GRID_SECTION, lw=0.9, zorder=2)
    for state in _states(track, [body]):
        these = shown & (frames.motion[:, body] == state)
        color = style.MOTION_COLORS[state]
        axes.scatter(pull[these] / unit, forces.friction[these] / unit, s=14, color=color, lw=0, zorder=4)
    axes.set(xlim=(0.0, 1.05 * right), ylim=(0.0, 1.18 * top))
    axes.set_xlabel(f"pulling force ({name})")
    axes.set_ylabel(f"friction force ({name})")


def _limit(axes: Axes, key: str, pull: Array, limit: Array) -> None:
    """A line with its value where the limit is steady, dots where the load changes."""
    look: dict[str, Any] = canvas.LIMITS[key]
    loaded = limit[limit > 0.0]
    if not len(loaded):
        return
    low, middle, high = np.percentile(loaded, [5.0, 50.0, 95.0])
    if high - low > STEADY * middle:
        axes.plot(pull, limit, ls="", marker="_" if key == "static" else ".", ms=3, color=look["color"], zorder=3)
        return
    axes.axhline(middle, **look, zorder=3)
    symbol = r"$\mu_s N$" if key == "static" else r"$\mu_d N$"
    where = (0.015, float(middle))
    canvas.note(
        axes, f"{symbol} = {middle:.4g}", where, xycoords=("axes fraction", "data"), ha="left", va="bottom",
        xytext=(0, 2), textcoords="offset points",
    )  # fmt: skip
