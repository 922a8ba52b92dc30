"""Random numbers for many worlds: a stream for each, so that what a world draws does not depend on the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Draws:
    """Streams of Philox (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011), whose key is the seed
    and the number of the world. A draw costs some microseconds a world."""

    def __init__(self, seed: int, worlds: int) -> None:
        self._seed = seed % 2**64
        self._streams: list[np.random.Generator | None] = [None] * worlds

    def _stream(self, world: int) -> np.random.Generator:
        stream = self._streams[world]
        if stream is None:
            stream = np.random.Generator(np.random.Philox(key=np.array([self._seed, world], np.uint64)))
            self._streams[world] = stream
        return stream

    def uniform(self, worlds: NDArray[np.int64], shape: tuple[int, ...]) -> Array:
        """(len(worlds), *shape) numbers from 0 to below 1."""
        return self._each(worlds, shape, "random")

    def normal(self, worlds: NDArray[np.int64], shape: tuple[int, ...]) -> Array:
        """(len(worlds), *shape) standard normal numbers."""
        return self._each(worlds, shape, "standard_normal")

    def _each(self, worlds: NDArray[np.int64], shape: tuple[int, ...], kind: str) -> Array:
        result = np.empty((len(worlds), *shape))
        for k, world in enumerate(worlds.tolist()):
            result[k] = getattr(self._stream(world), kind)(shape)
        return result
