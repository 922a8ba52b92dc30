"""Shapes and their mass properties. Sizes are full lengths in m, but for radii and semi-axes; the inertia tensor is
about the centre of mass.

Sources of the tensors: any mechanics text (solid bodies of uniform density); the hull is the sum of the
signed tetrahedra from the origin to each face (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia
tensor", J. Math. Stat. 1, 2005).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.errors import InvalidInputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MassProperties:
    """Volume (m^3), centre of mass (3,) in m and inertia tensor (3, 3) in m^5 of a shape of density 1, in its frame.

    The tensor is about the centre of mass. Multiply volume and tensor by the density to get kg and kg m^2.
    """

    volume: float
    center_of_mass: Array
    inertia: Array


class Shape:
    """Base class of all shapes."""

    kind: ClassVar[str] = "shape"
    bounded: ClassVar[bool] = True

    @property
    def mass_properties(self) -> MassProperties:
        """Volume, centre of mass and inertia of this shape at density 1."""
        raise NotImplementedError


def _centered(volume: float, diagonal: tuple[float, float, float]) -> MassProperties:
    return MassProperties(volume, np.zeros(3), np.diag(diagonal) * volume)


@dataclass(frozen=True, init=False)
class Sphere(Shape):
    """A solid sphere.

    Args:
        radius: in m, above 0.
    """

    radius: float
    kind: ClassVar[str] = "sphere"

    def __init__(self, radius: float) -> None:
        object.__setattr__(self, "radius", checks.length("Sphere radius", radius))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """I = 2/5 m r^2 about every axis."""
        r = self.radius
        i = 0.4 * r * r
        return _centered(4.0 / 3.0 * math.pi * r**3, (i, i, i))


@dataclass(frozen=True, init=False)
class Box(Shape):
    """A solid box, centred on its frame.

    Args:
        size: full lengths along x, y, z in m, each above 0.
    """

    size: tuple[float, float, float]
    kind: ClassVar[str] = "box"

    def __init__(self, size: ArrayLike) -> None:
        lengths = checks.vector("Box size", size)
        if (lengths <= 0.0).any():
            raise InvalidInputError(f"Box size must be three lengths above 0 m, got {size!r}.")
        object.__setattr__(self, "size", tuple(checks.length("Box size", float(s)) for s in lengths))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """I_x = m (y^2 + z^2) / 12 and so on."""
        x, y, z = self.size
        return _centered(x * y * z, ((y * y + z * z) / 12, (z * z + x * x) / 12, (x * x + y * y) / 12))


@dataclass(frozen=True, init=False)
class Capsule(Shape):
    """A cylinder along z with half a sphere on each end.

    Args:
        radius: in m, above 0.
        length: distance between the two sphere centres in m, above 0.
    """

    radius: float
    length: float
    kind: ClassVar[str] = "capsule"

    def __init__(self, radius: float, length: float) -> None:
        object.__setattr__(self, "radius", checks.length("Capsule radius", radius))
        object.__setattr__(self, "length", checks.length("Capsule length", length))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """Cylinder plus two half spheres whose own centres of mass lie 3/8 r beyond the sphere centres."""
        r, length = self.radius, self.length
        cylinder = math.pi * r * r * length
        ball = 4.0 / 3.0 * math.pi * r**3
        axial = cylinder * 0.5 * r * r + ball * 0.4 * r * r
        across = cylinder * (length**2 / 12 + r * r / 4)
        across += ball * (0.4 * r * r + length**2 / 4 + 0.375 * r * length)
        return MassProperties(cylinder + ball, np.zeros(3), np.diag((across, across, axial)))


@dataclass(frozen=True, init=False)
class Cylinder(Shape):
    """A solid cylinder along z.

    Args:
        radius: in m, above 0.
        length: between the flat ends in m, above 0.
    """

    radius: float
    length: float
    kind: ClassVar[str] = "cylinder"

    def __init__(self, radius: float, length: float) -> None:
        object.__setattr__(self, "radius", checks.length("Cylinder radius", radius))
        object.__setattr__(self, "length", checks.length("Cylinder length", length))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """I_z = m r^2 / 2, I_x = I_y = m (3 r^2 + l^2) / 12."""
        r, length = self.radius, self.length
        across = (3 * r * r + length**2) / 12
        return _centered(math.pi * r * r * length, (across, across, 0.5 * r * r))


@dataclass(frozen=True, init=False)
class Ellipsoid(Shape):
    """A solid ellipsoid, centred on its frame.

    Args:
        half_extents: semi-axes along x, y, z in m, each above 0.
    """

    half_extents: tuple[float, float, float]
    kind: ClassVar[str] = "ellipsoid"

    def __init__(self, half_extents: ArrayLike) -> None:
        name = "Ellipsoid half_extents"
        lengths = checks.vector(name, half_extents)
        if (lengths <= 0.0).any():
            raise InvalidInputError(f"{name} must be three lengths above 0 m, got {half_extents!r}.")
        object.__setattr__(self, "half_extents", tuple(checks.length(name, float(s)) for s in lengths))

    @cached_property
    def mass_properties(self) -> MassProperties:
        """I_x = m (b^2 + c^2) / 5 and so on."""
        a, b, c = self.half_extents
        moments = ((b * b + c * c) / 5, (c * c + a * a) / 5, (a * a + b * b) / 5)
        return _centered(4.0 / 3.0 * math.pi * a * b * c, moments)


@dataclass(frozen=True, init=False, eq=False)
class ConvexHull(Shape):
    """The convex hull of a set of points. Its frame is the one the points are given in.

    Args:
        points: (n, 3) in m, at least four that do not lie in one plane.
    """

    points: Array
    faces: NDArray[np.int64]
    kind: ClassVar[str] = "hull"

    def __init__(self, points: ArrayLike) -> None:
        from scipy.spatial import ConvexHull as Quickhull
        from scipy.spatial import QhullError

        try:
            cloud = np.array(points, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidInputError("ConvexHull points must be an array of shape (n, 3) of finite numbers.") from None
        if cloud.ndim != 2 or cloud.shape[1:] != (3,) or len(cloud) < 4:
            raise InvalidInputError(f"ConvexHull points must have shape (n, 3) with n of 4 or more, got {cloud.shape}.")
        if not np.isfinite(cloud).all():
            raise InvalidInputError("ConvexHull points must all be finite numbers.")
        try:
            hull = Quickhull(cloud)
        except QhullError:
            raise InvalidInputError("ConvexHull points must not all lie in one plane.") from None
        keep = np.sort(hull.vertices)
        renumber = np.full(len(cloud), -1)
        renumber[keep] = np.arange(len(keep))
        faces = renumber[hull.simplices]
        corners = cloud[keep]
        middle = corners.mean(axis=0)
        a, b, c = (corners[faces[:, k]] for k in range(3))
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - middle) < 0
        faces[inward] = faces[inward][:, ::-1]
        corners.setflags(write=False)
        faces.setflags(write=False)
        object.__setattr__(self, "points", corners)
        object.__setattr__(self, "faces", faces)

    @cached_property
    def mass_properties(self) -> MassProperties:
        """Sum over the signed tetrahedra (middle, a, b, c) of every outward face."""
        middle = self.points.mean(axis=0)
        volume, moment, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for face in self.faces:
            a, b, c = self.points[face] - middle
            v = float(a @ np.cross(b, c)) / 6.0
            s = a + b + c
            volume += v
            moment += v * s / 4.0
            # integral of x x^T over a tetrahedron with one corner at the origin
            second += v / 20.0 * (np.outer(a, a) + np.outer(b, b) + np.outer(c, c) + np.outer(s, s))
        center = moment / volume
        second -= volume * np.outer(center, center)
        return MassProperties(volume, center + middle, np.trace(second) * np.eye(3) - second)


@dataclass(frozen=True, init=False)
class Plane(Shape):
    """A half space that fills everything below its surface n . x = offset. Cannot be dynamic.

    Args:
        normal: outward direction (3,), need not be normalised.
        offset: distance of the surface from the origin of the shape's frame along the normal, in m.
    """

    normal: tuple[float, float, float]
    offset: float
    kind: ClassVar[str] = "plane"
    bounded: ClassVar[bool] = False

    def __init__(self, normal: ArrayLike = (0.0, 0.0, 1.0), offset: float = 0.0) -> None:
        n = checks.unit_vector("Plane normal", normal)
        object.__setattr__(self, "normal", tuple(float(c) for c in n))
        object.__setattr__(self, "offset", checks.number("Plane offset", offset))


def describe(shape: Any) -> str:
    """A short text such as ``Box 1 x 1 x 2 m`` for tables."""
    match shape:
        case Sphere():
            return f"Sphere r {shape.radius:g} m"
        case Box():
            return "Box " + " x ".join(f"{s:g}" for s in shape.size) + " m"
        case Capsule() | Cylinder():
            return f"{type(shape).__name__} r {shape.radius:g} m, {shape.length:g} m"
        case Ellipsoid():
            return "Ellipsoid semi-axes " + " x ".join(f"{s:g}" for s in shape.half_extents) + " m"
        case ConvexHull():
            return f"ConvexHull of {len(shape.points)} points"
        case Plane():
            return "Plane"
    return type(shape).__name__
