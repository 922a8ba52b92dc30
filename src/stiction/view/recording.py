"""A run as a recording of viser's scene: stage, grounds, bodies, contacts, frame after frame.

Bodies of the same shape share one batched mesh, whose positions, orientations and colours are updated together. That
keeps the page small (arrays instead of messages), lets a colour change at any frame, and draws a thousand boxes with
two calls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.record.frames import Frames
from stiction.shapes import ConvexHull, Plane, Shape
from stiction.view import camera, meshes, style

if TYPE_CHECKING:
    from viser import ViserServer

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

HOLD = 1.0
"""Seconds that the last picture stays before the player starts again."""
FARTHEST = 25.0
"""Bodies that end up farther away than this many sizes of the scene at its start are left out of the first picture."""
CELLS = 16
"""The grid has about this many cells along the longer side of what is seen."""
SURVEY = 24
"""Frames looked at to find the bounds of the run."""
LEAST_SLOPE_COSINE = 0.3
"""Planes whose normal is nearer to the horizontal than this cosine are walls, not slopes."""
MOST_NAMES = 12
"""Names are shown beside the moving bodies if there are no more than this."""
PALETTE = np.array([style.surface(style.MOTION_COLORS[motion]) for motion in Motion])


@dataclass(frozen=True)
class Survey:
    """What the run needs of space.

    Attributes:
        points: (p, 3) corners of the moving bodies at some frames, in m.
        centers: (k, n, 3) of the n moving bodies at k frames, in m.
        radii: (n,) of balls around the moving bodies, in m.
        cores: (n,) of balls within the moving bodies, in m.
        typical: size of a typical moving body, in m.
        cell: of the grid, in m: 1, 2 or 5 times a power of ten.
        moving: (n,) numbers of the moving bodies.
    """

    points: Array
    centers: Array
    radii: Array
    cores: Array
    typical: float
    cell: float
    moving: Indices


def record(frames: Frames, picked: Indices, seen: Survey, progress: Callable[[float], None]) -> str:
    """The page as viser makes it, without title and legend.

    Args:
        frames: the run.
        picked: numbers of the frames to show.
        seen: see :func:`survey`.
        progress: called with the finished share, from 0 to 1.
    """
    import viser

    # viser can only record what a running server shows, so one runs here: for this machine alone, on a free port
    with _quiet():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        first = int(picked[0])
        _set_stage(server, frames, seen)
        updates = [*_add_grounds(server, frames, seen), *_add_bodies(server, frames, first)]
        updates += [*_add_names(server, frames, seen), _add_contacts(server, frames, picked, seen.typical)]
        recording = server.get_scene_serializer()
        for n, k in enumerate(picked.tolist()):
            if n:
                recording.insert_sleep(float(frames.times[k] - frames.times[picked[n - 1]]))
            for update in updates:
                update(k)
            progress((n + 1) / len(picked))
        if len(picked) > 1:
            recording.insert_sleep(HOLD)
        return recording.as_html()
    finally:
        with _quiet():
            server.stop()


@contextmanager
def _quiet() -> Iterator[None]:
    """Keeps viser from announcing its server, which it does through rich's console even when told not to be verbose."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def survey(frames: Frames) -> Survey:
    """Bounds of what moves over the whole run, without what flies off."""
    bounded = [n for n, body in enumerate(frames.bodies) if body.shape.bounded]
    moving = np.array([n for n in bounded if not frames.bodies[n].fixed] or bounded, dtype=np.int64)
    if not len(moving):
        return Survey(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]]), np.zeros((1, 0, 3)), np.zeros(0), np.zeros(0), 1.0, 0.5, moving)
    looked_at = np.unique(np.linspace(0, len(frames) - 1, SURVEY).astype(int))
    boxes = [meshes.bounds(frames.bodies[n].shape) for n in moving]
    corners = np.array([_corners(low, high) for low, high in boxes])
    # (k, n, 8, 3): every corner of every moving body at every frame looked at
    turned = np.einsum("knij,ncj->knci", _matrices(frames.orientations[looked_at][:, moving]), corners)
    points = turned + frames.positions[looked_at][:, moving, None]
    radii = np.array([float(np.linalg.norm(high - low)) / 2 for low, high in boxes])
    start = points[0].reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(start, axis=0)))
    away = np.linalg.norm(points - start.mean(axis=0), axis=-1).max(axis=-1)
    near = points[away <= FARTHEST * size].reshape(-1, 3)
    extent = float(np.ptp(near[:, :2], axis=0).max())
    start_middle_end = np.unique([0, len(looked_at) // 2, len(looked_at) - 1])
    return Survey(
        points=near,
        centers=points[start_middle_end].mean(axis=2),
        radii=radii,
        cores=np.array([float((high - low).min()) / 2 for low, high in boxes]),
        typical=float(np.median([(high - low).mean() for low, high in boxes])),
        cell=_round_length(extent / CELLS),
        moving=moving,
    )


# --- the parts of the scene: each puts its nodes up and returns what brings them to frame k ----------------------------

Update = Callable[[int], None]


def _set_stage(server: ViserServer, frames: Frames, seen: Survey) -> None:
    """Camera and light."""
    normals = [
        _matrices(frames.orientations[0, n]) @ np.array(body.shape.normal)
        for n, body in enumerate(frames.bodies)
        if isinstance(body.shape, Plane)
    ]
    view = camera.place(seen.points, seen.centers, seen.radii, seen.cores, np.array(normals).reshape(-1, 3))
    distance = float(np.linalg.norm(view.position - view.look_at))
    server.scene.set_up_direction("+z")
    server.initial_camera.up = (0.0, 0.0, 1.0)
    server.initial_camera.position = view.position
    server.initial_camera.look_at = view.look_at
    server.initial_camera.fov = view.field_of_view
    server.initial_camera.near = distance / 500.0
    server.initial_camera.far = distance * 100.0
    server.scene.add_light_ambient("/light", intensity=style.AMBIENT)


def _add_grounds(server: ViserServer, frames: Frames, seen: Survey) -> list[Update]:
    """A block with a grid on it for every plane, large enough for all that comes to it: a slab, or a wedge if it slopes."""
    planes = [n for n, body in enumerate(frames.bodies) if isinstance(body.shape, Plane)]
    fixtures = [_world_corners(frames, n, 0) for n, body in enumerate(frames.bodies) if body.fixed and body.shape.bounded]
    moves = _changes(frames)
    updates: list[Update] = []
    for n in planes:
        plane = frames.bodies[n].shape
        assert isinstance(plane, Plane)
        rotation = _matrices(frames.orientations[0, n])
        frame = _patch_frame(plane, rotation)
        if len(planes) == 1:
            points = np.concatenate([seen.points, *fixtures])
        else:
            touching = (frames.contacts["body_a"] == n) | (frames.contacts["body_b"] == n)
            points = frames.contacts["point"][touching] if touching.any() else seen.points
        low, high = _patch_size((points - frames.positions[0, n]) @ rotation @ frame, seen)
        name = f"/ground/{_clean(frames.bodies[n].name)}"
        holder = server.scene.add_frame(name, show_axes=False)
        patch = {"wxyz": _quaternion(frame), "position": frame @ np.array([*(low + high) / 2, plane.offset])}
        block = _block((high - low) / 2, rotation @ frame, 0.25 * seen.cell, wedge=not moves[n])
        server.scene.add_batched_meshes_simple(
            f"{name}/block",
            block.vertices,
            block.faces,
            np.array([[1.0, 0.0, 0.0, 0.0]]),
            np.zeros((1, 3)),
            batched_colors=style.surface(style.GROUND),
            lod="off",
            cast_shadow=False,
            **patch,
        )
        # a little above the block, or the two would flicker through each other
        patch["position"] = patch["position"] + frame[:, 2] * 2e-3 * seen.cell
        server.scene.add_grid(
            f"{name}/grid",
            width=float(high[0] - low[0]),
            height=float(high[1] - low[1]),
            plane="xy",
            cell_size=seen.cell,
            cell_color=style.rgb(style.GRID_LINE),
            cell_thickness=1.0,
            section_size=5 * seen.cell,
            section_color=style.rgb(style.GRID_SECTION),
            section_thickness=1.0,
            fade_strength=0.0,
            shadow_opacity=0.0,
            plane_opacity=0.0,
            **patch,
        )
        updates.append(_follower(holder, frames, n, np.zeros(3)))
    return updates


def _add_bodies(server: ViserServer, frames: Frames, first: int) -> list[Update]:
    """Two batched meshes for every shape that occurs: the solids, coloured, and their edges."""
    still = ~_changes(frames)
    groups: dict[tuple[str, bool, bool], list[int]] = {}
    for n, body in enumerate(frames.bodies):
        if body.shape.bounded:
            groups.setdefault((_key(body.shape), body.fixed, bool(still[n])), []).append(n)
    updates: list[Update] = []
    for number, ((_, fixed, rests), members) in enumerate(groups.items()):
        shape = frames.bodies[members[0]].shape
        index = np.array(members)
        handles = []
        for part, mesh, colors in (
            ("solid", meshes.solid(shape), PALETTE[frames.motion[first, index]]),
            ("edges", meshes.edges(shape), style.surface(style.INK)),
        ):
            handles.append(
                server.scene.add_batched_meshes_simple(
                    f"/bodies/{number} {shape.kind}/{part}",
                    mesh.vertices,
                    mesh.faces,
                    frames.orientations[first, index],
                    frames.positions[first, index],
                    batched_colors=colors,
                    lod="off",
                    cast_shadow=part == "solid",
                    opacity=style.OPACITY if part == "solid" and not fixed else None,
                )
            )
        if not rests:
            updates.append(_batch_update(handles, frames, index))
    return updates


def _batch_update(handles: list[Any], frames: Frames, index: Indices) -> Update:
    def update(k: int) -> None:
        for handle in handles:
            handle.batched_positions = frames.positions[k, index]
            handle.batched_wxyzs = frames.orientations[k, index]
        handles[0].batched_colors = PALETTE[frames.motion[k, index]]

    return update


def _add_names(server: ViserServer, frames: Frames, seen: Survey) -> list[Update]:
    """Names above the moving bodies, if they are few."""
    if len(seen.moving) > MOST_NAMES:
        return []
    updates = []
    for n, radius in zip(seen.moving.tolist(), seen.radii, strict=True):
        name = frames.bodies[n].name
        label = server.scene.add_label(f"/names/{_clean(name)}", name, anchor="bottom-center", font_screen_scale=0.85)
        updates.append(_follower(label, frames, n, np.array([0.0, 0.0, 0.9 * radius]), turns=False))
    return updates


def _add_contacts(server: ViserServer, frames: Frames, picked: Indices, typical: float) -> Update:
    """Contact points in the colour of what they do, and an arrow along every normal."""
    most = max((len(frames.contacts_of(k)) for k in picked.tolist()), default=0)
    if not most:
        return lambda k: None
    radius = style.CONTACT_RADIUS * typical
    ball = meshes.sphere(radius)
    points = server.scene.add_batched_meshes_simple(
        "/contacts/points",
        ball.vertices,
        ball.faces,
        np.tile((1.0, 0.0, 0.0, 0.0), (most, 1)),
        np.zeros((most, 3)),
        batched_colors=np.zeros((most, 3), dtype=np.uint8),
        lod="off",
        cast_shadow=False,
        visible=False,
    )
    normals = server.scene.add_arrows(
        "/contacts/normals",
        np.zeros((most, 2, 3)),
        style.surface(style.NORMAL),
        shaft_radius=0.35 * radius,
        head_radius=0.95 * radius,
        head_length=3.0 * radius,
        visible=False,
    )

    def update(k: int) -> None:
        rows = frames.contacts_of(k)
        points.visible = normals.visible = len(rows) > 0
        if len(rows):
            points.batched_positions = rows["point"]
            points.batched_colors = PALETTE[np.where(rows["sticking"], Motion.STICKING, Motion.SLIDING)]
            tips = rows["point"] + style.NORMAL_LENGTH * typical * rows["normal"]
            normals.points = np.stack([rows["point"], tips], axis=1)

    return update


def _follower(handle: Any, frames: Frames, n: int, offset: Array, *, turns: bool = True) -> Update:
    """Keeps a node at body n, moved by a fixed offset in world axes."""

    def update(k: int) -> None:
        handle.position = frames.positions[k, n] + offset
        if turns:
            handle.wxyz = frames.orientations[k, n]

    return update


# --- geometry ---------------------------------------------------------------------------------------------------------


def _patch_frame(plane: Plane, rotation: Array) -> Array:
    """Columns x, y, normal (3, 3) of a plane's patch in its body's frame; x points down the slope if there is one."""
    normal = np.array(plane.normal)
    up = rotation @ normal
    downhill = up * up[2] - np.array([0.0, 0.0, 1.0])
    if np.linalg.norm(downhill) < 1e-6:
        downhill = np.array([1.0, 0.0, 0.0])
    x = rotation.T @ (downhill / np.linalg.norm(downhill))
    return np.column_stack([x, np.cross(normal, x), normal])


def _block(half: Array, frame: Array, thickness: float, *, wedge: bool) -> meshes.Mesh:
    """What is under a patch of half that size (2,), in the patch's own axes, the columns of ``frame`` in the world.

    A slope stands on a wedge with a level bottom: a slab alone in the air could as well be a floor seen askew.
    """
    top = np.array([[x * half[0], y * half[1], 0.0] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    heights = top @ frame[2]
    if wedge and LEAST_SLOPE_COSINE < frame[2, 2] < 0.9999:
        bottom = top - (heights - heights.min() + thickness)[:, None] * frame[2]
    else:
        bottom = top - (0.0, 0.0, thickness)
    return meshes.prism(top, bottom)


def _patch_size(local: Array, seen: Survey) -> tuple[Array, Array]:
    """Lowest and highest corner (2,) of a patch, in whole cells, with some room around the points."""
    margin = max(2.0 * seen.cell, 0.75 * seen.typical)
    low = np.floor((local[:, :2].min(axis=0) - margin) / seen.cell)
    high = np.ceil((local[:, :2].max(axis=0) + margin) / seen.cell)
    # an even number of cells puts the middle, where the grid starts, on a line of the plane's own grid
    high += (high - low) % 2
    return low * seen.cell, high * seen.cell


def _round_length(length: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    if not length > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(length))
    return min((power, 2 * power, 5 * power, 10 * power), key=lambda c: abs(math.log(c / length)))


def _corners(low: Array, high: Array) -> Array:
    choose = np.array([[(k >> axis) & 1 for axis in range(3)] for k in range(8)], dtype=bool)
    return np.where(choose, high, low)


def _world_corners(frames: Frames, n: int, k: int) -> Array:
    corners = _corners(*meshes.bounds(frames.bodies[n].shape))
    return corners @ _matrices(frames.orientations[k, n]).T + frames.positions[k, n]


def _matrices(quaternions: Array) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), w first."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _quaternion(matrix: Array) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation matrix: the eigenvector of Bar-Itzhack's symmetric 4 x 4 matrix."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    k = np.array(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, d + b, c + g],
            [c - g, d + b, e - a - i, h + f],
            [d - b, c + g, h + f, i - a - e],
        ]
    )
    result: Array = np.linalg.eigh(k)[1][:, -1]
    return result


def _changes(frames: Frames) -> NDArray[np.bool_]:
    """(n,) whether a body ever moves or changes its state."""
    moved = (frames.positions != frames.positions[0]).any(axis=(0, 2))
    turned = (frames.orientations != frames.orientations[0]).any(axis=(0, 2))
    return moved | turned | (frames.motion != frames.motion[0]).any(axis=0)


def _key(shape: Shape) -> str:
    """Equal for shapes that share a mesh."""
    return f"hull {shape.points.tobytes().hex()}" if isinstance(shape, ConvexHull) else repr(shape)


def _clean(name: str) -> str:
    """A body's name as a node of viser's tree, where slashes part folders."""
    return name.replace("/", "\u2215")
