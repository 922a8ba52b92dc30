"""Scene files: what they say comes out in the world, and what they may not say is refused with one sentence."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction import BrushTyre, InvalidInputError, MaterialWarning
from stiction.errors import InvalidFileError
from stiction.scene import Scene, Simulation, builtin_names, builtin_text, json_schema, load

HEAD = 'title = "t"\nexpect = "e."\nduration = 1.0\n'
FLOOR = '[[bodies]]\nname = "floor"\nshape = {type = "plane"}\nstatic = true\n'
CRATE = '[[bodies]]\nname = "crate"\nshape = {type = "box", size = [1, 1, 1]}\n'


def scene_of(tmp_path: Path, text: str) -> Scene:
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    return load(str(file))


def refusal(tmp_path: Path, text: str) -> str:
    """The one sentence with which a scene is refused, by load or by build, without the file and the line in front."""
    with pytest.raises(InvalidFileError) as caught:
        scene_of(tmp_path, text).build()
    error = caught.value
    sentence, file = str(error), str(tmp_path / "scene.toml")
    assert sentence.endswith(".") and "\n" not in sentence
    assert error.file == file
    where = file if error.line is None else f"{file}, line {error.line}"
    assert sentence.startswith(where)
    return sentence.removeprefix(f"{where}: ")


def test_everything_a_body_says_comes_out_in_the_world(tmp_path: Path) -> None:
    world = scene_of(
        tmp_path,
        HEAD
        + """
[world]
gravity = [0, 0, -1.62]
dt = 0.01
iterations = 50
restitution_threshold = 0.1
[materials]
base = "empty"
[[materials.pairs]]
a = "felt"
b = "slate"
static = 0.6
dynamic = 0.5
rolling = 0.002
[[bodies]]
name = "floor"
shape = {type = "plane", normal = [0, 0, 2], offset = -1}
static = true
material = "slate"
[[bodies]]
name = "ball"
shape = {type = "sphere", radius = 0.5}
material = "felt"
mass = 3.0
position = [1, 2, 3]
velocity = [4, 5, 6]
angular_velocity = [7, 8, 9]
orientation = [0, 0, 0, 2]
[[bodies]]
name = "paddle"
shape = {type = "box", size = [1, 2, 3]}
kinematic = true
material = "felt"
rotation = {axis = [0, 0, 3], angle_deg = 90}
surface_velocity = [0.5, 0, 0]
[[bodies]]
name = "heavy"
shape = {type = "box", size = [1, 1, 2]}
density = 100
""",
    ).build()
    np.testing.assert_array_equal(world.gravity, [0, 0, -1.62])
    assert world.dt == 0.01
    pair = world.materials.pair("slate", "felt")
    assert (pair.static, pair.dynamic, pair.rolling, pair.source) == (0.6, 0.5, 0.002, "scene")
    assert world.materials.materials == ["default", "felt", "slate"]
    ball, paddle = world["ball"], world["paddle"]
    assert [body.name for body in world] == ["floor", "ball", "paddle", "heavy"]
    assert world["floor"].shape == st.Plane((0, 0, 1), -1)
    assert (ball.shape, ball.material, ball.mass, ball.mobility) == (st.Sphere(0.5), "felt", 3.0, "dynamic")
    np.testing.assert_array_equal(ball.position, [1, 2, 3])
    np.testing.assert_array_equal(ball.velocity, [4, 5, 6])
    np.testing.assert_array_equal(ball.angular_velocity, [7, 8, 9])
    np.testing.assert_array_equal(ball.orientation, [0, 0, 0, 1])
    assert paddle.mobility == "kinematic"
    np.testing.assert_allclose(paddle.orientation, [math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    np.testing.assert_array_equal(paddle.surface_velocity, [0.5, 0, 0])
    assert world["heavy"].mass == 200.0


def test_what_is_left_out_is_as_for_a_world_made_by_hand(tmp_path: Path) -> None:
    world, other = scene_of(tmp_path, HEAD + CRATE).build(), st.World()
    made = other.add(st.Box((1, 1, 1)))
    crate = world["crate"]
    assert (world.dt, world.solver) == (other.dt, other.solver)
    np.testing.assert_array_equal(world.gravity, other.gravity)
    assert world.materials == other.materials
    assert (crate.mass, crate.material) == (made.mass, made.material)
    assert world.state_hash() == other.state_hash()


def test_a_frame_turns_and_moves_what_is_placed_in_it(tmp_path: Path) -> None:
    world = scene_of(
        tmp_path,
        HEAD
        + """
