"""Recording: a run in a file, to be looked at in parts, run again and compared."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.contacts import CONTACT_DTYPE
from stiction.errors import InvalidInputError
from stiction.motion import Motion
from stiction.record import layout
from stiction.record.bodies import info_from_dict
from stiction.record.columns import decode
from stiction.record.frames import Frames
from stiction.record.packed import PackedRows
from stiction.record.recorder import WIDTHS

if TYPE_CHECKING:
    from stiction.record.inputs import Input
    from stiction.record.replay import ReplayCheck
    from stiction.snapshot import Snapshot
    from stiction.view.server import Viewer
    from stiction.view.show import Inline
    from stiction.world import World

Array = NDArray[np.float64]

TRIES = 20
"""How often a file is read anew in which a piece became full meanwhile: to read takes much less time than a piece."""
UNREADABLE = (KeyError, ValueError, TypeError, OSError, RuntimeError, IndexError, EOFError, MemoryError)
"""What h5py and what reads its data raise where a file does not hold what it should, or says it holds far more."""


class Recording:
    """A recording, opened for reading with :meth:`open`. A context manager; :meth:`close` does the same by hand.

    Nothing is read before it is asked for, and of arrays only the frames and bodies that are asked for. A recording
    may be read while it is written, and after its process was killed; :meth:`refresh` sees what came since.

    Frames are for the eye: positions in float32, orientations in 16 bits, velocities in float16, unless the recording
    was made with ``precision="full"``. :meth:`world` gives any step to the last bit, by running the engine again from
    the snapshot before it.

    Attributes:
        path: of the file.
        format_version: 3, or 2 or 1 for recordings of earlier versions; those of 1 hold frames and a scene, but neither
            hashes nor inputs, so that they cannot be checked.
        title: a few words. dt: time step, s. every: steps from one frame to the next. solver: its name.
        precision: of frames, ``"display"`` or ``"full"``.
        first_step: steps that had been taken when the recording began.
        bodies: what does not change about each body that was ever there, in order of creation: the second axis of all
            arrays. Where a body was not there, frames hold NaN.
        metadata: everything else: versions, kernels, machine, settings, materials, scene, what the user gave.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._file, self.format_version = layout.open_file(path)
        self._closed = False
        try:
            attributes = {name: _plain(value) for name, value in self._file.attrs.items()}
            self.title = str(attributes.pop("title"))
            self.dt = float(attributes.pop("dt"))
            self.every = int(attributes.pop("every"))
            self.solver = str(attributes.pop("solver"))
            self.first_step = int(attributes.pop("first_step", 0))
            self.scene: dict[str, Any] | None = layout.read_json(self._file, "scene")
            if self.scene is not None and not isinstance(self.scene, dict):
                raise ValueError("its scene is no table")
            self.precision = str(attributes.setdefault("precision", "full"))
            self.metadata: dict[str, Any] = {**attributes, "scene": self.scene}
            if self.format_version > 1:
                for name in ("settings", "materials", "meta"):
                    self.metadata[name] = layout.read_json(self._file, name)
            self._rows = [_loads(text) for text in self._file["bodies"].asstr()[:]]
            self.bodies = [info_from_dict(row) for row in self._rows]
            self._packed = {f"frames/{name}": PackedRows(self._file, f"frames/{name}") for name in WIDTHS}
            if self.format_version > 1:
                self._packed |= {name: PackedRows(self._file, name) for name in ("inputs/rows", "inputs/numbers")}
            if self.format_version == 1 or self.metadata["contacts"]:
                self._packed["frames/motion"] = PackedRows(self._file, "frames/motion")
            self.refresh()
        except UNREADABLE as error:
            self._file.close()
            raise layout.damaged(path, error) from None

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Open a recording.

        Raises:
            InvalidInputError: there is no such file, or it is no recording, or it is damaged.
        """
        return cls(path)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; nothing happens if it is closed already."""
        if not self._closed:
            self._closed = True
            self._file.close()

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times)

    def __repr__(self) -> str:
        return f"<Recording of {self.title!r}: {len(self)} frames, {len(self.bodies)} bodies, {self.outcome}>"

    # --- what is there ------------------------------------------------------------------------------------------------

    def refresh(self) -> None:
        """See what has been written since the recording was opened.

        Raises:
            InvalidInputError: the file is damaged.
        """
        try:
            self._refresh()
        except UNREADABLE as error:
            raise layout.damaged(self.path, error) from None

    def _refresh(self) -> None:
        file = self._file
        if self.format_version == 1:
            names = ("times", "motion", "contact_ends", *WIDTHS)
            # a run that was killed may have left the last frame unfinished
            frames = min(len(file[f"frames/{name}"]) for name in names)
            self._lengths = dict.fromkeys(layout.COUNTED, 0) | {"frames/steps": frames}
            self.times: Array = file["frames/times"][:frames]
            self.frame_steps: NDArray[np.int64] = np.rint(self.times / self.dt).astype(np.int64)
            self.outcome = str(file.attrs["outcome"])
            self.has_contacts = True
        else:
            self._lengths = self._committed()
            frames = self._lengths["frames/steps"]
            self.frame_steps = file["frames/steps"][:frames]
            self.times = file["frames/times"][:frames]
            file["outcome"].id.refresh()
            self.outcome = bytes(file["outcome"][()]).decode()
            self.has_contacts = bool(self.metadata["contacts"])
            texts = (_loads(line.decode()) for line in self._texts().splitlines())
            added = [text for text in texts if text["what"] == "add"]
            for text in added[len(self.bodies) - len(self._rows) :]:
                self.bodies.append(info_from_dict(text["body"]))
        self._ends = np.concatenate([[0], file["frames/contact_ends"][:frames]]).astype(np.int64)

    def _committed(self) -> dict[str, int]:
        """Lengths of the data sets at the last commit that they all hold; the rows of tails are copied."""
        for _ in range(TRIES):
            lengths = self._see_lengths()
            seen = [packed.packed for packed in self._packed.values()]
            for name, packed in self._packed.items():
                packed.keep(lengths["frames/steps" if name.startswith("frames/") else name])
            for packed in self._packed.values():
                packed.refresh()
            if seen == [packed.packed for packed in self._packed.values()]:
                return lengths
            # a piece became full meanwhile, so that its rows may have been written over in its tail
        raise ValueError("it grows faster than it can be read")

    def _see_lengths(self) -> dict[str, int]:
        file = self._file
        plain = [name for name in layout.COUNTED if name not in ("inputs/rows", "inputs/numbers")]
        for name in ("commits", *plain):
            file[name].id.refresh()
        for name in ("frames/times", "frames/energy", "frames/contact_ends", "checkpoints/data"):
            file[name].id.refresh()
        for packed in self._packed.values():
            packed.refresh()
        rows = file["commits"][:]
        held = {name: len(file[name]) for name in plain}
        held |= {name: packed.room for name, packed in self._packed.items() if name in layout.COUNTED}
        held["frames/steps"] = min(held["frames/steps"], *(p.room for n, p in self._packed.items() if n not in held))
        good = (rows <= [held[name] for name in layout.COUNTED]).all(axis=1)
        if not good.any():
            raise ValueError("nothing of it was written whole")
        return dict(zip(layout.COUNTED, rows[np.flatnonzero(good)[-1]].tolist(), strict=True))

    @property
    def last_step(self) -> int:
        """Steps that had been taken at the last step that is here."""
        if self.format_version == 1:
            return int(self.frame_steps[-1]) if len(self) else self.first_step
        return self.first_step + self._lengths["hashes"] - 1

    @property
    def hashes(self) -> NDArray[np.uint64]:
        """(s,) :class:`stiction.hashing.Fingerprint` of the state at every step, from ``first_step`` on."""
        if self.format_version == 1:
            return np.zeros(0, np.uint64)
        result: NDArray[np.uint64] = self._file["hashes"][: self._lengths["hashes"]]
        return result

    @property
    def checkpoint_steps(self) -> NDArray[np.int64]:
        """(c,) steps at which there is a snapshot."""
        if self.format_version == 1:
            return np.zeros(0, np.int64)
        result: NDArray[np.int64] = self._file["checkpoints/rows"][: self._lengths["checkpoints/rows"]]["step"]
        return result

    @property
    def energies(self) -> NDArray[Any]:
        """(f,) a row a frame with the columns of :class:`stiction.Energy`, J, to the last bit.

        Raises:
            InvalidInputError: the recording is of format 1, which has none.
        """
        self._must_be_new("energies")
        rows = self._read("frames/energy", slice(0, len(self)))
        result = np.zeros(len(rows), [(name, np.float64) for name in layout.ENERGY_FIELDS])
        for k, name in enumerate(layout.ENERGY_FIELDS):
            result[name] = rows[:, k]
        return result

    def inputs(self) -> list[Input]:
        """Everything that changed the world from outside while it was recorded, in the order in which it came.

        Raises:
            InvalidInputError: the file is damaged.
        """
        from stiction.record.input_numbers import decode_numbers
        from stiction.record.inputs import read_inputs

        if self.format_version == 1:
            return []
        try:
            rows, numbers = (
                self._packed[name].read(slice(0, self._lengths[name])) for name in ("inputs/rows", "inputs/numbers")
            )
            if self.format_version > 2:
                numbers = decode_numbers(rows, numbers, int(self._file["inputs/numbers"].attrs["differences"]))
            return list(read_inputs(rows, numbers, self._texts()))
        except (*UNREADABLE, StopIteration) as error:
            raise layout.damaged(self.path, error) from None

    def _texts(self) -> bytes:
        result: bytes = self._file["inputs/texts"][: self._lengths["inputs/texts"]].tobytes()
        return result

    # --- frames -------------------------------------------------------------------------------------------------------

    def positions(self, body: str | int | None = None, start: float | None = None, stop: float | None = None) -> Array:
        """Positions of the frames from ``start`` to ``stop``, both included, m; nothing else is read.

        Args:
            body: its name or its place in ``bodies``; all if left out.
            start: s. stop: s. All frames if left out.

        Returns:
            (f, n, 3), or (f, 3) for one body.

        Raises:
            InvalidInputError: there is no such body, or a time is not a finite number.
        """
        return self._array("positions", body, start, stop)

    def orientations(
        self, body: str | int | None = None, start: float | None = None, stop: float | None = None
    ) -> Array:
        """Unit quaternions (w, x, y, z), (f, n, 4) or (f, 4), as :meth:`positions`."""
        return self._array("orientations", body, start, stop)

    def velocities(self, body: str | int | None = None, start: float | None = None, stop: float | None = None) -> Array:
        """Velocities of the centres of mass, m/s, (f, n, 3) or (f, 3), as :meth:`positions`."""
        return self._array("velocities", body, start, stop)

    def angular_velocities(
        self, body: str | int | None = None, start: float | None = None, stop: float | None = None
    ) -> Array:
        """Angular velocities in world axes, rad/s, (f, n, 3) or (f, 3), as :meth:`positions`."""
        return self._array("angular_velocities", body, start, stop)

    def contacts(self, step: int) -> NDArray[Any]:
        """Contact points after that step, rows of :data:`stiction.contacts.CONTACT_DTYPE`; bodies by their place in
        ``bodies``.

        They are read where the recording kept them (at its frames), and otherwise the engine runs again to find them.

        Raises:
            InvalidInputError: the recording does not hold the step, or cannot be run again.
        """
        at = np.flatnonzero(self.frame_steps == self.step("step", step))
        if self.has_contacts and len(at):
            k = int(at[0])
            return self._contact_rows(self._ends[k], self._ends[k + 1])
        from stiction.record.replay import world_and_slots

        world, slots = world_and_slots(self, step)
        rows = world.contacts()
        rows["body_a"], rows["body_b"] = slots[rows["body_a"]], slots[rows["body_b"]]
        return rows

    def show(
        self, start: float | None = None, stop: float | None = None, *, host: str = "127.0.0.1", port: int = 8080
    ) -> Viewer:
        """A view of this recording in the browser, with a slider for time; a notebook shows it in its cell.

        It is paused at first. ``viewer.url`` is its address, ``viewer.stop()`` ends it.

        Args:
            start, stop: which part, s.
            host: address to listen at; others than this one let other machines in.
            port: where to listen; if it is taken, at a free port.

        Raises:
            InvalidInputError: a value is not allowed, or there is no frame in that part.
        """
        from stiction.view.server import Viewer
        from stiction.view.show import playback_of

        return Viewer(playback_of(self, start, stop), host=host, port=port)

    def inline(self, start: float | None = None, stop: float | None = None, *, height: int = 480) -> Inline:
        """The part as a page of its own in a cell of a notebook: it plays there from the notebook's file alone, and so
        also in HTML that nbconvert has made, without Python and without a network. It takes some 2 MB.

        Args:
            start, stop: which part, s.
            height: of the picture, pixels.

        Raises:
            InvalidInputError: a value is not allowed, or there is no frame in that part.
        """
        from stiction.view.show import Inline

        return Inline(self.frames(start, stop), checks.integer("height", height, minimum=1))

    def frames(self, start: float | None = None, stop: float | None = None) -> Frames:
        """The frames from ``start`` to ``stop`` (s) in memory, for pages and plots.

        ``meta`` holds what :attr:`metadata` has, and the outcome. Without contacts in the file there are none in the
        frames, and ``motion`` calls every body that can move free; ``meta["contacts"]`` says whether that is so.
        """
        span = self.span(start, stop)
        arrays = {name: self._array(name, None, start, stop) for name in WIDTHS}
        f, n = arrays["positions"].shape[:2]
        if self.has_contacts:
            motion = self.stored("motion", span).reshape(f, -1)
        else:
            fixed = np.array([body.fixed for body in self.bodies], np.bool_).reshape(1, n)
            motion = np.where(np.repeat(fixed, f, axis=0), Motion.FIXED, Motion.FREE).astype(np.uint8)
        ends = self._ends[span.start : span.stop + 1]
        return Frames(
            title=self.title,
            dt=self.dt,
            bodies=list(self.bodies),
            times=self.times[span],
            motion=motion,
            contacts=self._contact_rows(int(ends[0]), int(ends[-1])),
            contact_offsets=ends - ends[0],
            meta={
                **self.metadata, "every": self.every, "solver": self.solver, "outcome": self.outcome,
                "contacts": self.has_contacts,
            },
            **arrays,
        )  # fmt: skip

    # --- other programs -----------------------------------------------------------------------------------------------

    def to_xarray(self, start: float | None = None, stop: float | None = None) -> Any:
        """The frames from ``start`` to ``stop`` (s) as an ``xarray.Dataset``: dimensions time, body, axis, component.

        Raises:
            InvalidInputError: xarray is not installed.
        """
        from stiction.record.export import dataset_of

        return dataset_of(self.frames(start, stop))

    def export(self, path: str | Path, start: float | None = None, stop: float | None = None) -> None:
        """Write the frames from ``start`` to ``stop`` (s) as the ending says: ``.glb`` (an animation), ``.parquet`` (a
        row a body and frame) or ``.nc`` (NetCDF).

        Raises:
            InvalidInputError: the ending is not known, or a package that it needs is not installed.
            OutputError: the file cannot be written.
        """
        from stiction.record.export import write

        write(self, path, start, stop)

    def to_parquet(self, path: str | Path, start: float | None = None, stop: float | None = None) -> None:
        """Write a Parquet file, whatever its name: a row a body and frame.

        Raises:
            InvalidInputError: pyarrow is not installed.
            OutputError: the file cannot be written.
        """
        from stiction import outputs
        from stiction.record.export import write_parquet

        write_parquet(self, outputs.writable("path", path), start, stop)

    # --- running again ------------------------------------------------------------------------------------------------

    def snapshot(self, checkpoint: int) -> Snapshot:
        """A snapshot, by its place in :attr:`checkpoint_steps`.

        Raises:
            InvalidInputError: it is damaged.
        """
        from zipfile import BadZipFile

        from stiction.record.file_writer import unpack_snapshot

        try:
            row = self._file["checkpoints/rows"][checkpoint]
            start, length = int(row["start"]), int(row["length"])
            return unpack_snapshot(self._file["checkpoints/data"][start : start + length].tobytes())
        except (*UNREADABLE, BadZipFile) as error:
            raise layout.damaged(self.path, error) from None

    def world(self, step: int | None = None) -> World:
        """The world as it was after that step, to the last bit, ready to go on; the last step if left out.

        Raises:
            InvalidInputError: the recording does not hold the step, or cannot be run again.
        """
        from stiction.record.replay import world_and_slots

        return world_and_slots(self, self.last_step if step is None else step)[0]

    def check(self, start: float | None = None, stop: float | None = None) -> ReplayCheck:
        """Run the engine again, and compare every step from ``start`` to ``stop`` (s) with its hash.

        Raises:
            InvalidInputError: the recording cannot be run again, or a time is not in it.
        """
        from stiction.record.replay import check

        return check(self, start, stop)

    # --- inside -------------------------------------------------------------------------------------------------------

    def step(self, name: str, value: Any) -> int:
        """A step that the recording holds."""
        step = checks.integer(name, value, minimum=0)
        if not self.first_step <= step <= self.last_step:
            raise InvalidInputError(
                f"{name} must be {self.first_step} to {self.last_step}, the steps of the recording, got {value!r}."
            )
        return step

    def step_at(self, name: str, time: float | None, otherwise: int) -> int:
        """The step nearest to a time in s, within the recording."""
        if time is None:
            return otherwise
        step = round(checks.number(name, time) / self.dt)
        if not self.first_step <= step <= self.last_step:
            raise InvalidInputError(
                f"{name} must be {self.first_step * self.dt:g} to {self.last_step * self.dt:g} s, the time of the "
                f"recording, got {time!r}."
            )
        return step

    def _must_be_new(self, what: str) -> None:
        if self.format_version == 1:
            raise InvalidInputError(f"recording {str(self.path)!r} has no {what}, for it is of format version 1.")

    def span(self, start: float | None, stop: float | None) -> slice:
        """The frames from ``start`` to ``stop`` (s), both included."""
        slack = 1e-6 * self.dt
        first = 0 if start is None else int(np.searchsorted(self.times, checks.number("start", start) - slack))
        last = len(self) if stop is None else int(np.searchsorted(self.times, checks.number("stop", stop) + slack))
        return slice(first, max(first, last))

    def _number(self, body: str | int) -> int:
        names = [info.name for info in self.bodies]
        if isinstance(body, str):
            if body not in names:
                raise InvalidInputError(f"no body is called {body!r}{checks.nearest(body, names)}.")
            return names.index(body)
        number = checks.integer("body", body, minimum=0)
        if number >= len(names):
            raise InvalidInputError(f"body must be a name or 0 to {len(names) - 1}, got {body!r}.")
        return number

    def _array(self, name: str, body: str | int | None, start: float | None, stop: float | None) -> Array:
        span = self.span(start, stop)
        if body is None:
            return self.array(name, span)
        number = self._number(body)
        if number >= self._packed[f"frames/{name}"].bodies:  # it was added after the last frame
            return np.full((span.stop - span.start, WIDTHS[name]), np.nan)
        return decode(self.stored(name, span, number))

    def array(self, name: str, span: slice) -> Array:
        """(f, n, width) one of the arrays of those frames, for all bodies."""
        values = decode(self.stored(name, span))
        missing = len(self.bodies) - values.shape[1]
        return values if missing <= 0 else np.pad(values, ((0, 0), (0, missing), (0, 0)), constant_values=np.nan)

    def stored(self, name: str, span: slice, body: int | None = None) -> NDArray[Any]:
        """(f, n, width) the numbers of an array as they were rounded for the file, or (f, width) those of one body."""
        try:
            return self._packed[f"frames/{name}"].read(span, body)
        except UNREADABLE as error:
            raise layout.damaged(self.path, error) from None

    def _read(self, name: str, where: Any) -> NDArray[Any]:
        try:
            result: NDArray[Any] = self._file[name][where]
        except UNREADABLE as error:
            raise layout.damaged(self.path, error) from None
        return result

    def _contact_rows(self, first: int, last: int) -> NDArray[Any]:
        return self._read("contacts", slice(int(first), int(last))).astype(CONTACT_DTYPE)


def _plain(value: Any) -> Any:
    """A Python number or text for an attribute of the file."""
    return value.item() if isinstance(value, np.generic) else value


def _loads(text: str) -> dict[str, Any]:
    import json

    data = json.loads(text)
    if not isinstance(data, dict):
        raise ValueError("a body is no table")
    return data
