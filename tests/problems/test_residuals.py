"""Residuals are zero at solutions and nowhere else, and each says what it is named for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from stiction.errors import InvalidInputError
from stiction.problems import ContactProblem, natural_map, residuals
from stiction.problems.residuals import project_onto_cones
from stiction.problems.sweeps import Sweeps

from .support import random_problem

ONE = ContactProblem(np.diag([2.0, 1, 1]), [-1.0, 2, 0], 0.5)
SOLUTION = [0.5, -0.25, 0.0]
"""r_n = 1/2 stops the approach; friction takes 1/4 of the slip, 2, and the rest goes on."""


def test_the_solution_of_one_contact_has_no_residual() -> None:
    found = residuals(ONE, SOLUTION)
    assert (found.natural_map, found.cone, found.dual, found.gap) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("r", "wrong"),
    [
        ([0.0, 0, 0], {"natural_map", "dual"}),  # goes on approaching
        ([0.5, -0.5, 0], {"natural_map", "cone", "gap"}),  # friction above its limit
        ([0.5, 0.25, 0], {"natural_map", "gap"}),  # friction that pushes on
        ([1.0, -0.5, 0], {"natural_map", "gap"}),  # pushes while it opens
    ],
)
def test_each_law_that_is_broken_shows(r: list[float], wrong: set[str]) -> None:
    found = vars(residuals(ONE, r))
    assert {name for name, value in found.items() if value > 1e-12} == wrong


def test_the_natural_map_by_hand() -> None:
    """r = 0: u = q, raised to (-1 + 1, 2, 0); the nearest point of the cone to (0, -2, 0) is (4/5, -2/5, 0)."""
    assert natural_map(ONE, [0.0, 0, 0]) == pytest.approx(np.hypot(0.8, 0.4) / np.sqrt(5.0), abs=1e-15)
    assert natural_map(ONE, [0.0, 0, 0], rho=3.0) == pytest.approx(3.0 * np.hypot(0.8, 0.4) / np.sqrt(5.0))


def test_without_q_nothing_is_divided() -> None:
    problem = ContactProblem(np.eye(3), np.zeros(3), 0.5)
    assert natural_map(problem, [0.0, 0, 0]) == 0.0
    assert natural_map(problem, [1.0, 0, 0]) == pytest.approx(1.0)


def test_the_projection_is_the_nearest_point_of_the_cone(rng: np.random.Generator) -> None:
    for _ in range(30):
        mu, r = rng.uniform(0.0, 2.0), rng.normal(size=3)

        def distance(p: np.ndarray, r: np.ndarray = r, mu: float = mu) -> float:
            n, angle, share = abs(p[0]), p[1], np.sin(p[2]) ** 2
            return float(np.linalg.norm(r - [n, mu * n * share * np.cos(angle), mu * n * share * np.sin(angle)]))

        guess = [max(r[0], 0.1), np.arctan2(r[2], r[1]), 1.0]
        best = min(
            minimize(distance, guess, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}).fun,
            np.linalg.norm(r),
        )
        found = project_onto_cones(r[None], np.array([mu]))[0]
        assert np.hypot(found[1], found[2]) <= mu * found[0] + 1e-14
        assert np.linalg.norm(r - found) <= best + 1e-9


def test_kernel_and_numpy_agree(rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    r = rng.normal(size=(problem.contacts, 3))
    assert Sweeps(problem).error(r) == pytest.approx(natural_map(problem, r), rel=1e-12)
    inertia = Sweeps(problem).inertia
    assert Sweeps(problem).merit(r) == pytest.approx(natural_map(problem, r, rho=inertia) / inertia, rel=1e-12)


def test_impulses_of_another_size_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="r must hold 3 numbers"):
        natural_map(ONE, np.zeros(6))
    with pytest.raises(InvalidInputError, match="rho must be above 0"):
        natural_map(ONE, SOLUTION, rho=0.0)
