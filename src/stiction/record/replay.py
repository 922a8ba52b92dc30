"""Running a recording again: from its snapshots, with its inputs, and comparing every step with what it was."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiction._version import __version__
from stiction.core import jit
from stiction.errors import InvalidInputError, SimulationError
from stiction.hashing import STATE_WIDTH, Fingerprint, machine_class
from stiction.record import layout
from stiction.record.columns import encode
from stiction.record.inputs import Input, add_body, apply, materials_from
from stiction.record.recorder import WIDTHS
from stiction.record.recording import UNREADABLE, Recording
from stiction.scene import Scene, Simulation
from stiction.snapshot import put
from stiction.world import World

Array = NDArray[np.float64]
Slots = NDArray[np.int64]
Progress = Callable[[int, int], None]

REPORT_STEPS = 50
"""Steps from one report of progress to the next."""


@dataclass(frozen=True)
class BodyDifference:
    """By how much a body differs from what was recorded, where that is first seen.

    Attributes:
        name: of the body.
        step: steps taken by then. time: s.
        position: distance, m. angle: rad. velocity: m/s. angular_velocity: rad/s.
    """

    name: str
    step: int
    time: float
    position: float
    angle: float
    velocity: float
    angular_velocity: float


@dataclass(frozen=True)
class ReplayCheck:
    """What came of running a recording again.

    Attributes:
        first, last: the steps that were compared, both included.
        differs_at: the first step whose state is not the one that was recorded, or None.
        bodies: those that differ in what was recorded, most first, at the first frame or snapshot from there on in
            which it can be seen; none if that was not reached or the difference is below the precision of frames.
        notes: sentences that explain: other kernels, another machine, a run that ended in another way.
    """

    first: int
    last: int
    differs_at: int | None
    bodies: list[BodyDifference] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def same(self) -> bool:
        """Whether every step ended in the very bits in which it was recorded."""
        return self.differs_at is None


class Replayer:
    """A world on its way through a recording again, from the last snapshot at or before a step.

    Args:
        recording: of format 2; those of format 1 have no snapshots.
        step: not after the last one.

    Attributes:
        world: as it is now. slots: (n,) place of each of its bodies in ``recording.bodies``.

    Raises:
        InvalidInputError: the recording cannot be run again by this version.
    """

    def __init__(self, recording: Recording, step: int) -> None:
        steps = recording.checkpoint_steps
        number = int(np.searchsorted(steps, step, side="right")) - 1
        if number < 0:
            raise InvalidInputError(f"recording {str(recording.path)!r} has no snapshot at or before step {step}.")
        self.recording = recording
        start = int(steps[number])
        inputs = recording.inputs()
        try:
            self.world, self.slots = _world_of(recording, [one for one in inputs if one.step < start])
            put(self.world, recording.snapshot(number))
        except InvalidInputError as error:
            raise InvalidInputError(f"recording {str(recording.path)!r} cannot be run again: {error}") from None
        except UNREADABLE as error:
            raise layout.damaged(recording.path, error) from None
        # what was done right after a snapshot has the same number of steps, and is not in it
        self._inputs: Iterator[Input] = iter([one for one in inputs if one.step >= start])
        self._next = next(self._inputs, None)

    def advance(self) -> None:
        """One step, with the inputs before it.

        Raises:
            SimulationError: a body's state is no longer finite.
        """
        self._apply_inputs()
        self.world.step()

    def advance_to(self, step: int) -> None:
        """To a step of the recording, without comparing."""
        while self.world.steps < step:
            self.advance()

    def _apply_inputs(self) -> None:
        while self._next is not None and self._next.step == self.world.steps:
            given = self._next
            self._next = next(self._inputs, None)
            apply(self.world, given)
            self.slots = _renumbered(self.slots, given)


def world_and_slots(recording: Recording, step: int) -> tuple[World, Slots]:
    """The world after that step, and the place of each of its bodies in ``recording.bodies``."""
    step = recording.step("step", step)
    if recording.format_version == 1:
        simulation = simulation_of(recording)
        if step > 0:
            simulation.advance(step)
        return simulation.world, np.arange(len(simulation.world), dtype=np.int64)
    replayer = Replayer(recording, step)
    replayer.advance_to(step)
    return replayer.world, replayer.slots


def check(
    recording: Recording,
    start: float | None = None,
    stop: float | None = None,
    on_progress: Progress | None = None,
) -> ReplayCheck:
    """Run the engine again and compare, see :meth:`Recording.check`.

    Args:
        recording: what to run.
        start: s. stop: s.
        on_progress: called with the steps compared and the steps there are.
    """
    first = recording.step_at("start", start, recording.first_step)
    last = recording.step_at("stop", stop, recording.last_step)
    if last < first:
        raise InvalidInputError(f"stop must not be before start, got {start!r} to {stop!r} s.")
    if recording.format_version == 1:
        return _check_frames(recording, first, last, on_progress)
    replayer = Replayer(recording, first)
    notes = _other_engine(recording)
    hashes, fingerprint = recording.hashes, Fingerprint()
    world = replayer.world
    differs_at: int | None = None
    step = world.steps
    try:
        while True:
            state = world._store.column(world._state.POSITION, STATE_WIDTH)
            step = world.steps
            if step >= first:
                if differs_at is None:
                    found = fingerprint(step, np.ascontiguousarray(state))
                    if found != int(hashes[step - recording.first_step]):
                        differs_at = step
                if differs_at is not None:
                    bodies = _compare(recording, step, state, replayer.slots)
                    if bodies:
                        return ReplayCheck(first, last, differs_at, bodies, notes)
                if on_progress is not None and (step - first) % REPORT_STEPS == 0:
                    on_progress(step - first, last - first)
            if step >= last:
                break
            replayer.advance()
    except SimulationError as error:
        notes.append(f"the run ended here with {str(error)!r}, and the recorded one did not.")
        return ReplayCheck(first, last, step + 1 if differs_at is None else differs_at, [], notes)
    if differs_at is not None:
        notes.append(f"no body differs by more than the precision of frames ({recording.precision}) up to the end.")
    return ReplayCheck(first, last, differs_at, [], notes)


def simulation_of(recording: Recording) -> Simulation:
    """The simulation of a recording of a scene, at its beginning.

    Raises:
        InvalidInputError: it has no scene, or the scene's bodies are not those recorded.
    """
    path = str(recording.path)
    if recording.scene is None:
        raise InvalidInputError(
            f"recording {path!r} has no scene, for it is of a world made in Python; Recording.world() gives that."
        )
    simulation = Simulation(Scene.from_dict(recording.scene, str(recording.metadata["scene_name"])))
    world = simulation.world
    names = [str(row["name"]) for row in recording._rows]
    initial = {} if recording.format_version > 1 else {key: recording._read(f"initial/{key}", ...) for key in WIDTHS}
    if [body.name for body in world] != names or any(
        values.shape != (len(world), WIDTHS[key]) for key, values in initial.items()
    ):
        raise InvalidInputError(f"recording {path!r} holds other bodies than its scene, so it cannot be restored.")
    if recording.format_version > 1:
        put(world, recording.snapshot(0))
    for key, values in initial.items():
        getattr(world, key)[:] = values
    return simulation


# --- pieces -----------------------------------------------------------------------------------------------------------


def _world_of(recording: Recording, past: list[Input]) -> tuple[World, Slots]:
    """A world with the settings and bodies that the recorded one had after those inputs; its state is still to come."""
    data = recording.metadata
    rows = list(recording._rows)
    slots = np.arange(len(rows), dtype=np.int64)
    materials = data["materials"]
    for one in past:
        if one.text is not None:
            if one.text["what"] == "add":
                rows.append(one.text)
            materials = one.text["rows"] if one.text["what"] == "materials" else materials
            slots = _renumbered(slots, one)
    initial = len(recording._rows)
    world = World(**data["settings"], materials=materials_from(materials))
    for slot in slots.tolist():
        row = rows[slot]
        add_body(world, {"body": row, **row} if slot < initial else row)
    return world, slots


def _renumbered(slots: Slots, given: Input) -> Slots:
    """The places of the bodies after an input."""
    text = given.text
    if text is not None and text["what"] == "add":
        return np.append(slots, int(text["slot"]))
    if text is not None and text["what"] == "remove":
        return np.delete(slots, text["bodies"])
    return slots


def _other_engine(recording: Recording) -> list[str]:
    """What may explain a difference without any fault."""
    notes, data = [], recording.metadata
    if data["kernels"] != jit.cache_key():
        notes.append(
            f"it was recorded by stiction {data['stiction_version']} with other kernels, versions of Numba or kind of "
            f"processor than this stiction {__version__}."
        )
    if data["machine"] != machine_class():
        notes.append(f"it was recorded on another class of machine: {data['machine']}; this is {machine_class()}.")
    return notes


def _compare(recording: Recording, step: int, state: Array, slots: Slots) -> list[BodyDifference]:
    """Bodies that differ from the snapshot or the frame of that step, as far as there is one."""
    checkpoints = np.flatnonzero(recording.checkpoint_steps == step)
    frames = np.flatnonzero(recording.frame_steps == step)
    if len(checkpoints):
        bodies, n = recording.snapshot(int(checkpoints[0]))["bodies"], len(state)
        before = bodies[:n, :STATE_WIDTH]
        differs = (before != state).any(axis=1)
    elif len(frames):
        k = int(frames[0])
        stored, same = [], []
        column = 0
        for name, width in WIDTHS.items():
            recorded = recording.array(name, slice(k, k + 1))[0][slots]
            rounded = encode(name, state[:, column : column + width], recording.precision)
            raw = recording.stored(name, slice(k, k + 1))[0][slots]
            same.append((rounded == raw).all(axis=1))
            stored.append(recorded)
            column += width
        before, differs = np.concatenate(stored, axis=1), ~np.logical_and.reduce(same)
    else:
        return []
    found = []
    for index in np.flatnonzero(differs).tolist():
        a, b = state[index], before[index]
        q = min(1.0, abs(float(a[3:7] @ b[3:7])))
        found.append(
            BodyDifference(
                name=recording.bodies[int(slots[index])].name,
                step=step,
                time=step * recording.dt,
                position=float(np.linalg.norm(a[:3] - b[:3])),
                angle=2.0 * float(np.arccos(q)),
                velocity=float(np.linalg.norm(a[7:10] - b[7:10])),
                angular_velocity=float(np.linalg.norm(a[10:] - b[10:])),
            )
        )
    return sorted(found, key=lambda one: -(one.position + one.angle + one.velocity + one.angular_velocity))


def _check_frames(recording: Recording, first: int, last: int, on_progress: Progress | None) -> ReplayCheck:
    """What :func:`check` does for a recording of format 1: its frames are exact, but there is nothing between them."""
    simulation = simulation_of(recording)
    world = simulation.world
    notes = ["it is of format version 1: frames were compared, and steps between them were not."]
    for step in recording.frame_steps[(recording.frame_steps >= first) & (recording.frame_steps <= last)].tolist():
        if step > world.steps:
            simulation.advance(step - world.steps)
        state = world._store.column(world._state.POSITION, STATE_WIDTH)
        bodies = _compare(recording, step, state, np.arange(len(world), dtype=np.int64))
        if bodies:
            return ReplayCheck(first, last, step, bodies, notes)
        if on_progress is not None:
            on_progress(step - first, last - first)
    return ReplayCheck(first, last, None, [], notes)
