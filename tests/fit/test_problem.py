"""Parameters by their keys, and simulated motion at the times of the data."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stiction.errors import InvalidInputError
from stiction.fit import Problem, Track, parse, parse_all
from stiction.fit.problem import rotation_between

from .support import DYNAMIC, PAIR, STATIC, crate_scene

TABLE = crate_scene().table


def track(times: list[float], body: str = "", turned: bool = False) -> Track:
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1)) if turned else None
    return Track(body, np.array(times), np.zeros((len(times), 3)), turns)


def test_a_parameter_starts_where_the_scene_is() -> None:
    found = parse(f"{STATIC}+{DYNAMIC}=0.2:0.7", TABLE)
    assert (found.name, found.keys) == ("wood-ground.static+dynamic", (STATIC, DYNAMIC))
    assert (found.low, found.high, found.first) == (0.2, 0.7, 0.6)
    assert parse(f"{PAIR}.restitution", TABLE).first == 0.5
    assert parse("bodies.crate.velocity[0]=1:2", TABLE).first == 1.5


@pytest.mark.parametrize(
    ("texts", "sentence"),
    [
        ([], "--free must name at least one key"),
        ([DYNAMIC, f"{STATIC}+{DYNAMIC}"], f"--free must name each key once, got '{DYNAMIC}' twice."),
        ([f"{DYNAMIC}=0.5"], f"range of {DYNAMIC} must be LOW:HIGH, such as 0.1:0.6, got '0.5'."),
        ([f"{DYNAMIC}=0.5:0.2"], "range of wood-ground.dynamic must be LOW:HIGH with LOW below HIGH, got 0.5:0.2."),
        (["bodies.crate.mass"], "parameter 'bodies.crate.mass' needs a range, such as bodies.crate.mass=0:1."),
        (["bodies.crate.name=0:1"], "parameter must be the path of a number, got 'bodies.crate.name'"),
        (["bodies.crat.mass=0:1"], "(did you mean 'crate'?)"),
    ],
)
def test_what_is_wrong_with_a_parameter(texts: list[str], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        parse_all(texts, TABLE)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("tracks", "sentence"),
    [
        ([track([0.0, 0.5], "crat")], "got 'crat' (did you mean 'crate'?)"),
        ([track([0.0, 0.5], "ground")], "body of the data must be one of the scene that moves, got 'ground'"),
        ([track([0.0, 2.0])], "data must end with the scene, at 0.75 s, got a sample at 2 s"),
        ([track([0.0, 0.5]), track([0.1], "crate")], "data must hold one track a body, got two of 'crate'."),
        ([Track("", np.zeros(1), np.full((1, 3), np.nan))], "more numbers than there are parameters (1), got 0."),
    ],
)
def test_what_does_not_fit_together(tracks: list[Track], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Problem(crate_scene(), tracks, parse_all([DYNAMIC], TABLE))
    assert sentence in str(caught.value)


def test_motion_between_steps_is_that_of_the_closed_form() -> None:
    times = [0.0, 0.013, 0.1, 0.201, 0.3]
    problem = Problem(crate_scene(), [track(times)], parse_all([DYNAMIC], TABLE))
    (motion,) = problem.simulate([0.3])
    expected = [1.5 * t - 0.5 * 0.3 * 9.81 * t * t for t in times]
    np.testing.assert_allclose(motion.positions[:, 0], expected, atol=1e-5)  # straight lines would be off by 1e-4


def test_residuals_skip_what_is_missing_and_count_in_sigmas() -> None:
    data = track([0.0, 0.1], turned=True)
    data.positions[1, 1:] = np.nan
    problem = Problem(crate_scene(), [data], parse_all([DYNAMIC], TABLE), sigma=0.01, sigma_angle=math.radians(2.0))
    f = problem.residuals([0.3])
    assert f.shape == (10,) == problem.moments.shape and problem.angular.sum() == 6
    np.testing.assert_allclose(f[:3], [0.0, 0.0, 10.0], atol=1e-3)
    np.testing.assert_allclose(f[3], (0.15 - 0.5 * 0.3 * 9.81 * 0.01) / 0.01, rtol=1e-4)


def test_the_turn_between_two_orientations_takes_the_short_way() -> None:
    half = math.radians(20.0)
    turned = np.array([[math.cos(half), 0.0, math.sin(half), 0.0]])
    same = np.array([[1.0, 0.0, 0.0, 0.0]])
    expected = [[0.0, 2.0 * half, 0.0]]
    np.testing.assert_allclose(rotation_between(same, turned), expected, rtol=1e-12)
    np.testing.assert_allclose(rotation_between(same, -turned), expected, rtol=1e-12)
    np.testing.assert_allclose(rotation_between(turned, turned), np.zeros((1, 3)), atol=1e-15)
