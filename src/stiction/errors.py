"""Everything stiction raises or warns with: one sentence with the parameter, its value and what is allowed."""

from __future__ import annotations

from typing import Any


class StictionError(Exception):
    """Base class of every error that stiction raises on purpose."""


class InvalidInputError(StictionError, ValueError):
    """A value at the public face is not allowed. Nothing has been changed."""


class InvalidFileError(InvalidInputError):
    """Something in a file that a user wrote is not allowed.

    Attributes:
        file: its name.
        line: where it is, from 1; None if it is nowhere in particular.
    """

    def __init__(self, message: str, *, file: str, line: int | None) -> None:
        super().__init__(message)
        self.file = file
        self.line = line


class NotYetError(StictionError, NotImplementedError):
    """A documented feature that this version does not have."""


class OutputError(StictionError, OSError):
    """A file or folder cannot be written. Raised before the work starts, not after it."""


class SimulationError(StictionError, RuntimeError):
    """A world blew up: a body's state is no longer finite.

    Attributes:
        step: number of the step that failed, counted from the world's first one.
        body: name of the first body that is no longer finite.
        state: last finite state of that body: ``position``, ``orientation``, ``velocity``, ``angular_velocity``.
            The world itself is back at that state.
    """

    def __init__(self, message: str, *, step: int, body: str, state: dict[str, Any]) -> None:
        super().__init__(message)
        self.step = step
        self.body = body
        self.state = state


class StictionWarning(UserWarning):
    """Base class of every warning that stiction gives."""


class MaterialWarning(StictionWarning):
    """A material pair that is legal but unphysical, such as dynamic above static friction."""


class IterationLimitWarning(StictionWarning):
    """A solver stopped at its iteration limit with contacts left to resolve."""
