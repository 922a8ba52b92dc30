"""Rapier through its own Python package."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stiction.bench import rotations
from stiction.bench.engines.base import Array, Engine, density, floats
from stiction.bench.scene import BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere


class Adapter(Engine):
    """A ``rapier3d.PhysicsWorld`` with its default parameters."""

    name = "rapier3d"
    module = "rapier3d"
    distribution = "rapier3d"
    notes = "default friction model and 4 iterations, 1 thread, sleeping off"

    def _build(self, scene: BenchScene, dt: float) -> None:
        rapier = self.load()
        world = rapier.PhysicsWorld(gravity=scene.gravity)
        world.integration_parameters.dt = dt
        world.set_num_threads(1)
        self.handles = []
        for body, friction in zip(scene.bodies, self.coefficients(scene), strict=True):
            if body.kinematic:
                builder = rapier.RigidBody.kinematic_velocity_based()
            elif body.density is None:
                builder = rapier.RigidBody.fixed()
            else:
                builder = rapier.RigidBody.dynamic()
            builder = builder.translation(floats(body.position))
            builder = builder.rotation(floats(rotations.rotation_vector(body.orientation)))
            builder = builder.linvel(floats(body.velocity)).angvel(floats(body.angular_velocity))
            builder = builder.linear_damping(0.0).angular_damping(0.0).can_sleep(False)
            collider = self._collider(rapier, body.shape).density(density(body))
            collider = collider.friction(friction).restitution(scene.restitution)
            self.handles.append(world.add_body(builder, [collider]))
        self.world = world

    @staticmethod
    def _collider(rapier: Any, shape: Shape) -> Any:
        match shape:
            case Sphere():
                return rapier.Collider.ball(shape.radius)
            case Box():
                return rapier.Collider.cuboid(*(0.5 * s for s in shape.size))
            case Capsule():
                return rapier.Collider.capsule_z(0.5 * shape.length, shape.radius)
            case Cylinder():  # along y in Rapier
                return rapier.Collider.cylinder(0.5 * shape.length, shape.radius).rotation((0.5 * math.pi, 0.0, 0.0))
            case ConvexHull():
                return rapier.Collider.convex_hull(np.ascontiguousarray(shape.points, dtype=np.float32))
        raise TypeError(f"no collider for {shape!r}")

    def _step(self) -> None:
        self.world.step()

    def _drive(self, index: int, position: Array, orientation: Array, velocity: Array, spin: Array) -> None:
        body = self.world.rigid_bodies[self.handles[index]]
        body.linvel, body.angvel = floats(velocity), floats(spin)

    def _push(self, index: int, force: Array) -> None:
        body = self.world.rigid_bodies[self.handles[index]]
        body.reset_forces()  # they last until they are taken back
        body.add_force(floats(force))

    def _bodies(self) -> list[Any]:
        bodies = self.world.rigid_bodies
        return [bodies[handle] for handle in self.handles]

    def positions(self) -> Array:
        rows = [(p.x, p.y, p.z) for p in (body.translation for body in self._bodies())]
        return np.array(rows, dtype=np.float64)

    def orientations(self) -> Array:
        rows = [(q.w, q.i, q.j, q.k) for q in (body.rotation for body in self._bodies())]
        return np.array(rows, dtype=np.float64)

    def velocities(self) -> Array:
        rows = [(v.x, v.y, v.z) for v in (body.linvel for body in self._bodies())]
        return np.array(rows, dtype=np.float64)

    def angular_velocities(self) -> Array:
        rows = [(w.x, w.y, w.z) for w in (body.angvel for body in self._bodies())]
        return np.array(rows, dtype=np.float64)
