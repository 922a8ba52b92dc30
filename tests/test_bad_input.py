"""Bad input: each gets one sentence that names the parameter, the value and what is allowed, and changes nothing.

``TABLE`` is the test, and the page docs/bad-input.md is written from it: run this file with STICTION_REGENERATE=1.
"""

from __future__ import annotations

import os
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.errors import InvalidInputError, NotYetError, SimulationError, StictionError

PAGE = Path(__file__).parents[1] / "docs" / "bad-input.md"
REGENERATE = "STICTION_REGENERATE"


@dataclass(frozen=True)
class Row:
    """A call, and the sentence it gets: word for word, or a pattern where the words do not matter."""

    call: str
    sentence: str | re.Pattern[str]
    error: type[StictionError] = InvalidInputError


def says(pattern: str) -> re.Pattern[str]:
    """One sentence that matches."""
    return re.compile(pattern)


TABLE: dict[str, list[Row]] = {
    "Shapes": [
        Row("st.Sphere(0)", "Sphere radius must be above 0 m, got 0."),
        Row("st.Sphere(-1.5)", "Sphere radius must be above 0 m, got -1.5."),
        Row("st.Sphere(nan)", "Sphere radius must be a finite number, got nan."),
        Row("st.Sphere('1')", "Sphere radius must be a finite number, got '1'."),
        Row("st.Sphere(True)", "Sphere radius must be a finite number, got True."),
        Row("st.Box(1)", "Box size must have shape (3,), got shape () from 1."),
        Row("st.Box((1, 2))", "Box size must have shape (3,), got shape (2,) from (1, 2)."),
        Row("st.Box((1, 0, 1))", "Box size must be three lengths above 0 m, got (1, 0, 1)."),
        Row("st.Box((1, 1, inf))", "Box size must be 3 finite numbers, got (1, 1, inf)."),
        Row("st.Box('large')", "Box size must be 3 finite numbers, got 'large'."),
        Row("st.Box((1, (1, 2), 1))", "Box size must be 3 finite numbers, got (1, (1, 2), 1)."),
        Row("st.Capsule(0.5, 0)", "Capsule length must be above 0 m, got 0."),
        Row("st.Capsule(None, 1)", "Capsule radius must be a finite number, got None."),
        Row("st.Cylinder(-1, 1)", "Cylinder radius must be above 0 m, got -1."),
        Row("st.Ellipsoid(1)", "Ellipsoid half_extents must have shape (3,), got shape () from 1."),
        Row("st.Ellipsoid((1, 0, 1))", "Ellipsoid half_extents must be three lengths above 0 m, got (1, 0, 1)."),
        Row("st.Ellipsoid((1, 1, nan))", "Ellipsoid half_extents must be 3 finite numbers, got (1, 1, nan)."),
        Row("st.Plane((0, 0, 0))", "Plane normal must not be the zero vector, got (0, 0, 0)."),
        Row("st.Plane(offset=inf)", "Plane offset must be a finite number, got inf."),
        Row(
            "st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0)])",
            "ConvexHull points must have shape (n, 3) with n of 4 or more, got (3, 3).",
        ),
        Row(
            "st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])",
            "ConvexHull points must not all lie in one plane.",
        ),
        Row(
            "st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, nan)])",
            "ConvexHull points must all be finite numbers.",
        ),
        Row("st.ConvexHull('cube')", "ConvexHull points must be an array of shape (n, 3) of finite numbers."),
    ],
    "Making a world": [
        Row("st.World(gravity=9.81)", "gravity must have shape (3,), got shape () from 9.81."),
        Row("st.World(gravity=(0, 0, nan))", "gravity must be 3 finite numbers, got (0, 0, nan)."),
        Row("st.World(dt=0)", "dt must be above 0 s, got 0."),
        Row("st.World(dt='fast')", "dt must be a finite number, got 'fast'."),
        Row("st.World(dt=-0.01)", "dt must be above 0 s, got -0.01."),
        Row(
            "st.World(solver='sofd')",
            "solver must be one of micro, soft, exact, got 'sofd' (did you mean 'soft'?).",
        ),
        Row("st.World(iterations=0)", "iterations must be a whole number, 1 or more, got 0."),
        Row("st.World(iterations=2.5)", "iterations must be a whole number, 1 or more, got 2.5."),
        Row("st.World(substeps=0)", "substeps must be a whole number, 1 or more, got 0."),
        Row("st.World(precision='half')", "precision must be one of double, single, got 'half'."),
        Row("st.World(materials={})", "materials must be a MaterialTable, got dict."),
        Row("st.World(micro_literal=1)", "micro_literal must be True or False, got 1."),
        Row("st.World(micro_literal=True)", "micro_literal must be left out unless solver is 'micro'."),
        Row("st.World(sleeping=1)", "sleeping must be True or False, got 1."),
        Row("st.World(restitution_threshold=-1)", "restitution_threshold must be 0 m/s or more, got -1."),
    ],
    "Adding a body": [
        Row("world.add('box')", "shape must be a stiction shape such as Box((1, 1, 1)), got 'box'."),
        Row("world.add(st.Plane())", "a Plane must be static=True or kinematic=True, for it has no finite mass."),
        Row("world.add(st.Sphere(1), static=True, kinematic=True)", "static and kinematic must not both be True."),
        Row("world.add(st.Sphere(1), static='yes')", "static must be True or False, got 'yes'."),
        Row("world.add(st.Sphere(1), position=(1, 2))", "position must have shape (3,), got shape (2,) from (1, 2)."),
        Row("world.add(st.Sphere(1), position=(0, nan, 0))", "position must be 3 finite numbers, got (0, nan, 0)."),
        Row("world.add(st.Sphere(1), position=None)", "position must have shape (3,), got shape () from None."),
        Row(
            "world.add(st.Sphere(1), orientation=(0, 0, 0, 0))",
            "orientation must not be the zero quaternion, got (0, 0, 0, 0).",
        ),
        Row(
            "world.add(st.Sphere(1), orientation=(1, 0, 0))",
            "orientation must have shape (4,), got shape (3,) from (1, 0, 0).",
        ),
        Row("world.add(st.Sphere(1), velocity=(inf, 0, 0))", "velocity must be 3 finite numbers, got (inf, 0, 0)."),
        Row(
            "world.add(st.Sphere(1), angular_velocity='spin')",
            "angular_velocity must be 3 finite numbers, got 'spin'.",
        ),
        Row(
            "world.add(st.Sphere(1), static=True, velocity=(1, 0, 0), name='wall')",
            "velocity and angular_velocity of static body 'wall' must be zero (a kinematic body moves, "
            "surface_velocity makes a belt).",
        ),
        Row(
            "world.add(st.Sphere(1), surface_velocity=3)", "surface_velocity must have shape (3,), got shape () from 3."
        ),
        Row("world.add(st.Sphere(1), mass=0)", "mass must be above 0 kg, got 0."),
        Row("world.add(st.Sphere(1), mass=nan)", "mass must be a finite number, got nan."),
        Row("world.add(st.Sphere(1), density=-600)", "density must be above 0 kg/m^3, got -600."),
        Row(
            "world.add(st.Sphere(1), mass=1, density=600)",
            "mass and density must not both be given, got 1 kg and 600 kg/m^3.",
        ),
        Row(
            "world.add(st.Sphere(1), mass=1, inertia=(1, 1, 3))",
            "inertia must obey the triangle inequality (no principal moment above the sum of the others), got 1, 1, 3 "
            "kg m^2.",
        ),
        Row(
            "world.add(st.Sphere(1), mass=1, inertia=(1, 0, 1))",
            "inertia must have positive principal moments, got 0, 1, 1 kg m^2.",
        ),
        Row(
            "world.add(st.Sphere(1), mass=1, inertia=1)",
            "inertia must be three moments or a (3, 3) tensor, got shape ().",
        ),
        Row(
            "world.add(st.Sphere(1), static=True, inertia=(1, 1, 1))",
            "inertia must be left out for a body that is not dynamic.",
        ),
        Row(
            "world.add(st.Sphere(1), static=True, center_of_mass=(0, 0, 0.1))",
            "center_of_mass must be left out for a body that is not dynamic.",
        ),
        Row(
            "world.add(st.Sphere(1), inertia=(1, 1, 1), center_of_mass=(0, 0))",
            "center_of_mass must have shape (3,), got shape (2,) from (0, 0).",
        ),
        Row(
            "world.add(st.Sphere(1), center_of_mass=(0, 0, 0.1))",
            "inertia must be given where center_of_mass is, for that of the shape is of its own mass distribution.",
        ),
        Row(
            "world.add(st.Sphere(1), material='woood')",
            "material must be one of the 10 in the table, got 'woood' (did you mean 'wood'?).",
        ),
        Row(
            "world.add(st.Sphere(1), material='unobtainium')",
            "material must be one of the 10 in the table, got 'unobtainium'.",
        ),
        Row(
            "world.add(st.Sphere(1), material=None)",
            "material name must be a non-empty text without blanks around it, got None.",
        ),
        Row("world.add(st.Sphere(1), material=['wood'])", says(r"^material .*, got \['wood'\]\.$")),
        Row("world.add(st.Sphere(1), name='crate')", "name must be unique in a world, got 'crate' twice."),
        Row("world.add(st.Sphere(1), name='')", "name must be a text that is not empty, got ''."),
        Row("world.add(st.Sphere(1), name=7)", "name must be a text that is not empty, got 7."),
        # numbers that are finite, and whose volume, mass or length is not
        Row("world.add(st.Sphere(1e200))", says(r"^Sphere radius must be .* m, got 1e\+200\.$")),
        Row("world.add(st.Sphere(1e-200))", says(r"^Sphere radius must be .* m, got 1e-200\.$")),
        Row("world.add(st.Box((1e-120, 1e-120, 1e-120)))", says(r"^Box size must be .* m, got .*1e-120")),
        Row("world.add(st.Sphere(1), density=1e308)", says(r"^(density|mass).* must be ")),
        Row("world.add(st.Sphere(1), mass=1e-320)", says(r"^mass must be .* kg, got 1e-320\.$")),
        Row(
            "world.add(st.Sphere(1), position=('1', '2', '3'))",
            "position must be 3 finite numbers, got ('1', '2', '3').",
        ),
        Row(
            "world.add(st.Sphere(1), position=(True, False, True))",
            "position must be 3 finite numbers, got (True, False, True).",
        ),
        Row("world.add(st.Sphere(1), position=np.array([1j, 0, 0]))", says(r"^position must be 3 finite numbers")),
    ],
    "Looking up": [
        Row("world['crat']", "no body is called 'crat' (did you mean 'crate'?)."),
        Row("world[['crate']]", says(r"^no body is called \['crate'\]")),
        Row("world.contacts(3)", "body must be a body of this world, got 3."),
        Row(
            "world.contacts(stranger)",
            "body must be a body of this world, got <Body 'stranger' (dynamic sphere, default)>.",
        ),
    ],
    "Time and gravity": [
        Row("world.step(0)", "n must be a whole number, 1 or more, got 0."),
        Row("world.step(-3)", "n must be a whole number, 1 or more, got -3."),
        Row("world.step(1.5)", "n must be a whole number, 1 or more, got 1.5."),
        Row("world.step(True)", "n must be a whole number, 1 or more, got True."),
        Row("world.run(0)", "seconds must be above 0 s, got 0."),
        Row("world.run(nan)", "seconds must be a finite number, got nan."),
        Row("world.run('long')", "seconds must be a finite number, got 'long'."),
        Row("world.run(1e308)", says(r"^seconds must be .* s or less, got 1e\+308\.$")),
        Row("world.gravity = 'down'", "gravity must be 3 finite numbers, got 'down'."),
        Row("world.gravity = (0, inf, 0)", "gravity must be 3 finite numbers, got (0, inf, 0)."),
    ],
    "Setting what a body has": [
        Row("crate.position = (0, 0)", "position of body 'crate' must have shape (3,), got shape (2,) from (0, 0)."),
        Row("crate.position = (nan, 0, 0)", "position of body 'crate' must be 3 finite numbers, got (nan, 0, 0)."),
        Row(
            "crate.orientation = (0, 0, 0, 0)",
            "orientation of body 'crate' must not be the zero quaternion, got (0, 0, 0, 0).",
        ),
        Row("crate.velocity = (0, 0, inf)", "velocity of body 'crate' must be 3 finite numbers, got (0, 0, inf)."),
        Row(
            "crate.angular_velocity = None",
            "angular_velocity of body 'crate' must have shape (3,), got shape () from None.",
        ),
        Row(
            "crate.surface_velocity = 1", "surface_velocity of body 'crate' must have shape (3,), got shape () from 1."
        ),
        Row("crate.mass = 0", "mass of body 'crate' must be above 0 kg, got 0."),
        Row("crate.mass = inf", "mass of body 'crate' must be a finite number, got inf."),
        Row("crate.mass = 1e-320", says(r"^mass of body 'crate' must ")),
        Row(
            "crate.inertia = (1, 2, 4)",
            "inertia of body 'crate' must obey the triangle inequality (no principal moment above the sum of the "
            "others), got 1, 2, 4 kg m^2.",
        ),
        Row(
            "crate.inertia = [(1, 0, 0), (0.5, 1, 0), (0, 0, 1)]",
            "inertia of body 'crate' must be symmetric, got [(1, 0, 0), (0.5, 1, 0), (0, 0, 1)].",
        ),
        Row("crate.inertia = (1, nan, 1)", "inertia of body 'crate' must be finite, got (1, nan, 1)."),
        Row(
            "floor.velocity = (1, 0, 0)",
            "velocity of body 'floor' must be zero, for it is static (kinematic ones move).",
        ),
        Row("floor.mass = 3", "mass of body 'floor' has no effect, for it is static, not dynamic."),
    ],
    "Forces and impulses": [
        Row("crate.apply_force((1, 2))", "force on body 'crate' must have shape (3,), got shape (2,) from (1, 2)."),
        Row("crate.apply_force((0, 0, nan))", "force on body 'crate' must be 3 finite numbers, got (0, 0, nan)."),
        Row("crate.apply_force((0, 0, 1), at=(nan, 0, 0))", "at must be 3 finite numbers, got (nan, 0, 0)."),
        Row("crate.apply_torque(1)", "torque on body 'crate' must have shape (3,), got shape () from 1."),
        Row("crate.apply_impulse('kick')", "impulse on body 'crate' must be 3 finite numbers, got 'kick'."),
        Row("crate.apply_impulse((1, 0, 0), at=(0, 0))", "at must have shape (3,), got shape (2,) from (0, 0)."),
        Row("floor.apply_force((1, 0, 0))", "force of body 'floor' has no effect, for it is static, not dynamic."),
        Row("floor.apply_torque((1, 0, 0))", "torque of body 'floor' has no effect, for it is static, not dynamic."),
        Row(
            "pusher.apply_impulse((1, 0, 0))",
            "impulse of body 'pusher' has no effect, for it is kinematic, not dynamic.",
        ),
        # what overflows only in the torque must not leave the force behind
        Row("crate.apply_force((0, 0, 1e300), at=(1e300, 0, 0))", says(r"'crate' must stay finite")),
        Row("crate.apply_impulse((0, 0, 1e300), at=(1e300, 0, 0))", says(r"'crate' must stay finite")),
    ],
    "Materials": [
        Row(
            "world.materials.set_pair('wood', 'ice', static=-0.1)",
            "static friction of wood - ice must be 0 or more, got -0.1.",
        ),
        Row(
            "world.materials.set_pair('wood', 'ice', dynamic=nan)",
            "dynamic friction of wood - ice must be a finite number, got nan.",
        ),
        Row(
            "world.materials.set_pair('wood', 'ice', static=0.3, restitution=1.5)",
            "restitution of wood - ice must be between 0 and 1, got 1.5.",
        ),
        Row(
            "world.materials.set_pair('wood', 'felt', dynamic=0.2)",
            "static friction of wood - felt must be given for a new pair, got None.",
        ),
        Row(
            "world.materials.pair('wood', 'rubbr')",
            "material must be one of the 10 in the table, got 'rubbr' (did you mean 'rubber'?).",
        ),
    ],
    "Not there yet": [
        Row(
            "st.World(solver='exact', threads=2)",
            "threads must be 1 with solver 'exact', got 2.",
            NotYetError,
        ),
        Row(
            "st.World(solver='micro', substeps=4)",
            "substeps must be 1 with solver 'micro', got 4; use a smaller dt.",
            NotYetError,
        ),
        Row(
            "st.World(solver='micro', precision='single')",
            "precision 'single' is not there yet with solver 'micro'; it has 'double'.",
            NotYetError,
        ),
    ],
}
"""What is asked for, under headings, and what is said."""

