"""Fingerprints of a world's state, bit for bit, and what decides about the last bits."""

from __future__ import annotations

import functools
import hashlib
import os
import platform
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Words = NDArray[np.uint64]

STATE_WIDTH = 13
"""Numbers a body of a state: position (3, m), orientation (4), velocity (3, m/s), angular velocity (3, rad/s)."""
PARTS = {
    "positions": slice(0, 3),
    "orientations": slice(3, 7),
    "velocities": slice(7, 10),
    "angular_velocities": slice(10, 13),
}
"""Where each of them is, under the name of the world's array."""

AT_ONCE = 1 << 16
"""Words that are hashed at once: they stay in the cache, and Python is asked for seldom."""
_MASK = (1 << 64) - 1


def state_hash(steps: int, state: Array) -> str:
    """A cryptographic hash of a state, 32 hexadecimal digits.

    Args:
        steps: taken so far.
        state: (n, 13), see :data:`STATE_WIDTH`.
    """
    digest = hashlib.blake2b(str(steps).encode(), digest_size=16)
    for part in PARTS.values():
        digest.update(np.ascontiguousarray(state[:, part]).tobytes())
    return digest.hexdigest()


class Fingerprint:
    """A quick hash of a state in 64 bits, for every step of a recording: some 30 us for a thousand bodies.

    Every word of the state is folded, so that its high bits reach the low ones, multiplied with an odd number that
    belongs to its place, and summed up modulo 2^64 (multilinear hashing: Carter and Wegman, "Universal classes of hash
    functions", 1979). One word that differs by any bits always changes the sum; several hide each other by chance once
    in 2^32 times or more rarely, and would have to do so again in every step that follows. It is no protection against
    forgery; :func:`state_hash` is.
    """

    def __init__(self) -> None:
        self._scratch: Words = np.zeros((0, 0), np.uint64)

    def __call__(self, steps: int, state: Array) -> int:
        """Of a contiguous state (n, 13) after ``steps`` steps."""
        return self.of_steps(steps, state[None])[0]

    def of_steps(self, first: int, states: Array) -> list[int]:
        """Of contiguous states (k, n, 13), one a step, the first one after ``first`` steps."""
        k, n = states.shape[:2]
        words = states.reshape(k, -1).view(np.uint64)
        weights, sums = _weights(words.shape[1]), []
        at_once = max(1, AT_ONCE // max(1, words.shape[1]))
        for start in range(0, k, at_once):
            part = words[start : start + at_once]
            if self._scratch.shape != part.shape:
                self._scratch = np.empty_like(part)
            mixed = self._scratch
            np.right_shift(part, np.uint64(32), out=mixed)
            np.bitwise_xor(part, mixed, out=mixed)
            np.multiply(mixed, weights, out=mixed)
            sums += np.add.reduce(mixed, axis=1).tolist()
        return [_scramble(total ^ _scramble(first + step) ^ n) for step, total in enumerate(sums)]


@functools.lru_cache(maxsize=8)
def _weights(count: int) -> Words:
    """Odd numbers that look like chance: the first ``count`` of splitmix64 (Steele, Lea and Flood, 2014)."""
    z = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    result: Words = (z ^ (z >> np.uint64(31))) | np.uint64(1)
    return result


def _scramble(z: int) -> int:
    """The last part of splitmix64, which is one to one."""
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
    return z ^ (z >> 31)


def machine_class() -> str:
    """What decides about the last bits: instruction set, fused multiply-add in the C library, the C library itself."""
    import llvmlite.binding as llvm

    binding: Any = llvm
    try:
        libc = os.confstr("CS_GNU_LIBC_VERSION") or ""
    except (AttributeError, ValueError, OSError):
        libc = ""
    fused = "fma" if binding.get_host_cpu_features().get("fma") else "no fma"
    return ", ".join([platform.system(), platform.machine(), libc or "other C library", fused])
