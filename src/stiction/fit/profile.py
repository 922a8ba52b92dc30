"""Intervals from the cost itself, where its bottom is no parabola: the profile likelihood.

The profile of a parameter is the lowest cost at each of its values, all other parameters free. Where the cost is
smooth and the data are many it is a parabola, and the Jacobian's covariance says where it has risen by t^2 noise
variances. A simulation has stairs (a crate lets go in a certain step) and bent valleys (a faster start with more
friction), so the ends of every interval are tried: if the cost there is not what the parabola says, the profile is
followed until it has risen by t^2. All values of the *other* parameters that are passed on the way and fit as well
belong to their intervals: on the next stair of static friction another dynamic friction is the best.

Venzon, Moolgavkar (1988), A method for computing profile-likelihood-based confidence intervals, Applied Statistics 37.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stiction.fit.parameters import Array
from stiction.fit.search import Search

TRUSTED = (0.6, 1.6)
"""The rise of the cost at the end of an interval, over the t^2 that it should be, between which nothing is followed."""
STRIDE = 0.25
"""Of the half width of the Jacobian's interval: so far apart are the values at which the profile is looked at."""
STRIDES = 40
"""At most, to either side."""
BEYOND = 3
"""Values one after the other where the cost is too high, before the end is believed: stairs go up and down."""
HALVINGS = 5
"""Of the last stride, for the end."""
STEEP, BESIDE, WITHIN = 0.1, 0.25, 0.65
"""A stair counts from this share of the interval's half width; so far beyond its end, in its widths, is the next; and
so many stairs the truth may be away: half a one if the nearest is found, a little more where noise decides."""
BETTER = 0.01
"""Variances of the noise by which the cost must be lower to count as better."""
ROUNDS = 3
"""Gauss-Newton steps of the other parameters at each value."""


@dataclass
class Profile:
    """The best values found at many values of one parameter.

    Attributes:
        j: number of the parameter. points: (p,) each. rises: their cost over the lowest, in variances of the noise.
    """

    j: int
    points: list[Array] = field(default_factory=list)
    rises: list[float] = field(default_factory=list)


class Profiler:
    """Profiles about the best values.

    Args:
        search: the function. x: (p,) the best values. J: (m, p) there. noise: standard deviation of the residuals.
        covariance: (p, p) of the Jacobian. free: (p,) which parameters the data see; others stay where they are.

    Attributes:
        lowest: cost of the best values.
    """

    def __init__(
        self, search: Search, x: Array, J: Array, noise: float, covariance: Array, free: NDArray[np.bool_]
    ) -> None:
        self.search, self.J, self.noise = search, J, noise
        self.covariance = np.where(np.isfinite(covariance), covariance, 0.0)
        self.free = np.flatnonzero(free)
        self.x, self.lowest = x.copy(), search.cost(x)

    def rise(self, j: int, value: float, near: Array | None = None) -> tuple[float, Array]:
        """Lowest cost over that of the best values, in variances of the noise, where parameter j has that value.

        Args:
            j: number of the parameter. value: of it.
            near: (p,) where the others begin; as the covariance says if left out.

        Returns:
            The rise, below 0 where something better was found; and the values (p,).
        """
        search, others = self.search, self.free[self.free != j]
        at = self.x.copy() if near is None else near.copy()
        if near is None and self.covariance[j, j] > 0.0:
            at[others] += self.covariance[others, j] / self.covariance[j, j] * (value - self.x[j])
        at[j] = value
        at = np.clip(at, search.low, search.high)
        f = search(at)
        cost = float(f @ f)
        span, columns = search.span[others], self.J[:, others]
        for _ in range(ROUNDS if len(others) else 0):
            moved = at.copy()
            moved[others] += np.linalg.lstsq(columns * span, -f, rcond=1e-8)[0] * span
            moved = np.clip(moved, search.low, search.high)
            g = search(moved)
            lower = float(g @ g)
            if lower >= cost:
                break
            gained = cost - lower
            at, f, cost = moved, g, lower
            if gained < 0.01 * self.noise**2:
                break
        return (cost - self.lowest) / self.noise**2, at

    def trusted(self, j: int, half: float, threshold: float) -> bool:
        """Whether the cost has risen by about the threshold at ``half`` to either side, as that of a parabola."""
        for value in (self.x[j] - half, self.x[j] + half):
            if self.search.low[j] < value < self.search.high[j]:
                rise, _ = self.rise(j, value)
                if not TRUSTED[0] * threshold <= rise <= TRUSTED[1] * threshold:
                    return False
        return True

    def follow(self, j: int, stride: float, threshold: float) -> Profile:
        """The profile of parameter j to either side until it stays above the threshold or the range ends."""
        profile = Profile(j, [self.x.copy()], [0.0])
        for way in (-1.0, 1.0):
            last_in, near, above = float(self.x[j]), self.x.copy(), 0
            first_out = last_in
            for k in range(1, STRIDES + 1):
                value = float(np.clip(self.x[j] + way * k * stride, self.search.low[j], self.search.high[j]))
                rise, at = min(self.rise(j, value, near), self.rise(j, value), key=lambda found: found[0])
                profile.points.append(at)
                profile.rises.append(rise)
                if rise <= threshold:
                    last_in, near, above = value, at, 0
                else:
                    first_out = value if above == 0 else first_out
                    above += 1
                if above == BEYOND or value in (self.search.low[j], self.search.high[j]):
                    break
            if above == 0:
                continue
            for _ in range(HALVINGS):
                value = 0.5 * (last_in + first_out)
                rise, at = self.rise(j, value, near)
                profile.points.append(at)
                profile.rises.append(rise)
                if rise <= threshold:
                    last_in = value
                else:
                    first_out = value
        return profile


