"""The format of a sweep's file, as pydantic models: one class a table, one line a key.

What a key means by itself is checked here; what needs the scene beside it, in :mod:`stiction.sweep.load`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from stiction import checks
from stiction.scene import fields
from stiction.scene.fields import Table, Text, fault

MOST_POINTS = 100_000_000
"""Runs of one sweep at most."""
RESERVED = ("run", "index", "error", "warning", "wall_seconds", "steps", "state_hash", "worker", "time", "dt", "g")
"""Columns of the table and names of the language that are there anyway."""
AXES = ("values", "linspace", "logspace", "uniform", "loguniform", "sobol", "logsobol")
"""Ways to say which values a parameter takes."""
DRAWN = ("uniform", "loguniform", "sobol", "logsobol")
"""Those that draw as many values as the sweep has samples."""


def _identifier(value: str) -> str:
    if not value.isidentifier() or value in RESERVED:
        raise fault(f"must be a name of letters, digits and _ that is none of {', '.join(RESERVED)}, got {value!r}.")
    return value


def _values(value: Any) -> tuple[Any, ...]:
    if not isinstance(value, (list, tuple)) or not value:
        raise fault(f"must be a list of one or more values, got {value!r}.")
    kinds = {_kind(item) for item in value}
    if len(kinds) > 1:
        raise fault(f"must be of one kind, got {' and '.join(sorted(kinds))}.")
    return tuple(value)


def _kind(value: Any) -> str:
    if isinstance(value, bool):
        return "flags"
    if isinstance(value, (int, float)):
        return "numbers"
    return {"str": "texts", "list": "lists", "dict": "tables"}.get(type(value).__name__, type(value).__name__)


def _spaced(value: Any) -> tuple[float, float, int]:
    if isinstance(value, (list, tuple)) and len(value) == 3:
        try:
            first, last = (checks.number("", item) for item in value[:2])
            return first, last, checks.integer("", value[2], minimum=1)
        except ValueError:
            pass
    raise fault(f"must be first value, last value and how many, got {value!r}.")


def _range(value: Any) -> tuple[float, float]:
    if isinstance(value, (list, tuple)) and len(value) == 2:
        try:
            low, high = (checks.number("", item) for item in value)
        except ValueError:
            pass
        else:
            if low < high:
                return low, high
    raise fault(f"must be two numbers, the smaller one first, got {value!r}.")


def _above_zero(value: tuple[float, ...]) -> tuple[float, ...]:
    if min(value[:2]) <= 0.0:
        raise fault(f"must begin and end above 0, got {list(value)!r}.")
    return value


Identifier = Annotated[Text, AfterValidator(_identifier)]
Values = Annotated[tuple[Any, ...], BeforeValidator(_values)]
Spaced = Annotated[tuple[float, float, int], BeforeValidator(_spaced)]
Range = Annotated[tuple[float, float], BeforeValidator(_range)]
LogSpaced = Annotated[Spaced, AfterValidator(_above_zero)]
LogRange = Annotated[Range, AfterValidator(_above_zero)]


class ParameterTable(Table):
    """One parameter: a key of the scene and the values that it takes."""

    key: Text
    """Path of a key of the scene, such as materials.pairs.wood-ice.static, as with --set."""
    name: Identifier | None = None
    """Its column and its name in expressions; the last part of the key if left out."""
    values: Values | None = None
    """These values."""
    linspace: Spaced | None = None
    """First, last, how many: evenly spaced."""
    logspace: LogSpaced | None = None
    """First, last, how many: each the same factor above the one before."""
    uniform: Range | None = None
    """Drawn at random between the two."""
    loguniform: LogRange | None = None
    """The same, evenly by logarithm."""
    sobol: Range | None = None
    """Between the two, as one dimension of a Sobol sequence together with the others of the kind."""
    logsobol: LogRange | None = None
    """The same, evenly by logarithm."""

    @model_validator(mode="after")
    def _one_axis(self) -> ParameterTable:
        given = [axis for axis in AXES if getattr(self, axis) is not None]
        if len(given) != 1:
            raise fault(f"must have exactly one of {', '.join(AXES)}, got {', '.join(given) or 'none'}.")
        return self

    @property
    def axis(self) -> str:
        """Which of :data:`AXES` it has."""
        return next(axis for axis in AXES if getattr(self, axis) is not None)

    @property
    def size(self) -> int:
        """How many values it has of itself: 1 if it is drawn."""
        spaced = self.linspace or self.logspace
        return len(self.values) if self.values is not None else spaced[2] if spaced is not None else 1

    @property
    def column(self) -> str:
        """Its name: what was given, or the last part of the key, or the last two where that one is reserved."""
        if self.name is not None:
            return self.name
        parts = self.key.split(".")
        last = parts[-1] if parts[-1] not in RESERVED else "_".join(parts[-2:])
        return "".join(c if c.isalnum() else "_" for c in last).strip("_")


class DerivedTable(Table):
    """A key of the scene that follows from parameters."""

    key: Text
    """Path of a key of the scene."""
    value: Text
    """Expression of parameters, such as 0.8 * static."""


class MetricTable(Table):
    """What to find out about each run."""

    name: Identifier
    """Its column, and its name in the metrics after it."""
    value: Text
    """Expression, such as slip_distance('crate')."""


class ClassTable(Table):
    """One outcome that a run can have."""

    label: Text
    """A word or two for the legend."""
    when: Text
    """Expression of parameters and metrics: the first class that holds is the run's."""
    expected: Text | None = None
    """Closed form: an expression of parameters alone that says where this class should be."""


