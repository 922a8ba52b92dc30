"""Checks at the public face: a value comes out clean, or one sentence says what is wrong with it.

Every function takes the parameter's name first, so that the sentence can name it, and returns the checked value.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.errors import InvalidInputError

Vector = NDArray[np.float64]


def number(name: str, value: Any) -> float:
    """A finite float."""
    if isinstance(value, (bool, str)):
        raise InvalidInputError(f"{name} must be a finite number, got {value!r}.")
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} must be a finite number, got {value!r}.") from None
    if not math.isfinite(result):
        raise InvalidInputError(f"{name} must be a finite number, got {value!r}.")
    return result


def positive(name: str, value: Any, unit: str = "") -> float:
    """A finite float above zero."""
    result = number(name, value)
    if result <= 0.0:
        raise InvalidInputError(f"{name} must be above 0{_unit(unit)}, got {value!r}.")
    return result


def non_negative(name: str, value: Any, unit: str = "") -> float:
    """A finite float that is zero or more."""
    result = number(name, value)
    if result < 0.0:
        raise InvalidInputError(f"{name} must be 0{_unit(unit)} or more, got {value!r}.")
    return result


def integer(name: str, value: Any, *, minimum: int) -> int:
    """An int that is ``minimum`` or more."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or int(value) < minimum:
        raise InvalidInputError(f"{name} must be a whole number, {minimum} or more, got {value!r}.")
    return int(value)


def vector(name: str, value: Any, length: int = 3) -> Vector:
    """A finite float64 array of shape ``(length,)``, always a copy."""
    try:
        result = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} must be {length} finite numbers, got {value!r}.") from None
    if result.shape != (length,):
        raise InvalidInputError(f"{name} must have shape ({length},), got shape {result.shape} from {value!r}.")
    if not np.isfinite(result).all():
        raise InvalidInputError(f"{name} must be {length} finite numbers, got {value!r}.")
    return result


def unit_vector(name: str, value: Any) -> Vector:
    """A direction: a finite vector that is not zero, normalised."""
    result = vector(name, value)
    length = float(np.linalg.norm(result))
    if length < 1e-12:
        raise InvalidInputError(f"{name} must not be the zero vector, got {value!r}.")
    return result / length


def unit_quaternion(name: str, value: Any) -> Vector:
    """A rotation as a quaternion (w, x, y, z): finite, not zero, normalised."""
    result = vector(name, value, 4)
    length = float(np.linalg.norm(result))
    if length < 1e-12:
        raise InvalidInputError(f"{name} must not be the zero quaternion, got {value!r}.")
    return result / length


def one_of(name: str, value: Any, allowed: Iterable[str]) -> str:
    """One of a closed set of words; the sentence names the nearest one."""
    words = list(allowed)
    if not isinstance(value, str) or value not in words:
        raise InvalidInputError(f"{name} must be one of {', '.join(words)}, got {value!r}{nearest(value, words)}.")
    return value


def nearest(value: Any, known: Iterable[str]) -> str:
    """' (did you mean ...?)' for the known word nearest to ``value``, or nothing."""
    words = list(known)
    folded = {word.lower(): word for word in reversed(words)}
    match = difflib.get_close_matches(str(value).lower(), list(folded), n=1, cutoff=0.5)
    return f" (did you mean {folded[match[0]]!r}?)" if match else ""


def _unit(unit: str) -> str:
    return f" {unit}" if unit else ""
