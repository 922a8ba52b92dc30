"""Arrays in large pages are arrays of zeros like any others."""

from __future__ import annotations

import gc
import pickle
from typing import Any

import numpy as np
import pytest

from stiction.core import memory
from stiction.core.memory import HUGE, LARGE, zeros


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int32, np.uint8])
@pytest.mark.parametrize("rows", [0, 1, 7, LARGE // 64, LARGE + 3])
def test_zeros_are_those_of_numpy(rows: int, dtype: Any) -> None:
    found = zeros((rows, 5), dtype)
    assert found.shape == (rows, 5) and found.dtype == dtype
    assert not found.any()
    assert found.flags.c_contiguous and found.flags.writeable and found.flags.aligned
    found[:] = 1
    assert found.sum() == 5 * rows
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(found[:9])), found[:9])


def test_what_is_large_begins_at_a_page_and_outlives_the_name_of_its_memory() -> None:
    arrays = [zeros((LARGE,)) for _ in range(3)]
    parts = [array[k :: k + 2] for k, array in enumerate(arrays)]
    for k, array in enumerate(arrays):
        array[:] = k
    del array, arrays
    gc.collect()
    assert [part.sum() for part in parts] == [k * len(part) for k, part in enumerate(parts)]
    if hasattr(memory.mmap, "MADV_HUGEPAGE"):
        assert zeros((LARGE,)).ctypes.data % HUGE == 0


def test_where_the_system_refuses_it_is_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise OSError("no large pages")

    monkeypatch.setattr(memory.mmap, "mmap", refuse)
    assert not zeros((LARGE,)).any()
