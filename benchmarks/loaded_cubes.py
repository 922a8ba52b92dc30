"""Adapters whose cubes are loaded on one side: the centre of mass beside the middle, and an inertia of their own.

Scenes for benchmarks know bodies of even density only. Here all that moves are cubes that share a mass, a centre of
mass and an inertia (about the centre of mass, alike about all axes). Positions stay those of the middle of a cube; the
velocity of a body in the scene is that of its centre of mass.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.bench import rotations
from stiction.bench.engines import engine_class
from stiction.bench.engines.with_mujoco import model
from stiction.bench.scene import BenchScene

Array = NDArray[np.float64]

MASS = 0.37
"""kg."""


class Loaded:
    """A mixin of an adapter.

    Args:
        center: (3,) m, of mass, from the middle, in the cube's axes.
        inertia: kg m^2 about it. restitution: for engines that have it only as the damping of their contacts.
    """

    def __init__(self, center: Array, inertia: float, restitution: float) -> None:
        super().__init__()
        self.center, self.inertia, self.restitution = center, inertia, restitution


class Stiction(Loaded, engine_class("stiction")):  # type: ignore[misc]  # the class is known at run time only
    def _build(self, scene: BenchScene, dt: float) -> None:
        self.world = self._world(scene, dt)
        floor, *cubes = scene.bodies
        self.world.add(floor.shape, static=True, position=floor.position)
        for body in cubes:
            moves = {"velocity": body.velocity, "angular_velocity": body.angular_velocity}
            own = {"mass": MASS, "inertia": (self.inertia,) * 3, "center_of_mass": self.center}
            self.world.add(body.shape, position=body.position, orientation=body.orientation, **own, **moves)


class Mujoco(Loaded, engine_class("mujoco")):  # type: ignore[misc]  # see above
    def _build(self, scene: BenchScene, dt: float) -> None:
        super()._build(scene, dt)
        place, inertia = (" ".join(repr(float(v)) for v in values) for values in (self.center, [self.inertia] * 3))
        own = f'<freejoint/><inertial pos="{place}" mass="{MASS!r}" diaginertia="{inertia}"/>'
        text = model(scene, dt, self.cone, self.coefficients(scene)).replace("<freejoint/>", own)
        speeds = self.data.qvel
        self.model = self.mujoco.MjModel.from_xml_string(text)
        self.data = self.mujoco.MjData(self.model)
        self.data.qvel[:] = speeds
        for k, index in enumerate(self.moving):  # a free joint has the velocity of the middle
            body = scene.bodies[index]
            arm = rotations.matrix(body.orientation) @ self.center
            self.data.qvel[6 * k : 6 * k + 3] = body.velocity - np.cross(body.angular_velocity, arm)
        logarithm = math.log(max(self.restitution, 1e-3))
        self.model.geom_solref[:, 1] = -logarithm / math.hypot(math.pi, logarithm)


class Pybullet(Loaded, engine_class("pybullet")):  # type: ignore[misc]  # see above
    """A body's frame is that of its centre of mass here, so the cube is moved in it, and back when it is asked."""

    def _shape(self, p: Any, shape: Any) -> int:
        half = [0.5 * s for s in shape.size]
        off = [0.0] * 3 if half[0] > 1.0 else (-self.center).tolist()  # the ground is as it is
        return int(self.client.createCollisionShape(p.GEOM_BOX, halfExtents=half, collisionFramePosition=off))

    def _build(self, scene: BenchScene, dt: float) -> None:
        super()._build(scene, dt)
        for index in np.flatnonzero(scene.dynamic):
            made, body = self.bodies[index], scene.bodies[index]
            place = np.array(body.position) + rotations.matrix(body.orientation) @ self.center
            x, y, z, w = (body.orientation[k] for k in (1, 2, 3, 0))
            self.client.resetBasePositionAndOrientation(made, place.tolist(), [x, y, z, w])
            self.client.resetBaseVelocity(made, list(body.velocity), list(body.angular_velocity))
            self.client.changeDynamics(made, -1, localInertiaDiagonal=[self.inertia] * 3)

    def positions(self) -> Array:
        found = super().positions()
        turns = rotations.matrix(self.orientations())
        return np.where(self.scene.dynamic[:, None], found - turns @ self.center, found)


class Rapier3d(Loaded, engine_class("rapier3d")):  # type: ignore[misc]  # see above
    """Rapier adds mass to what its shapes have: half of it is even, the other half lies twice as far off the middle."""

    def _build(self, scene: BenchScene, dt: float) -> None:
        light = [replace(body, density=0.5 * body.density) if body.dynamic else body for body in scene.bodies]
        super()._build(replace(scene, bodies=tuple(light)), dt)
        for index in np.flatnonzero(scene.dynamic):
            body = scene.bodies[index]
            even = 0.5 * MASS * body.shape.size[0] ** 2 / 6.0
            arms = MASS * (self.center @ self.center - self.center**2)
            rest = self.inertia - even - arms
            more = self.load().MassProperties((2.0 * self.center).tolist(), 0.5 * MASS, rest.tolist())
            self.world.rigid_bodies[self.handles[index]].set_additional_mass_properties(more, True)


class Robox3d(Loaded, engine_class("robox3d")):  # type: ignore[misc]  # see above
    def _build(self, scene: BenchScene, dt: float) -> None:
        super()._build(scene, dt)
        for index in np.flatnonzero(scene.dynamic):
            body = scene.bodies[index]
            self.bodies[index].set_mass_data(MASS, self.center, self.inertia * np.eye(3))
            self.bodies[index].linear_velocity = body.velocity  # of the centre of mass that it has now


LOADED = {"stiction": Stiction, "mujoco": Mujoco, "pybullet": Pybullet, "rapier3d": Rapier3d, "robox3d": Robox3d}
"""By the engine's name."""
