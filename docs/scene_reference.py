"""The tables of scene-reference.md, out of the JSON schema of scene files: every table, every key, its default."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stiction.scene import json_schema

TARGET = Path(__file__).resolve().parent / "_build" / "scene-reference.md"
TABLES = {
    "SceneTable": "(top of the file)",
    "WorldTable": "[world]",
    "MaterialsTable": "[materials]",
    "PairTable": "[[materials.pairs]]",
    "FrameTable": "[frames.NAME]",
    "Rotation": "rotation = { ... }",
    "BodyTable": "[[bodies]]",
    "BoxTable": 'shape = { type = "box", ... }',
    "SphereTable": 'shape = { type = "sphere", ... }',
    "PlaneTable": 'shape = { type = "plane", ... }',
    "CapsuleTable": 'shape = { type = "capsule", ... }',
    "CylinderTable": 'shape = { type = "cylinder", ... }',
    "EllipsoidTable": 'shape = { type = "ellipsoid", ... }',
    "HullTable": 'shape = { type = "hull", ... }',
    "GridTable": "grid = { ... }",
    "PushTable": "[[pushes]]",
    "SpringTable": "[[springs]]",
    "VelocityChangeTable": "[[velocity_changes]]",
    "VehicleTable": "[[vehicles]]",
    "ControlTable": "[[vehicles.controls]]",
}
"""What each table is called in a file, in the order of the page."""
PLAIN = {"number": "number", "integer": "whole number", "string": "text", "boolean": "`true` or `false`"}


def write() -> None:
    """Write the tables, if they are not there as they are now."""
    text = page(json_schema())
    if not TARGET.exists() or TARGET.read_text(encoding="utf-8") != text:
        TARGET.parent.mkdir(exist_ok=True)
        TARGET.write_text(text, encoding="utf-8")


def page(schema: dict[str, Any]) -> str:
    """All tables as Markdown.

    Raises:
        SystemExit: the schema has a table that this module has no heading for, or lacks one.
    """
    tables = {"SceneTable": schema, **schema["$defs"]}
    if set(tables) != set(TABLES):
        raise SystemExit(
            f"docs/scene_reference.py must name the tables of a scene; differs in {set(tables) ^ set(TABLES)}."
        )
    return "\n".join(line for name in TABLES for line in _table(name, tables))


def _table(name: str, tables: dict[str, Any]) -> list[str]:
    table = tables[name]
    lines = [f"({_anchor(name)})=", f"## `{TABLES[name]}`", "", table["description"], ""]
    lines += ["| key | value | if left out | |", "| --- | --- | --- | --- |"]
    needed = table.get("required", [])
    for key, entry in table["properties"].items():
        default = "*needed*" if key in needed else _default(entry)
        text = entry.get("description", "")
        if not text and "$ref" in entry:
            text = tables[entry["$ref"].rsplit("/", 1)[1]]["description"]
        text = text.replace("|", "\\|").replace("\n", " ")
        lines.append(f"| `{key}` | {_kind(entry)} | {default} | {text} |")
    return [*lines, ""]


def _anchor(name: str) -> str:
    return f"scene-{name.removesuffix('Table').lower()}"


def _default(entry: dict[str, Any]) -> str:
    value = entry.get("default")
    if value is None or value in ([], {}):
        return "–"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, float):
        return f"`{value:.6g}`"
    if isinstance(value, list):
        return f"`[{', '.join(f'{x:g}' for x in value)}]`"
    if isinstance(value, dict):
        return "its own defaults"
    return f"`{value}`"


def _kind(entry: dict[str, Any]) -> str:
    """What a key may hold, in words."""
    for choice in ("anyOf", "oneOf"):
        if choice in entry:
            kinds = [_kind(one) for one in entry[choice] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(kinds))
    if "$ref" in entry:
        name = entry["$ref"].rsplit("/", 1)[1]
        _, shape, _ = TABLES[name].split('"') if '"' in TABLES[name] else ("", "table", "")
        return f"[{shape}](#{_anchor(name)})"
    if "const" in entry:
        return f'`"{entry["const"]}"`'
    if "enum" in entry:
        return ", ".join(f'`"{word}"`' for word in entry["enum"])
    if entry.get("type") == "array":
        if "prefixItems" in entry:
            first, count = entry["prefixItems"][0], len(entry["prefixItems"])
            return f"{count} times {_kind(first)}" if first["type"] == "array" else f"{count} {PLAIN[first['type']]}s"
        items = entry.get("items", {})
        return (
            "list of tables"
            if "$ref" not in items
            else f"list of [tables](#{_anchor(items['$ref'].rsplit('/', 1)[1])})"
        )
    if entry.get("type") == "object":
        inside = entry.get("additionalProperties")
        if isinstance(inside, dict) and "$ref" in inside:
            return f"[tables](#{_anchor(inside['$ref'].rsplit('/', 1)[1])}) by name"
        return "table"
    return PLAIN[entry["type"]] + _range(entry)


def _range(entry: dict[str, Any]) -> str:
    """The bounds of a number."""
    low, high = entry.get("minimum"), entry.get("maximum")
    if "exclusiveMinimum" in entry:
        return f" above {entry['exclusiveMinimum']:g}"
    if low is not None and high is not None:
        return f", {low:g} to {high:g}"
    return f", {low:g} or more" if low is not None else ""
