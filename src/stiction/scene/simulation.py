"""Simulation: a scene on its way through time, with the forces and changes that the scene foresees."""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.body import Body
from stiction.errors import InvalidInputError
from stiction.scene.model_vehicle import VehicleTable
from stiction.scene.placing import frame_of, turned
from stiction.scene.scene import Scene
from stiction.vehicle import Vehicle
from stiction.wheels import four_wheels
from stiction.world import World

Array = NDArray[np.float64]

SNAP = 1e-9
"""Steps: a time that close to a multiple of dt is that multiple (0.1 s / 0.005 s is 20, not 20.000000000000004)."""


@dataclass(frozen=True)
class _Push:
    """A force on a body from one time to another, both in steps and not necessarily whole."""

    body: Body
    force: Array
    at: Array | None
    begin: float
    end: float

    def share(self, step: int) -> float:
        """How much of that step the force acts, 0 to 1."""
        return max(0.0, min(self.end, step + 1.0) - max(self.begin, float(step)))

    def apply(self, share: float) -> None:
        """Push for the coming step, so that the impulse is right even where a window begins or ends within it."""
        at = None
        if self.at is not None:
            at = self.body.position + turned(self.body.orientation, self.at)
        self.body.apply_force(self.force * share, at)


@dataclass(frozen=True)
class _Change:
    """New velocities of a body from a step on."""

    step: int
    body: Body
    velocity: Array | None
    angular_velocity: Array | None

    def apply(self) -> None:
        if self.velocity is not None:
            self.body.velocity = self.velocity
        if self.angular_velocity is not None:
            self.body.angular_velocity = self.angular_velocity


class _Driver:
    """A vehicle and what its driver does over time."""

    def __init__(self, table: VehicleTable, world: World) -> None:
        wheels = four_wheels(
            front=table.front,
            rear=table.rear,
            track=table.track,
            hub_height=table.hub_height,
            radius=table.radius,
            width=table.width,
            wheel_mass=table.wheel_mass,
            tyre=table.tyre,
            drive=table.drive,
            brake_front=table.brake_front,
        )
        self.vehicle = Vehicle(
            world,
            world[table.chassis],
            wheels,
            frequency=table.frequency,
            damping=table.damping,
            drive_torque=table.drive_torque,
            brake_torque=table.brake_torque,
        )
        self._times = [row.time for row in table.controls]
        self._rows = np.array([(row.throttle, row.brake, math.radians(row.steer_deg)) for row in table.controls])

    def drive(self, time: float) -> None:
        """Set the controls to what they are at that time, and apply the forces of the wheels for the coming step."""
        if self._times:
            throttle, brake, steer = (float(np.interp(time, self._times, column)) for column in self._rows.T)
            self.vehicle.throttle, self.vehicle.brake, self.vehicle.steer = throttle, brake, steer
        self.vehicle.apply()


class Simulation:
    """A world built from a scene, and its way to the end of the scene.

    Pushes and velocity changes happen at their times, however the steps are cut into calls of :meth:`advance`. A push
    that begins or ends within a step acts in it with the share of its force that gives the right impulse. Vehicles are
    driven in every step, with the controls of its middle.

    Args:
        scene: what to simulate.

    Attributes:
        scene: the scene.
        world: its world, at time 0.
        total_steps: number of steps that come nearest to the scene's duration, at least one.
        vehicles: its vehicles by their names.

    Raises:
        InvalidInputError, NotYetError: see :meth:`Scene.build`.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.world = scene.build()
        dt = self.world.dt
        self.total_steps = max(1, round(scene.duration / dt))
        self._drivers = self._make_drivers()
        self.vehicles = {name: driver.vehicle for name, driver in self._drivers.items()}
        self._pushes = self._make_pushes(dt)
        self._changes = self._make_changes(dt)
        # Steps before which something outside the world must be done; compiled stepping never runs across one of them.
        stops = {math.floor(push.begin) for push in self._pushes} | {change.step for change in self._changes}
        self._stops = sorted(stops)

    @property
    def step_index(self) -> int:
        """Steps taken so far."""
        return self.world.steps

    @property
    def done(self) -> bool:
        """Whether the end of the scene is reached."""
        return self.step_index >= self.total_steps

    def __repr__(self) -> str:
        return f"<Simulation of {self.scene.name!r}, step {self.step_index} of {self.total_steps}>"

    def advance(self, steps: int = 1) -> None:
        """Take that many steps, or as many as are left to the end of the scene.

        Raises:
            InvalidInputError: steps is not a whole number, 1 or more.
            SimulationError: a body's state is no longer finite; the world is back at its last finite state.
        """
        goal = min(self.step_index + checks.integer("steps", steps, minimum=1), self.total_steps)
        while self.step_index < goal:
            now = self.step_index
            for change in self._changes:
                if change.step == now:
                    change.apply()
            acting = [(push, share) for push in self._pushes if (share := push.share(now)) > 0.0]
            for push, share in acting:
                push.apply(share)
            for driver in self._drivers.values():
                driver.drive((now + 0.5) * self.world.dt)
            one_by_one = bool(acting or self._drivers)
            self.world.step(1 if one_by_one else self._next_stop(now, goal) - now)

    def _next_stop(self, now: int, goal: int) -> int:
        """The next step at which something happens from outside, or the goal."""
        after = bisect.bisect_right(self._stops, now)
        return min(goal, self._stops[after]) if after < len(self._stops) else goal

    def _make_drivers(self) -> dict[str, _Driver]:
        made = {}
        for number, table in enumerate(self.scene.table.vehicles):
            try:
                made[table.name] = _Driver(table, self.world)
            except InvalidInputError as error:
                raise InvalidInputError(f"vehicles[{number}]: {error}") from None
        return made

    def _make_pushes(self, dt: float) -> list[_Push]:
        pushes = []
        for push in self.scene.table.pushes:
            force = frame_of(self.scene.table, push.frame).turn(push.force)
            end = math.inf if push.until is None else _in_steps(push.until, dt)
            at = None if push.at is None else np.array(push.at)
            pushes.append(_Push(self.world[push.body], force, at, _in_steps(push.start, dt), end))
        return pushes

    def _make_changes(self, dt: float) -> list[_Change]:
        changes = []
        for change in sorted(self.scene.table.velocity_changes, key=lambda change: change.time):
            frame = frame_of(self.scene.table, change.frame)
            linear = None if change.velocity is None else frame.turn(change.velocity)
            angular = None if change.angular_velocity is None else frame.turn(change.angular_velocity)
            changes.append(_Change(round(change.time / dt), self.world[change.body], linear, angular))
        return changes


def _in_steps(time: float, dt: float) -> float:
    steps = time / dt
    whole = round(steps)
    return float(whole) if abs(steps - whole) < SNAP else steps
