"""The names of the environments, and making them known to Gymnasium."""

from __future__ import annotations

TASKS = ("PuckPush", "TrayBalance", "Curling")
"""Environments, without namespace and version."""
NAMESPACE = "stiction"


def register() -> None:
    """Make ``stiction/PuckPush-v0`` and the others known to ``gymnasium.make`` and ``make_vec``.

    Importing :mod:`stiction.envs` does it, where Gymnasium is installed; ``gymnasium.make`` imports it by itself if it
    is asked for ``"stiction.envs:stiction/PuckPush-v0"``. Calling it again does nothing.
    """
    from gymnasium.envs.registration import register as enter
    from gymnasium.envs.registration import registry

    for name in TASKS:
        if f"{NAMESPACE}/{name}-v0" not in registry:
            enter(
                f"{NAMESPACE}/{name}-v0",
                entry_point="stiction.envs.single:StictionEnv",
                vector_entry_point="stiction.envs.vector:StictionVectorEnv",
                kwargs={"task": name},
            )
