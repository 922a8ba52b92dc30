"""The state of a batch at one moment, as plain arrays: enough to go on from it to the last bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.core import state

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BatchState:
    """A copy of the worlds of a :class:`stiction.Batch`, contacts and their memory included.

    Attributes:
        arrays: blocks by name, worlds along the first axis.
        steps: (worlds,) steps since each world began.
        failed: (worlds,) whether it was frozen.
        n: bodies of a world.
    """

    arrays: dict[str, NDArray[Any]]
    steps: NDArray[np.int64]
    failed: NDArray[np.bool_]
    n: int

    def __len__(self) -> int:
        """Worlds in it."""
        return len(self.steps)

    def _columns(self, start: int, width: int) -> Array:
        columns: Array = self.arrays["bodies"][:, : self.n, start : start + width]
        return columns

    @property
    def positions(self) -> Array:
        """(worlds, n, 3) m."""
        return self._columns(state.POSITION, 3)

    @property
    def orientations(self) -> Array:
        """(worlds, n, 4) unit quaternions (w, x, y, z)."""
        return self._columns(state.ORIENTATION, 4)

    @property
    def velocities(self) -> Array:
        """(worlds, n, 3) m/s of the centres of mass."""
        return self._columns(state.V, 3)

    @property
    def angular_velocities(self) -> Array:
        """(worlds, n, 3) rad/s in world axes."""
        return self._columns(state.W, 3)
