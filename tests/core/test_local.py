"""The local solvers of one contact among many: which agree, which rest at solutions, and which does not.

In plain Python here; compiled, inside the sweep that calls them, they are tested with the problems that it solves.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from stiction.core.friction.local import ALTERNATE, CLAMP, NEWTON, PROJECTION, SECULAR, cone_projection, local_solution
from stiction.core.vec import Vec3

from .support import Array, mat, matrix_of, random_unit, vec

CASES = 1000


def cases(rng: np.random.Generator) -> list[tuple[Array, Array, float]]:
    """K (3, 3) of any axes, b, and mu for which one contact has one solution alone: mu |K_nt| < K_nn."""
    made = []
    for _ in range(CASES):
        R = matrix_of(random_unit(rng, 4))
        K = R @ np.diag(np.exp(rng.uniform(-1.0, 1.0, size=3))) @ R.T
        most = K[0, 0] / math.hypot(K[1, 0], K[2, 0])
        made.append((0.5 * (K + K.T), rng.normal(size=3), min(rng.uniform(0.0, 2.0), 0.8 * most)))
    return made


def law(K: Array, b: Array, mu: float, r: Array) -> float:
    """|r - P(r - (u + (mu |u_t|, 0, 0)))| over |b|, by numpy alone."""
    u = K @ r - b
    y = r - u - [mu * math.hypot(u[1], u[2]), 0.0, 0.0]
    t = math.hypot(y[1], y[2])
    if t <= mu * y[0]:
        p = y
    elif mu * t <= -y[0]:
        p = np.zeros(3)
    else:
        n = (y[0] + mu * t) / (1.0 + mu * mu)
        p = np.array([n, mu * n * y[1] / t, mu * n * y[2] / t])
    return float(np.linalg.norm(r - p) / np.linalg.norm(b))


@pytest.mark.parametrize("which", [SECULAR, NEWTON], ids=["secular", "newton"])
def test_the_exact_ones_solve_one_contact_at_once(which: int, rng: np.random.Generator) -> None:
    solve = local_solution
    for K, b, mu in cases(rng):
        r = np.array(solve(which, mat(K), vec(b), Vec3(0.0, 0.0, 0.0), mu))
        assert law(K, b, mu, r) < 1e-10


@pytest.mark.parametrize("which", [ALTERNATE, PROJECTION], ids=["alternate", "projection"])
def test_the_others_get_there_if_asked_again(which: int, rng: np.random.Generator) -> None:
    solve = local_solution
    for K, b, mu in cases(rng)[:30]:
        r = Vec3(0.0, 0.0, 0.0)
        for _ in range(1500):
            r = solve(which, mat(K), vec(b), r, mu)
        assert law(K, b, mu, np.array(r)) < 1e-6


def test_all_but_the_clamp_rest_at_the_solution(rng: np.random.Generator) -> None:
    solve = local_solution
    moved = 0.0
    for K, b, mu in cases(rng):
        right = solve(SECULAR, mat(K), vec(b), Vec3(0.0, 0.0, 0.0), mu)
        for which in (ALTERNATE, NEWTON, PROJECTION):
            again = solve(which, mat(K), vec(b), right, mu)
            assert np.linalg.norm(np.subtract(again, right)) < 1e-9 * np.linalg.norm(b)
        moved = max(moved, float(np.linalg.norm(np.subtract(solve(CLAMP, mat(K), vec(b), right, mu), right))))
    assert moved > 0.1


def test_the_clamp_points_along_the_velocity_divided_by_mass() -> None:
    """K_t = diag(1, 4), slip along (1, 1): friction along (1, 1/4), 31 degrees off."""
    K, b = np.diag([1.0, 1.0, 4.0]), np.array([1.0, 1.0, 1.0])
    wrong = local_solution(CLAMP, mat(K), vec(b), Vec3(0.0, 0.0, 0.0), 0.01)
    assert math.degrees(math.atan2(wrong.z, wrong.y)) == pytest.approx(math.degrees(math.atan(0.25)), abs=1e-9)
    right = local_solution(SECULAR, mat(K), vec(b), Vec3(0.0, 0.0, 0.0), 0.01)
    u = K @ np.array(right) - b
    assert math.degrees(math.atan2(right.z, right.y)) == pytest.approx(math.degrees(math.atan2(-u[2], -u[1])), abs=1e-6)


def test_an_exact_solver_does_not_jump_where_a_contact_has_several_solutions() -> None:
    """mu |K_nt| > K_nn: open (r = 0) and stuck both obey the laws; from near the stuck one it goes there."""
    K = np.array([[1.0, 3.0, 0.0], [3.0, 12.0, 0.0], [0.0, 0.0, 2.0]])
    b, mu = np.array([-0.1, -1.0, 0.0]), 0.5
    stuck = np.linalg.solve(K, b)
    assert math.hypot(*stuck[1:]) <= mu * stuck[0] and law(K, b, mu, stuck) < 1e-12  # both are solutions
    assert law(K, b, mu, np.zeros(3)) < 1e-12
    solve = local_solution
    near = solve(SECULAR, mat(K), vec(b), vec(stuck), mu)
    np.testing.assert_allclose(near, stuck, atol=1e-12)
    assert solve(SECULAR, mat(K), vec(b), Vec3(0.0, 0.0, 0.0), mu) == (0.0, 0.0, 0.0)


def test_the_projection_onto_the_cone() -> None:
    project = cone_projection
    assert project(1.0, 0.3, 0.4, 0.5) == (1.0, 0.3, 0.4)
    assert project(-1.0, 0.3, 0.4, 0.5) == (0.0, 0.0, 0.0)
    n, y, z = project(0.0, 3.0, 4.0, 0.5)
    assert (n, math.hypot(y, z)) == pytest.approx((2.0, 1.0)) and y / z == pytest.approx(0.75)
    assert project(2.0, 1.0, 0.0, 0.0) == (2.0, 0.0, 0.0)
    assert project(0.0, 0.0, 0.0, 0.0) == (0.0, 0.0, 0.0)
