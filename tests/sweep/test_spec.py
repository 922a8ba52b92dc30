"""A sweep's file: what is wrong in it is one sentence that names the key."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from stiction.errors import InvalidInputError
from stiction.sweep import builtin_names, builtin_text, from_dict, load
from stiction.sweep.load import json_schema
from stiction.sweep.runner import Runner

from .support import CRATE, spec

V = {"key": "bodies.crate.velocity[0]", "name": "v", "linspace": [0.5, 1.5, 5]}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"metrcs": []}, "metrcs: is not a known key (did you mean 'metrics'?)."),
        ({"parameters": [{**V, "linspce": [0, 1, 2]}]}, "parameters[0].linspce: is not a known key (did you mean 'lin"),
        ({"parameters": []}, "parameters: "),
        ({"parameters": [{"key": "world.dt"}]}, "parameters[0]: must have exactly one of values, linspace, "),
        ({"parameters": [{**V, "values": [1]}]}, "parameters[0]: must have exactly one of values, linspace, "),
        ({"parameters": [{**V, "linspace": [0, 1]}]}, "parameters[0].linspace: must be first value, last value and"),
        ({"parameters": [{"key": "world.dt", "values": [1, "a"]}]}, "parameters[0].values: must be of one kind, got"),
        ({"parameters": [{"key": "world.dt", "uniform": [2, 1]}]}, "parameters[0].uniform: must be two numbers, the s"),
        ({"parameters": [{"key": "world.dt", "logsobol": [0, 1]}]}, "parameters[0].logsobol: must begin and end above"),
        ({"parameters": [{"key": "world.dt", "uniform": [1, 2]}]}, "samples: must be given, for 'world.dt' is drawn."),
        (
            {"parameters": [{"key": "world.dt", "sobol": [1, 2]}], "samples": 100},
            "samples: must be a power of two with sobol, such as 64 or 128, got 100.",
        ),
        ({"samples": 4}, "samples: must not be given where no parameter has one of uniform"),
        (
            {"parameters": [V, {**V, "key": "world.dt"}]},
            "the sweep names of parameters and metrics must differ, got 'v'",
        ),
        ({"parameters": [{**V, "name": "steps"}]}, "parameters[0].name: must be a name of letters, digits and _ that"),
        (
            {"parameters": [{**V, "key": "bodies.crat.velocity[0]"}]},
            "parameters[0]: override 'bodies.crat.velocity[0]': 'crat' is not known in bodies (did you mean 'crate'?).",
        ),
        (
            {"parameters": [{"key": "bodies.crate.mass", "values": [1, -1]}]},
            "parameters[0]: bodies[1].mass: must be above 0 kg, got -1.",
        ),
        ({"parameters": [{**V, "linspace": [0, 1, 10**9]}]}, "the sweep asks for 1000000000 runs, and 100000000 are"),
        ({"metrics": [{"name": "way", "value": "slipp_distance('crate')"}]}, "metrics[0].value: 'slipp_distance' is"),
        (
            {"metrics": [{"name": "way", "value": "slip_distance('crte')"}]},
            "metrics[0].value: slip_distance needs a body of the scene, got 'crte' (did you mean 'crate'?).",
        ),
        ({"derived": [{"key": "bodies.crate.mass", "value": "2 * w"}]}, "derived[0].value: 'w' is not a known name in"),
        ({"derived": [{"key": "bodies.crate.weight", "value": "v"}]}, "derived[0]: override 'bodies.crate.weight': "),
        ({"scene": {**CRATE, "gravity": 1}}, "scene.gravity: is not a known key"),
        ({"scene": "rmap"}, "scene must be the path of a TOML file or one of ball, "),
        ({"duration": 0}, "duration: must be above 0 s, got 0."),
        (
            {"map": {"x": "v", "y": "w", "classes": [{"label": "a", "when": "way > 1"}]}},
            "map.y: must be a parameter with numbers, got 'w'; they are v.",
        ),
    ],
)
def test_a_mistake_is_one_sentence_that_names_the_key(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        from_dict(spec(**changes))
    assert str(caught.value).startswith(sentence)
    assert "\n" not in str(caught.value)


def test_a_scene_is_a_name_a_table_or_a_file_beside_the_sweep(tmp_path: Path) -> None:
    assert from_dict(spec()).scene.bodies[1].name == "crate"
    ball = {"scene": "ball", "parameters": [{"key": "world.dt", "values": [0.01]}]}
    named = from_dict(spec(**ball, metrics=[{"name": "way", "value": "displacement('ball')"}]))
    assert named.scene.bodies[1].name == "ball"
    scene = (
        "title = 'a'\nexpect = 'a'\nduration = 1\n[[bodies]]\nname = 'ball'\nshape = {type = 'sphere', radius = 1}\n"
    )
    (tmp_path / "mine.toml").write_text(scene)
    text = (
        'title = "a"\nscene = "mine.toml"\nduration = 0.25\n[[parameters]]\nkey = "world.dt"\nvalues = [0.01]\n'
        '[[metrics]]\nname = "way"\nvalue = "1"\n'
    )
    (tmp_path / "sweep.toml").write_text(text)
    loaded = load(tmp_path / "sweep.toml", ["bodies.ball.shape.radius=2"])
    assert (loaded.name, loaded.scene.duration, loaded.scene.bodies[0].shape.radius) == ("sweep", 0.25, 2.0)  # type: ignore[union-attr]  # it is a sphere


def test_the_file_in_the_documentation_runs() -> None:
    page = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    sweep = from_dict(tomllib.loads(page.partition("```toml\n")[2].partition("```")[0]))
    assert len(sweep.points) == 22
    row = Runner(sweep.job).run(sweep.points[0].values)
    assert row["error"] is None and 0.0 < row["metrics"]["share"] < 1.0


def test_built_in_sweeps_load_and_say_what_they_are_about() -> None:
    for name in builtin_names():
        assert len(load(name).points) > 1
        assert builtin_text(name).startswith("#")
    with pytest.raises(InvalidInputError, match=r"did you mean 'slip-tip-hold'\?"):
        load("slip-tip-hld")


def test_the_schema_knows_every_key() -> None:
    schema = json_schema()
    assert set(spec()) <= set(schema["properties"])
    assert schema["additionalProperties"] is False
