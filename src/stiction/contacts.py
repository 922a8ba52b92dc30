"""The structured array in which contact points are reported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.core import state

TOUCHING = 1e-5
"""m: points without a load are reported if the bodies are no farther apart."""

CONTACT_DTYPE = np.dtype(
    [
        ("body_a", np.int32),
        ("body_b", np.int32),
        ("point", np.float64, (3,)),
        ("normal", np.float64, (3,)),
        ("separation", np.float64),
        ("normal_impulse", np.float64),
        ("friction_impulse", np.float64, (3,)),
        ("sticking", np.bool_),
    ]
)
"""A row a contact point: indices of the bodies (a < b), point half way between the surfaces (m), normal from a to b,
separation (m, negative when they overlap), impulses of the last step that act on b (N s; on a the opposite), and
whether the point sticks."""


def contact_rows(numbers: NDArray[np.float64], tags: NDArray[np.int64]) -> NDArray[Any]:
    """The report of contact points, from their rows in :mod:`stiction.core.state`; (m,) of :data:`CONTACT_DTYPE`."""
    keep = np.flatnonzero((numbers[:, state.TOTAL] > 0.0) | (numbers[:, state.SEPARATION] <= TOUCHING))
    if len(keep) < len(numbers):
        numbers, tags = numbers.take(keep, axis=0), tags.take(keep, axis=0)
    rows = np.empty(len(numbers), CONTACT_DTYPE)
    rows["body_a"], rows["body_b"] = tags[:, state.BODY_A], tags[:, state.BODY_B]
    rows["point"] = numbers[:, state.POINT : state.POINT + 3]
    rows["normal"] = numbers[:, state.NORMAL : state.NORMAL + 3]
    rows["separation"] = numbers[:, state.SEPARATION]
    rows["normal_impulse"] = numbers[:, state.TOTAL]
    rows["friction_impulse"] = numbers[:, state.TOTAL_FRICTION : state.TOTAL_FRICTION + 3]
    rows["sticking"] = (numbers[:, state.TOTAL] > 0.0) & (tags[:, state.STATUS] & state.SLIDING != state.SLIDING)
    return rows
