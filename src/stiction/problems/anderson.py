"""Sweeps made faster: Anderson's extrapolation, and long steps along a drift, both taken only if they pay.

A run of sweeps is a map G, and a solution its fixed point. Anderson, "Iterative procedures for nonlinear integral
equations", J. ACM 12 (1965), takes the combination of the last few G(r_k) whose steps G(r_k) - r_k cancel best; for a
linear map that amounts to GMRES. Friction is linear only in pieces: where contacts open or begin to slide it may lead
astray. So the combination, projected onto the cones, is taken only where it does not raise the natural map; else its
memory is dropped.

Between rigid bodies there is something else: where contacts share a load, impulse may creep from one to another at a
constant rate for tens of thousands of sweeps while all velocities stand still. No combination of nearly equal steps
ends that; walking on along the last step does, twice as far each time, for as long as the natural map falls.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stiction.problems.residuals import project_onto_cones
from stiction.problems.sweeps import Sweeps

Vector = NDArray[np.float64]

ROUND = 10
"""Sweeps of one evaluation of G."""
MEMORY = 10
"""Steps that are combined."""
WALK_EVERY = 5
"""Rounds between walks along the drift."""
FIRST_STRIDE, LONGEST_STRIDE = 10.0, 1e7
RIDGE = 1e-12
"""Of the least-squares problem's trace: steps may be nearly parallel."""


def accelerated(
    sweeps: Sweeps, r: Vector, limit: int, tolerance: float, deadline: float, log: Callable[[int, Vector, float], None]
) -> int:
    """Sweep from r until the error is at ``tolerance``, or ``limit`` sweeps are done, or the deadline is past.

    ``log`` is told the number of sweeps, the impulses and their error after every round. Returns the sweeps done.
    """
    mu = sweeps.mu
    images: list[Vector] = []
    steps: list[Vector] = []
    done = rounds = 0
    while done < limit:
        count = min(ROUND, limit - done)
        image = r.copy()
        sweeps.advance(image, count)
        done += count
        rounds += 1
        step = image - r
        best, merit = image, sweeps.merit(image)
        images, steps = [*images[-MEMORY:], image], [*steps[-MEMORY:], step]

        if len(steps) > 2:
            combined = project_onto_cones(_combination(images, steps), mu)
            value = sweeps.merit(combined)
            if value <= merit:
                best, merit = combined, value
            else:
                images, steps = images[-1:], steps[-1:]

        if rounds % WALK_EVERY == 0:
            farther, walked = _walk(sweeps, best, merit, step)
            if walked:
                best, images, steps = farther, [], []

        r = best
        error = sweeps.error(r)
        log(done, r, error)
        if not error > tolerance or time.perf_counter() > deadline:
            break
    return done


def _combination(images: list[Vector], steps: list[Vector]) -> Vector:
    """The combination of images, weights adding up to one, whose steps cancel best in the least-squares sense."""
    differences = np.diff([step.ravel() for step in steps], axis=0)
    moved = np.diff([image.ravel() for image in images], axis=0)
    normal = differences @ differences.T
    normal[np.diag_indices_from(normal)] += RIDGE * normal.trace() + np.finfo(float).tiny
    weights = np.linalg.solve(normal, differences @ steps[-1].ravel())
    combined: Vector = images[-1] - (weights @ moved).reshape(images[-1].shape)
    return combined


def _walk(sweeps: Sweeps, r: Vector, merit: float, step: Vector) -> tuple[Vector, bool]:
    """From r along ``step``, each time twice as far, for as long as the natural map falls."""
    stride, walked = FIRST_STRIDE, False
    start = r
    while stride < LONGEST_STRIDE:
        there = project_onto_cones(start + stride * step, sweeps.mu)
        value = sweeps.merit(there)
        if not value < merit:
            break
        r, merit, walked = there, value, True
        stride *= 2.0
    return r, walked
