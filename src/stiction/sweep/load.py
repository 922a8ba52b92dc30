"""From a sweep's file to a sweep whose every key and expression has been checked against its scene."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stiction.checks import nearest
from stiction.errors import InvalidInputError, StictionWarning
from stiction.scene import Scene
from stiction.scene import load as load_scene
from stiction.scene.load import SUFFIX, is_path, names_in, parse, read_text, text_in
from stiction.scene.model import SceneTable
from stiction.scene.origin import Origin, naming_lines
from stiction.scene.overrides import apply_overrides, apply_values
from stiction.scene.placing import place
from stiction.scene.validate import validate_as
from stiction.sweep.expressions import Expression
from stiction.sweep.measures import MEASURES, NEEDS_CONTACTS, OF_BODY
from stiction.sweep.points import Points, base_key
from stiction.sweep.runner import Job
from stiction.sweep.spec import DRAWN, ParameterTable, SweepTable, grid_values

RUN_NAMES = ("time", "dt", "g")
"""Names that stand for something of the run itself."""


class Sweep:
    """A sweep: a scene, its points, and the job that each of them is put through.

    Args:
        table: the checked contents of a sweep's file.
        scene: the scene, before any parameter is set in it.
        name: of the sweep.

    Attributes:
        points: all its points. job: what a worker needs beside a point.

    Raises:
        InvalidInputError: a key leads nowhere, or an expression uses what is not there.
    """

    def __init__(self, table: SweepTable, scene: SceneTable, name: str) -> None:
        self.table = table
        self.name = name
        if table.duration is not None:
            scene = scene.model_copy(update={"duration": table.duration})
        self.scene = scene
        expressions = _check_expressions(table, scene)
        contacts = any(expression.calls & NEEDS_CONTACTS for expression in expressions)
        self.job = Job(
            scene=scene.model_dump(mode="json", by_alias=True, exclude_none=True),
            keys={parameter.column: parameter.key for parameter in table.parameters},
            derived={entry.key: entry.value for entry in table.derived},
            metrics={metric.name: metric.value for metric in table.metrics},
            every=table.every,
            contacts=contacts,
        )
        self.points = Points(table, base_key(self.job.deciding()))
        _check_keys(self)

    def __repr__(self) -> str:
        return f"<Sweep {self.name!r}: {len(self.points)} runs>"

    @property
    def title(self) -> str:
        """A few words."""
        return self.table.title


def builtin_names() -> list[str]:
    """Names of the built-in sweeps in alphabetical order."""
    return names_in("stiction.sweep")


def builtin_text(name: str) -> str:
    """The file of a built-in sweep, comments included.

    Raises:
        InvalidInputError: there is none of that name; the nearest one is named.
    """
    return text_in("stiction.sweep", "sweep", name)


def load(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Sweep:
    """A built-in sweep by its name, or the sweep in a file.

    Args:
        name_or_path: what ends in ``.toml`` or contains a slash is a path.
        overrides: changes of the scene such as ``world.dt=0.01``, made before the parameters are set.

    Raises:
        InvalidInputError: no such sweep, a syntax error (with its line), a key that is not known (with the nearest one
            that is), a parameter whose key leads nowhere in the scene, or an expression that cannot be.
    """
    text = str(name_or_path)
    if is_path(name_or_path):
        origin = Origin(text, read_text(Path(text), "sweep file"))
        data = parse(origin.text, text)
        with naming_lines(None if overrides else origin):
            return from_dict(data, Path(text).stem, Path(text).parent, overrides)
    return from_dict(parse(builtin_text(text), text + SUFFIX), text, Path(), overrides)


def from_dict(data: Any, name: str = "sweep", folder: Path | None = None, overrides: Sequence[str] = ()) -> Sweep:
    """The sweep that plain data describe.

    Args:
        data: what a file holds.
        name: of the sweep.
        folder: from where the path of a scene file counts; the working folder if left out.
        overrides: as in :func:`load`.

    Raises:
        InvalidInputError: as in :func:`load`.
    """
    if not isinstance(data, dict):
        raise InvalidInputError(f"a sweep must be a table of keys and values, got {data!r}.")
    table = validate_as(SweepTable, data, "the sweep")
    if isinstance(table.scene, dict):
        try:
            scene = Scene.from_dict({"title": table.title, "expect": table.title, **table.scene}, name)
        except InvalidInputError as error:
            raise InvalidInputError(f"scene.{error}") from None
    else:
        near = (folder or Path()) / table.scene
        scene = load_scene(near if is_path(table.scene) else table.scene)
    return Sweep(table, apply_overrides(scene.table, overrides), name)


def json_schema() -> dict[str, Any]:
    """The JSON schema of sweep files, for editors."""
    schema = SweepTable.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "stiction sweep"}


def _check_expressions(table: SweepTable, scene: SceneTable) -> list[Expression]:
    """Every expression uses names, functions and bodies that are there; those of the metrics are returned."""
    parameters = [parameter.column for parameter in table.parameters]
    bodies = [placed.name for placed in place(scene)]
    for number, entry in enumerate(table.derived):
        Expression(entry.value, f"derived[{number}].value").require(parameters)
    found: list[Expression] = []
    before: list[str] = []
    for number, metric in enumerate(table.metrics):
        expression = Expression(metric.value, f"metrics[{number}].value")
        expression.require([*parameters, *RUN_NAMES, *before], MEASURES)
        for call, body in expression.arguments_of(OF_BODY):
            if body is not None and body not in bodies:
                raise InvalidInputError(
                    f"{expression.where}: {call} needs a body of the scene, got {body!r}{nearest(body, bodies)}."
                )
        found.append(expression)
        before.append(metric.name)
    if table.map is not None:
        drawable = [p.column for p in table.parameters if _is_number(p)]
        for axis in ("x", "y"):
            name = getattr(table.map, axis)
            if name not in drawable:
                raise InvalidInputError(
                    f"map.{axis}: must be a parameter with numbers, got {name!r}; they are {', '.join(drawable)}."
                )
        if table.map.x == table.map.y:
            raise InvalidInputError(f"map.y: must not be the parameter of map.x, got {table.map.y!r} for both.")
        for number, outcome in enumerate(table.map.classes):
            Expression(outcome.when, f"map.classes[{number}].when").require([*parameters, *before])
            if outcome.expected is not None:
                where = f"map.classes[{number}].expected"
                Expression(outcome.expected, where).require([table.map.x, table.map.y])
    return found


def _is_number(parameter: ParameterTable) -> bool:
    return parameter.axis in DRAWN or isinstance(grid_values(parameter)[0], float | int)


def _check_keys(sweep: Sweep) -> None:
    """Each parameter can be set in the scene at both of its ends; what lies between is found out in its run."""
    ends = (sweep.points[0], sweep.points[len(sweep.points) - 1])
    for number, parameter in enumerate(sweep.table.parameters):
        for point in ends:
            _try(sweep.scene, {parameter.key: point.values[parameter.column]}, f"parameters[{number}]")
    for number, key in enumerate(sweep.job.derived):
        values = {key: float(Expression(sweep.job.derived[key], f"derived[{number}].value").evaluate(ends[0].values))}
        _try(sweep.scene, values, f"derived[{number}]")


def _try(scene: SceneTable, values: dict[str, Any], where: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StictionWarning)
        try:
            Scene(apply_values(scene, values))
        except InvalidInputError as error:
            raise InvalidInputError(f"{where}: {error}") from None
