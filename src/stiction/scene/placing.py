"""From the tables of a scene file to bodies with a place: frames are resolved and grids are rolled out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction.scene.model import BodyTable, FrameTable, Rotation, SceneTable

Array = NDArray[np.float64]

IDENTITY = (1.0, 0.0, 0.0, 0.0)


class Placed(NamedTuple):
    """One body, in world axes.

    Attributes:
        entry: number of its table in the file.
        name: of the body; a copy of a grid carries its indices.
        position: (3,), m. orientation: quaternion (4,). velocity, angular_velocity: (3,), m/s and rad/s.
    """

    entry: int
    name: str
    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array


class Frame(NamedTuple):
    """A place to stand: origin (3,) in m and orientation (4,) as a unit quaternion."""

    position: Array
    orientation: Array

    def turn(self, vector: ArrayLike) -> Array:
        """A vector of this frame in world axes."""
        return turned(self.orientation, np.asarray(vector, dtype=np.float64))


WORLD = Frame(np.zeros(3), np.array(IDENTITY))


def frame_of(scene: SceneTable, name: str | None) -> Frame:
    """The frame of that name, or the world's."""
    if name is None:
        return WORLD
    table = scene.frames[name]
    return Frame(np.array(table.position), _orientation(table))


def place(scene: SceneTable) -> Iterator[Placed]:
    """All bodies in the order of the file; the last index of a grid runs fastest."""
    for entry, body in enumerate(scene.bodies):
        frame = frame_of(scene, body.frame)
        own = product(frame.orientation, _orientation(body))
        velocity, spin = frame.turn(body.velocity), frame.turn(body.angular_velocity)
        for name, offset in copies(body):
            position = frame.position + frame.turn(np.array(body.position) + offset)
            yield Placed(entry, name, position, own, velocity, spin)


def copies(body: BodyTable) -> Iterator[tuple[str, Array]]:
    """Name and offset (3,) of every copy of a body; the body itself if it is no grid."""
    if body.grid is None:
        yield body.name, np.zeros(3)
        return
    for i, j, k in itertools.product(*(range(n) for n in body.grid.count)):
        yield f"{body.name}[{i},{j},{k}]", np.array((i, j, k)) * np.array(body.grid.step)


def _orientation(table: BodyTable | FrameTable) -> Array:
    if table.rotation is not None:
        return about(table.rotation)
    q = np.array(IDENTITY if table.orientation is None else table.orientation)
    return q / math.sqrt(q @ q)


def about(rotation: Rotation) -> Array:
    """The unit quaternion (cos a/2, sin a/2 axis) of a rotation by a about an axis."""
    axis = np.array(rotation.axis)
    half = 0.5 * math.radians(rotation.angle_deg)
    return np.array((math.cos(half), *(math.sin(half) / math.sqrt(axis @ axis) * axis)))


def product(p: Array, q: Array) -> Array:
    """The quaternion p q: first q, then p."""
    return np.array((p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))))


def turned(q: Array, v: Array) -> Array:
    """v (..., 3) turned by the unit quaternion q (..., 4): v + 2 w (u x v) + 2 u x (u x v), with u its vector part."""
    w, u = q[..., :1], q[..., 1:]
    twice = 2.0 * np.cross(u, v)
    return np.asarray(v + w * twice + np.cross(u, twice))
