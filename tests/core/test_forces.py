"""The force laws of the lecture's first part, and its question: what happens when the force stops?"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from stiction.core.friction.forces import (
    dynamic_friction,
    mixed_friction,
    planar_force,
    reaction_force,
    static_friction,
)
from stiction.core.vec import Vec3

from .support import Array, compiled, random_unit, vec

UP = Vec3(0.0, 0.0, 1.0)
STILL = Vec3(0.0, 0.0, 0.0)
WEIGHT = 10.0

forces = some.builds(Vec3, *[some.floats(-100.0, 100.0)] * 3)
normals = some.integers(0, 2**32 - 1).map(lambda seed: vec(random_unit(np.random.default_rng(seed))))


def array(v: Vec3) -> Array:
    """A Vec3 as an array."""
    return np.array(v)


@given(forces, normals)
def test_reaction_and_planar_force(f: Vec3, n: Vec3) -> None:
    """r undoes the pressing component and never pulls; f_planar has no component along n."""
    pressed = float(array(f) @ array(n))
    r = array(reaction_force(f, n))
    np.testing.assert_allclose(r, array(n) * max(-pressed, 0.0), rtol=0, atol=1e-13)
    planar = array(planar_force(f, n))
    assert abs(planar @ array(n)) <= 1e-13
    if pressed < 0.0:
        np.testing.assert_allclose(planar, array(f) + r, rtol=0, atol=1e-13)


@given(forces, normals, some.floats(0.0, 2.0))
def test_static_friction_is_the_case_with_the_smaller_magnitude(f: Vec3, n: Vec3, mu: float) -> None:
    planar, limit = array(planar_force(f, n)), mu * np.linalg.norm(reaction_force(f, n))
    friction = array(static_friction(f, n, mu))
    size = np.linalg.norm(planar)
    assert np.linalg.norm(friction) == pytest.approx(min(size, limit), abs=1e-12)
    # against the planar force, never along it, never beyond it
    assert friction @ planar <= 1e-12
    assert np.linalg.norm(planar + friction) == pytest.approx(max(size - limit, 0.0), abs=1e-12)
    np.testing.assert_array_equal(compiled(static_friction)(f, n, mu), friction)


@given(forces, normals, forces, some.floats(0.0, 2.0))
def test_dynamic_friction_depends_on_the_direction_of_sliding_alone(f: Vec3, n: Vec3, v: Vec3, mu: float) -> None:
    v_planar = v - n * float(array(v) @ array(n))
    speed, limit = np.linalg.norm(v_planar), mu * np.linalg.norm(reaction_force(f, n))
    friction = array(dynamic_friction(f, n, v_planar, mu, False))
    if speed < 1e-6:
        return
    np.testing.assert_allclose(friction, -array(v_planar) / speed * limit, rtol=0, atol=1e-11)
    np.testing.assert_allclose(dynamic_friction(f, n, v_planar * 2.0, mu, False), friction, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(compiled(dynamic_friction)(f, n, v_planar, mu, False), friction)


def test_dynamic_friction_of_what_does_not_slide_is_zero() -> None:
    assert dynamic_friction(Vec3(0.0, 0.0, -WEIGHT), UP, STILL, 0.4, False) == STILL


def test_the_literal_form_is_viscous() -> None:
    """-v mu_d |r| word for word: twice the speed, twice the force; so it is no Coulomb friction."""
    f, v = Vec3(0.0, 0.0, -WEIGHT), Vec3(3.0, 4.0, 0.0)
    slow, fast = (array(dynamic_friction(f, UP, v * s, 0.4, True)) for s in (1.0, 2.0))
    np.testing.assert_allclose(slow, (-12.0, -16.0, 0.0), rtol=1e-15)
    np.testing.assert_allclose(fast, 2.0 * slow, rtol=1e-15)
    # only at 1 m/s do the two agree
    one = Vec3(0.6, 0.8, 0.0)
    np.testing.assert_allclose(dynamic_friction(f, UP, one, 0.4, True), dynamic_friction(f, UP, one, 0.4, False))


def test_mixed_friction_has_one_coefficient_for_both() -> None:
    f, v = Vec3(3.0, 0.0, -WEIGHT), Vec3(0.0, 2.0, 0.0)
    assert mixed_friction(f, UP, STILL, 0.5) == static_friction(f, UP, 0.5)
    assert mixed_friction(f, UP, v, 0.5) == dynamic_friction(f, UP, v, 0.5, False)
    assert compiled(mixed_friction)(f, UP, v, 0.5) == mixed_friction(f, UP, v, 0.5)


def test_nothing_that_is_lifted_rubs() -> None:
    lifted = Vec3(1.0, 2.0, 3.0)
    assert reaction_force(lifted, UP) == STILL
    assert array(static_friction(lifted, UP, 0.9)) == pytest.approx(0.0)
    assert array(dynamic_friction(lifted, UP, Vec3(1.0, 0.0, 0.0), 0.9, False)) == pytest.approx(0.0)


# --- "What happens ... if we stop exerting a force on static object and on moving object?" ----------------------------


def pushed(force: float, seconds: float, released: float, law: Any, dt: float = 1e-4) -> tuple[float, float, float]:
    """A 1 kg block, pushed and then left alone: speed at release, time to stop after it, final speed."""
    speed = stopping = at_release = 0.0
    for step in range(round((seconds + released) / dt)):
        push = force if step * dt < seconds else 0.0
        f = Vec3(push, 0.0, -WEIGHT)
        before = speed
        speed += dt * (push + law(f, Vec3(speed, 0.0, 0.0)).x)
        if before > 0.0 and speed <= 0.0:  # friction stops, it does not reverse
            speed = 0.0
        if push:
            at_release = speed
        elif speed > 0.0:
            stopping += dt
    return at_release, stopping, speed


def two_coefficients(f: Vec3, v: Vec3) -> Vec3:
    """mu_s = 0.5 while at rest, mu_d = 0.4 while sliding."""
    force: Vec3 = static_friction(f, UP, 0.5) if v == STILL else dynamic_friction(f, UP, v, 0.4, False)
    return force


def test_a_resting_object_that_is_pushed_too_little_stays_and_stays_after_the_push() -> None:
    """4.9 N against 0.5 * 10 N: friction equals the push, and is zero once the push has gone."""
    assert pushed(4.9, 1.0, 1.0, two_coefficients) == (0.0, 0.0, 0.0)
    assert static_friction(Vec3(0.0, 0.0, -WEIGHT), UP, 0.5) == STILL


def test_a_moving_object_slows_down_at_mu_d_g_and_stops() -> None:
    """6 N break it loose, 6 - 4 N accelerate it; after 1 s at 2 m/s it needs v / (mu_d g) = 0.5 s to stop."""
    speed, stopping, final = pushed(6.0, 1.0, 2.0, two_coefficients)
    assert speed == pytest.approx(2.0, rel=1e-3)
    assert stopping == pytest.approx(0.5, rel=1e-2)
    assert final == 0.0


def test_what_slides_goes_on_under_a_push_that_could_not_have_started_it() -> None:
    """4.5 N lie between mu_d and mu_s: at rest nothing happens, once sliding it gains speed."""
    assert pushed(4.5, 1.0, 0.0, two_coefficients)[0] == 0.0
    f, v = Vec3(4.5, 0.0, -WEIGHT), Vec3(0.1, 0.0, 0.0)
    assert 4.5 + two_coefficients(f, v).x == pytest.approx(0.5)


def test_the_mixed_law_cannot_tell_the_two_apart() -> None:
    """With one coefficient the same push holds in both cases."""
    f = Vec3(4.5, 0.0, -WEIGHT)
    assert 4.5 + mixed_friction(f, UP, STILL, 0.5).x == 0.0
    assert 4.5 + mixed_friction(f, UP, Vec3(0.1, 0.0, 0.0), 0.5).x == pytest.approx(-0.5)


def test_the_literal_law_never_stops_anything() -> None:
    """Its speed decays as exp(-mu_d |r| t / m): exp(-4) of it is left after 1 s, and something for ever."""
    _, _, final = pushed(6.0, 1.0, 1.0, lambda f, v: dynamic_friction(f, UP, v, 0.4, True))
    start = 6.0 / 4.0 * (1.0 - math.exp(-4.0))
    assert final == pytest.approx(start * math.exp(-4.0), rel=1e-2)
    assert final > 0.0
