"""Scenes: TOML files that say what is there, what acts on it, and what must come of it."""

from __future__ import annotations

from stiction.scene.load import builtin_names, builtin_text, json_schema, load
from stiction.scene.scene import Scene
from stiction.scene.simulation import Simulation

__all__ = ["Scene", "Simulation", "builtin_names", "builtin_text", "json_schema", "load"]
