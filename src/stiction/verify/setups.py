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
    tangential_restitution: float = 0.0,
    gravity: ArrayLike = GRAVITY,
    sleeping: bool = True,
) -> st.World:
    """An empty world in which everything is of one material; ``dynamic`` is as ``static`` if left out."""
    table = st.MaterialTable()
    table.set_pair(
        "default", "default",
        static=static, dynamic=static if dynamic is None else dynamic,
        restitution=restitution, rolling=rolling, torsional=torsional, tangential_restitution=tangential_restitution,
    )  # fmt: skip
    return st.World(gravity=gravity, dt=dt, solver=solver, materials=table, sleeping=sleeping)


def solver_tolerance(solver: str) -> float:
    """eps: how far the velocity of a contact may be from what its law demands when a step ends, m/s.

    ``exact`` resolves impacts that bounce as ``micro`` does.
    """
    from stiction.core.solve.micro import TOLERANCE
    from stiction.core.solve.soft import ENOUGH
    from stiction.world import TOLERANCE as EXACT

    return {"micro": TOLERANCE, "soft": ENOUGH, "exact": max(EXACT, TOLERANCE)}[solver]


def slip_speed() -> float:
    """s: ``micro`` takes a contact that slips more slowly than this for one that holds, m/s."""
    from stiction.core.solve.micro import SLIP_SPEED

    return SLIP_SPEED


def substep(solver: str, dt: float) -> float:
    """h: the time after which a solver decides anew, s."""
    from stiction.world import SUBSTEPS

    return dt / SUBSTEPS[solver]


def rounding(solver: str, speed: float, seconds: float, dt: float) -> float:
    """u v t / h: no less than what single precision adds up to in a speed of at most ``speed``, m/s; u = 2^-24.

    It is what a velocity would be off that is rounded in each substep, the same way every time, as the next substep
    starts from v' + (v' - v). ``soft`` counts velocities from the start of the step and adds only what has changed to
    what bodies keep in double, so it is off by far less; an impact changes them by as much as there is.
    """
    return 2.0**-24 * speed * max(seconds, dt) / substep(solver, dt) if solver == "soft" else 0.0


def speed_error(solver: str, seconds: float, dt: float, speed: float = 0.0) -> float:
    """What a speed of at most ``speed`` may be off after ``seconds``, m/s: eps sqrt(t / dt), and what rounding makes.

    Errors that are left when the solver stops at its tolerance have either sign.
    """
    return solver_tolerance(solver) * math.sqrt(max(seconds / dt, 1.0)) + rounding(solver, speed, seconds, dt)


def distance_error(solver: str, seconds: float, dt: float, speed: float = 0.0) -> float:
    """The distance that such an error of speed makes in ``seconds``, at most, m."""
    return speed_error(solver, seconds, dt, speed) * seconds


def stop_error(solver: str, static: float, dynamic: float, dt: float) -> float:
    """How far off a block may stop because it stops at the end of a step, m.

    In that step it goes v dt / 2 from the speed v instead of v^2 / (2 mu_d g). Friction of mu_s N can hold it from
    v = mu_s g dt on, so this is short by mu_s (mu_s - mu_d) g dt^2 / (2 mu_d) at most, or long by mu_d g dt^2 / 8. In
    ``soft`` the step is a substep, and what slides has to come to rest under mu_d N before mu_s counts.
    """
    h = substep(solver, dt)
    held_early = static * (static - dynamic) / (2.0 * dynamic) if solver == "micro" else 0.0
    return G * h * h * max(dynamic / 8.0, held_early)


def delay(solver: str, dt: float) -> float:
    """How late a body that holds may let go where its force exceeds the limit by less than an eighth, s.

    ``soft`` looks once a substep, and wants to see it in PATIENCE of them running; ``exact`` once a step.
    """
    from stiction.core.solve.soft import PATIENCE

    return {"micro": 0.0, "soft": (1.0 + PATIENCE) * substep(solver, dt), "exact": dt}[solver]


def begin_error(solver: str, acceleration: float, dt: float) -> float:
    """How far off a body may be because it began to slide within a step, m.

    ``soft`` lets bodies glide with the mean of old and new velocity if they slide when a step begins. Others move with
    the new one in each substep, which is a h^2 / 2 too far in each of those of that step: a h dt / 2.
    """
    return 0.0 if solver == "micro" else 0.5 * acceleration * substep(solver, dt) * dt


def sink(solver: str, dt: float, compliance: float = 1.0) -> float:
    """How deep a contact point on something fixed may be, m; ``micro`` leaves 1e-6 m.

    A contact of ``soft`` is a spring of m_point omega^2, omega h = 1.3, where 1 / m_point is the response of the point
    to an impulse at it. ``compliance`` is (load / m g) (m / m_point): 1 for a ball, at most 7/4 for a corner of a box
    that stands on a face and 7/2 for one of a box that stands on an edge, as no 1 / m_point of a box is above 7 / m.
    """
    from stiction.core.solve.soft import STIFFNESS

    h = substep(solver, dt)
    return 1e-6 + (compliance * G * (h / (2.0 * STIFFNESS)) ** 2 if solver == "soft" else 0.0)


def lean(solver: str, dt: float, height: float, width: float) -> float:
    """How far the centre of a box leans over because friction at its foot, or a push, loads one of its edges more, m.

    At most, that edge carries all: the box leans by ``sink`` / width, and its centre by half the height times that.
    What leans while it slides straightens up when it has stopped.
    """
    return 0.5 * height / width * sink(solver, dt, 3.5) if solver == "soft" else 0.0


def box_compliance(size: Sequence[float]) -> float:
    """The ``compliance`` of ``sink`` for a solid box on its lower face: its corners carry a quarter each."""
    x, y, z = size
    return 0.25 * (1.0 + 3.0 * x * x / (x * x + z * z) + 3.0 * y * y / (y * y + z * z))


def soft_bounce(solver: str) -> float:
    """Restitution that is left where there should be none.

    In ``soft`` the compliance gamma lets a share gamma / (1 + gamma) of the closing speed v through for a substep, and
    what it sinks in by then is pushed out at the rate beta: beta h v gamma / (1 + gamma).
    """
    from stiction.core.solve.soft import DAMPING, STIFFNESS

    gamma, beta_h = 1.0 / (STIFFNESS * (2.0 * DAMPING + STIFFNESS)), STIFFNESS / (2.0 * DAMPING + STIFFNESS)
    return beta_h * gamma / (1.0 + gamma) if solver == "soft" else 0.0


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
