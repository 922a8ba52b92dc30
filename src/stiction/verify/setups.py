"""Pieces of scenes that cases share: worlds with one pair of materials, slopes, rotations, and the time of an event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction as st

Array = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]

G = 9.81
"""m/s^2"""
GRAVITY = (0.0, 0.0, -G)
WEIGHTLESS = (0.0, 0.0, 0.0)


def make_world(
    solver: str,
    dt: float,
    *,
    static: float = 0.0,
    dynamic: float | None = None,
    restitution: float = 0.0,
    rolling: float = 0.0,
    torsional: float = 0.0,
    gravity: ArrayLike = GRAVITY,
) -> st.World:
    """An empty world in which everything is of one material; ``dynamic`` is as ``static`` if left out."""
    table = st.MaterialTable()
    table.set_pair(
        "default", "default",
        static=static, dynamic=static if dynamic is None else dynamic,
        restitution=restitution, rolling=rolling, torsional=torsional,
    )  # fmt: skip
    return st.World(gravity=gravity, dt=dt, solver=solver, materials=table)


def solver_tolerance(solver: str) -> float:
    """eps: how far the velocity of a contact may be from what its law demands when a step ends, m/s."""
    from stiction.core.solve.micro import TOLERANCE
    from stiction.core.solve.soft import ENOUGH

    return {"micro": TOLERANCE, "soft": ENOUGH}[solver]


def slip_speed(solver: str) -> float:
    """s: a contact that slips more slowly than this is taken to hold, m/s."""
    from stiction.core.solve.micro import SLIP_SPEED

    return {"micro": SLIP_SPEED, "soft": SLIP_SPEED}[solver]


def speed_error(solver: str, seconds: float, dt: float) -> float:
    """What the solver's tolerance adds up to in a speed: eps sqrt(t / dt), for errors have either sign, m/s."""
    return solver_tolerance(solver) * math.sqrt(max(seconds / dt, 1.0))


def distance_error(solver: str, seconds: float, dt: float) -> float:
    """The distance that such an error of speed makes in ``seconds``, at most: t eps sqrt(t / dt), m."""
    return speed_error(solver, seconds, dt) * seconds


def stop_error(static: float, dynamic: float, dt: float) -> float:
    """How far off a block may stop because it stops at the end of a step, m.

    In that step it goes v dt / 2 from the speed v instead of v^2 / (2 mu_d g). Friction of mu_s N can hold it from
    v = mu_s g dt on, so this is short by mu_s (mu_s - mu_d) g dt^2 / (2 mu_d) at most, or long by mu_d g dt^2 / 8.
    """
    return G * dt * dt * max(dynamic / 8.0, static * (static - dynamic) / (2.0 * dynamic))


def about(axis: ArrayLike, angle: float) -> Quaternion:
    """Rotation by ``angle`` (rad) about ``axis`` (3,) as a unit quaternion."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis) * math.sin(0.5 * angle)
    return math.cos(0.5 * angle), float(x), float(y), float(z)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation that turns by b first and then by a."""
    from stiction.core.vec import Quat

    w, x, y, z = Quat(*a) * Quat(*b)
    return w, x, y, z


def matrix(q: ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a unit quaternion (4,)."""
    from stiction.core.vec import Quat, rotation

    return np.array(rotation(Quat(*np.asarray(q, float)))).reshape(3, 3)


def turned_by(q0: ArrayLike, q1: ArrayLike) -> float:
    """Angle between two orientations, rad."""
    a, b = np.asarray(q0, float), np.asarray(q1, float)
    return 2.0 * math.atan2(float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))) * 2.0


def box_inertia(mass: float, size: Sequence[float]) -> Array:
    """Principal moments of a solid box, (3,), kg m^2: written out here, so that the engine's own are checked, too."""
    x, y, z = size
    return mass / 12.0 * np.array([y * y + z * z, z * z + x * x, x * x + y * y])


@dataclass(frozen=True)
class Slope:
    """A plane through the origin, tilted by ``angle`` towards the compass direction ``azimuth`` (rad from x to y)."""

    angle: float
    azimuth: float = 0.0

    @property
    def normal(self) -> Array:
        """Unit vector out of the plane."""
        s = math.sin(self.angle)
        return np.array([s * math.cos(self.azimuth), s * math.sin(self.azimuth), math.cos(self.angle)])

    @property
    def down(self) -> Array:
        """Unit vector down the slope."""
        c = math.cos(self.angle)
        return np.array([c * math.cos(self.azimuth), c * math.sin(self.azimuth), -math.sin(self.angle)])

    @property
    def across(self) -> Array:
        """Unit vector along the slope, level."""
        return np.array([-math.sin(self.azimuth), math.cos(self.azimuth), 0.0])

    def orientation(self, yaw: float = 0.0) -> Quaternion:
        """Of a body that lies flat on the slope, its x axis ``yaw`` away from downhill."""
        upright = product(about((0, 0, 1), self.azimuth), about((0, 1, 0), self.angle))
        return product(upright, about((0, 0, 1), yaw))

    def add_to(self, world: st.World) -> st.Body:
        """The plane itself, static."""
        return world.add(st.Plane(self.normal), static=True)

    def add_box(self, world: st.World, size: Sequence[float], *, yaw: float = 0.0, at: float = 0.0) -> st.Body:
        """A box at rest flat on the slope, ``at`` metres along it from the origin."""
        position = self.normal * (0.5 * size[2]) + self.across * at
        return world.add(st.Box(size), position=position, orientation=self.orientation(yaw))

    def add_sphere(self, world: st.World, radius: float, *, at: float = 0.0) -> st.Body:
        """A sphere at rest on the slope."""
        return world.add(st.Sphere(radius), position=self.normal * radius + self.across * at)


def arrival(values: Sequence[float], dt: float) -> float:
    """When a quantity that falls in a straight line reaches zero, s; ``values[k]`` is its size at time k dt.

    The last step is a part of a step: the value left before it, over what the step before took. Nothing but
    measured values goes in. NaN if the quantity does not come down to a thousandth of where it began.
    """
    for k in range(2, len(values)):
        if values[k] <= 1e-3 * values[0]:
            return dt * (k - 1 + values[k - 1] / (values[k - 2] - values[k - 1]))
    return math.nan


def steps_for(seconds: float, dt: float) -> int:
    """Whole number of steps nearest to a time, at least one."""
    return max(1, round(seconds / dt))