ROWS = [row for rows in TABLE.values() for row in rows]


class Scene:
    """A world in the middle of something: a sliding crate, a moving pusher, forces that wait for the next step."""

    def __init__(self, solver: str | None = None) -> None:
        self.world = st.World(solver=solver, materials=st.MaterialTable.lecture())
        self.floor = self.world.add(st.Plane(), static=True, name="floor", material="concrete")
        self.crate = self.world.add(
            st.Box((1, 1, 1)), mass=2.0, position=(0, 0, 0.5), velocity=(2, 1, 0), material="wood", name="crate"
        )
        self.pusher = self.world.add(
            st.Sphere(0.2), kinematic=True, position=(5, 0, 1), velocity=(0, 1, 0), name="pusher"
        )
        self.stranger = st.World().add(st.Sphere(1), name="stranger")
        self.world.step(3)
        self.crate.apply_force((1, 2, 3), at=(0.1, 0, 1))

    def names(self) -> dict[str, Any]:
        """What a call in the table may use."""
        return {"st": st, "np": np, "nan": float("nan"), "inf": float("inf"), **vars(self)}

    def snapshot(self) -> dict[str, Any]:
        """Everything that a call could have changed, seen and unseen: forces that wait and masses are in the rows."""
        world, store = self.world, self.world._store
        return {
            "hash": world.state_hash(),
            "bodies": [(b.name, b.index, b.shape, b.material, b.mobility, b.mass) for b in world],
            "rows": store.bodies[: store.n].tobytes(),
            "kinds": store.kinds[: store.n].tobytes(),
            "gravity": world.gravity.tolist(),
            "constants": (world.dt, world.solver, world.steps, world.time, world.micro_literal),
            "materials": world.materials.copy(),
            "version": world.materials.version,
            "energy": world.energy(),
            "contacts": world.contacts().tobytes(),
            "report": world.report(),
            "materials in use": list(world._material_names),
        }


