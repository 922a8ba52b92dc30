"""Contact problems that others collected, measured: every local solver after some sweeps, and the default method."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from stiction import checks
from stiction.errors import InvalidInputError, StictionError
from stiction.problems import ContactProblem, Solution, solve
from stiction.record.interrupts import interrupts_held

COUNTS = (10, 100, 1000)
"""Sweeps after which the error of a local solver is taken."""
ENDINGS = (".hdf5", ".h5", ".dat", ".txt")
SHARE_OF_A_LOCAL_SOLVER = 1.0 / 30.0
"""Of the seconds for one problem; where they are used up, the error after more sweeps is not known."""
DEFAULT = "default"


@dataclass(frozen=True)
class ProblemResult:
    """What was measured on one problem.

    Attributes:
        problem: name of its file without endings.
        contacts: number of contacts.
        mu: smallest and largest coefficient.
        errors: for every local solver, and for "default", the error after so many plain (default: accelerated) sweeps.
            None where time was up; where the default had arrived before, its last error.
        error: of the default method; this and the rest are as in :class:`stiction.problems.Solution`.
        converged: whether it is at the tolerance.
        sweeps: of the default method.
        newton_steps: after its sweeps.
        seconds: wall time of both.
    """

    problem: str
    contacts: int
    mu: tuple[float, float]
    errors: dict[str, dict[int, float | None]]
    error: float
    converged: bool
    sweeps: int
    newton_steps: int
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Skipped:
    """A file that could not be read."""

    file: str
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def problem_files(folder: str | PathLike[str]) -> list[Path]:
    """Files of a folder whose names end as contact problems do, by name.

    Raises:
        InvalidInputError: there is no such folder, or no such file in it.
    """
    place = Path(folder)
    if not place.is_dir():
        raise InvalidInputError(f"--fclib must be a folder, got {str(folder)!r}.")
    found = sorted(file for file in place.iterdir() if file.suffix.lower() in ENDINGS and file.is_file())
    if not found:
        raise InvalidInputError(f"--fclib must be a folder with files {', '.join(ENDINGS)}, {str(folder)!r} has none.")
    return found


def measure_files(
    files: Sequence[Path],
    *,
    tolerance: float = 1e-6,
    sweeps: int = 100_000,
    seconds: float = 30.0,
    progress: Callable[[str], None] | None = None,
) -> Iterator[ProblemResult | Skipped]:
    """Measure one problem after the other; files that cannot be read are told apart and do no harm.

    Args:
        files: of contact problems.
        tolerance: of the default method.
        sweeps: its most sweeps.
        seconds: wall time for it, for each problem; a thirtieth of it for each local solver.
        progress: is told the name of each problem before it is measured.
    """
    checks.positive("tolerance", tolerance)
    checks.integer("sweeps", sweeps, minimum=0)
    checks.positive("seconds", seconds, "s")
    for file in files:
        name = file.name.partition(".")[0]
        if progress:
            progress(name)
        try:
            with interrupts_held():
                problem = ContactProblem.read(file)
            yield measure(problem, name, tolerance=tolerance, sweeps=sweeps, seconds=seconds)
        except StictionError as error:
            yield Skipped(file.name, str(error))


def measure(
    problem: ContactProblem, name: str, *, tolerance: float = 1e-6, sweeps: int = 100_000, seconds: float = 30.0
) -> ProblemResult:
    """Measure one problem."""
    from stiction.problems.sweeps import LOCAL_SOLVERS

    solve(problem, sweeps=1, finish=False, warn=False)  # compiles, which is nobody's time
    errors = {local: _errors(problem, local, seconds * SHARE_OF_A_LOCAL_SOLVER) for local in LOCAL_SOLVERS}
    solution = solve(problem, tolerance=tolerance, sweeps=sweeps, seconds=seconds, warn=False)
    errors[DEFAULT] = {count: _error_after(solution, count) for count in COUNTS}
    return ProblemResult(
        problem=name,
        contacts=problem.contacts,
        mu=(float(problem.mu.min()), float(problem.mu.max())),
        errors=errors,
        error=solution.error,
        converged=solution.converged,
        sweeps=solution.sweeps,
        newton_steps=solution.newton_steps,
        seconds=solution.seconds,
    )


def _errors(problem: ContactProblem, local: str, seconds: float) -> dict[int, float | None]:
    """Errors of plain sweeps with one local solver, started at zero."""
    import numpy as np

    from stiction.problems.sweeps import Sweeps

    engine = Sweeps(problem, local)
    r = np.zeros((problem.contacts, 3))
    deadline = time.perf_counter() + seconds
    errors: dict[int, float | None] = dict.fromkeys(COUNTS)
    done = 0
    for count in COUNTS:
        while done < count and (done == 0 or time.perf_counter() < deadline):
            engine.advance(r, COUNTS[0])
            done += COUNTS[0]
        if done < count:
            break
        errors[count] = engine.error(r)
    return errors


def _error_after(solution: Solution, count: int) -> float | None:
    """The error that the log has at ``count``, or at its end if that came first."""
    reached = solution.log[solution.log[:, 0] <= count]
    return float(reached[-1, 1])
