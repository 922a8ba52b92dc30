"""What a sweep will cost, found out by running a few of its points."""

from __future__ import annotations

import json
import statistics
import time
from dataclasses import dataclass
from typing import Any

from stiction.sweep.load import Sweep
from stiction.sweep.runner import Runner

MOST_TRIED = 9
"""Points that are run to see how long they take, spread over the sweep."""
SECONDS = 10.0
"""Wall time after which no further point is tried."""
WORKER_START = 1.5
"""s until a worker has started and loaded its kernels."""


@dataclass(frozen=True)
class SweepPlan:
    """What is to be expected of a sweep.

    Attributes:
        runs: all of them. steps: of a run that goes through. parameters: name to how many different values it takes.
        seconds_per_run: median over the points tried, in one process. slowest: of them, s. tried: how many.
        failed: how many of those failed. first_error: the sentence of the first one that did.
        workers: at work at a time. seconds: estimate for all runs with them, s.
        journal_bytes, table_bytes: estimates for all runs.
    """

    runs: int
    steps: int
    parameters: dict[str, int]
    seconds_per_run: float
    slowest: float
    tried: int
    failed: int
    first_error: str | None
    workers: int
    seconds: float
    journal_bytes: int
    table_bytes: int

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return dict(vars(self))


def make_plan(sweep: Sweep, workers: int) -> SweepPlan:
    """Run some points of a sweep, keep nothing, and say what all of them will cost.

    Args:
        sweep: the sweep.
        workers: that it will have.
    """
    runner = Runner(sweep.job)
    total = len(sweep.points)
    count = min(MOST_TRIED, total)
    places = [round(k * (total - 1) / max(count - 1, 1)) for k in range(count)]
    runner.run(sweep.points[places[0]].values)  # compiles or loads the kernels; not timed
    began, seconds, rows, lengths = time.perf_counter(), [], [], []
    for place in places:
        point = sweep.points[place]
        started = time.perf_counter()
        row = runner.run(point.values)
        lines = json.dumps({"run": point.run}), json.dumps({"run": point.run, "row": row})
        seconds.append(time.perf_counter() - started)
        rows.append(row)
        lengths.append(sum(len(line) + 2 for line in lines))
        if time.perf_counter() - began > SECONDS:
            break
    errors = [row["error"] for row in rows if row["error"]]
    per_run = statistics.fmean(seconds)
    # a row of the table: id and hash as texts, the worker and the errors by reference, everything else 8 bytes at most
    row_bytes = 20 + 32 + 8 * (4 + len(sweep.points.names) + len(sweep.job.metrics))
    return SweepPlan(
        runs=total,
        steps=max(row["steps"] for row in rows),
        parameters={name: sweep.points.sizes[name] for name in sweep.points.names},
        seconds_per_run=statistics.median(seconds),
        slowest=max(seconds),
        tried=len(seconds),
        failed=len(errors),
        first_error=errors[0] if errors else None,
        workers=workers,
        seconds=total * per_run / workers + WORKER_START,
        journal_bytes=round(total * statistics.fmean(lengths)),
        table_bytes=total * row_bytes,
    )