def is_one_sentence(text: str) -> bool:
    """Ends with a full stop, has no other one that ends a sentence, and no line break."""
    return text.endswith(".") and not re.search(r"\.\s+[A-Z]|\n", text) and len(text) < 400


# --- the table --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", ROWS, ids=[row.call for row in ROWS])
def test_bad_input_gets_its_sentence_and_changes_nothing(row: Row) -> None:
    scene, untouched = Scene(), Scene()
    before = scene.snapshot()
    with pytest.raises(StictionError) as refusal:
        exec(row.call, scene.names())
    text = str(refusal.value)
    assert type(refusal.value) is row.error
    if isinstance(row.sentence, str):
        assert text == row.sentence
    else:
        assert row.sentence.search(text), text
    assert is_one_sentence(text), text
    assert scene.snapshot() == before
    scene.world.step(2)
    untouched.world.step(2)
    assert scene.world.state_hash() == untouched.world.state_hash()


def test_the_table_is_long_enough_and_says_nothing_twice() -> None:
    assert len(ROWS) >= 45
    assert len({row.call for row in ROWS}) == len(ROWS)


ALLOWED = [
    "world.step()",
    "world.gravity = (0, 0, -1)",
    "world.add(st.Sphere(1))",
    "world.add(st.Plane(), static=True, material='ice')",
    "world.materials.set_pair('wood', 'ice', static=0.3)",
    "world.materials.add_material('felt')",
    "floor.position = (0, 0, -1)",
    "crate.velocity = (0, 0, 0)",
    "crate.surface_velocity = (1, 0, 0)",
    "crate.mass = 3",
    "crate.inertia = (1, 1, 1)",
    "crate.apply_force((1, 0, 0))",
    "crate.apply_torque((1, 0, 0))",
    "crate.apply_impulse((1, 0, 0))",
]


