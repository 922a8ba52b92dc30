"""All trials in all engines: each engine in a process of its own, one after the other."""

from __future__ import annotations

import platform
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.verify.against import trials_rolling, trials_sliding, trials_stacks
from stiction.verify.against.columns import COLUMNS, OWN, column
from stiction.verify.against.trial import Score, Trial

TRIALS: tuple[type[Trial], ...] = (*trials_sliding.TRIALS, *trials_rolling.TRIALS, *trials_stacks.TRIALS)

LARGEST_DT = 0.05
"""s"""

Progress = Callable[[str], None]


def all_trials() -> tuple[Trial, ...]:
    """One of each, in order."""
    return tuple(trial() for trial in TRIALS)


def trials_named(names: Iterable[str]) -> list[Trial]:
    """Those of the names in the order of :func:`all_trials`; all, if there are no names.

    Raises:
        InvalidInputError: a name is none of a trial.
    """
    known = {trial.name: trial for trial in all_trials()}
    wanted = [checks.one_of("trial", name, known) for name in names]
    return [trial for name, trial in known.items() if name in wanted or not wanted]


@dataclass
class Comparison:
    """Scores of engines in trials, and how they were come by.

    Attributes:
        trials: in order. engines: columns in order, those that could be asked.
        missing: engines that are not installed, and how to get them.
        dt: s between frames.
        solver: of stiction.
        versions, settings: of each engine.
        scores: by trial and engine.
    """

    trials: list[Trial]
    engines: list[str]
    missing: dict[str, str]
    dt: float
    solver: str
    versions: dict[str, str] = field(default_factory=dict)
    settings: dict[str, str] = field(default_factory=dict)
    scores: dict[tuple[str, str], Score] = field(default_factory=dict)

    def score(self, trial: str, engine: str) -> Score:
        """Of one engine in one trial."""
        return self.scores[trial, engine]

    def passed(self, engine: str) -> tuple[int, int]:
        """Trials that an engine passed, and those it could be asked."""
        asked = [s.passed for s in self.scores.values() if s.engine == engine and s.passed is not None]
        return sum(asked), len(asked)

    def better(self, trial: str) -> list[str]:
        """Engines whose error is smaller than that of stiction by a tenth of the tolerance or more."""
        own = self.scores.get((trial, OWN))
        if own is None or own.passed is None:
            return []
        mark = own.error - 0.1 * own.tolerance
        return [e for e in self.engines if e != OWN and self.scores[trial, e].error <= mark]

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "dt": self.dt,
            "solver": self.solver,
            "python": platform.python_version(),
            "engines": [
                {"name": name, "version": self.versions[name], "settings": self.settings[name]} for name in self.engines
            ],
            "missing": self.missing,
            "trials": [
                {
                    "name": trial.name,
                    "title": trial.title,
                    "formula": trial.formula,
                    "source": trial.source,
                    "unit": trial.unit,
                    "relative": trial.relative,
                    "tolerance": trial.tolerance,
                    "tolerance_reason": trial.tolerance_reason,
                    "scores": [self.score(trial.name, engine).as_dict() for engine in self.engines],
                }
                for trial in self.trials
            ],
        }


def compare(
    engines: Sequence[str],
    names: Iterable[str] = (),
    dt: float = 1.0 / 60.0,
    solver: str | None = None,
    isolated: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Ask stiction and other engines the same questions.

    Args:
        engines: columns to the right of stiction; those that are not installed are named in the result and left out.
        names: of trials; all if empty.
        dt: s between frames, at most 0.05; see :mod:`columns` for the steps that engines take in it.
        solver: of stiction; that of a World nobody sets up if left out.
        isolated: each engine in a process of its own, so that one that crashes ends its own trial only.
        progress: told what is about to run.

    Raises:
        InvalidInputError: a name is that of no engine or trial, or dt is out of its range.
        NotYetError: this version does not have the solver.
    """
    from stiction.world import World

    if checks.positive("dt", dt, "s") > LARGEST_DT:
        raise InvalidInputError(f"dt must be {LARGEST_DT:g} s or less, got {dt!r}.")
    solver = World(solver=solver, dt=dt).solver
    asked = [OWN, *(name for name in dict.fromkeys(engines) if name != OWN)]
    kinds = {name: column(name).kind for name in asked}
    missing = {name: f"pip install {kind.distribution}" for name, kind in kinds.items() if not kind.available()}
    present = [name for name in asked if name not in missing]
    found = Comparison(trials_named(names), present, missing, dt, solver)
    for name in present:
        found.versions[name] = kinds[name].version()
        found.settings[name] = COLUMNS[name].settings(dt)
        if name == OWN:
            found.settings[name] = found.settings[name].replace(kinds[name].notes, f"solver {solver!r}")
        if progress is not None:
            progress(f"{name} {found.versions[name]}")
        for score in _ask(name, found, isolated, progress):
            found.scores[score.trial, name] = score
    return found


def _ask(name: str, comparison: Comparison, isolated: bool, progress: Progress | None) -> Iterable[Score]:
    own = comparison.solver if name == OWN else None
    names = [trial.name for trial in comparison.trials]
    if isolated:
        from stiction.verify.against.worker import ask_apart

        yield from ask_apart(name, names, comparison.dt, own, progress)
    else:
        for trial in comparison.trials:
            yield ask(name, trial, comparison.dt, own)


def ask(name: str, trial: Trial, dt: float, solver: str | None = None) -> Score:
    """One engine in one trial, in this process."""
    chosen = column(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # engines warn of graphics, of names and of numbers that the score tells better
        score = trial.play(chosen.kind(solver), dt, chosen.substeps(dt))
    score.engine = name
    return score
