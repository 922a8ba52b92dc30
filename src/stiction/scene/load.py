"""Finding and reading scene files: the built-in ones by name, others by path."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from stiction.checks import nearest
from stiction.errors import InvalidInputError
from stiction.scene.model import SceneTable
from stiction.scene.overrides import apply_overrides
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
        InvalidInputError: no such scene, a file that cannot be read, a syntax error (with its line), or something in it
            that is not allowed (with the path of its key).

    Warns:
        MaterialWarning: dynamic friction of a pair is above its static friction.
    """
    text = str(name_or_path)
    if is_path(name_or_path):
        data = parse(read_text(Path(text), "scene file"), text)
        name = Path(text).stem
    else:
        data = parse(builtin_text(text), text + SUFFIX)
        name = text
    table = validate(data)
    if overrides:
        table = apply_overrides(table, overrides)
    return Scene(table, name)


def is_path(name_or_path: str | Path) -> bool:
    """Whether this is the path of a TOML file, and not the name of something built in."""
    text = str(name_or_path)
    return isinstance(name_or_path, Path) or text.endswith(SUFFIX) or "/" in text or "\\" in text


def parse(text: str, file: str) -> dict[str, Any]:
    """TOML as plain data; a syntax error names file and line."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        if found is None:
            raise InvalidInputError(f"{file}: TOML syntax error: {error}.") from None
        message, line, column = found.groups()
        where = f"line {line}, column {column}" if line else f"line {text.count(chr(10)) + 1}, at the end"
        raise InvalidInputError(f"{file}, {where}: TOML syntax error: {message}.") from None


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
