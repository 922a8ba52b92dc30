"""What is to be found: numbers of a scene, by the path of their keys, with the range in which they may lie."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.scene.model import SceneTable
from stiction.scene.overrides import value_at

Array = NDArray[np.float64]

RANGES: dict[str, tuple[float, float]] = {
    "static": (0.0, 1.5),
    "dynamic": (0.0, 1.5),
    "static_across": (0.0, 1.5),
    "dynamic_across": (0.0, 1.5),
    "restitution": (0.0, 1.0),
    "rolling": (0.0, 0.05),
    "torsional": (0.0, 0.05),
}
"""Where a coefficient is looked for if nobody says: lengths of rolling and torsional resistance in m."""


@dataclass(frozen=True)
class Parameter:
    """One number to be found.

    Attributes:
        name: short, for tables.
        keys: paths of the scene's keys that get its value; more than one where they are to be equal.
        low, high: the range in which it is looked for, in the unit of the key.
        start: where the search begins; None for the middle of the range.
    """

    name: str
    keys: tuple[str, ...]
    low: float
    high: float
    start: float | None = None

    def __post_init__(self) -> None:
        low, high = checks.number(f"low of {self.name}", self.low), checks.number(f"high of {self.name}", self.high)
        if not low < high:
            raise InvalidInputError(f"range of {self.name} must be LOW:HIGH with LOW below HIGH, got {low:g}:{high:g}.")
        if self.start is not None and not low <= self.start <= high:
            raise InvalidInputError(f"start of {self.name} must be {low:g} to {high:g}, got {self.start:g}.")

    @property
    def span(self) -> float:
        """Width of the range."""
        return self.high - self.low

    @property
    def first(self) -> float:
        """Where the search begins."""
        return 0.5 * (self.low + self.high) if self.start is None else self.start


def parse(text: str, table: SceneTable) -> Parameter:
    """``KEY``, ``KEY=LOW:HIGH`` or ``KEY+KEY=LOW:HIGH`` as a parameter of a scene.

    Args:
        text: the paths of one key or of several that are to be equal, and the range. The range of a coefficient may be
            left out (:data:`RANGES`).
        table: of the scene; a value that it has is where the search begins.

    Raises:
        InvalidInputError: a key that is not known or holds no number; no range where one is needed; a range that is
            none.
    """
    paths, equals, limits = text.partition("=")
    keys = tuple(path.strip() for path in paths.split("+"))
    values = [value_at(table, key) for key in keys]
    for key, value in zip(keys, values, strict=True):
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise InvalidInputError(f"parameter must be the path of a number, got {key!r}, which holds {value!r}.")
    last = keys[0].rpartition(".")[2]
    if equals:
        low, high = _range(limits, keys[0])
    elif last in RANGES:
        low, high = RANGES[last]
    else:
        raise InvalidInputError(f"parameter {keys[0]!r} needs a range, such as {keys[0]}=0:1.")
    known = next((float(value) for value in values if value is not None), None)
    start = known if known is not None and low < known < high else None
    return Parameter("+".join(_short(keys)), keys, low, high, start)


def parse_all(texts: Sequence[str], table: SceneTable) -> list[Parameter]:
    """All parameters; no key may be in two of them.

    Raises:
        InvalidInputError: see :func:`parse`; none is given; a key is given twice.
    """
    if not texts:
        raise InvalidInputError(
            "--free must name at least one key, such as materials.pairs.wood-concrete.dynamic, got none."
        )
    made = [parse(text, table) for text in texts]
    seen: set[str] = set()
    for parameter in made:
        for key in parameter.keys:
            if key in seen:
                raise InvalidInputError(f"--free must name each key once, got {key!r} twice.")
            seen.add(key)
    return made


def _range(text: str, key: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    try:
        limits = float(low), float(high)
    except ValueError:
        colon = ""
    if not colon or not all(math.isfinite(limit) for limit in limits):
        raise InvalidInputError(f"range of {key} must be LOW:HIGH, such as 0.1:0.6, got {text!r}.")
    return limits


def _short(keys: Sequence[str]) -> list[str]:
    """Keys without the words that all of them share: ``wood-concrete.static`` and then ``dynamic``."""
    names = [key.removeprefix("materials.pairs.").removeprefix("bodies.") for key in keys]
    stem = names[0].rpartition(".")[0] + "."
    return [names[0], *(name.removeprefix(stem) for name in names[1:])]


def as_values(parameters: Sequence[Parameter], x: Any) -> dict[str, float]:
    """Path of each key to its value, for :func:`stiction.scene.overrides.apply_values`."""
    return {key: float(value) for parameter, value in zip(parameters, x, strict=True) for key in parameter.keys}
