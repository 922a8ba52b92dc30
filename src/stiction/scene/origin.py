"""The text that a scene was read from, for sentences that name the line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from stiction.errors import InvalidFileError, InvalidInputError, NotYetError


class Origin(NamedTuple):
    """A file and its text."""

    file: str
    text: str


@contextmanager
def naming_lines(origin: Origin | None) -> Iterator[None]:
    """Sentences of errors that leave this block begin with file and line, if there is an origin.

    Raises:
        InvalidFileError: in place of an error whose sentence begins with the path of a key.
    """
    try:
        yield
    except InvalidFileError:
        raise
    except (InvalidInputError, NotYetError) as error:
        if origin is None:
            raise
        from stiction.scene.check import place_of

        place = place_of(str(error), origin.text)
        where = f"{origin.file}, line {place.line}" if place else origin.file
        raise InvalidFileError(f"{where}: {error}", file=origin.file, line=place.line if place else None) from None
