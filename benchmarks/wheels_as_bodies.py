"""Wheels as rays or as bodies: ``python benchmarks/wheels_as_bodies.py [--docs]``.

The same car twice. Once it is a :class:`stiction.Vehicle`. Once each wheel is a sphere with the tyre's law in ordinary
contact, held to the chassis by what ``apply_force`` can do from outside: in the plane of the chassis a spring and
damper, implicit in its own motion, as stiff as keeps it stable; across it the suspension; and a torque that leaves the
wheel no spin but that about its axle. ``--docs`` writes the table into docs/vehicles.md.
"""

from __future__ import annotations

import math
import sys
from typing import Protocol

import numpy as np
from docs_table import write_between

import stiction as st

G, MU, STIFFNESS = 9.81, 0.9, 15.0
MASS, WHEEL, RADIUS, BASE, TRACK = 1200.0, 20.0, 0.3, 2.6, 1.5
PLACES = [(x, y) for x in (0.5 * BASE, -0.5 * BASE) for y in (0.5 * TRACK, -0.5 * TRACK)]
HUB, HEIGHT = -0.25, 0.55
FREQUENCY, DAMPING = 1.5, 0.5
LOCKS = 1e9
"""N m"""


class Car(Protocol):
    chassis: st.Body
    steer: float

    def lock(self) -> None: ...

    def step(self) -> None: ...


def empty_road(dt: float) -> st.World:
    """A world with a road."""
    table = st.MaterialTable()
    table.set_pair("tyre", "road", static=MU, dynamic=MU, law=st.BrushTyre(STIFFNESS))
    world = st.World(dt=dt, materials=table)
    world.add(st.Plane(), static=True, material="road")
    return world


def add_chassis(world: st.World, speed: float) -> st.Body:
    """A box that meets nothing."""
    shape = st.Box((4.0, 1.2, 0.5))
    return world.add(shape, mass=MASS, position=(0, 0, HEIGHT), velocity=(speed, 0, 0), layer=2, mask=0)


class Rays:
    """The car as a vehicle."""

    def __init__(self, dt: float, speed: float) -> None:
        world = empty_road(dt)
        self.chassis = add_chassis(world, speed)
        wheels = [st.Wheel((x, y, HUB), RADIUS, mass=WHEEL, material="tyre", steered=x > 0) for x, y in PLACES]
        self.vehicle = st.Vehicle(world, self.chassis, wheels, brake_torque=LOCKS, visible=False)
        self.steer = 0.0

    def lock(self) -> None:
        self.vehicle.brake = 1.0

    def step(self) -> None:
        self.vehicle.steer = self.steer
        self.vehicle.step()


class Bodies:
    """The car with wheels that are spheres."""

    def __init__(self, dt: float, speed: float) -> None:
        self.world, self.dt = empty_road(dt), dt
        self.chassis = add_chassis(self.world, speed)
        moment = 0.5 * WHEEL * RADIUS**2
        self.inertia, self.locked, self.steer = moment, False, 0.0
        self.wheels = [
            self.world.add(
                st.Sphere(RADIUS),
                mass=WHEEL,
                inertia=(moment, moment, moment),
                position=(x, y, RADIUS),
                velocity=(speed, 0, 0),
                angular_velocity=(0, speed / RADIUS, 0),
                material="tyre",
            )
            for x, y in PLACES
        ]
        carried = MASS / len(PLACES)
        self.spring = carried * (2.0 * math.pi * FREQUENCY) ** 2
        self.damper = 2.0 * DAMPING * math.sqrt(self.spring * carried)
        self.weight = carried * G

    def lock(self) -> None:
        self.locked = True

    def step(self) -> None:
        body, dt = self.chassis, self.dt
        R = axes_of(body)
        for (x, y), wheel in zip(PLACES, self.wheels, strict=True):
            place = body.position + R @ np.array((x, y, HUB))
            off = R.T @ (wheel.position - place)
            here = body.velocity + np.cross(body.angular_velocity, wheel.position - body.position)
            speed = R.T @ (wheel.velocity - here)
            # critically damped, with the whole error gone in a step; in the plane the wheel's own mass is what moves
            k, c = np.full(3, WHEEL / dt**2), np.full(3, 2.0 * WHEEL / dt)
            k[2], c[2] = self.spring, self.damper
            force = -(k * off + (c + k * dt) * speed) / (1.0 + (c + k * dt) * dt / WHEEL)
            force[2] -= self.weight
            wheel.apply_force(R @ force)
            body.apply_force(-R @ force, at=wheel.position)
            angle = math.atan(BASE / (BASE / math.tan(self.steer) - y)) if x > 0 and self.steer else 0.0
            axle = R @ np.array((-math.sin(angle), math.cos(angle), 0.0))
            spin = wheel.angular_velocity - body.angular_velocity
            wrong = spin if self.locked else spin - axle * (axle @ spin)
            torque = -wrong * self.inertia / dt
            wheel.apply_torque(torque)
            body.apply_torque(-torque)
        self.world.step()


def axes_of(body: st.Body) -> np.ndarray:
    """Its axes in the world as columns."""
    w, x, y, z = body.orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def braking(kind: type[Rays] | type[Bodies], dt: float) -> float:
    """Distance with locked wheels from 20 m/s, as a part of v^2 / (2 mu g)."""
    car = kind(dt, 20.0)
    car.lock()
    for _ in range(round(5.0 / dt)):
        car.step()
        if car.chassis.velocity[0] <= 0.0:
            break
    return float(car.chassis.position[0]) / (20.0**2 / (2.0 * MU * G))


def cornering(kind: type[Rays] | type[Bodies], dt: float) -> float:
    """Yaw rate after two seconds at 20 m/s and a small angle, as a part of v delta / L: the car steers neutrally."""
    car = kind(dt, 20.0)
    car.steer = 0.01
    for _ in range(round(2.0 / dt)):
        car.step()
    speed = float(np.hypot(*car.chassis.velocity[:2]))
    return float(car.chassis.angular_velocity[2]) / (speed * 0.01 / BASE)


def main(arguments: list[str]) -> None:
    """Print the table, and write it into the page if asked to."""
    lines = ["| wheels | time step | braking, locked | yaw rate |", "| --- | --- | --- | --- |"]
    for name, kind in (("rays (`Vehicle`)", Rays), ("bodies on springs", Bodies)):
        for steps in (60, 240):
            found = braking(kind, 1.0 / steps), cornering(kind, 1.0 / steps)
            lines.append(f"| {name} | 1/{steps} s | {found[0]:.3f} | {found[1]:.3f} |")
    made = "\n".join(lines)
    print(made)
    if "--docs" in arguments:
        write_between("vehicles.md", "wheels", made)


if __name__ == "__main__":
    main(sys.argv[1:])
