"""Copies past the caches are copies."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from stiction.core.streaming import fence, stream, stream_columns


@pytest.mark.parametrize("n", [0, 1, 7, 300])
def test_columns_arrive_and_nothing_else_is_touched(n: int) -> None:
    bodies = np.random.default_rng(n).normal(size=(n + 3, 60))
    bodies[0, 3] = -0.0
    flat = np.full(13 * n + 9, np.nan)
    stream_columns(bodies, n, 3, 13, flat, 4)
    assert flat[4 : 4 + 13 * n].tobytes() == bodies[:n, 3:16].tobytes()
    assert np.isnan(np.delete(flat, np.arange(4, 4 + 13 * n))).all()


def test_another_thread_sees_what_was_streamed() -> None:
    bodies, flat = np.arange(52.0).reshape(4, 13), np.zeros(52)
    seen: list[bytes] = []
    copied = threading.Event()

    def look() -> None:
        copied.wait()
        seen.append(flat.tobytes())

    reader = threading.Thread(target=look)
    reader.start()
    stream_columns(bodies, 4, 0, 13, flat, 0)
    copied.set()
    reader.join()
    assert seen == [bodies.tobytes()]


def test_in_plain_python_it_is_an_assignment() -> None:
    flat = np.zeros(3)
    stream(flat, 1, 2.5)
    fence()
    assert flat.tolist() == [0.0, 2.5, 0.0]
