"""Contact problems made by hand or at random, and a check of solutions that shares nothing with the solver."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction.problems import ContactProblem

Vector = NDArray[np.float64]


def random_problem(rng: np.random.Generator, bodies: int = 4, contacts: int = 10) -> ContactProblem:
    """Bodies with random masses and inertias that fall onto the ground and each other, through random contacts.

    No wall moves (w = 0), so standing still is allowed and there is a solution.
    """
    d = 6 * bodies
    M = np.zeros((d, d))
    for k in range(bodies):
        M[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = np.exp(rng.uniform(-1, 1)) * np.eye(3)
        A = rng.normal(size=(3, 3))
        M[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = A @ A.T + 0.3 * np.eye(3)
    H = np.zeros((d, 3 * contacts))
    for c in range(contacts):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]  # columns: normal and two in the plane
        pair = rng.choice(bodies, size=min(2, bodies), replace=False)
        for body, sign in zip(pair[: rng.integers(1, len(pair) + 1)], (1.0, -1.0), strict=False):
            arm = rng.uniform(-0.5, 0.5, size=3)
            H[6 * body : 6 * body + 3, 3 * c : 3 * c + 3] = sign * frame
            H[6 * body + 3 : 6 * body + 6, 3 * c : 3 * c + 3] = sign * np.cross(arm, frame.T).T
    f = M @ rng.normal(size=d)
    return ContactProblem.from_global(M, H, f, np.zeros(3 * contacts), rng.uniform(0.05, 0.5, size=contacts))


def wedged() -> ContactProblem:
    """A ball between two walls that approach each other: there is no solution."""
    W = np.eye(6)
    W[0, 3] = W[3, 0] = -1.0
    return ContactProblem(W, [-1.0, 0, 0, -1.0, 0, 0], 0.5, title="wedged")


def assert_solved(problem: ContactProblem, r: Vector, tolerance: float) -> None:
    """The laws of Signorini and Coulomb, contact by contact, in units of |q| for velocities and of |r| for impulses."""
    W = problem.W.dense()
    u = (W @ r.ravel() + problem.q).reshape(-1, 3)
    small_u = tolerance * np.linalg.norm(problem.q)
    small_r = tolerance * max(np.linalg.norm(r), 1e-12)
    for i in range(problem.contacts):
        normal, friction, speed = r[i, 0], np.hypot(*r[i, 1:]), np.hypot(*u[i, 1:])
        assert friction <= problem.mu[i] * normal + small_r, f"contact {i} is outside its cone"
        assert u[i, 0] >= -small_u, f"contact {i} goes on approaching"
        assert min(normal / small_r, u[i, 0] / small_u) <= 1.0, f"contact {i} pushes while it opens"
        if normal > small_r and speed > small_u:
            # friction is opposite to the slip and as large as it may be; how well that is known depends on the slip
            opposite = -problem.mu[i] * normal * u[i, 1:] / speed
            allowed = small_r + 2.0 * problem.mu[i] * normal * small_u / speed
            assert np.hypot(*(r[i, 1:] - opposite)) <= allowed, (
                f"contact {i} has friction that is not opposite to its slip"
            )
