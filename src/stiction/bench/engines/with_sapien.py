"""PhysX 5 through SAPIEN, without its renderer."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from stiction.bench.engines.base import Array, Engine, density, floats
from stiction.bench.scene import BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere

X_TO_Z = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)
"""The turn that brings PhysX' axis of capsules and cylinders, x, to z."""


class Adapter(Engine):
    """A ``PhysxCpuSystem`` with the TGS solver, SAPIEN's default."""

    name = "sapien"
    module = "sapien"
    distribution = "sapien"
    two_coefficients = True
    usual_dt = 0.01
    notes = "TGS with 10 + 1 iterations, sleep threshold 0, damping 0"

    def _build(self, scene: BenchScene, dt: float) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the renderer, which is not used
            sapien, physx = self.load(), self.load("sapien.physx")
        self.sapien = sapien
        config = physx.get_scene_config()
        config.gravity = np.array(scene.gravity, dtype=np.float32)
        physx.set_scene_config(config)
        physx.set_body_config(sleep_threshold=0.0)
        self.system = physx.PhysxCpuSystem()
        self.system.timestep = dt
        self.world = sapien.Scene([self.system])
        ratio = 1.0 if scene.dynamic_friction is None else scene.dynamic_friction / scene.friction
        self.components = []
        for body, friction in zip(scene.bodies, self.coefficients(scene), strict=True):
            material = physx.PhysxMaterial(friction, ratio * friction, scene.restitution)
            fixed = body.density is None and not body.kinematic
            component = physx.PhysxRigidStaticComponent() if fixed else physx.PhysxRigidDynamicComponent()
            shape = self._shape(physx, body.shape, material)
            shape.density = density(body)
            component.attach(shape)
            if not fixed:
                component.linear_damping = component.angular_damping = 0.0
                component.sleep_threshold = 0.0
                component.kinematic = body.kinematic
            entity = sapien.Entity()
            entity.add_component(component)
            entity.pose = sapien.Pose(floats(body.position), floats(np.array(body.orientation)))
            self.world.add_entity(entity)
            if body.dynamic:
                component.linear_velocity = floats(body.velocity)
                component.angular_velocity = floats(body.angular_velocity)
            self.components.append(component)
        self.entities = [component.entity for component in self.components]

    def _shape(self, physx: Any, shape: Shape, material: Any) -> Any:
        match shape:
            case Sphere():
                return physx.PhysxCollisionShapeSphere(shape.radius, material)
            case Box():
                return physx.PhysxCollisionShapeBox([0.5 * s for s in shape.size], material)
            case Capsule() | Cylinder():
                kind = (
                    physx.PhysxCollisionShapeCapsule if shape.kind == "capsule" else physx.PhysxCollisionShapeCylinder
                )
                made = kind(shape.radius, 0.5 * shape.length, material)
                made.local_pose = self.sapien.Pose([0.0, 0.0, 0.0], list(X_TO_Z))
                return made
            case ConvexHull():
                points = np.ascontiguousarray(shape.points, dtype=np.float32)
                return physx.PhysxCollisionShapeConvexMesh(points, np.ones(3, dtype=np.float32), material)
        raise TypeError(f"no collision shape for {shape!r}")

    def _step(self) -> None:
        self.system.step()

    def _drive(self, index: int, position: Array, orientation: Array, velocity: Array, spin: Array) -> None:
        self.components[index].kinematic_target = self.sapien.Pose(floats(position), floats(orientation))

    def _push(self, index: int, force: Array) -> None:
        self.components[index].add_force_torque(np.array(force, np.float32), np.zeros(3, np.float32))

    def positions(self) -> Array:
        return np.array([entity.pose.p for entity in self.entities], dtype=np.float64)

    def orientations(self) -> Array:
        return np.array([entity.pose.q for entity in self.entities], dtype=np.float64)

    def velocities(self) -> Array:
        zero = np.zeros(3)
        dynamic = self.scene.dynamic
        rows = [c.linear_velocity if dynamic[i] else zero for i, c in enumerate(self.components)]
        return np.array(rows, dtype=np.float64)

    def angular_velocities(self) -> Array:
        zero = np.zeros(3)
        dynamic = self.scene.dynamic
        rows = [c.angular_velocity if dynamic[i] else zero for i, c in enumerate(self.components)]
        return np.array(rows, dtype=np.float64)
