"""Quaternions (w, x, y, z) on numpy arrays, as far as scenes and adapters need them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

IDENTITY = (1.0, 0.0, 0.0, 0.0)


def about(axis: ArrayLike, angle: float) -> Array:
    """The turn by ``angle`` rad about a unit ``axis``."""
    return np.array([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * np.asarray(axis, dtype=np.float64))])


def product(p: ArrayLike, q: ArrayLike) -> Array:
    """First q, then p; either may be (n, 4)."""
    a, b = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    u, v = a[..., 1:], b[..., 1:]
    w = a[..., :1] * b[..., :1] - (u * v).sum(-1, keepdims=True)
    return np.concatenate([w, a[..., :1] * v + b[..., :1] * u + np.cross(u, v)], axis=-1)


def matrix(q: ArrayLike) -> Array:
    """The rotation matrix of (4,), or of each row of (n, 4); its columns are the turned axes."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def rotation_vector(q: ArrayLike) -> Array:
    """Axis times angle in rad, (3,)."""
    w, *v = np.asarray(q, dtype=np.float64)
    length = float(np.linalg.norm(v))
    return np.array(v) * (2.0 * math.atan2(length, w) / length if length > 1e-12 else 2.0)


def random_quaternion(rng: np.random.Generator) -> Array:
    """A turn drawn evenly from all turns."""
    q = rng.normal(size=4)
    return np.asarray(q / np.linalg.norm(q))
