"""One run: an engine, a scene, and what came of it.

A run warms up (a small world with the same shapes takes a few steps: compiling is not counted), lets the scene settle,
then measures. Wall time and processor time of each step are kept, and at the end bodies are looked at.
"""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.bench import scenes
from stiction.bench.engines import Engine, engine_class
from stiction.bench.scene import BenchScene
from stiction.bench.stability import Stability, judge

Array = NDArray[np.float64]

WARM_UP_STEPS = 5


@dataclass(frozen=True)
class Task:
    """One run: all that a fresh process has to be told.

    Attributes:
        engine, scene: by name. size: dynamic bodies, or None for the usual number.
        solver: of stiction; None for its default.
        dt: s. settle: steps before measuring. steps: measured.
        limit: s of wall time after which a run stops early.
        seed: of the scene, where it has one; None for the scene's own.
        profile: also ask stiction for the time of each stage of a step.
    """

    engine: str
    scene: str
    size: int | None = None
    solver: str | None = None
    dt: float = 1.0 / 60.0
    settle: int = 120
    steps: int = 180
    limit: float = 60.0
    seed: int | None = None
    profile: bool = False


@dataclass
class Outcome:
    """What one run gave. Times are milliseconds a step, means unless said otherwise.

    Attributes:
        bodies: dynamic ones.
        version: of the engine.
        wall, cpu: of the measured steps. median, worst: of single measured steps, wall.
        settling: while the scene settled, wall.
        build: ms to make the world.
        steps: measured; 0 if the time limit came before the scene had settled, and ``wall`` is that of settling then.
        complete: the time limit did not stop it.
        stability: how the scene ended.
        stages: ms a step of each stage, or None.
        skipped: why it was not run; failed: how it broke down. Both None if all went well.
    """

    bodies: int = 0
    version: str = ""
    wall: float = math.nan
    cpu: float = math.nan
    median: float = math.nan
    worst: float = math.nan
    settling: float = math.nan
    build: float = math.nan
    steps: int = 0
    complete: bool = True
    stability: Stability | None = None
    stages: dict[str, float] | None = None
    skipped: str | None = None
    failed: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {**asdict(self), "stability": None if self.stability is None else self.stability._asdict()}

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Outcome:
        """The inverse of :meth:`as_dict`."""
        stability = values["stability"]
        return cls(**{**values, "stability": None if stability is None else Stability(**stability)})


def run_here(task: Task) -> Outcome:
    """One run in this process."""
    kind = engine_class(task.engine)
    scene = scenes.make(task.scene, task.size, task.seed)
    if not kind.available():
        return Outcome(bodies=scene.n, skipped=f"{task.engine} is not installed")
    engine = kind(task.solver)
    reason = engine.supports(scene)
    if reason is not None:
        return Outcome(bodies=scene.n, version=kind.version(), skipped=reason)
    _warm_up(kind(task.solver), scene, task.dt)

    began = time.perf_counter()
    engine.build(scene, task.dt)
    build = time.perf_counter() - began
    deadline = time.perf_counter() + task.limit
    settle_wall, _ = _timed_steps(engine, task.settle, deadline)
    settled = len(settle_wall) == task.settle
    wall, cpu = _timed_steps(engine, task.steps if settled else 0, deadline)
    measured = wall if len(wall) else settle_wall
    outcome = Outcome(
        bodies=scene.n,
        version=kind.version(),
        wall=1e3 * float(measured.mean()),
        cpu=1e3 * float(cpu.mean()) if len(cpu) else math.nan,
        median=1e3 * float(np.median(measured)),
        worst=1e3 * float(measured.max()),
        settling=1e3 * float(settle_wall.mean()) if len(settle_wall) else math.nan,
        build=1e3 * build,
        steps=len(wall),
        complete=len(wall) == task.steps,
        stability=judge(scene, engine.positions(), engine.orientations(), engine.velocities()),
    )
    if task.profile:
        outcome.stages = engine.profile(task.steps)
    return outcome


def _warm_up(engine: Engine, scene: BenchScene, dt: float) -> None:
    engine.build(scene.small(), dt)
    for _ in range(WARM_UP_STEPS):
        engine.before_step()
        engine.step()


def _timed_steps(engine: Engine, steps: int, deadline: float) -> tuple[Array, Array]:
    """Wall and processor time of each step in s; fewer steps, but one at least, if the deadline comes first."""
    wall: list[float] = []
    cpu: list[float] = []
    for _ in range(steps):
        if wall and time.perf_counter() > deadline:
            break
        engine.before_step()
        cpu_before, wall_before = time.process_time(), time.perf_counter()
        engine.step()
        wall_after, cpu_after = time.perf_counter(), time.process_time()
        wall.append(wall_after - wall_before)
        cpu.append(cpu_after - cpu_before)
    return np.array(wall), np.array(cpu)
