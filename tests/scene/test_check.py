"""Checking files: every mistake, each once, in its line; and what may not be meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiction.errors import InvalidFileError
from stiction.scene import Simulation, builtin_names, builtin_text, load
from stiction.scene.check import check_scene
from stiction.sweep.check import check_sweep, is_sweep

from .test_format import CRATE, FLOOR, HEAD, REFUSED


def lines(text: str) -> list[tuple[int | None, str]]:
    """Line and path of every mistake."""
    return [(one.place.line if one.place else None, one.path) for one in check_scene(text, "x.toml") if one.error]


def warned(text: str) -> list[tuple[str, str]]:
    found = check_scene(text, "x.toml")
    assert not any(one.error for one in found), found
    return [(one.path, one.text) for one in found]


MANY = """title = "A crate"
expct = "It stays."
duration = -2
[world]
gravty = [0, 0, -9.81]
solver = "sofd"
[materials]
base = "lectur"
[[materials.pairs]]
a = "wood"
b = "ice"
statc = 0.3
dynamic = -1
[frames.slope]
rotation = { axis = [0, 1, 0], angle = 20 }
[[bodies]]
name = "floor"
shape = { type = "plain" }
static = true
[[bodies]]
name = "crate"
shape = { type = "box", sise = [1, 1, 0] }
material = wood
mass = 1,5
frame = "slpe"
[[bodies]]
name = "crate"
shape = { type = "sphere" }
mass = 2
density = 3
material = "woood"
[[pushes]]
body = "crat"
force = [1, 0]
[[pushes]]
force = [1, 0, 0]
body = "crate"
frm = 3
until = 1
[[pushes]]
body = "floor"
force = [1, 0, 0]
"""


@pytest.mark.parametrize(("word", "key"), [("friction", "static"), ("frction", "static"), ("mu_k", "dynamic")])
def test_words_that_others_use_are_understood(word: str, key: str) -> None:
    text = f'{HEAD}[[materials.pairs]]\na = "wood"\nb = "ice"\n{word} = 0.1\n'
    (found,) = [one for one in check_scene(text, "x.toml") if one.error]
    assert found.suggestion == key


def test_every_mistake_is_told_once_in_its_line() -> None:
    assert lines(MANY) == [
        (2, "expct"), (3, "duration"), (5, "world.gravty"), (6, "world.solver"), (8, "materials.base"),
        (12, "materials.pairs[0].statc"), (13, "materials.pairs[0].dynamic"), (15, "frames.slope.rotation.angle"),
        (18, "bodies[0].shape.type"), (22, "bodies[1].shape.sise"), (22, "bodies[1].shape.sise"), (23, ""), (24, ""),
        (25, "bodies[1].frame"), (27, "bodies[2].name"), (28, "bodies[2].shape.radius"), (30, "bodies[2].density"),
        (31, "bodies[2].material"), (33, "pushes[0].body"), (34, "pushes[0].force"), (38, "pushes[1].frm"),
        (39, "pushes[1].until"), (41, "pushes[2].body"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("path", "suggestion"),
    [
        ("expct", "expect"), ("world.gravty", "gravity"), ("world.solver", "soft"), ("materials.base", "lecture"),
        ("frames.slope.rotation.angle", "angle_deg"), ("bodies[0].shape.type", "plane"), ("bodies[1].frame", "slope"),
        ("bodies[2].material", "wood"), ("pushes[0].body", "crate"), ("pushes[1].frm", "from"),
    ],
)  # fmt: skip
def test_what_may_be_meant_is_suggested(path: str, suggestion: str) -> None:
    assert suggestion in [one.suggestion for one in check_scene(MANY, "x.toml") if one.path == path]


@pytest.mark.parametrize("case", REFUSED)
def test_what_load_refuses_is_a_mistake_and_mostly_the_only_one(case: str, tmp_path: Path) -> None:
    """A file with one mistake: the same sentence, in the line that load names, and no follow-up of it."""
    text, _ = REFUSED[case]
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidFileError) as caught:
        Simulation(load(file))
    found = [one for one in check_scene(text, str(file)) if one.error]
    assert len(found) == 1, found
    (one,) = found
    assert str(caught.value).endswith(one.text)
    assert (one.place.line if one.place else None) == caught.value.line


@pytest.mark.parametrize("name", builtin_names())
def test_a_built_in_scene_has_no_mistakes(name: str) -> None:
    found = check_scene(builtin_text(name), name)
    assert [one for one in found if one.error] == []
    assert len(found) <= 1


def test_a_text_that_is_no_toml_at_all() -> None:
    found = check_scene(HEAD + "[world\ndt = -1\n", "x.toml")
    assert [(one.place.line if one.place else None, one.text[:17]) for one in found] == [(4, "TOML syntax error")]
    assert lines('x = "') == [(None, "title"), (None, "expect"), (None, "duration"), (1, "")]


@pytest.mark.parametrize(
    ("value", "hint"),
    [
        ("True", "true and false"),
        ("0,5", "decimals"),
        ("wood", "quotes"),
        ('"wood', "a quote is missing"),
        ("[1, 2", "a ] is missing"),
        ("9.81 m", "without a unit"),
        (".5", "between digits"),
        ("", "a value is missing"),
    ],
)
def test_a_wrong_value_has_a_hint(value: str, hint: str) -> None:
    (found,) = check_scene(f"{HEAD}x = {value}\n", "x.toml")
    assert found.place is not None and found.place.line == 4
    assert found.suggestion is not None and hint in found.suggestion


@pytest.mark.parametrize("value", ["[1, 2, 3", "{ a = 1", "[\n1,\n2"])
def test_a_bracket_that_is_not_closed_is_found_where_it_opens(value: str) -> None:
    text = f"{HEAD}x = {value}\n[world]\ndt = -1\n"
    assert (4, "") in lines(text)
    assert (6 + value.count("\n"), "world.dt") in lines(text)


def test_no_mistake_follows_from_a_line_that_cannot_be_read() -> None:
    text = HEAD + '[[bodies]]\nname = "a"\nshape = { type = "box", size = [1, 1, 1 }\n' + CRATE
    assert lines(text) == [(6, "")]


def test_mistakes_that_only_show_when_a_world_is_built_are_all_told() -> None:
    text = HEAD + FLOOR.replace("true", "false") + CRATE + "static = true\nvelocity = [1, 0, 0]\n"
    text += '[[bodies]]\nname = "b"\nshape = {type = "sphere", radius = 1}\ncenter_of_mass = [0, 0, 0.1]\n'
    text += '[[springs]]\nbody = "b"\nstiffness = 1e12\nanchor = [0, 0, 0]\n'
    assert lines(text) == [
        (7, "bodies[0].static"), (12, "bodies[1].velocity"), (16, "bodies[2].center_of_mass"),
        (19, "springs[0].stiffness"),
    ]  # fmt: skip


STANDING = CRATE + "position = [0, 0, 0.5]\n"


def test_a_crate_that_stands_on_a_floor_is_no_cause_for_warnings() -> None:
    assert warned(HEAD + FLOOR + STANDING) == []


@pytest.mark.parametrize(
    ("text", "path", "words"),
    [
        (HEAD + FLOOR + STANDING.replace("0.5", "0.2"), "bodies[1].position", "'crate' 0.3 m deep into 'floor'"),
        (HEAD + FLOOR + STANDING + STANDING.replace("crate", "b"), "bodies[2].position", "'b' 1 m deep into 'crate'"),
        (HEAD + FLOOR + STANDING + 'material = "ice"\n', "bodies[1].material", "pair default - ice has no coeff"),
        (HEAD + "[world]\ndt = 0.1\n" + FLOOR + STANDING, "world.dt", "is large"),
        (HEAD.replace("1.0", "1e6") + FLOOR + STANDING, "duration", "60000000 steps"),
        (HEAD + FLOOR, "bodies", "all static"),
        (HEAD, "", "no bodies"),
        (HEAD + "[frames.a]\n" + FLOOR + STANDING, "frames.a", "nothing is placed in"),
        (
            HEAD + FLOOR + STANDING + '[[pushes]]\nbody = "crate"\nforce = [1, 0, 0]\nfrom = 3\n',
            "pushes[0].from",
            "nothing is pushed",
        ),
        (
            HEAD
            + '[[materials.pairs]]\na = "default"\nb = "default"\nstatic = 0.1\ndynamic = 0.2\n'
            + FLOOR
            + STANDING,
            "materials.pairs[0]",
            "dynamic friction 0.2 above static friction 0.1",
        ),
        (
            HEAD + '[[materials.pairs]]\na = "default"\nb = "wod"\nstatic = 0.1\n' + FLOOR + STANDING,
            "materials.pairs[0].b",
            "'wod', a material that no body",
        ),
    ],
)
def test_what_may_not_be_meant_is_told(text: str, path: str, words: str) -> None:
    found = warned(text)
    assert [entry[0] for entry in found] == [path]
    assert words in found[0][1]


def test_bodies_that_cannot_meet_need_no_coefficients() -> None:
    far = CRATE.replace("crate", "far") + 'position = [9, 0, 0.5]\nmaterial = "rubber"\nvelocity = [1, 0, 0]\n'
    near = STANDING + 'material = "wood"\n'
    told = warned(HEAD + FLOOR + near + far)
    assert [path for path, _ in told] == ["bodies[1].material", "bodies[2].material"], "each with the floor"
    told = warned(HEAD + FLOOR + near + far.replace("[1, 0, 0]", "[-9, 0, 0]"))
    assert "'wood' of body 'crate'" in told[-1][1]


def test_a_sweep_is_told_from_a_scene_and_checked() -> None:
    text = builtin_text_of_sweep()
    assert is_sweep(text) and not is_sweep(HEAD)
    assert check_sweep(text, "x.toml") == []
    wrong = text.replace("[[parameters]]", '[[parameters]]\nnme = "x"', 1).replace(
        "[[metrics]]", "[[metrics]]\nz = 1", 1
    )
    found = check_sweep(wrong, "x.toml")
    assert [one.suggestion for one in found if one.path.endswith("nme")] == ["name"]
    assert any(one.path.startswith("metrics[0].z") for one in found)
    assert all(one.place is not None for one in found)


def builtin_text_of_sweep() -> str:
    from stiction.sweep import builtin_text as text_of

    return text_of("slip-tip-hold")
