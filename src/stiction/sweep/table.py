"""The table of a sweep: a row a run, as a Parquet file (or CSV), written in one move."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction import outputs
from stiction._version import __version__
from stiction.errors import NotYetError, OutputError
from stiction.sweep.journal import replace

if TYPE_CHECKING:
    from stiction.sweep.load import Sweep

SUFFIXES = (".parquet", ".csv")
Columns = dict[str, list[Any]]


def check_path(name: str, path: str | Path, *, make_folder: bool = False) -> Path:
    """The path, if a table can be written there.

    Args:
        name: what the sentence calls the parameter.
        path: of the table; its ending chooses the format.
        make_folder: make the folder if it is missing.

    Raises:
        OutputError: another ending, or the file cannot be written.
        NotYetError: a Parquet file without pyarrow.
    """
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise OutputError(f"{name} must end in {' or '.join(SUFFIXES)}, got {str(target)!r}.")
    if target.suffix.lower() == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401  # only whether it is there
        except ImportError:
            raise NotYetError(
                f"{name} needs pyarrow for a Parquet file: pip install 'stiction[sweep]', or name a .csv file."
            ) from None
    return outputs.writable(name, target, make_folder=make_folder)


def collect(sweep: Sweep, rows: Mapping[str, dict[str, Any]]) -> Columns:
    """The finished runs of a sweep as columns, in the order of its points.

    Args:
        sweep: the sweep.
        rows: id of each finished run to its row.

    Returns:
        ``index`` and ``run``, each parameter and each metric by name, then ``error``, ``warning``, ``steps``,
        ``state_hash``, ``wall_seconds`` and ``worker``. What a failed run has not is None.
    """
    names, metrics = sweep.points.names, list(sweep.job.metrics)
    about = ("error", "warning", "steps", "state_hash", "wall_seconds", "worker")
    columns: Columns = {name: [] for name in ("index", "run", *names, *metrics, *about)}
    for point in sweep.points:
        row = rows.get(point.run)
        if row is None:
            continue
        columns["index"].append(point.number)
        columns["run"].append(point.run)
        for name in names:
            value = point.values[name]
            columns[name].append(json.dumps(value) if isinstance(value, list | dict) else value)
        for name in metrics:
            columns[name].append(row["metrics"].get(name))
        for name in about:
            columns[name].append(row[name])
    for name in (*names, *metrics):
        columns[name] = _alike(columns[name])
    return columns


def write(sweep: Sweep, columns: Columns, path: Path) -> Path:
    """Write the table.

    The Parquet file carries the sweep, the scene and the version of stiction in its metadata, under ``stiction``.

    Raises:
        OutputError: it cannot be written.
    """
    content = _csv(columns) if path.suffix.lower() == ".csv" else _parquet(sweep, columns)
    try:
        replace(path, content)
    except OSError as error:
        raise outputs.not_writable("--table", path, error) from error
    return path


def _alike(values: list[Any]) -> list[Any]:
    """Values of one column in one kind: texts if one is, numbers if one is, or flags."""
    given = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in given):
        return [None if value is None else str(value) for value in values]
    if given and all(isinstance(value, bool) for value in given):
        return values
    return [None if value is None else float(value) for value in values]


def _parquet(sweep: Sweep, columns: Columns) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    texts = {"run": pa.string(), "error": pa.string(), "warning": pa.string(), "state_hash": pa.string()}
    arrays = {}
    for name, values in columns.items():
        found = pa.array(values, type=texts.get(name))
        arrays[name] = found.cast(pa.float64()) if pa.types.is_null(found.type) else found
    about = {"sweep": sweep.table.model_dump(mode="json", by_alias=True), "scene": sweep.job.scene}
    metadata = {"stiction": json.dumps({"version": __version__, **about})}
    sink = io.BytesIO()
    pq.write_table(pa.table(arrays).replace_schema_metadata(metadata), sink, compression="zstd")
    return sink.getvalue()


def _csv(columns: Columns) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()
