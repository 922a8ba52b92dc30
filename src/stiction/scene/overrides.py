"""Overrides: ``path=value`` changes one value of a scene without touching its file.

A path goes through the tables of the file by key: ``world.dt``, ``frames.ramp.rotation.angle_deg``. In the list of
bodies it goes by name or by number, ``bodies.crate.velocity`` or ``bodies[0].velocity``; in the other lists by number;
in a vector by number, ``bodies.crate.velocity[0]``; among the pairs of materials by the two names,
``materials.pairs.wood-ice.static``, also for a pair that only the base table has.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from stiction.checks import nearest
from stiction.errors import InvalidInputError
from stiction.scene.model import PairTable, SceneTable
from stiction.scene.references import BASES
from stiction.scene.validate import validate

Data = dict[str, Any]
Key = str | int

# Where one of these is set, the others no longer hold: only one of them may be given.
ALTERNATIVES: tuple[tuple[str, ...], ...] = (("mass", "density"), ("orientation", "rotation"))


def apply_overrides(table: SceneTable, overrides: Sequence[str]) -> SceneTable:
    """The table with all changes made, in their order.

    Args:
        table: a checked scene.
        overrides: each ``path=value``; the value is read as TOML, and as a bare text if it is none.

    Raises:
        InvalidInputError: an override has no ``=``, its path leads nowhere (the nearest known key is named), or its
            value is not allowed.
    """
    for override in overrides:
        path, equals, text = override.partition("=")
        path = path.strip()
        if not equals or not path:
            raise InvalidInputError(f"override must be path=value, such as world.dt=0.01, got {override!r}.")
        # All keys written out, so that a path finds those that the file leaves out; the pairs are needed by name.
        data = table.model_dump(mode="json", by_alias=True)
        _set(data, path, _value(text.strip()), table)
        table = validate(data)
    return table


def apply_values(table: SceneTable, values: Mapping[str, Any]) -> SceneTable:
    """The table with values at their paths, checked once when all are in.

    Args:
        table: a checked scene.
        values: path to value, as a file would hold it.

    Raises:
        InvalidInputError: a path leads nowhere (the nearest known key is named), or a value is not allowed.
    """
    if not values:
        return table
    data = table.model_dump(mode="json", by_alias=True)
    for path, value in values.items():
        _set(data, path, value, table)
    return validate(data)


def value_at(table: SceneTable, path: str) -> Any:
    """What a scene has at a path; None where it leaves the key out.

    Args:
        table: a checked scene.
        path: as in an override.

    Raises:
        InvalidInputError: the path leads nowhere (the nearest known key is named).
    """
    node: Any = table.model_dump(mode="json", by_alias=True)
    parts = _parts(path)
    for depth, part in enumerate(parts):
        node = node[_find(node, part, _join(parts[:depth]), path, table)]
    return node


def _value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return parsed["value"] if len(parsed) == 1 else text


def _set(data: Data, path: str, value: Any, table: SceneTable) -> None:
    parts = _parts(path)
    node: Any = data
    for depth, part in enumerate(parts):
        here = _join(parts[:depth])
        last = depth == len(parts) - 1
        key = _find(node, part, here, path, table)
        if last:
            node[key] = value
            for group in ALTERNATIVES:
                if key in group:
                    node.update({other: None for other in group if other != key and other in node})
        else:
            node = node[key]


def _parts(path: str) -> list[Key]:
    """``bodies[0].velocity`` as ["bodies", 0, "velocity"]."""
    parts: list[Key] = []
    for piece in path.split("."):
        found = re.fullmatch(r"([^\[\]]+)((?:\[\d+\])*)", piece)
        if found is None:
            raise InvalidInputError(f"override path must be like bodies.crate.velocity[0], got {path!r}.")
        parts.append(found[1].strip())
        parts.extend(int(number) for number in re.findall(r"\d+", found[2]))
    return parts


def _join(parts: Sequence[Key]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).removeprefix(".")


def _find(node: Any, part: Key, here: str, path: str, table: SceneTable) -> Key:
    """The key or number in ``node`` that a part of the path means."""
    if node is None:
        raise InvalidInputError(f"override {path!r}: {here} has no value in this scene, so set it as a whole.")
    if isinstance(node, dict):
        if isinstance(part, str) and part in node:
            return part
        raise _unknown(path, part, here, list(node))
    if not isinstance(node, list):
        raise InvalidInputError(f"override {path!r}: {here} is a single value and has nothing in it.")
    if isinstance(part, int):
        if part < len(node):
            return part
        there_is = f"entries 0 to {len(node) - 1}, not {part}" if node else "no entries"
        raise InvalidInputError(f"override {path!r}: {here} has {there_is}.")
    if here == "materials.pairs":
        return _find_pair(node, part, path, table)
    names = {entry["name"]: number for number, entry in enumerate(node) if isinstance(entry, dict) and "name" in entry}
    if part in names:
        return names[part]
    if not names:
        raise InvalidInputError(f"override {path!r}: the entries of {here} have numbers, such as {here}[0].")
    raise _unknown(path, part, here, list(names))


def _unknown(path: str, part: Key, here: str, known: list[str]) -> InvalidInputError:
    hint = nearest(part, known) or f"; known are {', '.join(known)}"
    return InvalidInputError(f"override {path!r}: {part!r} is not known in {here or 'a scene'}{hint}.")


def _find_pair(rows: list[Data], part: str, path: str, table: SceneTable) -> int:
    """The row of a pair of materials; a pair that only the base table has gets a row of its own."""
    base = BASES[table.materials.base]()
    for row in rows:
        base.add_material(row["a"])
        base.add_material(row["b"])
    splits = [(part[:k].strip(), part[k + 1 :].strip()) for k, character in enumerate(part) if character == "-"]
    for a, b in splits:
        for number, row in enumerate(rows):
            if {row["a"], row["b"]} == {a, b}:
                return number
    for a, b in splits:
        if a in base and b in base:
            rows.append(dict.fromkeys(PairTable.keys()) | {"a": a, "b": b})
            return len(rows) - 1
    pairs = [(row["a"], row["b"]) for row in rows] + [(a, b) for a, b, _ in base.pairs()]
    raise _unknown(path, part, "materials.pairs", [name for a, b in pairs for name in (f"{a}-{b}", f"{b}-{a}")])
