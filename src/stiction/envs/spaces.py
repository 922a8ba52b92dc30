"""Gymnasium's spaces of a task."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box

from stiction.envs.task import Task

RENDER_MODES = ("human", "rgb_array")


def observation_space(task: Task) -> Any:
    """A Box of numbers within the task's limits; not typed, for a Box is one of all its dtypes to mypy."""
    limits = np.array(task.limits, np.float32)
    return Box(-limits, limits, dtype=np.float32)


def action_space(task: Task) -> Any:
    """As many numbers from -1 to 1 as the task takes."""
    return Box(-1.0, 1.0, (task.actions,), np.float32)
