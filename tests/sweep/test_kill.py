"""``kill -9`` and Ctrl-C in the middle: no finished run is lost, none is done again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from stiction.sweep import Outcome, Sweep, load, make_backend, run_sweep

from .support import SLOW, busiest_to_come, finished, worker_pids

PATIENCE = 120.0
"""s until a sweep that does nothing is given up: workers may have to wait for a busy machine."""

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no kill -9")


def wait_until(holds: Callable[[], bool]) -> None:
    until = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < until, "the sweep does not get on"
        time.sleep(0.02)


def run_and_kill_a_worker(sweep: Sweep, folder: Path, backend: str) -> Outcome:
    """The outcome with two workers, one of which is killed once both have finished runs."""

    def kill_one() -> None:
        wait_until(lambda: busiest_to_come(folder) is not None)
        os.kill(busiest_to_come(folder) or 0, signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    outcome = run_sweep(sweep, folder, lambda: make_backend(backend, 2))
    killer.join()
    return outcome


@contextmanager
def driver(spec: Path, folder: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    """``stiction sweep`` in a process of its own."""
    command = [sys.executable, "-m", "stiction.cli.main", "sweep", str(spec), "--out", str(folder), *options]
    with subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "slow.toml"
    path.write_text(SLOW)
    return path


def test_a_killed_worker_loses_no_finished_run(spec: Path, tmp_path: Path) -> None:
    folder, sweep = tmp_path / "out", load(spec)
    outcome = run_and_kill_a_worker(sweep, folder, "local")
    assert (outcome.done, outcome.failed, outcome.deaths) == (24, 0, 1)
    assert finished(folder) == {point.run: 1 for point in sweep.points}
    assert len(worker_pids(folder)) == 4, "the driver, two workers, and one for the one that was killed"
    assert outcome.columns["way"] == pytest.approx([10.0 * v for v in outcome.columns["v"]], rel=1e-9)


def test_a_killed_driver_loses_no_finished_run(spec: Path, tmp_path: Path) -> None:
    folder, sweep = tmp_path / "out", load(spec)
    with driver(spec, folder, "--workers", "1") as process:
        wait_until(lambda: len(finished(folder)) >= 5 and len(worker_pids(folder)) == 2)
        process.kill()
        process.wait()
        # at once: the worker of the killed driver may still be at a run, which is waited for and kept
        outcome = run_sweep(sweep, folder, lambda: make_backend("inline"), resume=True)
    assert outcome.found >= 5 and (outcome.done, outcome.failed) == (24, 0)
    assert finished(folder) == {point.run: 1 for point in sweep.points}


def test_ctrl_c_keeps_a_table_and_says_how_to_go_on(spec: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with driver(spec, folder, "--workers", "1", "--json") as process:
        wait_until(lambda: len(finished(folder)) >= 5 and len(worker_pids(folder)) == 2)
        process.send_signal(signal.SIGINT)
        printed, told = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert f"go on with: stiction sweep {spec} --out {folder} --resume" in told
    result = json.loads(printed)
    assert result["interrupted"] and 5 <= result["done"] < 24
    assert pq.read_table(result["table"]).num_rows == result["done"] == len(finished(folder))
    outcome = run_sweep(load(spec), folder, lambda: make_backend("inline"), resume=True)
    assert (outcome.done, outcome.found) == (24, result["done"])
    assert set(finished(folder).values()) == {1}
