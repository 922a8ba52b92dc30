"""Solutions obey the laws at every contact; what does not converge says so; the same call gives the same bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.errors import InvalidInputError, IterationLimitWarning
from stiction.problems import ContactProblem, natural_map, solve
from stiction.problems.sweeps import LOCAL_SOLVERS, Sweeps

from .support import assert_solved, random_problem, wedged

EXACT = [name for name in LOCAL_SOLVERS if name != "clamp"]


def two_blocks(mass: float = 1.0) -> ContactProblem:
    """Two contacts of one body, with different masses in the plane: W has rank three of six."""
    K = np.diag([1.0, 1.0, 4.0]) / mass
    return ContactProblem(np.block([[K, K], [K, K]]), [-1.0, 1.0, 1.0] * 2, 0.2)


@pytest.mark.parametrize("shape", [(1, 1), (1, 6), (3, 5), (5, 12), (8, 30)])
def test_random_problems_are_solved(shape: tuple[int, int], rng: np.random.Generator) -> None:
    """With more contacts than the bodies have freedoms, too."""
    for _ in range(4):
        problem = random_problem(rng, *shape)
        solution = solve(problem, tolerance=1e-9)
        assert solution.converged and solution.error <= 1e-9
        assert_solved(problem, solution.r, 1e-7)
        assert solution.error == pytest.approx(natural_map(problem, solution.r), rel=1e-6, abs=1e-14)
        u = problem.W.dense() @ solution.r.ravel() + problem.q
        np.testing.assert_allclose(solution.u.ravel(), u, atol=1e-12 * np.abs(problem.q).max())


@pytest.mark.parametrize("how", [{"local": local} for local in EXACT] + [{"method": "newton"}], ids=str)
def test_every_way_but_the_clamp_solves_them(how: dict[str, Any], rng: np.random.Generator) -> None:
    for _ in range(3):
        problem = random_problem(rng, 4, 8)
        assert_solved(problem, solve(problem, tolerance=1e-9, **how).r, 1e-7)


@pytest.mark.parametrize(
    "how", [{"order": "symmetric"}, {"order": "random"}, {"omega": 1.2}, {"accelerate": False}], ids=str
)
def test_order_and_relaxation_change_the_way_not_the_solution(how: dict[str, Any], rng: np.random.Generator) -> None:
    problem = random_problem(rng, 5, 10)
    assert_solved(problem, solve(problem, tolerance=1e-9, **how).r, 1e-7)


def test_where_contacts_are_few_every_way_finds_the_same_impulses(rng: np.random.Generator) -> None:
    """One contact a body: W has full rank, little coupling, and one solution."""
    problem = ContactProblem(np.diag(rng.uniform(1, 2, size=9)), [-1.0, 1, 2, -2, 0.1, 0, 1, 1, 1], 0.3)
    first = solve(problem, tolerance=1e-12).r
    for local in EXACT:
        np.testing.assert_allclose(solve(problem, local=local, tolerance=1e-12).r, first, atol=1e-10)
    np.testing.assert_allclose(solve(problem, method="newton", tolerance=1e-12).r, first, atol=1e-10)


def test_the_clamp_has_friction_that_is_not_opposite_to_the_slip() -> None:
    """K_t = diag(1, 4): it points along K_t^-1 b, far off the slip, however many sweeps are made."""
    problem = two_blocks()
    with pytest.warns(IterationLimitWarning, match=r"error 0\.\d+ after 2000 sweeps is above the tolerance"):
        wrong = solve(problem, local="clamp", accelerate=False, finish=False, sweeps=2000)
    right = solve(problem, tolerance=1e-10)

    def off(r: np.ndarray, u: np.ndarray) -> float:
        along = -(r[:, 1:].sum(axis=0) @ u[0, 1:]) / np.linalg.norm(r[:, 1:].sum(axis=0)) / np.linalg.norm(u[0, 1:])
        return float(np.degrees(np.arccos(min(along, 1.0))))

    assert off(right.r, right.u) < 1e-3
    assert off(wrong.r, wrong.u) > 10.0
    assert wrong.error > 1e-2


def test_a_contact_that_friction_alone_can_hold_shut() -> None:
    """mu |K_nt| > K_nn, so several impulses solve it alone; the exact local solver must not jump between them."""
    K = np.array([[1.0, 3.0, 0], [3.0, 12.0, 0], [0, 0, 2.0]])
    problem = ContactProblem(K, [0.2, -1.0, 0.3], 0.5)
    for start in (None, [1.0, 0.3, 0.0]):
        solution = solve(problem, tolerance=1e-10, start=start)
        assert_solved(problem, solution.r, 1e-8)


def test_no_solution_is_told_and_the_best_is_given_back() -> None:
    with pytest.warns(
        IterationLimitWarning, match=r"wedged: error .* after 300 sweeps and \d+ Newton steps is above"
    ) as told:
        solution = solve(wedged(), sweeps=300)
    assert told[0].filename == __file__
    assert not solution.converged and np.isfinite(solution.r).all()
    assert solution.error == pytest.approx(min(solution.log[:, 1]), rel=1e-12)


def test_time_is_limited_too(rng: np.random.Generator) -> None:
    problem = random_problem(rng, 8, 30)
    with pytest.warns(IterationLimitWarning):
        solution = solve(problem, tolerance=1e-300, seconds=1e-9)
    assert solution.sweeps == 10


def test_singular_blocks_do_no_harm() -> None:
    """A bead on a wire: K has one direction, and one solution in it; and a contact of two bodies that cannot move."""
    along = np.array([0.6, 0.8, 0.0])
    W = np.zeros((6, 6))
    W[:3, :3] = np.outer(along, along)
    problem = ContactProblem(W, [*(-2.0 * along), 0.0, 0.3, 0.0], 0.9)
    solution = solve(problem, tolerance=1e-9)
    assert_solved(problem, solution.r, 1e-7)


def test_nothing_to_do_is_done_at_once() -> None:
    problem = ContactProblem(np.eye(3), [1.0, 5, 0], 0.5)
    solution = solve(problem)
    assert solution.converged and solution.sweeps == 0 and not solution.r.any()
    empty = solve(ContactProblem(np.zeros((0, 0)), [], []))
    assert empty.converged and empty.r.shape == (0, 3)


def test_a_start_at_the_solution_is_kept(rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    first = solve(problem, tolerance=1e-9)
    again = solve(problem, tolerance=1e-8, start=first.r)
    assert again.sweeps == 0
    np.testing.assert_allclose(again.r, first.r, atol=1e-12)


def test_the_log_tells_the_way(rng: np.random.Generator) -> None:
    problem = random_problem(rng, 6, 14)
    solution = solve(problem, accelerate=False, finish=False, tolerance=1e-12, sweeps=50, every=7, warn=False)
    assert solution.log[0].tolist() == [0.0, pytest.approx(natural_map(problem, np.zeros(3 * problem.contacts)))]
    ends = [float(k) for k in (0, 7, 14, 21, 28, 35, 42, 49, 50)]
    assert solution.log[:, 0].tolist() == ends[: len(solution.log)]


def test_the_same_call_gives_the_same_bits(rng: np.random.Generator) -> None:
    problem = random_problem(rng, 6, 20)
    for how in ({}, {"order": "random", "seed": 3}, {"method": "newton"}):
        first, second = (solve(problem, tolerance=1e-9, **how) for _ in range(2))  # type: ignore[arg-type]  # options by name
        assert first.r.tobytes() == second.r.tobytes() and first.log.tobytes() == second.log.tobytes()


def test_a_block_that_is_not_symmetric_is_solved_as_it_stands(rng: np.random.Generator) -> None:
    problem = random_problem(rng, 3, 3)
    W = problem.W.dense()
    W *= 1.0 + 1e-3 * rng.normal(size=W.shape)
    skewed = ContactProblem(W, problem.q, problem.mu)
    assert_solved(skewed, solve(skewed, tolerance=1e-9).r, 1e-7)


def test_proximal_sweeps_rest_at_solutions(rng: np.random.Generator) -> None:
    problem = random_problem(rng)
    r = solve(problem, tolerance=1e-11).r
    moved = r.copy()
    Sweeps(problem).advance(moved, 5, alpha=0.7, anchor=r)
    np.testing.assert_allclose(moved, r, atol=1e-8 * np.abs(r).max())


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"method": "magic"}, "method must be one of nsgs, newton"),
        ({"local": "secullar"}, "did you mean 'secular'"),
        ({"order": "up"}, "order must be one of"),
        ({"omega": 2.0}, "omega must be above 0 and below 2"),
        ({"tolerance": 0.0}, "tolerance must be above 0"),
        ({"sweeps": -1}, "sweeps must be a whole number"),
        ({"seconds": 0.0}, "seconds must be above 0 s"),
        ({"every": 0}, "every must be a whole number"),
        ({"start": [1.0]}, "r must hold 3 numbers"),
        ({"start": [np.nan, 0, 0]}, "start must be finite"),
    ],
)
def test_bad_arguments_are_refused(how: dict[str, Any], says: str) -> None:
    with pytest.raises(InvalidInputError, match=says):
        solve(ContactProblem(np.eye(3), [-1.0, 0, 0], 0.5), **how)


def test_a_matrix_that_is_not_positive_is_refused() -> None:
    with pytest.raises(InvalidInputError, match=r"W must be positive semidefinite, got W_nn = -1 at contact 1"):
        solve(ContactProblem(np.diag([1.0, 1, 1, -1, 1, 1]), -np.ones(6), 0.5))
