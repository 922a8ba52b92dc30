"""Simulation: pushes and velocity changes at their times, whatever the steps and however they are cut."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction import InvalidInputError, SimulationError
from stiction.scene import Scene, Simulation, load

BALL = {"name": "ball", "shape": {"type": "sphere", "radius": 0.5}, "mass": 2.0}
PADDLE = {"name": "paddle", "shape": {"type": "box", "size": [1, 1, 1]}, "kinematic": True, "position": [9, 0, 0]}


def simulation(dt: float = 0.01, duration: float = 1.0, **parts: Any) -> Simulation:
    world = {"gravity": [0, 0, 0], "dt": dt}
    data = {"title": "t", "expect": "e.", "duration": duration, "world": world, "bodies": [BALL, PADDLE], **parts}
    return Simulation(Scene.from_dict(data))


def push(**parts: Any) -> dict[str, Any]:
    return {"body": "ball", "force": [4.0, 0.0, 0.0], **parts}


@pytest.mark.parametrize(
    ("dt", "duration", "steps"), [(0.01, 1.0, 100), (0.3, 1.0, 3), (0.4, 1.0, 2), (5.0, 1.0, 1), (1 / 60, 2.0, 120)]
)
def test_a_scene_takes_the_steps_that_come_nearest_to_its_duration(dt: float, duration: float, steps: int) -> None:
    run = simulation(dt, duration)
    assert run.total_steps == steps
    assert not run.done
    run.advance(steps + 1000)
    assert run.done
    assert run.step_index == run.world.steps == steps
    run.advance()
    assert run.step_index == steps, "the end is the end"


@pytest.mark.parametrize("steps", [0, -1, 1.5, True, "1"])
def test_steps_must_be_a_whole_number(steps: Any) -> None:
    run = simulation()
    with pytest.raises(InvalidInputError, match="steps must be a whole number, 1 or more"):
        run.advance(steps)
    assert run.step_index == 0


@pytest.mark.parametrize("dt", [0.01, 0.03, 0.007, 0.25])
@pytest.mark.parametrize(("start", "until"), [(0.2, 0.5), (0.0, 0.31), (0.123, 0.456), (0.301, 0.302)])
def test_a_push_gives_its_impulse_at_any_time_step(dt: float, start: float, until: float) -> None:
    run = simulation(dt, pushes=[push(**{"from": start, "until": until})])
    run.advance(1000)
    np.testing.assert_allclose(run.world["ball"].velocity, [4.0 * (until - start) / 2.0, 0, 0], rtol=1e-12)


def test_a_push_acts_within_its_window_only() -> None:
    run = simulation(pushes=[push(**{"from": 0.2, "until": 0.5})])
    ball = run.world["ball"]
    run.advance(20)
    np.testing.assert_array_equal(ball.velocity, 0)
    run.advance()
    np.testing.assert_allclose(ball.velocity, [0.02, 0, 0], rtol=1e-12)
    run.advance(29)
    np.testing.assert_allclose(ball.velocity, [0.6, 0, 0], rtol=1e-12)
    run.advance(50)
    np.testing.assert_allclose(ball.velocity, [0.6, 0, 0], rtol=1e-12)


def test_a_push_without_an_end_lasts_to_the_end_of_the_scene() -> None:
    run = simulation(pushes=[push(), push(force=[0, 2, 0], **{"from": 0.5})])
    run.advance(1000)
    np.testing.assert_allclose(run.world["ball"].velocity, [2.0, 0.5, 0], rtol=1e-12)


def test_a_push_at_a_point_follows_the_body_and_turns_it() -> None:
    # at the top of a ball that was turned upside down, the point lies below
    ball = {**BALL, "rotation": {"axis": [1, 0, 0], "angle_deg": 180}}
    run = simulation(pushes=[push(at=[0, 0, 0.5], until=0.01)], bodies=[ball])
    run.advance()
    inertia = 0.4 * 2.0 * 0.5**2
    np.testing.assert_allclose(run.world["ball"].angular_velocity, [0, -0.5 * 4.0 * 0.01 / inertia, 0], atol=1e-12)


def test_a_push_in_a_frame_has_its_axes() -> None:
    frames = {"quarter": {"rotation": {"axis": [0, 0, 1], "angle_deg": 90}}}
    run = simulation(pushes=[push(frame="quarter")], frames=frames)
    run.advance(1000)
    np.testing.assert_allclose(run.world["ball"].velocity, [0, 2.0, 0], atol=1e-12)


def test_a_kinematic_body_changes_its_velocity_at_the_nearest_step() -> None:
    changes = [
        {"body": "paddle", "time": 0.504, "velocity": [0, 0, 0], "angular_velocity": [0, 0, 1]},
        {"body": "paddle", "time": 0.2, "velocity": [3, 0, 0]},
    ]
    run = simulation(velocity_changes=changes, bodies=[{**PADDLE, "velocity": [1, 0, 0], "position": [0, 9, 0]}])
    paddle = run.world["paddle"]
    run.advance(1000)
    np.testing.assert_allclose(paddle.position, [0.2 * 1 + 0.3 * 3, 9, 0], rtol=1e-12)
    np.testing.assert_array_equal(paddle.angular_velocity, [0, 0, 1])


def test_however_the_steps_are_cut_the_end_is_the_same() -> None:
    overrides = ["duration=1.7", "pushes[0].from=0.3333", "pushes[2].until=0.777"]
    whole, pieces = (Simulation(load("push-and-release", overrides)) for _ in range(2))
    whole.advance(whole.total_steps)
    for size in (1, 2, 30, 3, 100):
        pieces.advance(size)
    assert pieces.step_index == 136
    while not pieces.done:
        pieces.advance(7)
    assert pieces.world.state_hash() == whole.world.state_hash()


def test_compiled_stepping_runs_from_change_to_change(monkeypatch: pytest.MonkeyPatch) -> None:
    run = simulation(pushes=[push(**{"from": 0.5, "until": 0.52})])
    calls: list[int] = []
    step = run.world.step
    monkeypatch.setattr(run.world, "step", lambda n=1: (calls.append(n), step(n)))
    run.advance(100)
    assert calls == [50, 1, 1, 48]


def test_a_world_that_blows_up_stops_at_its_last_finite_state() -> None:
    run = simulation(dt=1.0, duration=99.0, bodies=[{**BALL, "velocity": [1e307, 0, 0]}])
    with pytest.raises(SimulationError, match=r"step \d+: the state of body 'ball' is no longer finite"):
        run.advance(99)
    assert np.isfinite(run.world.positions).all()
    assert not run.done
