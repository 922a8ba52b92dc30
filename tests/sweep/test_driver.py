"""Running sweeps in this process: failures are rows, what is finished is kept, what dies is done again."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from stiction.errors import OutputError
from stiction.sweep import Outcome, Progress, Sweep, SweepError, from_dict, load, make_backend, run_sweep
from stiction.sweep.backends import Report, Take, Work
from stiction.sweep.backends.local import InlineBackend
from stiction.sweep.batches import Queue
from stiction.sweep.figure import classify, compare, draw, expect
from stiction.sweep.journal import Folder, JournalWriter
from stiction.sweep.runner import Answer, Runner

from .support import entries, finished, spec

V2 = {"key": "bodies.crate.velocity[0]", "name": "v"}


def run(sweep: Sweep, folder: Path, **options: Any) -> Outcome:
    return run_sweep(sweep, folder, lambda: make_backend("inline"), **options)


def test_a_sweep_makes_a_table_of_what_came_of_it(tmp_path: Path) -> None:
    sweep = from_dict(spec())
    outcome = run(sweep, tmp_path)
    assert (outcome.total, outcome.done, outcome.failed, outcome.interrupted) == (5, 5, 0, False)
    assert outcome.columns["v"] == [0.5, 0.75, 1.0, 1.25, 1.5]
    assert outcome.columns["way"] == pytest.approx([v**2 / (2 * 0.4 * 9.81) for v in outcome.columns["v"]], rel=0.02)
    stored = pq.read_table(outcome.path)
    assert stored.to_pydict() == outcome.columns
    assert b"slip_distance" in stored.schema.metadata[b"stiction"]
    assert set(finished(tmp_path).values()) == {1}


def test_a_run_that_fails_is_a_row_with_its_error(tmp_path: Path) -> None:
    sweep = from_dict(spec(parameters=[{"key": "bodies.crate.mass", "values": [1, -1, 0, 2]}]))
    outcome = run(sweep, tmp_path)
    assert (outcome.done, outcome.failed) == (4, 2)
    assert outcome.columns["error"][0] is None and outcome.columns["error"][3] is None
    assert outcome.columns["error"][1] == "bodies[1].mass: must be above 0 kg, got -1."
    assert outcome.columns["way"][1] is None and outcome.columns["steps"][1] == 0
    again = run(sweep, tmp_path, resume=True)
    assert (again.found, again.failed, max(finished(tmp_path).values())) == (4, 2, 1)
    retried = run(sweep, tmp_path, resume=True, retry=True)
    assert (retried.found, retried.failed) == (2, 2)


def test_a_world_that_blows_up_and_a_metric_that_cannot_be_are_rows_too() -> None:
    fast = {**V2, "values": [1.0, 1e200, 2.0]}
    row = Runner(from_dict(spec(parameters=[fast])).job).run({"v": 1e200})
    assert row["error"] and row["metrics"] == {}
    odd = from_dict(spec(metrics=[{"name": "way", "value": "position('crate')"}]))
    assert Runner(odd.job).run({"v": 1.0})["error"] == "metric way must be one number, flag or text, got shape (31, 3)."


def test_what_a_run_warns_of_is_in_its_row() -> None:
    sweep = from_dict(spec(parameters=[{"key": "materials.pairs.crate-floor.static", "values": [0.4, 0.1]}]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        row = Runner(sweep.job).run({"static": 0.1})
    assert row["error"] is None and "dynamic" in row["warning"]


def test_derived_keys_and_earlier_metrics_are_used() -> None:
    metrics = [
        {"name": "force", "value": "mean(normal_force('crate')[5:])"},
        {"name": "ratio", "value": "force / (g * v)"},
        {"name": "how", "value": "motion('crate')"},
    ]
    sweep = from_dict(spec(derived=[{"key": "bodies.crate.mass", "value": "3 * v"}], metrics=metrics))
    got = Runner(sweep.job).run({"v": 0.5})["metrics"]
    assert got["ratio"] == pytest.approx(3.0, rel=1e-3)
    assert got["how"] == "sticking"


def test_a_folder_with_finished_runs_wants_resume(tmp_path: Path) -> None:
    run(from_dict(spec()), tmp_path)
    with pytest.raises(OutputError, match=r"without finished runs, and .* has 5: go on with --resume"):
        run(from_dict(spec()), tmp_path)
    finer = from_dict(spec(parameters=[{**V2, "linspace": [0.5, 1.5, 9]}]))
    outcome = run(finer, tmp_path, resume=True)
    assert (outcome.done, outcome.found) == (9, 5)


def test_two_drivers_do_not_share_a_folder(tmp_path: Path) -> None:
    Folder(tmp_path).make()
    with Folder(tmp_path).driving(), pytest.raises(OutputError, match="no other sweep is at work"):
        run(from_dict(spec()), tmp_path)


def test_ctrl_c_leaves_a_table_that_resume_completes(tmp_path: Path) -> None:
    sweep = from_dict(spec(parameters=[{**V2, "linspace": [0.5, 1.5, 9]}]))

    def stop(now: Progress) -> None:
        if now.phase == "running" and now.done >= 5:
            raise KeyboardInterrupt

    outcome = run(sweep, tmp_path, on_progress=stop)
    assert outcome.interrupted and 5 <= outcome.done < 9
    assert pq.read_table(outcome.path).num_rows == outcome.done
    complete = run(sweep, tmp_path, resume=True)
    assert (complete.done, complete.found, complete.interrupted) == (9, outcome.done, False)
    assert sorted(finished(tmp_path).values()) == [1] * 9


def test_a_run_that_was_stopped_is_not_held_against_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = from_dict(spec())

    def interrupted(self: Runner, values: dict[str, Any]) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Runner, "run", interrupted)
        for _ in range(5):
            assert run(sweep, tmp_path, resume=True).interrupted
    assert Folder(tmp_path).read().attempts == {sweep.points[0].run: 0}
    outcome = run(sweep, tmp_path, resume=True)
    assert (outcome.done, outcome.failed) == (5, 0)


def test_a_bug_in_a_run_is_a_row_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise KeyError("axle")

    monkeypatch.setattr("stiction.scene.Simulation.advance", broken)
    assert Runner(from_dict(spec()).job).run({"v": 1.0})["error"] == "KeyError: 'axle'"


class Fragile:
    """A backend whose worker dies in every run of some values, after it has noted that it began."""

    name, workers = "fragile", 1

    def __init__(self, deadly: float) -> None:
        self.deadly = deadly

    def run(self, work: Work, take: Take) -> Iterator[Report]:
        while batch := take():
            safe = []
            for point in batch:
                if point.values["v"] == self.deadly:
                    with JournalWriter(Folder(work.folder), work.session, "fragile") as journal:
                        journal.started(point.run)
                    yield Report(batch, None, "killed by SIGSEGV")
                    break
                safe.append(point)
                for report in InlineBackend().run(work, iter([[point], None]).__next__):
                    assert report.answer and report.answer.done == [point.run]
            else:
                yield Report(batch, Answer([point.run for point in batch], 0, None, 0.1))


def test_a_run_that_kills_its_workers_becomes_a_row(tmp_path: Path) -> None:
    sweep = from_dict(spec(parameters=[{**V2, "linspace": [0.5, 1.5, 9]}]))
    outcome = run_sweep(sweep, tmp_path, lambda: Fragile(1.25))
    assert (outcome.done, outcome.failed, outcome.deaths) == (9, 1, 3)
    assert outcome.columns["error"][6] == "the worker died during this run, 3 times (killed by SIGSEGV)."
    assert sorted(finished(tmp_path).values()) == [1] * 9


def test_workers_that_never_begin_a_run_end_the_sweep(tmp_path: Path) -> None:
    class Dead:
        name, workers = "dead", 1

        def run(self, work: Work, take: Take) -> Iterator[Report]:
            while batch := take():
                yield Report(batch, None, "no space left on device")

    with pytest.raises(SweepError, match=r"died in a row \(no space left on device\)"):
        run_sweep(from_dict(spec()), tmp_path, Dead)
    assert run(from_dict(spec()), tmp_path, resume=True).found == 3


def test_rows_from_workers_that_cannot_see_the_folder_come_with_the_answer(tmp_path: Path) -> None:
    class Elsewhere:
        name, workers = "elsewhere", 1

        def run(self, work: Work, take: Take) -> Iterator[Report]:
            far = Work(work.job, str(tmp_path / "not-there"), work.session)
            yield from InlineBackend().run(far, take)

    outcome = run_sweep(from_dict(spec()), tmp_path / "out", Elsewhere)
    assert (outcome.done, outcome.failed) == (5, 0)
    assert sorted(finished(tmp_path / "out").values()) == [1] * 5
    assert not (tmp_path / "not-there").exists()


def test_half_a_line_is_passed_over_and_its_run_done_again(tmp_path: Path) -> None:
    run(from_dict(spec()), tmp_path)
    journal = next((tmp_path / "runs").glob("*.jsonl"))
    text = journal.read_bytes()
    journal.write_bytes(text[:-40])
    assert len(entries(tmp_path)) == 9
    outcome = run(from_dict(spec()), tmp_path, resume=True)
    assert (outcome.found, outcome.done) == (4, 5)


def test_batches_take_seconds_and_shrink_towards_the_end() -> None:
    points = from_dict(spec(parameters=[{**V2, "linspace": [0, 1, 1000]}])).points
    queue = Queue(points, 1000, workers=2, seconds=0.02)
    first = queue.take()
    assert first is not None and len(first) == 100
    queue.learn(100, 10.0)
    assert queue.seconds == pytest.approx(0.7 * 0.02 + 0.3 * 0.1)
    queue.put_back(first[50:])
    sizes, seen = [], {point.number for point in first[:50]}
    while batch := queue.take():
        sizes.append(len(batch))
        seen |= {point.number for point in batch}
    assert seen == set(range(1000)) and sizes[-1] == 1 and max(sizes) == int(2.0 / 0.044)
    assert batch is None and len(queue) == 0


def test_the_map_agrees_with_the_closed_form_away_from_its_boundary(tmp_path: Path) -> None:
    changes = {"scene": {**load("slip-tip-hold").table.scene, "duration": 1.0}}  # type: ignore[dict-item]  # a table
    table = load("slip-tip-hold").table.model_dump(mode="json", exclude_none=True) | changes
    table["parameters"][0]["linspace"] = [0.25, 0.85, 4]
    table["parameters"][1]["linspace"] = [8, 36, 5]
    sweep = from_dict(table)
    outcome = run(sweep, tmp_path)
    columns = outcome.columns
    expected = expect(sweep, *(np.asarray(columns[name]) for name in ("mu", "angle_deg")))
    assert expected is not None and set(expected.tolist()) == {0, 1, 2}
    assert classify(sweep, columns).tolist() == expected.tolist()
    verdict = compare(sweep, columns)
    assert verdict is not None and (verdict.runs, verdict.agree, verdict.beside) == (20, 20, 0)
    columns["tips"] = [not tips for tips in columns["tips"]]
    spoiled = compare(sweep, columns)
    assert spoiled is not None and spoiled.agree < 10
    assert draw(sweep, columns, tmp_path / "map.png").stat().st_size > 10_000