[frames.ramp]
position = [10, 0, 0]
rotation = {axis = [0, 0, 1], angle_deg = 90}
[[bodies]]
name = "crate"
shape = {type = "box", size = [1, 1, 1]}
frame = "ramp"
position = [1, 0, 0.5]
velocity = [2, 0, 0]
angular_velocity = [0, 3, 0]
rotation = {axis = [1, 0, 0], angle_deg = 90}
""",
    ).build()
    crate = world["crate"]
    np.testing.assert_allclose(crate.position, [10, 1, 0.5], atol=1e-15)
    np.testing.assert_allclose(crate.velocity, [0, 2, 0], atol=1e-15)
    np.testing.assert_allclose(crate.angular_velocity, [-3, 0, 0], atol=1e-15)
    # first about the crate's x, then with the frame about z: (1 + k)(1 + i) / 2 = (1 + i + j + k) / 2
    np.testing.assert_allclose(crate.orientation, [0.5, 0.5, 0.5, 0.5], atol=1e-15)


def test_a_grid_names_and_places_its_copies(tmp_path: Path) -> None:
    grid = CRATE + "position = [0, 0, 5]\ngrid = {count = [2, 1, 3], step = [2, 9, 4]}\n"
    world = scene_of(tmp_path, HEAD + grid).build()
    assert [body.name for body in world][:4] == ["crate[0,0,0]", "crate[0,0,1]", "crate[0,0,2]", "crate[1,0,0]"]
    assert len(world) == 6
    np.testing.assert_array_equal(world["crate[1,0,2]"].position, [2, 0, 13])


def test_a_grid_follows_its_frame(tmp_path: Path) -> None:
    text = HEAD + "[frames.tilted]\nrotation = {axis = [0, 1, 0], angle_deg = 90}\n"
    text += CRATE + 'frame = "tilted"\ngrid = {count = [1, 1, 2], step = [0, 0, 3]}\n'
    world = scene_of(tmp_path, text).build()
    np.testing.assert_allclose(world["crate[0,0,1]"].position, [3, 0, 0], atol=1e-15)


def test_a_build_leaves_the_scene_and_other_worlds_alone(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, HEAD + CRATE)
    first, second = scene.build(), scene.build()
    first.materials.set_pair("wood", "ice", static=0.9)
    first["crate"].position = (1, 1, 1)
    assert second.materials.pair("wood", "ice").static == 0.2
    assert scene.build().state_hash() == second.state_hash() != first.state_hash()


@pytest.mark.parametrize("name", builtin_names())
def test_a_scene_survives_the_way_through_plain_data_and_json(name: str) -> None:
    scene = load(name)
    again = Scene.from_dict(json.loads(json.dumps(scene.to_dict())), name)
    assert again == scene
    assert again.to_dict() == scene.to_dict()
    assert again.build().state_hash() == scene.build().state_hash()


def test_scenes_that_differ_are_not_equal() -> None:
    assert load("ball") != load("ball", ["world.dt=0.01"])
    assert load("ball") != "ball"


def test_a_built_in_scene_can_be_saved_and_loaded_as_a_file(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, builtin_text("ramp"))
    assert scene == load("ramp")
    assert scene.name == "scene"
    assert repr(load("ramp")) == "<Scene 'ramp': Nine crates on a ramp of 30 degrees>"


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    assert scene_of(tmp_path, "\ufeff" + HEAD + CRATE).title == "t"


def test_dynamic_above_static_friction_warns_once_and_names_the_pair(tmp_path: Path) -> None:
    with pytest.warns(MaterialWarning, match="dynamic friction of wood - ice") as caught:
        scene = scene_of(tmp_path, HEAD + '[[materials.pairs]]\na = "wood"\nb = "ice"\ndynamic = 0.4\n')
        scene.build()
    assert len(caught) == 1


PAIR = '[[materials.pairs]]\na = "wood"\nb = "ice"\n'
PUSH = FLOOR + CRATE + '[[pushes]]\nbody = "crate"\nforce = [1, 0, 0]\n'
PADDLE = '[[bodies]]\nname = "paddle"\nshape = {type = "box", size = [1, 1, 1]}\nkinematic = true\n'
CHANGE = PADDLE + CRATE + '[[velocity_changes]]\nbody = "paddle"\ntime = 0.5\n'

REFUSED: dict[str, tuple[str, str]] = {
    # unknown keys, each with the nearest known one
    "top key": ("bodys = []\n" + HEAD, "bodys: is not a known key (did you mean 'bodies'?)."),
    "world key": (HEAD + "[world]\ngravty = [0, 0, 0]\n", "world.gravty: is not a known key (did you mean 'gravity'?)"),
    "body key": (HEAD + FLOOR + CRATE + "densty = 5\n", "bodies[1].densty: is not a known key (did you mean 'density'"),
    "shape key": (
        HEAD + CRATE.replace("size", "sise"),
        "bodies[0].shape.sise: is not a known key (did you mean 'size'?).",
    ),
    "foreign key": (HEAD + CRATE + "zzz = 5\n", "bodies[0].zzz: is not a known key; known are orientation, rotation"),
    "push key": (HEAD + PUSH + "form = 1\n", "pushes[0].form: is not a known key (did you mean 'from'?)."),
    "frame key": (
        HEAD + "[frames.a]\nrotation = {axis = [0, 0, 1], angle = 3}\n",
        "frames.a.rotation.angle: is not a known key (did you mean 'angle_deg'?).",
    ),
    # values
    "no title": ('expect = "e."\nduration = 1.0\n', "title: must be given."),
    "empty title": (HEAD.replace('"t"', '" "'), "title: must be a text that is not empty, got ' '."),
    "duration": (HEAD.replace("1.0", "-2"), "duration: must be above 0 s, got -2."),
    "nan": (HEAD + "[world]\ndt = nan\n", "world.dt: must be a finite number, got nan."),
    "huge": (HEAD + "[world]\ndt = 1" + 400 * "0" + "\n", "world.dt: must be a finite number, got 1000"),
    "text for number": (HEAD + '[world]\ndt = "1/60"\n', "world.dt: must be a finite number, got '1/60'."),
    "true for number": (HEAD + "[world]\ndt = true\n", "world.dt: must be a finite number, got True."),
    "gravity": (HEAD + "[world]\ngravity = -9.81\n", "world.gravity: must be 3 finite numbers, got -9.81."),
    "gravity of two": (HEAD + "[world]\ngravity = [0, -9.81]\n", "world.gravity: must be 3 finite numbers, got [0, -9"),
    "gravity of words": (HEAD + '[world]\ngravity = ["0", 0, 0]\n', "world.gravity: must be 3 finite numbers, got ["),
    "solver": (HEAD + '[world]\nsolver = "mikro"\n', "world.solver: must be one of micro, soft, exact, got 'mikro' (d"),
    "iterations": (HEAD + "[world]\niterations = 0\n", "world.iterations: must be a whole number, 1 or more, got 0."),
    "literal": (HEAD + "[world]\nmicro_literal = 1\n", "world.micro_literal: must be true or false, got 1."),
    "world as a value": ("world = 3\n" + HEAD, "world: must be a table of keys and values, got 3."),
    "bodies as a table": (HEAD + "[bodies]\nname = 1\n", "bodies: must be a list of tables, got {'name': 1}."),
    "frames as a list": (HEAD + "[[frames]]\n", "frames: must be a table of keys and values, got [{}]."),
    "body as a value": ("bodies = [3]\n" + HEAD, "bodies[0]: must be a table of keys and values, got 3."),
    "size": (
        HEAD + FLOOR + CRATE.replace("[1, 1, 1]", "[1, 0, 1]"),
        "bodies[1].shape.size: must be three lengths above 0 m, got [1.0, 0.0, 1.0].",
    ),
    "radius": (
        HEAD + '[[bodies]]\nname = "b"\nshape = {type = "sphere", radius = -1}\n',
        "bodies[0].shape.radius: must be above 0 m, got -1.",
    ),
    "normal": (HEAD + FLOOR.replace("}", ", normal = [0, 0, 0]}"), "bodies[0].shape.normal: must not be zero, got [0."),
    "type": (
        HEAD + CRATE.replace('"box"', '"bx"'),
        "bodies[0].shape.type: must be one of box, sphere, plane, capsule, cylinder, ellipsoid, hull, got 'bx' (did yo",
    ),
    "no type": (HEAD + '[[bodies]]\nname = "b"\nshape = {}\n', "bodies[0].shape.type: must be given: one of box, sphe"),
    "shape as a word": (
        HEAD + '[[bodies]]\nname = "b"\nshape = "box"\n',
        "bodies[0].shape: must be a table such as {type = \"box\", size = [1, 1, 1]}, got 'box'.",
    ),
    "few points": (
        HEAD + '[[bodies]]\nname = "b"\nshape = {type = "hull", points = [[0, 0, 0]]}\n',
        "bodies[0].shape.points: must be four or more points of three numbers each.",
    ),
    "no name": (HEAD + CRATE.replace('name = "crate"\n', ""), "bodies[0].name: must be given."),
    "dotted name": (HEAD + CRATE.replace("crate", "a.b"), "bodies[0].name: must be a name without any of . [ ] ="),
    "dotted frame": (HEAD + '[frames."a.b"]\n', "frames.a.b: must be a name without any of . [ ] ="),
    "mass": (HEAD + CRATE + "mass = 0\n", "bodies[0].mass: must be above 0 kg, got 0."),
    "mass and density": (
        HEAD + CRATE + "mass = 1\ndensity = 1\n",
        "bodies[0].density: must not be given together with mass.",
    ),
    "two turns": (
        HEAD + CRATE + "orientation = [1, 0, 0, 0]\nrotation = {axis = [0, 0, 1], angle_deg = 3}\n",
        "bodies[0].rotation: must not be given together with orientation.",
    ),
    "zero axis": (
        HEAD + CRATE + "rotation = {axis = [0, 0, 0], angle_deg = 3}\n",
        "bodies[0].rotation.axis: must not be zero, got [0.0, 0.0, 0.0].",
    ),
    "zero quaternion": (HEAD + CRATE + "orientation = [0, 0, 0, 0]\n", "bodies[0].orientation: must not be zero, got"),
    "static and kinematic": (
        HEAD + CRATE + "static = true\nkinematic = true\n",
        "bodies[0].kinematic: must not be true where static is true.",
    ),
    "grid count": (
        HEAD + CRATE + "grid = {count = [2, 0, 1], step = [1, 1, 1]}\n",
        "bodies[0].grid.count: must be three whole numbers, 1 or more, got [2, 0, 1].",
    ),
    "grid too large": (
        HEAD + CRATE + "grid = {count = [1000, 1000, 1000], step = [1, 1, 1]}\n",
        "bodies[0].grid.count: must ask for 100000 copies or fewer, got 1000 x 1000 x 1000.",
    ),
    "base": (HEAD + '[materials]\nbase = "lectur"\n', "materials.base: must be one of default, lecture, empty, got 'l"),
    "friction": (HEAD + PAIR + "static = -0.1\n", "materials.pairs[0].static: must be 0 or more, got -0.1."),
    "restitution": (HEAD + PAIR + "restitution = 1.5\n", "materials.pairs[0].restitution: must be between 0 and 1, go"),
    "new pair without static": (
        HEAD + PAIR.replace("wood", "felt") + "dynamic = 0.1\n",
        "materials.pairs[0]: static friction of felt - ice must be given for a new pair, got None.",
    ),
    # names that must exist
    "twice": (HEAD + CRATE + CRATE, "bodies[1].name: must be unique in a scene, got 'crate' twice."),
    "frame": (
        HEAD + "[frames.ramp]\n" + CRATE + 'frame = "rmap"\n',
        "bodies[0].frame: must be a frame of the scene, got 'rmap' (did you mean 'ramp'?).",
    ),
    "material": (
        HEAD + CRATE + 'material = "wod"\n',
        "bodies[0].material: must be a material of the scene, got 'wod' (did you mean 'wood'?).",
    ),
    "pushed body": (
        HEAD + PUSH.replace('body = "crate"', 'body = "crat"'),
        "pushes[0].body: must be a body of the scene, got 'crat' (did you mean 'crate'?).",
    ),
    "pushed floor": (
        HEAD + PUSH.replace('body = "crate"', 'body = "floor"'),
        "pushes[0].body: must be a dynamic body, and 'floor' is not.",
    ),
    "push ends before it begins": (
        HEAD + PUSH + "from = 2\nuntil = 1\n",
        "pushes[0].until: must be later than from (2 s), got 1.",
    ),
    "push before the beginning": (HEAD + PUSH + "from = -1\n", "pushes[0].from: must be 0 s or more, got -1."),
    "change of a dynamic body": (
        HEAD + CHANGE.replace('body = "paddle"', 'body = "crate"'),
        "velocity_changes[0].body: must be a kinematic body, and 'crate' is not.",
    ),
    "centre without inertia": (
        HEAD + CRATE + "center_of_mass = [0, 0, 0.1]\n",
        "bodies[0].center_of_mass: needs inertia beside it",
    ),
    "inertia": (HEAD + CRATE + "inertia = [1, 2]\n", "bodies[0].inertia: must be three moments or a tensor of"),
    "inertia of no body": (
        HEAD + CRATE + "inertia = [1, 1, 3]\n",
        "bodies[0]: inertia must obey the triangle inequality",
    ),
    # what only the world knows
    "dynamic plane": (HEAD + FLOOR.replace("true", "false"), "bodies[0]: a Plane must be static=True or kinematic=Tru"),
    "moving static": (HEAD + CRATE + "static = true\nvelocity = [1, 0, 0]\n", "bodies[0]: velocity and angular_veloci"),
    "flat hull": (
        HEAD + '[[bodies]]\nname = "b"\nshape = {type = "hull", points = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]}\n',
        "bodies[0]: ConvexHull points must not all lie in one plane.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_scene_that_is_not_allowed_is_refused_with_one_sentence(case: str, tmp_path: Path) -> None:
    text, sentence = REFUSED[case]
    assert refusal(tmp_path, text).startswith(sentence)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (HEAD + "[world\n", "scene.toml, line 4, column 7: TOML syntax error: Expected ']' at the end of a table"),
        (HEAD + "\nx = = 3\n", "scene.toml, line 5, column 5: TOML syntax error: Invalid value."),
        (HEAD + HEAD, "scene.toml, line 4, column"),
        (HEAD + 'x = "', "scene.toml, line 4"),
        (HEAD + "[world]", None),
    ],
)
def test_a_toml_syntax_error_names_file_and_line(text: str, sentence: str | None, tmp_path: Path) -> None:
    if sentence is None:
        assert scene_of(tmp_path, text).title == "t"
    else:
        assert sentence in refusal(tmp_path, text)


@pytest.mark.parametrize(
    "shape",
    [
        '{type = "capsule", radius = 0.5, length = 1}',
        '{type = "cylinder", radius = 0.5, length = 1}',
        '{type = "ellipsoid", half_extents = [0.5, 0.3, 0.2]}',
        '{type = "hull", points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}',
    ],
)
def test_every_shape_is_read_and_built(shape: str, tmp_path: Path) -> None:
    scene = scene_of(tmp_path, f'{HEAD}[[bodies]]\nname = "b"\nshape = {shape}\n')
    assert shape.split('"')[1] == scene.build()["b"].shape.kind


def test_every_solver_is_built_with_its_own_limits(tmp_path: Path) -> None:
    for solver in ("soft", "micro", "exact"):
        assert scene_of(tmp_path, HEAD + f'[world]\nsolver = "{solver}"\n').build().solver == solver


LAWS = """
[[materials.pairs]]
a = "tyre"
b = "road"
static = 1.0
dynamic = 0.9
static_across = 0.8
dynamic_across = 0.7
adhesion = 2.0
tangential_restitution = 0.5
law = {kind = "brush", stiffness = 15.0}