def test_a_scene_is_changed_by_what_is_allowed() -> None:
    """So that the comparison above can fail."""
    for call in ALLOWED:
        scene = Scene()
        before = scene.snapshot()
        exec(call, scene.names())
        assert scene.snapshot() != before, call


def test_errors_can_be_caught_as_what_they_are_elsewhere() -> None:
    """A ValueError is a ValueError, also for code that does not know this package."""
    for error, base in (
        (InvalidInputError, ValueError),
        (NotYetError, NotImplementedError),
        (SimulationError, RuntimeError),
        (st.OutputError, OSError),
    ):
        assert issubclass(error, base)
        assert issubclass(error, StictionError)


@pytest.mark.parametrize("size", [1e200, 1e-11, 1e-200])
def test_a_direction_of_extreme_length_is_refused_or_normalised(size: float) -> None:
    """Its square may be infinite or zero, but it never becomes the zero vector."""
    world = st.World()
    for make, wanted in (
        (lambda: world.add(st.Sphere(1), orientation=(size, 0, 0, 0)).orientation, (1, 0, 0, 0)),
        (lambda: st.Plane((0, 0, size)).normal, (0, 0, 1)),
    ):
        try:
            found = make()
        except InvalidInputError as refusal:
            assert is_one_sentence(str(refusal))
        else:
            np.testing.assert_allclose(found, wanted)