class MapTable(Table):
    """A map of the outcomes over two parameters, with the closed-form boundary between them."""

    x: Text
    """Parameter along x."""
    y: Text
    """Parameter along y."""
    classes: Annotated[tuple[ClassTable, ...], Field(min_length=1)]
    """Outcomes, in order of precedence."""
    x_label: Text | None = None
    """Text along x; the name of the parameter if left out."""
    y_label: Text | None = None
    """Text along y."""
    closed_form: Text | None = None
    """The formula in words, for the caption."""

    @model_validator(mode="after")
    def _all_or_none(self) -> MapTable:
        given = [entry.expected is not None for entry in self.classes]
        if any(given) and not all(given):
            raise fault("must give expected for each class or for none of them.", key="classes")
        return self


class SweepTable(Table):
    """A sweep: a scene, what varies in it, and what to find out about each run."""

    title: Text
    """A few words."""
    scene: str | dict[str, Any]
    """Name of a built-in scene, path of a scene file (from where this file is), or the scene itself as a table."""
    parameters: Annotated[tuple[ParameterTable, ...], Field(min_length=1)]
    """What varies. Grids are multiplied with each other and with the samples."""
    metrics: Annotated[tuple[MetricTable, ...], Field(min_length=1)]
    """What to find out about each run."""
    derived: tuple[DerivedTable, ...] = ()
    """Keys that follow from parameters."""
    duration: fields.Duration | None = None
    """Simulated time of each run, s; the scene's own if left out."""
    every: Annotated[int, Field(ge=1), fields.whole(1)] = 1
    """Steps from one frame to the next that metrics look at."""
    samples: Annotated[int, Field(ge=1), fields.whole(1)] | None = None
    """How many values are drawn for parameters with uniform, loguniform, sobol or logsobol."""
    seed: Annotated[int, Field(ge=0), fields.whole(0)] = 0
    """Of everything that is drawn."""
    scramble: fields.Flag = True
    """Scramble the Sobol sequence (Owen), so that it has no point at its corner."""
    map: MapTable | None = None
    """The figure to draw of the results."""

    @model_validator(mode="after")
    def _fits(self) -> SweepTable:
        names = [parameter.column for parameter in self.parameters] + [metric.name for metric in self.metrics]
        for number, parameter in enumerate(self.parameters):
            if not parameter.column.isidentifier() or parameter.column in RESERVED:
                raise fault(f"must have a name, for {parameter.key!r} gives none.", key=f"parameters[{number}]")
        for name in names:
            if names.count(name) > 1:
                raise fault(f"names of parameters and metrics must differ, got {name!r} twice; give each a name.")
        drawn = [parameter for parameter in self.parameters if parameter.axis in DRAWN]
        if drawn and self.samples is None:
            raise fault(f"must be given, for {drawn[0].key!r} is drawn.", key="samples")
        if self.samples is not None and not drawn:
            raise fault(f"must not be given where no parameter has one of {', '.join(DRAWN)}.", key="samples")
        if self.samples and any("sobol" in p.axis for p in drawn) and self.samples & (self.samples - 1):
            below = 1 << (self.samples.bit_length() - 1)
            raise fault(
                f"must be a power of two with sobol, such as {below} or {2 * below}, got {self.samples}.", key="samples"
            )
        if self.count > MOST_POINTS:
            raise fault(f"asks for {self.count} runs, and {MOST_POINTS} are allowed.")
        return self

    @property
    def count(self) -> int:
        """How many runs it has."""
        return math.prod(parameter.size for parameter in self.parameters) * (self.samples or 1)


def grid_values(parameter: ParameterTable) -> list[Any]:
    """The values of a parameter that is not drawn."""
    import numpy as np

    if parameter.values is not None:
        return list(parameter.values)
    if parameter.linspace is not None:
        return [float(x) for x in np.linspace(*parameter.linspace)]
    if parameter.logspace is not None:
        return [float(x) for x in np.geomspace(*parameter.logspace)]
    raise ValueError(f"{parameter.key!r} is drawn and has no grid")


__all__ = [
    "ClassTable",
    "DerivedTable",
    "MapTable",
    "MetricTable",
    "ParameterTable",
    "SweepTable",
    "grid_values",
]
