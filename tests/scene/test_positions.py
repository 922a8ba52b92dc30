"""Places of keys and values in a TOML text."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stiction.scene import builtin_names, builtin_text
from stiction.scene.positions import Location, Positions, split_path

HARD = '''
a."b c".'d' = 1   # a "comment" = [
"é\\u00e9" = """text ["
] = 3 \\""" """
s = \'\'\'
x = 1\'\'\'
list = [ 1, [2, 3], # one, two
  { x = 1, y.z = "]" }, "#",
]
date = 1979-05-27T07:32:00Z
[t.u]
k = 0x1F
[[t.rows]]
k = inf
[t.rows.inner]
k = true
[[t.rows]]
[[t.rows.deep]]
k = "second row"
[[t.rows.deep]]
k = {}
'''


def paths(node: Any, here: Location = ()) -> Iterator[Location]:
    """All paths in plain data."""
    entries = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in entries:
        yield (*here, key)
        yield from paths(value, (*here, key))


def at(data: Any, location: Location) -> Any:
    for part in location:
        data = data[part]
    return data


def check(text: str) -> None:
    """Every path is found, and what stands at the place of a value is that value."""
    data, positions = tomllib.loads(text), Positions(text)
    lines = text.split("\n")
    for location in paths(data):
        assert location in positions, location
        value, place = at(data, location), positions.value(location)
        assert place is not None
        shown = lines[place.line - 1][place.column - 1 :][: place.length]
        if isinstance(value, (bool, int, float)) and not shown.startswith("["):
            assert tomllib.loads(f"x = {shown}")["x"] == pytest.approx(value), location
        key = positions.key(location)
        assert key is not None
        if isinstance(location[-1], str) and location[-1].isascii():
            assert location[-1] in lines[key.line - 1], location


@pytest.mark.parametrize("name", builtin_names())
def test_everything_in_a_built_in_scene_is_found(name: str) -> None:
    check(builtin_text(name))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_everything_in_a_hard_text_is_found(end: str) -> None:
    check(HARD.replace("\n", end))


def test_lines_and_columns_are_right() -> None:
    positions = Positions("a = 1\n[b]\n  c = [1, 2.5]\n")
    assert positions.key(("b", "c")) == (3, 3, 1)
    assert positions.value(("b", "c")) == (3, 7, 8)
    assert positions.value(("b", "c", 1)) == (3, 11, 3)
    assert positions.value(("b",)) == (2, 1, 3)
    assert positions.key(("b", "missing")) == (2, 1, 3), "the nearest thing around it"
    assert positions.key(("nowhere",)) is None


KEYS = st.text("ab-_é \"'.\\#=[", min_size=1, max_size=4)
VALUES = st.recursive(
    st.integers(-99, 99) | st.booleans() | st.text("a\"'\\#[]{}=,\n", max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=6,
)


def written(value: Any) -> str:
    """As inline TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{quoted(key)} = {written(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ",\n ".join(map(written, value)) + "]"
    return quoted(value) if isinstance(value, str) else str(value).lower()


def quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


@given(st.dictionaries(KEYS, VALUES, max_size=4))
def test_everything_in_any_text_is_found(data: dict[str, Any]) -> None:
    text = "".join(f"{quoted(key)} = {written(value)} # [\n" for key, value in data.items())
    assert tomllib.loads(text) == data
    positions = Positions(text)
    assert all(location in positions for location in paths(data))


@pytest.mark.parametrize(
    ("sentence", "location", "rest"),
    [
        ("bodies[1].shape.size: must be given.", ("bodies", 1, "shape", "size"), "must be given."),
        ("frames.a.b: must be a name.", ("frames", "a.b"), "must be a name."),
        ("bodies[0]: a Plane: no.", ("bodies", 0), "a Plane: no."),
        ("bodies[7].x: no.", ("bodies", 7, "x"), "no."),
        ("odd key: no.", ("odd key",), "no."),
        ("the scene must be a table.", (), "the scene must be a table."),
        ("other.toml, line 3: no.", (), "other.toml, line 3: no."),
    ],
)
def test_a_sentence_is_split_at_the_end_of_its_path(sentence: str, location: Location, rest: str) -> None:
    data = {"bodies": [{}, {"shape": {"size": 1}}], "frames": {"a.b": {}, "a": {}}, "odd key": 1}
    assert split_path(sentence, data) == (location, rest)