@pytest.mark.parametrize(
    "setting",
    [
        "crate.material = 'ice'",
        "crate.name = 'box'",
        "crate.index = 0",
        "crate.shape = st.Sphere(1)",
        "world.solver = 'soft'",
        "world.micro_literal = True",
        "world.materials = {}",
    ],
)
def test_what_cannot_be_set_cannot_be_set_without_effect(setting: str) -> None:
    """A name that takes a value and ignores it would be worse than an error."""
    scene = Scene()
    before = scene.snapshot()
    with pytest.raises((AttributeError, InvalidInputError, NotYetError)):
        exec(setting, scene.names())
    assert scene.snapshot() == before


def test_dynamic_above_static_friction_is_allowed_with_a_warning_that_names_the_pair() -> None:
    scene = Scene()
    with pytest.warns(st.MaterialWarning) as said:
        scene.world.materials.set_pair("wood", "concrete", static=0.2, dynamic=0.3)
    (warning,) = said
    assert str(warning.message) == (
        "dynamic friction of wood - concrete should be at most its static friction 0.2, got 0.3."
    )
    assert warning.filename == __file__
    scene.world.step()


# --- a world that blows up --------------------------------------------------------------------------------------------

EXPLOSIONS = [
    "crate.velocity = (1e308, 0, 0)",
    "crate.velocity = (0, 0, -1e308)",
    "crate.velocity = (1e160, 1e160, 0)",
    "crate.angular_velocity = (1e308, 0, 0)",
    "crate.angular_velocity = (1e160, 1e160, 1e160)",
    "crate.apply_force((1e308, 0, 1e308))",
    "crate.apply_torque((1e308, 0, 1e308))",
    "world.gravity = (0, 0, -1e308)",
]


