"""Where in its text a TOML file says what: a line and a column for the path of every key and value.

``tomllib`` keeps no positions. A file that it has read is known to be right, so finding the places again takes no more
than this: headers, keys, and where values begin and end.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

Location = tuple[str | int, ...]

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_KEY = re.compile(r""""(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[A-Za-z0-9_-]+""")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}(?!")|' + r"'''.*?'{3,5}(?!')|" + r""""(?:[^"\\\n]|\\.)*"|'[^'\n]*'""", re.DOTALL
)
_BARE = re.compile(r"[^,\]}#\n]+")


class Place(NamedTuple):
    """A piece of a text.

    Attributes:
        line, column: where it begins, from 1.
        length: of what is in that line.
    """

    line: int
    column: int
    length: int


class Positions:
    """The places of all keys and values of a TOML text.

    Args:
        text: valid TOML.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._keys: dict[Location, tuple[int, int]] = {}
        self._values: dict[Location, tuple[int, int]] = {}
        self._counts: dict[Location, int] = {}
        self._at = 0
        table: Location = ()
        while self._skip(_BLANK) < len(text):
            if text[self._at] == "[":
                table = self._header()
            else:
                self._assignment(table)

    def key(self, location: Sequence[str | int]) -> Place | None:
        """The place of a key, of the nearest one around it that the text has, or None if it has none of them."""
        return self._find(location, self._keys, self._values)

    def value(self, location: Sequence[str | int]) -> Place | None:
        """The place of a value; of its table's header, or of the nearest thing around it, where there is none."""
        return self._find(location, self._values, self._keys)

    def __contains__(self, location: object) -> bool:
        return location in self._keys or location in self._values

    def _find(self, location: Sequence[str | int], *books: dict[Location, tuple[int, int]]) -> Place | None:
        for length in range(len(location), 0, -1):
            for book in books:
                span = book.get(tuple(location[:length]))
                if span is not None:
                    return self._place(*span)
        return None

    def _place(self, begin: int, end: int) -> Place:
        start = self.text.rfind("\n", 0, begin) + 1
        stop = self.text.find("\n", begin)
        stop = len(self.text) if stop < 0 else stop
        return Place(self.text.count("\n", 0, begin) + 1, begin - start + 1, max(1, min(end, stop) - begin))

    # -- reading ------------------------------------------------------------------------------------------------------

    def _skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self.text, self._at)
        self._at = found.end() if found else self._at
        return self._at

    def _header(self) -> Location:
        begin, array = self._at, self.text.startswith("[[", self._at)
        self._at += 2 if array else 1
        parts = [part for part, _, _ in self._dotted()]
        self._at += 2 if array else 1
        here: Location = ()
        for number, part in enumerate(parts):
            here = (*here, part)
            last = number == len(parts) - 1
            if array and last:
                self._counts[here] = self._counts.get(here, 0) + 1
            self._keys.setdefault(here, (begin, self._at))
            if here in self._counts:  # of a list of tables, the one that came last
                here = (*here, self._counts[here] - 1)
                self._keys.setdefault(here, (begin, self._at))
        self._keys[here] = (begin, self._at)
        return here

    def _assignment(self, table: Location) -> None:
        parts = self._dotted()
        here, begin = table, parts[0][1]
        for part, _, end in parts:
            here = (*here, part)
            self._keys.setdefault(here, (begin, end))
        self._skip(_SPACE)
        self._at += 1  # the equals sign
        self._skip(_SPACE)
        self._value(here)

    def _dotted(self) -> list[tuple[str, int, int]]:
        """The parts of a key with their places; reading stands behind it."""
        parts: list[tuple[str, int, int]] = []
        while True:
            begin = self._skip(_SPACE)
            end = self._skip(_KEY)
            parts.append((_plain(self.text[begin:end]), begin, end))
            self._skip(_SPACE)
            if not self.text.startswith(".", self._at):
                return parts
            self._at += 1

    def _value(self, here: Location) -> None:
        begin = self._at
        first = self.text[begin]
        if first in "\"'":
            self._skip(_STRING)
        elif first in "[{":
            self._at += 1
            self._list(here) if first == "[" else self._inline(here)
            self._at += 1  # the bracket
        else:
            found = _BARE.match(self.text, begin)
            self._at = begin + len(found[0].rstrip()) if found else begin + 1
        self._values[here] = (begin, self._at)

    def _list(self, here: Location) -> None:
        number = 0
        while self.text[self._skip(_BLANK)] != "]":
            self._value((*here, number))
            number += 1
            if self.text[self._skip(_BLANK)] == ",":
                self._at += 1

    def _inline(self, here: Location) -> None:
        while self.text[self._skip(_BLANK)] != "}":
            self._assignment(here)
            if self.text[self._skip(_BLANK)] == ",":
                self._at += 1


def _plain(key: str) -> str:
    """A key without its quotes."""
    if key.startswith("'"):
        return key[1:-1]
    if key.startswith('"'):
        import tomllib

        return next(iter(tomllib.loads(f"{key} = 0")))
    return key


def split_path(sentence: str, data: Any) -> tuple[Location, str]:
    """The path with which a sentence begins, and the rest of it: ``bodies[3].shape.size: must be …``.

    Args:
        sentence: as :mod:`stiction.scene.validate` and all that builds a scene make them.
        data: what it is about; a key may hold any character, so the path is found by the keys there are.

    Returns:
        The path as keys and numbers, empty if the sentence begins with none, and what it says.
    """
    location: list[str | int] = []
    node, rest = data, sentence
    while not (location and rest.startswith(": ")):
        number = re.match(r"\[(\d+)\]", rest) if location else None
        if number:
            location.append(int(number[1]))
            known = isinstance(node, list) and int(number[1]) < len(node)
            node, rest = node[int(number[1])] if known else None, rest[number.end() :]
            continue
        if location and not rest.startswith("."):
            return (), sentence
        rest = rest.removeprefix(".") if location else rest
        keys = sorted((key for key in node if isinstance(key, str)), key=len) if isinstance(node, dict) else []
        fitting = [key for key in keys if rest.startswith(key) and rest[len(key) :].startswith((".", "[", ": "))]
        guess = re.match(r"[A-Za-z_]\w*(?=[.\[]|: )", rest)
        if not fitting and guess is None:
            return (), sentence
        key = fitting[-1] if fitting else guess[0] if guess else ""
        location.append(key)
        node, rest = node.get(key) if isinstance(node, dict) else None, rest[len(key) :]
    return tuple(location), rest[2:]
