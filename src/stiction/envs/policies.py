"""A policy for PuckPush with few numbers, to learn by :class:`CrossEntropy`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction.envs.arena import Observations

Array = NDArray[np.float64]

FEATURES = 6
PUSH_PARAMETERS = 2 * FEATURES


def push_policy(parameters: Array, observations: Observations) -> Array:
    """Velocity of the pusher in the frame whose first axis points from the puck to the target.

    tanh of a linear function of: 1, distance to the target, velocity of the puck along and across, place of the pusher
    along and across (in dm, so that all are of one size). Linear in that frame, it is the same for all directions.

    Args:
        parameters: (worlds, 12), six for the motion along, six across.
        observations: (worlds, 8) of PuckPush.

    Returns:
        (worlds, 2) actions.
    """
    seen = observations.astype(np.float64)
    gap, v, arm = seen[:, 0:2], seen[:, 2:4], seen[:, 4:6]
    distance = np.sqrt(gap[:, 0] ** 2 + gap[:, 1] ** 2)
    along = gap / np.maximum(distance, 1e-9)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    parts = [(vector * axis).sum(axis=1) for vector in (v, 10.0 * arm) for axis in (along, across)]
    features = np.stack([np.ones_like(distance), distance, *parts], axis=1)
    own = np.tanh((parameters.reshape(-1, 2, FEATURES) * features[:, None]).sum(axis=2))
    actions: Array = own[:, :1] * along + own[:, 1:] * across
    return actions
