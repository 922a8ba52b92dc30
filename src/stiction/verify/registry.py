"""All cases in order, and how they are run."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable
from typing import NamedTuple

from stiction import checks
from stiction.errors import InvalidInputError, IterationLimitWarning, SimulationError
from stiction.verify import (
    cases_driven,
    cases_dynamics,
    cases_edges,
    cases_faces,
    cases_impact,
    cases_laws,
    cases_limits,
    cases_motion,
    cases_rolling,
    cases_sliding,
    cases_slopes,
    cases_stacks,
    cases_tops,
    cases_wedges,
)
from stiction.verify.case import Case, Measurement, Result
from stiction.world import World

DEFAULT_DT = 1.0 / 60.0
"""s, that of a World nobody sets up."""
LARGEST_DT = 0.05
"""s: beyond it what the cases time takes only a few steps."""

CASES: tuple[type[Case], ...] = (
    cases_sliding.StoppingDistance,
    cases_sliding.ThinSheet,
    cases_sliding.SpinDownOnCorners,
    cases_slopes.ThresholdAngle,
    cases_slopes.InclineSliding,
    cases_slopes.InclineSideways,
    cases_slopes.TwoCoefficients,
    cases_slopes.BreakAway,
    cases_slopes.TipOrSlide,
    cases_slopes.Ladder,
    cases_driven.PushAndRelease,
    cases_driven.PushToTip,
    cases_driven.PulledBlock,
    cases_driven.StickSlip,
    cases_driven.BeltDrop,
    cases_driven.BeltCrossing,
    cases_driven.CrateOnLorry,
    cases_driven.CrateOnTurntable,
    cases_driven.AcceleratingPlate,
    cases_driven.BallOnTurntable,
    cases_rolling.SlideToRoll,
    cases_rolling.Backspin,
    cases_rolling.RollingDown,
    cases_rolling.SlowRoll,
    cases_rolling.RollingResistance,
    cases_rolling.RollingResistanceOnSlope,
    cases_rolling.TorsionalResistance,
    cases_impact.BouncingBall,
    cases_impact.ObliqueImpact,
    cases_impact.Superball,
    cases_impact.TwoBodies,
    cases_impact.Momentum,
    cases_impact.BilliardThrow,
    cases_impact.NewtonsCradle,
    cases_impact.RodImpact,
    cases_impact.ImpactEnergy,
    cases_motion.FreeFall,
    cases_motion.ConstantForce,
    cases_motion.SpinningTop,
    cases_motion.TumblingPeriod,
    cases_motion.Precession,
    cases_motion.EnergyLedger,
    cases_motion.SlideToRollEnergy,
    cases_limits.CreepBelowThreshold,
    cases_limits.SlideAndSpinOnCorners,
    cases_limits.SlideAndSpinOfAFace,
    cases_limits.SpinDownOfAFace,
    cases_limits.TowerOfTen,
    cases_limits.HeavyOnLight,
    cases_stacks.SinkOfSoftContacts,
    cases_stacks.CrookedTower,
    cases_stacks.Pyramid,
    cases_stacks.HeavyOnTop,
    cases_faces.BrakeDistances,
    cases_faces.DiscEndsTogether,
    cases_faces.BreakAwayWithTorque,
    cases_wedges.Wedge,
    cases_wedges.TwoCards,
    cases_wedges.ThreeLogs,
    cases_wedges.Arch,
    cases_dynamics.SlidingRod,
    cases_dynamics.FollowAndDraw,
    cases_dynamics.ShakenPlate,
    cases_dynamics.BallsOnABox,
    cases_dynamics.DominoWave,
    cases_dynamics.KaplaTower,
    cases_laws.StribeckStop,
    cases_laws.GrainOnSlope,
    cases_laws.TyreBrush,
    cases_laws.TyreMagic,
    cases_laws.PullOff,
    cases_edges.BalanceOnAnEdge,
    cases_tops.TippeTop,
    cases_tops.Rattleback,
)


class Summary(NamedTuple):
    """How many rows of a verification ended how; together they are all rows.

    Attributes:
        passed: within their tolerance, surprises not counted.
        failed: outside it, and nothing excuses them.
        known_limits: outside it, as their case says of this solver.
        surprises: known limits that passed.
    """

    passed: int
    failed: int
    known_limits: int
    surprises: int


def all_cases() -> tuple[Case, ...]:
    """One of each case, in the order in which they are run."""
    return tuple(case() for case in CASES)


def run(
    names: Iterable[str] | None = None,
    solver: str | None = None,
    dt: float = DEFAULT_DT,
    progress: Callable[[str], None] | None = None,
) -> list[Result]:
    """Run cases and judge what they measured.

    A solver that hits its iteration limit says so with a warning; here that would say nothing that the numbers do not,
    so it becomes a note (:attr:`Result.reason`) on the rows of the case. A world that blows up is a row that failed.

    Args:
        names: of cases; all that speak of the solver if left out. They are run in the order of :func:`all_cases`, each
            once.
        solver: that is measured; that of a :class:`stiction.World` nobody sets up if left out.
        dt: time step, s, at most 0.05.
        progress: is called with the name of each case before it is run.

    Raises:
        InvalidInputError: a name is not that of a case (the nearest one is named) or that of a case which does not
        speak
            of the solver, the solver is none, or dt is not above 0 and at most 0.05 s.
        NotYetError: this version does not have the solver.
    """
    if checks.positive("dt", dt, "s") > LARGEST_DT:
        raise InvalidInputError(f"dt must be {LARGEST_DT:g} s or less, got {dt!r}.")
    solver = World(solver=solver, dt=dt).solver  # raises where there is no such solver
    cases = _chosen(names, solver)
    results: list[Result] = []
    for case in cases:
        if progress is not None:
            progress(case.name)
        results += _run_one(case, solver, dt)
    return results


def summarise(results: Iterable[Result]) -> Summary:
    """Count rows by how they ended."""
    counts = [0, 0, 0, 0]
    for row in results:
        counts[2 * row.known_limit + (row.passed == row.known_limit)] += 1
    passed, failed, known_limits, surprises = counts
    return Summary(passed, failed, known_limits, surprises)


def _chosen(names: Iterable[str] | None, solver: str) -> list[Case]:
    cases = {case.name: case for case in all_cases()}
    if names is None:
        return [case for case in cases.values() if solver in case.solvers]
    wanted = [names] if isinstance(names, str) else list(names)
    for name in wanted:
        if name not in cases:
            hint = checks.nearest(name, cases)
            raise InvalidInputError(f"case must be one of the {len(cases)} of all_cases(), got {name!r}{hint}.")
        if solver not in cases[name].solvers:
            raise InvalidInputError(
                f"case {name!r} speaks of {' and '.join(cases[name].solvers)} only, got solver {solver!r}."
            )
    return [case for name, case in cases.items() if name in wanted]


def _run_one(case: Case, solver: str, dt: float) -> list[Result]:
    """All rows of a case, the last one failed if its world blew up."""
    measurements: list[Measurement] = []
    blown_up: str | None = None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", IterationLimitWarning)
        try:
            measurements.extend(case.measure(solver, dt))
        except SimulationError as error:
            blown_up = str(error)
    for warning in caught:
        if not issubclass(warning.category, IterationLimitWarning):
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    hits = sum(issubclass(warning.category, IterationLimitWarning) for warning in caught)
    note = f"the solver hit its iteration limit in {hits} of the worlds of this case" if hits else None
    rows = [case.judge(measurement, solver, note) for measurement in measurements]
    if blown_up is not None:
        rows.append(case.judge(Measurement("state", 0.0, math.nan, 0.0), solver, blown_up))
    return rows
