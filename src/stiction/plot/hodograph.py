"""Sliding against turning: the path of (R w, v) as friction brakes both, and the ratio at which a disc ends.

A disc that slides and spins comes to rest along one line, v = 0.653 R w, wherever it began (Farkas, Bartels, Unger and
Wolf, "Frictional coupling between sliding and spinning motion", Phys. Rev. Lett. 90, 248302, 2003); a ball ends on
v = R w, and rolls.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.plot import canvas
from stiction.plot.track import Track
from stiction.record.frames import Frames
from stiction.scene.placing import turned
from stiction.shapes import Capsule, Cylinder, Sphere
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MOST_BODIES = 9
LEAST = 0.01
"""Share of its first speed down to which a body is followed; below it a step or two end all motion."""
ENDING = 0.1
"""Where a body ends below that share, ratios are drawn over what is left, down to little; else over time."""
RINGS, SPOKES = 400, 400
"""Points on a disc over which friction is summed."""


@functools.cache
def common_ratio() -> float:
    """v / (R w) at which a disc under even pressure ends, whatever the friction: 0.653.

    There sliding and spinning are braked in proportion, v' / v = w' / w, with the force and the torque of Coulomb's
    law summed over the disc, and I = m R^2 / 2. Found by halving.
    """
    rho = np.sqrt((np.arange(RINGS) + 0.5) / RINGS)
    angle = 2.0 * np.pi * (np.arange(SPOKES) + 0.5) / SPOKES
    x, y = (np.outer(rho, turn(angle)) for turn in (np.cos, np.sin))
    low, high = 0.1, 1.0
    for _ in range(40):
        ratio = 0.5 * (low + high)
        ux, uy = ratio - y, x
        size = np.hypot(ux, uy)
        force, torque = np.mean(ux / size), np.mean((x * uy - y * ux) / size)
        # where sliding is braked the more, its share falls: the ratio at which it no longer does lies below
        low, high = (low, ratio) if force / ratio > 2.0 * torque else (ratio, high)
    return low


def speeds(frames: Frames, body: int) -> tuple[Array, Array]:
    """Speed v and speed of turning R w of a body, (f,) each, in m/s.

    R is the radius of a round body; of another one that of a disc with its moment of inertia, sqrt(2 I / m), about the
    axis about which it turns at first.
    """
    shape = frames.bodies[body].shape
    spin = frames.angular_velocities[:, body]
    if isinstance(shape, (Cylinder, Sphere, Capsule)):
        radius = shape.radius
    else:
        begins = int(np.argmax(np.linalg.norm(spin, axis=1)))
        axis = turned(frames.orientations[begins, body] * (1.0, -1.0, -1.0, -1.0), spin[begins])
        properties = shape.mass_properties
        size = float(axis @ axis)
        inertia = float(axis @ properties.inertia @ axis) / size if size > 0.0 else 0.0
        radius = math.sqrt(2.0 * inertia / properties.volume)
    return np.linalg.norm(frames.velocities[:, body], axis=1), radius * np.linalg.norm(spin, axis=1)


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: left the hodograph, right the ratio of both speeds over the share of motion that is left.

    Raises:
        InvalidInputError: ``bodies`` is empty, names a body that is not there, or has more than nine names; or nothing
            can move.
    """
    frames = track.frames
    chosen, remark = canvas.choose(frames, bodies, MOST_BODIES)
    figure = canvas.sheet(frames.title + remark)
    left, right = (canvas.dress(figure.add_subplot(1, 2, place)) for place in (1, 2))
    handles, paths = [], [speeds(frames, body) for body in chosen]
    ends = min(_left(v, turning)[-1] for v, turning in paths) < ENDING
    for number, (body, (v, turning)) in enumerate(zip(chosen, paths, strict=True)):
        color = style.SERIES[number % len(style.SERIES)]
        left.plot(turning, v, color=color, lw=2.0, zorder=3)
        left.plot(turning[0], v[0], marker="o", ms=6, mfc=style.PAPER, mec=color, mew=1.6, zorder=4, clip_on=False)
        share = _left(v, turning)
        alive = np.logical_and.accumulate(share > LEAST) & (turning > 1e-6 * turning.max())
        across = share if ends else frames.times
        right.plot(across[alive], v[alive] / turning[alive], color=color, lw=2.0, zorder=3)
        handles.append(canvas.dot(color, canvas.short(frames.bodies[body].name)))
    for ratio, words in _ends(frames, chosen):
        far = max(float(turning.max()) for _, turning in paths)
        left.plot([0.0, 2.0 * far], [0.0, 2.0 * far * ratio], **canvas.LIMITS["static"], zorder=2)
        right.axhline(ratio, **canvas.LIMITS["static"], zorder=2)
        canvas.note(
            right, words, (0.02, ratio), xycoords=("axes fraction", "data"), xytext=(0, -4),
            textcoords="offset points", va="top", zorder=6,
        )  # fmt: skip
    _finish(left, right, paths, ends)
    canvas.legend(figure, handles)
    return figure


def _ends(frames: Frames, chosen: list[int]) -> list[tuple[float, str]]:
    """Ratios v / (R w) at which bodies of these shapes end, and what to write there."""
    shapes = [frames.bodies[body].shape for body in chosen]
    ends = []
    if any(isinstance(shape, Cylinder) for shape in shapes):
        ends.append((common_ratio(), rf"$v = {common_ratio():.3f}\,R\omega$"))
    if any(isinstance(shape, Sphere) for shape in shapes):
        ends.append((1.0, r"rolls: $v = R\omega$"))
    return ends


def _left(v: Array, turning: Array) -> Array:
    """(f,) which share of its first speed, sqrt(v^2 + (R w)^2), a body has left."""
    size = np.hypot(v, turning)
    return np.asarray(size / max(float(size[0]), 1e-300))


def _finish(left: Axes, right: Axes, paths: list[tuple[Array, Array]], ends: bool) -> None:
    widest, highest = (max(1e-9, *(float(path[k].max()) for path in paths)) for k in (1, 0))
    left.set(xlim=(0.0, 1.06 * widest), ylim=(0.0, 1.06 * highest))
    left.set_xlabel(r"speed of turning $R\omega$ (m/s)")
    left.set_ylabel(r"speed $v$ (m/s)")
    if ends:
        right.set_xscale("log")
        right.set_xlim(1.0, LEAST)
        right.set_xticks([1.0, 0.1, 0.01], ["100 %", "10 %", "1 %"])
        right.set_xlabel(r"speed that is left, $\sqrt{v^2 + (R\omega)^2}$")
    else:
        right.set_xlabel("time (s)")
    right.set_ylim(0.0, min(2.5, max(1.1, right.get_ylim()[1])))
    right.set_ylabel(r"$v\,/\,R\omega$")
