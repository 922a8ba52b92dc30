"""A tiny world in plain Python takes the very steps of the compiled one: one source, two ways to run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import stiction

PROGRAM = """
import json
import numba
import stiction as st

world = st.World(solver="micro")
world.materials.set_pair("a", "b", static=0.5, dynamic=0.4, restitution=0.5, rolling=1e-3, torsional=1e-3)
world.add(st.Plane(), static=True, material="a")
world.add(st.Box((1, 1, 0.5)), position=(0, 0, 0.25), velocity=(1, 0.5, 0), angular_velocity=(0, 0, 1), material="b")
world.add(st.Sphere(0.3), position=(0, 1.0, 0.31), velocity=(0.2, -4, -1), material="b")
world["box 1"].apply_force((0, 0, 20), at=(0.2, 0, 0.5))
for _ in range(5):
    world.step()
state = [world.positions, world.orientations, world.velocities, world.angular_velocities]
print(json.dumps({
    "plain": bool(numba.config.DISABLE_JIT),
    "state": [x.hex() for array in state for x in array.ravel().tolist()],
    "contacts": len(world.contacts()),
    "energy": list(world.energy()),
    "visits": world.report().visits,
}))
"""
"""A crate slides and turns, a ball bounces off it and off the ground."""


def run(plain: bool) -> dict[str, object]:
    """What PROGRAM prints, with or without the compiler."""
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    environment["PYTHONPATH"] = str(Path(stiction.__file__).parents[1])
    if plain:
        environment["NUMBA_DISABLE_JIT"] = "1"
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    found: dict[str, object] = json.loads(result.stdout)
    return found


def numbers(hexadecimal: object) -> list[float]:
    """Floats of their exact texts."""
    assert isinstance(hexadecimal, list)
    return [float.fromhex(x) for x in hexadecimal]


def test_plain_python_steps_as_the_compiled_kernels_do() -> None:
    """Equal up to the last digits of sine and cosine, which are those of two libraries."""
    plain, compiled = run(plain=True), run(plain=False)
    assert plain["plain"] is True
    assert compiled["plain"] is False
    np.testing.assert_allclose(numbers(plain["state"]), numbers(compiled["state"]), rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.array(plain["energy"]), np.array(compiled["energy"]), rtol=1e-12, atol=1e-11)
    assert plain["contacts"] == compiled["contacts"]
    assert plain["visits"] == compiled["visits"]
    # it was a world in which something happened
    assert plain["contacts"]
    assert all(isinstance(v, int) for v in plain["visits"])  # type: ignore[attr-defined]  # a list of ints
    assert sum(plain["visits"]) > 20  # type: ignore[call-overload]  # a list of ints
