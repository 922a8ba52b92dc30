"""Recordings in the forms of other programs: which ending means what, and tables and arrays with names."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction import outputs
from stiction.errors import InvalidInputError
from stiction.record.frames import Frames
from stiction.record.recorder import WIDTHS

if TYPE_CHECKING:
    from stiction.record.recording import Recording

Progress = Callable[[int, int], None]

ENDINGS = {".glb": (), ".parquet": ("pyarrow",), ".nc": ("xarray",)}
"""Endings of files that can be written, with the packages that each needs."""
COLUMNS = {
    "positions": ("x", "y", "z"),
    "orientations": ("qw", "qx", "qy", "qz"),
    "velocities": ("vx", "vy", "vz"),
    "angular_velocities": ("wx", "wy", "wz"),
}
"""Columns of a table, SI units."""
UNITS = {"positions": "m", "orientations": "1", "velocities": "m s-1", "angular_velocities": "rad s-1"}
AXES = {3: ("axis", ["x", "y", "z"]), 4: ("component", ["w", "x", "y", "z"])}
TABLE_ROWS = 1 << 18
"""Rows of a table that are made at once."""


def check_target(name: str, path: str | Path) -> Path:
    """The path, if its ending is known, what that needs is installed, and the file can be written.

    Raises:
        InvalidInputError: the ending is not known, or a package is missing.
        OutputError: the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() not in ENDINGS:
        raise InvalidInputError(f"{name} must end in {', '.join(ENDINGS)}, got {str(target)!r}.")
    need(f"{name} {str(target)!r}", *ENDINGS[target.suffix.lower()])
    return outputs.writable(name, target, make_folder=True)


def need(what: str, *packages: str) -> None:
    """InvalidInputError unless these packages are installed."""
    for package in packages:
        if importlib.util.find_spec(package) is None:
            raise InvalidInputError(f'{what} needs {package}: pip install "stiction[data]".')


def write(
    recording: Recording, path: str | Path, start: float | None, stop: float | None, on_progress: Progress | None = None
) -> None:
    """Write the frames from ``start`` to ``stop`` (s) in the form that the ending names."""
    target = check_target("path", path)
    try:
        match target.suffix.lower():
            case ".glb":
                from stiction.record.gltf import write_glb

                write_glb(recording.frames(start, stop), target, on_progress)
            case ".parquet":
                write_parquet(recording, target, start, stop, on_progress)
            case _:
                engine = next(
                    (name for name in ("h5netcdf", "netCDF4", "scipy") if importlib.util.find_spec(name)), None
                )
                dataset_of(recording.frames(start, stop)).to_netcdf(target, engine=engine)
    except OSError as error:
        raise outputs.not_writable("path", target, error) from error


def write_parquet(
    recording: Recording, path: Path, start: float | None, stop: float | None, on_progress: Progress | None = None
) -> None:
    """A row a body and frame: step, time, body, position, orientation, velocities; some frames at a time."""
    need("to_parquet", "pyarrow")
    import pyarrow as pa
    import pyarrow.parquet as pq

    span = recording.span(start, stop)
    steps, times = recording.frame_steps[span], recording.times[span]
    names = pa.array([body.name for body in recording.bodies], pa.string())
    n = len(recording.bodies)
    schema = pa.schema(
        [("step", pa.int64()), ("time", pa.float64()), ("body", pa.dictionary(pa.int32(), pa.string()))]
        + [(column, pa.float64()) for columns in COLUMNS.values() for column in columns],
        metadata={"title": recording.title, "dt": repr(recording.dt), "source": "stiction recording"},
    )
    at_once = max(1, TABLE_ROWS // max(1, n))
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for first in range(0, len(steps), at_once):
            part = slice(first, min(first + at_once, len(steps)))
            f = part.stop - part.start
            bodies = pa.DictionaryArray.from_arrays(np.tile(np.arange(n, dtype=np.int32), f), names)
            data: list[Any] = [np.repeat(steps[part], n), np.repeat(times[part], n), bodies]
            for name, columns in COLUMNS.items():
                values = recording.array(name, slice(span.start + part.start, span.start + part.stop))
                data += [np.ascontiguousarray(values[:, :, k].ravel()) for k in range(len(columns))]
            writer.write_table(pa.table(data, schema=schema))
            if on_progress is not None:
                on_progress(part.stop, len(steps))


def dataset_of(frames: Frames) -> Any:
    """An ``xarray.Dataset`` with dimensions time, body, axis and component.

    Raises:
        InvalidInputError: xarray is not installed.
    """
    need("to_xarray", "xarray")
    import xarray as xr

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {
        "time": ("time", frames.times, {"units": "s"}),
        "body": ("body", [body.name for body in frames.bodies]),
        "material": ("body", [body.material for body in frames.bodies]),
    }
    for name, width in WIDTHS.items():
        axis, labels = AXES[width]
        variables[name] = (("time", "body", axis), getattr(frames, name), {"units": UNITS[name]})
        coordinates[axis] = (axis, labels)
    attributes = {"title": frames.title, "dt": frames.dt, "solver": str(frames.meta.get("solver", ""))}
    return xr.Dataset(variables, coordinates, attributes)
