"""The points of a sweep: which values the parameters have in each run, and by which id a run is known for ever.

A run's id is a hash of all that decides its row: the scene, the values that are set in it, how long it runs, which
frames are looked at, what is asked of them, and the engine (its version and its sources). So a run that was
finished is found again after whatever stopped a sweep, also by a sweep that has more points now than it had then.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._version import __version__
from stiction.sweep.spec import DRAWN, ParameterTable, SweepTable, grid_values

ID_LENGTH = 20
"""Hexadecimal digits of a run's id: among 10^6 runs two are alike with a chance of 10^-12."""

ENGINE = (
    "*.py",
    "core/**/*.py",
    "data/*.toml",
    "scene/*.py",
    "record/*.py",
    "sweep/expressions.py",
    "sweep/measures.py",
)
"""Files of the package that decide what comes out of a run."""


class Point(NamedTuple):
    """One run to be.

    Attributes:
        number: its place in the sweep. run: its id. values: name of each parameter to its value.
    """

    number: int
    run: str
    values: dict[str, Any]


class Points:
    """All points of a sweep, made when they are asked for.

    The last grid parameter runs fastest, and within each point of the grid the samples do; each point of the grid has
    the same samples, so that what differs between two of them is not chance.

    Args:
        table: the sweep.
        base: what all runs have in common, see :func:`base_key`.

    Attributes:
        names: of the parameters, in order. sizes: how many different values each of them takes.
    """

    def __init__(self, table: SweepTable, base: str) -> None:
        self._base = base
        self.names = [parameter.column for parameter in table.parameters]
        self._grids = [(p.column, grid_values(p)) for p in table.parameters if p.axis not in DRAWN]
        self._drawn = draw(table)
        self._samples = table.samples or 1
        self._count = table.count
        self.sizes = {name: len(grid) for name, grid in self._grids} | dict.fromkeys(self._drawn, self._samples)

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Point]:
        return (self[index] for index in range(self._count))

    def __getitem__(self, index: int) -> Point:
        if not 0 <= index < self._count:
            raise IndexError(index)
        cell, sample = divmod(index, self._samples)
        values = {name: float(column[sample]) for name, column in self._drawn.items()}
        for name, grid in reversed(self._grids):
            cell, place = divmod(cell, len(grid))
            values[name] = grid[place]
        ordered = {name: values[name] for name in self.names}
        return Point(index, run_id(self._base, ordered), ordered)


def run_id(base: str, values: dict[str, Any]) -> str:
    """The id of a run: a hash of what it has in common with others and of its own values."""
    return hashlib.sha256(f"{base}{canonical(values)}".encode()).hexdigest()[:ID_LENGTH]


def canonical(value: Any) -> str:
    """Plain data as text, the same for the same data: keys in order, every digit of a number."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"))


def base_key(common: dict[str, Any]) -> str:
    """Hash of what all runs of a sweep have in common, the engine included."""
    return hashlib.sha256(canonical([common, __version__, _engine()]).encode()).hexdigest()


@cache
def _engine() -> str:
    """Hash of the sources that decide a row: between two releases the version stays while the physics may change."""
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for pattern in ENGINE:
        for source in sorted(package.glob(pattern)):
            digest.update(source.relative_to(package).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()


def draw(table: SweepTable) -> dict[str, NDArray[np.float64]]:
    """(samples,) values of every parameter that is drawn.

    Each random parameter has a stream of its own, from the seed and its name, so that one more parameter leaves the
    others as they are. The Sobol sequence (scipy's) has a dimension for each of its parameters, in their order.
    """
    count = table.samples or 1
    drawn: dict[str, NDArray[np.float64]] = {}
    for parameter in table.parameters:
        if parameter.axis in ("uniform", "loguniform"):
            stream = np.random.default_rng([table.seed, zlib.crc32(parameter.column.encode())])
            drawn[parameter.column] = scale(parameter, stream.random(count))
    for parameter, column in sobol_columns(table, [p for p in table.parameters if "sobol" in p.axis]):
        drawn[parameter.column] = scale(parameter, column)
    return drawn


def sobol_columns(
    table: SweepTable, parameters: Sequence[ParameterTable]
) -> Iterator[tuple[ParameterTable, NDArray[np.float64]]]:
    """Each parameter with its column of the Sobol sequence, in [0, 1)."""
    if not parameters:
        return
    from scipy.stats import qmc

    count = table.samples or 1
    sequence = qmc.Sobol(len(parameters), scramble=table.scramble, rng=table.seed)
    unit = sequence.random_base2(count.bit_length() - 1)
    for number, parameter in enumerate(parameters):
        yield parameter, unit[:, number]


def scale(parameter: ParameterTable, unit: NDArray[np.float64]) -> NDArray[np.float64]:
    """Numbers in [0, 1) between the ends of a parameter, evenly or by logarithm."""
    low, high = parameter.uniform or parameter.loguniform or parameter.sobol or parameter.logsobol or (0.0, 1.0)
    if parameter.axis.startswith("log"):
        return np.asarray(low * (high / low) ** unit)
    return low + (high - low) * unit
