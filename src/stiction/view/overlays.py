"""What the live view draws over the bodies: contacts, impulses, one friction cone, patches, centres, trails."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.record.classify import lengths
from stiction.record.frames import BodyInfo
from stiction.record.recorder import Frame
from stiction.view import meshes, style
from stiction.view.instances import add_instances, upright
from stiction.view.nodes import PALETTE, Arrows, Dots
from stiction.view.session import Session
from stiction.view.survey import matrices, quaternion

if TYPE_CHECKING:
    from viser import ViserServer

Array = NDArray[np.float64]

MOST_CONTACTS = 4000
"""Contact points shown at most, those with the largest load: more would cover each other."""
MOST_TRAILS = 64
TRAIL = 120
"""Moving bodies that leave a trail at most, and frames that it lasts."""
MOST_CENTRES = 2000
LAYERS = {
    "contacts": "contact points",
    "normals": "normals",
    "friction": "friction impulses",
    "cone": "cone at the picked contact",
    "patches": "contact patches",
    "centres": "centres of mass",
    "trails": "trails",
}
"""What can be shown, and its name for the reader."""
SHOWN = ("contacts", "normals", "friction", "cone")
"""What is shown at first."""
ASLEEP = style.surface(style.ASLEEP)
CONE_SEGMENTS = 48
IMPULSE_LENGTH = 1.2
"""Length of the arrow of the largest normal impulse, as a share of the typical size of the moving bodies."""
FADE = 0.97
"""By how much the impulse that sets that length falls from frame to frame, where none is larger."""


def body_colors(frame: Frame, asleep: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Colours (n, 3) for viser by what the bodies are doing, those that sleep apart."""
    colors = PALETTE.take(frame.motion, axis=0)
    if asleep.any():
        colors[asleep] = ASLEEP
    return colors


def patch_outlines(rows: NDArray[Any]) -> Array:
    """Segments (k, 2, 3) in m around the contact points of each pair of bodies that has three or more."""
    if not len(rows):
        return np.zeros((0, 2, 3))
    order = np.lexsort((rows["body_b"], rows["body_a"]))
    a, b = rows["body_a"][order], rows["body_b"][order]
    starts = np.flatnonzero((np.diff(a, prepend=-1) != 0) | (np.diff(b, prepend=-1) != 0))
    segments = []
    for group in np.split(order, starts[1:]):
        if len(group) < 3:
            continue
        points = rows["point"][group]
        basis = np.linalg.svd(np.eye(3) - np.outer(rows["normal"][group[0]], rows["normal"][group[0]]))[0][:, :2]
        loop = points[_hull((points - points[0]) @ basis)]
        segments.append(np.stack([loop, np.roll(loop, -1, axis=0)], axis=1))
    return np.concatenate(segments) if segments else np.zeros((0, 2, 3))


def _hull(points: Array) -> list[int]:
    """Numbers of the corners of the convex hull of points (k, 2), counter-clockwise: Andrew's monotone chain."""
    order = np.lexsort((points[:, 1], points[:, 0])).tolist()

    def half(numbers: list[int]) -> list[int]:
        chain: list[int] = []
        for n in numbers:
            while len(chain) > 1:
                (ax, ay), (bx, by) = points[chain[-1]] - points[chain[-2]], points[n] - points[chain[-2]]
                if ax * by - ay * bx > 1e-12:
                    break
                chain.pop()
            chain.append(n)
        return chain

    return half(order)[:-1] + half(order[::-1])[:-1]


