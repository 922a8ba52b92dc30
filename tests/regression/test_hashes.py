"""Golden hashes: small scenes end in the very bits in which they ended when the hashes were written.

Bits depend on the machine's sine and cosine and on nothing else, so hashes are kept by class of machine. On a class
that nobody has written down yet, runs are compared with each other, and the test says that this was all it could do.
After a change of the physics, run this file with STICTION_REGENERATE=1 and look at the difference.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import stiction as st
from stiction.hashing import machine_class

FILE = Path(__file__).with_name("hashes.json")
REGENERATE = "STICTION_REGENERATE"
STEPS = 120


# --- scenes -----------------------------------------------------------------------------------------------------------


def ramp() -> st.World:
    """Crates on a slope of 25 degrees: one holds, one slides, one turns while it slides."""
    world = st.World(solver="micro", materials=st.MaterialTable.lecture())
    angle = math.radians(25)
    world.gravity = (9.81 * math.sin(angle), 0, -9.81 * math.cos(angle))
    world.add(st.Plane(), static=True, material="concrete")
    for y, material in ((0.0, "rubber"), (2.0, "wood"), (4.0, "wet rubber")):
        world.add(st.Box((1, 0.8, 0.5)), position=(0, y, 0.25), material=material)
    world.bodies[2].angular_velocity = (0, 0, 3)
    return world


def balls() -> st.World:
    """Balls that bounce, slide, roll and hit each other, with rolling and spinning resistance."""
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.4, dynamic=0.3, restitution=0.6, rolling=0.002, torsional=0.003)
    world = st.World(solver="micro", materials=table)
    world.add(st.Plane(), static=True)
    for k in range(5):
        at = (0.62 * k, 0.05 * (-1) ** k, 0.3 + 0.2 * k)
        world.add(st.Sphere(0.3), position=at, velocity=(2.0 - k, 0.1 * k, 0), angular_velocity=(0, 5.0 - k, k))
    return world


def wall() -> st.World:
    """A small wall of boxes that a ball knocks over."""
    world = st.World(solver="micro", materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete")
    for row in range(3):
        for k in range(3 - row):
            at = (0, 0.55 * k + 0.275 * row, 0.25 + 0.5 * row)
            world.add(st.Box((0.5, 0.5, 0.5)), position=at, material="wood")
    world.add(st.Sphere(0.25), density=3000, position=(-2, 0.5, 0.8), velocity=(8, 0, 1), material="metal")
    return world


def works() -> st.World:
    """A belt, a turntable that is driven, and a crate that is pushed: every kind of mobility."""
    world = st.World(solver="micro", dt=1 / 120, materials=st.MaterialTable.lecture())
    world.add(st.Box((6, 1, 0.2)), static=True, position=(0, 0, -0.1), surface_velocity=(1, 0, 0), material="rubber")
    world.add(
        st.Box((2, 2, 0.2)), kinematic=True, position=(4.1, 0, -0.1), angular_velocity=(0, 0, 1), material="rubber"
    )
    world.add(st.Box((0.4, 0.4, 0.4)), position=(2.6, 0.1, 0.2), orientation=(1, 0, 0, 0.2), material="concrete")
    world.add(st.Sphere(0.2), position=(-1, 0, 0.25), velocity=(0, 0.2, 0), material="concrete")
    world.bodies[2].apply_impulse((20, 10, 0), at=(2.6, 0, 0.3))
    return world


def stacks() -> st.World:
    """The default solver: a tower whose boxes are yawed, a crate that slides into it, another that spins."""
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.6, dynamic=0.4)
    world = st.World(materials=table)
    world.add(st.Box((40, 40, 1)), static=True, position=(0, 0, -0.5))
    for k in range(6):
        yaw = 0.1 * k
        world.add(
            st.Box((1, 1, 1)), position=(0, 0, 0.5 + k), orientation=(math.cos(0.5 * yaw), 0, 0, math.sin(0.5 * yaw))
        )
    world.add(st.Box((1, 0.8, 0.5)), position=(-4, 0.2, 0.25), velocity=(6, 0, 0))
    world.add(st.Box((1, 1, 0.3)), position=(3, 3, 0.15), velocity=(1, 0, 0), angular_velocity=(0, 0, 5))
    return world


SCENES: dict[str, Callable[[], st.World]] = {
    "ramp": ramp,
    "balls": balls,
    "wall": wall,
    "works": works,
    "stacks": stacks,
}

pytestmark = pytest.mark.filterwarnings("ignore::stiction.IterationLimitWarning")


def final_hash(scene: str, step: int = STEPS) -> str:
    """The hash after all steps, taken so many at a time."""
    world = SCENES[scene]()
    for _ in range(STEPS // step):
        world.step(step)
    return world.state_hash()


# --- tests ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def golden() -> dict[str, str]:
    """Hashes of this class of machine, or none."""
    if os.environ.get(REGENERATE):
        known = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
        known[machine_class()] = {scene: final_hash(scene) for scene in SCENES}
        FILE.write_text(json.dumps(known, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    found: dict[str, str] = json.loads(FILE.read_text(encoding="utf-8")).get(machine_class(), {})
    return found


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_ends_in_the_bits_in_which_it_always_ended(scene: str, golden: dict[str, str]) -> None:
    once = final_hash(scene)
    assert once == final_hash(scene)
    if not golden:
        pytest.skip(
            f"no hashes are kept for {machine_class()!r}: two runs were compared with each other, and they agree; "
            f"{REGENERATE}=1 adds this class of machine to {FILE.name}"
        )
    assert once == golden[scene], f"if the physics was meant to change, run this with {REGENERATE}=1"


@pytest.mark.parametrize("scene", SCENES)
def test_how_many_steps_a_call_takes_makes_no_difference(scene: str) -> None:
    assert len({final_hash(scene, step) for step in (1, 8, STEPS)}) == 1


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_is_worth_a_hash(scene: str) -> None:
    """Something moves, something touches, and nothing has flown away."""
    world = SCENES[scene]()
    before = world.state_hash()
    touched = 0
    for _ in range(STEPS):
        world.step()
        touched += len(world.contacts())
    assert world.state_hash() != before
    assert touched > STEPS
    assert world.energy().friction > 0.0
    assert abs(world.positions).max() < 50.0


def test_another_process_gets_the_same_bits() -> None:
    """Its memory lies elsewhere, its dictionaries hash otherwise."""
    code = (
        f"import importlib.util, warnings; warnings.simplefilter('ignore');"
        f"spec = importlib.util.spec_from_file_location('scenes', {str(Path(__file__))!r});"
        f"module = importlib.util.module_from_spec(spec); spec.loader.exec_module(module);"
        f"print(*(module.final_hash(scene) for scene in module.SCENES))"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(st.__file__).parents[1]), "PYTHONHASHSEED": "7"}
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.split() == [final_hash(scene) for scene in SCENES]
