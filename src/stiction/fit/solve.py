"""Fit: the values that explain the data best, how well the data know them, and what they do not tell."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.fit import intervals, profile
from stiction.fit import search as searching
from stiction.fit.parameters import Array, Parameter
from stiction.fit.search import LOSSES, Progress, Search

MOST_TRACKS_ALONE = 8
"""With so many tracks or more the bootstrap draws tracks, below it draws moments: noise differs less than tosses do."""
WAVES = 0.5
"""Correlation of neighbouring residuals above which the scene misses something."""


class Fittable(Protocol):
    """What :func:`fit` takes: a :class:`stiction.fit.problem.Problem`, or anything with the same face."""

    labels: NDArray[np.int64]
    moments: Array

    @property
    def parameters(self) -> Sequence[Parameter]:
        """What is to be found."""

    def residuals(self, x: Sequence[float] | Array) -> Array:
        """(m,) differences."""


@dataclass(frozen=True)
class Estimate:
    """What was found of one parameter.

    Attributes:
        parameter: which.
        value: its best value. error: standard error, infinite if the data do not see it.
        low, high: an interval that holds the true value in 90 of 100 such experiments.
        seen: whether the data tell anything of it.
    """

    parameter: Parameter
    value: float
    error: float
    low: float
    high: float
    seen: bool

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        named = {"name": self.parameter.name, "keys": list(self.parameter.keys), "start": self.parameter.first}
        limits = {"range": [self.parameter.low, self.parameter.high], "seen": self.seen}
        return {**named, "value": self.value, "error": self.error, "low": self.low, "high": self.high, **limits}


@dataclass(frozen=True)
class Fit:
    """The result of a fit.

    Attributes:
        estimates: one a parameter.
        residuals: (m,) at the best values. noise: their standard deviation, in the units of the problem's sigma.
        correlation: (p, p) of the estimates.
        remarks: sentences on what the data do not tell.
        evaluations: simulations that it took. seconds: wall time.
        ends: (starts, p) where each start led to. costs: (starts,) sum of squares there.
        interrupted: Ctrl-C came; estimates are then the best so far, without intervals.
        method: how the intervals were made.
    """

    estimates: tuple[Estimate, ...]
    residuals: Array
    noise: float
    correlation: Array
    remarks: tuple[str, ...] = ()
    evaluations: int = 0
    seconds: float = 0.0
    ends: Array = field(default_factory=lambda: np.zeros((0, 0)))
    costs: Array = field(default_factory=lambda: np.zeros(0))
    interrupted: bool = False
    method: str = "jacobian"

    @property
    def x(self) -> Array:
        """(p,) the best values."""
        return np.array([estimate.value for estimate in self.estimates])


def fit(
    problem: Fittable,
    *,
    starts: int = 3,
    loss: str = "linear",
    bootstrap: int = 0,
    trials: int = 0,
    level: float = intervals.LEVEL,
    seed: int = 0,
    on_progress: Progress | None = None,
) -> Fit:
    """Least squares of simulated against measured motion.

    Args:
        problem: what was measured, and what is to be found.
        starts: searches, from the parameters' first values and from the best of points all over their ranges.
        loss: ``linear``, or one that outliers move less: ``soft_l1``, ``huber``, ``cauchy``.
        bootstrap: resampled data sets for the intervals; 0 for intervals from the Jacobian.
        trials: of Optuna before the search, for problems with many local minima; 0 for none.
        level: of the intervals, above 0 and below 1.
        seed: of everything that is drawn.
        on_progress: told after every simulation.

    Raises:
        InvalidInputError: an option is not allowed; trials without Optuna; see also :meth:`Problem.residuals`.
    """
    checks.integer("starts", starts, minimum=1)
    checks.integer("bootstrap", bootstrap, minimum=0)
    checks.integer("trials", trials, minimum=0)
    checks.integer("seed", seed, minimum=0)
    checks.one_of("loss", loss, LOSSES)
    if not 0.0 < checks.number("level", level) < 1.0:
        raise InvalidInputError(f"level must be above 0 and below 1, got {level!r}.")
    began = time.perf_counter()
    search = Search(problem, on_progress)
    rng = np.random.default_rng(seed)
    try:
        x, ends, costs, steps, scale = _find(search, starts, loss, trials, seed, rng)
        made = _judge(problem, search, x, steps, loss, scale, bootstrap, level, rng)
    except KeyboardInterrupt:
        if search.state.x is None:
            raise
        return _unfinished(problem, search, time.perf_counter() - began)
    estimates, residuals, spread, remarks = made
    return Fit(
        tuple(estimates),
        residuals,
        spread.noise,
        spread.correlation,
        tuple(remarks),
        search.state.done,
        time.perf_counter() - began,
        ends,
        costs,
        method="bootstrap" if bootstrap else "jacobian",
    )


def _find(
    search: Search, count: int, loss: str, trials: int, seed: int, rng: np.random.Generator
) -> tuple[Array, Array, Array, Array, float]:
    """The best values, where each start led to, steps for differences there, and the scale of a robust loss."""
    coarse = searching.COARSE * search.span
    begin = searching.starts(search, count, rng)
    if trials:
        search.state.phase = "trying (Optuna)"
        begin.append(searching.trials(search, trials, search.cost, seed))
    ends, costs, scale = [], [], 1.0
    total: Callable[[Array], float] = search.cost
    for k, first in enumerate(begin):
        search.state.phase = f"start {k + 1} of {len(begin)}"
        x = searching.descend(search, first, coarse)
        ends.append(x)
        costs.append(search.cost(x))
    best = ends[int(np.argmin(costs))]
    if loss != "linear":
        # the scale of what is an outlier comes from the fit in which they still count
        scale = searching.TUNING * max(searching.spread(search(best)), 1e-9)
        total = searching.robust_total(search, loss, scale)
        search.state.phase = "robust"
        best = min((searching.descend(search, x, coarse, loss, scale) for x in ends), key=total)
    search.state.phase = "refining"
    steps, rough = search.steps(best)
    refined = searching.descend(search, best, steps, loss, scale)
    best = refined if total(refined) <= total(best) else best
    if rough.max() > 1e-3:  # no smooth bottom: stairs or leaps
        best = searching.settle(search, best, steps, total)
    return best, np.array(ends), np.array(costs), steps, scale


def _judge(
    problem: Fittable,
    search: Search,
    x: Array,
    steps: Array,
    loss: str,
    scale: float,
    draws: int,
    level: float,
    rng: np.random.Generator,
) -> tuple[list[Estimate], Array, intervals.Spread, list[str]]:
    """Estimates with intervals at the best values, and remarks."""
    parameters = search.parameters
    search.state.phase = "intervals"
    f = search(x)
    J = search.jacobian(x, steps)
    spread = intervals.spread_of(J, f, search.span, loss, scale)
    flats = [intervals.flat_range(search, x, j, spread.noise) for j in range(len(parameters))]
    seen = np.isfinite(spread.errors) & np.array(
        [high - low <= intervals.STAIR * p.span for (low, high), p in zip(flats, parameters, strict=True)]
    )
    t = intervals.quantile(level, len(f) - len(x))
    found = profile.Limits.none(len(x))
    if loss == "linear" and not draws and spread.noise > 0.0:
        search.state.phase = "profiles"
        profiler = profile.Profiler(search, x, J, spread.noise, spread.covariance, seen)
        found = profile.followed(profiler, spread.errors, flats, t)
        if found.better is not None:
            x, f = found.better, search(found.better)
            profiler = profile.Profiler(search, x, J, spread.noise, spread.covariance, seen)
            flats = [intervals.flat_range(search, x, j, spread.noise) for j in range(len(parameters))]
        beside = profile.beside_stairs(profiler, flats, t)
        found = found.wider(*beside)
    x = x.copy()
    for j, (low, high) in enumerate(flats):
        if high - low < intervals.STAIR * search.span[j]:
            x[j] = 0.5 * (low + high)  # on a stair every value is as good, so the middle errs least
    lows, highs = x - t * spread.errors, x + t * spread.errors
    if draws:
        groups = _groups(problem)
        w = searching.weights(loss, (f / scale) ** 2)
        drawn = intervals.bootstrap(search, x, J, groups, draws, rng, w)
        lows, highs = np.quantile(drawn, [0.5 * (1.0 - level), 0.5 * (1.0 + level)], axis=0)
    estimates = []
    for j, parameter in enumerate(parameters):
        low, high = flats[j]
        error = float(spread.errors[j]) if seen[j] else np.inf
        if not seen[j]:
            # what the simulation does not change at all is certain; beyond it only the range is
            wide = high - low > intervals.STAIR * parameter.span
            limits = (low, high) if wide else (parameter.low, parameter.high)
        elif found.followed[j]:
            limits = (min(found.low[j], x[j]), max(found.high[j], x[j]))
            error = (limits[1] - limits[0]) / (2.0 * t)
        else:
            limits = (min(found.low[j], lows[j] - (x[j] - low)), max(found.high[j], highs[j] + (high - x[j])))
        a, b = max(limits[0], parameter.low), min(limits[1], parameter.high)
        estimates.append(Estimate(parameter, float(x[j]), error, float(a), float(b), bool(seen[j])))
    remarks = intervals.remarks(parameters, spread, flats, x)
    waves = _waves(problem, f)
    if waves > WAVES:
        remarks.append(
            f"What is left over is no noise: neighbouring differences have a correlation of {waves:.2f}, so the scene "
            f"misses something that the data hold, and the intervals are too narrow."
        )
    return estimates, f, spread, remarks


def _groups(problem: Fittable) -> NDArray[np.int64]:
    """(m,) what the bootstrap draws together: a track, or all that was measured of a body at one moment."""
    if len(np.unique(problem.labels)) >= MOST_TRACKS_ALONE:
        keys = np.stack([problem.labels, np.zeros_like(problem.moments)], axis=1)
    else:
        keys = np.stack([problem.labels, problem.moments], axis=1)
    return np.asarray(np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1), np.int64)


def _waves(problem: Fittable, f: Array) -> float:
    """Correlation of residuals that follow each other in time, over all runs of growing times."""
    moments = problem.moments
    follows = (problem.labels[1:] == problem.labels[:-1]) & (moments[1:] >= moments[:-1])
    stride = _stride(moments)
    a, b = f[:-stride], f[stride:]
    if stride == 1:
        a, b = a[follows], b[follows]
    size = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / size if size > 0.0 and len(a) > 10 else 0.0


def _stride(moments: Array) -> int:
    """How many residuals there are at the first moment: from one to the same of the next sample."""
    changes = np.flatnonzero(np.diff(moments) != 0.0)
    return int(changes[0]) + 1 if len(changes) else 1


def _unfinished(problem: Fittable, search: Search, seconds: float) -> Fit:
    x = search.state.x
    assert x is not None
    f = np.asarray(problem.residuals(x))
    unknown = [Estimate(p, float(v), np.inf, p.low, p.high, True) for p, v in zip(search.parameters, x, strict=True)]
    noise = float(np.sqrt(f @ f / max(1, len(f) - len(x))))
    p = len(x)
    return Fit(tuple(unknown), f, noise, np.eye(p), (), search.state.done, seconds, interrupted=True)
