"""The file of a recording while it is written: batches of steps go in, rows of data sets come out.

Nothing here looks at a world, so all of it may happen in another thread. ``commits`` is written last: its rows say how
long the other data sets were when all that belongs together was there, and readers go by the last one that holds.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction.accounts import balance
from stiction.contacts import CONTACT_DTYPE, contact_rows
from stiction.core import state as columns
from stiction.core import step as kernels
from stiction.errors import OutputError
from stiction.hashing import PARTS, STATE_WIDTH, Fingerprint
from stiction.record import layout
from stiction.record.classify import judge
from stiction.record.columns import PackedColumn, PlainColumn, encode, piece_rows
from stiction.record.input_numbers import ORDER, InputNumbers
from stiction.record.inputs import KINDS, TEXT
from stiction.record.recorder import WIDTHS
from stiction.reports import Energy
from stiction.snapshot import Snapshot

Array = NDArray[np.float64]

CONTACT_ROWS = 512
"""Contact points of a piece."""
SNAPSHOT_LEVEL = 4
"""Of deflating a snapshot: a twentieth smaller than with 1, and seldom enough to take half as long again."""
INPUT_ROWS = 4096
"""Inputs of a piece, and numbers of them."""


class Moment(NamedTuple):
    """What a frame has besides the state.

    Attributes:
        ledger: the engine's ledger of energy. gravity: (3,) m/s^2.
        rows: (n, width) the engine's rows of bodies with masses and inertias, into which the state will be put.
        contacts: the engine's rows of contact points, see :func:`stiction.contacts.contact_rows`; None if they are not
            kept.
        fixed: (n,) which bodies do not move by themselves; None with them.
    """

    ledger: Array
    gravity: Array
    rows: Array
    contacts: tuple[Array, NDArray[np.int64]] | None
    fixed: NDArray[np.bool_] | None


class RawInput(NamedTuple):
    """An input on its way into the file: numbers, or a text."""

    step: int
    body: int
    code: int
    numbers: Array | None
    text: dict[str, Any] | None


class Batch(NamedTuple):
    """Steps in a row of a world whose bodies stay the same.

    Attributes:
        first: steps that had been taken at the first of the states.
        states: (k, n, 13), one a step.
        slots: (n,) number of each body in the file, which never changes, while indices do when bodies are removed.
        frames: which of them become frames, by steps taken.
        inputs: before, between and after these steps.
        checkpoints: snapshots, with the steps taken by then.
        room: memory that may be used again once the batch has been taken in.
    """

    first: int
    states: Array
    slots: NDArray[np.int64]
    frames: dict[int, Moment]
    inputs: list[RawInput]
    checkpoints: list[tuple[int, Snapshot]]
    room: Array | None = None


class FileWriter:
    """Writes a recording.

    Args:
        path: of the file, which is made now.
        attributes: of the root.
        texts: JSON values that do not change: settings, materials, scene, meta.
        bodies: JSON of the bodies at the beginning.
        precision: of the frames. contacts: whether they are kept.

    Raises:
        OutputError: the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        attributes: dict[str, Any],
        texts: dict[str, Any],
        bodies: list[dict[str, Any]],
        precision: str,
        contacts: bool,
    ) -> None:
        self._path, self._precision, self._contacts = path, precision, contacts
        self._fingerprint = Fingerprint()
        self._last_hash = self._last_frame = -1
        self._rows = 0
        self._data_end = self._text_end = 0
        self._slots = len(bodies)
        file = self._file = layout.create_file(path)
        file.attrs.update(attributes)
        text = h5py.string_dtype()
        for name, value in texts.items():
            file.create_dataset(name, data=json.dumps(value), dtype=text)
        file.create_dataset("bodies", data=[json.dumps(body) for body in bodies], dtype=text, shape=(len(bodies),))
        outcome = np.array(layout.OPEN_OUTCOME.encode(), layout.OUTCOME_DTYPE)
        self._outcome = file.create_dataset("outcome", data=outcome)

        n, rows = len(bodies), piece_rows(len(bodies))
        types = layout.FRAME_TYPES[precision]
        self._frames = {
            name: PackedColumn(file, f"frames/{name}", types[name], (n, width), rows, layout.ORDERS[name])
            for name, width in WIDTHS.items()
        }
        if contacts:
            self._frames["motion"] = PackedColumn(file, "frames/motion", "u1", (n, 1), rows)
        self._input_rows = PackedColumn(file, "inputs/rows", layout.INPUT_DTYPE, (), INPUT_ROWS)
        self._input_numbers = PackedColumn(file, "inputs/numbers", "u8", (), INPUT_ROWS)
        self._inputs = (self._input_numbers, self._input_rows)
        self._encoder = InputNumbers()
        contact = CONTACT_DTYPE if precision == "full" else layout.DISPLAY_CONTACT
        self._plain = {
            "inputs/texts": PlainColumn(file, "inputs/texts", "u1", rows=1 << 16),
            "checkpoints/data": PlainColumn(file, "checkpoints/data", "u1", rows=1 << 16),
            "checkpoints/rows": PlainColumn(file, "checkpoints/rows", layout.CHECKPOINT_DTYPE, rows=64),
            "contacts": PlainColumn(file, "contacts", contact, rows=CONTACT_ROWS),
            "frames/contact_ends": PlainColumn(file, "frames/contact_ends", "i8"),
            "frames/times": PlainColumn(file, "frames/times", "f8"),
            "frames/energy": PlainColumn(file, "frames/energy", "f8", (len(layout.ENERGY_FIELDS),), rows=256),
            "frames/steps": PlainColumn(file, "frames/steps", "i8"),
            "hashes": PlainColumn(file, "hashes", "u8", rows=4096),
        }
        self._commits = PlainColumn(file, "commits", "i8", (len(layout.COUNTED),), rows=64)
        self._commits.dataset.attrs["columns"] = list(layout.COUNTED)
        self._input_rows.dataset.attrs["kinds"] = list(KINDS)
        self._input_numbers.dataset.attrs["differences"] = ORDER
        self._input_numbers.dataset.attrs["type"] = "<f8"
        self._plain["frames/energy"].dataset.attrs["columns"] = list(layout.ENERGY_FIELDS)
        self._dt = float(attributes["dt"])

    def share(self) -> None:
        """From now on others may read along; no new data set can be made."""
        self._file.swmr_mode = True

    def process(self, batch: Batch) -> None:
        """Take a batch in; :meth:`commit` writes it."""
        new = max(0, self._last_hash + 1 - batch.first)
        if new < len(batch.states):
            self._plain["hashes"].add(self._fingerprint.of_steps(batch.first + new, batch.states[new:]))
            self._last_hash = batch.first + len(batch.states) - 1
        self._add_inputs(batch.inputs)
        for step, snapshot in batch.checkpoints:
            data = np.frombuffer(pack_snapshot(snapshot), np.uint8)
            self._plain["checkpoints/data"].add(data)
            row = np.array([(step, self._data_end, len(data))], layout.CHECKPOINT_DTYPE)
            self._plain["checkpoints/rows"].add(row)
            self._data_end += len(data)
        steps = [step for step in sorted(batch.frames) if step > self._last_frame]
        if steps:
            self._add_frames(batch, steps)
            self._last_frame = steps[-1]

    def _add_inputs(self, inputs: list[RawInput]) -> None:
        if not inputs:
            return
        rows = np.array([(one.step, one.body, one.code) for one in inputs], layout.INPUT_DTYPE)
        self._input_rows.add(rows)
        numbers = [one.numbers for one in inputs if one.numbers is not None]
        if numbers:
            self._input_numbers.add(self._encoder.encode(rows, np.concatenate(numbers)))
        text = KINDS.index(TEXT)
        lines = b"".join(json.dumps(one.text).encode() + b"\n" for one in inputs if one.code == text)
        self._plain["inputs/texts"].add(np.frombuffer(lines, np.uint8))

    def _add_frames(self, batch: Batch, steps: list[int]) -> None:
        states = batch.states[[step - batch.first for step in steps]]
        slots = batch.slots
        if len(slots):
            self._slots = max(self._slots, int(slots[-1]) + 1)
        whole = len(slots) == self._slots
        for name, part in PARTS.items():
            values = states[:, :, part]
            if not whole:
                values = np.full((len(steps), self._slots, values.shape[2]), np.nan)
                values[:, slots] = states[:, :, part]
            self._frames[name].add(encode(name, values, self._precision))
        plain = self._plain
        plain["frames/steps"].add(steps)
        plain["frames/times"].add([step * self._dt for step in steps])
        moments = [batch.frames[step] for step in steps]
        plain["frames/energy"].add([energy_of(moment, state) for moment, state in zip(moments, states, strict=True)])
        ends = []
        for moment, state in zip(moments, states, strict=True):
            if moment.contacts is not None and moment.fixed is not None:
                rows = contact_rows(*moment.contacts)
                motion = np.zeros((1, self._slots, 1), np.uint8)
                motion[0, slots, 0] = judge(state, moment.fixed, rows)
                self._frames["motion"].add(motion)
                rows["body_a"], rows["body_b"] = slots[rows["body_a"]], slots[rows["body_b"]]
                plain["contacts"].add(rows)
                self._rows += len(rows)
            ends.append(self._rows)
        plain["frames/contact_ends"].add(ends)

    def commit(self, everything: bool) -> None:
        """Write what was taken in, down to the system; frames that do not fill a piece only if they wait since the
        commit before, or if ``everything`` is asked for.

        Raises:
            OutputError: the disk does not take it.
        """
        # a step without its inputs could not be repeated, so these are always written
        frames = [partial(column.write, everything) for column in self._frames.values()]
        self._write([*(partial(column.write, True) for column in self._inputs), *frames])

    def close(self, outcome: str) -> None:
        """Write the rest and how it ended, and close the file."""
        try:
            self._write([column.finish for column in (*self._inputs, *self._frames.values())])
            self._outcome[()] = outcome.encode()[: layout.OUTCOME_DTYPE.itemsize]
        finally:
            self._file.close()

    def _write(self, writes: list[Callable[[], None]]) -> None:
        """Write the packed columns by these calls, then the plain ones, and at last how long all of them are."""
        try:
            for write in (*writes, *(column.write for column in self._plain.values())):
                write()
            lengths = {name: column.length for name, column in self._plain.items()}
            lengths |= {"inputs/rows": self._input_rows.length, "inputs/numbers": self._input_numbers.length}
            lengths["frames/steps"] = min(column.length for column in self._frames.values())
            self._commits.add([[lengths[name] for name in layout.COUNTED]])
            self._commits.write()
            layout.sign(self._file)
        except (OSError, RuntimeError) as error:
            raise OutputError(f"recording {str(self._path)!r} cannot be written any further: {error}.") from None


def energy_of(moment: Moment, state: Array) -> Energy:
    """The ledger of energy of a moment whose state (n, 13) is given, to the last bit as the world would tell it, J."""
    rows = moment.rows
    rows[:, columns.POSITION : columns.POSITION + STATE_WIDTH] = state
    return balance(columns, moment.ledger, *kernels.energy(rows, len(rows), *moment.gravity))


def pack_snapshot(snapshot: Snapshot) -> bytes:
    """A snapshot as the bytes of an ``.npz`` file, which ``numpy.load`` opens."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=SNAPSHOT_LEVEL) as archive:
        for name, array in snapshot.items():
            with archive.open(name.replace("/", "|") + ".npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asarray(array, order="C"), allow_pickle=False)
    return out.getvalue()


def unpack_snapshot(data: bytes) -> Snapshot:
    """What :func:`pack_snapshot` packed; ValueError or BadZipFile for anything else."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        return {name.replace("|", "/"): archive[name] for name in archive.files}
