"""Snapshots: everything from which a world goes on to the last bit, its memory of contacts included, as plain arrays.

A snapshot is a dictionary of arrays. It fits the version of stiction that took it: the rows of :mod:`stiction.core`
are kept as they are.
"""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.core import pairs
from stiction.errors import InvalidInputError
from stiction.hulls import HullTable
from stiction.shapes import ConvexHull
from stiction.soft_store import BY_SLOT
from stiction.world import World

Snapshot = dict[str, NDArray[Any]]

SCRATCH = {
    "contacts", "tags", "points", "cache.begun", "cache.ended", "soft.blocks", "soft.members", "soft.rows", "soft.aux",
    "soft.pose", "desk.looked", "desk.active", "desk.lists", "desk.normals", "desk.ordered", "desk.pieces",
    "desk.sizes", "desk.notes", "desk.failed", "desk.contacts", "desk.tags", "desk.points",
}  # fmt: skip
"""Arrays that a step fills before it reads them: of these a snapshot keeps the shape alone. The rows of contact points
are so in the soft solver only, which has manifolds besides; ``micro`` has nothing else to answer with."""
NOT_KEPT = {
    "crew", "dtype", "_one", "rigid", "_table", "_written", "_needs", "_parts", "_edited", "_tree_is_fresh",
    "_outcome", "cycles", "seconds", "hulls",
}  # fmt: skip
"""Attributes of a store that follow from the others, or from the settings and materials of its world."""
ACROSS = {"scratch.bodies", "desk.lists", "cache.lists"}
"""Matrices that have bodies in their columns; the others have them, or pairs, or contacts, in their rows."""
LISTS = {"cache.pairs": pairs.PAIRS, "cache.free": pairs.FREE}
"""Lists with the entry of ``cache.counts`` that says how many of their rows are in use."""
WORLD = "world"
"""The entry with what the world keeps beside its store, JSON."""
HULLS = "hulls/"
"""Beginning of the names of the points of hulls, in the order of their table."""


def take(world: World) -> Snapshot:
    """A snapshot of a world as it is now, between two steps."""
    result: Snapshot = {}
    scratch = _scratch(world)
    for name, value in vars(world._store).items():
        if name in NOT_KEPT:
            continue
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            for field in value._fields:
                result[f"{name}.{field}"] = _kept(getattr(value, field), f"{name}.{field}" in scratch)
        elif isinstance(value, np.ndarray):
            result[name] = _kept(value, name in scratch)
        elif isinstance(value, (bool, int, np.integer)):
            result[name] = np.array(int(value), np.int64)
        else:
            raise TypeError(f"a snapshot knows no attribute {name!r} of {type(world._store).__name__}")
    for number, points in enumerate(world._store.hulls.points()):
        result[f"{HULLS}{number}"] = points
    _forget_what_is_free(result)
    beside = {
        "material_names": world._material_names,
        "added": world._added,
        "gravity": world._gravity.tolist(),
        "warned": world._warned,
    }
    result[WORLD] = np.frombuffer(json.dumps(beside).encode(), np.uint8)
    return result


def put(world: World, snapshot: Snapshot) -> None:
    """Bring a world that has the same bodies, and was made with the same settings, to the state of a snapshot.

    Raises:
        InvalidInputError: it does not fit the world; nothing has been changed.
    """
    store, scratch = world._store, _scratch(world)
    made: dict[str, Any] = {}
    if int(snapshot.get("n", np.array(-1))) != len(world):
        raise InvalidInputError(f"snapshot must be one of {len(world)} bodies, got {snapshot.get('n')}.")
    for name, value in vars(store).items():
        if name in NOT_KEPT:
            continue
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            parts = {
                field: _array(snapshot, f"{name}.{field}", getattr(value, field), scratch) for field in value._fields
            }
            made[name] = type(value)(**parts)
        elif isinstance(value, np.ndarray):
            made[name] = _array(snapshot, name, value, scratch)
        else:
            made[name] = type(value)(_entry(snapshot, name)[()])
    beside = json.loads(_entry(snapshot, WORLD).tobytes())
    hulls = HullTable()
    for number in range(sum(name.startswith(HULLS) for name in snapshot)):
        hulls.add(ConvexHull(_entry(snapshot, f"{HULLS}{number}")))

    vars(store).update(made)
    store.hulls = hulls
    store.replaced()
    world._material_names = list(beside["material_names"])
    world._table_of = None
    world._added, world._warned = beside["added"], beside["warned"]
    world._gravity = np.array(beside["gravity"])
    world._settings = world._make_settings()
    world._events = None


def copy_of(world: World) -> World:
    """A world of its own that goes on from here to the last bit, with a table of materials of its own.

    Events, recordings and views stay with the old one.
    """
    other = World(**settings_of(world), materials=copy.deepcopy(world.materials))
    for body in world:
        other.add(
            body.shape,
            static=body.mobility == "static",
            kinematic=body.mobility == "kinematic",
            material=body.material,
            name=body.name,
        )
    put(other, take(world))
    return other


def settings_of(world: World) -> dict[str, Any]:
    """The arguments, besides ``materials``, with which a world like this one is made; plain values for a file."""
    store: Any = world._store
    soft = hasattr(store, "crew")
    settings: dict[str, Any] = {
        "gravity": world._gravity.tolist(),
        "dt": world.dt,
        "solver": world.solver,
        "substeps": world._substeps,
        "iterations": world._iterations,
        "precision": "single" if soft and store.dtype is np.float32 else "double",
        "micro_literal": world.micro_literal,
        "restitution_threshold": world._threshold,
        "sleeping": world._sleeping,
        "threads": store.crew.threads if soft else 1,
    }
    return settings | ({"tolerance": world._tolerance} if world.solver == "exact" else {})


def _scratch(world: World) -> set[str]:
    return SCRATCH - {"contacts", "tags"} if world.solver == "micro" else SCRATCH


def _kept(array: NDArray[Any], shape_alone: bool) -> NDArray[Any]:
    return np.array(array.shape, np.int64) if shape_alone else array.copy()


def _forget_what_is_free(snapshot: Snapshot) -> None:
    """Zeros for rows that nobody will read: in a heap that is stirred they are half of all, and would take as much
    place."""
    if "cache.counts" not in snapshot:
        return
    counts = snapshot["cache.counts"]
    for name, count in LISTS.items():
        snapshot[name][counts[count] :] = 0
    free = snapshot["cache.free"][: counts[pairs.FREE]] + 1
    for name in BY_SLOT:
        snapshot[f"soft.{name}"][free] = 0


def _entry(snapshot: Snapshot, name: str) -> NDArray[Any]:
    if name not in snapshot:
        raise InvalidInputError(f"snapshot must have {name!r}: it was taken by another version of stiction.")
    return snapshot[name]


def _array(snapshot: Snapshot, name: str, like: NDArray[Any], scratch: set[str]) -> NDArray[Any]:
    """An array of the snapshot, if it has the type and the columns of the one that the world has."""
    value = _entry(snapshot, name)
    shape = tuple(value.tolist()) if name in scratch else value.shape
    fits = len(shape) == like.ndim and (name in scratch or value.dtype == like.dtype)
    if fits and like.ndim == 2:
        axis = 0 if name in ACROSS else 1
        fits = shape[axis] == like.shape[axis]
    if not fits:
        raise InvalidInputError(f"snapshot must fit this version of stiction, and its {name!r} does not.")
    return np.zeros(shape, like.dtype) if name in scratch else value.copy()
