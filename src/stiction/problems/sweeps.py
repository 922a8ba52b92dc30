"""The kernel of Gauss-Seidel with one problem's arrays in its hands."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.core.friction import local as solvers
from stiction.core.solve import nsgs
from stiction.errors import InvalidInputError
from stiction.problems.problem import ContactProblem
from stiction.problems.residuals import norm_of_q

Vector = NDArray[np.float64]
Local = Literal["secular", "alternate", "newton", "projection", "clamp"]
Order = Literal["forward", "symmetric", "random"]

LOCAL_SOLVERS: dict[str, int] = {
    "secular": solvers.SECULAR,
    "alternate": solvers.ALTERNATE,
    "newton": solvers.NEWTON,
    "projection": solvers.PROJECTION,
    "clamp": solvers.CLAMP,
}
ORDERS = ("forward", "symmetric", "random")
SINGULAR = 1e-10
"""A diagonal block whose smallest eigenvalue is below this part of its largest one is stiffened."""
STIFFENED = 1e-6


class Sweeps:
    """Sweeps over one problem with one local solver.

    Args:
        problem: what to solve.
        local: the local solver.
        order: "forward", "symmetric" (every second sweep backwards) or "random" (shuffled once).
        omega: relaxation, above 0 and below 2; 1 for none.
        seed: of the random order.
    """

    def __init__(
        self, problem: ContactProblem, local: str = "secular", order: str = "forward", omega: float = 1.0, seed: int = 0
    ) -> None:
        checks.one_of("local", local, LOCAL_SOLVERS)
        checks.one_of("order", order, ORDERS)
        if not 0.0 < checks.number("omega", omega) < 2.0:
            raise InvalidInputError(f"omega must be above 0 and below 2, got {omega!r}.")
        self.problem = problem
        self.which = LOCAL_SOLVERS[local]
        self.turn = order == "symmetric"
        self.omega = float(omega)
        n = problem.contacts
        self.order = np.random.default_rng(seed).permutation(n) if order == "random" else np.arange(n)
        self.at_rest = np.zeros((n, 3))
        W = problem.W
        self.matrix = (W.pointers, W.indices, W.data)
        self.places = W.diagonal_places()
        self.q = problem.q.reshape(-1, 3).copy()
        self.mu = problem.mu.copy()
        self.norm = norm_of_q(problem)
        self.extra, self.inertia = _stiffening(W.diagonal())

    def advance(self, r: Vector, count: int, *, alpha: float = 0.0, anchor: Vector | None = None) -> None:
        """``count`` sweeps from r, in place; with alpha those of the proximal problem at ``anchor``."""
        at = self.at_rest if anchor is None else anchor
        nsgs.sweep(
            *self.matrix, self.places, self.q, self.mu, self.extra, r,
            self.order, self.turn, at, float(alpha), self.which, self.omega, int(count),
        )  # fmt: skip

    def error(self, r: Vector) -> float:
        """The reported error of r: natural map with rho = 1 over |q|."""
        return float(nsgs.natural_map(*self.matrix, self.q, self.mu, r, 1.0)) / self.norm

    def merit(self, r: Vector) -> float:
        """The natural map with rho = a typical mass, so that impulses and velocities weigh alike whatever the units."""
        return float(nsgs.natural_map(*self.matrix, self.q, self.mu, r, self.inertia)) / (self.norm * self.inertia)


def _stiffening(diagonal: Vector) -> tuple[Vector, float]:
    """What to add to singular diagonal blocks, and the typical mass of a contact, the inverse of W's mean diagonal."""
    traces = np.trace(diagonal, axis1=1, axis2=2) / 3.0
    normal = diagonal[:, 0, 0]
    if len(normal) and normal.min() < 0.0:
        worst = int(normal.argmin())
        raise InvalidInputError(f"W must be positive semidefinite, got W_nn = {normal[worst]:g} at contact {worst}.")
    mean = float(traces.mean()) if len(traces) and traces.mean() > 0.0 else 1.0
    eigenvalues = np.linalg.eigvalsh(0.5 * (diagonal + diagonal.transpose(0, 2, 1)))
    singular = eigenvalues[:, 0] <= SINGULAR * eigenvalues[:, 2]
    extra = np.where(singular, STIFFENED * np.maximum(traces, mean), 0.0)
    return extra, 1.0 / mean
