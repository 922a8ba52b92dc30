"""Reading rows that are stored in pieces: differences are summed up, and what does not fill a piece is in a tail."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.record.differences import from_differences
from stiction.record.layout import TAILS


class PackedRows:
    """A data set of a recording, of any version: see :class:`stiction.record.columns.PackedColumn`.

    Raises:
        KeyError: it is not there.
    """

    def __init__(self, file: h5py.File, name: str) -> None:
        self._dataset = file[name]
        self._tail = file.get(f"{TAILS}/{name}")
        self._order = int(self._dataset.attrs.get("differences", 0)) if self._dataset.ndim == 3 else 0
        self._type: np.dtype[Any] = np.dtype(self._dataset.attrs.get("type", self._dataset.dtype))
        self._left: NDArray[Any] | None = None

    @property
    def bodies(self) -> int:
        """Of rows of bodies: how many there are."""
        return int(max(self._dataset.shape[1], 0 if self._left is None else self._left.shape[1]))

    def refresh(self) -> None:
        """See what has been written since."""
        self._dataset.refresh()
        if self._tail is not None:
            self._tail.refresh()

    @property
    def packed(self) -> int:
        """Rows that are in pieces."""
        return len(self._dataset)

    @property
    def room(self) -> int:
        """Rows that there are at most, those of the tail included."""
        return self.packed + (0 if self._tail is None else len(self._tail))

    def keep(self, length: int) -> None:
        """Have ``length`` rows from now on: those that are in no piece are copied, for their place in the file will be
        used again."""
        left = length - self.packed
        self._left = self._tail[:left] if left > 0 and self._tail is not None else None

    def read(self, rows: slice, body: int | None = None) -> NDArray[Any]:
        """(k, ...) the rows of that slice, whose ends are whole numbers; or (k, width) those of one body."""
        start, stop = rows.start, max(rows.start, rows.stop)
        packed = self._in_pieces(min(start, self.packed), min(stop, self.packed), body)
        if self._left is None or stop <= self.packed:
            return packed
        left = self._left[max(0, start - self.packed) : stop - self.packed]
        left = left if body is None else left[:, body]
        if packed.shape[1:] != left.shape[1:]:  # a body has come since the last piece
            wide = np.full((len(packed), *left.shape[1:]), np.nan if left.dtype.kind == "f" else 0, left.dtype)
            wide[:, : packed.shape[1]] = packed
            packed = wide
        return np.concatenate([packed, left])

    def _in_pieces(self, start: int, stop: int, body: int | None) -> NDArray[Any]:
        bodies = () if body is None else (slice(body, body + 1),)
        if not self._order:
            stored: NDArray[Any] = self._dataset[(slice(start, stop), *bodies)]
        else:
            size = self._dataset.chunks[0]
            first = start // size * size
            codes = self._dataset[(slice(first, stop), *bodies)]
            pieces = [
                from_differences(codes[k : k + size], self._order, self._type) for k in range(0, len(codes), size)
            ]
            stored = np.concatenate([codes[:0].view(self._type), *pieces])[start - first :]
        if body is None:
            return stored
        if stored.shape[1] == 0:  # it came after the last piece
            nothing = np.nan if stored.dtype.kind == "f" else 0
            return np.full((len(stored), stored.shape[2]), nothing, stored.dtype)
        one: NDArray[Any] = stored[:, 0]
        return one
