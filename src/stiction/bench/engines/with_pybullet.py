"""Bullet through pybullet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stiction.bench.engines.base import Array, Engine, density, floats, wxyz, xyzw
from stiction.bench.scene import BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere


class Adapter(Engine):
    """A client without a window. Bullet multiplies coefficients, so each body gets their square root."""

    name = "pybullet"
    module = "pybullet"
    distribution = "pybullet"
    drives = False
    rolls = True
    combines = "product"
    usual_dt = 1.0 / 240.0
    notes = "damping 0, sleeping off, 50 iterations; hulls get the diagonal of their inertia tensor only"

    def _build(self, scene: BenchScene, dt: float) -> None:
        p = self.load()
        self.client = self.load("pybullet_utils.bullet_client").BulletClient(p.DIRECT)
        client = self.client
        client.setGravity(*floats(scene.gravity))
        client.setPhysicsEngineParameter(fixedTimeStep=dt)
        shapes: dict[int, int] = {}
        self.bodies = []
        for body, friction in zip(scene.bodies, self.coefficients(scene), strict=True):
            shape = body.shape
            if id(shape) not in shapes:
                shapes[id(shape)] = self._shape(p, shape)
            properties = shape.mass_properties
            mass = density(body) * properties.volume if body.dynamic else 0.0
            made = client.createMultiBody(mass, shapes[id(shape)], -1, floats(body.position), xyzw(body.orientation))
            surface = {"lateralFriction": friction, "restitution": math.sqrt(scene.restitution)}
            if scene.rolling:  # of a pair: r_a mu_b + r_b mu_a
                surface["rollingFriction"] = 0.5 * scene.rolling / friction
            still = {"linearDamping": 0.0, "angularDamping": 0.0}
            client.changeDynamics(made, -1, **surface, **still, activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING)
            if body.dynamic:
                if isinstance(shape, ConvexHull):
                    inertia = density(body) * np.diag(properties.inertia)
                    client.changeDynamics(made, -1, localInertiaDiagonal=floats(inertia))
                client.resetBaseVelocity(made, floats(body.velocity), floats(body.angular_velocity))
            self.bodies.append(made)

    def _shape(self, p: Any, shape: Shape) -> int:
        make = self.client.createCollisionShape
        match shape:
            case Sphere():
                made = make(p.GEOM_SPHERE, radius=shape.radius)
            case Box():
                made = make(p.GEOM_BOX, halfExtents=[0.5 * s for s in shape.size])
            case Capsule():
                made = make(p.GEOM_CAPSULE, radius=shape.radius, height=shape.length)
            case Cylinder():
                made = make(p.GEOM_CYLINDER, radius=shape.radius, height=shape.length)
            case ConvexHull():
                made = make(p.GEOM_MESH, vertices=shape.points.tolist())
            case _:
                raise TypeError(f"no collision shape for {shape!r}")
        return int(made)

    def _step(self) -> None:
        self.client.stepSimulation()

    def _push(self, index: int, force: Array) -> None:
        body = self.bodies[index]
        center = self.client.getBasePositionAndOrientation(body)[0]
        self.client.applyExternalForce(body, -1, floats(force), center, self.load().WORLD_FRAME)

    def positions(self) -> Array:
        return np.array([self.client.getBasePositionAndOrientation(body)[0] for body in self.bodies])

    def orientations(self) -> Array:
        return wxyz(np.array([self.client.getBasePositionAndOrientation(body)[1] for body in self.bodies]))

    def velocities(self) -> Array:
        return np.array([self.client.getBaseVelocity(body)[0] for body in self.bodies])

    def angular_velocities(self) -> Array:
        return np.array([self.client.getBaseVelocity(body)[1] for body in self.bodies])
