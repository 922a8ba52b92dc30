"""Journals: who wants to know of every step of a world, and of everything that changes it from outside."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.body import Body
    from stiction.record.writer import RecordingWriter
    from stiction.store import StepFailure

Array = NDArray[np.float64]
Step = Callable[[int, Any, Any], "StepFailure | None"]


class Journal(Protocol):
    """What a world calls while it has a journal. Each call about a change comes before it, but for :meth:`added`."""

    def catch_up(self) -> None:
        """Something is about to change."""

    def wrote(self, index: int, column: str, value: Array) -> None:
        """Numbers of body ``index`` are about to be set, from that column of its row on."""

    def wrote_kind(self, index: int, column: str, value: int) -> None:
        """A whole number of body ``index`` is about to be set."""

    def added(self, body: Body) -> None:
        """A body was added."""

    def removing(self, indices: Sequence[int]) -> None:
        """Bodies are about to be removed."""

    def gravity(self, value: Array) -> None:
        """Gravity is about to be set, (3,) m/s^2."""

    def entered_friction(self, index: int, lost: float) -> None:
        """Forces from outside were friction: J that the ledger is about to enter for body ``index``."""

    def follow(self, step: Step, steps: int, settings: Any, table: Any) -> StepFailure | None:
        """Take steps with ``step``, and note each of them."""


class Journaled:
    """The part of :class:`stiction.World` that has a journal."""

    _journal: Journal | None = None

    def _must_not_be_recorded(self, what: str) -> None:
        if self._journal is not None:
            raise InvalidInputError(f"{what} must not change while the world is being recorded: a recording has one.")

    def record(
        self, path: str | Path, *, every: int | None = None, contacts: bool = False, precision: str = "display",
        title: str | None = None, meta: dict[str, Any] | None = None,
    ) -> RecordingWriter:  # fmt: skip
        """Record every step from now on into a file, until the recording is closed: a context manager.

        All that changes the world through its public face is recorded too, so that ``stiction replay FILE --check``
        can run the engine again. Open it with :meth:`stiction.Recording.open`, even while it is written.

        Args:
            path: of the HDF5 file. An older recording there is replaced, a file of any other kind is not.
            every: steps from one frame to the next; 30 frames a second if left out. A hash is kept of every step.
            contacts: keep contact points and what bodies are doing in every frame, too, which costs more than the rest.
            precision: of frames: ``"display"``, or ``"full"`` for float64. Replaying is exact with both.
            title: a few words.
            meta: more to keep, such as seeds; plain values.

        Raises:
            InvalidInputError: a value is not allowed, or the world is being recorded already.
            OutputError: the file cannot be written.

        Example:
            >>> import stiction as st
            >>> world = st.World()
            >>> ball = world.add(st.Sphere(0.5), position=(0, 0, 3))
            >>> with world.record("ball.h5"):
            ...     world.run(1.0)
            >>> with st.Recording.open("ball.h5") as recording:
            ...     recording.check().same
            True
        """
        from stiction.record.writer import RecordingWriter

        return RecordingWriter(
            path, self, every, contacts, precision=precision, title=title, meta=meta  # type: ignore[arg-type]  # a World
        )  # fmt: skip
