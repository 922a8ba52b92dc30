"""Vehicles in a scene file: the wheels of a car under one of its bodies, and what the driver does."""

from __future__ import annotations

import itertools
from typing import Annotated, Literal

from pydantic import model_validator

from stiction.scene import fields
from stiction.scene.fields import Name, Number, Table, Text, fault
from stiction.vehicle import MOST_STEER_DEG
from stiction.wheels import DRIVES


class ControlTable(Table):
    """What the driver does at a time; straight lines lead from one row to the next."""

    time: fields.Time
    """s"""
    throttle: Annotated[float, fields.between(-1.0, 1.0)] = 0.0
    """Part of the drive torque, -1 (backwards) to 1."""
    brake: fields.Fraction = 0.0
    """Part of the brake torque, 0 to 1."""
    steer_deg: Annotated[float, fields.between(-MOST_STEER_DEG, MOST_STEER_DEG)] = 0.0
    """Steering angle of the front axle, degrees to the left."""


class VehicleTable(Table):
    """Four wheels under a body whose x points forwards and y to the left. They are rays with a spin, not bodies."""

    name: Name
    """Unique in the scene."""
    chassis: Text
    """The body, a dynamic one."""
    front: Number
    """x of the front axle in the axes of the body, m. It steers."""
    rear: Number
    """x of the rear axle, m."""
    track: fields.Length
    """Distance from the left wheels to the right ones, m."""
    hub_height: Number
    """z of the hubs in the axes of the body when the vehicle stands on level ground, m."""
    radius: fields.Length = 0.3
    """Of the wheels, m."""
    width: fields.Length = 0.2
    """Of the wheels, to be looked at, m."""
    wheel_mass: fields.Kilograms = 20.0
    """kg, gives a wheel its inertia about the axle; its weight is that of the body."""
    tyre: Text = "default"
    """Material of the tyres."""
    drive: Annotated[Literal["front", "rear", "all"], fields.word(*DRIVES)] = "rear"
    """The axle that is driven."""
    brake_front: fields.Fraction = 0.6
    """Share of the brake torque that the front axle has, 0 to 1."""
    frequency: fields.Frequency = 1.5
    """Of the suspension, Hz."""
    damping: fields.Ratio = 0.5
    """Its damping ratio."""
    drive_torque: fields.Torque = 2000.0
    """At full throttle, N m."""
    brake_torque: fields.Torque = 10_000.0
    """At full brake, N m."""
    controls: tuple[ControlTable, ...] = ()
    """What the driver does, in the order of time; nothing if left out."""

    @model_validator(mode="after")
    def _goes_forwards(self) -> VehicleTable:
        if self.front <= self.rear:
            raise fault(f"must be ahead of rear ({self.rear:g} m), got {self.front:g}.", key="front")
        times = [row.time for row in self.controls]
        for before, after in itertools.pairwise(times):
            if after <= before:
                raise fault(f"must have times that rise, got {times} s.", key="controls")
        return self
