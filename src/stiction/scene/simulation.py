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
from stiction.scene.origin import naming_lines
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
    """A force on a body from one time to another, both in steps and not necessarily whole.

    Attributes:
        force: (3,) N, when it begins. growth: (3,) N by which it grows in a step.
    """

    body: Body
    force: Array
    growth: Array
    at: Array | None
    begin: float
    end: float

    def apply(self, step: int) -> bool:
        """Push for the coming step, and say whether there was anything to push.

        Where a window begins or ends within the step, or the force changes in it, the impulse is right.
        """
        begin, end = max(self.begin, float(step)), min(self.end, step + 1.0)
        if end <= begin:
            return False
        mean = self.force + self.growth * (0.5 * (begin + end) - self.begin)
        at = None
        if self.at is not None:
            at = self.body.position + turned(self.body.orientation, self.at)
        self.body.apply_force(mean * (end - begin), at)
        return True


@dataclass(frozen=True)
class _Spring:
    """A spring between a point of a body and a place that moves evenly.

    Attributes:
        anchor, velocity: (3,) m and m/s of its other end, at time 0.
        at: (3,) m, the point of the body in its shape's frame; None if that is its centre of mass.
    """

    body: Body
    stiffness: float
    anchor: Array
    velocity: Array
    at: Array | None

    def apply(self, time: float, dt: float) -> None:
        """Pull for a step that begins at that time, with the force that the spring is about to have in its middle.

        That force neither feeds nor damps a body that swings freely: a step multiplies its state by a matrix of
        determinant 1, whose eigenvalues lie on the unit circle as long as k dt^2 < 4 m.
        """
        body = self.body
        if self.at is None:
            point, speed = body.center_of_mass, body.velocity
        else:
            point = body.position + turned(body.orientation, self.at)
            speed = body.velocity + np.cross(body.angular_velocity, point - body.center_of_mass)
        half = 0.5 * dt
        stretch = self.anchor + (time + half) * self.velocity - (point + half * speed)
        body.apply_force(self.stiffness * stretch, None if self.at is None else point)


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
    that begins or ends within a step acts in it with the share of its force that gives the right impulse. Springs pull
    in every step; vehicles are driven in every step, with the controls of its middle.

    Args:
        scene: what to simulate.

    Attributes:
        scene: the scene.
        world: its world, at time 0.
        total_steps: number of steps that come nearest to the scene's duration, at least one.
        vehicles: its vehicles by their names.

    Raises:
        InvalidInputError: a spring is too stiff for the time step; and see :meth:`Scene.build`.
        NotYetError: see :meth:`Scene.build`.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.world = scene.build()
        dt = self.world.dt
        self.total_steps = max(1, round(scene.duration / dt))
        with naming_lines(scene.origin):
            self._drivers = self._make_drivers()
            self._springs = self._make_springs(dt)
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
            pushed = [push.apply(now) for push in self._pushes]
            for spring in self._springs:
                spring.apply(now * self.world.dt, self.world.dt)
            for driver in self._drivers.values():
                driver.drive((now + 0.5) * self.world.dt)
            one_by_one = any(pushed) or bool(self._springs or self._drivers)
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
            frame = frame_of(self.scene.table, push.frame)
            force, growth = frame.turn(push.force), frame.turn(push.growth) * dt
            end = math.inf if push.until is None else _in_steps(push.until, dt)
            at = None if push.at is None else np.array(push.at)
            pushes.append(_Push(self.world[push.body], force, growth, at, _in_steps(push.start, dt), end))
        return pushes

    def _make_springs(self, dt: float) -> list[_Spring]:
        springs = []
        for number, spring in enumerate(self.scene.table.springs):
            body, frame = self.world[spring.body], frame_of(self.scene.table, spring.frame)
            most = 4.0 * body.mass / dt**2
            if spring.stiffness >= most:
                raise InvalidInputError(
                    f"springs[{number}].stiffness: must be below 4 m / dt^2 = {most:g} N/m, or its body swings faster "
                    f"than steps can follow, got {spring.stiffness:g}."
                )
            # at the centre of mass the spring cannot turn the body, and needs no arm
            at = np.array(spring.at)
            centred = np.array_equal(at, self.world._store.column(self.world._state.CENTER, 3)[body.index])
            anchor = frame.position + frame.turn(spring.anchor)
            velocity = frame.turn(spring.velocity)
            springs.append(_Spring(body, spring.stiffness, anchor, velocity, None if centred else at))
        return springs

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
