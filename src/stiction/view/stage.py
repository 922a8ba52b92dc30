"""The stage of a scene in viser: camera and light, and the grounds on which things move."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.record.frames import Frames
from stiction.record.recorder import Frame
from stiction.shapes import Plane
from stiction.view import camera, meshes, style
from stiction.view.instances import add_instances
from stiction.view.survey import Survey, matrices, quaternion, world_corners

if TYPE_CHECKING:
    from viser import ViserServer

Array = NDArray[np.float64]
Update = Callable[[Frame], None]
"""Brings nodes that were put up to a moment of the world."""

LEAST_SLOPE_COSINE = 0.3
"""Planes whose normal is nearer to the horizontal than this cosine are walls, not slopes."""
LEVEL = 0.9999
"""Planes whose normal is nearer to the vertical than this cosine are floors."""


@contextmanager
def quiet() -> Iterator[None]:
    """Keeps viser from announcing its server, which it does through rich's console even when told not to be verbose."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def set_stage(server: ViserServer, view: camera.Camera) -> None:
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


def add_grounds(server: ViserServer, frames: Frames, seen: Survey, view: camera.Camera) -> list[Update]:
    """A block with a grid on it for every plane, large enough for all that comes to it."""
    # fixed bodies stand on the ground too, but one that reaches far out must not make it endless
    lowest, highest = seen.points.min(axis=0), seen.points.max(axis=0)
    room = 0.5 * (highest - lowest).max()
    fixed = [n for n, body in enumerate(frames.bodies) if body.fixed and body.shape.bounded]
    everything = np.concatenate(
        [seen.points, *(np.clip(world_corners(frames, n, 0), lowest - room, highest + room) for n in fixed)]
    )
    planes = [n for n, body in enumerate(frames.bodies) if isinstance(body.shape, Plane)]
    moves = changes(frames)
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
        name = f"/ground/{clean(frames.bodies[n].name)}"
        holder = server.scene.add_frame(name, show_axes=False)
        patch = {"wxyz": quaternion(frame), "position": frame @ np.array([*(low + high) / 2, plane.offset])}
        block = _block((high - low) / 2, rotation @ frame, 0.25 * seen.cell, wedge=not moves[n])
        add_instances(server, f"{name}/block", block, np.zeros((1, 3)), colors=style.surface(style.GROUND), **patch)
        updates.append(_follower(holder, n))
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


def _follower(handle: Any, n: int) -> Update:
    """Keeps a node where body n is."""
    there: list[float] = []

    def update(frame: Frame) -> None:
        nonlocal there
        here = [*frame.positions[n].tolist(), *frame.orientations[n].tolist()]
        if here != there:  # most grounds never move, and viser takes long to find that out
            there = here
            handle.position, handle.wxyz = frame.positions[n], frame.orientations[n]

    return update


# --- geometry ---------------------------------------------------------------------------------------------------------


def first_view(frames: Frames, seen: Survey) -> camera.Camera:
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


def changes(frames: Frames) -> NDArray[np.bool_]:
    """(n,) whether a body ever moves or changes its state."""
    moved: NDArray[np.bool_] = (frames.positions != frames.positions[0]).any(axis=(0, 2))
    moved |= (frames.orientations != frames.orientations[0]).any(axis=(0, 2))
    moved |= (frames.motion != frames.motion[0]).any(axis=0)
    return moved


def clean(name: str) -> str:
    """A body's name as a node of viser's tree, where slashes part folders."""
    return name.replace("/", "\u2215")
