"""MuJoCo, from a model in its own language (MJCF).

MuJoCo's kinematic (mocap) bodies have no velocity and drag nothing along. So what turns about an axis is one body on a
hinge of very large inertia, with its angle and speed set before each step.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stiction.bench import rotations
from stiction.bench.engines.base import Array, Engine, density
from stiction.bench.scene import BenchBody, BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere

HINGE_INERTIA = 1e9
"""kg m^2, of what turns: no load changes its speed within a step."""


class Adapter(Engine):
    """An ``MjModel`` of free bodies, with the elliptic cone: the default pyramid gives other friction sideways."""

    name = "mujoco"
    module = "mujoco"
    distribution = "mujoco"
    notes = 'cone="elliptic" instead of the default pyramid, contact softness at its defaults'

    def supports(self, scene: BenchScene) -> str | None:
        if scene.restitution != 0.0:
            return "mujoco has no coefficient of restitution"
        return super().supports(scene)

    def _build(self, scene: BenchScene, dt: float) -> None:
        mujoco = self.load()
        self.mujoco = mujoco
        self.model = mujoco.MjModel.from_xml_string(model(scene, dt))
        self.data = mujoco.MjData(self.model)
        self.moving = np.flatnonzero(scene.dynamic)
        self.hinges = 0 if scene.turning is None else 1  # its angle and speed come before those of the free bodies
        for k, index in enumerate(self.moving):
            body = scene.bodies[index]
            spin = rotations.matrix(body.orientation).T @ np.array(body.angular_velocity)  # in the body's frame here
            start = self.hinges + 6 * k
            self.data.qvel[start : start + 6] = (*body.velocity, *spin)

    def before_step(self) -> None:
        turning = self.scene.turning
        if turning is not None:
            self.data.qpos[0], self.data.qvel[0] = turning.rate * self.steps * self.dt, turning.rate

    def _step(self) -> None:
        self.mujoco.mj_step(self.model, self.data)
        if self.data.warning.number.any():
            names = [str(self.mujoco.mjtWarning(i).name) for i in np.flatnonzero(self.data.warning.number)]
            raise RuntimeError(f"mujoco warned of {', '.join(names)}")

    def _poses(self) -> Array:
        return np.array(self.data.qpos[self.hinges :]).reshape(-1, 7)

    def positions(self) -> Array:
        rows = self.scene.positions.copy()
        rows[self.moving] = self._poses()[:, :3]
        for index, position, _ in self.scene.driven_at(self.steps * self.dt):
            rows[index] = position
        return rows

    def orientations(self) -> Array:
        rows = self.scene.orientations.copy()
        rows[self.moving] = self._poses()[:, 3:]
        for index, _, orientation in self.scene.driven_at(self.steps * self.dt):
            rows[index] = orientation
        return rows

    def velocities(self) -> Array:
        rows = np.zeros((len(self.scene.bodies), 3))
        rows[self.moving] = np.array(self.data.qvel[self.hinges :]).reshape(-1, 6)[:, :3]
        return rows


def model(scene: BenchScene, dt: float) -> str:
    """The scene in MJCF."""
    meshes: dict[int, str] = {}
    assets, bodies = [], [_turning(scene)]
    for body in scene.bodies:
        if body.kinematic:
            continue
        shape = body.shape
        if isinstance(shape, ConvexHull) and id(shape) not in meshes:
            meshes[id(shape)] = f"hull{len(meshes)}"
            points = _text(shape.points.ravel())
            assets.append(f'<mesh name="{meshes[id(shape)]}" inertia="convex" vertex="{points}"/>')
        bodies.append(_body(body, meshes.get(id(shape), ""), scene.friction))
    memory = max(64, len(scene.bodies) // 4)  # MiB; reserved, not touched
    return f"""<mujoco>
<compiler angle="radian"/>
<option timestep="{dt!r}" gravity="{_text(scene.gravity)}" cone="elliptic"/>
<size memory="{memory}M"/>
<asset>{"".join(assets)}</asset>
<worldbody>
{chr(10).join(bodies)}
</worldbody>
</mujoco>"""


def _body(body: BenchBody, mesh: str, friction: float) -> str:
    geometry = f"<geom {_geometry(body.shape, mesh)} {_surface(body, friction)}/>"
    pose = f'pos="{_text(body.position)}" quat="{_text(body.orientation)}"'
    return f"<body {pose}>{'<freejoint/>' if body.dynamic else ''}{geometry}</body>"


def _turning(scene: BenchScene) -> str:
    """One body on a hinge, with all kinematic bodies as its parts."""
    turning = scene.turning
    if turning is None:
        return ""
    parts = []
    for body in scene.bodies:
        if body.kinematic:
            pose = f'pos="{_text(np.array(body.position) - np.array(turning.center))}" quat="{_text(body.orientation)}"'
            parts.append(f"<geom {pose} {_geometry(body.shape, '')} {_surface(body, scene.friction)}/>")
    hinge = f'<joint type="hinge" axis="{_text(turning.axis)}" armature="{HINGE_INERTIA!r}"/>'
    return f'<body pos="{_text(turning.center)}">{hinge}{"".join(parts)}</body>'


def _surface(body: BenchBody, friction: float) -> str:
    meets = int(body.dynamic)  # what is not dynamic meets only what is
    return f'friction="{friction!r} 0.005 0.0001" density="{density(body)!r}" conaffinity="{meets}"'


def _geometry(shape: Shape, mesh: str) -> str:
    match shape:
        case Sphere():
            return f'type="sphere" size="{shape.radius!r}"'
        case Box():
            return f'type="box" size="{_text(0.5 * s for s in shape.size)}"'
        case Capsule() | Cylinder():
            return f'type="{shape.kind}" size="{shape.radius!r} {0.5 * shape.length!r}"'
        case ConvexHull():
            return f'type="mesh" mesh="{mesh}"'
    raise TypeError(f"no geom for {shape!r}")


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
