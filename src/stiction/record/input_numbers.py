"""The numbers of inputs as they are stored: what is set in every step, such as the speed of a wall, changes little.

From a number that was set, the one before it of the same kind and body is taken, and so with what is left, thrice more:
fourth differences of codes, see :mod:`stiction.record.differences`, over the whole file, with zeros before the first.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.record.differences import Codes, codes_of, folded, unfolded, values_of
from stiction.record.inputs import WIDTHS_BY_CODE

ORDER = 4
"""How often the difference is taken: a wall that is led by a formula takes a quarter less than with one difference.
What is set to anything takes a bit more of 64 with each."""


class InputNumbers:
    """Makes the stored form of numbers that come bit by bit."""

    def __init__(self) -> None:
        self._last: dict[tuple[int, int], Codes] = {}
        """By kind and how many differences have been taken: (bodies, width) what came last of each body."""

    def encode(self, rows: NDArray[Any], numbers: NDArray[np.float64]) -> Codes:
        """Of further inputs.

        Args:
            rows: of ``INPUT_DTYPE``. numbers: all that go with them, one after the other.
        """
        stored = codes_of(numbers)
        for kind, bodies, places in _by_kind(rows):
            left, starts = stored[places], np.flatnonzero(np.diff(bodies, prepend=-1))
            ends = np.append(starts[1:], len(bodies)) - 1
            for k in range(ORDER):
                last = self._last_of(kind, k, int(bodies[-1]) + 1, left.shape[1])
                before = np.empty_like(left)
                before[1:] = left[:-1]
                before[starts] = last[bodies[starts]]
                last[bodies[ends]] = left[ends]
                left = left - before
            stored[places] = folded(left)
        return stored

    def _last_of(self, kind: int, k: int, bodies: int, width: int) -> Codes:
        last = self._last.get((kind, k), np.zeros((0, width), np.uint64))
        if len(last) < bodies:
            last = np.concatenate([last, np.zeros((bodies - len(last), width), np.uint64)])
            self._last[kind, k] = last
        return last


def decode_numbers(rows: NDArray[Any], stored: Codes, order: int = ORDER) -> NDArray[np.float64]:
    """The numbers of all inputs of a file, from the first one on."""
    codes = stored.copy()
    for _, bodies, places in _by_kind(rows):
        left, starts = unfolded(stored[places]), np.flatnonzero(np.diff(bodies, prepend=-1))
        counts = np.diff(np.append(starts, len(bodies)))
        for _ in range(order):
            sums = np.cumsum(left, axis=0, dtype=np.uint64)
            # sums begin anew with each body; they wrap around, and so does taking away what was before
            left = sums - np.repeat(sums[starts] - left[starts], counts, axis=0)
        codes[places] = left
    return values_of(codes, np.float64)


def _by_kind(rows: NDArray[Any]) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.int64]]]:
    """For each kind that has numbers: the body of each input plus 1 (0: none), sorted, and (inputs, width) the places
    of its numbers; inputs of a body stay in the order in which they came."""
    widths = WIDTHS_BY_CODE[rows["what"]]
    starts = np.cumsum(widths) - widths
    for kind in np.unique(rows["what"][widths > 0]).tolist():
        which = np.flatnonzero(rows["what"] == kind)
        which = which[np.argsort(rows["body"][which], kind="stable")]
        places = starts[which, None] + np.arange(WIDTHS_BY_CODE[kind])
        yield kind, rows["body"][which].astype(np.int64) + 1, places
