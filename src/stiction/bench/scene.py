"""A benchmark scene: bodies, gravity and what must become of them, in words that every engine understands.

Bodies of a benchmark share one coefficient of friction, static and dynamic alike, so that the rules by which engines
combine the coefficients of two bodies (mean, product, maximum) cannot make a difference. Comparisons of friction ask
for more: two coefficients, pairs of surfaces, rolling resistance, forces, belts. What an engine cannot express it says
(:meth:`stiction.bench.engines.Engine.supports`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiction.bench import rotations
from stiction.shapes import Box, Shape

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

GRAVITY: Vector = (0.0, 0.0, -9.81)
DENSITY = 1000.0
"""kg/m^3, of every body that names no other."""


@dataclass(frozen=True)
class BenchBody:
    """One body at the start.

    Attributes:
        shape: its frame has its origin at the centre of mass, as all shapes but hulls have by themselves.
        position: m. orientation: (w, x, y, z).
        velocity: m/s. angular_velocity: rad/s, in world axes.
        density: kg/m^3, or None for a body that is static.
        kinematic: it is driven as :attr:`BenchScene.turning` or :attr:`BenchScene.gliding` says, whatever it meets.
        surface: what :attr:`BenchScene.pairs` calls it.
    """

    shape: Shape
    position: Vector
    orientation: Quaternion = rotations.IDENTITY
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    density: float | None = DENSITY
    kinematic: bool = False
    surface: str = "default"

    @property
    def dynamic(self) -> bool:
        """Whether forces move it."""
        return self.density is not None and not self.kinematic


@dataclass(frozen=True)
class Turning:
    """How kinematic bodies move: about an axis through ``center`` (m) along the unit vector ``axis``, at ``rate``
    rad/s."""

    center: Vector
    axis: Vector
    rate: float


@dataclass(frozen=True)
class Gliding:
    """How kinematic bodies move: all alike, without turning, from ``velocity`` m/s with ``acceleration`` m/s^2."""

    velocity: Vector
    acceleration: Vector = (0.0, 0.0, 0.0)

    def moved(self, time: float) -> Array:
        """How far they are from where they began, (3,) m."""
        return np.array(self.velocity) * time + 0.5 * np.array(self.acceleration) * time * time


Force = Callable[[float, Array, Array], Array]
"""(bodies, 3) N at the centres of mass, held through a step, from the time in s at its start, positions (bodies, 3) m
half a step later as far as velocities tell (a force held from its start would feed a spring with energy), and
velocities (bodies, 3) m/s at its start."""


@dataclass(frozen=True)
class BenchScene:
    """What every engine builds.

    Attributes:
        name: of the scene in the list of scenes.
        bodies: in order; engines report positions in the same order.
        friction: coefficient of every pair of bodies, static and dynamic.
        restitution: of every pair.
        gravity: m/s^2.
        turning: of the kinematic bodies, if there are any and they turn.
        gliding: of the kinematic bodies, if there are any and they do not turn.
        dynamic_friction: coefficient of what slides, where it is not ``friction``.
        rolling: rolling resistance of every pair, as a length in m.
        pairs: coefficients of pairs of surfaces for which ``friction`` does not hold: (surface, surface, coefficient).
        force: pushes and springs.
        rest: (n, 3) m, where the bodies stand if they stay where they belong; None where they are meant to move.
        tolerance: m, how far a body may be from its place in ``rest`` and still count as standing.
        floor: height in m of the ground's surface.
    """

    name: str
    bodies: tuple[BenchBody, ...]
    friction: float = 0.6
    restitution: float = 0.0
    gravity: Vector = GRAVITY
    turning: Turning | None = None
    gliding: Gliding | None = None
    dynamic_friction: float | None = None
    rolling: float = 0.0
    pairs: tuple[tuple[str, str, float], ...] = ()
    force: Force | None = field(default=None, compare=False)
    rest: Array | None = field(default=None, compare=False)
    tolerance: float = 0.25
    floor: float = 0.0

    @cached_property
    def dynamic(self) -> NDArray[np.bool_]:
        """(bodies,) which bodies forces move."""
        return np.array([body.dynamic for body in self.bodies])

    @property
    def n(self) -> int:
        """Number of dynamic bodies: the size that tables and plots speak of."""
        return int(self.dynamic.sum())

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of shapes in it, in alphabetical order."""
        return tuple(sorted({body.shape.kind for body in self.bodies}))

    @cached_property
    def positions(self) -> Array:
        """(bodies, 3) m at the start."""
        return np.array([body.position for body in self.bodies], dtype=np.float64)

    @cached_property
    def orientations(self) -> Array:
        """(bodies, 4) quaternions (w, x, y, z) at the start."""
        return np.array([body.orientation for body in self.bodies], dtype=np.float64)

    def driven_at(self, time: float) -> list[tuple[int, Array, Array]]:
        """Number, position (m) and orientation of each kinematic body at ``time`` s."""
        if self.gliding is not None:
            moved = self.gliding.moved(time)
            driven = [(i, body) for i, body in enumerate(self.bodies) if body.kinematic]
            return [(i, np.array(body.position) + moved, np.array(body.orientation)) for i, body in driven]
        turning = self.turning
        if turning is None:
            return []
        turn = rotations.about(turning.axis, turning.rate * time)
        R, center = rotations.matrix(turn), np.array(turning.center)
        return [
            (i, center + R @ (np.array(body.position) - center), rotations.product(turn, body.orientation))
            for i, body in enumerate(self.bodies)
            if body.kinematic
        ]

    def small(self, each: int = 6) -> BenchScene:
        """All that is not dynamic, and the first few dynamic bodies of each kind: for compiling before measuring."""
        seen: dict[str, int] = {}
        kept = []
        for body in self.bodies:
            if body.dynamic:
                seen[body.shape.kind] = seen.get(body.shape.kind, 0) + 1
                if seen[body.shape.kind] > each:
                    continue
            kept.append(body)
        return replace(self, bodies=tuple(kept), rest=None)


def ground(half_width: float = 50.0, top: float = 0.0) -> BenchBody:
    """A static box 2 m thick whose upper face is at the height ``top`` m: no engine needs a plane."""
    side = 2.0 * max(half_width, 50.0)
    return static_box((side, side, 2.0), (0.0, 0.0, top - 1.0))


def static_box(size: Vector, position: Vector, orientation: Sequence[float] | Array = rotations.IDENTITY) -> BenchBody:
    """A box that never moves; size and position in m."""
    return BenchBody(Box(size), position, quaternion(orientation), density=None)


def container(half_x: float, half_y: float, height: float, thickness: float = 1.0) -> list[BenchBody]:
    """Four static walls around the inner rectangle 2 half_x by 2 half_y m, standing on z = 0."""
    x, y, t = half_x + 0.5 * thickness, half_y + 0.5 * thickness, thickness
    long_x, long_y = 2.0 * (half_x + thickness), 2.0 * half_y
    return [
        static_box((t, long_y, height), (-x, 0.0, 0.5 * height)),
        static_box((t, long_y, height), (x, 0.0, 0.5 * height)),
        static_box((long_x, t, height), (0.0, -y, 0.5 * height)),
        static_box((long_x, t, height), (0.0, y, 0.5 * height)),
    ]


def vector(values: Sequence[float] | Array) -> Vector:
    """Three plain floats."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def quaternion(values: Sequence[float] | Array) -> Quaternion:
    """Four plain floats of length 1."""
    w, x, y, z = (float(value) for value in values)
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return (w / length, x / length, y / length, z / length)