[[bodies]]
name = "wheel"
material = "tyre"
grain = [0, 2, 0]
shape = {type = "sphere", radius = 0.3}
"""


def test_laws_and_grain_are_read(tmp_path: Path) -> None:
    world = scene_of(tmp_path, HEAD + LAWS).build()
    pair = world.materials.pair("road", "tyre")
    assert pair.law == BrushTyre(15.0)
    assert (pair.static_across, pair.dynamic_across, pair.adhesion) == (0.8, 0.7, 2.0)
    assert pair.tangential_restitution == 0.5
    with pytest.raises(InvalidInputError, match="did you mean 'brush'"):
        scene_of(tmp_path, (HEAD + LAWS).replace('"brush"', '"brsh"')).build()


def test_a_scene_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"got 'rmap' \(did you mean 'ramp'\?\)\.$"):
        load("rmap")
    with pytest.raises(InvalidInputError, match="one of ball, billiards, conveyor"):
        builtin_text("nothing of that kind")
    with pytest.raises(InvalidInputError, match=r"scene file must exist, got '.*none\.toml'\.$"):
        load(str(tmp_path / "none.toml"))
    with pytest.raises(InvalidInputError, match=r"cannot be read: Is a directory\.$"):
        load(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidInputError, match="must be TOML text in UTF-8"):
        load(tmp_path / "binary.toml")
    with pytest.raises(InvalidInputError, match="the scene must be a table of keys and values, got 3"):
        Scene.from_dict(3)  # type: ignore[arg-type]  # wrong on purpose


def test_the_schema_knows_every_key_and_refuses_others() -> None:
    schema = json_schema()
    json.dumps(schema)
    assert set(schema["required"]) == {"title", "expect", "duration"}
    definitions: dict[str, Any] = schema["$defs"]
    assert {"from", "until", "body", "force", "growth", "at", "frame"} == set(definitions["PushTable"]["properties"])
    assert all(table["additionalProperties"] is False for table in definitions.values())
    assert definitions["BoxTable"]["properties"]["size"]["minItems"] == 3
    assert definitions["BodyTable"]["properties"]["density"]["description"].startswith("kg/m^3")
    assert definitions["WorldTable"]["properties"]["dt"]["exclusiveMinimum"] == 0


def test_a_body_may_be_loaded_on_one_side(tmp_path: Path) -> None:
    text = HEAD + CRATE + "mass = 2\ninertia = [0.3, 0.3, 0.4]\ncenter_of_mass = [0, 0.1, -0.2]\n"
    text += "position = [1, 0, 0]\nrotation = {axis = [1, 0, 0], angle_deg = 90}\n"
    scene = scene_of(tmp_path, text)
    crate = scene.build()["crate"]
    np.testing.assert_allclose(crate.center_of_mass, [1, 0.2, 0.1], atol=1e-15)
    np.testing.assert_allclose(crate.position, [1, 0, 0], atol=1e-15)
    world = st.World()
    other = world.add(
        st.Box((1, 1, 1)),
        mass=2,
        inertia=(0.3, 0.3, 0.4),
        center_of_mass=(0, 0.1, -0.2),
        orientation=(math.sqrt(0.5), math.sqrt(0.5), 0, 0),
    )
    np.testing.assert_allclose(crate.inertia, other.inertia)
    again = Scene.from_dict(json.loads(json.dumps(scene.to_dict())))
    assert again == scene
    assert again.build().state_hash() == scene.build().state_hash()
    heavier = load(tmp_path / "scene.toml", ["bodies.crate.center_of_mass[2]=-0.3"])
    np.testing.assert_allclose(heavier.build()["crate"].center_of_mass, [1, 0.3, 0.1], atol=1e-15)


def test_inertia_may_be_a_tensor(tmp_path: Path) -> None:
    tensor = [[0.3, 0.01, 0.0], [0.01, 0.3, 0.0], [0.0, 0.0, 0.4]]
    scene = scene_of(tmp_path, HEAD + CRATE + f"inertia = {tensor}\n")
    np.testing.assert_allclose(scene.build()["crate"].inertia, tensor)
    assert Scene.from_dict(scene.to_dict()) == scene


def test_a_spring_at_the_centre_of_mass_does_not_turn_a_body_that_is_loaded_on_one_side(tmp_path: Path) -> None:
    text = HEAD + "[world]\ngravity = [0, 0, 0]\n" + CRATE + "inertia = [9, 9, 9]\ncenter_of_mass = [0, 0, -0.2]\n"
    text += '[[springs]]\nbody = "crate"\nstiffness = 100\nanchor = [1, 0, -0.2]\n'
    turned, held = (Simulation(scene_of(tmp_path, text + f"at = [0, 0, {z}]\n")) for z in (0.0, -0.2))
    for simulation in (turned, held):
        simulation.advance(10)
    assert np.linalg.norm(held.world["crate"].angular_velocity) == 0.0
    assert np.linalg.norm(turned.world["crate"].angular_velocity) > 1e-3
