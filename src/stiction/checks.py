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

SMALLEST_LENGTH, LARGEST_LENGTH = 1e-12, 1e12
SMALLEST_MASS, LARGEST_MASS = 1e-40, 1e40
ALL_LAYERS = -1
"""All bits of a mask."""


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
        given = np.asarray(value)
        if given.dtype.kind in "bcUS":
            raise ValueError  # numpy would read flags and texts as numbers, and drop imaginary parts
        result = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} must be {length} finite numbers, got {value!r}.") from None
    if result.shape != (length,):
        raise InvalidInputError(f"{name} must have shape ({length},), got shape {result.shape} from {value!r}.")
    if not np.isfinite(result).all():
        raise InvalidInputError(f"{name} must be {length} finite numbers, got {value!r}.")
    return result


def vectors(name: str, value: Any) -> Vector:
    """Finite float64 vectors, (k, 3) or (3,), always a copy."""
    try:
        given = np.asarray(value)
        if given.dtype.kind in "bcUS":
            raise ValueError
        result = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInputError(f"{name} must be finite vectors, (k, 3), got {value!r}.") from None
    if result.ndim not in (1, 2) or result.shape[-1] != 3:
        raise InvalidInputError(f"{name} must have shape (k, 3) or (3,), got shape {result.shape}.")
    if not np.isfinite(result).all():
        raise InvalidInputError(f"{name} must be finite, got {result[~np.isfinite(result).all(axis=-1)]}.")
    return result


def layers(name: str, value: Any) -> int:
    """A set of layers, as the bits of a whole number of 64 bits."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not -(2**63) <= int(value) < 2**63:
        raise InvalidInputError(f"{name} must be a whole number of 64 bits, one a layer (-1 for all), got {value!r}.")
    return int(value)


def unit_vector(name: str, value: Any) -> Vector:
    """A direction: a finite vector that is not zero, normalised."""
    return _normalised(name, vector(name, value), "vector", value)


def unit_quaternion(name: str, value: Any) -> Vector:
    """A rotation as a quaternion (w, x, y, z): finite, not zero, normalised."""
    return _normalised(name, vector(name, value, 4), "quaternion", value)


def _normalised(name: str, result: Vector, what: str, value: Any) -> Vector:
    """To length 1, by way of its largest entry, so that no square can overflow or vanish."""
    largest = np.abs(result).max()
    if largest < 1e-12:
        raise InvalidInputError(f"{name} must not be the zero {what}, got {value!r}.")
    scaled = result / largest
    unit: Vector = scaled / np.linalg.norm(scaled)
    return unit


def length(name: str, value: Any) -> float:
    """A length of a body in m: above zero, and of a size that leaves volume and inertia finite."""
    result = positive(name, value, "m")
    if not SMALLEST_LENGTH <= result <= LARGEST_LENGTH:
        raise InvalidInputError(f"{name} must be {SMALLEST_LENGTH:g} to {LARGEST_LENGTH:g} m, got {value!r}.")
    return result


def mass(name: str, value: Any) -> float:
    """A mass in kg: above zero, and of a size whose inverse is finite."""
    result = positive(name, value, "kg")
    if not SMALLEST_MASS <= result <= LARGEST_MASS:
        raise InvalidInputError(f"{name} must be {SMALLEST_MASS:g} to {LARGEST_MASS:g} kg, got {value!r}.")
    return result


def one_of(name: str, value: Any, allowed: Iterable[str]) -> str:
    """One of a closed set of words; the sentence names the nearest one."""
    words = list(allowed)
    if not isinstance(value, str) or value not in words:
        raise InvalidInputError(f"{name} must be one of {', '.join(words)}, got {value!r}{nearest(value, words)}.")
    return value


def nearest(value: Any, known: Iterable[str]) -> str:
    """' (did you mean ...?)' for the known word nearest to ``value``, or nothing."""
    word = nearest_word(value, known)
    return f" (did you mean {word!r}?)" if word is not None else ""


def nearest_word(value: Any, known: Iterable[str]) -> str | None:
    """The known word nearest to ``value``, if one is near."""
    folded = {word.lower(): word for word in reversed(list(known))}
    match = difflib.get_close_matches(str(value).lower(), list(folded), n=1, cutoff=0.5)
    return folded[match[0]] if match else None


def _unit(unit: str) -> str:
    return f" {unit}" if unit else ""
