"""Running a simulation to its end, with everything that wants to see it on the way."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import SimulationError
from stiction.motion import Motion
from stiction.record.classify import classify
from stiction.record.recorder import Capturer, Recorder
from stiction.scene import Simulation
from stiction.shapes import describe

if TYPE_CHECKING:
    from stiction.record.writer import RecordingWriter

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

REPORTS = 100
"""How often a run without frames reports its progress, if nobody says."""


class BodySummary(NamedTuple):
    """What became of a body.

    Attributes:
        name, shape, material: what it is.
        displacement: distance between where it began and where it is now, m.
        speed: m/s.
        motion: what it is doing, a word of :class:`stiction.motion.Motion`.
        friction_work: what friction and rolling resistance at its contacts have taken, J.
    """

    name: str
    shape: str
    material: str
    displacement: float
    speed: float
    motion: str
    friction_work: float


class RunResult(NamedTuple):
    """What a run did.

    Attributes:
        steps: steps that were taken. time: simulated time that went by in them, s.
        wall_seconds: time that it took.
        bodies: a row for every body that is not static.
    """

    steps: int
    time: float
    wall_seconds: float
    bodies: list[BodySummary]


def run(
    simulation: Simulation,
    *,
    recorder: Recorder | None = None,
    writer: RecordingWriter | None = None,
    on_progress: Progress | None = None,
    chunk: int | None = None,
) -> RunResult:
    """Take a simulation to its end from wherever it is.

    Frames are kept at the steps that the recorder asks for, and at the end; a writer notes every step by itself. What
    goes wrong on the way is raised again after the writer's file has been closed, with all steps up to there; the
    simulation can be looked at, and after Ctrl-C also be run further.

    Args:
        simulation: what to run.
        recorder: keeps frames in memory.
        writer: of a recording of the simulation. At the end of the run all is written, and the file is still open.
        on_progress: called with the steps taken and the steps there are, after every chunk.
        chunk: steps from one report to the next at most; a hundredth of the run if left out.

    Raises:
        InvalidInputError: chunk is not a whole number, 1 or more.
        SimulationError: a body's state is no longer finite.
        KeyboardInterrupt: Ctrl-C.
    """
    total = simulation.total_steps
    chunk = max(1, total // REPORTS) if chunk is None else checks.integer("chunk", chunk, minimum=1)
    capturers: list[Capturer] = [] if recorder is None else [recorder]
    began, first = time.perf_counter(), simulation.step_index
    start = simulation.world.positions.copy()
    try:
        for one in capturers:
            one.capture()
        while not simulation.done:
            now = simulation.step_index
            due = [now + one.every - now % one.every for one in capturers]
            simulation.advance(min([now + chunk, *due]) - now)
            for one in capturers:
                one.capture(force=simulation.done)
            if on_progress is not None:
                on_progress(simulation.step_index, total)
        if writer is not None:
            writer.flush()
    except (KeyboardInterrupt, SimulationError) as error:
        if writer is not None:
            from stiction.record.writer import outcome_of

            writer.close(outcome_of(error))
        raise
    steps = simulation.step_index - first
    wall = time.perf_counter() - began
    return RunResult(steps, steps * simulation.world.dt, wall, summary(simulation, start))


def summary(simulation: Simulation, start_positions: Array) -> list[BodySummary]:
    """A row for every body that is not static, in order of creation.

    Args:
        simulation: as it is now.
        start_positions: (n, 3) where displacements are counted from, m.
    """
    world = simulation.world
    moved = np.linalg.norm(world.positions - start_positions, axis=1)
    speeds = np.linalg.norm(world.velocities, axis=1)
    motion = classify(world)
    return [
        BodySummary(
            name=body.name,
            shape=describe(body.shape),
            material=body.material,
            displacement=float(moved[body.index]),
            speed=float(speeds[body.index]),
            motion=Motion(int(motion[body.index])).word,
            friction_work=body.friction_work,
        )
        for body in world
        if body.mobility != "static"
    ]
