"""What moves in viser's scene: bodies in batches, their names, contact points and arrows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.record.frames import BodyInfo, Frames
from stiction.record.recorder import Frame
from stiction.shapes import ConvexHull, Shape
from stiction.view import meshes, style
from stiction.view.instances import add_instances, upright
from stiction.view.stage import Update, clean
from stiction.view.survey import Survey, matrices

if TYPE_CHECKING:
    from viser import ViserServer

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_NAMES = 12
"""Names are shown beside the moving bodies if there are no more than this."""
PALETTE = np.array([style.surface(style.MOTION_COLORS[motion]) for motion in Motion])
SLIDES_OR_STICKS = PALETTE[[Motion.SLIDING, Motion.STICKING]]
"""Colours of contact points that do not stick, and that do."""


class Batch:
    """Bodies of the same shape: one batched mesh of their solids, coloured, and one of their edges.

    Attributes:
        index: (k,) numbers of the bodies.
        solid: viser's handle of the solids.
        rests: whether the bodies are never moved.
    """

    def __init__(self, server: ViserServer, name: str, shape: Shape, index: Indices, frame: Frame, fixed: bool) -> None:
        self.index = index
        first, last = int(index[0]), int(index[-1])
        # bodies of one shape are often added one after another: a slice of them copies nothing
        self._members = slice(first, last + 1) if last - first + 1 == len(index) else index
        self.rests = False
        handles = []
        for part, mesh, colors in (
            ("solid", meshes.solid(shape), PALETTE[frame.motion[index]]),
            ("edges", meshes.edges(shape), style.surface(style.INK)),
        ):
            handles.append(
                add_instances(
                    server,
                    f"/bodies/{name}/{part}",
                    mesh,
                    frame.positions[index],
                    frame.orientations[index],
                    colors=colors,
                    cast_shadow=part == "solid",
                    opacity=style.OPACITY if part == "solid" and not fixed else None,
                )
            )
        self.solid, self._edges = handles

    def show(self, frame: Frame, colors: NDArray[np.uint8]) -> None:
        """Bring the bodies to where they are in a frame, in these colours (n, 3), a row for every body of the world."""
        positions = frame.positions[self._members].astype(np.float32)
        orientations = frame.orientations[self._members].astype(np.float32)
        for handle in (self.solid, self._edges):
            handle.batched_positions = positions
            handle.batched_wxyzs = orientations
        self.solid.batched_colors = colors[self._members]


def add_bodies(server: ViserServer, bodies: list[BodyInfo], frame: Frame, still: NDArray[np.bool_]) -> list[Batch]:
    """A batch for every shape that occurs, those that are ``still`` (n,) apart from the others."""
    groups: dict[tuple[str, bool, bool], list[int]] = {}
    for n, body in enumerate(bodies):
        if body.shape.bounded:
            groups.setdefault((_key(body.shape), body.fixed, bool(still[n])), []).append(n)
    batches = []
    for number, ((_, fixed, rests), members) in enumerate(groups.items()):
        shape = bodies[members[0]].shape
        batch = Batch(server, f"{number} {shape.kind}", shape, np.array(members), frame, fixed)
        batch.rests = rests
        batches.append(batch)
    return batches


def add_names(server: ViserServer, bodies: list[BodyInfo], seen: Survey) -> list[Update]:
    """Names above the moving bodies, if they are few."""
    if len(seen.moving) > MOST_NAMES:
        return []
    return [_name_update(server, bodies[n], n, 0.1 * seen.typical) for n in seen.moving.tolist()]


def _name_update(server: ViserServer, body: BodyInfo, n: int, gap: float) -> Update:
    label = server.scene.add_label(
        f"/names/{clean(body.name)}", body.name, anchor="bottom-center", font_screen_scale=0.85
    )

    def update(frame: Frame) -> None:
        top = meshes.height(body.shape, matrices(frame.orientations[n]))
        label.position = frame.positions[n] + (0.0, 0.0, top + gap)

    return update


class Dots:
    """Contact points in the colour of what they do."""

    def __init__(self, server: ViserServer, room: int, typical: float) -> None:
        ball = meshes.sphere(style.CONTACT_RADIUS * typical)
        self._room = room
        colors = np.zeros((room, 3), dtype=np.uint8)
        self.handle = add_instances(server, "/contacts/points", ball, np.zeros((room, 3)), colors=colors, visible=False)

    def show(self, points: Array, sticking: NDArray[np.bool_]) -> None:
        """Show points (k, 3) in m, with (k,) whether they stick."""
        self.handle.visible = len(points) > 0
        if len(points):
            if len(points) > self._room:
                self._room = 2 * len(points)
                self.handle.batched_wxyzs = upright(self._room)
            self.handle.batched_positions = points.astype(np.float32)
            self.handle.batched_colors = SLIDES_OR_STICKS.take(sticking, axis=0)


class Arrows:
    """Arrows of one colour, as thick as suits contact points."""

    def __init__(self, server: ViserServer, name: str, room: int, color: str, typical: float) -> None:
        radius = style.CONTACT_RADIUS * typical
        self.handle = server.scene.add_arrows(
            name,
            np.zeros((room, 2, 3)),
            style.surface(color),
            shaft_radius=0.35 * radius,
            head_radius=0.95 * radius,
            head_length=3.0 * radius,
            visible=False,
        )

    def show(self, tails: Array, arrows: Array) -> None:
        """Show arrows (k, 3) that begin at ``tails`` (k, 3), in m."""
        self.handle.visible = len(tails) > 0
        if len(tails):
            points = np.empty((len(tails), 2, 3), np.float32)
            points[:, 0] = tails
            np.add(tails, arrows, out=points[:, 1])
            self.handle.points = points


def add_contacts(server: ViserServer, frames: Frames, picked: Indices, typical: float) -> Update:
    """Contact points in the colour of what they do, and an arrow along every normal."""
    most = max((len(frames.contacts_of(k)) for k in picked.tolist()), default=0)
    if not most:
        return lambda frame: None
    points = Dots(server, most, typical)
    normals = Arrows(server, "/contacts/normals", most, style.NORMAL, typical)

    def update(frame: Frame) -> None:
        rows = frame.contacts
        points.show(rows["point"], rows["sticking"])
        normals.show(rows["point"], style.NORMAL_LENGTH * typical * rows["normal"])

    return update


def _key(shape: Shape) -> str:
    """Equal for shapes that share a mesh."""
    return f"hull {shape.points.tobytes().hex()}" if isinstance(shape, ConvexHull) else repr(shape)
