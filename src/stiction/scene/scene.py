"""Scene: a checked scene file, ready to become a world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from stiction.errors import InvalidInputError, NotYetError
from stiction.scene.model import SceneTable
from stiction.scene.origin import Origin, naming_lines
from stiction.scene.placing import place
from stiction.scene.references import check_references, make_materials
from stiction.scene.validate import validate
from stiction.shapes import Shape
from stiction.world import World


class Scene:
    """A scene: bodies, materials and what acts on them, and one sentence that says what must happen.

    Made by :func:`stiction.scene.load`, or from plain data. A scene never changes; :meth:`build` gives a new world.

    Args:
        table: the checked contents of a scene file.
        name: of the built-in scene, or of the file without its ending.
        origin: the file and the text that it comes from, for sentences that name a line.

    Raises:
        InvalidInputError: two places of the table do not agree.

    Warns:
        MaterialWarning: dynamic friction of a pair is above its static friction.
    """

    def __init__(self, table: SceneTable, name: str = "scene", origin: Origin | None = None) -> None:
        self.table = table
        self.name = name
        self.origin = origin
        self._materials = make_materials(table)
        check_references(table, self._materials)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], name: str = "scene") -> Self:
        """The scene that plain data describe, such as :meth:`to_dict` gives.

        Raises:
            InvalidInputError: one sentence that begins with the path of the key.
        """
        if not isinstance(data, Mapping):
            raise InvalidInputError(f"the scene must be a table of keys and values, got {data!r}.")
        return cls(validate(data), name)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain data for TOML or JSON: defaults written out, what is not there left out."""
        return self.table.model_dump(mode="json", by_alias=True, exclude_none=True)

    @property
    def title(self) -> str:
        """A few words."""
        return self.table.title

    @property
    def expect(self) -> str:
        """One sentence that says what must happen."""
        return self.table.expect

    @property
    def duration(self) -> float:
        """Simulated time, s."""
        return self.table.duration

    def __eq__(self, other: object) -> bool:
        """Same contents; the name does not matter."""
        return self.table == other.table if isinstance(other, Scene) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # it can change, so it must not be a key

    def __repr__(self) -> str:
        return f"<Scene {self.name!r}: {self.title}>"

    def build(self) -> World:
        """A new world with the bodies of the scene.

        Pushes and velocity changes are not part of a world: :class:`stiction.scene.Simulation` applies them.

        Raises:
            InvalidInputError: a body cannot be added.
            NotYetError: the scene asks for a solver or for the contact of a shape that this version does not have.
        """
        with naming_lines(self.origin):
            return self._build()

    def _build(self) -> World:
        settings = self.table.world
        try:
            world = World(**settings.model_dump(), materials=self._materials.copy())
        except (InvalidInputError, NotYetError) as error:
            raise type(error)(f"world: {error}") from None

        shapes: dict[int, Shape] = {}
        for placed in place(self.table):
            body = self.table.bodies[placed.entry]
            try:
                if placed.entry not in shapes:  # a thousand copies share one shape
                    shapes[placed.entry] = body.shape.build()
                world.add(
                    shapes[placed.entry],
                    static=body.static,
                    kinematic=body.kinematic,
                    position=placed.position,
                    orientation=placed.orientation,
                    velocity=placed.velocity,
                    angular_velocity=placed.angular_velocity,
                    mass=body.mass,
                    density=body.density,
                    inertia=body.inertia,
                    center_of_mass=body.center_of_mass,
                    material=body.material,
                    name=placed.name,
                    surface_velocity=body.surface_velocity,
                    grain=body.grain,
                )
            except (InvalidInputError, NotYetError) as error:
                raise type(error)(f"bodies[{placed.entry}]: {error}") from None
        return world