both = pytest.mark.parametrize("solver", ["soft", "micro"])


@both
@pytest.mark.parametrize("cause", EXPLOSIONS)
def test_a_world_that_blows_up_says_where_and_goes_back(cause: str, solver: str) -> None:
    scene = Scene(solver)
    world = scene.world
    exec(cause, scene.names())
    kept: list[Any] = []
    with pytest.raises(SimulationError) as failure:
        for _ in range(50):
            kept = [a.copy() for a in (world.positions, world.orientations, world.velocities, world.angular_velocities)]
            ledger = world._store.ledger.copy()
            steps = world.steps
            world.step()
    error = failure.value
    assert error.step == steps + 1
    assert error.body == "crate"
    assert str(error).startswith(f"step {error.step}: the state of body 'crate' is no longer finite; ")
    assert is_one_sentence(str(error))
    assert set(error.state) == {"position", "orientation", "velocity", "angular_velocity"}
    for value in error.state.values():
        assert np.isfinite(value).all()

    # all bodies are back at the state before that step, and so are the clock and the ledger
    assert world.steps == steps
    now = (world.positions, world.orientations, world.velocities, world.angular_velocities)
    for before, after in zip(kept, now, strict=True):
        np.testing.assert_array_equal(after, before)
    for name, value in error.state.items():
        np.testing.assert_array_equal(getattr(scene.crate, name), value)
    sums = slice(0, 5)  # friction, rolling, impacts, work, numerical
    np.testing.assert_array_equal(world._store.ledger[sums], ledger[sums])
    assert np.isfinite([body.friction_work for body in world]).all()


