"""How far a set of impulses is from solving a contact problem.

**The error that is reported** everywhere is the natural map with rho = 1, as FCLIB and Siconos take it,

    |r - P_K(r - (u + (mu |u_t|, 0, 0)))| / |q|,

so that numbers can be compared with theirs (Acary, Brémond, Huber, "On solving contact problems with Coulomb friction:
formulations and numerical comparisons", 2018). It is zero at solutions and nowhere else. But it subtracts m/s from N s,
so its size depends on units: of a contact that ought to be open it counts the smaller one of r and u.

**De Saxcé's form** has no such choice: with the raised velocity w = u + (mu |u_t|, 0, 0), the laws of Signorini and
Coulomb are

    r in K,  w in K*,  r . w = 0,

and each part can be off by itself. :func:`residuals` gives them beside the natural map, each relative to what it is
made of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.problems.problem import ContactProblem

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Residuals:
    """What is left of each law; all are zero at a solution.

    Attributes:
        natural_map: the reported error, by FCLIB's definition.
        cone: how far r is outside the friction cones, as a part of |r|.
        dual: how far the raised velocities are outside the dual cones, as a part of |q|.
        gap: sum of |r . (u + (mu |u_t|, 0, 0))| as a part of |r| |q|.
    """

    natural_map: float
    cone: float
    dual: float
    gap: float


def impulses(problem: ContactProblem, r: ArrayLike) -> Vector:
    """r as (n, 3), checked."""
    given = np.array(r, dtype=np.float64)
    if given.size != 3 * problem.contacts:
        raise InvalidInputError(f"r must hold {3 * problem.contacts} numbers, got shape {given.shape}.")
    return given.reshape(-1, 3)


def velocities(problem: ContactProblem, r: ArrayLike) -> Vector:
    """u = W r + q, (n, 3) in m/s, for impulses r of shape (n, 3) or (3n,)."""
    return problem.W.times(impulses(problem, r)) + problem.q.reshape(-1, 3)


def project_onto_cones(r: Vector, mu: Vector) -> Vector:
    """The nearest points of the cones |r_t| <= mu r_n, for r of shape (n, 3)."""
    normal, planar = r[:, 0], np.hypot(r[:, 1], r[:, 2])
    inside = planar <= mu * normal
    outside = ~inside & (mu * planar > -normal)  # neither inside nor in the polar cone, whose nearest point is zero
    height = (normal + mu * planar) / (1.0 + mu * mu)
    made = np.where(inside[:, None], r, 0.0)
    made[outside, 0] = height[outside]
    made[outside, 1:] = (mu * height / np.where(planar > 0.0, planar, 1.0))[outside, None] * r[outside, 1:]
    return made


def raised(u: Vector, mu: Vector) -> Vector:
    """De Saxcé's velocities u + (mu |u_t|, 0, 0)."""
    made = u.copy()
    made[:, 0] += mu * np.hypot(u[:, 1], u[:, 2])
    return made


def natural_map(problem: ContactProblem, r: ArrayLike, *, rho: float = 1.0) -> float:
    """|r - P_K(r - rho (u + (mu |u_t|, 0, 0)))| / |q|, by numpy; rho in kg, 1 for the error that is reported.

    Where q is zero, so that r = 0 is a solution, it is not divided.
    """
    checks.positive("rho", rho)
    r = impulses(problem, r)
    step = r - rho * raised(velocities(problem, r), problem.mu)
    return float(np.linalg.norm(r - project_onto_cones(step, problem.mu)) / norm_of_q(problem))


def residuals(problem: ContactProblem, r: ArrayLike) -> Residuals:
    """All residuals of impulses r, (n, 3) or (3n,) in N s."""
    r = impulses(problem, r)
    w = raised(velocities(problem, r), problem.mu)
    size, speed = float(np.linalg.norm(r)) or 1.0, norm_of_q(problem)
    # P_K*(w) = w + P_K(-w), by Moreau
    return Residuals(
        natural_map=natural_map(problem, r),
        cone=float(np.linalg.norm(r - project_onto_cones(r, problem.mu)) / size),
        dual=float(np.linalg.norm(project_onto_cones(-w, problem.mu)) / speed),
        gap=float(np.abs((r * w).sum(axis=1)).sum() / (size * speed)),
    )


def norm_of_q(problem: ContactProblem) -> float:
    """|q|, or 1 where it is zero."""
    return float(np.linalg.norm(problem.q)) or 1.0
