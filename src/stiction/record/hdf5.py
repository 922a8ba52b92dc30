"""Recordings in HDF5: the scene, the state it began with, and frame after frame.

The file (any HDF5 reader opens it):

    /                   format, format_version, stiction_version, title, scene_name, dt, every, solver, outcome
    /scene              the scene with all defaults written out, JSON
    /bodies             (n,) JSON: name, shape, material, mass, fixed
    /initial/…          positions, orientations, velocities, angular_velocities at step 0, to the last bit
    /frames/…           the same, (f, n, …), with times, motion and contact_ends (f,): frame k's contacts end there
    /contacts           rows of all frames, see stiction.contacts.CONTACT_DTYPE

Whatever ends a run, the file is closed with the frames up to there; ``outcome`` says what it was.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from stiction import outputs
from stiction._version import __version__
from stiction.errors import InvalidInputError, OutputError, SimulationError
from stiction.record.bodies import info_from_dict, info_to_dict
from stiction.record.frames import CONTACT_DTYPE, Frames
from stiction.record.interrupts import interrupts_held
from stiction.record.recorder import WIDTHS, Capturer, Frame, body_infos, gather
from stiction.scene import Scene, Simulation

if TYPE_CHECKING:
    from stiction.record.frames import BodyInfo

FORMAT = "stiction recording"
FORMAT_VERSION = 1

CHUNK_BYTES = 1 << 18
"""Aimed size of a piece of a data set, which HDF5 compresses and reads as one."""
BUFFERED_FRAMES = 64
"""Frames that are kept in memory before they are written."""
BUFFERED_SECONDS = 1.0
"""Frames are written after that time at the latest, so that little is lost if the machine stops."""


class RecordingWriter(Capturer):
    """Writes a run into a file, while it goes on. A context manager; :meth:`close` does the same by hand.

    Args:
        path: of the file, which is made now, so that a bad path is known before the run. An older recording there is
            replaced, a file of any other kind is not.
        simulation: at its beginning.
        every: steps from one frame to the next.
        contacts: keep contact points, too.

    Raises:
        InvalidInputError: the simulation has already begun, or every is not a whole number, 1 or more.
        OutputError: the file cannot be written.
    """

    def __init__(self, path: str | Path, simulation: Simulation, every: int = 1, contacts: bool = True) -> None:
        super().__init__(simulation.world, every, contacts)
        if simulation.step_index != 0:
            raise InvalidInputError(
                f"a recording must begin with the simulation, which is at step {simulation.step_index} already."
            )
        self.path = outputs.writable("recording", path)
        self._simulation = simulation
        self._buffer: list[Frame] = []
        self._frames = 0
        self._rows = 0
        self._written_at = time.monotonic()
        with interrupts_held():
            self._file: h5py.File | None = _create(self.path)
            self._write_header(self._file)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(None if error is None else outcome_of(error))

    def __len__(self) -> int:
        return self._frames + len(self._buffer)

    def _keep(self, frame: Frame) -> None:
        self._buffer.append(frame)
        if len(self._buffer) >= BUFFERED_FRAMES or time.monotonic() - self._written_at > BUFFERED_SECONDS:
            self.flush()

    def flush(self) -> None:
        """Write what is still in memory, down to the disk.

        Raises:
            OutputError: the disk does not take it.
        """
        if self._file is None:
            return
        try:
            with interrupts_held():
                self._append(self._file)
                self._file.flush()
        except OSError as error:
            raise OutputError(f"recording {str(self.path)!r} cannot be written any further: {error}.") from None
        self._written_at = time.monotonic()

    def close(self, outcome: str | None = None) -> None:
        """Write what is still in memory and close the file; nothing happens if it is closed already.

        Args:
            outcome: how the run ended; ``complete`` or ``stopped early`` if left out, whichever it was.
        """
        if self._file is None:
            return
        with interrupts_held():
            try:
                self.flush()
                self._file.attrs["outcome"] = outcome or ("complete" if self._simulation.done else "stopped early")
            finally:
                self._file.close()
                self._file = None

    def _write_header(self, file: h5py.File) -> None:
        world, scene = self.world, self._simulation.scene
        attributes = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "stiction_version": __version__,
            "title": scene.title,
            "scene_name": scene.name,
            "dt": world.dt,
            "every": self.every,
            "solver": world.solver,
            "outcome": "not closed",
        }
        file.attrs.update(attributes)
        text = h5py.string_dtype()
        file.create_dataset("scene", data=json.dumps(scene.to_dict()), dtype=text)
        file.create_dataset("bodies", data=[json.dumps(info_to_dict(b)) for b in body_infos(world)], dtype=text)
        for name in WIDTHS:
            file.create_dataset(f"initial/{name}", data=getattr(world, name))

        n = len(world)
        for name, width in WIDTHS.items():
            _extendable(file, f"frames/{name}", (n, width), np.dtype(np.float64))
        _extendable(file, "frames/motion", (n,), np.dtype(np.uint8))
        _extendable(file, "frames/times", (), np.dtype(np.float64))
        _extendable(file, "frames/contact_ends", (), np.dtype(np.int64))
        _extendable(file, "contacts", (), CONTACT_DTYPE)
        file.flush()

    def _append(self, file: h5py.File) -> None:
        """Write the buffer behind what is there. Cut off in the middle and called again, it writes the same again."""
        if not self._buffer:
            return
        arrays = gather(self._buffer, len(self._fixed))
        rows, counts = arrays.pop("contacts"), arrays.pop("counts")
        _put(file["contacts"], self._rows, rows)
        arrays["contact_ends"] = self._rows + np.cumsum(counts)
        for name in ("times", *(name for name in arrays if name != "times")):
            _put(file[f"frames/{name}"], self._frames, arrays[name])
        # from here on the frames count as written
        self._frames, self._rows, self._buffer = self._frames + len(counts), self._rows + len(rows), []


def load_frames(path: str | Path) -> Frames:
    """The frames of a recording; ``meta`` holds its scene, versions and outcome.

    Raises:
        InvalidInputError: there is no such file, or it is no recording.
    """
    with _open(path) as file:
        try:
            groups = {name: file[f"frames/{name}"] for name in ("times", "motion", "contact_ends", *WIDTHS)}
            # a run that was killed may have left the last frame unfinished
            f = min(len(group) for group in groups.values())
            arrays: dict[str, NDArray[Any]] = {name: group[:f] for name, group in groups.items()}
            ends = arrays.pop("contact_ends")
            offsets = np.concatenate([[0], ends]).astype(np.int64)
            meta = {name: _plain(value) for name, value in file.attrs.items() if name not in ("title", "dt")}
            return Frames(
                title=str(file.attrs["title"]),
                dt=float(file.attrs["dt"]),
                bodies=_bodies(file),
                contacts=file["contacts"][: offsets[-1]].astype(CONTACT_DTYPE),
                contact_offsets=offsets,
                meta={**meta, "scene": _scene(file)},
                **arrays,
            )
        except (KeyError, ValueError, TypeError, OSError) as error:
            raise _damaged(path, error) from None


def restore(path: str | Path) -> Simulation:
    """The simulation of a recording, back at its beginning: the same scene, and the same state to the last bit.

    With the version of stiction that made the recording, on the same kind of machine, it runs as it ran then.

    Raises:
        InvalidInputError: there is no such file, it is no recording, or the scene's bodies are not those recorded.
    """
    with _open(path) as file:
        try:
            data, name, bodies = _scene(file), str(file.attrs["scene_name"]), _bodies(file)
            initial = {key: file[f"initial/{key}"][:] for key in WIDTHS}
        except (KeyError, ValueError, TypeError, OSError) as error:
            raise _damaged(path, error) from None
    simulation = Simulation(Scene.from_dict(data, name))
    world = simulation.world
    shapes = {key: (len(world), width) for key, width in WIDTHS.items()}
    if [body.name for body in world] != [body.name for body in bodies] or any(
        initial[key].shape != shape for key, shape in shapes.items()
    ):
        raise InvalidInputError(f"recording {str(path)!r} holds other bodies than its scene, so it cannot be restored.")
    for key, values in initial.items():
        getattr(world, key)[:] = values
    return simulation


def outcome_of(error: BaseException) -> str:
    """How a run ended, for the file."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, SimulationError):
        return f"failed: {error}"
    return f"stopped by {type(error).__name__}: {error}"


