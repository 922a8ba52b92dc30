"""Box3D (Erin Catto) through robox3d."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stiction.bench.engines.base import Array, Engine, density, floats, wxyz, xyzw
from stiction.bench.scene import BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere

SIDES = 16
"""Of the prism that stands for a cylinder: its 32 corners are as many as a hull may have."""


class Adapter(Engine):
    """A ``robox3d.World`` with 4 substeps, its default."""

    name = "robox3d"
    module = "robox3d"
    distribution = "robox3d"
    combines = "geometric mean"
    rolls = True
    notes = "4 substeps, 1 worker, sleeping off; a cylinder is a prism with 16 sides"

    def _build(self, scene: BenchScene, dt: float) -> None:
        robox3d = self.load()
        self.world = robox3d.World(gravity=scene.gravity, substeps=4, worker_count=1, enable_sleep=False)
        self.bodies = []
        for body, friction in zip(scene.bodies, self.coefficients(scene), strict=True):
            kind = "kinematic" if body.kinematic else "static" if body.density is None else "dynamic"
            made = self.world.create_body(body.position, xyzw(body.orientation), kind)
            self._add_shape(made, body.shape, density(body), friction, scene)
            if kind != "static":
                made.linear_velocity, made.angular_velocity = body.velocity, body.angular_velocity
            self.bodies.append(made)
        self.group = self.load("robox3d.core.batch").BodyGroup(self.bodies)

    def _add_shape(self, body: Any, shape: Shape, density: float, friction: float, scene: BenchScene) -> None:
        surface = {"density": density, "friction": friction, "restitution": scene.restitution}
        match shape:
            case Sphere():
                made = body.add_sphere(shape.radius, **surface)
                if scene.rolling:  # a share of the radius here; only the C interface has it
                    lib = self.load("robox3d._ffi").lib
                    material = lib.b3Shape_GetSurfaceMaterial(made)
                    material.rollingResistance = scene.rolling / shape.radius
                    lib.b3Shape_SetSurfaceMaterial(made, material)
            case Box():
                body.add_box([0.5 * s for s in shape.size], **surface)
            case Capsule():
                end = (0.0, 0.0, 0.5 * shape.length)
                body.add_capsule([-e for e in end], end, shape.radius, **surface)
            case Cylinder():
                body.add_hull(prism(shape), max_vertices=2 * SIDES, **surface)
            case ConvexHull():
                body.add_hull(shape.points, **surface)

    def _step(self) -> None:
        self.world.step(self.dt)

    def _drive(self, index: int, position: Array, orientation: Array, velocity: Array, spin: Array) -> None:
        self.bodies[index].linear_velocity = floats(velocity)
        self.bodies[index].angular_velocity = floats(spin)

    def _push(self, index: int, force: Array) -> None:
        self.bodies[index].apply_force(floats(force))

    def positions(self) -> Array:
        return np.array(self.group.poses()[:, :3], dtype=np.float64)

    def orientations(self) -> Array:
        return wxyz(self.group.poses()[:, 3:])

    def velocities(self) -> Array:
        return np.array(self.group.velocities()[:, :3], dtype=np.float64)

    def angular_velocities(self) -> Array:
        return np.array(self.group.velocities()[:, 3:], dtype=np.float64)


def prism(shape: Cylinder) -> Array:
    """Corners (32, 3) m of a prism inscribed in a cylinder."""
    angles = 2.0 * math.pi * np.arange(SIDES) / SIDES
    ring = np.stack([shape.radius * np.cos(angles), shape.radius * np.sin(angles)], axis=1)
    ends = [np.column_stack([ring, np.full(SIDES, sign * 0.5 * shape.length)]) for sign in (-1.0, 1.0)]
    return np.concatenate(ends)
