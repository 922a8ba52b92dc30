"""Finding and reading scene files: the built-in ones by name, others by path."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from stiction.checks import nearest
from stiction.errors import InvalidFileError, InvalidInputError
from stiction.scene.model import SceneTable
from stiction.scene.origin import Origin, naming_lines
from stiction.scene.overrides import apply_overrides
from stiction.scene.positions import Place
from stiction.scene.scene import Scene
from stiction.scene.validate import validate

SUFFIX = ".toml"


def names_in(package: str) -> list[str]:
    """Names of the TOML files that a package ships in its folder ``builtin``, in alphabetical order."""
    folder = resources.files(package).joinpath("builtin")
    return sorted(file.name.removesuffix(SUFFIX) for file in folder.iterdir() if file.name.endswith(SUFFIX))


def text_in(package: str, what: str, name: str) -> str:
    """One of these files, comments included; ``what`` says what it is.

    Raises:
        InvalidInputError: there is none of that name; the nearest one is named.
    """
    known = names_in(package)
    if name not in known:
        raise InvalidInputError(
            f"{what} must be the path of a TOML file or one of {', '.join(known)}, got {name!r}{nearest(name, known)}."
        )
    return resources.files(package).joinpath("builtin", name + SUFFIX).read_text(encoding="utf-8")


def builtin_names() -> list[str]:
    """Names of the built-in scenes in alphabetical order."""
    return names_in("stiction.scene")


def builtin_text(name: str) -> str:
    """The file of a built-in scene, comments included.

    Raises:
        InvalidInputError: there is none of that name; the nearest one is named.
    """
    return text_in("stiction.scene", "scene", name)


def load(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """A built-in scene by its name, or the scene in a file.

    Args:
        name_or_path: what ends in ``.toml`` or contains a slash is a path.
        overrides: changes such as ``world.dt=0.01``, see :func:`stiction.scene.overrides.apply_overrides`.

    Raises:
        InvalidInputError: no such scene, or a file that cannot be read.
        InvalidFileError: a syntax error, or something in a file that is not allowed (with its line and the path of its
            key). :func:`stiction.scene.check.check_scene` tells all of them.

    Warns:
        MaterialWarning: dynamic friction of a pair is above its static friction.
    """
    text = str(name_or_path)
    origin = None
    if is_path(name_or_path):
        origin = Origin(text, read_text(Path(text), "scene file"))
        data = parse(origin.text, text)
        name = Path(text).stem
    else:
        data = parse(builtin_text(text), text + SUFFIX)
        name = text
    with naming_lines(origin):
        table = validate(data)
        if not overrides:
            return Scene(table, name, origin)
    # what an override has made of it is in no line
    return Scene(apply_overrides(table, overrides), name)


def is_path(name_or_path: str | Path) -> bool:
    """Whether this is the path of a TOML file, and not the name of something built in."""
    text = str(name_or_path)
    return isinstance(name_or_path, Path) or text.endswith(SUFFIX) or "/" in text or "\\" in text


def parse(text: str, file: str) -> dict[str, Any]:
    """TOML as plain data; a syntax error names file and line."""
    fault = find_syntax_fault(text)
    if fault is None:
        return tomllib.loads(text)
    line, column, _ = fault.place
    where = "at the end" if fault.at_end else f"column {column}"
    message = f"{file}, line {line}, {where}: TOML syntax error: {fault.message}."
    raise InvalidFileError(message, file=file, line=line)


class SyntaxFault(NamedTuple):
    """What is no TOML in a text: what is wrong, where, and whether only the end of the text showed it."""

    message: str
    place: Place
    at_end: bool


def find_syntax_fault(text: str) -> SyntaxFault | None:
    """The first thing in a text that is no TOML; None if all of it is."""
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        message, line, column = found.groups() if found else (str(error), None, None)
        if line and column:
            return SyntaxFault(message, Place(int(line), int(column), 1), False)
        return SyntaxFault(message, Place(text.count("\n") + 1, len(text) - text.rfind("\n"), 1), True)
    return None


def read_text(path: Path, what: str) -> str:
    """The text of a file; ``what`` is what a sentence calls it, such as ``scene file``."""
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors begin a file with a byte-order mark
    except FileNotFoundError:
        raise InvalidInputError(f"{what} must exist, got {str(path)!r}.") from None
    except UnicodeDecodeError:
        raise InvalidInputError(f"{what} must be TOML text in UTF-8, got {str(path)!r}.") from None
    except OSError as error:
        raise InvalidInputError(f"{what} {str(path)!r} cannot be read: {error.strerror}.") from None


def json_schema() -> dict[str, Any]:
    """The JSON schema of scene files, for editors."""
    schema = SceneTable.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "stiction scene"}
