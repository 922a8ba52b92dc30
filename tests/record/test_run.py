"""The run loop: everyone sees what they asked for, and the table says what became of the bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction import InvalidInputError, SimulationError
from stiction.core.solve.micro import TOLERANCE
from stiction.record.recorder import Recorder
from stiction.record.run import run, summary
from stiction.scene import Scene, Simulation, load

G = 9.81


def crates() -> Simulation:
    return Simulation(load("push-and-release"))


def test_progress_is_reported_up_to_the_end() -> None:
    simulation = crates()
    calls: list[tuple[int, int]] = []
    result = run(simulation, on_progress=lambda done, total: calls.append((done, total)))
    assert [done for done, _ in calls] == list(range(6, 601, 6))
    assert {total for _, total in calls} == {600}
    assert result.steps == 600
    np.testing.assert_allclose(result.time, 3.0)
    assert result.wall_seconds > 0
    assert result.bodies == summary(simulation, crates().world.positions)


def test_a_chunk_can_be_chosen_and_must_be_a_whole_number() -> None:
    simulation = crates()
    calls: list[int] = []
    run(simulation, on_progress=lambda done, total: calls.append(done), chunk=250)
    assert calls == [250, 500, 600]
    for chunk in (0, 2.5, True):
        with pytest.raises(InvalidInputError, match="chunk must be a whole number, 1 or more"):
            run(simulation, chunk=chunk)  # type: ignore[arg-type]  # wrong on purpose


def test_a_run_goes_on_where_the_simulation_stands() -> None:
    simulation, whole = crates(), crates()
    simulation.advance(101)
    recorder = Recorder(simulation.world, "t", every=100)
    result = run(simulation, recorder=recorder)
    assert result.steps == 499
    np.testing.assert_allclose(recorder.frames().times, [1.0, 1.5, 2.0, 2.5, 3.0])
    run(whole)
    assert simulation.world.state_hash() == whole.world.state_hash()
    assert run(simulation).steps == 0, "there is nothing left to do"


def test_frames_come_every_so_many_steps_and_at_the_end_without_changing_the_run() -> None:
    watched, alone = crates(), crates()
    recorder = Recorder(watched.world, "t", every=7)
    run(watched, recorder=recorder, chunk=5)
    run(alone)
    steps = np.round(recorder.frames().times / 0.005).astype(int)
    assert steps.tolist() == [*range(0, 600, 7), 600]
    assert watched.world.state_hash() == alone.world.state_hash()


def test_what_goes_wrong_is_raised_after_the_frames_up_to_there_were_kept() -> None:
    ball = {"name": "ball", "shape": {"type": "sphere", "radius": 1.0}, "velocity": [1e153, 0, 0]}
    data = {"title": "t", "expect": "e.", "duration": 99.0, "world": {"dt": 1.0, "gravity": [0, 0, 0]}}
    simulation = Simulation(Scene.from_dict({**data, "bodies": [ball]}))
    recorder = Recorder(simulation.world, "t")
    with pytest.raises(SimulationError):
        run(simulation, recorder=recorder)
    assert len(recorder) == simulation.step_index + 1 > 1


def test_the_table_says_what_became_of_each_body() -> None:
    simulation = crates()
    rows: dict[str, Any] = {row.name: row for row in run(simulation).bodies}
    assert list(rows) == ["resting, 440 N", "moving, 440 N", "resting, 540 N"], "the static floor is left out"
    held, moving = rows["resting, 440 N"], rows["moving, 440 N"]
    assert (held.shape, held.material, held.motion) == ("Box 0.8 x 0.8 x 0.6 m", "wood", "sticking")
    assert held.displacement < TOLERANCE * simulation.world.time
    assert moving.speed < 1e-5
    x = simulation.world["moving, 440 N"].position[0]
    np.testing.assert_allclose(moving.displacement, x, rtol=1e-9)
    np.testing.assert_allclose(moving.friction_work, 0.4 * 100 * G * x, rtol=1e-4)


def test_a_kinematic_body_is_in_the_table() -> None:
    paddle = {"name": "paddle", "shape": {"type": "box", "size": [1, 1, 1]}, "kinematic": True, "velocity": [3, 0, 4]}
    scene = {"title": "t", "expect": "e.", "duration": 2.0, "bodies": [paddle]}
    (row,) = run(Simulation(Scene.from_dict(scene))).bodies
    np.testing.assert_allclose([row.displacement, row.speed, row.friction_work], [10, 5, 0])
    assert row.motion == "fixed"
