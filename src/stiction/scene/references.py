"""What two places of a scene must agree on: names of frames, bodies and materials."""

from __future__ import annotations

from collections.abc import Iterable

from stiction.checks import nearest
from stiction.errors import InvalidInputError
from stiction.materials import MaterialTable
from stiction.scene.model import BodyTable, PushTable, SceneTable, SpringTable
from stiction.scene.placing import copies

BASES = {"default": MaterialTable.default, "lecture": MaterialTable.lecture, "empty": MaterialTable}


def make_materials(scene: SceneTable) -> MaterialTable:
    """The table of materials of a scene.

    Raises:
        InvalidInputError: a pair cannot be set.

    Warns:
        MaterialWarning: dynamic friction of a pair is above its static friction.
    """
    table = BASES[scene.materials.base]()
    for number, pair in enumerate(scene.materials.pairs):
        values = pair.model_dump(exclude={"a", "b", "source"})
        source = "scene" if pair.source is None else pair.source
        try:
            table.set_pair(pair.a, pair.b, **values, source=source)
        except InvalidInputError as error:
            raise InvalidInputError(f"materials.pairs[{number}]: {error}") from None
    return table


def check_references(scene: SceneTable, materials: MaterialTable) -> None:
    """Every name that is used exists, once, and is of the right kind.

    Raises:
        InvalidInputError: the path of the key, its value, and the nearest name that exists.
    """
    bodies: dict[str, BodyTable] = {}
    for number, body in enumerate(scene.bodies):
        where = f"bodies[{number}]"
        for name, _ in copies(body):
            if name in bodies:
                raise InvalidInputError(f"{where}.name: must be unique in a scene, got {name!r} twice.")
            bodies[name] = body
        _must_exist(f"{where}.frame", body.frame, scene.frames, "frame")
        _must_exist(f"{where}.material", body.material, materials.materials, "material")
    pulls: list[tuple[str, PushTable | SpringTable]] = [(f"pushes[{k}]", push) for k, push in enumerate(scene.pushes)]
    pulls += [(f"springs[{k}]", spring) for k, spring in enumerate(scene.springs)]
    for where, pull in pulls:
        _must_exist(f"{where}.body", pull.body, bodies, "body")
        _must_exist(f"{where}.frame", pull.frame, scene.frames, "frame")
        if bodies[pull.body].static or bodies[pull.body].kinematic:
            raise InvalidInputError(f"{where}.body: must be a dynamic body, and {pull.body!r} is not.")
    for number, change in enumerate(scene.velocity_changes):
        where = f"velocity_changes[{number}]"
        _must_exist(f"{where}.body", change.body, bodies, "body")
        _must_exist(f"{where}.frame", change.frame, scene.frames, "frame")
        if not bodies[change.body].kinematic:
            raise InvalidInputError(f"{where}.body: must be a kinematic body, and {change.body!r} is not.")
    vehicles: set[str] = set()
    for number, vehicle in enumerate(scene.vehicles):
        where = f"vehicles[{number}]"
        if vehicle.name in vehicles:
            raise InvalidInputError(f"{where}.name: must be unique in a scene, got {vehicle.name!r} twice.")
        vehicles.add(vehicle.name)
        _must_exist(f"{where}.chassis", vehicle.chassis, bodies, "body")
        _must_exist(f"{where}.tyre", vehicle.tyre, materials.materials, "material")
        if bodies[vehicle.chassis].static or bodies[vehicle.chassis].kinematic:
            raise InvalidInputError(f"{where}.chassis: must be a dynamic body, and {vehicle.chassis!r} is not.")


def _must_exist(path: str, name: str | None, known: Iterable[str], what: str) -> None:
    names = list(known)
    if name is not None and name not in names:
        raise InvalidInputError(f"{path}: must be a {what} of the scene, got {name!r}{nearest(name, names)}.")
