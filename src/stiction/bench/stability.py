"""What became of a scene: how deep bodies lie in each other, how far they are from their places, what still stands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.bench import geometry
from stiction.bench.scene import BenchScene

Array = NDArray[np.float64]

LOST = 1.0
"""m below the ground at which a body has fallen through."""


class Stability(NamedTuple):
    """The end of a run; lengths in m. What a scene cannot answer is None.

    Attributes:
        overlap: deepest overlap of two spheres or boxes, exact; None where no such body is dynamic.
        ground_depth: deepest point of any body below the ground's surface.
        sink: mean height by which bodies are below their places.
        drift: largest horizontal distance from its place.
        out: bodies farther from their places than the scene's tolerance, sideways or downwards.
        lost: bodies that fell through the ground, or are no longer finite.
        speed: largest speed of a dynamic body, m/s.
        stands: nothing is out of its place and nothing is lost.
    """

    overlap: float | None
    ground_depth: float
    sink: float | None
    drift: float | None
    out: int | None
    lost: int
    speed: float
    stands: bool | None


def judge(scene: BenchScene, positions: Array, orientations: Array, velocities: Array) -> Stability:
    """What a scene's bodies have come to, from the poses and velocities that an engine gives for all bodies."""
    dynamic = scene.dynamic
    finite: NDArray[np.bool_] = np.asarray(np.isfinite(np.hstack([positions, orientations])).all(axis=1))
    safe_positions = np.where(finite[:, None], positions, 0.0)
    safe_orientations = np.where(finite[:, None], orientations, (1.0, 0.0, 0.0, 0.0))
    low = geometry.lowest(scene, safe_positions, safe_orientations)
    lost = dynamic & (~finite | (low < scene.floor - LOST))
    kept = dynamic & ~lost
    overlap = geometry.overlap(scene, safe_positions, safe_orientations) if finite[dynamic].all() else float("inf")
    depth = float(np.maximum(scene.floor - low[kept], 0.0).max(initial=0.0))
    speed = float(np.linalg.norm(velocities[kept], axis=1).max(initial=0.0))
    if scene.rest is None:
        return Stability(overlap, depth, None, None, None, int(lost.sum()), speed, None)

    move = (safe_positions - scene.rest)[dynamic]
    sideways = np.hypot(move[:, 0], move[:, 1])
    out = (sideways > scene.tolerance) | (move[:, 2] < -scene.tolerance) | lost[dynamic]
    drift = float(sideways.max(initial=0.0)) if finite[dynamic].all() else float("inf")
    sink = float(-move[:, 2].mean()) if len(move) else 0.0
    return Stability(overlap, depth, sink, drift, int(out.sum()), int(lost.sum()), speed, not out.any())
