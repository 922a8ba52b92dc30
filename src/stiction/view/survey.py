"""What a run needs of space: where its bodies are and go and how large they are, so that all of it can be shown."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiction.record.frames import Frames
from stiction.view import meshes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FARTHEST = 25.0
"""Bodies that end up farther away than this many sizes of the scene at its start are left out of the first picture."""
CELLS = 12
"""The grid has about this many cells along the longer side of what is seen."""
SURVEY = 24
"""Frames looked at to find the bounds of the run."""


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


def survey(frames: Frames) -> Survey:
    """Bounds of what moves over the whole run, without what flies off."""
    bounded = [n for n, body in enumerate(frames.bodies) if body.shape.bounded]
    moving = np.array([n for n in bounded if not frames.bodies[n].fixed] or bounded, dtype=np.int64)
    if not len(moving):
        return Survey(
            np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]]),
            np.zeros((1, 0, 3)),
            np.zeros(0),
            np.zeros(0),
            1.0,
            0.5,
            moving,
        )
    looked_at = np.unique(np.linspace(0, len(frames) - 1, SURVEY).astype(int))
    boxes = [meshes.bounds(frames.bodies[n].shape) for n in moving]
    local = np.array([corners(low, high) for low, high in boxes])
    # (k, n, 8, 3): every corner of every moving body at every frame looked at
    turned = np.einsum("knij,ncj->knci", matrices(frames.orientations[looked_at][:, moving]), local)
    points = turned + frames.positions[looked_at][:, moving, None]
    radii = np.array([float(np.linalg.norm(high - low)) / 2 for low, high in boxes])
    start = points[0].reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(start, axis=0)))
    away = np.linalg.norm(points - start.mean(axis=0), axis=-1).max(axis=-1)
    near = points[away <= FARTHEST * size].reshape(-1, 3)
    extent = float(np.ptp(near, axis=0).max())
    start_middle_end = np.unique([0, len(looked_at) // 2, len(looked_at) - 1])
    return Survey(
        points=near,
        centers=points[start_middle_end].mean(axis=2),
        radii=radii,
        cores=np.array([float((high - low).min()) / 2 for low, high in boxes]),
        typical=float(np.median([(high - low).mean() for low, high in boxes])),
        cell=round_length(extent / CELLS),
        moving=moving,
    )


def round_length(length: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    if not length > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(length))
    return min((power, 2 * power, 5 * power, 10 * power), key=lambda c: abs(math.log(c / length)))


def corners(low: Array, high: Array) -> Array:
    """The eight corners (8, 3) of a box between two of them."""
    choose = np.array([[(k >> axis) & 1 for axis in range(3)] for k in range(8)], dtype=bool)
    return np.where(choose, high, low)


def world_corners(frames: Frames, n: int, k: int) -> Array:
    """Corners (8, 3) of the box around body n in frame k, in m."""
    box = corners(*meshes.bounds(frames.bodies[n].shape))
    result: Array = box @ matrices(frames.orientations[k, n]).T + frames.positions[k, n]
    return result


def matrices(quaternions: Array) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), w first."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    result: Array = np.moveaxis(rows, (0, 1), (-2, -1))
    return result


def quaternion(matrix: Array) -> Array:
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
