"""A world's arrays by their addresses, so that a step hands over one array instead of sixty.

Numba unboxes every array of an argument at each call: 0.2 us each, several times what the step of one body takes. So
the store writes down once where its arrays are, and the kernel makes them up again. Such an array owns nothing, and no
references to it are counted: who keeps the book keeps what is in it, and writes another one when an array is replaced.

One book also serves many worlds that are alike: where each of them has its own rows, an array is a block with one more
axis, the first, and its page says how far the rows of one world are from those of the next. The rows of neighbours
follow each other without a gap, so that those of several worlds are read as one array (:func:`rows_at`).

In plain Python (``NUMBA_DISABLE_JIT=1``) a book is the list of the arrays themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numba import extending
from numba.core import types
from numba.np.arrayobj import populate_array

from stiction.core.jit import config

intrinsic: Any = extending.intrinsic  # called with one argument less than it is written with

ADDRESS, STRIDE, SHAPE, PAGE = 0, 1, 2, 5
"""Columns of a book, (arrays, PAGE) int64: address; bytes from one world to the next; lengths of up to three axes."""


class Each(NamedTuple):
    """A block in which each world has its own array: the first axis is that of worlds."""

    block: np.ndarray


def write_book(*parts: Any) -> Any:
    """The book of arrays, of blocks and of tuples of both, one after the other."""
    arrays = list(_flat(parts))
    if config.DISABLE_JIT:
        return arrays
    book = np.zeros((len(arrays), PAGE), np.int64)
    for page, one in zip(book, arrays, strict=True):
        array = one.block if isinstance(one, Each) else one
        if not array.flags.c_contiguous:
            raise ValueError("an array in a book must be contiguous")
        shape = array.shape
        page[ADDRESS] = array.ctypes.data
        if isinstance(one, Each):
            page[STRIDE], shape = array.strides[0], shape[1:]
        page[SHAPE : SHAPE + len(shape)] = shape
    return book


def _flat(parts: Any) -> Iterator[np.ndarray | Each]:
    for part in parts:
        if isinstance(part, tuple) and not isinstance(part, Each):
            yield from _flat(part)
        else:
            yield part


def _reader(axes: int, several: bool = False) -> Any:
    """What reads a page as an array of so many axes: that of one world, or those of several as one."""

    def make_reader(typing, book, k, world, worlds, like):
        number = types.unliteral(like)
        result = types.Array(number, axes, "C")

        def make(context, builder, signature, args):
            pages = context.make_array(signature.args[0])(context, builder, args[0])
            word = context.get_value_type(types.intp)
            first = builder.mul(args[1], word(PAGE))
            words = [builder.load(builder.gep(pages.data, [builder.add(first, word(c))])) for c in range(SHAPE + axes)]
            start = builder.add(words[ADDRESS], builder.mul(words[STRIDE], args[2]))
            array = context.make_array(result)(context, builder)
            itemsize = word(context.get_abi_sizeof(context.get_data_type(number)))
            lengths, strides = words[SHAPE:], [itemsize]
            for length in reversed(lengths[1:]):
                strides.insert(0, builder.mul(strides[0], length))
            if several:
                lengths[0] = builder.mul(lengths[0], args[3])
            address = builder.inttoptr(start, array.data.type)
            populate_array(array, data=address, shape=lengths, strides=strides, itemsize=itemsize, meminfo=None)
            return array._getvalue()

        words = (types.intp, types.intp, types.intp) if several else (types.intp, types.intp)
        return result(book, *words, number), make

    if several:

        @intrinsic
        def rows_at(typing, book, k, world, worlds, like):
            """The rows of so many worlds from this one on, one after the other."""
            return make_reader(typing, book, k, world, worlds, like)

        return rows_at

    @intrinsic
    def array_at(typing, book, k, world, like):
        """The array of a world on page k of a book; ``like`` is a number of its type."""
        return make_reader(typing, book, k, world, 1, like)

    return array_at


def _plain_array_at(book: Any, k: int, world: int, like: Any) -> np.ndarray:
    page = book[k]
    return page.block[world] if isinstance(page, Each) else page


def _plain_rows_at(book: Any, k: int, world: int, worlds: int, like: Any) -> np.ndarray:
    page = book[k]
    if not isinstance(page, Each):
        return page
    block = page.block[world : world + worlds]
    return block.reshape(-1, *block.shape[2:])


if config.DISABLE_JIT:
    vector_at = matrix_at = cube_at = _plain_array_at
    entries_at = rows_at = _plain_rows_at
else:
    vector_at, matrix_at, cube_at = (_reader(axes) for axes in (1, 2, 3))
    entries_at, rows_at = (_reader(axes, several=True) for axes in (1, 2))
