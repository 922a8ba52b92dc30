"""Numbers of inputs: the same bits come back, however they came; what is set evenly leaves next to nothing."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiction.record.input_numbers import InputNumbers, decode_numbers
from stiction.record.inputs import KINDS, WIDTHS_BY_CODE
from stiction.record.layout import INPUT_DTYPE

Array = NDArray[np.float64]


def encoded(rows: NDArray[Any], numbers: Array, at_once: int) -> NDArray[Any]:
    """As a recording's writer does it: some inputs at a time."""
    encoder, ends = InputNumbers(), np.cumsum(WIDTHS_BY_CODE[rows["what"]])
    parts, begin = [], 0
    for first in range(0, len(rows), at_once):
        part = rows[first : first + at_once]
        end = int(ends[first + len(part) - 1])
        parts.append(encoder.encode(part, numbers[begin:end]))
        begin = end
    return np.concatenate([np.zeros(0, np.uint64), *parts])


@pytest.mark.parametrize("at_once", [1, 7, 1000])
def test_the_same_bits_come_back(at_once: int) -> None:
    rng = np.random.default_rng(0)
    rows = np.zeros(200, INPUT_DTYPE)
    rows["step"] = np.arange(200) // 3
    rows["body"] = rng.integers(-1, 12, 200)
    rows["what"] = rng.integers(0, len(KINDS), 200)
    numbers = rng.integers(0, 256, (int(WIDTHS_BY_CODE[rows["what"]].sum()), 8), np.uint8).view(np.float64)[:, 0]
    stored = encoded(rows, numbers, at_once)
    np.testing.assert_array_equal(stored, encoded(rows, numbers, 13))
    assert decode_numbers(rows, stored).tobytes() == numbers.tobytes()
    assert numbers.tobytes() != stored.tobytes()


def test_nothing_comes_of_nothing() -> None:
    rows = np.zeros(0, INPUT_DTYPE)
    assert decode_numbers(rows, encoded(rows, np.zeros(0), 5)).tolist() == []


def test_what_is_set_again_and_again_costs_next_to_nothing() -> None:
    rows = np.zeros(3000, INPUT_DTYPE)
    rows["body"], rows["what"] = np.tile([4, 9, 5], 1000), KINDS.index("velocity")
    numbers = np.tile(np.array([[0.1, 0.2, 0.3], [-1 / 3, 0, 7], [1e-9, 3, 2]]), (1000, 1)).ravel()
    stored = encoded(rows, numbers, 50)
    assert not stored[36:].any(), "only the first four settings of each body"
    moving = numbers.reshape(-1, 3, 3) + np.linspace(0, 1, 1000)[:, None, None]  # now each a little further
    less = encoded(rows, moving.ravel(), 50)
    planes = less.view(np.uint8).reshape(-1, 8).T.tobytes()
    assert 3 * len(zlib.compress(planes)) < len(zlib.compress(moving.tobytes()))