class Overlays:
    """The layers over the bodies.

    Args:
        server: viser's.
        bodies: what does not change about the n bodies.
        frame: the first one.
        typical: size of a typical moving body, in m.

    Attributes:
        shown: names of the layers of ``LAYERS`` that are shown.
        hidden: contact points that were not shown because there are too many.
    """

    def __init__(self, server: ViserServer, bodies: list[BodyInfo], frame: Frame, typical: float) -> None:
        self.shown = set(SHOWN)
        self.hidden = 0
        self._typical = typical
        self._moving = np.flatnonzero([not body.fixed for body in bodies])
        self._centres = np.array([_centre(body) for body in bodies]).reshape(-1, 3)
        self._trail: deque[Array] = deque(maxlen=TRAIL)
        self._largest = 0.0
        self.dots = Dots(server, max(16, len(frame.contacts)), typical)
        self._normals = Arrows(server, "/contacts/normals", 1, style.NORMAL, typical)
        self._impulses = Arrows(server, "/contacts/friction", 1, style.FRICTION, typical)
        self.rows = frame.contacts[:0]
        width = 0.25 * style.CONTACT_RADIUS * typical
        nothing = np.zeros((1, 2, 3))
        self._patches = server.scene.add_line_segments(
            "/patches", nothing, style.rgb(style.INK), thickness=2 * width, visible=False
        )
        self._trails = server.scene.add_line_segments(
            "/trails", nothing, style.rgb(style.MUTED_INK), thickness=width, visible=False
        )
        self._centre_dots = _crosses(server, typical)
        self._cone = _Cone(server, typical)

    def show(self, frame: Frame, session: Session) -> None:
        """Bring all layers to a frame."""
        rows = frame.contacts
        self.hidden = max(0, len(rows) - MOST_CONTACTS)
        if self.hidden:
            rows = rows.take(np.argpartition(rows["normal_impulse"], self.hidden)[self.hidden :])
        self.rows = rows
        self._show_contacts(rows)
        _segments(self._patches, patch_outlines(rows) if "patches" in self.shown else np.zeros((0, 2, 3)))
        self._show_trails(frame)
        moving = self._moving[:MOST_CENTRES] if "centres" in self.shown else self._moving[:0]
        self._centre_dots.visible = len(moving) > 0
        if len(moving):
            turned = np.einsum("nij,nj->ni", matrices(frame.orientations[moving]), self._centres[moving])
            self._centre_dots.batched_wxyzs = upright(len(moving))
            self._centre_dots.batched_positions = (frame.positions[moving] + turned).astype(np.float32)
        row = session.picked_contact(frame.contacts) if "cone" in self.shown else None
        self._cone.show(row, None if row is None else session.coefficients(int(row["body_a"]), int(row["body_b"])))

    def _show_contacts(self, rows: NDArray[Any]) -> None:
        """Points, normals and friction impulses."""
        self._largest = max(FADE * self._largest, float(rows["normal_impulse"].max(initial=0.0)))
        scale = IMPULSE_LENGTH * self._typical / self._largest if self._largest > 0.0 else 0.0
        points, nothing = np.ascontiguousarray(rows["point"]), np.zeros((0, 3))
        dots = slice(None) if "contacts" in self.shown else slice(0)
        self.dots.show(points[dots], rows["sticking"][dots])
        if "normals" in self.shown:
            self._normals.show(points, style.NORMAL_LENGTH * self._typical * rows["normal"])
        else:
            self._normals.show(nothing, nothing)
        if "friction" in self.shown:
            arrows = scale * rows["friction_impulse"]
            long = np.flatnonzero(lengths(arrows) > 0.02 * self._typical)
            self._impulses.show(points.take(long, axis=0), arrows.take(long, axis=0))
        else:
            self._impulses.show(nothing, nothing)

    def forget(self) -> None:
        """Time went back: trails begin anew."""
        self._trail.clear()
        self._largest = 0.0

    def _show_trails(self, frame: Frame) -> None:
        if "trails" not in self.shown:
            self._trail.clear()
            self._trails.visible = False
            return
        self._trail.append(frame.positions[self._moving[:MOST_TRAILS]])
        path = np.array(self._trail)
        _segments(self._trails, np.stack([path[:-1], path[1:]], axis=2).reshape(-1, 2, 3))


class _Cone:
    """The friction cone of one contact as tall as its normal impulse is drawn, and the impulse inside."""

    def __init__(self, server: ViserServer, typical: float) -> None:
        self._height = IMPULSE_LENGTH * typical
        angles = np.linspace(0.0, 2.0 * np.pi, CONE_SEGMENTS, endpoint=False)
        circle = np.column_stack([np.cos(angles), np.sin(angles), np.ones(CONE_SEGMENTS)])
        around = np.arange(CONE_SEGMENTS)
        faces = np.column_stack([np.zeros(CONE_SEGMENTS, np.int64), 1 + around, 1 + (around + 1) % CONE_SEGMENTS])
        self._circle = circle
        self._mesh = server.scene.add_mesh_simple(
            "/cone/static",
            np.concatenate([np.zeros((1, 3)), circle]),
            faces,
            color=style.rgb(style.MOTION_COLORS[Motion.STICKING]),
            opacity=0.3,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._rings = server.scene.add_line_segments(
            "/cone/limits",
            np.zeros((1, 2, 3)),
            style.rgb(style.MOTION_COLORS[Motion.SLIDING]),
            thickness=0.012 * typical,
            visible=False,
        )
        self._impulse = Arrows(server, "/cone/impulse", 1, style.INK, typical)

    def show(self, row: Any | None, coefficients: tuple[float, float] | None) -> None:
        """Show the cone of a contact row with its static and dynamic coefficient; nothing if either is None."""
        there = row is not None and coefficients is not None
        self._mesh.visible = self._rings.visible = there
        if row is None or coefficients is None:
            self._impulse.show(np.zeros((0, 3)), np.zeros((0, 3)))
            return
        static, dynamic = coefficients
        normal = row["normal"]
        helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
        x = np.cross(helper, normal)
        x /= np.linalg.norm(x)
        frame = np.column_stack([x, np.cross(normal, x), normal])
        self._mesh.wxyz = quaternion(frame)
        self._mesh.position = row["point"]
        # a flat disc where there is no friction would have no thickness at all
        self._mesh.scale = (self._height * max(static, 1e-3), self._height * max(static, 1e-3), self._height)
        ring = row["point"] + self._height * (self._circle * (dynamic, dynamic, 1.0)) @ frame.T
        _segments(self._rings, np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
        impulse = normal + row["friction_impulse"] / row["normal_impulse"]
        self._impulse.show(row["point"][None], self._height * impulse[None])


def _segments(handle: Any, points: Array) -> None:
    """Show line segments (k, 2, 3), or hide them if there are none."""
    handle.visible = len(points) > 0
    if len(points):
        handle.points = points.astype(np.float32)


def _crosses(server: ViserServer, typical: float) -> Any:
    ball = meshes.sphere(0.8 * style.CONTACT_RADIUS * typical)
    return add_instances(server, "/centres", ball, np.zeros((1, 3)), colors=style.surface(style.INK), visible=False)


def _centre(body: BodyInfo) -> Array:
    """Centre of mass in the shape's frame, (3,), m."""
    if not body.shape.bounded:
        return np.zeros(3)
    return np.asarray(body.shape.mass_properties.center_of_mass, dtype=np.float64)