@both
@pytest.mark.parametrize("cause", ["crate.apply_force((1e308, 0, 1e308))", "crate.velocity = (1e308, 0, 0)"])
def test_after_a_blow_up_the_world_can_be_mended_and_goes_on(cause: str, solver: str) -> None:
    scene = Scene(solver)
    world = scene.world
    exec(cause, scene.names())
    with pytest.raises(SimulationError):
        world.step()
    scene.crate.velocity = (1, 0, 0)
    world.step(30)
    energy = world.energy()
    assert np.isfinite(energy).all()
    assert scene.crate.velocity[0] < 1.0
    assert np.isfinite(scene.crate.friction_work)


@both
def test_a_blow_up_in_the_middle_of_many_steps_names_its_step(solver: str) -> None:
    """What was done before it stays done."""
    one, many = Scene(solver), Scene(solver)
    for scene in (one, many):
        scene.world.gravity = (0, 0, 1e300)
        scene.crate.velocity = (0, 0, 0)
    with pytest.raises(SimulationError) as failure:
        many.world.step(1_000_000)
    assert failure.value.step == many.world.steps + 1
    if many.world.steps > 3:
        one.world.step(many.world.steps - 3)
    with pytest.raises(SimulationError) as again:
        one.world.step()
    assert again.value.step == failure.value.step
    for name, value in failure.value.state.items():
        np.testing.assert_array_equal(again.value.state[name], value)


@both
def test_nan_written_into_the_arrays_is_found_in_the_next_step(solver: str) -> None:
    """The arrays are views, so nothing can refuse it earlier; what is reported is finite all the same."""
    scene = Scene(solver)
    scene.world.positions[scene.crate.index, 0] = float("nan")
    with pytest.raises(SimulationError, match="the state of body 'crate' is no longer finite") as failure:
        scene.world.step()
    assert failure.value.body == "crate"
    assert failure.value.step == 4
    assert np.isfinite(failure.value.state["position"]).all()


@both
def test_a_healthy_body_beside_a_broken_one_is_not_blamed(solver: str) -> None:
    world = st.World(solver=solver)
    world.add(st.Plane(), static=True)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5), name="healthy")
    world.add(st.Sphere(0.5), position=(5, 0, 0.5), velocity=(1e308, 0, 0), name="broken")
    with pytest.raises(SimulationError) as failure:
        world.step()
    assert failure.value.body == "broken"


# --- the page ---------------------------------------------------------------------------------------------------------

INTRODUCTION = """\
# Bad input

What stiction is given is checked where it is given, at once. What it cannot use it refuses with one sentence that names
the parameter, the value and what is allowed, and nothing has changed: no body is half added, no force half applied.

Below, `world` is a world with three bodies: `floor` (static), `crate` (dynamic) and `pusher` (kinematic); `stranger`
belongs to another world. All of these raise `InvalidInputError`, which is a `ValueError`, unless another error is
named.
This page is written from the table in `tests/test_bad_input.py`, which tries every row.
"""

ENDING = """
## What only shows while it runs

A world that blows up raises `SimulationError` (a `RuntimeError`) with the number of the `step`, the name of the `body`
whose state is no longer finite, and the last finite `state` of it. The world is back at that state, so it can be looked
at, mended and run on.

Dynamic friction above static friction is legal but unphysical, so it is a `MaterialWarning` that names the pair. A
solver that stops at its iteration limit says so once in an `IterationLimitWarning`; `world.report()` counts how often.
"""


def page() -> str:
    """The page: every row whose sentence is given word for word."""
    lines = [INTRODUCTION]
    for heading, rows in TABLE.items():
        error = {row.error.__name__ for row in rows}
        (name,) = error
        lines.append(f"## {heading}\n")
        if name != "InvalidInputError":
            lines.append(f"These raise `{name}`.\n")
        lines.append("| you write | stiction says |\n| --- | --- |")
        lines += [f"| `{row.call}` | {row.sentence} |" for row in rows if isinstance(row.sentence, str)]
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n" + ENDING


def test_the_page_in_the_documentation_is_that_of_the_table() -> None:
    if os.environ.get(REGENERATE):
        PAGE.write_text(page(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == page(), f"write it anew with {REGENERATE}=1"


def test_no_sentence_breaks_the_table_of_the_page() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for row in ROWS:
            compile(row.call, "row", "exec")
            assert "|" not in row.call
            assert not isinstance(row.sentence, str) or "|" not in row.sentence
