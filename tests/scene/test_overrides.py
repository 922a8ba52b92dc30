"""Overrides: a path leads to one value of a scene, or says where it went astray."""

from __future__ import annotations

from typing import Any

import pytest

from stiction import InvalidInputError
from stiction.scene import load
from stiction.scene.overrides import apply_values


def value_at(scene: Any, *keys: Any) -> Any:
    node = scene.to_dict()
    for key in keys:
        node = node[key]
    return node


@pytest.mark.parametrize(
    ("override", "keys", "value"),
    [
        ("world.dt=0.01", ("world", "dt"), 0.01),
        ("world.dt = 0.01", ("world", "dt"), 0.01),
        ("world.micro_literal=true", ("world", "micro_literal"), True),
        ("duration=0.5", ("duration",), 0.5),
        ("title=a bare text", ("title",), "a bare text"),
        ('title="with = and . in it"', ("title",), "with = and . in it"),
        ("title=two = signs", ("title",), "two = signs"),
        ("bodies.ball.velocity=[5,0,0]", ("bodies", 1, "velocity"), [5.0, 0.0, 0.0]),
        ("bodies[1].velocity=[5,0,0]", ("bodies", 1, "velocity"), [5.0, 0.0, 0.0]),
        ("bodies.ball.velocity[1]=2", ("bodies", 1, "velocity"), [3.5, 2.0, 0.0]),
        ("bodies.ball.material=glass", ("bodies", 1, "material"), "glass"),
        ("bodies.ball.shape.radius=0.1", ("bodies", 1, "shape", "radius"), 0.1),
        (
            'bodies.ball.shape={type="box", size=[1,1,1]}',
            ("bodies", 1, "shape"),
            {"type": "box", "size": [1.0, 1.0, 1.0]},
        ),
        ("bodies.ball.mass=3", ("bodies", 1, "mass"), 3.0),
        ("materials.base=default", ("materials", "base"), "default"),
        ("materials.pairs.wood-ice.static=0.3", ("materials", "pairs", 0), {"a": "wood", "b": "ice", "static": 0.3}),
        (
            "materials.pairs.ice-wood.rolling=0.01",
            ("materials", "pairs", 0),
            {"a": "ice", "b": "wood", "rolling": 0.01},
        ),
        (
            "materials.pairs.lubricated metal-metal.dynamic=0.02",
            ("materials", "pairs", 0),
            {"a": "lubricated metal", "b": "metal", "dynamic": 0.02},
        ),
    ],
)
def test_an_override_sets_one_value(override: str, keys: tuple[Any, ...], value: Any) -> None:
    scene = load("ball", [override])
    assert value_at(scene, *keys) == value
    plain, changed = load("ball").to_dict(), scene.to_dict()
    for data in (plain, changed):
        data.pop(keys[0])
    assert plain == changed, "and nothing else"


def test_an_override_reaches_the_world() -> None:
    world = load("ball", ["materials.pairs.wood-ice.static=0.3", "bodies.ball.velocity=[5,0,0]"]).build()
    pair = world.materials.pair("wood", "ice")
    assert (pair.static, pair.dynamic) == (0.3, 0.1), "dynamic friction keeps its value"
    assert world["ball"].velocity.tolist() == [5, 0, 0]


def test_a_frame_of_the_ramp_can_be_turned() -> None:
    scene = load("ramp", ["frames.ramp.rotation.angle_deg=25"])
    assert value_at(scene, "frames", "ramp", "rotation", "angle_deg") == 25.0


def test_later_overrides_see_earlier_ones() -> None:
    scene = load("ball", ["materials.pairs.wood-ice.static=0.3", "materials.pairs.wood-ice.dynamic=0.2", "world.dt=1"])
    assert value_at(scene, "materials", "pairs") == [{"a": "wood", "b": "ice", "static": 0.3, "dynamic": 0.2}]
    with pytest.raises(InvalidInputError, match="has entries 0 to 0, not 1"):
        load("ball", ["materials.pairs.wood-ice.static=0.3", "materials.pairs[1].static=0.3"])


def test_setting_one_of_two_alternatives_drops_the_other() -> None:
    body = value_at(load("pyramid", ["bodies.row0.mass=3"]), "bodies", 1)
    assert body["mass"] == 3.0 and "density" not in body
    frame = value_at(load("ramp", ["frames.ramp.orientation=[1,0,0,0]"]), "frames", "ramp")
    assert frame == {"position": [0.0, 0.0, 5.7], "orientation": [1.0, 0.0, 0.0, 0.0]}


