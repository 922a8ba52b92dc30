"""A square matrix of 3 x 3 blocks, row by row: the form in which a sweep over contacts wants W."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Vector = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """Blocks of 3 x 3 in compressed rows; the blocks of one row stand in the order of their columns.

    Attributes:
        pointers: (n + 1,): the blocks of block row i are ``pointers[i]`` to ``pointers[i + 1]``.
        indices: block column of each block, (m,).
        data: the blocks, (m, 3, 3), ``data[k, row, column]``.
    """

    pointers: Index
    indices: Index
    data: Vector

    @property
    def rows(self) -> int:
        """Number of block rows, which is the number of contacts."""
        return len(self.pointers) - 1

    @classmethod
    def of(cls, matrix: Any) -> BlockMatrix:
        """From a dense array or a scipy sparse matrix, (3n, 3n); every diagonal block is there, if only as zeros.

        Raises:
            InvalidInputError: it is not square, not made of blocks of three, or not finite.
        """
        if not hasattr(matrix, "tocoo"):
            dense = np.array(matrix, dtype=np.float64)
            if dense.ndim != 2:
                raise InvalidInputError(f"W must be a matrix, got shape {dense.shape}.")
            i, j = np.nonzero(dense)  # NaN is not zero, so it is still seen below
            return cls.of_triplets(i, j, dense[i, j], dense.shape)
        coo = matrix.tocoo()
        return cls.of_triplets(coo.row, coo.col, coo.data, coo.shape)

    @classmethod
    def of_triplets(cls, i: Any, j: Any, x: Any, shape: tuple[int, ...]) -> BlockMatrix:
        """From entries x at rows i and columns j; entries at the same place are added."""
        i, j, x = np.asarray(i, np.int64), np.asarray(j, np.int64), np.asarray(x, np.float64)
        if len(shape) != 2 or shape[0] != shape[1] or shape[0] % 3:
            raise InvalidInputError(f"W must be (3n, 3n), got shape {tuple(int(k) for k in shape)}.")
        if not np.isfinite(x).all():
            raise InvalidInputError(f"W must be finite, got {x[~np.isfinite(x)][0]}.")
        n = shape[0] // 3
        diagonal = np.arange(n)
        places, where = np.unique(np.concatenate((i // 3 * n + j // 3, diagonal * (n + 1))), return_inverse=True)
        data = np.zeros((len(places), 3, 3))
        np.add.at(data, (where[: len(x)], i % 3, j % 3), x)
        pointers = np.searchsorted(places, np.arange(n + 1) * n) if n else np.zeros(1, np.int64)
        return cls(pointers.astype(np.int64), places % n if n else places, data)

    def sparse(self) -> csr_array:
        """The same as a scipy array in compressed rows, (3n, 3n), without the zeros within blocks."""
        from scipy.sparse import bsr_array

        size = 3 * self.rows
        made = bsr_array((self.data, self.indices, self.pointers), shape=(size, size)).tocsr()
        made.eliminate_zeros()
        made.sort_indices()
        return made

    def dense(self) -> Vector:
        """The same as a dense array, (3n, 3n)."""
        n = self.rows
        made = np.zeros((n, n, 3, 3))
        made[self.row_of_block(), self.indices] = self.data
        return made.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)

    def row_of_block(self) -> Index:
        """Block row of each block, (m,)."""
        return np.repeat(np.arange(self.rows), np.diff(self.pointers))

    def diagonal(self) -> Vector:
        """The diagonal blocks, (n, 3, 3)."""
        return self.data[self.diagonal_places()]

    def diagonal_places(self) -> Index:
        """Where in ``data`` the diagonal blocks stand, (n,)."""
        found: Index = np.flatnonzero(self.indices == self.row_of_block())
        return found

    def times(self, r: Vector) -> Vector:
        """W r for r of shape (n, 3)."""
        products = np.einsum("kij,kj->ki", self.data, r[self.indices])
        made = np.zeros_like(r)
        np.add.at(made, self.row_of_block(), products)
        return made
