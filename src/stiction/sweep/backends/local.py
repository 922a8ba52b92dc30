"""Backends on this machine: a few processes that live as long as the sweep, or this process alone.

Each worker is ``python -m stiction.sweep.worker``: batches go in as lines of JSON, answers come out. A process pool of
the standard library would be less code, but there the death of one worker breaks the whole pool, and every run that was
under way with it; here it costs one run and the start of one process.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

from stiction.bench.worker import THREADS
from stiction.sweep.backends import Report, Take, Work
from stiction.sweep.points import Point
from stiction.sweep.runner import Answer, run_batch

GRACE = 20.0
"""s that a worker has to finish the run that it is at when the sweep is stopped."""
LAST_GRACE = 5.0
"""s that it has after that to leave the run."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class InlineBackend:
    """This process, one batch after the other: for tests, for debuggers, and to see what a worker costs."""

    name = "inline"
    workers = 1

    def run(self, work: Work, take: Take) -> Iterator[Report]:
        """See :class:`stiction.sweep.backends.Backend`."""
        while batch := take():
            yield Report(batch, run_batch(work.job, batch, work.folder, work.session))


class LocalBackend:
    """Processes on this machine, each with one thread.

    Args:
        workers: how many; one for each core if left out.
    """

    name = "local"

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or cores()

    def run(self, work: Work, take: Take) -> Iterator[Report]:
        """See :class:`stiction.sweep.backends.Backend`."""
        heard: queue.SimpleQueue[tuple[_Worker, str]] = queue.SimpleQueue()
        busy: set[_Worker] = set()
        idle: list[_Worker] = []
        try:
            while True:
                while len(busy) < self.workers and (batch := take()):
                    worker = idle.pop() if idle else _Worker(work, heard)
                    busy.add(worker)
                    worker.give(batch)
                if not busy:
                    return
                worker, line = heard.get()
                if worker not in busy:  # it died while it had nothing to do
                    idle = [other for other in idle if other is not worker]
                    worker.let_go()
                    continue
                busy.discard(worker)
                report = worker.report(line)
                if report.answer is None:
                    worker.let_go()
                else:
                    idle.append(worker)
                yield report
        finally:
            everyone = [*busy, *idle]
            for worker in everyone:
                worker.let_go()
            until = time.monotonic() + GRACE
            for worker in everyone:
                worker.end(until)


class _Worker:
    """One process, and a thread that listens to it."""

    def __init__(self, work: Work, heard: queue.SimpleQueue[tuple[_Worker, str]]) -> None:
        command = [sys.executable, "-m", "stiction.sweep.worker"]
        environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
        # a session of its own: Ctrl-C reaches the driver alone, which lets every worker finish its run
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )
        self._batch: list[Point] = []
        self._send({"job": work.job, "folder": work.folder, "session": work.session})
        threading.Thread(target=self._listen, args=(heard,), daemon=True).start()

    def give(self, batch: list[Point]) -> None:
        """Hand over a batch; if the process is dead, its end is heard soon."""
        self._batch = batch
        self._send(batch)

    def report(self, line: str) -> Report:
        """What a line that it wrote says about its batch; an empty one is its end."""
        if line:
            return Report(self._batch, Answer(*json.loads(line)))
        return Report(self._batch, None, _death(self._process.wait()))

    def let_go(self) -> None:
        """Ask it to end after what it is at."""
        try:
            if self._process.stdin:
                self._process.stdin.close()
        except OSError:
            pass  # it is dead

    def end(self, until: float) -> None:
        """Wait for it until then (monotonic, s); if that is not enough, make it leave its run, and at last kill it."""
        for stop in (self._process.terminate, self._process.kill):
            try:
                self._process.wait(max(0.0, until - time.monotonic()))
                return
            except subprocess.TimeoutExpired:
                stop()
                until = time.monotonic() + LAST_GRACE
        self._process.wait()

    def _send(self, message: Any) -> None:
        stream = self._process.stdin
        try:
            if stream:
                stream.write(json.dumps(message) + "\n")
                stream.flush()
        except OSError:
            pass  # dead, and heard of by the thread that listens

    def _listen(self, heard: queue.SimpleQueue[tuple[_Worker, str]]) -> None:
        stream = self._process.stdout
        if stream:
            with stream:
                for line in stream:
                    if line.endswith("\n"):
                        heard.put((self, line))
        heard.put((self, ""))


def _death(status: int) -> str:
    if status < 0:
        return f"killed by {signal.Signals(-status).name}"
    return f"ended with exit status {status}"
