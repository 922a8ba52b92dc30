"""Scenes that run in milliseconds, and data made from them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.fit import Problem, Track, parse_all
from stiction.scene import Scene

PAIR = "materials.pairs.wood-ground"
DYNAMIC, STATIC = f"{PAIR}.dynamic", f"{PAIR}.static"


def crate_scene(**more: Any) -> Scene:
    """A crate of 10 kg that slides along x with 1.5 m/s over a plane; more keys of the scene, or others."""
    table: dict[str, Any] = {
        "title": "A crate",
        "expect": "It slides and stops.",
        "duration": 0.75,
        "world": {"dt": 1.0 / 60.0},
        "materials": {"base": "empty", "pairs": [{"a": "wood", "b": "ground", "static": 0.6, "dynamic": 0.4}]},
        "bodies": [
            {"name": "ground", "shape": {"type": "plane"}, "static": True, "material": "ground"},
            {
                "name": "crate",
                "shape": {"type": "box", "size": [0.4, 0.4, 0.2]},
                "mass": 10.0,
                "material": "wood",
                "position": [0.0, 0.0, 0.1],
                "velocity": [1.5, 0.0, 0.0],
            },
        ],
    }
    return Scene.from_dict(table | more, "crate")


def pulled_scene(**more: Any) -> Scene:
    """The same crate at rest, pulled with a force of 45 N that grows by 30 N/s until 0.5 s."""
    scene = crate_scene().to_dict()
    scene["bodies"][1]["velocity"] = [0.0, 0.0, 0.0]
    pull = {"body": "crate", "force": [45.0, 0.0, 0.0], "growth": [30.0, 0.0, 0.0], "until": 0.5}
    return Scene.from_dict({**scene, "duration": 0.8, "world": {"dt": 0.01}, "pushes": [pull], **more}, "pulled")


def made_up(
    scene: Scene, free: list[str], truth: list[float], times: NDArray[np.float64], noise: float, seed: int
) -> Problem:
    """A problem whose data come from the scene itself, with noise of that size in m."""
    parameters = parse_all(free, scene.table)
    blank = Track("", times, np.zeros((len(times), 3)))
    motion = Problem(scene, [blank], parameters).simulate(truth)[0]
    drawn = np.random.default_rng(seed).normal(size=motion.positions.shape)
    return Problem(scene, [Track("", times, motion.positions + noise * drawn)], parameters)
