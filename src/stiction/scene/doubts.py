"""What a scene may well hold, but its author may not have meant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stiction.materials import MaterialTable
from stiction.scene.model import SceneTable
from stiction.scene.placing import place
from stiction.scene.positions import Location
from stiction.scene.simulation import Simulation
from stiction.shapes import Plane

Array = NDArray[np.float64]
Doubt = tuple[Location, str]

LARGE_DT = 1.0 / 30.0
"""s above which a step is called large."""
MANY_STEPS = 1_000_000
DEEP = 0.05
"""Overlaps deeper than this part of the thinner body are deep."""
MOST_BODIES = 1000
"""Of a scene whose overlaps are looked for: the kernels run as plain Python here, for nothing must be compiled."""
MOST_PAIRS = 5000


def doubts(simulation: Simulation) -> list[Doubt]:
    """Warnings about a scene: the path of a key, and a sentence.

    Args:
        simulation: of the scene, at time 0. It is left as it is.
    """
    table, materials = simulation.scene.table, simulation.world.materials
    return [
        *_of_time(table, simulation.total_steps),
        *_of_names(table),
        *_of_pairs(table, materials),
        *_of_guessed_pairs(simulation),
        *_of_overlaps(simulation),
    ]


def _of_time(table: SceneTable, steps: int) -> Iterator[Doubt]:
    if table.world.dt > LARGE_DT:
        yield ("world", "dt"), f"is large: fast or small bodies need 1/60 s or less, got {table.world.dt:g} s."
    if steps > MANY_STEPS:
        yield ("duration",), f"takes {steps} steps of {table.world.dt:g} s."
    for number, push in enumerate(table.pushes):
        if push.start >= table.duration:
            yield (
                ("pushes", number, "from"),
                f"is not before the end of the scene, {table.duration:g} s, got {push.start:g} s: nothing is pushed.",
            )
    for number, change in enumerate(table.velocity_changes):
        if change.time >= table.duration:
            yield (
                ("velocity_changes", number, "time"),
                f"is not before the end of the scene, {table.duration:g} s, got {change.time:g} s: nothing changes.",
            )


def _of_names(table: SceneTable) -> Iterator[Doubt]:
    if table.bodies and all(body.static for body in table.bodies):
        yield ("bodies",), "are all static: nothing can move."
    if not table.bodies:
        yield (), "the scene has no bodies."
    used = {body.frame for body in table.bodies} | {push.frame for push in table.pushes}
    used |= {spring.frame for spring in table.springs} | {change.frame for change in table.velocity_changes}
    for name in table.frames:
        if name not in used:
            yield ("frames", name), "is a frame that nothing is placed in."


def _of_pairs(table: SceneTable, materials: MaterialTable) -> Iterator[Doubt]:
    here = {body.material for body in table.bodies} | {vehicle.tyre for vehicle in table.vehicles}
    for number, row in enumerate(table.materials.pairs):
        pair = materials.pair(row.a, row.b)
        if pair.dynamic > pair.static:
            yield (
                ("materials", "pairs", number),
                f"has dynamic friction {pair.dynamic:g} above static friction {pair.static:g}, which is unphysical.",
            )
        for key in ("a", "b"):
            name = getattr(row, key)
            if name not in here:
                yield ("materials", "pairs", number, key), f"is {name!r}, a material that no body of the scene has."


def _of_guessed_pairs(simulation: Simulation) -> Iterator[Doubt]:
    """Pairs of materials without coefficients of their own, of bodies that are likely to meet."""
    table, materials = simulation.scene.table, simulation.world.materials
    told: set[frozenset[str]] = set()
    for first, second in _likely_to_meet(simulation):
        a, b = (table.bodies[entry].material for entry in (first, second))
        if materials.is_set(a, b) or frozenset((a, b)) in told:
            continue
        told.add(frozenset((a, b)))
        guess = materials.pair(a, b)
        yield (
            ("bodies", second, "material"),
            f"meets {a!r} of body {table.bodies[first].name!r}, and the pair {a} - {b} has no coefficients of its own: "
            f"static {guess.static:.3g} and dynamic {guess.dynamic:.3g} are guessed.",
        )


def _likely_to_meet(simulation: Simulation) -> Iterator[tuple[int, int]]:
    """Entries (i <= j) of which one is dynamic, whose boxes overlap on their way: straight on, and falling freely."""
    table, world = simulation.scene.table, simulation.world
    shapes = [body.shape for body in world]
    entries = [placed.entry for placed in place(table)]
    if not entries:
        return
    time = table.duration
    low, high = _bounds(simulation)
    fall = np.where([[body.mobility == "dynamic"] for body in world], 0.5 * world.gravity * time**2, 0.0)
    way = world.velocities * time
    low = low + np.minimum(way, 0.0) + np.minimum(fall, 0.0)
    high = high + np.maximum(way, 0.0) + np.maximum(fall, 0.0)
    lows: dict[int, Array] = {}
    highs: dict[int, Array] = {}
    for index, entry in enumerate(entries):
        lows[entry] = np.minimum(lows.get(entry, low[index]), low[index])
        highs[entry] = np.maximum(highs.get(entry, high[index]), high[index])
    planes = {entries[body.index]: body for body in world if isinstance(shapes[body.index], Plane)}
    counts = np.bincount(entries, minlength=len(table.bodies))
    numbers = range(len(table.bodies))
    for i in numbers:
        for j in numbers[i:]:
            still = all(table.bodies[k].static or table.bodies[k].kinematic for k in (i, j))
            if still or (i == j and counts[i] < 2) or (i in planes and j in planes):
                continue
            if (lows[i] <= highs[j]).all() and (lows[j] <= highs[i]).all():
                yield i, j


def _bounds(simulation: Simulation) -> tuple[Array, Array]:
    """Lowest and highest corners (n, 3) of the boxes around bodies; those of planes have no end, m."""
    from stiction.core.broadphase import update_bounds
    from stiction.core.state import BOUNDS

    world, store = simulation.world, simulation.world._store
    bodies = store.bodies.copy()
    update_bounds(bodies, store.kinds, len(world), 0.0, 0.0)
    low, high = bodies[: len(world), BOUNDS : BOUNDS + 3].copy(), bodies[: len(world), BOUNDS + 3 : BOUNDS + 6].copy()
    planes = [body.index for body in world if isinstance(body.shape, Plane)]
    low[planes], high[planes] = -np.inf, np.inf
    for body in world:
        if isinstance(body.shape, Plane):
            up = int(np.argmax(np.abs(body.shape.normal)))
            if body.shape.normal[up] == 1.0:  # a floor: nothing above it meets it before it gets there
                high[body.index, up] = body.shape.offset + body.position[up]
    return low, high


def _of_overlaps(simulation: Simulation) -> Iterator[Doubt]:
    """Bodies that begin deep in one another."""
    from stiction.core import state
    from stiction.core.broadphase import find_pairs, update_bounds
    from stiction.core.collide.narrow import pair_contacts
    from stiction.core.vec import Vec3

    world = simulation.world
    n, store = len(world), world._store
    if not 1 < n <= MOST_BODIES:
        return
    bodies, kinds = store.bodies.copy(), store.kinds
    update_bounds(bodies, kinds, n, 0.0, 0.0)
    pairs = np.zeros((MOST_PAIRS, 2), np.int64)
    count = min(find_pairs(bodies, kinds, n, np.arange(n), pairs), MOST_PAIRS)
    contacts, tags = state.make_contacts(16)
    points = np.zeros((state.SCRATCH, 5))
    nowhere = Vec3(0.0, 0.0, 0.0)
    deepest: dict[tuple[int, int], tuple[float, int, int]] = {}
    entries = [placed.entry for placed in place(simulation.scene.table)]
    for a, b in pairs[:count].tolist():
        found, _, _ = pair_contacts(
            bodies, kinds, a, b, 0.0, nowhere, contacts, tags, 0, points, 1, store.hulls.arrays
        )  # fmt: skip
        if found == 0:
            continue
        depth = -float(contacts[:found, state.SEPARATION].min())
        thin = min(_thickness(bodies, index, state.BOUNDS) for index in (a, b) if kinds[index, 0] != state.PLANE)
        key = (entries[a], entries[b])
        if depth > DEEP * thin and depth > deepest.get(key, (0.0, 0, 0))[0]:
            deepest[key] = depth, a, b
    names = [body.name for body in world]
    for depth, a, b in deepest.values():
        later, other = (a, b) if entries[a] > entries[b] else (b, a)
        yield (
            ("bodies", entries[later], "position"),
            f"puts {names[later]!r} {depth:.3g} m deep into {names[other]!r}: it will be pushed out.",
        )


def _thickness(bodies: Array, index: int, bounds: int) -> float:
    return float((bodies[index, bounds + 3 : bounds + 6] - bodies[index, bounds : bounds + 3]).min())
