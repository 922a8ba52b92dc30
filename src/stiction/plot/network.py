"""The contact network of a heap: who leans on whom, how hard, and how near each contact is to giving way."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.plot import canvas
from stiction.plot.dots import chosen_points
from stiction.plot.track import Track
from stiction.record.frames import Frames
from stiction.scene.placing import turned
from stiction.view import style
from stiction.view.meshes import solid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

WIDEST = 7.0
"""Points: the width of the line of the largest load."""
FLAT = 0.2
"""What is no higher than that share of its lesser extent across gravity is seen from above, unless it is a mere row."""
MOBILISED = ("#0b3c5d", "#328cc1", "#f2c14e", "#e8590c")
"""Colours of a contact from no friction at all to all that it can give: they grow lighter, then warm."""


def links(track: Track, bodies: list[str] | None = None) -> list[tuple[int, int, Array, float, float]]:
    """The loaded contacts of the last frame, the points of two bodies taken together.

    Returns:
        For each: both bodies, the centre of load (3,) in m, the size of the force in N, and which share of its static
        limit friction takes up, 0 to 1.
    """
    points = chosen_points(track, bodies)
    points = points[points.frame == len(track.frames) - 1]
    found = []
    for row, (static, _) in zip(points.rows, points.coefficients.tolist(), strict=True):
        load, friction = float(row["normal_impulse"]), row["friction_impulse"]
        force = float(np.linalg.norm(row["normal"] * load + friction)) / track.frames.dt
        share = float(np.linalg.norm(friction)) / (static * load) if static > 0.0 else 1.0
        found.append((int(row["body_a"]), int(row["body_b"]), row["point"].copy(), force, min(1.0, share)))
    return found


def best_view(frames: Frames, gravity: Array) -> tuple[Array, str]:
    """(2, 3) directions of the picture, and what the second one is: height, or depth if seen from above.

    A heap is seen from the side, with the axis of the world that is nearest to its largest extent to the right; what
    lies flat, as balls on a table do, is seen from above.
    """
    strength = float(np.linalg.norm(gravity))
    up = -gravity / strength if strength > 0.0 else np.array([0.0, 0.0, 1.0])
    movers = [n for n, body in enumerate(frames.bodies) if not body.fixed]
    x = frames.positions[-1, movers]
    x = x - x.mean(axis=0)
    height = x @ up
    x = x - np.outer(height, up)
    _, extents, directions = np.linalg.svd(np.vstack([x, 1e-6 * np.eye(3)]), full_matrices=False)
    # along an axis of the world, which scenes are built along, rather than askew by a little
    axes = np.eye(3) - np.outer(up, up)
    lengths = np.linalg.norm(axes, axis=1)
    axes = axes[lengths > 0.5] / lengths[lengths > 0.5, None]
    right = axes[np.argmax(np.abs(axes @ directions[0]))]
    if np.linalg.norm(height) < FLAT * extents[1] and extents[1] > FLAT * extents[0]:
        return np.array([right, np.cross(up, right)]), "depth"
    return np.array([right, up]), "height"


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: bodies in outline, a line a contact, as wide as its force.

    Args:
        track: the run; its last frame is shown.
        bodies: names of the bodies whose contacts are shown; all of them if left out.

    Raises:
        InvalidInputError: ``bodies`` is empty or names a body that is not there; or nothing can move.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    frames = track.frames
    canvas.choose(frames, None, len(frames.bodies))
    view, name = best_view(frames, track.gravity)
    found = links(track, bodies)
    figure = canvas.sheet(f"{frames.title}, t = {frames.times[-1]:.3g} s", (9.6, 7.2))
    axes = canvas.dress(figure.add_subplot())
    low, high = _outlines(axes, frames, view)

    largest = max([1e-12, *(force for *_, force, _ in found)])
    segments, widths, shares = [], [], []
    for a, b, centre, force, share in sorted(found, key=lambda link: link[3]):
        for body in (a, b):
            if not frames.bodies[body].fixed:
                segments.append(np.array([view @ frames.positions[-1, body], view @ centre]))
                widths.append(WIDEST * math.sqrt(force / largest))
                shares.append(share)
    colors = LinearSegmentedColormap.from_list("mobilised", MOBILISED)
    drawn = LineCollection(segments, linewidths=widths, cmap=colors, norm=Normalize(0.0, 1.0), capstyle="round")
    drawn.set(array=np.array(shares), zorder=3)
    axes.add_collection(drawn)

    room = 0.04 * float(max(high - low))
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room), aspect="equal")
    axes.set_xlabel("across (m)")
    axes.set_ylabel(f"{name} (m)")
    bar = figure.colorbar(ScalarMappable(drawn.norm, colors), ax=axes, shrink=0.75, pad=0.02)
    bar.set_label(r"share of the static limit, $|F|\,/\,\mu_s N$", fontsize=11, color=style.INK)
    bar.ax.tick_params(colors=style.MUTED_INK, labelsize=10)
    bar.outline.set_visible(False)
    _legend(figure, largest)
    return figure


def _outlines(axes: Axes, frames: Frames, view: Array) -> tuple[Array, Array]:
    """Draw bodies as the outlines of their shapes, fixed ones paler; the corners of those that move, (2,) each in m."""
    from matplotlib.collections import PolyCollection
    from scipy.spatial import ConvexHull

    pieces: dict[bool, list[Array]] = {False: [], True: []}
    for n, body in enumerate(frames.bodies):
        if not body.shape.bounded:
            continue
        corners = turned(frames.orientations[-1, n], solid(body.shape).vertices) + frames.positions[-1, n]
        flat = corners @ view.T
        pieces[body.fixed].append(flat[ConvexHull(flat).vertices])
    for fixed, color, edge in ((True, style.GROUND, "none"), (False, "#f1f4f6", style.GRID_SECTION)):
        axes.add_collection(
            PolyCollection(pieces[fixed], facecolor=color, edgecolor=edge, lw=0.9, zorder=1 + (not fixed))
        )
    everything = np.concatenate(pieces[False])
    return everything.min(axis=0), everything.max(axis=0)


def _legend(figure: Figure, largest: float) -> None:
    """Three widths of line and the forces they stand for."""
    from matplotlib.lines import Line2D

    unit, name = (1000.0, "kN") if largest >= 5000.0 else (1.0, "N")
    handles: list[Any] = []
    for share in (1.0, 0.25, 0.05):
        label = f"{float(f'{share * largest / unit:.2g}'):g} {name}"
        handles.append(Line2D([], [], color=style.MUTED_INK, lw=WIDEST * math.sqrt(share), label=label))
    canvas.legend(figure, handles)
