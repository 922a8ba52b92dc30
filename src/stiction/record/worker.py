"""The thread that writes a recording, so that the simulation need not wait for it."""

from __future__ import annotations

import queue
import threading
import time
from collections import deque

import numpy as np
from numpy.typing import NDArray

from stiction.record.file_writer import Batch, FileWriter

Array = NDArray[np.float64]

WAITING = 8
"""Batches that may wait; when there are more, the simulation does."""
POLL_SECONDS = 1e-3
"""How often it looks then whether there is room."""
COMMIT_SECONDS = 0.5
"""What is ready is written after that time, and the rest the next time: little is lost when a process is killed."""
IDLE_SECONDS = 1.0
"""When nothing has come for that time, everything is written."""


class Worker:
    """Feeds a file from a thread of its own, until :meth:`close`."""

    def __init__(self, file: FileWriter) -> None:
        self._file = file
        self._queue: queue.SimpleQueue[Batch | threading.Event | None] = queue.SimpleQueue()
        self._failure: BaseException | None = None
        self._free: deque[Array] = deque(maxlen=WAITING)
        self._thread = threading.Thread(target=self._run, name="stiction recording", daemon=True)
        self._thread.start()

    def put(self, batch: Batch) -> None:
        """Hand over a batch.

        Raises:
            OutputError: what was handed over before could not be written.
        """
        self._raise()
        while self._queue.qsize() >= WAITING:  # a queue with a limit takes 50 us more for each batch
            time.sleep(POLL_SECONDS)
        self._queue.put(batch)

    def room(self, shape: tuple[int, ...]) -> Array:
        """Memory for the states of a batch: that of one that has been written, which is faster than new memory."""
        while self._free:
            room = self._free.pop()  # the last one that was read, of which most is in a cache
            if room.shape == shape:
                return room
        return np.empty(shape)

    def flush(self) -> None:
        """Wait until all that was handed over is in the file.

        Raises:
            OutputError: it could not be written.
        """
        done = threading.Event()
        self._queue.put(done)
        done.wait()
        self._raise()

    def close(self, outcome: str) -> None:
        """Write everything and how it ended, and end the thread.

        Raises:
            OutputError: something could not be written.
        """
        self._queue.put(None)
        self._thread.join()
        self._file.close(outcome)
        self._raise()

    def _raise(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        committed = time.monotonic()
        pending = False
        while True:
            try:
                one = self._queue.get(timeout=IDLE_SECONDS if pending else None)
            except queue.Empty:
                one = threading.Event()  # nothing comes: write what is there, as if somebody had asked
            if one is None:
                return
            try:
                if self._failure is not None:
                    pass  # the file takes no more
                elif isinstance(one, Batch):
                    self._file.process(one)
                    if one.room is not None:
                        self._free.append(one.room)
                    pending, now = True, time.monotonic()
                    if now - committed > COMMIT_SECONDS:
                        self._file.commit(everything=False)
                        committed = now
                else:
                    self._file.commit(everything=True)
                    pending, committed = False, time.monotonic()
            except BaseException as error:
                self._failure = error
            if isinstance(one, threading.Event):
                one.set()
