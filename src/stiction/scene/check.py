"""Every mistake of a file at once, each with its place in the text.

Whoever reads a file stops at the first thing that is wrong. Here that thing is noted and mended in a copy, which is
then read again, until nothing is wrong any more: what a file may hold is said nowhere twice.
"""

from __future__ import annotations

import copy
import re
import tomllib
import warnings
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from stiction.errors import InvalidInputError, NotYetError, StictionWarning
from stiction.scene.fields import Table
from stiction.scene.load import SyntaxFault, find_syntax_fault, parse
from stiction.scene.mend import MISSING, UNKNOWN, Mender, suggestion_in
from stiction.scene.model import SceneTable
from stiction.scene.positions import Location, Place, Positions, split_path
from stiction.scene.scene import Scene
from stiction.scene.simulation import Simulation
from stiction.scene.validate import path_text, sentences_of

MOST = 200
"""Readings of one file at most."""

Data = dict[str, Any]
Reader = Callable[[Data], list[str]]
"""Gives the sentences of what is wrong with data, each beginning with the path of its key; none if all is well."""


class Finding(NamedTuple):
    """A mistake in a file, or something in it that may not be meant.

    Attributes:
        path: of the key, empty for the whole file.
        text: what is wrong and what is allowed.
        suggestion: what may have been meant.
        place: where it is, if it is anywhere.
        error: a mistake, and not only a warning.
    """

    path: str
    text: str
    suggestion: str | None
    place: Place | None
    error: bool = True

    def as_dict(self) -> dict[str, Any]:
        """The finding as plain data for JSON."""
        return {
            "severity": "error" if self.error else "warning",
            "path": self.path or None,
            "line": self.place.line if self.place else None,
            "column": self.place.column if self.place else None,
            "text": self.text,
            "suggestion": self.suggestion,
        }


class Checked(NamedTuple):
    """What came out of a check.

    Attributes:
        findings: in the order of the file.
        data: the file as plain data, without the lines that are no TOML.
        positions: of what is in it; None if nothing of it could be read.
    """

    findings: list[Finding]
    data: Data
    positions: Positions | None


def check_scene(text: str, file: str) -> list[Finding]:
    """All that is wrong with the text of a scene file, and what may not be meant, in the order of the file.

    Warnings are looked for only where there is no mistake.

    Args:
        text: TOML.
        file: its name, for sentences.
    """
    checked = check(text, file, read_scene)
    if checked.findings or checked.positions is None:
        return checked.findings
    from stiction.scene.doubts import doubts

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StictionWarning)
        simulation = Simulation(Scene.from_dict(checked.data))
    told = doubts(simulation)
    return _in_order(_finding(location, words, checked.positions, error=False) for location, words in told)


def read_scene(data: Data) -> list[str]:
    """What is wrong with a scene: what shows in its keys, or else the first thing that shows when it is built."""
    return faults_of(SceneTable, "the scene", data, lambda: Simulation(Scene.from_dict(data)))


def faults_of(table: type[Table], what: str, data: Data, build: Callable[[], object]) -> list[str]:
    """What is wrong with the keys of a table, or else the first thing that shows when ``build`` makes what it says."""
    found = sentences_of(table, data, what)
    if found:
        return found
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StictionWarning)
        try:
            build()
        except (InvalidInputError, NotYetError) as error:
            return [str(error)]
    return []


def check(text: str, file: str, read: Reader) -> Checked:
    """All mistakes of a text.

    Args:
        text: TOML.
        file: its name, for sentences.
        read: says what is wrong with its data.
    """
    rest, faults = _without_syntax_faults(text)
    syntax = [Finding("", *_explained(fault, text), fault.place) for fault in faults]
    if rest is None:
        return Checked(_in_order(syntax), {}, None)
    data, positions = parse(rest, file), Positions(rest)
    lost = {match[1] for fault in faults if (match := _ASSIGNMENT.match(_line(text, fault.place.line)))}
    mender = Mender(copy.deepcopy(data))
    found: dict[tuple[Location, str], None] = {}
    for _ in range(MOST):
        faults_now = [split_path(sentence, mender.data) for sentence in read(mender.data)]
        before = len(found)
        for here, words in faults_now:
            if mender.is_fallout(here, words) or (words.startswith(MISSING) and here and here[-1] in lost):
                continue
            found.setdefault((_refined(mender.original(here), words, data), words))
        mended = mender.mend(faults_now)
        if not mended and len(found) == before:
            break
    kept = [_finding(location, words, positions) for location, words in found]
    return Checked(_in_order([*syntax, *kept]), data, positions)


