"""The reference of scene files in the documentation has every table and every key of the schema."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from stiction.scene import json_schema

MODULE = runpy.run_path(str(Path(__file__).parents[1] / "docs" / "scene_reference.py"))


def test_every_key_has_a_row() -> None:
    text = MODULE["page"](json_schema())
    schema = json_schema()
    tables = [schema, *schema["$defs"].values()]
    for table in tables:
        for key in table["properties"]:
            assert f"| `{key}` | " in text
    assert text.count("\n## ") + text.startswith("## ") == len(tables)
    assert "| `dt` | number above 0 | `0.0166667` |" in text


def test_a_table_that_nobody_has_placed_is_told() -> None:
    schema = json_schema()
    schema["$defs"]["NewTable"] = {"properties": {}, "description": ""}
    with pytest.raises(SystemExit, match="NewTable"):
        MODULE["page"](schema)
