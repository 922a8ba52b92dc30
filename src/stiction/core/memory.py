"""Memory for arrays that are too large for the processor's table of pages.

Linux hands out memory in pages of 4 kB. A processor remembers where some thousands of them are, 10 to 16 MB in all; a
step over ten thousand bodies goes over more, and waits for the table at every second row. Pages of 2 MB end that, where
the system has them for programs that ask (``madvise``). Elsewhere, and for small arrays, this is ``np.zeros``.
"""

from __future__ import annotations

import math
import mmap
from typing import Any

import numpy as np

HUGE = 1 << 21
"""Bytes of a large page, ..."""
LARGE = 1 << 20
"""... and of an array that gets some: one of half a page is worth one."""


def zeros(shape: tuple[int, ...], dtype: Any = np.float64) -> np.ndarray:
    """An array of zeros, in large pages if it is large."""
    kind = np.dtype(dtype)
    size = math.prod(shape) * kind.itemsize
    if size < LARGE or not hasattr(mmap, "MADV_HUGEPAGE"):
        return np.zeros(shape, kind)
    try:
        # the pages lie at whole multiples of their size, so there has to be room to begin at one
        room = mmap.mmap(-1, (size // HUGE + 2) * HUGE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        room.madvise(mmap.MADV_HUGEPAGE)
    except OSError:
        return np.zeros(shape, kind)
    start = np.frombuffer(room, np.uint8).ctypes.data
    return np.frombuffer(room, np.uint8, size, -start % HUGE).view(kind).reshape(shape)


def refilled(new: Any, old: Any) -> Any:
    """``new``, a tuple of arrays, with as much of the same tuple with other room as both have room for."""
    for source, target in zip(old, new, strict=True):
        both = tuple(slice(min(a, b)) for a, b in zip(source.shape, target.shape, strict=True))
        target[both] = source[both]
    return new
