"""What an environment shows: small pictures drawn here, or a world in the live view."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.core.vec import Quat, rotation
from stiction.envs.arena import Arena
from stiction.shapes import Plane
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from stiction.view.server import Viewer
    from stiction.world import World

DPI = 100


class Eyes:
    """Shows the worlds of an arena.

    Args:
        arena: whose worlds.
        mode: ``"rgb_array"``, ``"human"`` or None, which shows nothing.

    Attributes:
        viewer: the live view of the first world in mode ``"human"``, once there was something to see.
    """

    def __init__(self, arena: Arena, mode: str | None) -> None:
        self.viewer: Viewer | None = None
        self._arena, self._mode = arena, mode
        self._sheet: tuple[FigureCanvasAgg, Axes] | None = None
        self._shapes: list[Any] = []
        self._shown = 0.0

    def look(self) -> None:
        """Bring the live view up to date, and wait until as much time has gone by as in the world."""
        if self._mode != "human":
            return
        world = self._arena.batch.world(0)
        if self.viewer is None:
            from stiction.view.server import Viewer
            from stiction.view.session import LiveSession

            title = f"{self._arena.task.name}: the program steps it"
            self.viewer = Viewer(LiveSession(world, title, advance=_leave_alone))
        else:
            self._hand_over(self.viewer, world)
        task = self._arena.task
        due = self._shown + task.drives * task.hold * self._arena.batch.dt
        now = time.monotonic()
        if self._shown and due > now and self.viewer.clients:  # nobody waits for what nobody sees
            time.sleep(due - now)
        self._shown = time.monotonic()

    @staticmethod
    def _hand_over(viewer: Viewer, world: World) -> None:
        """Show a newer copy of the same world."""
        from stiction.view.session import LiveSession

        with viewer.lock:
            session = viewer.session
            assert isinstance(session, LiveSession)
            if world.time < session.world.time:
                session.chart.clear()  # an episode began anew
            session.world = world

    def picture(self, world: int) -> NDArray[np.uint8] | None:
        """(height, width, 3) of this world in mode ``"rgb_array"``, None in the others."""
        if self._mode != "rgb_array":
            return None
        canvas, axes = self._sheet or self._unfold()
        for patch in list(axes.patches):
            patch.remove()
        self._draw(axes, world)
        canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib has no types here
        pixels: NDArray[np.uint8] = np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]  # the same
        return pixels

    def close(self) -> None:
        """End the live view."""
        if self.viewer is not None:
            self.viewer.stop()
            self.viewer = None

    # --- pictures -----------------------------------------------------------------------------------------------------

    def _unfold(self) -> tuple[FigureCanvasAgg, Axes]:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        from stiction.view.meshes import solid

        view = self._arena.task.view
        height = round(view.width * (view.y[1] - view.y[0]) / (view.x[1] - view.x[0]))
        figure = Figure(figsize=(view.width / DPI, height / DPI), dpi=DPI, facecolor=style.SKY_BOTTOM)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set(xlim=view.x, ylim=view.y)
        self._shapes = [
            None if isinstance(body.shape, Plane) else solid(body.shape) for body in self._arena.batch.bodies
        ]
        self._sheet = FigureCanvasAgg(figure), axes
        return self._sheet

    def _draw(self, axes: Axes, world: int) -> None:
        from matplotlib.patches import Circle, Polygon, Rectangle

        task, batch = self._arena.task, self._arena.batch
        for mark in task.marks(world):
            (x, y), size = mark.center, mark.size
            axes.add_patch(
                Circle((x, y), mark.radius, fc=mark.color)
                if size is None
                else Rectangle((x - size[0] / 2, y - size[1] / 2), *size, fc=mark.color)
            )
        colors = iter(style.SERIES * len(batch.bodies))
        for body, mesh, origin, q in zip(
            batch.bodies, self._shapes, batch.positions[world], batch.orientations[world], strict=True
        ):
            if mesh is None:
                continue
            turned = _rotation(q)
            places = origin + mesh.vertices @ turned.T
            color = next(colors) if body.mobility == "dynamic" else style.ASLEEP
            axes.add_patch(Polygon(_outline(places[:, task.view.axes]), fc=color, ec=style.INK, lw=1.0))
            if body.mobility == "dynamic" and task.view.axes == (0, 1):  # a line that shows that it turns
                reach = 0.5 * np.ptp(mesh.vertices[:, 0]) * turned[:, 0]
                axes.add_patch(Polygon([origin[:2], (origin + reach)[:2]], closed=False, ec=style.INK, lw=1.5))


def _leave_alone(steps: int) -> None:
    """What the view's own play button does to a world that a program steps: nothing."""


def _rotation(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    return np.array(rotation(Quat(*q.tolist()))).reshape(3, 3)


def _outline(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of the convex hull of points (k, 2)."""
    from scipy.spatial import ConvexHull

    corners: NDArray[np.float64] = points[ConvexHull(points).vertices]
    return corners
