"""Springs and growing forces of a scene: what they do to a body is the closed form, at any time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from stiction import InvalidInputError
from stiction.scene import Scene, Simulation

BALL = {"name": "ball", "shape": {"type": "sphere", "radius": 0.5}, "mass": 2.0}
WALL = {"name": "wall", "shape": {"type": "box", "size": [1, 1, 1]}, "static": True, "position": [0, 0, 9]}
TURNED = {"slope": {"position": [1, 0, 0], "rotation": {"axis": [0, 0, 1], "angle_deg": 90}}}


def simulation(dt: float = 0.01, duration: float = 1.0, **parts: Any) -> Simulation:
    world = {"gravity": [0, 0, 0], "dt": dt}
    data = {"title": "t", "expect": "e.", "duration": duration, "world": world, "bodies": [BALL, WALL], **parts}
    return Simulation(Scene.from_dict(data))


def spring(**parts: Any) -> dict[str, Any]:
    return {"body": "ball", "stiffness": 8.0, "anchor": [0, 0, 0], **parts}


# --- forces that grow -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dt", [0.01, 0.03, 0.25])
@pytest.mark.parametrize(("start", "until"), [(0.2, 0.5), (0.0, 0.31), (0.123, 0.456), (0.301, 0.302)])
def test_a_growing_push_gives_its_impulse_at_any_time_step(dt: float, start: float, until: float) -> None:
    push = {"body": "ball", "force": [4, 0, 0], "growth": [0, 6, 0], "from": start, "until": until}
    run = simulation(dt, pushes=[push])
    run.advance(1000)
    lasts = until - start
    np.testing.assert_allclose(run.world["ball"].velocity, [2 * lasts, 1.5 * lasts**2, 0], rtol=1e-12)


def test_growth_is_in_the_axes_of_the_frame() -> None:
    push = {"body": "ball", "force": [0, 0, 0], "growth": [4, 0, 0], "frame": "slope"}
    run = simulation(pushes=[push], frames=TURNED)
    run.advance(1000)
    np.testing.assert_allclose(run.world["ball"].velocity, [0, 1, 0], atol=1e-12)


# --- springs ----------------------------------------------------------------------------------------------------------


def test_a_spring_swings_a_body_with_its_frequency_and_neither_feeds_nor_damps_it() -> None:
    run = simulation(0.01, 50.0, springs=[spring()], bodies=[{**BALL, "position": [0.3, 0, 0]}])
    ball, w = run.world["ball"], math.sqrt(8.0 / 2.0)
    energies, places = [], []
    while not run.done:
        run.advance()
        x, v = ball.position[0], ball.velocity[0]
        # what the rule of the force keeps is the energy with a mass that is less by k dt^2 / 4
        energies.append(0.5 * (2.0 - 8.0 * 0.01**2 / 4) * v * v + 0.5 * 8.0 * x * x)
        places.append(x)
    np.testing.assert_allclose(energies, energies[0], rtol=1e-9)
    times = 0.01 * np.arange(1, len(places) + 1)
    # its phase runs ahead by (w dt)^2 / 24 of itself
    np.testing.assert_allclose(
        places, 0.3 * np.cos(w * times), atol=0.3 * (w * times[-1] * (w * 0.01) ** 2 / 24 + 1e-4)
    )


def test_what_a_spring_does_is_work_in_the_ledger() -> None:
    run = simulation(springs=[spring(anchor=[1, 0, 0])])
    run.advance(1000)
    energy, ball = run.world.energy(), run.world["ball"]
    assert energy.work == pytest.approx(ball.kinetic_energy) != 0.0
    assert energy.work == pytest.approx(0.5 * 8.0 * (1 - (1 - ball.position[0]) ** 2), rel=1e-3)


def test_a_moving_end_drags_the_body_along_in_the_axes_of_the_frame() -> None:
    moving = spring(anchor=[0, 0, 0], velocity=[0.5, 0, 0], frame="slope", stiffness=50.0)
    run = simulation(0.01, 2.0, springs=[moving], frames=TURNED, bodies=[{**BALL, "position": [1, 0, 0]}])
    run.advance(1000)
    w, t = 5.0, 2.0
    np.testing.assert_allclose(run.world["ball"].position, [1, 0.5 * (t - math.sin(w * t) / w), 0], atol=2e-4)


def test_a_spring_at_a_point_turns_the_body_to_it() -> None:
    run = simulation(springs=[spring(at=[0.5, 0, 0], anchor=[0.5, 1, 0], stiffness=0.01)], duration=0.1)
    run.advance(1000)
    ball = run.world["ball"]
    # F = k d, alpha = r F / (2/5 m r^2)
    np.testing.assert_allclose(ball.velocity, [0, 0.01 / 2.0 * 0.1, 0], rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(
        ball.angular_velocity, [0, 0, 0.5 * 0.01 / (0.4 * 2.0 * 0.25) * 0.1], rtol=1e-3, atol=1e-9
    )


def test_a_spring_acts_however_steps_are_cut() -> None:
    parts: dict[str, Any] = {"springs": [spring(velocity=[1, 0, 0])], "bodies": [BALL]}
    at_once, piecewise = simulation(**parts), simulation(**parts)
    at_once.advance(1000)
    while not piecewise.done:
        piecewise.advance(7)
    assert at_once.world.state_hash() == piecewise.world.state_hash()


def test_a_spring_survives_the_way_through_plain_data() -> None:
    scene = simulation(springs=[spring(velocity=[1, 0, 0], at=[0, 0, 0.1])]).scene
    assert Scene.from_dict(scene.to_dict()) == scene


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ({"springs": [spring(stiffness=0)]}, "springs[0].stiffness: must be above 0 N/m, got 0."),
        ({"springs": [spring(body="bal")]}, "springs[0].body: must be a body of the scene, got 'bal' (did you mean"),
        ({"springs": [spring(body="wall")]}, "springs[0].body: must be a dynamic body, and 'wall' is not."),
        ({"springs": [spring(frame="slop")]}, "springs[0].frame: must be a frame of the scene, got 'slop'."),
        ({"springs": [spring(anchor=[1, 2])]}, "springs[0].anchor: must be 3 finite numbers"),
        ({"springs": [spring(length=1)]}, "springs[0].length: is not a known key"),
        ({"springs": [spring(), spring(stiffness=8e4)]}, "springs[1].stiffness: must be below 4 m / dt^2 = 80000 N/m"),
        ({"pushes": [{"body": "ball", "force": [0, 0, 0], "growth": 3}]}, "pushes[0].growth: must be 3 finite numbers"),
    ],
)
def test_what_is_not_allowed_is_told_with_its_path(parts: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        simulation(**parts)
    assert str(caught.value).startswith(sentence)
