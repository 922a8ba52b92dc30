"""What does not change about a body, as plain data for a file and back."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from stiction.body import Body
from stiction.record.frames import BodyInfo
from stiction.scene.model import ShapeTable
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere

_SHAPES: TypeAdapter[Any] = TypeAdapter(ShapeTable)


def shape_to_dict(shape: Shape) -> dict[str, Any]:
    """A shape as a scene file writes it."""
    match shape:
        case Sphere():
            return {"type": "sphere", "radius": shape.radius}
        case Box():
            return {"type": "box", "size": list(shape.size)}
        case Plane():
            return {"type": "plane", "normal": list(shape.normal), "offset": shape.offset}
        case Capsule() | Cylinder():
            return {"type": shape.kind, "radius": shape.radius, "length": shape.length}
        case Ellipsoid():
            return {"type": "ellipsoid", "half_extents": list(shape.half_extents)}
        case ConvexHull():
            return {"type": "hull", "points": shape.points.tolist()}
    raise TypeError(f"no file form of {type(shape).__name__}")


def shape_from_dict(data: dict[str, Any]) -> Shape:
    """The shape that :func:`shape_to_dict` wrote; ValueError for anything else."""
    shape: Shape = _SHAPES.validate_python(data).build()
    return shape


def info_of(body: Body) -> BodyInfo:
    """What does not change about a body."""
    return BodyInfo(body.name, body.shape, body.material, body.mass, body.mobility != "dynamic")


def info_to_dict(info: BodyInfo) -> dict[str, Any]:
    """A body as plain data; the infinite mass of a fixed one is left out, for JSON knows no such number."""
    data = {"name": info.name, "shape": shape_to_dict(info.shape), "material": info.material, "fixed": info.fixed}
    return data if info.fixed else {**data, "mass": info.mass}


def info_from_dict(data: dict[str, Any]) -> BodyInfo:
    """The body that :func:`info_to_dict` wrote; KeyError or ValueError for anything else."""
    mass = float("inf") if data["fixed"] else float(data["mass"])
    return BodyInfo(data["name"], shape_from_dict(data["shape"]), data["material"], mass, bool(data["fixed"]))
