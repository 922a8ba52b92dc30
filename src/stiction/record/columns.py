"""Data sets to which rows are appended: plain ones, and those whose pieces are deflated here, outside HDF5.

HDF5 would deflate while it holds Python's lock, so that the simulation had to wait. zlib by itself lets go of it, and
HDF5 takes pieces that are ready: shuffled and deflated as its own filters do, so that any reader undoes it.
"""

from __future__ import annotations

import math
import zlib
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.record.differences import code_type, to_differences
from stiction.record.layout import FRAME_TYPES, HALF_MAX, HALF_MIN, QUATERNION_SCALE, TAILS

PIECE_NUMBERS = 1 << 15
"""Bodies times frames of a piece of a frame array, about: larger ones deflate little better, and are full later."""
PIECE_FRAMES = (8, 64)
"""Frames of a piece at least and at most."""
PIECE_BODIES = 512
"""Bodies of a piece at most: whoever reads one body reads those beside it, too; small pieces take longer to write."""
LEVEL = 1
"""Of deflating: higher ones take longer and save a few percent."""
TAIL_BYTES = 1 << 13
"""Of a piece of a tail, about: with larger ones more would be written than is new."""
TAIL_BODIES = 128
"""Bodies of such a piece at most: nothing deflates what a last one has more than there are bodies."""


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
    """Rows in pieces that are shuffled and deflated, as differences from the row before where ``order`` says so.

    A piece that is not full waits. What must not be lost of it is written into its data set in ``tails``, as it is: a
    place that is used again for the next piece, while that of a piece which was packed before its time would be lost,
    for readers may still be looking at it. Only the last one of a file is packed as it is, by :meth:`finish`.

    Args:
        file: to make the data sets in. name: of the rows.
        dtype: of the numbers.
        shape: of a row: (n, width) for n bodies, or () for rows of one item.
        rows: of a piece.
        order: of the differences that are stored, 0 for none, see :func:`stiction.record.differences.to_differences`.
    """

    def __init__(
        self, file: h5py.File, name: str, dtype: Any, shape: tuple[int, ...], rows: int, order: int = 0
    ) -> None:
        self._dtype, self._shape, self._order = np.dtype(dtype), shape, order
        self.rows = rows
        """Rows of a piece."""
        self._nothing = np.nan if self._dtype.kind == "f" else 0
        self._spans = tuple(max(1, min(size, PIECE_BODIES)) for size in shape[:1]) + shape[1:]
        growing = tuple(None for _ in shape[:1]) + shape[1:]
        self.dataset = file.create_dataset(
            name, (0, *shape), code_type(dtype) if order else dtype, maxshape=(None, *growing),
            chunks=(rows, *self._spans), compression="gzip", compression_opts=LEVEL, shuffle=True,
        )  # fmt: skip
        if order:
            self.dataset.attrs["differences"] = order
            self.dataset.attrs["type"] = self._dtype.str
        beside = tuple(min(size, TAIL_BODIES) for size in self._spans[:1]) + shape[1:]
        at_once = max(1, min(rows, TAIL_BYTES // (math.prod(beside) * self._dtype.itemsize)))
        self.tail = file.create_dataset(
            f"{TAILS}/{name}", (rows, *shape), dtype, maxshape=(rows, *growing), chunks=(at_once, *beside),
            fillvalue=self._nothing if self._dtype.names is None else None,
        )  # fmt: skip
        self._waiting: list[NDArray[Any]] = []
        self._count = 0
        self._base = 0
        self._seen = 0
        self._kept = 0

    @property
    def length(self) -> int:
        """Rows that are in the file."""
        return self._base + self._kept

    def add(self, rows: NDArray[Any]) -> None:
        """Append rows (k, n, width), or (k,); n may be larger than it was before."""
        if len(rows):
            self._shape = tuple(max(pair) for pair in zip(self._shape, rows.shape[1:], strict=True))
            self._waiting.append(rows)
            self._count += len(rows)

    def write(self, everything: bool) -> None:
        """Write all pieces that are full, and the rows that are left, if one of them waits since the last time or if
        ``everything`` is asked for.
        """
        if self._count >= self.rows:
            rows = self._joined()
            whole = len(rows) // self.rows * self.rows
            self._put(rows[:whole])
            self._waiting, self._count, self._seen, self._kept = [rows[whole:]], len(rows) - whole, 0, 0
        if self._count > self._kept and (everything or self._seen > 0):
            rows = self._joined()
            if self.tail.shape[1:] != self._shape:
                self.tail.resize((self.rows, *self._shape))
            self.tail[self._kept : len(rows)] = rows[self._kept :]
            self.tail.flush()
            self._waiting, self._kept = [rows], len(rows)
        self._seen = self._count

    def finish(self) -> None:
        """Write all rows, the last ones as a piece that is not full: nothing can be added then."""
        self.write(everything=False)
        if self._count:
            self._put(self._joined())
            self._waiting, self._count, self._kept = [], 0, 0

    def _joined(self) -> NDArray[Any]:
        return np.concatenate([self._filled(part, (len(part), *self._shape)) for part in self._waiting])

    def _filled(self, rows: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
        """Rows in an array of that shape; what is not there is nothing."""
        if rows.shape == shape:
            return rows
        wide = np.full(shape, self._nothing, rows.dtype) if rows.dtype.names is None else np.zeros(shape, rows.dtype)
        wide[tuple(slice(size) for size in rows.shape)] = rows
        return wide

    def _put(self, rows: NDArray[Any]) -> None:
        """Pack the next rows; the last piece of them need not be full."""
        self.dataset.resize((self._base + len(rows), *self._shape))
        for start in range(0, len(rows), self.rows):
            piece = rows[start : start + self.rows]
            for body in range(0, self._shape[0], self._spans[0]) if self._shape else (0,):
                part = piece[:, body : body + self._spans[0]] if self._shape else piece
                if self._order:
                    part = to_differences(np.ascontiguousarray(part), self._order)
                if part.shape != (self.rows, *self._spans):
                    full = np.zeros((self.rows, *self._spans), part.dtype)
                    full[tuple(slice(size) for size in part.shape)] = part
                    part = full
                place = (self._base + start, body, 0)[: part.ndim]
                self.dataset.id.write_direct_chunk(place, pack(part, self._order))
        self.dataset.flush()
        self._base += len(rows)


def pack(piece: NDArray[Any], order: int = 0) -> bytes:
    """As HDF5's filters shuffle and gzip make it."""
    # of differences runs of zeros are all that repeats: to look for no more is quicker, and leaves fewer bytes
    strategy = zlib.Z_RLE if order else zlib.Z_DEFAULT_STRATEGY
    packer = zlib.compressobj(LEVEL, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, strategy)
    parts = []
    for plane in np.ascontiguousarray(piece).reshape(-1).view(np.uint8).reshape(-1, piece.dtype.itemsize).T:
        # each plane has a code of its own: high bytes are mostly zero, low ones are anything
        parts += [packer.compress(plane.tobytes()), packer.flush(zlib.Z_PARTIAL_FLUSH)]
    return b"".join([*parts, packer.flush()])


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
