"""The backend on Ray, where Ray is installed: the same rows to the bit, and kill -9 of a worker loses nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiction.sweep import from_dict, load, make_backend, run_sweep

from .support import SLOW, finished, spec
from .test_kill import run_and_kill_a_worker

pytest.importorskip("ray", reason="Ray is an extra of 250 MB that the suite does without: pip install 'stiction[ray]'")

pytestmark = pytest.mark.filterwarnings("ignore")  # Ray leaves files and sockets to the garbage collector


def test_ray_gives_the_rows_that_this_process_gives(tmp_path: Path) -> None:
    sweep = from_dict(spec())
    here = run_sweep(sweep, tmp_path / "here", lambda: make_backend("inline")).columns
    there = run_sweep(sweep, tmp_path / "there", lambda: make_backend("ray", 2)).columns
    for name in ("run", "v", "way", "state_hash", "error"):
        assert here[name] == there[name]
    assert len(set(there["worker"])) > 1


def test_a_killed_worker_of_ray_loses_no_finished_run(tmp_path: Path) -> None:
    (tmp_path / "slow.toml").write_text(SLOW)
    folder, sweep = tmp_path / "out", load(tmp_path / "slow.toml")
    outcome = run_and_kill_a_worker(sweep, folder, "ray")
    assert (outcome.done, outcome.failed, outcome.deaths) == (24, 0, 1)
    assert finished(folder) == {point.run: 1 for point in sweep.points}
