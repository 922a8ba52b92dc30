"""Frames: a run as arrays in memory, the one form that viewer, plots, tables and files share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.contacts import CONTACT_DTYPE
from stiction.shapes import Shape

__all__ = ["CONTACT_DTYPE", "BodyInfo", "Frames"]


@dataclass(frozen=True)
class BodyInfo:
    """What does not change about a body: name, shape, material, mass in kg (inf for a fixed one), fixed or not."""

    name: str
    shape: Shape
    material: str
    mass: float
    fixed: bool


@dataclass
class Frames:
    """f frames of a world of n bodies.

    Attributes:
        title: of the scene.
        dt: time step of the simulation in s (frames may be further apart).
        bodies: n rows of what does not change.
        times: (f,) in s.
        positions, velocities, angular_velocities: (f, n, 3) in m, m/s and rad/s.
        orientations: (f, n, 4) unit quaternions (w, x, y, z).
        motion: (f, n) uint8 values of :class:`stiction.motion.Motion`.
        contacts: rows of ``CONTACT_DTYPE`` of all frames, one frame after the other.
        contact_offsets: (f + 1,) rows of frame k are ``contacts[contact_offsets[k]:contact_offsets[k + 1]]``.
        meta: anything else worth keeping (scene text, versions, seeds).
    """

    title: str
    dt: float
    bodies: list[BodyInfo]
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    orientations: NDArray[np.float64]
    velocities: NDArray[np.float64]
    angular_velocities: NDArray[np.float64]
    motion: NDArray[np.uint8]
    contacts: NDArray[Any]
    contact_offsets: NDArray[np.int64]
    meta: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.times)

    def contacts_of(self, frame: int) -> NDArray[Any]:
        """Contact rows of one frame, a view."""
        return self.contacts[self.contact_offsets[frame] : self.contact_offsets[frame + 1]]
