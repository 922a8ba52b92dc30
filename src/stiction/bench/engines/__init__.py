"""Adapters of the engines that scenes are run in; each is imported when it is asked for."""

from __future__ import annotations

import importlib

from stiction import checks
from stiction.bench.engines.base import Engine

OWN = "stiction"
PEERS = ("mujoco", "rapier3d", "robox3d", "pybullet", "sapien")
ENGINES = (OWN, *PEERS)


def engine_class(name: str) -> type[Engine]:
    """The adapter of that name; the engine itself is not imported.

    Raises:
        InvalidInputError: there is no such adapter.
    """
    checks.one_of("engine", name, ENGINES)
    made: type[Engine] = importlib.import_module(f"stiction.bench.engines.with_{name}").Adapter
    return made


__all__ = ["ENGINES", "OWN", "PEERS", "Engine", "engine_class"]
