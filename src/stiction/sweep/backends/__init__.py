"""Where the batches of a sweep are run: one small protocol, and those who speak it.

A backend is asked for one thing: keep its workers busy with what ``take`` gives, and report each batch once, whether
its worker has answered or died. What is finished, what is put back and when to stop is decided by
:mod:`stiction.sweep.driver`, alike for all of them.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from stiction import checks
from stiction.errors import InvalidInputError, NotYetError
from stiction.sweep.points import Point
from stiction.sweep.runner import Answer

BACKENDS = ("local", "ray", "inline")
"""Processes on this machine; Ray, here or on a cluster; this very process, one run after the other."""

Take = Callable[[], list[Point] | None]


@dataclass(frozen=True)
class Work:
    """What a worker needs to know once.

    Attributes:
        job: a :class:`stiction.sweep.runner.Job` as text.
        folder: of the sweep, an absolute path.
        session: token of the driver.
    """

    job: str
    folder: str
    session: str


@dataclass(frozen=True)
class Report:
    """A batch that a worker is through with.

    Attributes:
        batch: its runs. answer: of the worker, or None if it died. died: how, in a few words.
    """

    batch: list[Point]
    answer: Answer | None
    died: str = ""


class Backend(Protocol):
    """Runs batches.

    Attributes:
        name: for people. workers: how many batches are worked at at a time.
    """

    name: str
    workers: int

    def run(self, work: Work, take: Take) -> Iterator[Report]:
        """Run all batches that ``take`` gives, also those that it gives again after a report, until it gives None and
        none is under way. Closing the iterator stops the workers."""
        ...


def check(name: str, workers: int | None = None, address: str | None = None) -> None:
    """Whether :func:`make` can be called with these: before the work, and without starting anything.

    Raises:
        InvalidInputError: no such name, a number below 1, an address without Ray.
        NotYetError: Ray is not installed.
    """
    checks.one_of("--backend", name, BACKENDS)
    if address is not None and name != "ray":
        raise InvalidInputError(f"--address goes with --backend ray, got {address!r} with {name!r}.")
    if workers is not None:
        checks.integer("--workers", workers, minimum=1)
    if name == "ray" and importlib.util.find_spec("ray") is None:
        raise NotYetError("--backend ray needs Ray: pip install 'stiction[ray]'.")


def make(name: str, workers: int | None = None, address: str | None = None) -> Backend:
    """The backend of that name.

    Args:
        name: one of :data:`BACKENDS`.
        workers: how many; all cores of the machine (or of the cluster) if left out.
        address: of a Ray cluster; a Ray on this machine if left out.

    Raises:
        InvalidInputError, NotYetError: see :func:`check`.
    """
    from stiction.sweep.backends.local import InlineBackend, LocalBackend

    check(name, workers, address)
    if name == "ray":
        from stiction.sweep.backends.ray import RayBackend

        return RayBackend(workers, address)
    return InlineBackend() if name == "inline" else LocalBackend(workers)
