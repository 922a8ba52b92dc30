"""The folder of a sweep: who is at work in it, and the journals of finished runs.

Every worker appends to a journal of its own: a line when a run starts, a line with the row when it is finished, each in
one write. What a killed process leaves is therefore whole lines and perhaps half a last one, which is passed over.
Nothing is ever changed in place; the table is made from all journals, and replaced in one move.

Two locks keep drivers apart. The driver holds ``driver.lock`` for as long as it lives. Workers share ``workers.lock``
while they are at a batch, and a new driver waits until they have let go of it: workers of a killed driver find, after
the run they are at, that the token in ``session`` is another one, and stop. So no run is ever done twice at a time.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from stiction.errors import OutputError

fcntl: Any = None
"""Windows has no flock: there two drivers in one folder are not kept apart."""
try:
    fcntl = importlib.import_module("fcntl")
except ImportError:
    pass

Row = dict[str, Any]


class Finished(NamedTuple):
    """What the journals of a folder say.

    Attributes:
        rows: id of each finished run to its row; of two rows of a run the later one.
        attempts: id of each run that was started and not finished to how often.
        repeated: rows that were there twice, without an error the first time.
    """

    rows: dict[str, Row]
    attempts: dict[str, int]
    repeated: int


class Folder:
    """The folder of a sweep.

    Args:
        path: of the folder; it need not exist.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.runs = self.path / "runs"
        self._session = self.path / "session"

    def __repr__(self) -> str:
        return f"<Folder {str(self.path)!r}>"

    def make(self) -> None:
        """Make the folder.

        Raises:
            OutputError: it cannot be made.
        """
        try:
            self.runs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                f"--out must be a folder that can be written, got {str(self.path)!r} ({error.strerror or error})."
            ) from error

    def session(self) -> str | None:
        """Token of the driver that works here now or did last; None where the folder cannot be seen."""
        try:
            return self._session.read_text(encoding="ascii")
        except OSError:
            return None

    def begin_session(self) -> str:
        """A new token; workers with an older one stop after the run that they are at."""
        token = f"{time.time_ns():020d}-{os.getpid()}"
        replace(self._session, token.encode("ascii"))
        return token

    def end_session(self) -> None:
        """Ask all workers to stop after the run that they are at."""
        replace(self._session, f"{time.time_ns():020d}-ended".encode("ascii"))

    @contextmanager
    def driving(self) -> Iterator[None]:
        """Within it this process alone is the driver here.

        Raises:
            OutputError: another one is.
        """
        with _lock(self.path / "driver.lock", wait=False, shared=False) as free:
            if not free:
                raise OutputError(f"--out must be a folder in which no other sweep is at work, got {str(self.path)!r}.")
            yield

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Within it this process counts as a worker."""
        with _lock(self.path / "workers.lock", wait=True, shared=True):
            yield

    def wait_for_workers(self, on_wait: Callable[[], None] | None = None) -> None:
        """Until no process is at work here: orphans of a killed driver finish the run that they are at.

        Args:
            on_wait: called first if there are any.
        """
        with _lock(self.path / "workers.lock", wait=False, shared=False) as free:
            if free:
                return
        if on_wait is not None:
            on_wait()
        with _lock(self.path / "workers.lock", wait=True, shared=False):
            pass

    def read(self, since: str = "") -> Finished:
        """All that the journals hold, or those of the session ``since`` and later ones."""
        rows: dict[str, Row] = {}
        attempts: dict[str, int] = {}
        repeated = 0
        for journal in sorted(self.runs.glob("*.jsonl")):
            if journal.name < since:
                continue
            for entry in _entries(journal):
                run = entry["run"]
                if "row" not in entry:
                    attempts[run] = attempts.get(run, 0) + (-1 if "left" in entry else 1)
                    continue
                repeated += run in rows and rows[run]["error"] is None
                rows[run] = entry["row"]
                attempts.pop(run, None)
        return Finished(rows, attempts, repeated)


class JournalWriter:
    """Appends to one worker's journal.

    Args:
        folder: of the sweep.
        session: token of the driver.
        worker: name of the worker.
    """

    def __init__(self, folder: Folder, session: str, worker: str) -> None:
        self.path = folder.runs / f"{session}-{re.sub(r'[^A-Za-z0-9.-]', '_', worker)}.jsonl"
        self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)

    def __enter__(self) -> JournalWriter:
        return self

    def __exit__(self, *_: object) -> None:
        os.fsync(self._file)
        os.close(self._file)

    def started(self, run: str) -> None:
        """Note that a run begins."""
        self._write({"run": run})

    def left(self, run: str) -> None:
        """Note that a run was given up because somebody wanted to stop."""
        self._write({"run": run, "left": True})

    def finished(self, run: str, row: Row) -> None:
        """Keep a finished run."""
        self._write({"run": run, "row": row})

    def _write(self, entry: dict[str, Any]) -> None:
        # The line break comes first: whatever half a line a killed process has left, this one begins anew.
        line = b"\n" + json.dumps(entry).encode() + b"\n"
        while line:
            line = line[os.write(self._file, line) :]


def _entries(journal: Path) -> Iterator[dict[str, Any]]:
    with journal.open("rb") as lines:
        for line in lines:
            if not line.endswith(b"\n") or len(line) < 2:
                continue
            try:
                entry = json.loads(line)
            except ValueError:
                continue  # half a line, left by a process that was killed while it wrote
            yield entry


def replace(path: Path, content: bytes) -> None:
    """Write a file in one move: whoever reads it finds the old content or the new one, never a part."""
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    with partial.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    partial.replace(path)


@contextmanager
def _lock(path: Path, *, wait: bool, shared: bool) -> Iterator[bool]:
    """A lock that ends with the process that holds it, however that ends; False where it is taken."""
    if fcntl is None:
        yield True
        return
    file = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        how = (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB)
        try:
            fcntl.flock(file, how)
        except BlockingIOError:
            yield False
            return
        yield True
    finally:
        os.close(file)
