"""Learning environments for Gymnasium in which friction is the point.

>>> import gymnasium, stiction.envs
>>> stiction.envs.register()                                             # done already where stiction is installed
>>> env = gymnasium.make("stiction/PuckPush-v0")                         # doctest: +SKIP
>>> many = gymnasium.make_vec("stiction/PuckPush-v0", num_envs=64)       # doctest: +SKIP
"""

from __future__ import annotations

import importlib
from typing import Any

from stiction.envs.registration import TASKS, register

__all__ = [
    "TASKS", "CrossEntropy", "Curling", "PuckPush", "StictionEnv", "StictionVectorEnv", "Task", "TrayBalance",
    "register",
]  # fmt: skip

_HOMES = {
    "CrossEntropy": "cross_entropy",
    "Curling": "curling",
    "PuckPush": "puck_push",
    "StictionEnv": "single",
    "StictionVectorEnv": "vector",
    "Task": "task",
    "TrayBalance": "tray_balance",
}


def __getattr__(name: str) -> Any:
    """Modules are loaded at first use: Gymnasium imports this package while it is being imported itself."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
