"""Numbers as differences from the ones before, without loss: what moves smoothly leaves small ones, which deflate well.

Every number is a whole number here. A floating-point number is its bits, with those below the sign flipped where it is
negative: then larger numbers have larger codes, and neighbours in time have codes that are near. Codes are counted
modulo 2^b in their b bits, so that no difference can overflow, and undoing it gives the same bits on any machine.
docs/recordings.md describes this for readers in other languages.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

Codes = NDArray[Any]
"""Unsigned whole numbers of as many bits as the numbers they stand for."""


def code_type(dtype: DTypeLike) -> np.dtype[Any]:
    """The type of the codes of numbers of a type."""
    return np.dtype(f"u{np.dtype(dtype).itemsize}")


def codes_of(values: NDArray[Any]) -> Codes:
    """Codes of numbers: in the order of the numbers if read as signed whole numbers."""
    codes = values.view(code_type(values.dtype))
    return _turned(codes) if values.dtype.kind == "f" else codes.copy()


def values_of(codes: Codes, dtype: DTypeLike) -> NDArray[Any]:
    """The numbers of that type whose codes these are."""
    return (_turned(codes) if np.dtype(dtype).kind == "f" else codes).view(dtype)


def code_of_nothing(dtype: DTypeLike) -> Any:
    """The code from which the first one of a piece is counted, so that a body that is not there is stored as zeros:
    that of NaN for floating-point numbers, 0 for others.
    """
    nothing = np.full(1, np.nan if np.dtype(dtype).kind == "f" else 0, dtype)
    return codes_of(nothing)[0]


def _turned(codes: Codes) -> Codes:
    """Bits of floating-point numbers to codes, and back."""
    signed = codes.view(f"i{codes.dtype.itemsize}")
    flipped = signed >> _top(codes)
    flipped &= np.iinfo(signed.dtype).max
    flipped ^= signed
    result: Codes = flipped.view(codes.dtype)
    return result


def folded(differences: Codes, scratch: Codes | None = None) -> Codes:
    """Differences of either sign as 0, -1, 1, -2, 2 … -> 0, 1, 2, 3, 4 …: small ones have zeros in their high bytes.

    With ``scratch``, an array of the same shape and type, no memory is taken but that of both, which are changed.
    """
    signed = differences.view(f"i{differences.dtype.itemsize}")
    out = None if scratch is None else scratch.view(signed.dtype)
    signs = np.right_shift(signed, _top(differences), out=out)
    doubled = np.left_shift(signed, 1, out=None if scratch is None else signed)
    doubled ^= signs
    result: Codes = doubled.view(differences.dtype)
    return result


def unfolded(stored: Codes) -> Codes:
    """The differences that :func:`folded` folded."""
    one = stored.dtype.type(1)
    result: Codes = (stored >> one) ^ (~(stored & one) + one)
    return result


def _top(codes: Codes) -> int:
    return 8 * codes.dtype.itemsize - 1


# --- pieces of rows ---------------------------------------------------------------------------------------------------


def to_differences(values: NDArray[Any], order: int) -> Codes:
    """A piece as it is stored.

    Args:
        values: (k, ...) rows of a piece.
        order: 1: what is stored of a row is its difference from the row before; 2: from where it would be, had it gone
            on as from the row before that to the row before. The second row has one row before it, the first none, see
            :func:`code_of_nothing`.
    """
    codes = codes_of(values)
    result = np.empty_like(codes)
    np.subtract(codes[:1], code_of_nothing(values.dtype), out=result[:1])
    np.subtract(codes[1:], codes[:-1], out=result[1:])
    if order == 2:
        codes[2:] = result[1:-1]
        np.subtract(result[2:], codes[2:], out=result[2:])
    return folded(result, scratch=codes)


def from_differences(stored: Codes, order: int, dtype: DTypeLike) -> NDArray[Any]:
    """The rows of which :func:`to_differences` made a piece, or as many of the first ones as are given."""
    codes = unfolded(stored)
    codes[:1] += code_of_nothing(dtype)
    if order == 2:
        np.cumsum(codes[1:], axis=0, dtype=codes.dtype, out=codes[1:])
    np.cumsum(codes, axis=0, dtype=codes.dtype, out=codes)
    return values_of(codes, dtype)
