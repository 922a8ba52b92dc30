"""A run as a recording of viser's scene: stage, grounds, bodies, contacts, frame after frame.

Bodies of the same shape share one batched mesh, whose positions, orientations and colours are updated together. That
keeps the page small (arrays instead of messages), lets a colour change at any frame, and draws a thousand boxes with
two calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.record.frames import Frames
from stiction.shapes import ConvexHull, Plane, Shape
from stiction.view import camera, meshes, style
from stiction.view.survey import Survey, matrices, quaternion, world_corners

if TYPE_CHECKING:
    from viser import ViserServer

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

HOLD = 1.0
"""Seconds that the last picture stays before the player starts again."""
LEAST_SLOPE_COSINE = 0.3
"""Planes whose normal is nearer to the horizontal than this cosine are walls, not slopes."""
LEVEL = 0.9999
"""Planes whose normal is nearer to the vertical than this cosine are floors."""
MOST_NAMES = 12
"""Names are shown beside the moving bodies if there are no more than this."""
PALETTE = np.array([style.surface(style.MOTION_COLORS[motion]) for motion in Motion])


def record(frames: Frames, picked: Indices, seen: Survey, progress: Callable[[float], None]) -> str:
    """The page as viser makes it, without title and legend.

    Args:
        frames: the run.
        picked: numbers of the frames to show.
        seen: see :func:`stiction.view.survey.survey`.
        progress: called with the finished share, from 0 to 1.
    """
    import viser

    # viser can only record what a running server shows, so one runs here: for this machine alone, on a free port
    with _quiet():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        first = int(picked[0])
        view = _view(frames, seen)
        _set_stage(server, view)
        updates = [*_add_grounds(server, frames, seen, view), *_add_bodies(server, frames, first)]
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


# --- the parts of the scene: each puts its nodes up and returns what brings them to frame k ---------------------------

Update = Callable[[int], None]


def _set_stage(server: ViserServer, view: camera.Camera) -> None:
    """Camera and light."""
    distance = float(np.linalg.norm(view.position - view.look_at))
    server.scene.set_up_direction("+z")
    server.initial_camera.up = (0.0, 0.0, 1.0)
    server.initial_camera.position = view.position
    server.initial_camera.look_at = view.look_at
    server.initial_camera.fov = view.field_of_view
    server.initial_camera.near = distance / 500.0
    server.initial_camera.far = distance * 100.0
    # the player's own light comes from above and throws the shadows; its panorama costs seconds without a graphics card
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_ambient("/light/all round", intensity=style.AMBIENT)
    # over the reader's left shoulder, so that two sides of a box differ; without decay it is as good as far away
    forward = (view.look_at - view.position) / distance
    left = np.cross((0.0, 0.0, 1.0), forward)
    lamp = view.position + distance * (0.9 * left + np.array([0.0, 0.0, 0.2]))
    server.scene.add_light_point("/light/lamp", intensity=style.LAMP, decay=0.0, position=tuple(lamp.tolist()))


def _add_grounds(server: ViserServer, frames: Frames, seen: Survey, view: camera.Camera) -> list[Update]:
    """A block with a grid on it for every plane, large enough for all that comes to it."""
    # fixed bodies stand on the ground too, but one that reaches far out must not make it endless
    lowest, highest = seen.points.min(axis=0), seen.points.max(axis=0)
    room = 0.5 * (highest - lowest).max()
    fixed = [n for n, body in enumerate(frames.bodies) if body.fixed and body.shape.bounded]
    everything = np.concatenate(
        [seen.points, *(np.clip(world_corners(frames, n, 0), lowest - room, highest + room) for n in fixed)]
    )
    planes = [n for n, body in enumerate(frames.bodies) if isinstance(body.shape, Plane)]
    moves = _changes(frames)
    updates: list[Update] = []
    for n in planes:
        plane = frames.bodies[n].shape
        assert isinstance(plane, Plane)
        rotation = matrices(frames.orientations[0, n])
        frame = _patch_frame(plane, rotation)
        normal = rotation @ frame[:, 2]
        touching = (frames.contacts["body_a"] == n) | (frames.contacts["body_b"] == n)
        # a slope among other planes is as large as its use; a floor lies under everything
        partial = len(planes) > 1 and normal[2] < LEVEL and touching.any()
        points = frames.contacts["point"][touching] if partial else everything
        low, high = _patch_size((points - frames.positions[0, n]) @ rotation @ frame, seen)
        name = f"/ground/{_clean(frames.bodies[n].name)}"
        holder = server.scene.add_frame(name, show_axes=False)
        patch = {"wxyz": quaternion(frame), "position": frame @ np.array([*(low + high) / 2, plane.offset])}
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
        updates.append(_follower(holder, frames, n))
        if float(normal @ (view.position - view.look_at)) < 0.0:
            continue  # a wall between the reader and the scene: its grid would lie over everything
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
    return [_name_update(server, frames, n, 0.1 * seen.typical) for n in seen.moving.tolist()]


def _name_update(server: ViserServer, frames: Frames, n: int, gap: float) -> Update:
    body = frames.bodies[n]
    node = f"/names/{_clean(body.name)}"
    label = server.scene.add_label(node, body.name, anchor="bottom-center", font_screen_scale=0.85)

    def update(k: int) -> None:
        top = meshes.height(body.shape, matrices(frames.orientations[k, n]))
        label.position = frames.positions[k, n] + (0.0, 0.0, top + gap)

    return update


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


def _follower(handle: Any, frames: Frames, n: int) -> Update:
    """Keeps a node where body n is."""

    def update(k: int) -> None:
        handle.position = frames.positions[k, n]
        handle.wxyz = frames.orientations[k, n]

    return update


# --- geometry ---------------------------------------------------------------------------------------------------------


def _view(frames: Frames, seen: Survey) -> camera.Camera:
    """Where the reader stands at first: before the scene and above its floors and slopes."""
    planes = [(n, body.shape) for n, body in enumerate(frames.bodies) if isinstance(body.shape, Plane)]
    normals = [matrices(frames.orientations[0, n]) @ np.array(plane.normal) for n, plane in planes]
    normals += supports(frames)
    grounds = np.array([normal for normal in normals if normal[2] > LEAST_SLOPE_COSINE]).reshape(-1, 3)
    return camera.place(seen.points, seen.centers, seen.radii, seen.cores, grounds)


def supports(frames: Frames) -> list[NDArray[np.float64]]:
    """The directions (3,) in which fixed bodies carry others, each once: normals of their contacts, rounded to 0.1."""
    rows = frames.contacts
    if not len(rows):
        return []
    fixed = np.array([body.fixed for body in frames.bodies])
    carried_by_a, carried_by_b = fixed[rows["body_a"]], fixed[rows["body_b"]]
    normals = np.concatenate([rows["normal"][carried_by_a], -rows["normal"][carried_by_b]])
    return list(np.unique(normals.round(1), axis=0))


def _patch_frame(plane: Plane, rotation: Array) -> Array:
    """Columns x, y, normal (3, 3) of a plane's patch in its body's frame; x points down the slope if there is one."""
    normal = np.array(plane.normal)
    up = rotation @ normal
    downhill = up * up[2] - np.array([0.0, 0.0, 1.0])
    if np.linalg.norm(downhill) < 1e-6:
        downhill = np.array([1.0, 0.0, 0.0])
    x = rotation.T @ (downhill / np.linalg.norm(downhill))
    return np.column_stack([x, np.cross(normal, x), normal])


def _patch_size(local: Array, seen: Survey) -> tuple[Array, Array]:
    """Lowest and highest corner (2,) of a patch, in whole cells, with some room around the points."""
    margin = max(2.0 * seen.cell, 0.75 * seen.typical)
    low = np.floor((local[:, :2].min(axis=0) - margin) / seen.cell)
    high = np.ceil((local[:, :2].max(axis=0) + margin) / seen.cell)
    # an even number of cells puts the middle, where the grid starts, on a line of the plane's own grid
    high += (high - low) % 2
    return low * seen.cell, high * seen.cell


def _block(half: Array, frame: Array, thickness: float, *, wedge: bool) -> meshes.Mesh:
    """What is under a patch of half that size (2,), in the patch's own axes, the columns of ``frame`` in the world.

    A floor is a slab. A slope stands on a wedge with a level bottom: a slab alone in the air could as well be a floor
    seen askew. A wall or a ceiling is one sheet, which does not show from behind, so that it hides nothing.
    """
    top = np.array([[x * half[0], y * half[1], 0.0] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    if frame[2, 2] < LEAST_SLOPE_COSINE:
        return meshes.sheet(top)
    if frame[2, 2] > LEVEL or not wedge:
        return meshes.prism(top, top - (0.0, 0.0, thickness))
    heights = top @ frame[2]
    return meshes.prism(top, top - (heights - heights.min() + thickness)[:, None] * frame[2])


def _changes(frames: Frames) -> NDArray[np.bool_]:
    """(n,) whether a body ever moves or changes its state."""
    moved: NDArray[np.bool_] = (frames.positions != frames.positions[0]).any(axis=(0, 2))
    moved |= (frames.orientations != frames.orientations[0]).any(axis=(0, 2))
    moved |= (frames.motion != frames.motion[0]).any(axis=0)
    return moved


def _key(shape: Shape) -> str:
    """Equal for shapes that share a mesh."""
    return f"hull {shape.points.tobytes().hex()}" if isinstance(shape, ConvexHull) else repr(shape)


def _clean(name: str) -> str:
    """A body's name as a node of viser's tree, where slashes part folders."""
    return name.replace("/", "\u2215")
