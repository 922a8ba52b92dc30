"""Data sets to which rows are appended: plain ones, and those whose pieces are deflated here, outside HDF5.

HDF5 would deflate while it holds Python's lock, so that the simulation had to wait. zlib by itself lets go of it, and
HDF5 takes pieces that are ready: shuffled and deflated as its own filters do, so that any reader undoes it.
"""

from __future__ import annotations

import zlib
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.record.layout import FRAME_TYPES, HALF_MAX, HALF_MIN, QUATERNION_SCALE

PIECE_NUMBERS = 1 << 14
"""Bodies times frames of a piece of a frame array, about: larger ones deflate no better, and are full later."""
PIECE_FRAMES = (4, 64)
"""Frames of a piece at least and at most."""
PIECE_BODIES = 256
"""Bodies of a piece at most: whoever reads one body reads those beside it, too."""
LEVEL = 1
"""Of deflating: higher ones take longer and save a few percent."""


class PlainColumn:
    """Rows that are written as they are."""

    def __init__(self, file: h5py.File, name: str, dtype: Any, shape: tuple[int, ...] = (), rows: int = 1024) -> None:
        self.dataset = file.create_dataset(
            name, (0, *shape), dtype, maxshape=(None, *shape), chunks=(rows, *(max(1, size) for size in shape))
        )
        self._dtype = self.dataset.dtype  # asking HDF5 takes longer than adding a row
        self._waiting: list[NDArray[Any]] = []
        self.length = 0
        """Rows that are in the file."""

    def add(self, rows: Any) -> None:
        """Append rows, which are written with the next :meth:`write`."""
        values = np.asarray(rows, self._dtype)
        if len(values):
            self._waiting.append(values)

    def write(self) -> None:
        """Write what waits. Cut off and called again, it writes the same again."""
        if self._waiting:
            values = np.concatenate(self._waiting)
            end = self.length + len(values)
            self.dataset.resize(end, axis=0)
            self.dataset[self.length : end] = values
            self._waiting, self.length = [], end
            self.dataset.flush()


class PackedColumn:
    """Rows of n bodies (or of none, ``width`` 0) in pieces that are shuffled and deflated.

    A piece that is not full may be written, too, and is written again when it has grown; what it took before in the
    file is lost, for readers may still be looking at it.
    """

    def __init__(self, file: h5py.File, name: str, dtype: Any, bodies: int, width: int, rows: int) -> None:
        self._bodies, self._width = bodies, width
        self.rows = rows
        """Rows of a piece."""
        self._span = max(1, min(bodies, PIECE_BODIES))
        shape, pieces, most = (0, bodies, width), (rows, self._span, width), (None, None, width)
        self.dataset = file.create_dataset(
            name, shape, dtype, maxshape=most, chunks=pieces, compression="gzip", compression_opts=LEVEL, shuffle=True,
            fillvalue=np.nan if np.dtype(dtype).kind == "f" else 0,
        )  # fmt: skip
        self._waiting: list[NDArray[Any]] = []
        self._count = 0
        self._base = 0
        self._partial = 0

    @property
    def length(self) -> int:
        """Rows that are in the file."""
        return self._base + self._partial

    def add(self, rows: NDArray[Any]) -> None:
        """Append rows (k, n, width); n may be larger than it was before."""
        self._bodies = max(self._bodies, rows.shape[1])
        self._waiting.append(rows)
        self._count += len(rows)

    def write(self, partial: bool, least: float = 0.0) -> None:
        """Write all pieces that are full, and, if ``partial``, the last one as well, once it has grown by more than
        ``least``, a share of a piece.
        """
        left = self._count % self.rows
        new = left - (self._partial if left == self._count else 0)
        partial = partial and new > least * self.rows
        if self._count < self.rows and not partial:
            return
        rows = np.concatenate([self._padded(part) for part in self._waiting])
        whole = len(rows) // self.rows * self.rows
        ends = [*range(self.rows, whole + 1, self.rows), *([len(rows)] if partial and len(rows) > whole else [])]
        self.dataset.resize((self._base + (ends[-1] if ends else 0), self._bodies, self._width))
        start = 0
        for end in ends:
            self._put(self._base + start, rows[start:end])
            start = end
        self.dataset.flush()
        self._partial = len(rows) - whole if partial else 0
        self._base += whole
        self._waiting, self._count = [rows[whole:]], len(rows) - whole

    def _padded(self, rows: NDArray[Any]) -> NDArray[Any]:
        if rows.shape[1] == self._bodies:
            return rows
        wide = np.full((len(rows), self._bodies, self._width), self.dataset.fillvalue, rows.dtype)
        wide[:, : rows.shape[1]] = rows
        return wide

    def _put(self, first: int, rows: NDArray[Any]) -> None:
        for body in range(0, self._bodies, self._span):
            part = rows[:, body : body + self._span]
            piece = part
            if part.shape[:2] != (self.rows, self._span):
                piece = np.zeros((self.rows, self._span, self._width), part.dtype)
                piece[: len(part), : part.shape[1]] = part
            self.dataset.id.write_direct_chunk((first, body, 0), pack(piece))


def pack(piece: NDArray[Any]) -> bytes:
    """As HDF5's filters shuffle and gzip make it."""
    planes = np.ascontiguousarray(piece).reshape(-1).view(np.uint8).reshape(-1, piece.dtype.itemsize)
    return zlib.compress(planes.T.tobytes(), LEVEL)


def piece_rows(bodies: int) -> int:
    """Frames of a piece: fewer where there are many bodies, so that whole pieces are ready soon."""
    low, high = PIECE_FRAMES
    return max(low, min(high, round(PIECE_NUMBERS / max(1, bodies))))


# --- numbers for the eye ----------------------------------------------------------------------------------------------


def encode(name: str, values: NDArray[np.float64], precision: str) -> NDArray[Any]:
    """An array of frames as it is stored."""
    dtype = FRAME_TYPES[precision][name]
    if dtype == "i2":
        scaled = values.astype(np.float32) * np.float32(QUATERNION_SCALE)
        scaled[np.isnan(scaled)] = 0.0
        np.rint(scaled, out=scaled)
        return scaled.astype(np.int16)
    if dtype == "f2":
        with np.errstate(over="ignore"):
            single = values.astype(np.float32)
        single[np.abs(single) < HALF_MIN] = 0.0
        np.clip(single, -HALF_MAX, HALF_MAX, out=single)
        return single.astype(np.float16)
    with np.errstate(over="ignore"):  # beyond 3e38 m a position for display is infinite
        return values.astype(dtype)


def decode(stored: NDArray[Any]) -> NDArray[np.float64]:
    """What :func:`encode` stored, in float64; orientations are unit quaternions again, NaN for bodies not there."""
    values: NDArray[np.float64] = stored.astype(np.float64)
    if stored.dtype.kind == "i":
        norm = np.linalg.norm(values, axis=-1, keepdims=True)
        with np.errstate(invalid="ignore"):
            values /= norm
    return values
