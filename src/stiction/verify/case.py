"""What a verification case is: a formula with its source, a scene, a measurement, and a tolerance that says why.

A case knows one closed form. It builds its own small world, measures what the formula speaks of (a distance, a time, an
angle; never a proxy), and yields one :class:`Measurement` for each number. :mod:`stiction.verify.registry` runs cases
and turns measurements into :class:`Result` rows.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

Kind = Literal["absolute", "relative"]


@dataclass(frozen=True, slots=True)
class Measurement:
    """One number that a formula predicts, and what a world made of it.

    Attributes:
        what: what was measured, in words.
        expected: by the formula.
        measured: in the world; NaN if the event in question never came.
        tolerance: largest error that passes, in ``unit`` if absolute, as a share of |expected| if relative.
        unit: of expected and measured; empty for pure numbers.
        kind: of the tolerance.
    """

    what: str
    expected: float
    measured: float
    tolerance: float
    unit: str = ""
    kind: Kind = "absolute"


@dataclass(frozen=True, slots=True)
class Result:
    """A row of a verification: a measurement, judged. Error and tolerance are absolute, in ``unit``.

    Attributes:
        case: name of the case.
        what: what was measured.
        formula: of the case.
        expected, measured, error, tolerance: numbers; error is |measured - expected|.
        unit: of all four.
        solver: that was measured.
        known_limit: whether the case says that this solver cannot pass it by its nature.
        reason: why a known limit is one; else why a measurement is missing or less sure than others; or None.
    """

    case: str
    what: str
    formula: str
    expected: float
    measured: float
    error: float
    tolerance: float
    unit: str
    solver: str
    known_limit: bool = False
    reason: str | None = None

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance. A measurement that is not a number never passes."""
        return self.error <= self.tolerance

    @property
    def expected_failure(self) -> str | None:
        """Why a row that did not pass was not expected to, or None: a known limit does not fail a verification."""
        return self.reason if self.known_limit and not self.passed else None

    @property
    def surprise(self) -> bool:
        """Whether a known limit passes: then it is none any more, and its case should say so."""
        return self.known_limit and self.passed

    def as_dict(self) -> dict[str, str | float | bool | None]:
        """The row as plain values for JSON; what is not a finite number becomes None."""
        return {
            "case": self.case,
            "what": self.what,
            "formula": self.formula,
            "expected": _finite(self.expected),
            "measured": _finite(self.measured),
            "error": _finite(self.error),
            "tolerance": _finite(self.tolerance),
            "unit": self.unit,
            "passed": self.passed,
            "solver": self.solver,
            "reason": self.reason,
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


class Case(ABC):
    """A closed form and how it is measured. Subclasses set the attributes and write :meth:`measure`.

    Attributes:
        name: in kebab-case, unique.
        title: what must happen, in a few words.
        formula: as text, such as ``d = v^2 / (2 mu_d g)``.
        source: the law, text or paper that the formula comes from.
        tolerance: as a formula of dt, of the solver's own tolerance ``eps`` (m/s a step) and of the scene.
        tolerance_reason: where an error of that size comes from.
        other_tolerance: for each solver whose tolerance is another one, what it is and why, as two texts.
        solvers: that the formula speaks of; the others are not measured.
        known_limit: for each solver that cannot pass this case by its nature, why. Such a case is run, measured and
            listed like any other, but a row of it that does not pass is not a failure.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    formula: ClassVar[str]
    source: ClassVar[str]
    tolerance: ClassVar[str]
    tolerance_reason: ClassVar[str]
    other_tolerance: ClassVar[Mapping[str, tuple[str, str]]] = {}
    solvers: ClassVar[tuple[str, ...]] = ("soft", "micro", "exact")
    known_limit: ClassVar[Mapping[str, str]] = {}

    @abstractmethod
    def measure(self, solver: str, dt: float) -> Iterable[Measurement]:
        """Build the scene, run it, and yield what was measured.

        Args:
            solver: a solver that this version has.
            dt: time step, s.
        """

    def tolerance_of(self, solver: str) -> tuple[str, str]:
        """The tolerance that holds for a solver, as a formula, and where it comes from."""
        return self.other_tolerance.get(solver, (self.tolerance, self.tolerance_reason))

    def judge(self, measurement: Measurement, solver: str, reason: str | None = None) -> Result:
        """A row from a measurement.

        Args:
            measurement: what :meth:`measure` yielded.
            solver: that it was measured with.
            reason: a note on the row; the reason of a known limit goes before it.
        """
        scale = abs(measurement.expected) if measurement.kind == "relative" else 1.0
        return Result(
            case=self.name,
            what=measurement.what,
            formula=self.formula,
            expected=float(measurement.expected),
            measured=float(measurement.measured),
            error=abs(float(measurement.measured) - float(measurement.expected)),
            tolerance=float(measurement.tolerance) * scale,
            unit=measurement.unit,
            solver=solver,
            known_limit=solver in self.known_limit,
            reason=self.known_limit.get(solver, reason),
        )
