"""Recording a world while it runs: every step is noted, and everything that changes the world from outside.

In the simulation's thread a step costs a copy of its state; hashes, energies, rounding, deflating and the file are the
business of a :class:`stiction.record.worker.Worker`. After a step nothing of Python is in the processor's caches any
more, and each line costs ten times what it seems to: so little is done in :meth:`RecordingWriter.catch_up`.
"""

from __future__ import annotations

import atexit
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from stiction import checks, outputs
from stiction._version import __version__
from stiction.body import Body
from stiction.core import jit
from stiction.core.streaming import stream_columns
from stiction.errors import InvalidInputError, SimulationError
from stiction.hashing import STATE_WIDTH, machine_class
from stiction.journal import Step
from stiction.record import layout
from stiction.record.bodies import info_of, info_to_dict
from stiction.record.classify import fixed_bodies
from stiction.record.file_writer import Batch, FileWriter, Moment, RawInput
from stiction.record.inputs import CODES, FRICTION, GRAVITY, KINDS, LISTED_KINDS, TEXT, VIEW, added_text
from stiction.record.interrupts import interrupts_held
from stiction.record.worker import Worker
from stiction.scene import Simulation
from stiction.snapshot import Snapshot, settings_of, take
from stiction.world import World

if TYPE_CHECKING:
    from stiction.store import StepFailure

Array = NDArray[np.float64]

FRAMES_PER_SECOND = 30.0
"""Of simulated time, if nobody says otherwise."""
CHECKPOINT_STEPS = 2000
"""Steps from one snapshot to the next: whoever wants to go on from a step has to run so many at most."""
BATCH_BYTES = 1 << 21
"""Aimed size of the states that are handed over at once."""
BATCH_STEPS = 256
"""Steps that are handed over at once, at most."""
HEAVINESS = ("MASS", "INVERSE_MASS", "INERTIA", "INVERSE_INERTIA")
"""Columns of a body's row that its energy depends on, besides its state."""
BATCH_SECONDS = 0.5
"""Steps are handed over after that time at the latest."""


