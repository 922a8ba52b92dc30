"""The coefficients of pairs of materials, the same in all worlds or each world's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.materials import MaterialTable
from stiction.pair_properties import LABELS, PROPERTIES

Array = NDArray[np.float64]


class PairTables:
    """One table of k materials for all worlds, (k, k, c), or once they differ one for each, (worlds, k, k, c).

    What is set for some worlds beyond the five numbers of a pair (laws, grain, adhesion) stays as it was for all.
    """

    def __init__(self, materials: MaterialTable, names: list[str], worlds: int) -> None:
        self.names, self.worlds = list(names), worlds
        self.array: Array = materials.to_array(self.names)

    def _place(self, a: str, b: str) -> tuple[int, int]:
        for name in (a, b):
            if name not in self.names:
                raise InvalidInputError(
                    f"material must be one of those of the bodies ({', '.join(self.names)}), got {name!r}"
                    f"{checks.nearest(name, self.names)}."
                )
        return self.names.index(a), self.names.index(b)

    def set(self, a: str, b: str, values: Mapping[str, ArrayLike], chosen: NDArray[np.int64]) -> None:
        """Set numbers of a pair in the chosen worlds; all are checked before any is set."""
        i, j = self._place(a, b)
        checked = {name: _numbers(f"{LABELS[name]} of {a} - {b}", value, len(chosen), name) for name, value in
                   values.items()}  # fmt: skip
        everywhere = len(chosen) == self.worlds and all(len(np.unique(v)) <= 1 for v in checked.values())
        if self.array.ndim == 3 and not everywhere:
            self.array = np.repeat(self.array[None], self.worlds, axis=0)
        for name, numbers in checked.items():
            column = PROPERTIES.index(name)
            for row, other in ((i, j), (j, i)):
                if self.array.ndim == 3:
                    self.array[row, other, column] = numbers[0]
                else:
                    self.array[chosen, row, other, column] = numbers

    def pair(self, a: str, b: str) -> dict[str, Array]:
        """The numbers of a pair, (worlds,) each."""
        i, j = self._place(a, b)
        row = self.array[..., i, j, :]
        return {
            name: np.broadcast_to(row[..., column], (self.worlds,)).copy() for column, name in enumerate(PROPERTIES)
        }

    def put(self, materials: MaterialTable, world: int) -> None:
        """Write the numbers of a world into a table of words, where they are not the same already."""
        rows = self.array if self.array.ndim == 3 else self.array[world]
        was = materials.to_array(self.names)
        for i, a in enumerate(self.names):
            for j, b in enumerate(self.names[: i + 1]):
                if (rows[i, j, : len(PROPERTIES)] != was[i, j, : len(PROPERTIES)]).any():
                    numbers: dict[str, Any] = {name: float(rows[i, j, k]) for k, name in enumerate(PROPERTIES)}
                    materials.set_pair(a, b, **numbers)


def _numbers(label: str, value: ArrayLike, count: int, name: str) -> Array:
    """One number a world, within the range of its kind."""
    try:
        numbers = np.broadcast_to(np.asarray(value, np.float64), (count,))
    except (TypeError, ValueError):
        raise InvalidInputError(f"{label} must be a number or ({count},) numbers, got {value!r}.") from None
    most = 1.0 if name == "restitution" else np.inf
    wrong = ~((numbers >= 0.0) & (numbers <= most) & np.isfinite(numbers))
    if wrong.any():
        allowed = "between 0 and 1" if name == "restitution" else "finite and 0 or more"
        raise InvalidInputError(f"{label} must be {allowed}, got {float(numbers[wrong][0])!r}.")
    return numbers
