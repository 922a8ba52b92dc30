"""Coulomb's law of one contact holds for any matrix and coefficient; what the other laws get wrong, in degrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from stiction.core.friction.coulomb import clipped_impulse, coulomb_impulse, literal_change, secular_friction
from stiction.core.friction.rolling import resisting_torque
from stiction.core.vec import Mat33, Vec3

from .support import Array, compiled, mat, matrix_of, random_inverse_inertia, random_unit, vec

CASES = 5000


def random_matrices(rng: np.random.Generator, n: int, spread: float) -> Array:
    """(n, 3, 3) symmetric positive definite: eigenvalues e^-spread to e^spread, any axes."""
    result = np.empty((n, 3, 3))
    for k in range(n):
        R = matrix_of(random_unit(rng, 4))
        result[k] = R @ np.diag(np.exp(rng.uniform(-spread, spread, size=3))) @ R.T
        result[k] = 0.5 * (result[k] + result[k].T)
    return result


def solve_all(K: Array, b: Array, mu_stick: Array, mu_slide: Array) -> tuple[Array, Any]:
    """The compiled law on n contacts: impulses (n, 3) and whether each sticks (n,)."""
    g, sticks = np.empty_like(b), np.empty(len(b), np.bool_)
    compiled(_coulomb_loop)(K, b, mu_stick, mu_slide, g, sticks)
    return g, sticks


def _coulomb_loop(K: Any, b: Any, mu_stick: Any, mu_slide: Any, g: Any, sticks: Any) -> None:
    for i in range(len(b)):
        k = K[i]
        matrix = Mat33(k[0, 0], k[0, 1], k[0, 2], k[1, 0], k[1, 1], k[1, 2], k[2, 0], k[2, 1], k[2, 2])
        impulse, hold = coulomb_impulse(matrix, Vec3(b[i, 0], b[i, 1], b[i, 2]), mu_stick[i], mu_slide[i])
        g[i, 0], g[i, 1], g[i, 2] = impulse.x, impulse.y, impulse.z
        sticks[i] = hold


def remaining(K: Array, b: Array, g: Array) -> Array:
    """Velocity (n, 3) that is left after the impulses."""
    return np.asarray(b - np.einsum("nij,nj->ni", K, g))


# --- the right law ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spread", [0.0, 1.0, 3.5], ids=["isotropic", "like a box", "thousandfold"])
@pytest.mark.parametrize("largest_mu", [0.1, 1.0, 20.0])
def test_signorini_and_coulomb_hold_together(rng: np.random.Generator, spread: float, largest_mu: float) -> None:
    """No contact closes any more; inside the cone nothing slips; on it friction is exactly along the slip."""
    K = random_matrices(rng, CASES, spread)
    b = rng.normal(size=(CASES, 3))
    b[:, 0] = np.abs(b[:, 0])
    mu = rng.uniform(0.0, largest_mu, size=CASES)
    g, sticks = solve_all(K, b, mu, mu)
    u = remaining(K, b, g)
    size = np.linalg.norm(b, axis=1)
    # rounding grows with the spread of the eigenvalues
    tolerance = 1e-13 * math.exp(2 * spread) * size

    assert (g[:, 0] > 0).all()
    assert (np.abs(u[:, 0]) <= tolerance).all()
    tangential = np.linalg.norm(g[:, 1:], axis=1)
    assert (tangential[sticks] <= mu[sticks] * g[sticks, 0] * (1 + 1e-12)).all()
    assert (np.linalg.norm(u[sticks, 1:], axis=1) <= tolerance[sticks]).all()

    slides = ~sticks
    np.testing.assert_allclose(tangential[slides], (mu * g[:, 0])[slides], rtol=1e-11)
    slip = u[slides, 1:]
    direction = g[slides, 1:] / tangential[slides, None]
    across = np.abs(slip[:, 0] * direction[:, 1] - slip[:, 1] * direction[:, 0])
    along = np.einsum("ni,ni->n", slip, direction)
    assert (across <= tolerance[slides]).all()
    assert (along >= -tolerance[slides]).all()
    # both regimes were there
    assert slides.sum() > 50
    assert sticks.sum() > 50 or largest_mu < 0.5


def test_the_law_takes_energy_and_never_gives(rng: np.random.Generator) -> None:
    """g . (u0 + u1) / 2 is what an impulse takes: more than nothing in every case."""
    K = random_matrices(rng, CASES, 2.0)
    b = rng.normal(size=(CASES, 3))
    mu = rng.uniform(0.0, 3.0, size=CASES)
    g, _ = solve_all(K, b, mu, mu)
    taken = 0.5 * np.einsum("ni,ni->n", g, b + remaining(K, b, g))
    assert taken.min() >= -1e-13


def test_an_opening_contact_gets_nothing(rng: np.random.Generator) -> None:
    b = rng.normal(size=(100, 3))
    b[:, 0] = -np.abs(b[:, 0])
    b[0] = (0.0, 1.0, 1.0)
    g, sticks = solve_all(random_matrices(rng, 100, 1.0), b, np.ones(100), np.ones(100))
    assert not g.any()
    assert not sticks.any()


def test_static_decides_whether_and_dynamic_how_much(rng: np.random.Generator) -> None:
    K = random_matrices(rng, CASES, 1.0)
    b = rng.normal(size=(CASES, 3))
    b[:, 0] = np.abs(b[:, 0])
    mu_stick = rng.uniform(0.2, 1.0, size=CASES)
    mu_slide = mu_stick * rng.uniform(0.1, 0.9, size=CASES)
    g, sticks = solve_all(K, b, mu_stick, mu_slide)
    _, wanted = solve_all(K, b, mu_stick, mu_stick)
    np.testing.assert_array_equal(sticks, wanted)
    tangential = np.linalg.norm(g[:, 1:], axis=1)
    np.testing.assert_allclose(tangential[~sticks], (mu_slide * g[:, 0])[~sticks], rtol=1e-11)
    held = np.einsum("nij,nj->ni", K, g)
    np.testing.assert_allclose(held[sticks], b[sticks], rtol=0, atol=1e-12)


def test_without_friction_only_the_normal_speed_goes(rng: np.random.Generator) -> None:
    K = random_matrices(rng, 100, 1.0)
    b = np.abs(rng.normal(size=(100, 3)))
    g, _ = solve_all(K, b, np.zeros(100), np.zeros(100))
    assert not g[:, 1:].any()
    np.testing.assert_allclose(g[:, 0], b[:, 0] / K[:, 0, 0], rtol=1e-15)


def test_plain_python_agrees_bit_for_bit(rng: np.random.Generator) -> None:
    K = random_matrices(rng, 200, 2.0)
    b = rng.normal(size=(200, 3))
    mu = rng.uniform(0.0, 2.0, size=200)
    g, sticks = solve_all(K, b, mu, 0.8 * mu)
    for i in range(200):
        plain, holds = coulomb_impulse(mat(K[i]), vec(b[i]), float(mu[i]), float(0.8 * mu[i]))
        assert np.array(plain).tobytes() == g[i].tobytes()
        assert holds == sticks[i]


def test_friction_does_not_depend_on_the_planar_axes(rng: np.random.Generator) -> None:
    """A round cone: turn the basis about the normal and the impulse turns with it."""
    K, b = random_matrices(rng, 200, 1.5), np.abs(rng.normal(size=(200, 3)))
    mu = rng.uniform(0.05, 1.0, size=200)
    g, sticks = solve_all(K, b, mu, mu)
    angle = rng.uniform(0.0, 2 * math.pi)
    Q = np.array([[1, 0, 0], [0, math.cos(angle), -math.sin(angle)], [0, math.sin(angle), math.cos(angle)]])
    turned, holds = solve_all(np.ascontiguousarray(Q @ K @ Q.T), b @ Q.T, mu, mu)
    np.testing.assert_array_equal(holds, sticks)
    np.testing.assert_allclose(turned, g @ Q.T, rtol=0, atol=1e-10)


def sliding_solutions(K: Array, b: Array, mu: float) -> list[Array]:
    """Every impulse on the cone whose slip lies along it, found by walking round the cone and nothing cleverer."""

    def impulse(angle: float) -> Array:
        e = np.array([1.0, mu * math.cos(angle), mu * math.sin(angle)])
        return np.asarray(e * (b[0] / (K[0] @ e)))

    def across(angle: float) -> float:
        u = b - K @ impulse(angle)
        return float(u[1] * math.sin(angle) - u[2] * math.cos(angle))

    found = []
    grid = np.linspace(0.0, 2 * math.pi, 2001)
    values = [across(a) for a in grid]
    for i in range(len(grid) - 1):
        if values[i] * values[i + 1] <= 0.0:
            g = impulse(brentq(across, grid[i], grid[i + 1], xtol=1e-14))
            slip = (b - K @ g)[1:]
            if g[0] > 0.0 and slip @ g[1:] >= 0.0:
                found.append(g)
    return found


def test_against_a_walk_round_the_cone(rng: np.random.Generator) -> None:
    checked = 0
    while checked < 25:
        K = random_matrices(rng, 1, 1.5)[0]
        b = np.abs(rng.normal(size=3))
        mu = float(rng.uniform(0.05, 1.0))
        if (K[0, 0] - mu * math.hypot(K[0, 1], K[0, 2])) <= 0.0:
            continue  # the walk divides by that
        g, sticks = coulomb_impulse(mat(K), vec(b), mu, mu)
        if sticks:
            continue
        solutions = sliding_solutions(K, b, mu)
        assert min(np.abs(np.array(g) - s).max() for s in solutions) < 1e-9
        checked += 1


# --- friction under a known load --------------------------------------------------------------------------------------


def test_secular_friction_is_the_minimum_over_the_disk(rng: np.random.Generator) -> None:
    """No impulse of at most that size takes more energy: 1/2 g K g - b g over |g| <= limit, by brute force."""
    angles = np.linspace(0.0, 2 * math.pi, 20001)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    slid = 0
    for _ in range(200):
        K = random_matrices(rng, 1, 2.0)[0][1:, 1:]
        b, limit = rng.normal(size=2), float(rng.uniform(0.01, 2.0))
        k11, k12, k22, b1, b2 = (float(x) for x in (K[0, 0], K[0, 1], K[1, 1], *b))
        g1, g2, sticks = secular_friction(k11, k12, k22, b1, b2, limit)
        g = np.array([g1, g2])
        cost = 0.5 * g @ K @ g - b @ g
        on_circle = circle * limit
        best = (0.5 * np.einsum("ni,ij,nj->n", on_circle, K, on_circle) - on_circle @ b).min()
        assert cost <= best + 1e-12
        if sticks:
            np.testing.assert_allclose(K @ g, b, atol=1e-12)
            assert np.hypot(*g) <= limit * (1 + 1e-15)
        else:
            slid += 1
            assert np.hypot(*g) == pytest.approx(limit, rel=1e-12)
            slip = b - K @ g
            assert slip @ g >= 0.0
            assert abs(slip[0] * g[1] - slip[1] * g[0]) <= 1e-12 * limit
            assert cost == pytest.approx(best, abs=1e-6)
    assert slid > 30


def test_secular_friction_without_a_limit_to_give() -> None:
    assert secular_friction(1.0, 0.0, 1.0, 3.0, 4.0, 0.0) == (0.0, 0.0, False)
    assert secular_friction(1.0, 0.0, 1.0, 0.0, 0.0, 0.0) == (0.0, 0.0, True)
    assert secular_friction(2.0, 0.0, 2.0, 3.0, 4.0, 2.5) == (1.5, 2.0, True)


def test_rolling_torque_has_its_own_cone_and_spinning_its_own_limit(rng: np.random.Generator) -> None:
    """Within the limits all relative rotation stops; at them the torque lies along the rolling that is left."""
    B = mat(matrix_of(random_unit(rng, 4)))
    stopped = limited = 0
    for _ in range(200):
        A = random_inverse_inertia(rng)
        spin = rng.normal(size=3)
        rolling, torsional, gn = (float(x) for x in rng.uniform(0.0, (4.0, 4.0, 1.5)))
        m = np.array(resisting_torque(mat(A), B, vec(spin), Vec3(0.0, 0.0, 0.0), rolling, torsional, gn))
        assert abs(m[0]) <= torsional * gn * (1 + 1e-15)
        assert np.hypot(*m[1:]) <= rolling * gn * (1 + 1e-12)
        axes = np.array(B).reshape(3, 3)
        local = axes.T @ A @ axes
        # both parts are found as if the other were not there
        left = (axes.T @ spin)[1:] - local[1:, 1:] @ m[1:]
        if np.hypot(*m[1:]) < rolling * gn * (1 - 1e-9):
            stopped += 1
            np.testing.assert_allclose(left, 0.0, atol=1e-11)
        else:
            limited += 1
            assert left @ m[1:] >= -1e-12
            assert abs(left[0] * m[2] - left[1] * m[1]) <= 1e-11
        wanted = (axes.T @ spin)[0] / local[0, 0]
        assert m[0] == pytest.approx(np.clip(wanted, -torsional * gn, torsional * gn), rel=1e-9)
    assert stopped > 5
    assert limited > 5


def test_a_torque_is_replaced_and_not_added_to(rng: np.random.Generator) -> None:
    """The same answer whatever part of it was applied before."""
    B = matrix_of(random_unit(rng, 4))
    for _ in range(100):
        A, spin = random_inverse_inertia(rng), rng.normal(size=3)
        limits = [float(x) for x in rng.uniform(0.1, 1.5, size=3)]
        fresh = np.array(resisting_torque(mat(A), mat(B), vec(spin), Vec3(0.0, 0.0, 0.0), *limits))
        # rolling alone: the part about the normal changes the rolling of a body that is not round
        held = np.array([0.0, *rng.normal(size=2)])
        again = resisting_torque(mat(A), mat(B), vec(spin - A @ B @ held), vec(held), *limits)
        np.testing.assert_allclose(again[1:], fresh[1:], rtol=0, atol=1e-10)


# --- the others -------------------------------------------------------------------------------------------------------


def angle_between(a: Array, b: Array) -> float:
    """Degrees."""
    return math.degrees(math.acos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1.0, 1.0)))


@pytest.mark.parametrize("ratio", [1.0, 2.0, 4.0])
def test_the_clipped_impulse_misses_the_slip_by_its_known_angle(ratio: float) -> None:
    """Scaling K^-1 b back points up to atan((k - 1) / (2 sqrt k)) off the slip, k the ratio of K_t's eigenvalues."""
    K = mat(np.diag([1.0, 1.0, ratio]))
    clipped_worst = right_worst = 0.0
    for angle in np.linspace(0.0, 2 * math.pi, 721):
        b = Vec3(1e-3, math.cos(angle), math.sin(angle))  # a light touch, so that the slip hardly changes
        for law, right in ((clipped_impulse(K, b, 0.5), False), (coulomb_impulse(K, b, 0.5, 0.5), True)):
            g, sticks = law
            assert not sticks
            assert math.hypot(g.y, g.z) == pytest.approx(0.5 * g.x, rel=1e-11)
            slip = np.array([b.y - g.y, b.z - ratio * g.z])
            error = angle_between(slip, np.array(g[1:]))
            if right:
                right_worst = max(right_worst, error)
            else:
                clipped_worst = max(clipped_worst, error)
    assert right_worst < 1e-5
    wanted = math.degrees(math.atan((ratio - 1.0) / (2.0 * math.sqrt(ratio))))
    assert clipped_worst == pytest.approx(wanted, abs=0.05)


