"""Ctrl-C while a file is being written: held back until it is whole again, and then heard for certain."""

from __future__ import annotations

import importlib
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

# what lies below module signal, which looks for a name of each handler first: 100 us when nothing of it is in a cache
_below: Any = importlib.import_module("_signal")


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Within it SIGINT waits; at its end it is handled as it would have been.

    h5py frees its handles in callbacks of weak references, and Python ignores an exception that is raised in one of
    those. A Ctrl-C that arrives while HDF5 is at work is handled in the next line of Python, which often is such a
    callback: the KeyboardInterrupt would be lost and the run go on (seen with h5py 3.16 and Python 3.11).

    Only the main thread handles signals, so in another one this does nothing; nor does it where SIGINT has no handler.
    """
    handler = _below.getsignal(signal.SIGINT)
    if not callable(handler) or threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[tuple[int, FrameType | None]] = []
    _below.signal(signal.SIGINT, lambda number, frame: held.append((number, frame)))
    try:
        yield
    finally:
        _below.signal(signal.SIGINT, handler)
        if held:
            handler(*held[-1])
