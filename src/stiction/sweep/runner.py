"""One run, and a batch of runs: what a worker does, wherever it is.

A row is written to the worker's journal the moment its run is finished, so that whatever ends the worker takes no
finished run with it. Where the folder of the sweep cannot be seen, on another machine without shared files, rows go
back to the driver with the answer instead.
"""

from __future__ import annotations

import json
import os
import platform
import time
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from stiction.errors import InvalidInputError, StictionError, StictionWarning
from stiction.sweep.journal import Folder, JournalWriter

Row = dict[str, Any]
Run = tuple[int, str, dict[str, Any]]
"""Number, id and values of a run, as :class:`stiction.sweep.points.Point` has them."""


@dataclass(frozen=True)
class Job:
    """What all runs of a sweep have in common, as plain data.

    Attributes:
        scene: the scene as :meth:`stiction.scene.Scene.to_dict` gives it.
        keys: name of each parameter to the path of its key in the scene.
        derived: path of a key to the expression of its value.
        metrics: name of each metric to its expression, in order.
        every: steps from one frame to the next. contacts: keep contact points with each frame.
    """

    scene: dict[str, Any]
    keys: dict[str, str]
    derived: dict[str, str]
    metrics: dict[str, str]
    every: int
    contacts: bool

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    def deciding(self) -> dict[str, Any]:
        """What decides the rows: all of it but the words about the scene."""
        words = ("title", "expect")
        return {**self.as_dict(), "scene": {key: value for key, value in self.scene.items() if key not in words}}

    def to_json(self) -> str:
        """One line of text."""
        return json.dumps(self.as_dict())

    @staticmethod
    def from_json(text: str) -> Job:
        """What :meth:`to_json` wrote."""
        return Job(**json.loads(text))


class Runner:
    """Puts points through a job.

    Args:
        job: what to do with each of them.
    """

    def __init__(self, job: Job) -> None:
        from stiction.scene.validate import validate
        from stiction.sweep.expressions import Expression

        self.job = job
        self._table = validate(job.scene)
        self._derived = {key: Expression(text, key) for key, text in job.derived.items()}
        self._metrics = {name: Expression(text, f"metric {name}") for name, text in job.metrics.items()}

    def run(self, values: dict[str, Any]) -> Row:
        """The row of one point: metrics, or the error that kept it from having any.

        Args:
            values: name of each parameter to its value.

        Returns:
            ``metrics`` by name, ``error`` and ``warning`` as one sentence or None, ``wall_seconds``, ``steps``,
            ``state_hash`` of the end, and the ``worker`` as host and process.
        """
        began = time.perf_counter()
        row: Row = {"metrics": {}, "error": None, "warning": None, "steps": 0, "state_hash": None}
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", StictionWarning)
            try:
                self._fill(row, values)
            except StictionError as error:
                row["error"] = str(error)
            except Exception as error:  # whatever one run does, the others go on
                row["error"] = f"{type(error).__name__}: {error}"
        if caught:
            row["warning"] = " ".join(dict.fromkeys(str(warning.message) for warning in caught))
        row["wall_seconds"] = time.perf_counter() - began
        row["worker"] = worker_name()
        return row

    def _fill(self, row: Row, values: dict[str, Any]) -> None:
        from stiction.record.recorder import Recorder
        from stiction.record.run import run as run_simulation
        from stiction.scene import Scene, Simulation
        from stiction.scene.overrides import apply_values
        from stiction.sweep.measures import Measures

        changes = {self.job.keys[name]: value for name, value in values.items()}
        for key, expression in self._derived.items():
            changes[key] = _plain(expression.evaluate(values), key)
        simulation = Simulation(Scene(apply_values(self._table, changes)))
        world = simulation.world
        recorder = Recorder(world, "run", every=self.job.every, contacts=self.job.contacts, motion=False)
        try:
            run_simulation(simulation, recorder=recorder, chunk=simulation.total_steps)
        finally:
            row["steps"] = simulation.step_index
        row["state_hash"] = world.state_hash()
        measures = Measures(recorder.frames(), world)
        known = {**values, **measures.names()}
        functions = measures.functions()
        for name, expression in self._metrics.items():
            known[name] = row["metrics"][name] = _plain(expression.evaluate(known, functions), name)


def _plain(value: Any, name: str) -> float | bool | str:
    """A number, a flag or a text as Python has it."""
    if isinstance(value, str):
        return value
    array = np.asarray(value)
    if array.ndim or array.dtype.kind not in "bif":
        raise InvalidInputError(f"metric {name} must be one number, flag or text, got shape {array.shape}.")
    return bool(array) if array.dtype.kind == "b" else float(array)


@lru_cache(maxsize=4)
def _runner(job: str) -> Runner:
    return Runner(Job.from_json(job))


def worker_name() -> str:
    """Host and process."""
    return f"{platform.node()}:{os.getpid()}"


class Answer(NamedTuple):
    """What became of a batch.

    Attributes:
        done: ids of the runs that are finished. failed: how many of them have an error instead of metrics.
        rows: the rows that are in no journal, because the folder cannot be seen from here, in the order of ``done``.
        seconds: that the runs took, without what came before and after them.
    """

    done: list[str]
    failed: int
    rows: list[Row] | None
    seconds: float


def run_batch(job: str, batch: Sequence[Run], folder: str, session: str) -> Answer:
    """Run a batch, each row into this worker's journal as it is finished.

    Args:
        job: a :class:`Job` as text.
        batch: the runs.
        folder: of the sweep.
        session: token of the driver that asks; the batch ends early once another driver has taken over.
    """
    runner = _runner(job)
    place = Folder(folder)
    began = time.perf_counter()
    if place.session() is None:
        rows = [runner.run(values) for _, _, values in batch]
        wrong = sum(row["error"] is not None for row in rows)
        return Answer([run for _, run, _ in batch], wrong, rows, time.perf_counter() - began)
    done, failed = [], 0
    with place.at_work(), JournalWriter(place, session, worker_name()) as journal:
        for _, run, values in batch:
            if place.session() != session:
                break
            journal.started(run)
            try:
                row = runner.run(values)
            except BaseException:  # somebody wants to stop, which is not this run's fault
                journal.left(run)
                raise
            journal.finished(run, row)
            done.append(run)
            failed += row["error"] is not None
    return Answer(done, failed, None, time.perf_counter() - began)