@dataclass(frozen=True)
class Limits:
    """What the profiles say.

    Attributes:
        low, high: (p,) ends; infinite, the wrong way round, where no profile says anything.
        followed: (p,) whether the profile of a parameter was followed.
        better: (p,) values with a lower cost than the best so far; None if there were none.
    """

    low: Array
    high: Array
    followed: NDArray[np.bool_]
    better: Array | None = None

    @classmethod
    def none(cls, p: int) -> Limits:
        """Of p parameters, none of which was followed."""
        return cls(np.full(p, np.inf), np.full(p, -np.inf), np.zeros(p, dtype=bool))

    def wider(self, low: Array, high: Array) -> Limits:
        """The same, at least as far as from ``low`` to ``high``, (p,) each."""
        return replace(self, low=np.minimum(self.low, low), high=np.maximum(self.high, high))


def followed(profiler: Profiler, errors: Array, flats: list[tuple[float, float]], t: float) -> Limits:
    """Try the ends of all intervals, and follow the profiles of those where the cost is not what it should be.

    Args:
        profiler: about the best values. errors: (p,) standard errors. flats: from where to where each parameter
            changes nothing: its stair.
        t: standard errors to either side.
    """
    profiles = []
    for j in map(int, profiler.free):
        half = max(t * float(errors[j]), 0.5 * (flats[j][1] - flats[j][0]))
        if not profiler.trusted(j, half, t * t):
            profiles.append(profiler.follow(j, STRIDE * half, t * t))
    found = Limits.none(len(profiler.x))
    points = [(rise, point, made.j) for made in profiles for rise, point in zip(made.rises, made.points, strict=True)]
    if not points:
        return found
    least = min(rise for rise, _, _ in points)
    better = None
    if least < -BETTER:
        better = next(point for rise, point, _ in points if rise == least)
    given, hidden = _given_one(profiler.covariance), ~np.isin(np.arange(len(profiler.x)), profiler.free)
    low, high = found.low, found.high
    for rise, point, j in points:
        if rise - least <= t * t:
            # about each point the others may still lie where the rise comes to t^2
            room = np.sqrt(t * t - (rise - least)) * given[j]
            room[j] = 0.0
            room[hidden] = 0.0
            low, high = np.minimum(low, point - room), np.maximum(high, point + room)
    found.followed[[made.j for made in profiles]] = True
    return Limits(low, high, found.followed, better)


def beside_stairs(profiler: Profiler, flats: list[tuple[float, float]], t: float) -> tuple[Array, Array]:
    """(p,) ends that are left because the best stair may not be the right one.

    What is measured lets go between two steps. The stair that comes nearest to it is then about half a stair off at
    most, and so are the other parameters, of what they change from this stair to the next.

    Args:
        profiler: about the best values. flats: the stair of each parameter. t: standard errors to either side.
    """
    x, free = profiler.x, profiler.free
    found = Limits.none(len(x))
    low, high, given = found.low, found.high, _given_one(profiler.covariance)
    for j in map(int, free):
        a, b = flats[j]
        if b - a < STEEP * t * np.sqrt(profiler.covariance[j, j]):
            continue
        room = np.zeros(len(x))
        room[free] = t * given[j, free]
        for value, end in ((a - BESIDE * (b - a), a - WITHIN * (b - a)), (b + BESIDE * (b - a), b + WITHIN * (b - a))):
            if profiler.search.low[j] < value < profiler.search.high[j]:
                point = x + WITHIN * (profiler.rise(j, value)[1] - x)
                point[j], room[j] = end, 0.0
                low, high = np.minimum(low, point - room), np.maximum(high, point + room)
    return low, high


def _given_one(covariance: Array) -> Array:
    """(p, p) standard error of parameter k where j is given, in row j: what of its variance j does not explain."""
    variances = np.diag(covariance)
    with np.errstate(invalid="ignore", divide="ignore"):
        explained = covariance**2 / variances[:, None]
    left = variances[None, :] - np.nan_to_num(explained, nan=0.0, posinf=0.0)
    return np.asarray(np.sqrt(np.maximum(np.where(np.isfinite(left), left, 0.0), 0.0)))