def test_the_clipped_impulse_stops_the_normal_speed_and_stays_on_the_cone(rng: np.random.Generator) -> None:
    for K, b in zip(random_matrices(rng, 300, 1.0), rng.normal(size=(300, 3)), strict=True):
        g, sticks = clipped_impulse(mat(K), vec(b), 0.4)
        if b[0] <= 0.0:
            assert (g, sticks) == (Vec3(0.0, 0.0, 0.0), False)
            continue
        u = b - K @ np.array(g)
        assert abs(u[0]) < 1e-11
        assert math.hypot(g.y, g.z) <= 0.4 * g.x * (1 + 1e-12)
        if sticks:
            np.testing.assert_allclose(u, 0.0, atol=1e-11)


@pytest.mark.parametrize(
    ("v", "restitution", "change", "sticks"),
    [
        # |v_planar| = 0.5 <= v_C mu_s = 0.6: all of the planar velocity is removed
        ((1.0, 0.3, 0.4), 0.0, (1.0, 0.3, 0.4), True),
        ((1.0, 0.3, 0.4), 0.5, (1.5, 0.3, 0.4), True),
        # 5 > 0.6: scaled with mu_d, whatever the load: ten times the speed, ten times the "friction"
        ((1.0, 3.0, 4.0), 0.0, (1.0, 1.2, 1.6), False),
        ((1.0, 30.0, 40.0), 0.0, (1.0, 12.0, 16.0), False),
        ((1.0, 0.6, 0.0), 0.0, (1.0, 0.6, 0.0), True),
    ],
)
def test_the_slides_word_for_word(
    v: tuple[float, ...], restitution: float, change: tuple[float, ...], sticks: bool
) -> None:
    """Slide "Friction as impulses" with mu_s = 0.6, mu_d = 0.4."""
    found, holds = literal_change(Vec3(*v), restitution, 0.6, 0.4)
    assert tuple(found) == pytest.approx(change, abs=1e-15)
    assert holds is sticks