# --- pieces -----------------------------------------------------------------------------------------------------------


def _create(path: Path) -> h5py.File:
    if path.exists() and path.stat().st_size > 0 and not h5py.is_hdf5(path):
        raise OutputError(f"recording must not replace a file of another kind, and {str(path)!r} is no HDF5 file.")
    try:
        return h5py.File(path, "w")
    except OSError as error:
        raise OutputError(f"recording cannot be written: {str(path)!r}: {error}.") from None


def _open(path: str | Path) -> h5py.File:
    if not Path(path).is_file():
        raise InvalidInputError(f"recording must be a file that exists, got {str(path)!r}.")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        if h5py.is_hdf5(path):
            raise InvalidInputError(f"recording {str(path)!r} cannot be opened: {error}.") from None
        raise InvalidInputError(f"{str(path)!r} is not a recording of stiction: it is no HDF5 file.") from None
    if file.attrs.get("format") != FORMAT:
        file.close()
        raise InvalidInputError(f"{str(path)!r} is not a recording of stiction, but another HDF5 file.")
    version = int(file.attrs.get("format_version", 0))
    if version != FORMAT_VERSION:
        file.close()
        raise InvalidInputError(
            f"recording {str(path)!r} must have format version {FORMAT_VERSION}, got {version}: "
            f"it was made by another version of stiction."
        )
    return file


def _damaged(path: str | Path, error: Exception) -> InvalidInputError:
    return InvalidInputError(f"recording {str(path)!r} is damaged: {error}.")


def _scene(file: h5py.File) -> dict[str, Any]:
    data = json.loads(file["scene"].asstr()[()])
    if not isinstance(data, dict):
        raise ValueError("its scene is no table")
    return data


def _bodies(file: h5py.File) -> list[BodyInfo]:
    return [info_from_dict(json.loads(text)) for text in file["bodies"].asstr()[:]]


def _plain(value: Any) -> Any:
    """A Python number or text for an attribute of the file."""
    return value.item() if isinstance(value, np.generic) else value


def _extendable(file: h5py.File, name: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
    """An empty data set to which rows of that shape can be appended."""
    row = max(1, dtype.itemsize * int(np.prod(shape, dtype=np.int64)))
    chunk = (max(1, min(1024, CHUNK_BYTES // row)), *(max(1, size) for size in shape))
    file.create_dataset(
        name,
        shape=(0, *shape),
        maxshape=(None, *(size or None for size in shape)),  # a world without bodies has pieces of one body, too
        dtype=dtype,
        chunks=chunk,
        compression="gzip",
        compression_opts=1,
        shuffle=True,
    )


def _put(target: h5py.Dataset, start: int, values: NDArray[Any]) -> None:
    """Write rows from ``start`` on, the last ones of the data set."""
    target.resize(start + len(values), axis=0)
    if len(values):
        target[start:] = values