def place_of(sentence: str, text: str) -> Place | None:
    """Where in the text of a file the thing is that a sentence is about, if it is anywhere."""
    data = tomllib.loads(text)
    location, words = split_path(sentence, data)
    return _finding(_refined(location, words, data), words, Positions(text)).place if location else None


def _finding(location: Location, words: str, positions: Positions, *, error: bool = True) -> Finding:
    about_key = words.startswith((UNKNOWN, MISSING, "must not be given"))
    place = positions.key(location) if about_key else positions.value(location)
    return Finding(path_text(location), words, suggestion_in(words), place, error)


def _refined(location: Location, words: str, data: Data) -> Location:
    """Of a sentence about a whole table: the key in it that the sentence is about."""
    node: Any = data
    for part in location:
        try:
            node = node[part]
        except (KeyError, IndexError, TypeError):
            return location
    if not isinstance(node, dict):
        return location
    named = [word for word in re.findall(r"[a-z_]+", words) if word in node]
    return (*location, named[0]) if named else location


def _in_order(findings: Iterable[Finding]) -> list[Finding]:
    return sorted(findings, key=lambda one: one.place[:2] if one.place else (0, 0))


# -- syntax -----------------------------------------------------------------------------------------------------------

_ASSIGNMENT = re.compile(r"""\s*([\w-]+)\s*=\s*(.*?)\s*(?:#.*)?$""")
"""A line with a key and a value of its own."""

_HINTS = (
    (r"True|False", "flags are written true and false"),
    (r"[-+]?\d+,\d+", "decimals are written with a point"),
    (r"[A-Za-z_][\w .-]*", 'texts stand in quotes, as in "wood"'),
    (r"['\"][^'\"]*", "the text has no end: a quote is missing"),
    (r"\[[^\]]*", "the list has no end: a ] is missing"),
    (r"\{[^}]*", "the table has no end: a } is missing"),
    (r"[-+]?\d[\d.]*\s*[A-Za-z/^°]+.*", "numbers stand without a unit"),
    (r"[-+]?(\.\d+|\d+\.)", "a point stands between digits, as in 0.5 and 1.0"),
    (r"", "a value is missing"),
)
"""What a wrong value looks like, and what may help."""


def _without_syntax_faults(text: str) -> tuple[str | None, list[SyntaxFault]]:
    """The text with faulty assignments of one line blanked out, and the faults; None where others are in the way."""
    faults: list[SyntaxFault] = []
    lines = text.split("\n")
    while (fault := find_syntax_fault("\n".join(lines))) is not None:
        first, last = fault.place.line - 1, fault.place.line
        if fault.message.startswith("Unclosed"):  # it is told where the text goes on, and is where the bracket stands
            opening = _opening(lines, first)
            first, last = opening, max(first, opening + 1)
            begins = _ASSIGNMENT.match(lines[first])
            fault = fault._replace(place=Place(first + 1, begins.start(2) + 1 if begins else 1, 1))
        faults.append(fault)
        if len(faults) == MOST or first >= len(lines) or not _ASSIGNMENT.match(lines[first]):
            return None, faults
        lines[first:last] = [""] * (last - first)
    return "\n".join(lines), faults


def _opening(lines: list[str], line: int) -> int:
    """The last line up to this one in which a value begins with a bracket that is not closed in it."""
    for number in range(min(line, len(lines) - 1), -1, -1):
        found = _ASSIGNMENT.match(lines[number])
        if found and (found[2].count("[") > found[2].count("]") or found[2].count("{") > found[2].count("}")):
            return number
    return line


def _explained(fault: SyntaxFault, text: str) -> tuple[str, str | None]:
    """What a fault says, and what may help."""
    found = _ASSIGNMENT.match(_line(text, fault.place.line))
    hints = [hint for pattern, hint in _HINTS if found and re.fullmatch(pattern, found[2])]
    return f"TOML syntax error: {fault.message}.", hints[0] if hints else None


def _line(text: str, number: int) -> str:
    lines = text.split("\n")
    return lines[number - 1] if number <= len(lines) else ""
