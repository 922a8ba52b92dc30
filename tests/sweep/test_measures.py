"""What metrics can ask of a run, against closed forms and hand-made frames."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction
from stiction.errors import InvalidInputError
from stiction.record.recorder import Recorder
from stiction.sweep.expressions import Expression
from stiction.sweep.measures import MEASURES, Measures

G, V, MU, DT = 9.81, 2.0, 0.4, 1.0 / 240.0
Ask = Callable[[str], Any]


def asker(world: stiction.World, steps: int) -> Ask:
    """Steps a world and answers expressions about it."""
    recorder = Recorder(world, "run", motion=False)
    recorder.capture()
    for _ in range(steps):
        world.step()
        recorder.capture()
    measures = Measures(recorder.frames(), world)
    return lambda text: Expression(text, "value").evaluate(measures.names(), measures.functions())


@pytest.fixture(scope="module")
def sliding() -> Ask:
    """A crate of 10 kg that slides along (3, 4, 0) and stops after V / (MU G) = 0.51 s."""
    table = stiction.MaterialTable()
    table.set_pair("crate", "floor", static=MU, dynamic=MU)
    world = stiction.World(dt=DT, materials=table)
    world.add(stiction.Plane(), static=True, material="floor", name="floor")
    start = np.array([0.6, 0.8, 0.0]) * V
    box = stiction.Box((1, 1, 0.4))
    world.add(box, mass=10, material="crate", name="crate", position=(0, 0, 0.2), velocity=start)
    return asker(world, 240)


def test_a_sliding_crate(sliding: Ask) -> None:
    way, end = V**2 / (2 * MU * G), V / (MU * G)
    for text in ("slip_distance('crate')", "displacement('crate')", "path_length('crate')", "integral(speed('crate'))"):
        assert sliding(text) == pytest.approx(way, rel=1e-3), text
    assert sliding("time_to_rest('crate')") == pytest.approx(end, abs=2 * DT)
    assert sliding("when(speed('crate') < 1)") == pytest.approx(end / 2, abs=2 * DT)
    assert sliding("at(speed('crate'), 0.1)") == pytest.approx(V - MU * G * 0.1, rel=1e-3)
    assert sliding("friction_work('crate')") == pytest.approx(0.5 * 10 * V**2, rel=1e-4)
    assert sliding("dissipated()") == pytest.approx(20.0, rel=1e-3)
    assert sliding("kinetic_energy()") == pytest.approx(0.0, abs=1e-9)
    assert sliding("mean(normal_force('crate'))") == pytest.approx(10 * G, rel=1e-4)
    assert sliding("median(friction_force('crate')[:60])") == pytest.approx(MU * 10 * G, rel=1e-3)
    assert sliding("velocity('crate')[0, 1]") == pytest.approx(0.8 * V)
    assert sliding("motion('crate') == 'sticking'") and not sliding("tipped('crate')")
    assert sliding("max(tilt('crate'))") < 1e-3


def test_what_moves_to_the_end_never_comes_to_rest() -> None:
    world = stiction.World(gravity=(0, 0, 0), dt=0.01)
    world.add(stiction.Sphere(0.5), name="ball", velocity=(1, 0, 0))
    world.add(stiction.Sphere(0.5), name="still", position=(9, 9, 0))
    ask = asker(world, 10)
    assert math.isnan(ask("time_to_rest('ball')")) and ask("time_to_rest('still')") == 0.0
    assert ask("time_to_rest('ball', 2)") == 0.0 and ask("time_to_rest('ball', speed=2)") == 0.0
    assert math.isnan(ask("when(speed('ball') > 2)"))
    assert ask("last(time)") == pytest.approx(0.1) and ask("g") == 0.0 and ask("dt") == 0.01


def test_tilt_counts_turning_about_level_axes_alone() -> None:
    world = stiction.World(gravity=(0, 0, 0), dt=0.01)
    half = math.sqrt(0.5)
    world.add(stiction.Sphere(0.5), name="spins", angular_velocity=(0, 0, 3), orientation=(half, half, 0, 0))
    world.add(stiction.Sphere(0.5), name="falls", position=(5, 0, 0), angular_velocity=(0, 1.5, 0))
    ask = asker(world, 100)
    assert ask("max(tilt('spins'))") == pytest.approx(0.0, abs=1e-6)
    assert ask("last(tilt('falls'))") == pytest.approx(1.5, rel=1e-4)
    assert ask("tipped('falls')") and not ask("tipped('falls', 90)") and not ask("tipped('spins', 1)")


def test_a_belt_slips_under_what_it_carries() -> None:
    table = stiction.MaterialTable()
    table.set_pair("crate", "belt", static=MU, dynamic=MU)
    world = stiction.World(dt=DT, materials=table)
    belt = stiction.Box((20, 2, 0.2))
    world.add(belt, static=True, material="belt", name="belt", position=(0, 0, -0.1), surface_velocity=(V, 0, 0))
    crate = stiction.Box((0.5, 0.5, 0.2))
    world.add(crate, mass=10, material="crate", name="crate", position=(0, 0, 0.1))
    ask = asker(world, 180)
    assert ask("slip_distance('crate')") == pytest.approx(V**2 / (2 * MU * G), rel=0.02)
    assert ask("last(slip_speed('crate'))") == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("speed('crte')", "body must be one of the scene, got 'crte' (did you mean 'crate'?)."),
        ("integral(3)", "integral needs a series of 241 numbers, one a frame, got shape ()."),
        ("speed('crate') + time[1:]", "value cannot be computed: \"speed('crate') + time[1:]\" (operands could not be"),
    ],
)
def test_what_cannot_be_answered_is_one_sentence(sliding: Ask, text: str, sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        sliding(text)
    assert str(caught.value).startswith(sentence)


def test_every_function_is_told_in_the_documentation() -> None:
    page = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    assert all(text for text in MEASURES.values())
    assert [name for name in MEASURES if f"`{name}(" not in page] == []
