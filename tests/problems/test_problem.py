"""The value: what it accepts, what it refuses, and its matrix of blocks."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from stiction.errors import InvalidInputError
from stiction.problems import BlockMatrix, ContactProblem

from .support import random_problem


def test_dense_sparse_and_blocks_make_the_same_problem(rng: np.random.Generator) -> None:
    W = np.where(rng.random((12, 12)) < 0.4, rng.normal(size=(12, 12)), 0.0)
    for given in (W, W.tolist(), csr_array(W), csc_array(W), BlockMatrix.of(W)):
        problem = ContactProblem(given, np.ones(12), 0.5)
        np.testing.assert_array_equal(problem.W.dense(), W)
        np.testing.assert_array_equal(problem.W.sparse().toarray(), W)
        assert problem.contacts == 4 and problem.mu.tolist() == [0.5] * 4


def test_the_blocks_lie_in_order_and_multiply_as_the_matrix_does(rng: np.random.Generator) -> None:
    W = random_problem(rng).W
    for row in range(W.rows):
        assert (np.diff(W.indices[W.pointers[row] : W.pointers[row + 1]]) > 0).all()
    r = rng.normal(size=(W.rows, 3))
    np.testing.assert_allclose(W.times(r).ravel(), W.dense() @ r.ravel(), atol=1e-12)
    dense = W.dense().reshape(W.rows, 3, W.rows, 3)
    np.testing.assert_array_equal(W.diagonal(), dense[np.arange(W.rows), :, np.arange(W.rows), :])


def test_a_matrix_without_a_diagonal_block_gets_one() -> None:
    W = ContactProblem(np.zeros((6, 6)), np.zeros(6), 0.1).W
    assert W.indices.tolist() == [0, 1] and not W.data.any()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"W": np.eye(4)}, r"W must be \(3n, 3n\), got shape \(4, 4\)"),
        ({"W": np.ones((3, 6))}, r"W must be \(3n, 3n\)"),
        ({"W": np.ones(3)}, "W must be a matrix"),
        ({"W": np.diag([1.0, np.nan, 1])}, "W must be finite, got nan"),
        ({"q": [1.0, 2]}, "q must hold 3 numbers, got 2"),
        ({"q": [1.0, 2, np.inf]}, "q must be finite, got inf at index 2"),
        ({"mu": [0.1, 0.2]}, "mu must hold 1 numbers, got 2"),
        ({"mu": -0.1}, "mu must be 0 or more, got -0.1 at contact 0"),
        ({"mu": np.nan}, "mu must be finite"),
    ],
)
def test_what_is_not_a_problem_is_refused(change: dict[str, Any], says: str) -> None:
    given: dict[str, Any] = {"W": np.eye(3), "q": [-1.0, 0, 0], "mu": 0.5} | change
    with pytest.raises(InvalidInputError, match=says):
        ContactProblem(**given)


def test_a_global_form_that_does_not_fit_is_refused() -> None:
    good: dict[str, Any] = {"M": np.eye(6), "H": np.ones((6, 3)), "f": np.zeros(6), "w": np.zeros(3), "mu": 0.5}
    ContactProblem.from_global(**good)
    for change, says in (
        ({"M": np.eye(5)}, r"M must be \(d, d\) and H \(d, 3n\), got \(5, 5\) and \(6, 3\)"),
        ({"M": np.zeros((6, 6))}, "M must not be singular"),
        ({"M": np.diag([1.0, 1, 1, 1, 1, np.inf])}, "M and H must be finite"),
        ({"f": np.zeros(5)}, "f must hold 6 numbers, got 5"),
        ({"w": np.zeros(4)}, "w must hold 3 numbers, got 4"),
    ):
        with pytest.raises(InvalidInputError, match=says):
            ContactProblem.from_global(**(good | change))


def test_a_problem_says_what_it_is() -> None:
    assert repr(ContactProblem(np.eye(3), np.zeros(3), 0.5, title="crate")) == (
        "<ContactProblem: 'crate', 1 contacts, 1 blocks>"
    )


def test_importing_problems_leaves_the_compiler_and_heavy_packages_alone() -> None:
    code = "import sys, stiction.problems; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    loaded = set(
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    )
    assert loaded & {"numba", "scipy", "h5py"} == set()
