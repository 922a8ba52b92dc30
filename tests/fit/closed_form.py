"""A crate that is pulled until it lets go, in closed form: a fit takes little time, so that many of them can tell how
often an interval holds the truth. It has what makes the simulated one hard: stairs, and parameters that motion ties."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stiction.fit import Parameter

Array = NDArray[np.float64]
G = 9.81


class PushAndRelease:
    """The crate of the manual's example; it lets go in a certain step, or at any time.

    Args:
        measured: (n,) m, ways at ``times`` (n,) in s; None for the exact ones of ``truth``.
        mass: kg. growth: N/s of the pull. until: s, when it ends.
        dt: s; the crate lets go at a multiple of it, at any time if 0.
    """

    parameters = (Parameter("static", ("static",), 0.4, 0.6), Parameter("dynamic", ("dynamic",), 0.25, 0.45))

    def __init__(
        self, times: Array, measured: Array, *, mass: float, growth: float, until: float, dt: float, sigma: float = 1e-3
    ) -> None:
        self.moments, self.measured, self.sigma = times, measured, sigma
        self.mass, self.growth, self.until, self.dt = mass, growth, until, dt
        self.labels = np.zeros(len(times), dtype=np.int64)

    def ways(self, x: Sequence[float] | Array) -> Array:
        """(n,) m at the times of the samples."""
        static, dynamic = (float(value) for value in x)
        begin = static * self.mass * G / self.growth
        if self.dt > 0.0:
            begin = self.dt * np.ceil(begin / self.dt)
        if begin >= self.until:
            return np.zeros(len(self.moments))
        jerk, left, slow = self.growth / self.mass, begin, dynamic * G
        # a dynamic friction above the static one holds it until the pull is above that too
        left = max(begin, slow / jerk)
        if left >= self.until:
            return np.zeros(len(self.moments))
        t = np.minimum(self.moments, self.until)
        s = np.maximum(t - left, 0.0)
        pulled = jerk * (left * s**2 / 2.0 + s**3 / 6.0) - slow * s**2 / 2.0
        s = self.until - left
        speed = jerk * (left * s + s**2 / 2.0) - slow * s
        s = np.maximum(self.moments - self.until, 0.0)
        s = np.minimum(s, speed / slow) if slow > 0.0 else s
        return np.asarray(pulled + speed * s - slow * s**2 / 2.0)

    def residuals(self, x: Sequence[float] | Array) -> Array:
        """(n,) in units of sigma."""
        return (self.ways(x) - self.measured) / self.sigma
