"""What an expression can ask of a run: functions of a body's name, over the frames of a recording.

Each function is one method of :class:`Measures` with the decorator ``measure``; its docstring is what
``stiction sweep --functions`` prints. Series are arrays with an entry a frame, everything else is one value.

Contact points are those of the step that led to a frame. Before the first step there are none; the first frame is given
those of the second one, so that what slips from the beginning is seen to do so.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.motion import Motion
from stiction.record.frames import Frames
from stiction.scene.placing import turned
from stiction.world import World

Array = NDArray[np.float64]
Method = TypeVar("Method", bound=Callable[..., Any])

REST_SPEED = 1e-3
"""m/s: a body that is slower than this, all of it, rests."""
TIPPED_DEG = 45.0
"""Degrees: a body whose upright axis has turned further than this has tipped over."""

MEASURES: dict[str, str] = {}
"""Name of each function to what it gives."""
OF_BODY: set[str] = set()
"""Functions whose first argument is the name of a body."""
NEEDS_CONTACTS: set[str] = set()
"""Functions for which the contact points of each frame must be kept."""


def measure(*, contacts: bool = False) -> Callable[[Method], Method]:
    """Make a method a function of the language; ``contacts`` says that it looks at contact points."""

    def enter(method: Method) -> Method:
        name = method.__name__
        MEASURES[name] = (inspect.getdoc(method) or "").replace("\n", " ")
        if "body" in inspect.signature(method).parameters:
            OF_BODY.add(name)
        if contacts:
            NEEDS_CONTACTS.add(name)
        return method

    return enter


def usage(name: str) -> str:
    """How to call a function of the language: ``tipped(body, angle_deg=45)``."""
    parameters = list(inspect.signature(getattr(Measures, name)).parameters.values())[1:]
    shown = [p.name if p.default is p.empty else f"{p.name}={p.default:g}" for p in parameters]
    return f"{name}({', '.join(shown)})"


class Measures:
    """A finished run, as the functions of the language see it.

    Args:
        frames: all that was recorded.
        world: at the end of the run.
    """

    def __init__(self, frames: Frames, world: World) -> None:
        self.frames = frames
        self.world = world
        self._numbers = {body.name: number for number, body in enumerate(frames.bodies)}

    def names(self) -> dict[str, Any]:
        """Names besides the sweep's own: ``time`` (f,) in s, ``dt`` in s, and ``g``, the size of gravity in m/s^2."""
        return {"time": self.frames.times, "dt": self.frames.dt, "g": float(np.linalg.norm(self.world.gravity))}

    def functions(self) -> dict[str, Callable[..., Any]]:
        """The functions of the language, bound to this run."""
        return {name: getattr(self, name) for name in MEASURES}

    # --- series -------------------------------------------------------------------------------------------------------

    @measure()
    def position(self, body: str) -> Array:
        """Series (f, 3): where the origin of its shape is, m."""
        return self.frames.positions[:, self._number(body)]

    @measure()
    def velocity(self, body: str) -> Array:
        """Series (f, 3): of its centre of mass, m/s."""
        return self.frames.velocities[:, self._number(body)]

    @measure()
    def angular_velocity(self, body: str) -> Array:
        """Series (f, 3), rad/s."""
        return self.frames.angular_velocities[:, self._number(body)]

    @measure()
    def speed(self, body: str) -> Array:
        """Series (f,): of its centre of mass, m/s."""
        return np.asarray(np.linalg.norm(self.velocity(body), axis=1))

    @measure()
    def tilt(self, body: str) -> Array:
        """Series (f,): angle in rad between its upright axis (against gravity at the start) and where that points now;
        turning about it does not count."""
        gravity = self.world.gravity
        size = float(np.linalg.norm(gravity))
        up = -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        orientations = self.frames.orientations[:, self._number(body)]
        backwards = orientations[0] * np.array([1.0, -1.0, -1.0, -1.0])
        now = turned(orientations, turned(backwards, up))
        # the sine and the cosine together are exact for small angles, where the cosine alone is not
        return np.asarray(np.arctan2(np.linalg.norm(np.cross(now, up), axis=1), now @ up))

    @measure(contacts=True)
    def slip_speed(self, body: str) -> Array:
        """Series (f,): speed in m/s at which it slips over what it touches, the mean of its contact points by load."""
        slips, loads = self._slips(self._number(body))
        loaded = loads > 0.0
        return np.asarray(np.divide(slips, loads, out=np.zeros_like(slips), where=loaded))

    @measure(contacts=True)
    def normal_force(self, body: str) -> Array:
        """Series (f,): sum of the normal forces at its contact points, N."""
        impulses = self._sum_of_contacts(self._number(body), self._rows["normal_impulse"])
        return np.asarray(impulses / self.frames.dt)

    @measure(contacts=True)
    def friction_force(self, body: str) -> Array:
        """Series (f,): size of the sum of the friction forces on it, N."""
        number, rows = self._number(body), self._rows
        sign = np.where(rows["body_b"] == number, 1.0, -1.0)
        parts = [self._sum_of_contacts(number, sign * rows["friction_impulse"][:, axis]) for axis in range(3)]
        return np.asarray(np.linalg.norm(parts, axis=0) / self.frames.dt)

    # --- one value ----------------------------------------------------------------------------------------------------

    @measure(contacts=True)
    def slip_distance(self, body: str) -> float:
        """How far it has slipped over what it touches, m: slip_speed, integrated over time."""
        return self.integral(self.slip_speed(body))

    @measure()
    def displacement(self, body: str) -> float:
        """Distance from where it began to where it ended, m."""
        x = self.position(body)
        return float(np.linalg.norm(x[-1] - x[0]))

    @measure()
    def path_length(self, body: str) -> float:
        """Length of its way from frame to frame, m."""
        return float(np.linalg.norm(np.diff(self.position(body), axis=0), axis=1).sum())

    @measure()
    def tipped(self, body: str, angle_deg: float = TIPPED_DEG) -> bool:
        """Whether its upright axis has turned by more than angle_deg (45) at any time."""
        return bool(np.degrees(self.tilt(body).max()) > angle_deg)

    @measure()
    def time_to_rest(self, body: str, speed: float = REST_SPEED) -> float:
        """Time in s from which on no point of it is faster than speed (0.001 m/s) until the end; NaN if it still is."""
        number = self._number(body)
        turning = np.linalg.norm(self.angular_velocity(body), axis=1)
        fastest = self.speed(body) + turning * _reach(self.frames.bodies[number].shape)
        moving = np.flatnonzero(fastest > speed)
        if not len(moving):
            return float(self.frames.times[0])
        return float("nan") if moving[-1] == len(fastest) - 1 else float(self.frames.times[moving[-1] + 1])

    @measure()
    def motion(self, body: str) -> str:
        """What it is doing at the end: 'sticking', 'sliding', 'rolling', 'free' or 'fixed'."""
        return Motion(int(self._motion[self._number(body)])).word

    @measure()
    def friction_work(self, body: str) -> float:
        """What friction and rolling resistance at its contacts have taken, J."""
        return float(self.world[self.frames.bodies[self._number(body)].name].friction_work)

    @measure()
    def dissipated(self) -> float:
        """What friction, rolling and impacts have taken from the whole world, J."""
        return float(self.world.energy().dissipated)

    @measure()
    def kinetic_energy(self) -> float:
        """Of the whole world at the end, J."""
        return float(self.world.energy().kinetic)

    @measure()
    def integral(self, series: Any) -> float:
        """Of a series over time, by trapezia."""
        return float(np.trapezoid(self._series("integral", series), self.frames.times))

    @measure()
    def at(self, series: Any, seconds: float) -> float:
        """Value of a series at a time in s, between two frames on a straight line."""
        return float(np.interp(float(seconds), self.frames.times, self._series("at", series)))

    @measure()
    def when(self, condition: Any) -> float:
        """Time in s of the first frame at which a condition on series holds; NaN if it never does."""
        holds = np.flatnonzero(self._series("when", condition))
        return float(self.frames.times[holds[0]]) if len(holds) else float("nan")

    # --- underneath ---------------------------------------------------------------------------------------------------

    def _number(self, body: str) -> int:
        if body not in self._numbers:
            raise InvalidInputError(
                f"body must be one of the scene, got {body!r}{checks.nearest(body, self._numbers)}."
            )
        return self._numbers[body]

    def _series(self, name: str, value: Any) -> Array:
        series = np.asarray(value)
        if series.shape != self.frames.times.shape:
            raise InvalidInputError(
                f"{name} needs a series of {len(self.frames)} numbers, one a frame, got shape {series.shape}."
            )
        return series

    @cached_property
    def _motion(self) -> NDArray[np.uint8]:
        from stiction.record.classify import classify

        return classify(self.world)

    @cached_property
    def _rows(self) -> NDArray[Any]:
        """Contact rows of all frames, those of the second one twice if the first has none."""
        return np.concatenate([self.frames.contacts[: self._borrowed], self.frames.contacts])

    @cached_property
    def _borrowed(self) -> int:
        """How many rows the first frame takes from the second one."""
        offsets = self.frames.contact_offsets
        return int(offsets[2]) if len(offsets) > 2 and offsets[1] == 0 and self.frames.times[0] == 0.0 else 0

    @cached_property
    def _frame_of_row(self) -> NDArray[np.int64]:
        counts = np.diff(self.frames.contact_offsets)
        counts[0] += self._borrowed
        return np.repeat(np.arange(len(self.frames)), counts)

    def _sum_of_contacts(self, number: int, values: Array) -> Array:
        """(f,) sum of a value a contact row over the rows of a body."""
        rows = self._rows
        mine = (rows["body_a"] == number) | (rows["body_b"] == number)
        found = np.bincount(self._frame_of_row[mine], values[mine], minlength=len(self.frames))
        return np.asarray(found, np.float64)

    def _slips(self, number: int) -> tuple[Array, Array]:
        """(f,) sum of slip speed times normal impulse, and (f,) sum of normal impulse, over a body's contacts."""
        rows = self._rows
        difference = self._point_velocities("body_a") - self._point_velocities("body_b")
        normal = rows["normal"]
        planar = difference - normal * np.sum(normal * difference, axis=1, keepdims=True)
        loads = rows["normal_impulse"]
        slips = np.linalg.norm(planar, axis=1) * loads
        return self._sum_of_contacts(number, slips), self._sum_of_contacts(number, loads)

    def _point_velocities(self, side: str) -> Array:
        """(rows, 3) velocity of one body's surface at every contact row, moving surfaces included, m/s."""
        rows, at = self._rows, (self._frame_of_row, self._rows[side])
        centres, belts = self._centres_and_belts
        turns = self.frames.orientations[at]
        arm = rows["point"] - self.frames.positions[at] - turned(turns, centres[rows[side]])
        spin = np.cross(self.frames.angular_velocities[at], arm)
        return np.asarray(self.frames.velocities[at] + spin + turned(turns, belts[rows[side]]))

    @cached_property
    def _centres_and_belts(self) -> tuple[Array, Array]:
        """(n, 3) centre of mass in m and (n, 3) surface velocity in m/s of every body, in the axes of its shape."""
        bodies = list(self.world)
        centres = np.zeros((len(bodies), 3))
        for number, body in enumerate(bodies):
            if np.isfinite(body.mass):
                backwards = body.orientation * np.array([1.0, -1.0, -1.0, -1.0])
                centres[number] = turned(backwards, body.center_of_mass - body.position)
        return centres, np.array([body.surface_velocity for body in bodies]).reshape(-1, 3)


def _reach(shape: Any) -> float:
    """Distance from the origin of a shape to its farthest point, m; 0 for a plane, which never turns."""
    if hasattr(shape, "points"):
        return float(np.linalg.norm(shape.points, axis=1).max())
    if hasattr(shape, "size"):
        return float(np.linalg.norm(shape.size)) / 2.0
    radius, length = float(getattr(shape, "radius", 0.0)), float(getattr(shape, "length", 0.0))
    return radius + length / 2.0
