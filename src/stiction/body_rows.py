"""From the arguments of :meth:`stiction.World.add` to the columns of a body's row: the checks, and the numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.body import checked_inertia
from stiction.core import state
from stiction.errors import InvalidInputError
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere

if TYPE_CHECKING:
    from stiction.hulls import HullTable

Array = NDArray[np.float64]

DEFAULT_DENSITY = 1000.0
"""kg/m^3, of a body that is given neither mass nor density."""


def code_and_size(shape: Shape, hulls: HullTable) -> tuple[int, Array]:
    """How core names the shape, and its four numbers of SIZE."""
    match shape:
        case Sphere():
            return state.SPHERE, np.array((shape.radius, 0.0, 0.0, 0.0))
        case Plane():
            return state.PLANE, np.array((*shape.normal, shape.offset))
        case Capsule():
            return state.CAPSULE, np.array((shape.radius, shape.radius, 0.5 * shape.length + shape.radius, 0.0))
        case Cylinder():
            return state.CYLINDER, np.array((shape.radius, shape.radius, 0.5 * shape.length, 0.0))
        case Ellipsoid():
            return state.ELLIPSOID, np.array((*shape.half_extents, 0.0))
        case ConvexHull():
            return state.HULL, np.array((*np.abs(shape.points).max(axis=0), hulls.add(shape)))
    assert isinstance(shape, Box)
    x, y, z = shape.size
    return state.BOX, np.array((0.5 * x, 0.5 * y, 0.5 * z, 0.0))


def check_mobility(shape: Any, static: Any, kinematic: Any) -> bool:
    """Whether the body is not dynamic."""
    if not isinstance(shape, Shape):
        raise InvalidInputError(f"shape must be a stiction shape such as Box((1, 1, 1)), got {shape!r}.")
    for name, value in (("static", static), ("kinematic", kinematic)):
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidInputError(f"{name} must be True or False, got {value!r}.")
    if static and kinematic:
        raise InvalidInputError("static and kinematic must not both be True.")
    if isinstance(shape, Plane) and not (static or kinematic):
        raise InvalidInputError("a Plane must be static=True or kinematic=True, for it has no finite mass.")
    if not isinstance(shape, (Sphere, Box, Plane, Capsule, Cylinder, ConvexHull, Ellipsoid)):
        raise InvalidInputError(f"shape must be one of stiction's shapes, got a {type(shape).__name__}.")
    return bool(static or kinematic)


def mass_columns(
    shape: Shape,
    fixed: bool,
    mass: float | None,
    density: float | None,
    inertia: ArrayLike | None,
    center_of_mass: ArrayLike | None = None,
) -> dict[int, Any]:
    """Columns of mass, centre of mass and inertia."""
    if mass is not None and density is not None:
        raise InvalidInputError(f"mass and density must not both be given, got {mass!r} kg and {density!r} kg/m^3.")
    if mass is not None:
        mass = checks.mass("mass", mass)
    if density is not None:
        density = checks.positive("density", density, "kg/m^3")
    if fixed:
        for name, value in (("inertia", inertia), ("center_of_mass", center_of_mass)):
            if value is not None:
                raise InvalidInputError(f"{name} must be left out for a body that is not dynamic.")
        return {}
    properties = shape.mass_properties
    center = properties.center_of_mass
    if center_of_mass is not None:
        center = checks.vector("center_of_mass", center_of_mass)
        if inertia is None:
            raise InvalidInputError(
                "inertia must be given where center_of_mass is, for that of the shape is of its own mass distribution."
            )
    if mass is not None:
        density = mass / properties.volume
    density = DEFAULT_DENSITY if density is None else density
    mass = checks.mass("mass (density times volume)", density * properties.volume) if mass is None else mass
    tensor = properties.inertia * density if inertia is None else checked_inertia("inertia", inertia)
    return {
        state.MASS: mass,
        state.INVERSE_MASS: 1.0 / mass,
        state.CENTER: center,
        state.INERTIA: tensor,
        state.INVERSE_INERTIA: np.linalg.inv(tensor),
    }
