"""Where the differences are smallest: least squares from several starts, with steps that suit a simulation.

A simulation is no smooth function of its parameters. A crate lets go in a certain step, so that static friction acts
in stairs; a cube lands on another edge. Differences for the Jacobian therefore begin coarse and become as fine as they
can be without seeing the stairs, and a simplex, which needs no slopes, has the last word.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from stiction.errors import InvalidInputError
from stiction.fit.parameters import Array, Parameter

LOSSES = ("linear", "soft_l1", "huber", "cauchy")
COARSE = 0.02
"""Share of a parameter's range over which differences are taken at first."""
LADDER = (0.02, 0.01, 0.005, 0.0025, 0.001)
"""Shares among which the final one is chosen."""
AGREE = 0.1
"""Two steps of the ladder agree if their columns differ by less than this share."""
ROUNDS = 40
"""Rounds of least squares from one start at most."""
CANDIDATES = 16
"""Points a parameter among which starts are chosen."""
TUNING = 1.345
"""Residuals above so many standard deviations count less with a robust loss (Huber's choice, 95 % efficient)."""

Progress = Callable[["State"], None]


class Objective(Protocol):
    """What can be fitted: parameters and a function of them."""

    @property
    def parameters(self) -> Sequence[Parameter]:
        """What is to be found."""

    def residuals(self, x: Sequence[float] | Array) -> Array:
        """(m,) differences, each in units of its own standard deviation or of one that all share."""


@dataclass
class State:
    """How far a search is, and the best it has seen.

    Attributes:
        phase: a word or two. done, total: evaluations, of those that may come.
        x: (p,) the best values so far, None before the first. rms: root mean square of their residuals.
    """

    phase: str = "starting"
    done: int = 0
    total: int = 0
    x: Array | None = None
    rms: float = np.inf


class Search:
    """The function to be minimised, with a memory of the best and of how often it was asked.

    Args:
        objective: parameters and residuals.
        on_progress: told after every evaluation.
    """

    def __init__(self, objective: Objective, on_progress: Progress | None = None) -> None:
        self.objective = objective
        self.parameters = list(objective.parameters)
        self.low = np.array([p.low for p in self.parameters])
        self.high = np.array([p.high for p in self.parameters])
        self.span = self.high - self.low
        self.state = State()
        self._tell = on_progress
        self._last: tuple[bytes, Array] | None = None

    def __call__(self, x: Array) -> Array:
        """Residuals (m,) at x (p,)."""
        key = np.ascontiguousarray(x, dtype=np.float64).tobytes()
        if self._last is not None and self._last[0] == key:
            return self._last[1]
        f = np.asarray(self.objective.residuals(x), dtype=np.float64)
        self._last = key, f
        rms = float(np.sqrt(np.mean(f * f)))
        self.state.done += 1
        if rms < self.state.rms:
            self.state.rms, self.state.x = rms, np.array(x)
        if self._tell is not None:
            self._tell(self.state)
        return f

    def cost(self, x: Array) -> float:
        """Sum of squares."""
        f = self(x)
        return float(f @ f)

    def jacobian(self, x: Array, steps: Array) -> Array:
        """(m, p) from differences to both sides, or to the inner one where the range ends.

        Args:
            x: (p,). steps: (p,) in the units of the parameters.
        """
        columns = [self.column(x, j, float(step)) for j, step in enumerate(steps)]
        return np.stack(columns, axis=1)

    def column(self, x: Array, j: int, step: float) -> Array:
        """(m,) derivative by one parameter."""
        up, down = x.copy(), x.copy()
        up[j], down[j] = min(x[j] + step, self.high[j]), max(x[j] - step, self.low[j])
        return np.asarray((self(up) - self(down)) / (up[j] - down[j]))

    def steps(self, x: Array) -> tuple[Array, Array]:
        """(p,) the finest steps at which the slope does not depend on the step, and (p,) by how much it still does.

        The second number is 0 for a smooth function, 0.1 or less for a usable one, and above where stairs are in the
        way; of a parameter that changes nothing it is 0.
        """
        chosen, rough = np.empty(len(x)), np.zeros(len(x))
        for j in range(len(x)):
            columns = [self.column(x, j, share * self.span[j]) for share in LADDER]
            sizes = [float(np.linalg.norm(column)) for column in columns]
            changes = [
                float(np.linalg.norm(fine - coarse)) / size if size > 0.0 else 0.0
                for coarse, fine, size in zip(columns, columns[1:], sizes, strict=False)
            ]
            good = [k for k, change in enumerate(changes) if change < AGREE]
            k = good[-1] + 1 if good else 0
            chosen[j], rough[j] = LADDER[k] * self.span[j], changes[max(k - 1, 0)]
        return chosen, rough


