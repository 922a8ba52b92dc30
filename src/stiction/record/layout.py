"""The layout of a recording in HDF5: names, types and versions, and the file itself, made and opened.

docs/recordings.md describes it for readers in other languages; what is written here is what is there.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from stiction.contacts import CONTACT_DTYPE
from stiction.errors import InvalidInputError, OutputError
from stiction.record.recorder import WIDTHS

FORMAT = "stiction recording"
FORMAT_VERSION = 3
"""3: frames and inputs as differences, tails. 2: frames for the eye, hashes of all steps, inputs and snapshots.
1: frames in float64 and the scene, no more."""
READABLE_VERSIONS = (1, 2, 3)

PRECISIONS = ("display", "full")
QUATERNION_SCALE = 32767
"""Orientations for display are whole numbers of 16 bits, 1 is that number."""
HALF_MAX = float(np.finfo(np.float16).max)
"""m/s and rad/s: faster bodies are written down with this speed in velocities for display."""
HALF_MIN = float(np.finfo(np.float16).smallest_normal)
"""m/s and rad/s, 6e-5: slower ones count as at rest there. What trembles need not be kept, and numbers that small would
take twenty times as long to round."""
FRAME_TYPES = {
    "display": {"positions": "f4", "orientations": "i2", "velocities": "f2", "angular_velocities": "f2"},
    "full": dict.fromkeys(WIDTHS, "f8"),
}
"""Types of the arrays of a frame, little-endian as everything in the file."""
ORDERS = {"positions": 2, "orientations": 2, "velocities": 1, "angular_velocities": 1}
"""Of the differences as which they are stored: places go on as they went, velocities do not, for bodies meet."""
TAILS = "tails"
"""The group of the rows that do not fill a piece yet, under the names of the data sets to which they will go."""

_CONTACT_PARTS: dict[str, np.dtype[Any]] = {name: CONTACT_DTYPE[name] for name in CONTACT_DTYPE.names or ()}
_SINGLE: Any = {name: np.dtype("<f4") if part.base.kind == "f" else part.base for name, part in _CONTACT_PARTS.items()}
DISPLAY_CONTACT: np.dtype[Any] = np.dtype([(name, _SINGLE[name], part.shape) for name, part in _CONTACT_PARTS.items()])
"""Contact points for display: the columns of ``CONTACT_DTYPE``, numbers in float32."""

ENERGY_FIELDS = (
    "kinetic", "potential", "friction", "rolling", "impacts", "work", "edits", "numerical", "initial",
)  # fmt: skip
"""Columns of ``frames/energy``, J, see :class:`stiction.Energy`."""

COUNTED = ("hashes", "frames/steps", "contacts", "inputs/rows", "inputs/numbers", "inputs/texts", "checkpoints/rows")
"""Data sets whose lengths a row of ``commits`` holds, in this order: what was written whole by then."""

INPUT_DTYPE = np.dtype([("step", "<i8"), ("body", "<i4"), ("what", "u1")])
"""A row of ``inputs/rows``: steps taken before it, index of the body at that time (-1 for none), and a place in
:data:`stiction.record.inputs.KINDS`."""
CHECKPOINT_DTYPE = np.dtype([("step", "<i8"), ("start", "<i8"), ("length", "<i8")])
"""A row of ``checkpoints/rows``: steps taken by then, and where in ``checkpoints/data`` its bytes are."""
OUTCOME_DTYPE = np.dtype("S400")
USER_BLOCK = 512
"""Bytes before all that is HDF5's."""
SIGNATURE, FLAGS = b"\x89HDF\r\n\x1a\n", 11
"""With which HDF5's part begins, and where in it the flags are."""
OPEN_OUTCOME = "not closed"
"""Outcome of a recording that is still being written, or whose process was killed."""


def create_file(path: Path) -> h5py.File:
    """A new file that others can read while it is written (SWMR)."""
    if path.exists() and path.stat().st_size > 0 and not h5py.is_hdf5(path):
        raise OutputError(f"recording must not replace a file of another kind, and {str(path)!r} is no HDF5 file.")
    try:
        return h5py.File(path, "w", libver=("v110", "v110"), userblock_size=USER_BLOCK)
    except OSError as error:
        raise OutputError(f"recording cannot be written: {str(path)!r}: {error}.") from None


def sign(file: h5py.File) -> None:
    """Write down, before all that is HDF5's, how long the file is now that a commit is whole."""
    if not hasattr(os, "pwrite"):  # Windows: a file that was cut off is found out later there
        return
    handle = file.id.get_vfd_handle()
    text = f"{FORMAT} {FORMAT_VERSION}\n{os.fstat(handle).st_size:020d} bytes\n"
    os.pwrite(handle, text.encode(), 0)


def _is_cut_off(path: Path) -> bool:
    """Whether the file is shorter than it was at its last commit."""
    match = re.fullmatch(rb"[a-z ]+ \d+\n(\d{20}) bytes\n\0*", _head(path)[:USER_BLOCK])
    return match is not None and path.stat().st_size < int(match[1])


def _is_being_written(path: Path) -> bool:
    """Whether the file says that somebody writes it, who may have been killed (HDF5 file format, superblock 3)."""
    head = _head(path)
    start = head.find(SIGNATURE)
    flags = head[start + FLAGS : start + FLAGS + 1]
    return start in (0, USER_BLOCK) and flags != b"" and flags[0] & 1 == 1


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(2 * USER_BLOCK)


def open_file(path: str | Path) -> tuple[h5py.File, int]:
    """A recording and the version of its format.

    Raises:
        InvalidInputError: there is no such file, or it is no recording that can be read.
    """
    if not Path(path).is_file():
        raise InvalidInputError(f"recording must be a file that exists, got {str(path)!r}.")
    try:
        file = h5py.File(path, "r")
    except OSError as first:
        if not h5py.is_hdf5(path):
            raise InvalidInputError(f"{str(path)!r} is not a recording of stiction: it is no HDF5 file.") from None
        try:  # while it is written, and after its process was killed, only a reader that says so may read it
            if _is_cut_off(Path(path)):  # asked before: such a reader would wait for the rest
                raise OSError("it is cut off, and shorter than it was once")
            if not _is_being_written(Path(path)):
                raise first
            file = h5py.File(path, "r", libver="latest", swmr=True)
        except (OSError, ValueError) as error:
            raise InvalidInputError(f"recording {str(path)!r} cannot be opened: {error}.") from None
    try:
        if file.attrs.get("format") != FORMAT:
            raise InvalidInputError(f"{str(path)!r} is not a recording of stiction, but another HDF5 file.")
        version = int(file.attrs.get("format_version", 0))
        if version not in READABLE_VERSIONS:
            raise InvalidInputError(
                f"recording {str(path)!r} must have format version {', '.join(map(str, READABLE_VERSIONS))}, "
                f"got {version}: it was made by another version of stiction."
            )
    except InvalidInputError:
        file.close()
        raise
    except (OSError, ValueError, TypeError) as error:
        file.close()
        raise damaged(path, error) from None
    return file, version


def damaged(path: str | Path, error: Exception) -> InvalidInputError:
    """What to raise where a recording does not hold what it should; what says so already is raised again."""
    if isinstance(error, InvalidInputError):
        return error
    return InvalidInputError(f"recording {str(path)!r} is damaged: {error}.")


def read_json(file: h5py.File, name: str) -> Any:
    """A data set of one JSON text."""
    return json.loads(file[name].asstr()[()])
