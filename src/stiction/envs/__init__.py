"""Learning environments for Gymnasium in which friction is the point.

>>> import gymnasium, stiction.envs                                      # which registers them
>>> env = gymnasium.make("stiction/PuckPush-v0")                         # doctest: +SKIP
>>> many = gymnasium.make_vec("stiction/PuckPush-v0", num_envs=64)       # doctest: +SKIP
"""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

from stiction.envs.registration import TASKS, register
from stiction.errors import InvalidInputError

__all__ = [
    "TASKS", "Arena", "CrossEntropy", "Curling", "PuckPush", "StictionEnv", "StictionVectorEnv", "Task", "TrayBalance",
    "register",
]  # fmt: skip

_HOMES = {
    "Arena": "arena",
    "CrossEntropy": "cross_entropy",
    "Curling": "curling",
    "PuckPush": "puck_push",
    "StictionEnv": "single",
    "StictionVectorEnv": "vector",
    "Task": "task",
    "TrayBalance": "tray_balance",
}

_NEED_GYMNASIUM = ("StictionEnv", "StictionVectorEnv")


def __getattr__(name: str) -> Any:
    """Modules are loaded at first use: names are registered without the compiler, and tasks need no Gymnasium."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name in _NEED_GYMNASIUM and importlib.util.find_spec("gymnasium") is None:
        raise InvalidInputError(f'{name} needs Gymnasium: pip install "stiction[gym]".')
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


if importlib.util.find_spec("gymnasium") is not None:
    register()
