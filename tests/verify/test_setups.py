"""The pieces that cases share: a wrong one would make every case that uses it wrong in the same way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stiction.verify import setups
from stiction.verify.cases_limits import SlideAndSpinOfAFace, mean_arm
from stiction.verify.cases_motion import complete_elliptic
from stiction.verify.cases_slopes import largest_that_holds


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.5, 0.999])
def test_arrival_finds_the_moment_within_a_step(fraction: float) -> None:
    dt, moment = 0.1, 0.1 * (7 + fraction)
    values = [max(3.0 * (1.0 - k * dt / moment), 0.0) for k in range(15)]
    assert setups.arrival(values, dt) == pytest.approx(moment, rel=1e-12)


def test_arrival_of_what_never_comes_is_nan() -> None:
    assert math.isnan(setups.arrival([1.0] * 20, 0.1))


@pytest.mark.parametrize(("angle", "azimuth"), [(0.3, 0.0), (0.7, 2.0), (1.2, -2.5)])
def test_a_slope_is_a_right_handed_frame(angle: float, azimuth: float) -> None:
    slope = setups.Slope(angle, azimuth)
    frame = np.stack([slope.down, slope.across, slope.normal], axis=1)
    assert np.allclose(frame.T @ frame, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert slope.down[2] == pytest.approx(-math.sin(angle))
    assert slope.across[2] == 0.0
    assert np.allclose(setups.matrix(slope.orientation()), frame, atol=1e-14)
    turned = setups.matrix(slope.orientation(yaw=0.4))
    assert turned[:, 0] @ slope.down == pytest.approx(math.cos(0.4))
    assert turned[:, 0] @ slope.across == pytest.approx(math.sin(0.4))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.5, 3.0])
def test_the_angle_between_two_orientations(angle: float) -> None:
    start = setups.about((1, 2, 3), 0.8)
    assert setups.turned_by(start, setups.product(setups.about((0, 1, 1), angle), start)) == pytest.approx(
        angle, abs=1e-15
    )


def test_rotations_add_up() -> None:
    q = setups.product(setups.about((0, 0, 1), 0.5 * math.pi), setups.about((1, 0, 0), 0.5 * math.pi))
    assert np.allclose(setups.matrix(q) @ (0, 1, 0), (0, 0, 1), atol=1e-15)
    assert np.allclose(setups.matrix(q) @ (0, 0, 1), (1, 0, 0), atol=1e-15)


def test_errors_add_up_like_a_random_walk() -> None:
    eps = setups.solver_tolerance("micro")
    assert setups.speed_error("micro", 1.0, 0.01) == pytest.approx(10.0 * eps)
    assert setups.distance_error("micro", 2.0, 0.02) == pytest.approx(20.0 * eps)


@pytest.mark.parametrize(("static", "dynamic"), [(0.5, 0.3), (0.4, 0.4), (0.9, 0.2)])
def test_the_last_step_of_a_slide_is_off_by_no_more_than_said(static: float, dynamic: float) -> None:
    dt, g = 0.02, setups.G
    worst = 0.0
    for v in np.linspace(0.0, static * g * dt, 201):
        worst = max(worst, abs(0.5 * v * dt - v * v / (2.0 * dynamic * g)))
    assert worst == pytest.approx(setups.stop_error("micro", static, dynamic, dt), rel=1e-3)


@pytest.mark.parametrize("k2", [0.0, 0.3, 0.99])
def test_the_elliptic_integral(k2: float) -> None:
    # the integrand is periodic and smooth, so the mid-point rule converges faster than any power
    phi = (np.arange(4000) + 0.5) / 4000 * math.pi / 2
    quadrature = float(np.mean(1.0 / np.sqrt(1.0 - k2 * np.sin(phi) ** 2))) * math.pi / 2
    assert complete_elliptic(k2) == pytest.approx(quadrature, rel=1e-12)


def test_the_moments_of_a_box() -> None:
    """Against the integral, by a fine grid of points."""
    size = (0.8, 0.5, 0.3)
    axes = [(np.arange(200) + 0.5) / 200 * s - s / 2 for s in size]
    xx, yy, zz = (float(np.mean(a * a)) for a in axes)
    assert setups.box_inertia(2.0, size) == pytest.approx(2.0 * np.array([yy + zz, zz + xx, xx + yy]), rel=1e-4)


@pytest.mark.parametrize("threshold", [20.03, 20.05, 20.09])
def test_the_search_brackets_a_threshold(threshold: float) -> None:
    assert largest_that_holds(lambda degrees: degrees > threshold, threshold) == pytest.approx((20.0, 20.1))


def test_the_search_finds_a_threshold_that_is_elsewhere() -> None:
    assert largest_that_holds(lambda degrees: degrees > 20.27, 20.03) == pytest.approx((20.2, 20.3))


def test_the_search_says_when_nothing_holds_or_everything_does() -> None:
    holds, gives = largest_that_holds(lambda degrees: True, 20.03)
    assert math.isnan(holds)
    assert gives == pytest.approx(19.5)
    holds, gives = largest_that_holds(lambda degrees: False, 20.03)
    assert holds == pytest.approx(20.6)
    assert math.isnan(gives)


def test_what_soft_alone_is_allowed_is_nothing_for_micro() -> None:
    dt = 1 / 60
    for allowed in (
        setups.rounding("micro", 5.0, 1.0, dt),
        setups.delay("micro", dt),
        setups.begin_error("micro", 3.0, dt),
        setups.lean("micro", dt, 1.0, 1.0),
        setups.soft_bounce("micro"),
    ):
        assert allowed == 0.0


@pytest.mark.parametrize("speed", [1.1, 1.9, 5.0])
def test_single_precision_rounds_a_steady_motion_by_no_more_than_said(speed: float) -> None:
    """A velocity that loses the same amount in each substep, kept in single precision."""
    h, n = 1 / 480, 400
    loss = 0.1 * setups.G * h
    v = np.float32(speed)
    for _ in range(n):
        v = np.float32(v - np.float32(loss))
    off = abs(float(v) - (speed - n * loss))
    assert 0.0 < off <= setups.rounding("soft", speed, n * h, 8 * h)


def test_how_deep_a_box_sinks() -> None:
    assert setups.box_compliance((1.0, 1.0, 1e-9)) == pytest.approx(7.0 / 4.0)
    assert setups.box_compliance((1.0, 1.0, 1.0)) == pytest.approx(1.0)
    assert setups.sink("soft", 1 / 60) == pytest.approx(1e-6 + setups.G / 624.0**2)
    assert setups.sink("micro", 1 / 60) == 1e-6


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (2.0, 0.4)])
def test_the_mean_arm_of_a_rectangle(a: float, b: float) -> None:
    """Against the integral, by a fine grid of points."""
    x, y = np.meshgrid(*(((np.arange(500) + 0.5) / 500 - 0.5) * side for side in (a, b)))
    assert mean_arm(a, b) == pytest.approx(float(np.mean(np.hypot(x, y))), rel=1e-5)


@pytest.mark.parametrize(
    ("shape", "spin", "distance"),
    [
        ("square", 10.0, 2.9072),
        ("square", 20.0, 5.2400),
        ("disc", 5.0, 1.8148),
        ("disc", 10.0, 2.6301),
        ("disc", 20.0, 4.6185),
    ],
)
def test_the_reference_of_slide_and_spin_agrees_with_another(shape: str, spin: float, distance: float) -> None:
    """Those distances come from the pressure integral in closed form, edge by edge."""
    case = SlideAndSpinOfAFace()
    points, inertia = (case._rectangle(1.0, 1.0), 1.0 / 6.0) if shape == "square" else (case._disc(0.5), 0.125)
    assert case._reference(points, spin, inertia) == pytest.approx(distance, rel=3e-4)