class RecordingWriter:
    """Records a world, from where it is now until :meth:`close`. A context manager.

    Args:
        path: of the file, which is made now, so that a bad path is known before the run. An older recording there is
            replaced, a file of any other kind is not.
        source: a world, or a simulation at its beginning, whose scene is then kept as well.
        every: steps from one frame to the next; 30 frames a second if left out.
        contacts: keep contact points and what bodies are doing, too.
        precision: of frames, ``"display"`` or ``"full"``.
        title: a few words; those of the scene if left out.
        meta: more to keep, plain values.
        checkpoint_steps: steps from one snapshot to the next.

    Raises:
        InvalidInputError: a value is not allowed, the simulation has already begun, or its world is being recorded.
        OutputError: the file cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        source: World | Simulation,
        every: int | None = None,
        contacts: bool = False,
        *,
        precision: str = "display",
        title: str | None = None,
        meta: dict[str, Any] | None = None,
        checkpoint_steps: int = CHECKPOINT_STEPS,
    ) -> None:
        simulation = source if isinstance(source, Simulation) else None
        world = source if isinstance(source, World) else source.world
        self.world, self._simulation = world, simulation
        usual = max(1, round(1.0 / (FRAMES_PER_SECOND * world.dt)))
        self.every = usual if every is None else checks.integer("every", every, minimum=1)
        self.precision = checks.one_of("precision", precision, layout.PRECISIONS)
        self._checkpoint_steps = checks.integer("checkpoint_steps", checkpoint_steps, minimum=1)
        if not isinstance(contacts, bool):
            raise InvalidInputError(f"contacts must be True or False, got {contacts!r}.")
        self.contacts = contacts
        if simulation is not None and simulation.step_index != 0:
            raise InvalidInputError(
                f"a recording must begin with the simulation, which is at step {simulation.step_index} already."
            )
        if world._journal is not None:
            raise InvalidInputError("a world must have one recording at a time; close the other one first.")
        self.path = outputs.writable("recording", path)

        self._store = world._store
        self._first = self._noted = world.steps
        self._count = 0
        self._states: Array
        self._flat: Array
        self._column = world._state.POSITION
        self._slots = np.arange(len(world), dtype=np.int64)
        self._next_slot = len(world)
        self._row, self._before = -1, self._state().copy()
        self._gravity = world.gravity
        self._materials, self._materials_version = world.materials, world.materials.version
        self._touched: dict[int, Array] = {}
        self._rows: Array | None = None
        self._last_frame_step = self._first
        self._next_frame = self._first + self.every - self._first % self.every
        self._next_checkpoint = self._first + self._checkpoint_steps
        self._frames = 0
        self._closed = False
        with interrupts_held():
            attributes, texts = self._header(title, meta)
            bodies = [info_to_dict(info_of(body)) | _role(body) for body in world]
            file = FileWriter(self.path, attributes, texts, bodies, self.precision, contacts)
            states = self._before[None]
            checkpoints: list[tuple[int, Snapshot]] = [(self._first, take(world))]
            frames = {self._first: self._moment()}
            file.process(Batch(self._first, states, self._slots, frames, [], checkpoints))
            self._frames = 1
            file.commit(everything=True)
            file.share()
            self._worker = Worker(file)
            self._new_batch(self._first + 1)
        world._journal = self
        atexit.register(self.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(None if error is None else outcome_of(error))

    def __len__(self) -> int:
        """Frames so far."""
        return self._frames

    def __repr__(self) -> str:
        state = "closed" if self._closed else "open"
        return f"<RecordingWriter of {str(self.path)!r}, {self._frames} frames, {state}>"

    def flush(self) -> None:
        """Write all steps so far, down to the system.

        Raises:
            OutputError: the disk does not take it.
        """
        if self._closed:
            return
        self.catch_up()
        with interrupts_held():
            self._hand_over()
            self._worker.flush()

    def close(self, outcome: str | None = None) -> None:
        """Write the last step and all that is left, and close the file; nothing happens if it is closed already.

        Args:
            outcome: how the run ended; ``complete`` or ``stopped early`` for a simulation, ``closed`` for a world.
        """
        if self._closed:
            return
        with interrupts_held():
            self.catch_up()
            if self._noted != self._last_frame_step:
                self._frames_due[self._noted] = self._moment()
                self._frames += 1
                if self._count == 0:  # its batch is gone, so the state goes a second time
                    self._first_in_batch, self._count = self._noted, 1
                    self._states[0] = self._last()
            self._closed = True
            self.world._journal = None
            atexit.unregister(self.close)
            if outcome is None:
                done = self._simulation is not None and self._simulation.done
                outcome = "closed" if self._simulation is None else "complete" if done else "stopped early"
            try:
                self._hand_over()
            finally:
                self._worker.close(outcome)

    # --- what a world tells (stiction.journal.Journal) ----------------------------------------------------------------

    def follow(self, step: Step, steps: int, settings: Any, table: Any) -> StepFailure | None:
        """Take steps one by one, and note each."""
        for _ in range(steps):
            if self._store.watched or self._materials.version != self._materials_version:
                self._look_for_changes()
            failure = step(1, settings, table)
            if failure is not None:
                self._row, self._before = -1, self._state().copy()
                self._touched.clear()
                self._note_text({"what": "failure"})
                return failure
            self.catch_up()
        return None

    def catch_up(self) -> None:
        """Note the step that was taken last, if it has not been: Ctrl-C may have come between."""
        step = self._store.steps
        if step == self._noted:
            return
        k, n = step - self._first_in_batch, len(self._slots)
        stream_columns(self._store.bodies, n, self._column, STATE_WIDTH, self._flat, k * n * STATE_WIDTH)
        if step == self._next_frame:
            self._frames_due[step] = self._moment()
        if step == self._next_checkpoint:
            self._checkpoints[step] = take(self.world)
        # from here on the step is noted; cut off before, it is noted again
        self._row, self._count, self._noted = k, k + 1, step
        if step == self._next_frame:
            self._frames += 1
            self._last_frame_step, self._next_frame = step, step + self.every
        if step == self._next_checkpoint:
            self._next_checkpoint += self._checkpoint_steps
        if self._touched:
            self._touched.clear()
        if self._count == self._room or time.monotonic() - self._handed_over > BATCH_SECONDS:
            with interrupts_held():
                self._hand_over()

    def wrote(self, index: int, column: str, value: Array) -> None:
        """Numbers of a body are about to be set."""
        self.catch_up()
        numbers = np.array(value, np.float64).ravel()
        self._inputs.append(RawInput(self._noted, index, CODES[column], numbers, None))
        if column in HEAVINESS:
            self._rows = None
        start = getattr(self.world._state, column)
        if start < STATE_WIDTH:
            row = self._touched.setdefault(index, self._last()[index].copy())
            row[start : start + len(numbers)] = numbers

    def wrote_kind(self, index: int, column: str, value: int) -> None:
        """A whole number of a body is about to be set."""
        self.catch_up()
        assert column in LISTED_KINDS
        self._note_text({"what": "kind", "body": index, "column": column, "value": int(value)})

    def added(self, body: Body) -> None:
        """A body was added."""
        self._note_text(added_text(self.world, body) | {"slot": self._next_slot})
        with interrupts_held():
            self._row, self._before, self._rows = -1, np.vstack([self._last(), self._state()[-1:]]), None
            self._change_slots(np.append(self._slots, self._next_slot))
            self._next_slot += 1

    def removing(self, indices: Sequence[int]) -> None:
        """Bodies are about to be removed."""
        self.catch_up()
        self._look_for_changes()
        self._note_text({"what": "remove", "bodies": list(indices), "slots": self._slots[list(indices)].tolist()})
        keep = np.ones(len(self._slots), np.bool_)
        keep[list(indices)] = False
        with interrupts_held():
            self._row, self._before, self._rows = -1, self._state()[keep].copy(), None
            self._touched.clear()
            self._change_slots(self._slots[keep])

    def gravity(self, value: Array) -> None:
        """Gravity is about to be set."""
        self.catch_up()
        self._gravity = value.copy()
        self._inputs.append(RawInput(self._noted, -1, KINDS.index(GRAVITY), self._gravity, None))

    def entered_friction(self, index: int, lost: float) -> None:
        """Forces from outside were friction."""
        self.catch_up()
        self._inputs.append(RawInput(self._noted, index, KINDS.index(FRICTION), np.array([lost]), None))

    # --- inside -------------------------------------------------------------------------------------------------------

    def _state(self) -> Array:
        """(n, 13) a view."""
        return self._store.column(self._column, STATE_WIDTH)

    def _last(self) -> Array:
        """(n, 13) the state that was noted last, with bodies that came or went since."""
        return self._before if self._row < 0 else self._states[self._row]

    def _note_text(self, text: dict[str, Any]) -> None:
        self._inputs.append(RawInput(self._noted, -1, KINDS.index(TEXT), None, text))

    def _look_for_changes(self) -> None:
        """Before a step: what has changed without a word, through views of the state or in the table of materials."""
        if self._store.watched:
            is_now, was = self._state(), self._last()
            differs = is_now.view(np.int64) != was.view(np.int64)
            # mostly nothing does, and that is known sooner without looking at each body
            for index in np.flatnonzero(differs.any(axis=1)).tolist() if differs.any() else []:
                expected, row = self._touched.get(index), is_now[index].copy()
                if expected is None or expected.tobytes() != row.tobytes():
                    self._inputs.append(RawInput(self._noted, index, KINDS.index(VIEW), row, None))
                    self._touched[index] = row
        materials = self._materials
        if materials.version != self._materials_version:
            self._note_text({"what": "materials", "rows": materials.to_toml_rows()})
            self._materials_version = materials.version

    def _moment(self) -> Moment:
        store = self._store
        if self._rows is None:
            self._rows = store.bodies[: store.n].copy()
        ledger = store.ledger.copy()
        if not self.contacts:
            return Moment(ledger, self._gravity, self._rows, None, None)
        numbers, tags = self.world._raw_contacts()
        return Moment(ledger, self._gravity, self._rows, (numbers.copy(), tags.copy()), fixed_bodies(self.world))

    def _new_batch(self, first: int) -> None:
        n = len(self._slots)
        self._room = room = max(1, min(BATCH_STEPS, BATCH_BYTES // (8 * STATE_WIDTH * max(1, n))))
        self._first_in_batch = first
        self._handed_over = time.monotonic()
        self._states = self._worker.room((room, n, STATE_WIDTH))
        self._flat = self._states.reshape(-1)
        self._count = 0
        self._frames_due: dict[int, Moment] = {}
        self._inputs: list[RawInput] = []
        self._checkpoints: dict[int, Snapshot] = {}

    def _hand_over(self) -> None:
        """Give what was noted to the worker; Ctrl-C must not come between."""
        checkpoints = list(self._checkpoints.items())
        if self._count or self._inputs:
            states = self._states[: self._count]
            # no copy: even if the worker gives this room back at once, a row is not written again before it is outdated
            self._row, self._before = -1, self._last()
            due = self._frames_due
            self._worker.put(
                Batch(self._first_in_batch, states, self._slots, due, self._inputs, checkpoints, self._states)
            )
        self._new_batch(self._noted + 1)

    def _change_slots(self, slots: NDArray[np.int64]) -> None:
        """Bodies come or go: what was noted of those before is handed over."""
        self._hand_over()
        self._slots = slots
        self._new_batch(self._noted + 1)

    def _header(self, title: str | None, meta: dict[str, Any] | None) -> tuple[dict[str, Any], dict[str, Any]]:
        world = self.world
        scene = None if self._simulation is None else self._simulation.scene
        attributes = {
            "format": layout.FORMAT,
            "format_version": layout.FORMAT_VERSION,
            "stiction_version": __version__,
            "kernels": jit.cache_key(),
            "machine": machine_class(),
            "title": title or (scene.title if scene is not None else "a world"),
            "scene_name": scene.name if scene is not None else "",
            "dt": world.dt,
            "every": self.every,
            "first_step": self._first,
            "solver": world.solver,
            "precision": self.precision,
            "contacts": self.contacts,
        }
        texts = {
            "scene": None if scene is None else scene.to_dict(),
            "settings": settings_of(world),
            "materials": world.materials.to_toml_rows(),
            "meta": meta or {},
        }
        return attributes, texts


def outcome_of(error: BaseException) -> str:
    """How a run ended, for the file."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, SimulationError):
        return f"failed: {error}"
    return f"stopped by {type(error).__name__}: {error}"


def _role(body: Body) -> dict[str, Any]:
    return {"mobility": body.mobility, "sensor": body.sensor}
