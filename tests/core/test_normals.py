"""The normals of a manifold: a complementarity problem of four points, against all its active sets."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from stiction.core.lanes import LANES, load, store
from stiction.core.solve.normals import Four, Sym4, inverse_of_points, lowest, non_negative, point_matrix, times4

from .support import Array, compiled

UPPER = np.triu_indices(4)


def packed(A: Array) -> Sym4:
    """The upper triangle of a symmetric matrix."""
    return Sym4(*(float(a) for a in A[UPPER]))


def full(A: Any) -> Array:
    """A Sym4 as a matrix (4, 4)."""
    result = np.zeros((4, 4))
    result[UPPER] = A
    return np.asarray(result + result.T - np.diag(np.diag(result)))


class Patch:
    """A random manifold of 1 to 4 points on one or two bodies: its normals' matrix, with compliance on the diagonal."""

    def __init__(self, rng: np.random.Generator, points: int = 4, compliance: float = 0.04) -> None:
        size = np.exp(rng.uniform(-1, 1, size=2))
        corners = 0.5 * size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        self.places = corners[rng.permutation(4)] + rng.normal(size=(4, 2)) * 0.05 * size
        self.places[points:] = 0.0
        self.here = (np.arange(4) < points).astype(float)
        # response of (closing, spin about u, spin about v) to (force, torques), positive definite
        arms = np.hstack([rng.normal(size=(3, 2)) * 0.3, rng.normal(size=(3, 1))])
        self.K = np.eye(3) * np.exp(rng.uniform(-1, 1, size=3)) + arms @ arms.T
        self.G = np.stack([np.ones(4), self.places[:, 1], -self.places[:, 0]], axis=1)
        rigid = self.G @ self.K @ self.G.T
        mask = np.outer(self.here, self.here)
        self.rigid = rigid * mask + np.diag(1 - self.here)
        self.A = self.rigid + np.diag(compliance * np.diag(self.rigid) * self.here)


def solution(A: Array, b: Array) -> Array:
    """Loads x >= 0 with A x - b >= 0 and x . (A x - b) = 0, by trying all sixteen sets of loaded points."""
    for loaded in itertools.product((False, True), repeat=4):
        on = np.array(loaded)
        x = np.zeros(4)
        if on.any():
            x[on] = np.linalg.solve(A[np.ix_(on, on)], b[on])
        if (x >= 0).all() and (A @ x - b >= -1e-12 * np.abs(b).max()).all():
            return x
    raise AssertionError("a positive definite problem has a solution")


def test_the_matrix_of_the_points_is_that_of_the_patch(rng: np.random.Generator) -> None:
    """A_kl = G_k K G_l^T; a missing point stands by itself."""
    for points in (1, 2, 3, 4) * 5:
        patch = Patch(rng, points)
        K = patch.K
        k = (K[0, 0], K[0, 1], K[0, 2], K[1, 1], K[1, 2], K[2, 2])
        found = point_matrix(k, Four(*patch.places[:, 0]), Four(*patch.places[:, 1]), Four(*patch.here))
        np.testing.assert_allclose(full(found), patch.rigid, rtol=1e-12, atol=1e-12 * np.abs(patch.rigid).max())


@pytest.mark.parametrize("points", [1, 2, 3, 4])
def test_the_inverse_is_that_of_the_points_that_are_there(rng: np.random.Generator, points: int) -> None:
    for _ in range(20):
        patch = Patch(rng, points)
        found = full(compiled(inverse_of_points)(packed(patch.A), Four(*patch.here)))
        wanted = np.zeros((4, 4))
        wanted[:points, :points] = np.linalg.inv(patch.A[:points, :points])
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_any_points_may_be_missing(rng: np.random.Generator) -> None:
    """Not only the last ones."""
    for loaded in itertools.product((0.0, 1.0), repeat=4):
        here = np.array(loaded)
        A = Patch(rng).A * np.outer(here, here) + np.diag(1 - here)
        found = full(inverse_of_points(packed(A), Four(*here)))
        wanted = np.linalg.inv(A) * np.outer(here, here)
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(np.linalg.inv(A)).max())


def test_times_and_lowest(rng: np.random.Generator) -> None:
    A, x = Patch(rng).A, rng.normal(size=4)
    np.testing.assert_allclose(times4(packed(A), Four(*x)), A @ x, rtol=1e-13, atol=1e-13)
    assert lowest(Four(*x)) == x.min()


def loads_of(A: Array, b: Array) -> Array:
    """What a pass finds: the loads without the limit, then the limit."""
    inverse = np.linalg.inv(A)
    return np.array(compiled(non_negative)(Four(*(inverse @ b)), packed(inverse)))


def random_problem(rng: np.random.Generator) -> tuple[Array, Array]:
    """A manifold and closing speeds of a body that falls, turns and wobbles."""
    patch = Patch(rng)
    return patch.A, patch.G @ rng.normal(size=3) + 0.1 * rng.normal(size=4)


