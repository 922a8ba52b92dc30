"""A hand that pulls a body: a damped spring between a point of it and the pointer, with a limit to its force."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stiction.view.survey import matrices
from stiction.world import World

Array = NDArray[np.float64]

FREQUENCY = 2.0
"""Hz, at which the held point would swing."""
DAMPING = 0.7
"""Share of critical damping."""
MOST_WEIGHTS = 10.0
"""Largest force, as a multiple of the body's weight under 9.81 m/s^2: more than any dry friction, less than a blow."""


class Grab:
    """A hold on a body.

    The spring is as stiff for its point as for any other: its stiffness follows from the mass that the point shows to a
    force, the inverse of the largest eigenvalue of K = 1/m - S I^-1 S, with S the skew matrix of the point's arm.

    Args:
        world: the world.
        body: number of the body, which must be dynamic.
        point: (3,) m, where it is held.

    Attributes:
        target: (3,) m, where the pointer is.
        force: (3,) N, of the last pull.
    """

    def __init__(self, world: World, body: int, point: Array) -> None:
        self.body = body
        held = world.bodies[body]
        rotation = matrices(held.orientation)
        self._local = rotation.T @ (point - held.position)
        self.target = point.copy()
        self.force = np.zeros(3)
        x, y, z = (point - held.center_of_mass).tolist()
        skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        inverse_inertia = rotation @ np.linalg.inv(held.inertia) @ rotation.T
        inverse_mass = np.eye(3) / held.mass - skew @ inverse_inertia @ skew
        shown = 1.0 / float(np.linalg.eigvalsh(inverse_mass)[-1])
        rate = 2.0 * math.pi * FREQUENCY
        self._stiffness, self._damping = shown * rate**2, 2.0 * DAMPING * shown * rate
        self._most = MOST_WEIGHTS * held.mass * 9.81

    def point(self, world: World) -> Array:
        """Where the held point is now, (3,), m."""
        held = world.bodies[self.body]
        result: Array = held.position + matrices(held.orientation) @ self._local
        return result

    def pull(self, world: World) -> None:
        """Pull for the coming step."""
        held = world.bodies[self.body]
        point = self.point(world)
        speed = held.velocity + np.cross(held.angular_velocity, point - held.center_of_mass)
        force = self._stiffness * (self.target - point) - self._damping * speed
        size = float(np.linalg.norm(force))
        self.force = force if size <= self._most else force * (self._most / size)
        held.apply_force(self.force, point)
