"""Running a sweep: what is finished stays finished, what fails is a row, what dies is done again.

The driver runs the first points itself. That compiles the kernels of the scene into the cache folder before any worker
starts, so that none of them compiles what another one is compiling, and it tells how long a run takes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from stiction.errors import OutputError, StictionError
from stiction.sweep import table
from stiction.sweep.backends import Backend, Report, Work
from stiction.sweep.batches import Queue
from stiction.sweep.journal import Folder, JournalWriter, Row
from stiction.sweep.load import Sweep
from stiction.sweep.points import Point
from stiction.sweep.runner import run_batch, worker_name

MOST_ATTEMPTS = 3
"""How often a run may take its worker with it before that is its result."""
FIRST_RUNS = 3
"""Runs of the driver itself: the first compiles or loads the kernels, the others tell how long a run takes."""
MOST_DEATHS = 5
"""Batches in a row whose worker died without a single finished run: then it is not the runs that are at fault."""


class SweepError(StictionError, RuntimeError):
    """The workers of a sweep cannot work. What was finished is kept."""


class Progress(NamedTuple):
    """How far a sweep is.

    Attributes:
        phase: in a few words. done: finished runs, earlier sessions included. total: all runs.
        failed: finished ones with an error. rate: runs per second as of late, 0 while unknown.
        left: s until the end at that rate, NaN while unknown.
    """

    phase: str
    done: int
    total: int
    failed: int
    rate: float
    left: float


@dataclass(frozen=True)
class Outcome:
    """What a sweep came to.

    Attributes:
        columns: the table, see :func:`stiction.sweep.table.collect`. path: its file.
        total: runs of the sweep. done: finished ones in the table. failed: of them, those with an error.
        found: finished in earlier sessions. deaths: batches whose worker died.
        seconds: wall time of this session. rate: runs per second while the workers were at work, 0 if they had none.
        interrupted: by Ctrl-C. workers: how many there were.
    """

    columns: table.Columns
    path: Path
    total: int
    done: int
    failed: int
    found: int
    deaths: int
    seconds: float
    rate: float
    interrupted: bool
    workers: int


def run_sweep(
    sweep: Sweep,
    out: str | Path,
    backend: Callable[[], Backend],
    *,
    path: str | Path | None = None,
    resume: bool = False,
    retry: bool = False,
    on_progress: Callable[[Progress], None] | None = None,
) -> Outcome:
    """Run what is not yet finished of a sweep, and write its table.

    Args:
        sweep: what to run.
        out: its folder; journals are kept in it.
        backend: makes what runs the batches; called when the kernels are ready, and only if there is work for it.
        path: of the table; ``table.parquet`` in the folder if left out.
        resume: go on with what the folder holds; otherwise it must hold no finished runs.
        retry: do failed runs again.
        on_progress: told after every batch.

    Returns:
        The outcome, also after Ctrl-C: then it is marked as interrupted, and has what was finished.

    Raises:
        OutputError: the folder or the table cannot be written, another sweep is at work there, or it has finished runs
            and ``resume`` is False.
        SweepError: workers die one after the other without finishing a run.
    """
    folder = Folder(Path(out).resolve())
    folder.make()
    target = table.check_path("--table", path or folder.path / "table.parquet", make_folder=True)
    with folder.driving():
        session = _Session(sweep, folder, resume, retry, on_progress)
        interrupted = False
        try:
            session.run(backend)
        except KeyboardInterrupt:
            interrupted = True
        finally:
            folder.end_session()
            folder.wait_for_workers()
        return session.outcome(target, interrupted)


class _Session:
    """One driver's life."""

    def __init__(
        self, sweep: Sweep, folder: Folder, resume: bool, retry: bool, on_progress: Callable[[Progress], None] | None
    ) -> None:
        self.sweep, self.folder = sweep, folder
        self._tell = on_progress
        self._began = time.perf_counter()
        self._workers_began = self._began
        self._by_workers = 0
        self._rate = 0.0
        self.workers = 0
        self.deaths = 0
        self._total = len(sweep.points)
        self._done, self._failed = 0, 0
        self._say("reading what is finished")
        self.token = folder.begin_session()
        folder.wait_for_workers(lambda: self._say("waiting for workers of an earlier driver"))
        before = folder.read()
        if before.rows and not resume:
            raise OutputError(
                f"--out must be a folder without finished runs, and {str(folder.path)!r} has {len(before.rows)}: "
                "go on with --resume, or name another folder."
            )
        self._attempts = before.attempts
        keep = {run for run, row in before.rows.items() if not (retry and row["error"] is not None)}
        self._finished = {point.run for point in sweep.points if point.run in keep} if keep else set()
        self._failed = sum(before.rows[run]["error"] is not None for run in self._finished)
        self._done = self.found = len(self._finished)
        del before

    def run(self, backend: Callable[[], Backend]) -> None:
        """All that is left."""
        work = Work(self.sweep.job.to_json(), str(self.folder.path), self.token)
        pending = self._pending()
        seconds = self._first_runs(work, pending)
        if self._done == self._total:
            return
        self._say("starting workers")
        hands = backend()
        self.workers = hands.workers
        queue = Queue(pending, self._total - self._done, hands.workers, seconds)
        self._workers_began = time.perf_counter()
        vain = 0
        reports = hands.run(work, queue.take)
        try:
            for report in reports:
                before = self._done
                left = self._take_in(report)
                if report.answer is not None:
                    queue.learn(len(report.answer.done), report.answer.seconds)
                    self._rate = hands.workers / queue.seconds
                queue.put_back(left)
                vain = 0 if self._done > before else vain + 1
                if vain >= MOST_DEATHS * hands.workers:
                    raise SweepError(f"workers must be able to work, and {vain} died in a row ({report.died}).")
                self._say("running")
        finally:
            self.folder.end_session()  # before the workers are waited for, so that they stop soon
            reports.close()  # type: ignore[attr-defined]  # every backend's run is a generator

    def outcome(self, target: Path, interrupted: bool) -> Outcome:
        """The table and the numbers."""
        self._say("writing the table")
        rows = self.folder.read().rows
        columns = table.collect(self.sweep, rows)
        table.write(self.sweep, columns, target)
        spent = time.perf_counter() - self._workers_began
        done = len(columns["run"])
        return Outcome(
            columns=columns,
            path=target,
            total=self._total,
            done=done,
            failed=sum(error is not None for error in columns["error"]),
            found=self.found,
            deaths=self.deaths,
            seconds=time.perf_counter() - self._began,
            rate=self._by_workers / spent if self._by_workers else 0.0,
            interrupted=interrupted,
            workers=self.workers,
        )

    def _pending(self) -> Iterator[Point]:
        """The points that are not finished; those that have cost too many workers become rows here."""
        for point in self.sweep.points:
            if point.run in self._finished:
                continue
            if self._attempts.get(point.run, 0) >= MOST_ATTEMPTS:
                self._give_up(point)
            else:
                yield point

    def _first_runs(self, work: Work, pending: Iterator[Point]) -> float:
        """Run the first points here; returns the s that a run takes."""
        seconds = 1.0
        self._say("first runs, which may compile kernels")
        for point in islice(pending, FIRST_RUNS):
            began = time.perf_counter()
            answer = run_batch(work.job, [point], work.folder, work.session)
            seconds = time.perf_counter() - began
            self._count(answer.done, answer.failed)
            self._say("first runs")
        return seconds

    def _take_in(self, report: Report) -> list[Point]:
        """Count what a batch has finished, and return the points of it that are left."""
        answer = report.answer
        if answer is not None:
            if answer.rows is not None:
                with JournalWriter(self.folder, self.token, worker_name()) as journal:
                    for run, row in zip(answer.done, answer.rows, strict=True):
                        journal.finished(run, row)
            self._count(answer.done, answer.failed)
            self._by_workers += len(answer.done)
            return [point for point in report.batch if point.run not in set(answer.done)]
        self.deaths += 1
        found = self.folder.read(since=self.token)
        mine = [point.run for point in report.batch if point.run in found.rows]
        self._count(mine, sum(found.rows[run]["error"] is not None for run in mine))
        self._by_workers += len(mine)
        left = []
        for point in report.batch:
            if point.run in found.rows:
                continue
            if self._attempts.get(point.run, 0) + found.attempts.get(point.run, 0) >= MOST_ATTEMPTS:
                self._give_up(point, report.died)
            else:
                left.append(point)
        return left

    def _give_up(self, point: Point, died: str = "") -> None:
        """Make a row of a run that kills its workers."""
        how = f" ({died})" if died else ""
        row: Row = {
            "metrics": {},
            "error": f"the worker died during this run, {MOST_ATTEMPTS} times{how}.",
            "warning": None,
            "steps": 0,
            "state_hash": None,
            "wall_seconds": 0.0,
            "worker": worker_name(),
        }
        with JournalWriter(self.folder, self.token, worker_name()) as journal:
            journal.finished(point.run, row)
        self._count([point.run], 1)

    def _count(self, done: Iterable[str], failed: int) -> None:
        self._done += len(list(done))
        self._failed += failed

    def _say(self, phase: str) -> None:
        if self._tell is None:
            return
        left = (self._total - self._done) / self._rate if self._rate else float("nan")
        self._tell(Progress(phase, self._done, self._total, self._failed, self._rate, left))
