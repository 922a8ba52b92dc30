"""Directions of pairs that are apart, in one number."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as some

from stiction.core.apart import TINY, pack, unpack
from stiction.core.vec import Vec3

from .support import compiled

NUMBERS = some.floats(-1e3, 1e3)


@given(x=NUMBERS, y=NUMBERS, z=NUMBERS)
def test_a_direction_comes_back_to_a_millionth(x: float, y: float, z: float) -> None:
    longest = max(abs(x), abs(y), abs(z))
    number = compiled(pack)(Vec3(x, y, z))
    assert number > 0 if longest > TINY else number == 0
    if number:
        back = compiled(unpack)(number)
        np.testing.assert_allclose([back.x, back.y, back.z], np.array([x, y, z]) / longest, rtol=0, atol=1e-6)


def test_of_all_signs(rng: np.random.Generator) -> None:
    for _ in range(100):
        v = rng.normal(size=3)
        back = compiled(unpack)(compiled(pack)(Vec3(*v)))
        np.testing.assert_array_equal(np.sign([back.x, back.y, back.z]), np.sign(v))