def test_loads_without_a_pull_are_left_alone(rng: np.random.Generator) -> None:
    for _ in range(50):
        A = Patch(rng).A
        x = rng.uniform(0.01, 1.0, size=4)
        np.testing.assert_allclose(loads_of(A, A @ x), x, rtol=1e-9)


def test_loads_are_never_pulls_and_loaded_points_close_as_they_should(rng: np.random.Generator) -> None:
    """Whatever set it ends with: loads of zero or more, and no error at the points that carry some."""
    for _ in range(500):
        A, b = random_problem(rng)
        x = loads_of(A, b)
        assert (x >= 0.0).all()
        loaded = x > 0.0
        np.testing.assert_allclose((A @ x)[loaded], b[loaded], rtol=0, atol=1e-9 * np.abs(b).max())


def test_nearly_always_it_is_the_solution(rng: np.random.Generator) -> None:
    """Worst first is a rule of thumb: now and then it takes out a point that should carry a load.

    Then that point closes for one pass. In all cases at least as much energy is gone as without any load.
    """
    same, n = 0, 600
    for _ in range(n):
        A, b = random_problem(rng)
        x, wanted = loads_of(A, b), solution(A, b)
        same += bool(np.allclose(x, wanted, rtol=0, atol=1e-9 * max(np.abs(wanted).max(), 1e-3)))
        # 1/2 x A x - b x, which the solution minimises
        reached, least = 0.5 * x @ A @ x - b @ x, 0.5 * wanted @ A @ wanted - b @ wanted
        assert least - 1e-12 * abs(least) <= reached <= 1e-12
    assert same >= 0.95 * n


def test_all_points_that_open_carry_nothing(rng: np.random.Generator) -> None:
    for _ in range(50):
        np.testing.assert_array_equal(loads_of(Patch(rng).A, -rng.uniform(0.1, 1.0, size=4)), 0.0)


def test_one_point_too_high_leaves_a_stool_of_three(rng: np.random.Generator) -> None:
    """A level square under a load with one corner that opens: that corner and no other is free."""
    for corner in range(4):
        G = np.array([[1, y, -x] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], float)
        A = G @ np.diag([1.0, 0.1, 0.1]) @ G.T + 0.04 * np.eye(4)
        b = np.ones(4)
        b[corner] = -3.0
        x, wanted = loads_of(A, b), solution(A, b)
        np.testing.assert_allclose(x, wanted, atol=1e-12)
        assert x[corner] == 0.0
        assert (np.delete(x, corner) >= 0.0).all()


def kernel_of_lanes(x: Any, y: Any) -> None:
    """Rows 0 to 9 the matrix, 10 to 13 the closing speeds; 14 to 17 which points are there."""
    A = Sym4(
        load(x, 0), load(x, 1), load(x, 2), load(x, 3), load(x, 4), load(x, 5), load(x, 6), load(x, 7), load(x, 8),
        load(x, 9),
    )  # fmt: skip
    here = Four(load(x, 14), load(x, 15), load(x, 16), load(x, 17))
    inverse = inverse_of_points(A, here)
    found = non_negative(times4(inverse, Four(load(x, 10), load(x, 11), load(x, 12), load(x, 13))), inverse)
    store(y, 0, found.a)
    store(y, 1, found.b)
    store(y, 2, found.c)
    store(y, 3, found.d)


@pytest.mark.parametrize(("precision", "digits"), [(np.float32, 2e-4), (np.float64, 1e-10)], ids=["single", "double"])
def test_eight_manifolds_at_once_are_eight_one_by_one(rng: np.random.Generator, precision: Any, digits: float) -> None:
    """Some with fewer points, each with its own set of loads; lanes that are done wait for those that are not."""
    for _ in range(25):
        patches = [Patch(rng, int(rng.integers(1, 5))) for _ in range(LANES)]
        speeds = [(p.G @ rng.normal(size=3) + 0.1 * rng.normal(size=4)) * p.here for p in patches]
        x = np.array([[*p.A[UPPER], *b, *p.here] for p, b in zip(patches, speeds, strict=True)]).T
        y = np.full((4, LANES), np.nan, precision)
        compiled(kernel_of_lanes)(np.ascontiguousarray(x, precision), y)
        for lane, (patch, b) in enumerate(zip(patches, speeds, strict=True)):
            alone = loads_of(patch.A, b) * patch.here
            # a load that is zero but for rounding may be let go or kept: both answer the speeds that were asked for
            missed = patch.A @ (y[:, lane] - alone)
            assert np.abs(missed).max() <= digits * max(np.abs(b).max(), np.abs(alone * np.diag(patch.A)).max(), 1e-3)
            assert (y[:, lane] >= 0.0).all()
            assert (y[:, lane][patch.here == 0.0] == 0.0).all()
