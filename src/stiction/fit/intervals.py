"""How well the data know a parameter: standard errors, intervals, and what they do not see at all.

Near the best values the residuals are f + J d, so that d spreads like C = s^2 (J^T J)^-1, s^2 = |f|^2 / (m - p) (for
a robust loss the sandwich of Huber, White). The singular values of J, its columns scaled by the ranges of the
parameters, tell which directions in parameter space the data see: along one whose singular value is below the noise,
the parameters can go from one end of their ranges to the other and nobody would notice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiction.fit.parameters import Array, Parameter
from stiction.fit.search import Search, weights

LEVEL = 0.9
"""Of an interval: so often it holds the true value."""
UNSEEN = 0.5
"""A parameter whose standard error is this share of its range or more is not seen."""
SAME = 0.01
"""Change of the sum of squares in units of the noise's variance that counts as none."""
FINE, HALVINGS = 1e-5, 17
"""What changes within this share of the range is not flat; otherwise so many halvings find where it begins to."""
STAIR = 0.1
"""Share of the range: what is flat further than that is not a stair but a parameter that is not seen."""


@dataclass(frozen=True)
class Spread:
    """What the Jacobian says.

    Attributes:
        covariance: (p, p), infinite for directions that are not seen. noise: standard deviation of the residuals.
        singular: (p,) singular values of the scaled Jacobian over the noise, largest first. directions: (p, p) rows.
    """

    covariance: Array
    noise: float
    singular: Array
    directions: Array

    @property
    def errors(self) -> Array:
        """(p,) standard errors."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """(p, p); 0 where an error is not finite."""
        e = self.errors
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.nan_to_num(self.covariance / np.outer(e, e), posinf=0.0, neginf=0.0)


def spread_of(J: Array, f: Array, span: Array, loss: str = "linear", scale: float = 1.0) -> Spread:
    """Covariance and singular values.

    Args:
        J: (m, p) Jacobian. f: (m,) residuals. span: (p,) ranges of the parameters.
        loss, scale: as in the search.
    """
    m, p = J.shape
    w = weights(loss, (f / scale) ** 2)
    noise = float(np.sqrt(np.sum(w * f * f) / max(1, m - p)))
    scaled = np.sqrt(w)[:, None] * J * span
    _, values, V = np.linalg.svd(scaled, full_matrices=False)
    seen = values * UNSEEN > noise if noise > 0.0 else values > 1e-9 * max(values.max(), 1e-300)
    inverse = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    if loss == "linear":
        inner = V.T @ np.diag((noise * inverse) ** 2) @ V
    else:
        bread = V.T @ np.diag(inverse**2) @ V
        meat = (J * span * (w * f)[:, None]).T @ (J * span * (w * f)[:, None]) * m / max(1, m - p)
        inner = bread @ meat @ bread
    # Along a direction that is hardly seen, the parameters still stay in their ranges: what has the largest share in it
    # goes through its whole range at most, and takes those with smaller shares along.
    reach = 1.0 / np.abs(V[~seen]).max(axis=1, initial=1e-300)
    blind = np.minimum(reach, noise / np.maximum(values[~seen], 1e-300))
    inner = inner + V[~seen].T @ np.diag(blind**2) @ V[~seen]
    covariance = inner * np.outer(span, span)
    hidden = (V[~seen] ** 2).sum(axis=0) > 0.1  # a parameter with a share in a direction that is not seen
    hidden |= np.sqrt(np.diag(inner)) > UNSEEN
    covariance[hidden, :] = covariance[:, hidden] = 0.0
    covariance[hidden, hidden] = np.inf
    return Spread(covariance, noise, values / noise if noise > 0.0 else np.full(p, np.inf), V)


def flat_range(search: Search, x: Array, j: int, noise: float) -> tuple[float, float]:
    """From where to where a parameter can go, the others as they are, without any change that the data would notice."""
    base, threshold = search.cost(x), SAME * max(noise, 1e-12) ** 2

    def same(value: float) -> bool:
        other = x.copy()
        other[j] = value
        return abs(search.cost(other) - base) <= threshold

    limits = []
    for end in (float(search.low[j]), float(search.high[j])):
        inner, outer = float(x[j]), end
        if inner == outer or same(outer):
            limits.append(outer)
            continue
        if not same(inner + FINE * (outer - inner)):
            limits.append(inner)
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (inner + outer)
            if same(middle):
                inner = middle
            else:
                outer = middle
        limits.append(inner)
    return limits[0], limits[1]


def quantile(level: float, freedom: int) -> float:
    """Standard errors to either side that make an interval of that level (Student)."""
    from scipy.stats import t

    return float(t.ppf(0.5 * (1.0 + level), max(1, freedom)))


def bootstrap(
    search: Search, x: Array, J: Array, groups: NDArray[np.int64], draws: int, rng: np.random.Generator, w: Array
) -> Array:
    """(draws, p) values that data with resampled groups lead to: three Gauss-Newton steps each, with the same J.

    Args:
        search: the function. x: (p,) best values. J: (m, p) there.
        groups: (m,) number of the group of each residual: what belongs together is drawn together.
        draws: how often. rng: random numbers. w: (m,) how much each residual counts.
    """
    found = np.empty((draws, len(x)))
    members = int(groups.max()) + 1
    search.state.phase = "resampling"
    for k in range(draws):
        counts = np.bincount(rng.integers(0, members, members), minlength=members)
        weight = counts[groups] * w
        A = J * np.sqrt(weight)[:, None]
        now = x.copy()
        for _ in range(3):
            step = np.linalg.lstsq(A * search.span, -np.sqrt(weight) * search(now), rcond=1e-6)[0] * search.span
            now = np.clip(now + step, search.low, search.high)
            if np.all(np.abs(step) < 1e-4 * search.span):
                break
        found[k] = now
    return found


def remarks(parameters: list[Parameter], spread: Spread, flats: list[tuple[float, float]], x: Array) -> list[str]:
    """One sentence for each thing that the data do not tell."""
    found = []
    errors, correlation = spread.errors, spread.correlation
    told: set[int] = set()
    for j, parameter in enumerate(parameters):
        low, high = flats[j]
        if high - low > STAIR * parameter.span:
            told.add(j)
            found.append(
                f"The data do not see {parameter.name}: from {low:.4g} to {high:.4g} nothing that was measured changes."
            )
    for row, value in zip(spread.directions[::-1], spread.singular[::-1], strict=True):
        if value * UNSEEN > 1.0:
            break
        shares = [j for j in np.argsort(-np.abs(row)) if row[j] ** 2 > 0.1 and j not in told]
        told.update(shares)
        if len(shares) > 1:
            names = ", ".join(parameters[j].name for j in shares)
            found.append(f"The data see {names} only together: one can make up for the other.")
        elif shares:
            found.append(
                f"The data hardly see {parameters[shares[0]].name}: over its whole range the motion changes less than "
                f"the noise."
            )
    for j, parameter in enumerate(parameters):
        if j in told:
            continue
        for k in range(j):
            if abs(correlation[j, k]) > 0.98:
                found.append(
                    f"{parameters[k].name} and {parameter.name} are hard to tell apart: their correlation is "
                    f"{correlation[j, k]:.3f}."
                )
        edge = 1e-3 * parameter.span
        if min(x[j] - parameter.low, parameter.high - x[j]) < edge and np.isfinite(errors[j]):
            end = "lower" if x[j] - parameter.low < edge else "upper"
            found.append(f"{parameter.name} is at the {end} end of its range, so its interval means little.")
    return found
