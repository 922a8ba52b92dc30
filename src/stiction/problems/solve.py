"""Solve a contact problem, and say how far that went.

The default is the most robust of what is here: Gauss-Seidel over contacts with the exact local solver, accelerated, and
a proximal Newton method for what is left when sweeps come to an end. Each part can be asked for alone.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.errors import InvalidInputError, IterationLimitWarning
from stiction.problems.problem import ContactProblem
from stiction.problems.residuals import impulses, project_onto_cones, velocities

if TYPE_CHECKING:
    from stiction.problems.sweeps import Sweeps

Vector = NDArray[np.float64]
Log = Callable[[int, Vector, float], None]

METHODS = ("nsgs", "newton")
MOST_NEWTON_STEPS = 600
TURNS = ((2_000, 50), (8_000, 150), (math.inf, MOST_NEWTON_STEPS))
"""Sweeps, then Newton steps, in turns: each brings problems to an end on which the other creeps."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What :func:`solve` found.

    Attributes:
        r: impulses, (n, 3) in N s, the normal component first.
        u: velocities W r + q, (n, 3) in m/s.
        error: natural map of r with rho = 1 as a part of |q|, the error that FCLIB reports.
        converged: whether the error is at the tolerance.
        sweeps: sweeps done.
        newton_steps: steps of the proximal Newton method done.
        seconds: wall time, the compilation of the kernels on the first call included.
        log: the error on the way, (k, 2): sweeps plus Newton steps, error.
    """

    r: Vector
    u: Vector
    error: float
    converged: bool
    sweeps: int
    newton_steps: int
    seconds: float
    log: Vector


def solve(
    problem: ContactProblem,
    *,
    method: str = "nsgs",
    local: str = "secular",
    accelerate: bool = True,
    finish: bool = True,
    tolerance: float = 1e-6,
    sweeps: int = 100_000,
    seconds: float | None = None,
    every: int = 10,
    order: str = "forward",
    omega: float = 1.0,
    seed: int = 0,
    start: ArrayLike | None = None,
    warn: bool = True,
) -> Solution:
    """Find impulses that obey the laws of Signorini and Coulomb at all contacts.

    Args:
        problem: the contacts.
        method: "nsgs" (sweeps over the contacts) or "newton" (proximal Newton steps on all of them from the start).
        local: the solver of a single contact in a sweep: "secular", "alternate", "newton", "projection" or "clamp". The
            last one has other fixed points than the problem has solutions; it is there to be compared with.
        accelerate: extrapolate from the last sweeps wherever that lowers the natural map.
        finish: take turns with proximal Newton steps where sweeps alone are slow to reach the tolerance.
        tolerance: of the error.
        sweeps: the most sweeps that are made.
        seconds: wall time after which no further sweep begins; no limit if left out.
        every: sweeps between two entries of the log, for sweeps that are not accelerated; the error is tested then.
        order: in which contacts are visited: "forward", "symmetric" (every second sweep backwards) or "random"
            (shuffled once, by ``seed``).
        omega: over- or under-relaxation, above 0 and below 2.
        seed: of the random order. The same call gives the same result to the bit, unless ``seconds`` cuts it short.
        start: impulses to start from, (n, 3) or (3n,); zero if left out.
        warn: whether to warn of an error above the tolerance; ``converged`` tells it anyway.

    Returns:
        The best impulses that were seen.

    Raises:
        InvalidInputError: an argument is not allowed, or W has a negative diagonal.

    Warns:
        IterationLimitWarning: the error is above the tolerance. There may be no solution: a body may be wedged between
            walls that approach each other.
    """
    from stiction.problems.anderson import accelerated
    from stiction.problems.proximal import proximal_newton
    from stiction.problems.sweeps import Sweeps

    checks.one_of("method", method, METHODS)
    checks.positive("tolerance", tolerance)
    checks.integer("sweeps", sweeps, minimum=0)
    checks.integer("every", every, minimum=1)
    began = time.perf_counter()
    deadline = math.inf if seconds is None else began + checks.positive("seconds", seconds, "s")
    engine = Sweeps(problem, local, order, omega, seed)
    r = np.zeros((problem.contacts, 3)) if start is None else impulses(problem, start)
    if not np.isfinite(r).all():
        raise InvalidInputError("start must be finite.")
    r = project_onto_cones(r, engine.mu)

    best = _Best(r, engine.error(r))
    run = accelerated if accelerate else partial(_plain, every=every)
    done = newton_steps = 0
    for most, most_steps in TURNS if method == "nsgs" and finish else ((math.inf, MOST_NEWTON_STEPS),):
        if best.error <= tolerance or (done + newton_steps and time.perf_counter() > deadline):
            break
        if method == "nsgs":
            limit = int(min(most, sweeps - done))
            done += run(engine, best.r.copy(), limit, tolerance, deadline, best.see)
            best.offset = done + newton_steps
        if (method == "newton" or finish) and best.error > tolerance:
            newton_steps += proximal_newton(engine, best.r, most_steps, tolerance, deadline, best.see)
            best.offset = done + newton_steps

    converged = best.error <= tolerance
    if warn and not converged:
        steps = f" and {newton_steps} Newton steps" if newton_steps else ""
        warnings.warn(
            f"{problem.title or 'A contact problem'}: error {best.error:.2g} after {done} sweeps{steps} is above the "
            f"tolerance {tolerance:g}; more sweeps may help, or there is no solution.",
            IterationLimitWarning,
            stacklevel=2,
        )
    return Solution(
        r=best.r,
        u=velocities(problem, best.r),
        error=best.error,
        converged=converged,
        sweeps=done,
        newton_steps=newton_steps,
        seconds=time.perf_counter() - began,
        log=np.array(best.log, dtype=np.float64).reshape(-1, 2),
    )


class _Best:
    """The best impulses so far, and the log."""

    def __init__(self, r: Vector, error: float) -> None:
        self.r, self.error = r, error
        self.log: list[tuple[int, float]] = [(0, error)]
        self.offset = 0

    def see(self, done: int, r: Vector, error: float) -> None:
        self.log.append((self.offset + done, error))
        if error < self.error:
            self.r, self.error = r.copy(), error


def _plain(engine: Sweeps, r: Vector, limit: int, tolerance: float, deadline: float, log: Log, *, every: int) -> int:
    """Sweeps and nothing else."""
    done = 0
    while done < limit:
        count = min(every, limit - done)
        engine.advance(r, count)
        done += count
        error = engine.error(r)
        log(done, r, error)
        if not error > tolerance or time.perf_counter() > deadline:
            break
    return done
