"""A still picture of a world: its bodies as they are now, from the side, from above or from any direction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.body import Body
from stiction.errors import InvalidInputError
from stiction.plot import canvas, painter
from stiction.record.classify import classify, fixed_bodies
from stiction.scene.placing import turned
from stiction.shapes import Box, Plane
from stiction.view import style
from stiction.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
View = str | tuple[float, float]

SLAB = 0.025
"""Thickness of the slab that stands for a plane, as a share of what lies on it."""
MARGIN = 0.06
"""How far a plane is drawn beyond the outermost body, as a share of the whole."""
EDGE = 0.7
"""Width of the edges of bodies, in points."""


def project(points: ArrayLike, view: View = "side") -> Array:
    """Where points are in a picture.

    Args:
        points: (3,) or (n, 3) in the world, m.
        view: as in :func:`bodies`.

    Returns:
        (2,) or (n, 2): to the right and up, m; what :func:`bodies` draws at.

    Raises:
        InvalidInputError: the view is not known.
    """
    return np.asarray(np.asarray(points, np.float64) @ painter.axes_of(view)[:2].T)


def bodies(
    axes: Axes,
    world: World,
    view: View = "side",
    *,
    only: Iterable[Body | str] | None = None,
    colors: Mapping[str, str] | str | None = None,
    alpha: float = 1.0,
    edge: float = EDGE,
) -> None:
    """Draw the bodies of a world as they are now into axes, to scale, in m.

    Called again after some steps, with ``only`` and a small ``alpha``, it shows where bodies have been.

    Args:
        axes: matplotlib's; what is there already stays.
        world: any world. Bodies have the colour of what they are doing: green sticks, orange slides, violet rolls.
        view: ``"side"`` (x to the right, z up), ``"front"`` (y to the right, z up), ``"top"`` (x to the right, y up);
            or where the viewer is, as two angles in degrees: from the x axis towards the y axis, and above the ground.
        only: the bodies to draw, or their names; all if left out. A plane is drawn as far as bodies reach.
        colors: ``#rrggbb`` of some bodies by name, or of all that move.
        alpha: 1 covers what is below, 0 is invisible.
        edge: width of the edges in points, 0 for none.

    Raises:
        InvalidInputError: the view or a body is not known, or a number is not allowed.
    """
    from matplotlib.collections import PolyCollection

    if not isinstance(world, World):
        raise InvalidInputError(f"world must be a World, got {type(world).__name__}.")
    alpha, edge = checks.non_negative("alpha", alpha), checks.non_negative("edge", edge, "points")
    if alpha > 1.0:
        raise InvalidInputError(f"alpha must be 1 or less, got {alpha!r}.")
    directions = painter.axes_of(view)
    chosen = list(world) if only is None else [_known(world, one) for one in only]
    paint = _colors(world, colors)
    strokes = painter.Strokes([], [], [], [])
    grounds = [body for body in chosen if isinstance(body.shape, Plane)]
    solids = [
        painter.place(body.shape, body.position, body.orientation, paint[body.name])
        for body in chosen
        if body.shape.bounded
    ]
    for ground in grounds:  # bodies are above it, so it is behind them all
        painter.paint(_slab(ground, world), directions, strokes, edge if edge == 0.0 else EDGE / 2)
    for number in painter.in_order(solids, directions):
        painter.paint(solids[number], directions, strokes, edge)
    drawn = PolyCollection(
        strokes.paths, closed=False, facecolors=strokes.faces, edgecolors=strokes.lines, linewidths=strokes.widths,
        alpha=alpha, capstyle="round", joinstyle="round", zorder=2,
    )  # fmt: skip
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.autoscale_view()


def picture(world: World, view: View = "side", *, title: str = "", **options: Any) -> Figure:
    """A world as it is now, as a figure of its own.

    >>> import stiction as st
    >>> from stiction import plot
    >>> world = st.World()
    >>> floor = world.add(st.Plane(), static=True)
    >>> crate = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    >>> figure = plot.picture(world, (-60, 25))     # plot.save(figure, "crate.png")

    Args:
        world: any world.
        view: as in :func:`bodies`, as are all other options.
        title: of the figure.

    Raises:
        InvalidInputError: the view or a body is not known, or a number is not allowed.
    """
    figure = canvas.sheet(title, (9.6, 6.0))
    axes = figure.add_subplot()
    bodies(axes, world, view, **options)
    axes.set_axis_off()
    return figure


def _known(world: World, one: Body | str) -> Body:
    if not isinstance(one, Body):
        return world[one]
    if not any(one is body for body in world):
        raise InvalidInputError(f"only must hold bodies of this world, got {one.name!r} of another.")
    return one


def _colors(world: World, colors: Mapping[str, str] | str | None) -> dict[str, str]:
    """The colour of each body by name."""
    doing = classify(world)
    result = {body.name: style.MOTION_COLORS[m] for body, m in zip(world, doing.tolist(), strict=True)}
    for body in world:
        if isinstance(body.shape, Plane):
            result[body.name] = style.GROUND
    if colors is None:
        return result
    from matplotlib.colors import is_color_like, to_hex

    if isinstance(colors, str):
        moves = ~fixed_bodies(world)
        colors = {body.name: colors for body, mover in zip(world, moves.tolist(), strict=True) if mover}
    for name, color in colors.items():
        if not is_color_like(color):
            raise InvalidInputError(f"colors must be colours such as '#0072b2', got {color!r} for {name!r}.")
        result[world[name].name] = to_hex(color)
    return result


def _slab(body: Body, world: World) -> painter.Solid:
    """A plane as a slab under all that is there."""
    shape = body.shape
    assert isinstance(shape, Plane)
    normal = turned(body.orientation, np.array(shape.normal))
    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    across /= np.linalg.norm(across)
    frame = np.column_stack([across, np.cross(normal, across), normal])
    reach = [
        painter.place(one.shape, one.position, one.orientation, style.GROUND) for one in world if one.shape.bounded
    ]
    corners = [(one.vertices - body.position) @ frame for one in reach] or [np.zeros((1, 3))]
    low = np.min([c.min(axis=0) - one.reach for c, one in zip(corners, reach, strict=False)] or [[-1] * 3], axis=0)
    high = np.max([c.max(axis=0) + one.reach for c, one in zip(corners, reach, strict=False)] or [[1] * 3], axis=0)
    room = MARGIN * float((high - low).max())
    size = high - low + 2.0 * room
    size[2] = SLAB * float(size.max())
    middle = 0.5 * (low + high)
    middle[2] = shape.offset - 0.5 * size[2]
    return painter.place(Box(size), body.position + frame @ middle, _quaternion(frame), style.GROUND)


def _quaternion(rotation: Array) -> Array:
    """The unit quaternion (w, x, y, z) of a rotation matrix (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z])
