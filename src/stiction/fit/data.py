"""Measured motion: a CSV file with one sample a row, checked line by line.

Columns are ``t`` in s, one or more of ``x``, ``y``, ``z`` in m (origin of the body's shape, world axes), if it was
measured ``qw``, ``qx``, ``qy``, ``qz`` (unit quaternion), and ``body`` where the file holds more than one body. An
empty cell or ``nan`` is a sample that is missing. Lines that begin with ``#`` are remarks.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiction.checks import nearest
from stiction.errors import InvalidInputError

Array = NDArray[np.float64]

TIME, BODY = "t", "body"
POSITION = ("x", "y", "z")
ORIENTATION = ("qw", "qx", "qy", "qz")
COLUMNS = (TIME, *POSITION, *ORIENTATION, BODY)
MISSING = ("", "nan", "na")
UNIT_TOLERANCE = 0.02
"""How far the length of a quaternion may be from 1: files hold rounded numbers."""


@dataclass(frozen=True)
class Track:
    """What was measured of one body.

    Attributes:
        body: its name; empty where the file names none.
        times: (n,) s, increasing.
        positions: (n, 3) m, NaN where a coordinate is missing.
        orientations: (n, 4) unit quaternions (w, x, y, z), NaN in rows that are missing; None if none was measured.
    """

    body: str
    times: Array
    positions: Array
    orientations: Array | None = None

    def __post_init__(self) -> None:
        n = len(self.times)
        if self.positions.shape != (n, 3):
            raise InvalidInputError(f"positions must have shape ({n}, 3), got shape {self.positions.shape}.")
        if self.orientations is not None and self.orientations.shape != (n, 4):
            raise InvalidInputError(f"orientations must have shape ({n}, 4), got shape {self.orientations.shape}.")

    def __len__(self) -> int:
        return len(self.times)

    @property
    def count(self) -> int:
        """Numbers that were measured: coordinates, and three for each orientation."""
        turned = 0 if self.orientations is None else 3 * int(np.isfinite(self.orientations[:, 0]).sum())
        return int(np.isfinite(self.positions).sum()) + turned


def read_csv(path: str | Path) -> list[Track]:
    """The tracks in a file, a body each, in the order in which their names appear.

    Args:
        path: of the file; columns as above, in any order.

    Raises:
        InvalidInputError: the file cannot be read, a column is missing or unknown, or a cell (named by its line) is no
            number; times do not increase; a quaternion is not of length 1 or only in part there.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InvalidInputError(f"data file must exist, got {str(file)!r}.") from None
    except UnicodeDecodeError:
        raise InvalidInputError(f"data file must be text in UTF-8, got {str(file)!r}.") from None
    except OSError as error:
        raise InvalidInputError(f"data file {str(file)!r} cannot be read: {error.strerror}.") from None
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    if not lines:
        raise InvalidInputError(f"{file}: must hold a line of column names and samples, got nothing.")
    header = [name.strip() for name in next(csv.reader([lines[0][1]]))]
    _check_header(header, str(file))
    rows: dict[str, list[tuple[int, list[float]]]] = {}
    for number, line in lines[1:]:
        where = f"{file}, line {number}"
        cells = [cell.strip() for cell in next(csv.reader([line]))]
        if len(cells) != len(header):
            raise InvalidInputError(f"{where}: must have {len(header)} cells, as the header has, got {len(cells)}.")
        given = dict(zip(header, cells, strict=True))
        body = given.get(BODY, "")
        if BODY in given and not body:
            raise InvalidInputError(f"{where}: body must be the name of a body, got nothing.")
        values = [_number(given.get(name, ""), name, where) for name in (TIME, *POSITION, *ORIENTATION)]
        rows.setdefault(body, []).append((number, values))
    if not rows:
        raise InvalidInputError(f"{file}: must hold samples below the column names, got none.")
    return [_track(body, found, str(file), header) for body, found in rows.items()]


def _check_header(header: Sequence[str], file: str) -> None:
    for name in header:
        if name not in COLUMNS:
            raise InvalidInputError(
                f"{file}: columns must be among {', '.join(COLUMNS)}, got {name!r}{nearest(name, COLUMNS)}."
            )
        if header.count(name) > 1:
            raise InvalidInputError(f"{file}: column {name!r} must be there once, got it {header.count(name)} times.")
    if TIME not in header:
        raise InvalidInputError(f"{file}: column t, the time in s, must be there, got {', '.join(header)}.")
    if not any(name in header for name in POSITION):
        raise InvalidInputError(
            f"{file}: at least one of the columns x, y, z, in m, must be there, got {', '.join(header)}."
        )
    turned = [name for name in ORIENTATION if name in header]
    if turned and len(turned) < len(ORIENTATION):
        raise InvalidInputError(
            f"{file}: columns qw, qx, qy, qz must be there all four or not at all, got {', '.join(turned)}."
        )


def _number(text: str, name: str, where: str) -> float:
    if text.lower() in MISSING:
        if name == TIME:
            raise InvalidInputError(f"{where}: t must be a time in s, got {text!r}.")
        return math.nan
    try:
        value = float(text)
    except ValueError:
        raise InvalidInputError(f"{where}: {name} must be a number or empty, got {text!r}.") from None
    if not math.isfinite(value):
        raise InvalidInputError(f"{where}: {name} must be finite or empty, got {text!r}.")
    return value


def _track(body: str, rows: Sequence[tuple[int, list[float]]], file: str, header: Iterable[str]) -> Track:
    numbers = [number for number, _ in rows]
    values = np.array([row for _, row in rows])
    times = values[:, 0]
    if times[0] < 0.0:
        raise InvalidInputError(
            f"{file}, line {numbers[0]}: t must be 0 s or more, counted from the start of the scene, got {times[0]:g}."
        )
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        k = int(late[0]) + 1
        of = f" of body {body!r}" if body else ""
        raise InvalidInputError(
            f"{file}, line {numbers[k]}: t{of} must be later than {times[k - 1]:g} s, that of the sample before, "
            f"got {times[k]:g}."
        )
    turned = values[:, 4:] if ORIENTATION[0] in header else None
    if turned is not None:
        there = np.isfinite(turned)
        lengths = np.linalg.norm(turned, axis=1)
        for k, number in enumerate(numbers):
            if there[k].any() and not there[k].all():
                raise InvalidInputError(f"{file}, line {number}: qw, qx, qy, qz must be there all four or not at all.")
            if there[k].all() and abs(lengths[k] - 1.0) > UNIT_TOLERANCE:
                raise InvalidInputError(
                    f"{file}, line {number}: qw, qx, qy, qz must have length 1, got {lengths[k]:.4g}."
                )
        turned = turned / lengths[:, None]
    return Track(body, times, values[:, 1:4], turned)