def test_a_value_cannot_smuggle_in_a_second_key() -> None:
    assert load("ball", ["title=1\nduration = 9"]).title == "1\nduration = 9"


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("world.dt", "override must be path=value, such as world.dt=0.01, got 'world.dt'."),
        ("=3", "override must be path=value, such as world.dt=0.01, got '=3'."),
        ("wrld.dt=3", "override 'wrld.dt': 'wrld' is not known in a scene (did you mean 'world'?)."),
        ("world.tt=3", "override 'world.tt': 'tt' is not known in world (did you mean 'dt'?)."),
        ("world.zzz=3", "override 'world.zzz': 'zzz' is not known in world; known are gravity, dt, solver"),
        ("bodies.bal.velocity=3", "override 'bodies.bal.velocity': 'bal' is not known in bodies (did you mean 'ball'?"),
        (
            "bodies.ball.velocty=3",
            "override 'bodies.ball.velocty': 'velocty' is not known in bodies.ball (did you mean 'velocity'?).",
        ),
        (
            "materials.pairs.wod-ice.static=1",
            "override 'materials.pairs.wod-ice.static': 'wod-ice' is not known in materials.pairs (did you mean 'wood-",
        ),
        ("bodies[2].mass=3", "override 'bodies[2].mass': bodies has entries 0 to 1, not 2."),
        (
            "bodies.ball.velocity[3]=3",
            "override 'bodies.ball.velocity[3]': bodies.ball.velocity has entries 0 to 2, not 3.",
        ),
        ("world.dt.x=3", "override 'world.dt.x': world.dt is a single value and has nothing in it."),
        (
            "bodies.ball.rotation.angle_deg=3",
            "override 'bodies.ball.rotation.angle_deg': bodies.ball.rotation has no value in this scene, so set it as",
        ),
        ("bodies..mass=3", "override path must be like bodies.crate.velocity[0], got 'bodies..mass'."),
        ("world.dt=-1", "world.dt: must be above 0 s, got -1."),
        ("world.dt=fast", "world.dt: must be a finite number, got 'fast'."),
        ("bodies.ball.velocity=[5,0", "bodies[1].velocity: must be 3 finite numbers, got '[5,0'."),
        ("bodies.ball.material=glas", "bodies[1].material: must be a material of the scene, got 'glas' (did you mean"),
        ("bodies=3", "bodies: must be a list of tables, got 3."),
        ("bodies.ball=3", "bodies[1]: must be a table of keys and values, got 3."),
    ],
)  # fmt: skip
def test_an_override_that_leads_nowhere_says_so(override: str, sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        load("ball", [override])
    assert str(caught.value).startswith(sentence)
    assert str(caught.value).endswith(".")


def test_values_are_set_together_and_checked_once() -> None:
    table = load("ball").table
    both = {"materials.pairs.wood-ice.static": 0.3, "materials.pairs.ice-wood.dynamic": 0.2, "bodies.ball.density": 500}
    changed = apply_values(table, both)
    (pair,) = (pair for pair in changed.materials.pairs if {pair.a, pair.b} == {"wood", "ice"})
    assert (pair.static, pair.dynamic) == (0.3, 0.2)
    assert (changed.bodies[1].density, changed.bodies[1].mass) == (500.0, None)
    assert apply_values(table, {}) == table == load("ball").table
    with pytest.raises(InvalidInputError, match=r"did you mean 'velocity'\?"):
        apply_values(table, {"bodies.ball.velocty[0]": 1.0})
    with pytest.raises(InvalidInputError, match=r"^bodies\[1\]\.density: must be above 0 kg/m\^3, got -1\."):
        apply_values(table, {"duration": 1.0, "bodies.ball.density": -1})


def test_pushes_are_set_by_number() -> None:
    assert value_at(load("push-and-release", ["pushes[1].from=0.5"]), "pushes", 1, "from") == 0.5
    with pytest.raises(InvalidInputError, match=r"the entries of pushes have numbers, such as pushes\[0\]\.$"):
        load("push-and-release", ["pushes.resting.from=0.5"])