def starts(search: Search, count: int, rng: np.random.Generator, points: int | None = None) -> list[Array]:
    """The first values, and the best of points that fill the ranges evenly (Sobol), ``count`` in all.

    ``points`` are tried, 16 a parameter if left out, rounded up to a power of two.
    """
    from scipy.stats import qmc

    first = np.array([p.first for p in search.parameters])
    if count == 1:
        return [first]
    p = len(first)
    wanted = max(count, CANDIDATES * p if points is None else points)
    sobol = qmc.Sobol(p, scramble=True, rng=rng)
    even = sobol.random_base2(int(np.ceil(np.log2(wanted))))
    search.state.phase = "looking around"
    # a little inside the range: at its very ends many a simulation does nothing at all
    scored = sorted((search.cost(x), k, x) for k, x in enumerate(search.low + (0.02 + 0.96 * even) * search.span))
    chosen = [first]
    for _, _, x in scored:
        apart = min(float(np.max(np.abs(x - other) / search.span)) for other in chosen)
        if apart > 0.05:
            chosen.append(x)
        if len(chosen) == count:
            break
    return chosen


def descend(search: Search, x: Array, steps: Array, loss: str = "linear", scale: float = 1.0) -> Array:
    """Least squares from one start within the ranges; returns where it ends, (p,)."""
    from scipy.optimize import least_squares

    inside = np.clip(x, search.low + 1e-9 * search.span, search.high - 1e-9 * search.span)
    found = least_squares(
        search,
        inside,
        jac=lambda at: search.jacobian(at, steps),
        bounds=(search.low, search.high),
        x_scale=search.span,
        loss=loss,
        f_scale=scale,
        max_nfev=ROUNDS,
        ftol=1e-7,
        xtol=1e-7,
        gtol=1e-10,
    )
    return np.asarray(found.x)


def settle(search: Search, x: Array, size: Array, total: Callable[[Array], float], most: int | None = None) -> Array:
    """A simplex (Nelder and Mead) of that size (p,) about x, down to a hundredth of it; returns the better of both.

    It evaluates ``most`` points, 60 a parameter if left out, and a few more at most.
    """
    from scipy.optimize import minimize

    corners = np.vstack([x, x + np.diag(np.where(x + size <= search.high, size, -size))])
    found = minimize(
        total,
        x,
        method="Nelder-Mead",
        bounds=list(zip(search.low, search.high, strict=True)),
        options={
            "initial_simplex": corners,
            "maxfev": 60 * len(x) if most is None else most,
            "xatol": 0.01 * float(np.min(size)),
            "fatol": 1e-6 * max(total(x), 1e-12),
        },
    )
    return np.asarray(found.x) if found.fun < total(x) else x


def trials(search: Search, count: int, total: Callable[[Array], float], seed: int) -> Array:
    """The best of ``count`` trials of Optuna's tree-structured Parzen estimator, which needs no slopes at all.

    Raises:
        InvalidInputError: Optuna is not installed.
    """
    try:
        import optuna
    except ImportError:
        raise InvalidInputError('--trials needs Optuna: pip install "stiction[fit]".') from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=max(10, count // 5))
    study = optuna.create_study(sampler=sampler)
    names = [p.name for p in search.parameters]
    study.enqueue_trial({p.name: p.first for p in search.parameters})

    def ask(trial: optuna.Trial) -> float:
        return total(
            np.array([trial.suggest_float(n, a, b) for n, a, b in zip(names, search.low, search.high, strict=True)])
        )

    study.optimize(ask, n_trials=count)
    return np.array([study.best_params[name] for name in names])


def robust_total(search: Search, loss: str, scale: float) -> Callable[[Array], float]:
    """The sum that a loss makes of the residuals, as scipy's ``least_squares`` has it."""

    def total(x: Array) -> float:
        z = (search(x) / scale) ** 2
        return float(scale**2 * _rho(loss, z).sum())

    return total


def _rho(loss: str, z: Array) -> Array:
    if loss == "soft_l1":
        return np.asarray(2.0 * (np.sqrt(1.0 + z) - 1.0))
    if loss == "huber":
        return np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0)
    return np.log1p(z) if loss == "cauchy" else z


def weights(loss: str, z: Array) -> Array:
    """Derivative of the loss by z, the squared residual over the squared scale: how much each residual counts."""
    if loss == "soft_l1":
        return np.asarray(1.0 / np.sqrt(1.0 + z))
    if loss == "huber":
        return np.where(z <= 1.0, 1.0, 1.0 / np.sqrt(np.maximum(z, 1.0)))
    return 1.0 / (1.0 + z) if loss == "cauchy" else np.ones_like(z)


def spread(f: Array) -> float:
    """Standard deviation of residuals by their median size, which outliers do not move (1.4826 MAD)."""
    return 1.4826 * float(np.median(np.abs(f)))
