"""Numbers as differences: the same bits come back, whatever they are, and what rests or moves evenly leaves zeros."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiction.record.differences import (
    code_of_nothing,
    codes_of,
    folded,
    from_differences,
    to_differences,
    unfolded,
    values_of,
)

TYPES = ("<f2", "<f4", "<f8", "<i2")


def any_bits(dtype: str, shape: tuple[int, ...]) -> NDArray[Any]:
    """Numbers of any bits: NaN, infinities, denormal ones and zeros of both signs among them."""
    rng = np.random.default_rng(3)
    values = rng.integers(0, 256, (*shape, np.dtype(dtype).itemsize), np.uint8).view(dtype)[..., 0]
    if np.dtype(dtype).kind == "f":
        tiny = np.finfo(dtype).smallest_subnormal
        values[:6, 0, 0] = [0.0, -0.0, np.inf, -np.inf, tiny, -tiny]
        values[:, 1] = np.nan
    return values


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("order", [1, 2])
def test_the_same_bits_come_back_from_a_piece_and_from_its_beginning(dtype: str, order: int) -> None:
    values = any_bits(dtype, (40, 9, 3))
    stored = to_differences(values, order)
    assert stored.dtype == np.dtype(f"u{values.itemsize}")
    for rows in (0, 1, 2, 3, 40):
        again = from_differences(stored[:rows], order, dtype)
        assert again.dtype == values.dtype
        assert again.tobytes() == values[:rows].tobytes()


@pytest.mark.parametrize("dtype", TYPES)
def test_codes_are_in_the_order_of_the_numbers(dtype: str) -> None:
    values = any_bits(dtype, (500, 3, 1)).ravel()
    values = values[np.isfinite(values)].tolist()
    # -0 before 0, which are equal: where vectors are sorted they come out in any order
    values = np.array(sorted(values, key=lambda x: (x, math.copysign(1, x))), dtype)
    codes = codes_of(values)
    assert (np.diff(codes.view(f"i{codes.itemsize}").astype(object)) >= 0).all()
    assert values_of(codes, dtype).tobytes() == values.tobytes()


@pytest.mark.parametrize("dtype", TYPES)
def test_a_body_that_is_not_there_is_stored_as_zeros(dtype: str) -> None:
    nothing = np.full((8, 2, 3), np.nan if np.dtype(dtype).kind == "f" else 0, dtype)
    for order in (1, 2):
        assert not to_differences(nothing, order).any()
        assert from_differences(np.zeros((8, 2, 3), code_of_nothing(dtype).dtype), order, dtype).tobytes() == (
            nothing.tobytes()
        )


def test_what_rests_leaves_zeros_and_what_moves_evenly_leaves_small_numbers() -> None:
    rest = np.full((20, 4, 3), 1 / 3, np.float32)
    assert not to_differences(rest, 1)[1:].any() and not to_differences(rest, 2)[1:].any()
    even = (1.0 + 0.01 * np.arange(50)).astype(np.float32).reshape(-1, 1, 1)  # 1 to 1.5: steps of one size
    assert to_differences(even, 1)[1:].max() > 1e5
    assert to_differences(even, 2)[2:].max() <= 4


def test_folding_brings_small_differences_of_both_signs_near_zero() -> None:
    for bits in (8, 16, 32, 64):
        numbers = np.array([0, -1, 1, -2, 2], f"i{bits // 8}").view(f"u{bits // 8}")
        assert folded(numbers).tolist() == [0, 1, 2, 3, 4]
        ends = np.array([np.iinfo(f"i{bits // 8}").min, np.iinfo(f"i{bits // 8}").max], f"i{bits // 8}")
        both = np.concatenate([numbers, ends.view(numbers.dtype)])
        np.testing.assert_array_equal(unfolded(folded(both)), both, strict=True)
