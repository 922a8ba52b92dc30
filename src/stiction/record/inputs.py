"""Inputs: everything that changed a world from outside, as a recording keeps it, and how it is done again.

Most are numbers that were set in the row of a body. They are kept as they were set, not as the call that set them, so
that the same bits come back whatever rounding the call did.
"""

from __future__ import annotations

import contextlib
import json
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.body import Body
from stiction.errors import InvalidInputError, MaterialWarning, SimulationError
from stiction.hashing import STATE_WIDTH
from stiction.materials import MaterialTable
from stiction.record.bodies import info_from_dict, info_of, info_to_dict
from stiction.world import World

COLUMNS = {
    "position": ("POSITION", 3),
    "orientation": ("ORIENTATION", 4),
    "velocity": ("V", 3),
    "angular velocity": ("W", 3),
    "surface velocity": ("SURFACE", 3),
    "force": ("FORCE", 3),
    "torque": ("TORQUE", 3),
    "mass": ("MASS", 1),
    "inverse mass": ("INVERSE_MASS", 1),
    "inertia": ("INERTIA", 9),
    "inverse inertia": ("INVERSE_INERTIA", 9),
}
"""Inputs that set numbers of a body: the column of its row in which they begin, and how many they are. ``force`` and
``torque`` are the sums that act in the coming step."""
VIEW, GRAVITY, TEXT, FRICTION = "state through a view", "gravity", "text", "friction from outside"
KINDS = (*COLUMNS, VIEW, GRAVITY, TEXT, FRICTION)
"""What an input is, by its number in a file. ``state through a view`` is a state of 13 numbers, written into the
world's arrays; a ``text`` is a line of ``inputs/texts``; ``friction from outside`` is what a tyre's forces took, J. New
kinds come last, since files know them by number."""
NUMBERS = {**{name: width for name, (_, width) in COLUMNS.items()}, VIEW: STATE_WIDTH, GRAVITY: 3, TEXT: 0, FRICTION: 1}
"""How many numbers go with it."""
CODES = {column: KINDS.index(name) for name, (column, _) in COLUMNS.items()}
WIDTHS_BY_CODE = np.array([NUMBERS[name] for name in KINDS], np.int64)
LISTED_KINDS = ("LAYER", "MASK")


class Input(NamedTuple):
    """One input.

    Attributes:
        step: steps taken before it.
        what: one of :data:`KINDS`.
        body: index of the body at that time, -1 for none.
        numbers: that were set.
        text: of a ``text``: plain data.
    """

    step: int
    what: str
    body: int
    numbers: NDArray[np.float64]
    text: dict[str, Any] | None


def read_inputs(rows: NDArray[Any], numbers: NDArray[np.float64], texts: bytes) -> Iterator[Input]:
    """The inputs of a file, in the order in which they came."""
    lines = iter(texts.splitlines())
    starts = np.concatenate([[0], np.cumsum(WIDTHS_BY_CODE[rows["what"]])])
    for k, (step, body, code) in enumerate(rows.tolist()):
        what = KINDS[code]
        text = json.loads(next(lines)) if what == TEXT else None
        yield Input(step, what, body, numbers[starts[k] : starts[k + 1]], text)


def apply(world: World, given: Input) -> None:
    """Do again to a world what was done to the one that was recorded.

    Raises:
        InvalidInputError: it asks for something that this version does not know.
    """
    if given.what in COLUMNS:
        world._write(given.body, COLUMNS[given.what][0], given.numbers)
    elif given.what == VIEW:
        state = world._state.POSITION
        world._store.watch()
        world._store.bodies[given.body, state : state + STATE_WIDTH] = given.numbers
    elif given.what == GRAVITY:
        world.gravity = given.numbers
    elif given.what == FRICTION:
        world._note_friction(given.body, float(given.numbers[0]))
    else:
        _apply_text(world, given.text or {})


# --- texts ------------------------------------------------------------------------------------------------------------


def added_text(world: World, body: Body) -> dict[str, Any]:
    """A body that was just added, to the last bit."""
    store: Any = world._store
    grain = store.soft.grain[body.index + 1].tolist() if hasattr(store, "soft") else None
    return {
        "what": "add",
        "body": info_to_dict(info_of(body)),
        "mobility": body.mobility,
        "sensor": body.sensor,
        "row": store.bodies[body.index].tolist(),
        "kinds": store.kinds[body.index].tolist(),
        "grain": grain,
    }


def _apply_text(world: World, text: dict[str, Any]) -> None:
    match text.get("what"):
        case "add":
            body = add_body(world, text)
            store: Any = world._store
            store.bodies[body.index] = text["row"]
            store.kinds[body.index] = text["kinds"]
            if text["grain"] is not None:
                store.soft.grain[body.index + 1] = text["grain"]
        case "remove":
            world.remove([world.bodies[index] for index in text["bodies"]])
        case "kind":
            world._write_kind(int(text["body"]), text["column"], int(text["value"]))
        case "failure":
            with contextlib.suppress(SimulationError):  # the same one as then
                world.step()
        case "materials":
            world._materials = materials_from(text["rows"])
            world._table_of = None
            world._wake_all()
        case other:
            raise InvalidInputError(f"input {other!r} of the recording is not known to this version of stiction.")


def add_body(world: World, data: dict[str, Any]) -> Body:
    """A body of the same name, shape, mobility and material; its row is then overwritten by whoever knows it."""
    info = info_from_dict(data["body"])
    return world.add(
        info.shape,
        static=data["mobility"] == "static",
        kinematic=data["mobility"] == "kinematic",
        mass=None if info.fixed else info.mass,
        material=info.material,
        name=info.name,
        sensor=data["sensor"],
    )


def materials_from(rows: list[dict[str, Any]]) -> MaterialTable:
    """A table of materials; who made it has been warned of its oddities already."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MaterialWarning)
        return MaterialTable.from_rows(rows)
