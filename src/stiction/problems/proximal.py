"""Newton's method on all contacts at once, within a proximal-point loop: for what sweeps do not bring to an end.

Alart and Curnier's equations, r_n = max(0, r_n - rho_n u_n) and r_t = the nearest point to r_t - rho_t u_t in the disk
of radius mu max(0, r_n - rho_n u_n), are smooth in pieces. Newton's method on them converges quadratically near a
solution if W has full rank, and may fail without it, the usual case between rigid bodies. So each outer step solves

    W + alpha 1,   q - alpha r_before

instead, which has full rank, and whose solution is one of the problem itself once r stands still (Rockafellar's
proximal points; for friction: Acary, Brémond, Huber, "On solving contact problems with Coulomb friction: formulations
and numerical comparisons", 2018). alpha falls while Newton arrives, and rises when it does not.

An inner step costs one sparse LU factorisation of a 3n x 3n matrix with the pattern of W.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stiction.problems.residuals import project_onto_cones
from stiction.problems.sweeps import Sweeps

Vector = NDArray[np.float64]

FIRST_ALPHA, SMALLEST_ALPHA, LARGEST_ALPHA = 1e-2, 1e-10, 1e2
"""Of W's mean diagonal."""
FALLS, RISES = 0.2, 10.0
INNER_STEPS = 12
ARRIVED = 0.1
"""An outer step counts if Newton has brought its equations down to this part."""
ENOUGH = 1e-3
"""Of the tolerance: as exact as an inner problem need be."""
SHORTEST_STEP = 1e-3
SUFFICIENT = 1e-4


def proximal_newton(
    sweeps: Sweeps, r: Vector, limit: int, tolerance: float, deadline: float, log: Callable[[int, Vector, float], None]
) -> int:
    """Newton steps from r until the error is at ``tolerance``, or ``limit`` of them are done, or the deadline is past.

    ``log`` is told the number of Newton steps, the impulses and their error after every outer step. Returns the steps.
    """
    unit = 1.0 / sweeps.inertia  # impulses times this are velocities: everything below is in m/s
    x = r * unit
    alpha, done = FIRST_ALPHA, 0
    enough = ENOUGH * tolerance * sweeps.norm
    while done < limit and time.perf_counter() < deadline:
        equations = _Equations(sweeps, unit, alpha, x)
        y, before, after, count = _newton(equations, x, min(INNER_STEPS, limit - done), enough)
        done += max(count, 1)
        here = project_onto_cones(y, sweeps.mu) / unit
        error = sweeps.error(here)
        log(done, here, error)
        if error <= tolerance:
            break
        if after < ARRIVED * before or after <= enough:
            x, alpha = y, max(FALLS * alpha, SMALLEST_ALPHA)
        else:
            alpha = min(RISES * alpha, LARGEST_ALPHA)
    return done


def _newton(equations: _Equations, x: Vector, limit: int, enough: float) -> tuple[Vector, float, float, int]:
    """Damped Newton steps; the last point, the norms of the first and the last residual, and the number of steps."""
    F, A, B = equations.at(x)
    norm = before = float(np.linalg.norm(F))
    for done in range(limit):
        if norm <= enough:
            return x, before, norm, done
        step = equations.step(F, A, B)
        if step is None:
            return x, before, norm, done
        share = 1.0
        while True:
            there = x + share * step
            F, A, B = equations.at(there)
            value = float(np.linalg.norm(F))
            if value < (1.0 - SUFFICIENT * share) * norm:
                break
            share *= 0.5
            if share < SHORTEST_STEP:
                return x, before, norm, done + 1
        x, norm = there, value
    return x, before, norm, limit


class _Equations:
    """Alart and Curnier's equations of one proximal problem; impulses times ``unit``, so in m/s."""

    def __init__(self, sweeps: Sweeps, unit: float, alpha: float, anchor: Vector) -> None:
        from scipy.sparse import bsr_array

        self.sweeps = sweeps
        pointers, indices, blocks = sweeps.matrix
        self.blocks = blocks / unit
        self.blocks[sweeps.places] += alpha * np.eye(3)
        self.pattern = (indices, pointers)
        self.row = np.repeat(np.arange(len(pointers) - 1), np.diff(pointers))
        self.bsr = bsr_array
        self.W = self._sparse(self.blocks)
        self.q = sweeps.q - alpha * anchor
        diagonal = self.blocks[sweeps.places]
        normal, planar = diagonal[:, 0, 0], 0.5 * (diagonal[:, 1, 1] + diagonal[:, 2, 2])
        self.rho = 1.0 / np.column_stack((normal, planar, planar))

    def _sparse(self, blocks: Vector) -> object:
        size = 3 * (len(self.pattern[1]) - 1)
        return self.bsr((blocks, *self.pattern), shape=(size, size)).tocsc()

    def at(self, x: Vector) -> tuple[Vector, Vector, Vector]:
        """Residual F (n, 3), and blocks A, B (n, 3, 3) of its generalised derivative dF = A dx + B du."""
        mu = self.sweeps.mu
        u = (self.W @ x.ravel()).reshape(-1, 3) + self.q  # type: ignore[operator]  # scipy has no types
        y = x - self.rho * u
        normal = np.maximum(y[:, 0], 0.0)
        radius, planar = mu * normal, np.hypot(y[:, 1], y[:, 2])
        slides = planar > radius
        some = np.where(planar > 0.0, planar, 1.0)
        scale = np.where(slides, radius / some, 1.0)
        along = np.where(slides[:, None], y[:, 1:] / some[:, None], 0.0)
        F = np.column_stack((x[:, 0] - normal, x[:, 1:] - scale[:, None] * y[:, 1:]))

        nearest = np.zeros((len(mu), 3, 3))  # derivative of the nearest point in y
        closed = y[:, 0] > 0.0
        nearest[:, 0, 0] = closed
        nearest[:, 1:, 0] = (mu * closed)[:, None] * along
        nearest[:, 1:, 1:] = scale[:, None, None] * (np.eye(2) - along[:, :, None] * along[:, None, :])
        return F, np.eye(3) - nearest, nearest * self.rho[:, None, :]

    def step(self, F: Vector, A: Vector, B: Vector) -> Vector | None:
        """Newton's step -(A + B W)^-1 F, or None where that matrix is singular."""
        from scipy.sparse.linalg import splu

        jacobian = np.einsum("kab,kbc->kac", B[self.row], self.blocks)
        jacobian[self.sweeps.places] += A
        try:
            step: Vector = -splu(self._sparse(jacobian)).solve(F.ravel())
        except RuntimeError:
            return None
        return step.reshape(-1, 3) if np.isfinite(step).all() else None
