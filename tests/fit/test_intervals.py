"""Intervals hold the truth as often as they say: of parameters that motion ties together, and where a simulation lets
go in steps while the real thing does not."""

from __future__ import annotations

import numpy as np
import pytest

from stiction.fit import fit
from stiction.fit.intervals import UNSEEN, spread_of

from .closed_form import PushAndRelease

TIMES = np.arange(0.0, 5.0, 0.01)
CASE = {"mass": 100.0, "growth": 140.0, "until": 4.2}
"""The manual's example."""


def studied(count: int, truth: tuple[float, float], dt: float, seed: int) -> tuple[list[int], list[float], float]:
    """How many of ``count`` intervals held each parameter, how wide they were, and the last fit's correlation.

    The data let go at any time, whatever dt (s) the model has.
    """
    clean = PushAndRelease(TIMES, np.zeros_like(TIMES), dt=0.0, **CASE).ways(truth)
    rng = np.random.default_rng(seed)
    held, widths, correlation = np.zeros(2, dtype=int), np.zeros(2), 0.0
    for _ in range(count):
        made = fit(PushAndRelease(TIMES, clean + 1e-3 * rng.normal(size=len(TIMES)), dt=dt, **CASE), starts=1)
        for k, (found, true) in enumerate(zip(made.estimates, truth, strict=True)):
            held[k] += found.low <= true <= found.high
            widths[k] += (found.high - found.low) / count
        correlation = float(made.correlation[0, 1])
    return held.tolist(), widths.tolist(), correlation


def test_coupled_intervals_hold_the_truth_in_85_to_95_of_100() -> None:
    held, widths, correlation = studied(100, (0.52, 0.37), 0.0, 0)
    assert correlation < -0.95, "the motion ties the two together"
    assert all(85 <= count <= 95 for count in held), held
    assert widths[0] < 0.001 and widths[1] < 0.002, "an interval that holds everything would hold the truth too"


@pytest.mark.parametrize("truth", [(0.52, 0.37), (0.5213, 0.37)])
def test_intervals_hold_a_truth_that_lies_between_the_stairs_of_the_steps(truth: tuple[float, float]) -> None:
    dt = 0.005
    held, widths, _ = studied(30, truth, dt, 1)
    assert min(held) >= 25, held
    stair = CASE["growth"] * dt / (CASE["mass"] * 9.81)
    assert widths[0] < 3.0 * stair and widths[1] < 5.0 * stair


def test_a_small_share_in_what_is_not_seen_widens_an_interval() -> None:
    # the data see a + 0.2 b and, a thousand times worse than the noise, the rest: b is not known, and a no better than
    # a fifth of b's range
    rows = np.array([[1.0, 0.2], [-2e-5, 1e-4]])
    J = np.tile(100.0 * rows, (50, 1))
    f = np.random.default_rng(2).normal(size=100)
    spread = spread_of(J, f, np.ones(2))
    assert 0.1 < spread.errors[0] < UNSEEN and np.isinf(spread.errors[1])
