"""Contact problems in the text format of Siconos (numerics, ``frictionContact_printInFile``).

Numbers in free form: dimension, number of contacts, the matrix, q, mu. The matrix begins with its storage (0 dense,
1 blocks), its rows and its columns.

    dense    rows and columns once more, then all entries by columns
    blocks   number of blocks, block rows, block columns; where each block row ends, where each block column ends;
             lengths of two index lists; row pointers; block columns; then each block: its number, entries by columns

What may follow mu is left alone: some files end with a flag.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.errors import InvalidInputError, NotYetError, OutputError
from stiction.problems.blocks import BlockMatrix

if TYPE_CHECKING:
    from stiction.problems.problem import ContactProblem

DENSE, BLOCKS = 0, 1
LARGEST = 10_000_000
"""More contacts or blocks than this in the first lines are no contact problem but some other file of numbers."""


class _Numbers:
    """The numbers of a file, one after the other, with what was expected when they run out."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            text = path.read_bytes().decode("ascii")
            words = text.split()
            self.values = np.array(words, dtype=np.float64) if words else np.zeros(0)
        except OSError as error:
            raise InvalidInputError(f"{path} cannot be read: {error.strerror or error}.") from None
        except ValueError:
            raise self.wrong("neither FCLIB's HDF5 nor Siconos' text: it is not made of numbers alone") from None
        self.at = 0

    def wrong(self, what: str) -> InvalidInputError:
        return InvalidInputError(f"{self.path} is {what}.")

    def take(self, count: int, what: str) -> NDArray[np.float64]:
        if self.at + count > len(self.values):
            left = len(self.values) - self.at
            raise self.wrong(f"cut short: {what} must be {count} numbers, {left} are left")
        self.at += count
        return self.values[self.at - count : self.at]

    def whole(self, count: int, what: str, *, most: int = LARGEST) -> NDArray[np.int64]:
        found = self.take(count, what)
        if not ((found == np.floor(found)) & (found >= 0) & (found <= most)).all():
            bad = found[~((found == np.floor(found)) & (found >= 0) & (found <= most))][0]
            raise self.wrong(f"not Siconos' text: {what} must be whole numbers up to {most}, got {bad:g}")
        return found.astype(np.int64)


def read(path: Path) -> ContactProblem:
    """The problem in a text file.

    Raises:
        InvalidInputError: it is cut short or says something impossible; the sentence names the file.
        NotYetError: the problem is planar, or its matrix is stored in CSparse's form.
    """
    from stiction.problems.problem import ContactProblem

    numbers = _Numbers(path)
    dimension, n, storage, rows, columns = numbers.whole(5, "dimension, contacts, storage, rows and columns").tolist()
    if dimension != 3:
        raise NotYetError(f"{path}: the dimension must be 3, got {dimension}; planar problems are not read.")
    if storage not in (DENSE, BLOCKS):
        raise NotYetError(f"{path}: the storage of the matrix must be 0 (dense) or 1 (blocks), got {storage}.")
    if n < 1 or rows != 3 * n or columns != 3 * n:
        raise numbers.wrong(f"impossible: {n} contacts with a matrix of {rows} x {columns}")
    W = _dense(numbers, 3 * n) if storage == DENSE else _blocks(numbers, n)
    q = numbers.take(3 * n, "q")
    mu = numbers.take(n, "mu")
    try:
        return ContactProblem(W, q, mu, title=path.name.partition(".")[0])
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None


def _dense(numbers: _Numbers, size: int) -> NDArray[np.float64]:
    if numbers.whole(2, "rows and columns").tolist() != [size, size]:
        raise numbers.wrong(f"impossible: the dense matrix is not {size} x {size} as said before")
    return numbers.take(size * size, "the dense matrix").reshape(size, size).T


def _blocks(numbers: _Numbers, n: int) -> BlockMatrix:
    count, *sides = numbers.whole(3, "numbers of blocks, block rows and block columns").tolist()
    if sides != [n, n]:
        raise numbers.wrong(f"impossible: {n} contacts with {sides[0]} x {sides[1]} blocks")
    ends = numbers.whole(2 * n, "ends of block rows and columns")
    if (ends != np.tile(3 * np.arange(1, n + 1), 2)).any():
        raise numbers.wrong("impossible: its blocks are not all 3 x 3")
    if numbers.whole(2, "lengths of the index lists").tolist() != [n + 1, count]:
        raise numbers.wrong(f"impossible: the index lists must have {n + 1} and {count} entries")
    pointers = numbers.whole(n + 1, "row pointers", most=count)
    columns = numbers.whole(count, "block columns", most=n - 1)
    if pointers[0] != 0 or pointers[-1] != count or (np.diff(pointers) < 0).any():
        raise numbers.wrong(f"impossible: row pointers must rise from 0 to {count}")
    with_names = numbers.take(10 * count, "the blocks, each with its number").reshape(count, 10)
    if (with_names[:, 0] != np.arange(count)).any():
        raise numbers.wrong("impossible: its blocks are not numbered in turn")
    data = with_names[:, 1:].reshape(count, 3, 3).transpose(0, 2, 1)
    rows = np.repeat(np.arange(n), np.diff(pointers))
    i = 3 * rows[:, None, None] + np.arange(3)[None, :, None] + np.zeros((1, 1, 3), np.int64)
    j = 3 * columns[:, None, None] + np.arange(3)[None, None, :] + np.zeros((1, 3, 1), np.int64)
    try:
        return BlockMatrix.of_triplets(i.ravel(), j.ravel(), data.ravel(), (3 * n, 3 * n))
    except InvalidInputError as error:
        raise InvalidInputError(f"{numbers.path}: {error}") from None


def write(problem: ContactProblem, path: Path) -> None:
    """Write W by blocks, q and mu, with as many digits as float64 has.

    Raises:
        OutputError: the file cannot be written.
    """
    W, n = problem.W, problem.contacts
    count = len(W.indices)
    ends = "\t".join(str(3 * k) for k in range(1, n + 1))
    lines = ["3", str(n), str(BLOCKS), str(3 * n), str(3 * n), str(count), str(n), str(n), ends, ends]
    lines += [str(n + 1), str(count), _row(W.pointers), _row(W.indices)]
    for k, block in enumerate(W.data):
        lines.append(str(k))
        lines += [f"{value:32.24e}" for value in block.T.ravel().tolist()]
    lines += [" ".join(f"{value:32.24e}" for value in vector.tolist()) for vector in (problem.q, problem.mu)]
    try:
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error}.") from None


def _row(numbers: NDArray[np.int64]) -> str:
    return "\t".join(str(number) for number in numbers.tolist())
