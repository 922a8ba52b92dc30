"""MuJoCo, from a model in its own language (MJCF).

MuJoCo's kinematic (mocap) bodies have no velocity and drag nothing along. So what turns about an axis is one body on a
hinge of very large inertia, with its angle and speed set before each step; what glides is one on three slides.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stiction.bench import rotations
from stiction.bench.engines.base import Array, Engine, density
from stiction.bench.scene import BenchBody, BenchScene
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Shape, Sphere

HINGE_INERTIA = 1e9
"""kg m^2 of what turns, kg of what glides: no load changes its speed within a step."""


class Adapter(Engine):
    """An ``MjModel`` of free bodies, with the elliptic cone: the default pyramid gives other friction sideways."""

    name = "mujoco"
    module = "mujoco"
    distribution = "mujoco"
    kinds = Engine.kinds | {"ellipsoid"}
    rolls = True
    bounces = False
    combines = "maximum"
    usual_dt = 0.002
    cone = "elliptic"
    notes = 'cone="elliptic" instead of the default pyramid, contact softness at its defaults'

    def _build(self, scene: BenchScene, dt: float) -> None:
        mujoco = self.load()
        self.mujoco = mujoco
        self.model = mujoco.MjModel.from_xml_string(model(scene, dt, self.cone, self.coefficients(scene)))
        self.data = mujoco.MjData(self.model)
        self.moving = np.flatnonzero(scene.dynamic)
        order = [i for i, body in enumerate(scene.bodies) if not body.kinematic]
        first = (
            1 if self.scene.turning is None and self.scene.gliding is None else 2
        )  # 0 is the world, 1 what is driven
        self.numbers = {index: first + k for k, index in enumerate(order)}
        # what is driven comes before the free bodies: the angle of a hinge, or three ways
        self.hinges = 3 if scene.gliding is not None else 1 if scene.turning is not None else 0
        for k, index in enumerate(self.moving):
            body = scene.bodies[index]
            spin = rotations.matrix(body.orientation).T @ np.array(body.angular_velocity)  # in the body's frame here
            start = self.hinges + 6 * k
            self.data.qvel[start : start + 6] = (*body.velocity, *spin)

    def before_step(self) -> None:
        self._push_all()
        turning, gliding, time = self.scene.turning, self.scene.gliding, self.steps * self.dt
        if gliding is not None:
            here, there = gliding.moved(time), gliding.moved(time + self.dt)
            self.data.qpos[:3], self.data.qvel[:3] = here, (there - here) / self.dt
        elif turning is not None:
            self.data.qpos[0], self.data.qvel[0] = turning.rate * time, turning.rate

    def _push(self, index: int, force: Array) -> None:
        self.data.xfrc_applied[self.numbers[index], :3] = force

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

    def angular_velocities(self) -> Array:
        rows = np.zeros((len(self.scene.bodies), 3))
        own = np.array(self.data.qvel[self.hinges :]).reshape(-1, 6)[:, 3:]  # in the body's frame
        rows[self.moving] = np.einsum("nij,nj->ni", rotations.matrix(self._poses()[:, 3:]), own)
        return rows


class Pyramidal(Adapter):
    """MuJoCo as it comes."""

    cone = "pyramidal"
    notes = "contact softness at its defaults"


def model(scene: BenchScene, dt: float, cone: str, coefficients: list[float]) -> str:
    """The scene in MJCF, with a coefficient of friction for each body."""
    meshes: dict[int, str] = {}
    surfaces = [_surface(body, mu, scene.rolling) for body, mu in zip(scene.bodies, coefficients, strict=True)]
    assets, bodies = [], [_driven(scene, surfaces)]
    for body, surface in zip(scene.bodies, surfaces, strict=True):
        if body.kinematic:
            continue
        shape = body.shape
        if isinstance(shape, ConvexHull) and id(shape) not in meshes:
            meshes[id(shape)] = f"hull{len(meshes)}"
            points = _text(shape.points.ravel())
            assets.append(f'<mesh name="{meshes[id(shape)]}" inertia="convex" vertex="{points}"/>')
        bodies.append(_body(body, meshes.get(id(shape), ""), surface))
    memory = max(64, len(scene.bodies) // 4)  # MiB; reserved, not touched
    return f"""<mujoco>
<compiler angle="radian"/>
<option timestep="{dt!r}" gravity="{_text(scene.gravity)}" cone="{cone}"/>
<size memory="{memory}M"/>
<asset>{"".join(assets)}</asset>
<worldbody>
{chr(10).join(bodies)}
</worldbody>
</mujoco>"""


def _body(body: BenchBody, mesh: str, surface: str) -> str:
    geometry = f"<geom {_geometry(body.shape, mesh)} {surface}/>"
    pose = f'pos="{_text(body.position)}" quat="{_text(body.orientation)}"'
    return f"<body {pose}>{'<freejoint/>' if body.dynamic else ''}{geometry}</body>"


def _driven(scene: BenchScene, surfaces: list[str]) -> str:
    """One body on a hinge, or on three slides, with all kinematic bodies as its parts."""
    turning, gliding = scene.turning, scene.gliding
    center = np.zeros(3) if turning is None else np.array(turning.center)
    parts = []
    for body, surface in zip(scene.bodies, surfaces, strict=True):
        if body.kinematic:
            pose = f'pos="{_text(np.array(body.position) - center)}" quat="{_text(body.orientation)}"'
            parts.append(f"<geom {pose} {_geometry(body.shape, '')} {surface}/>")
    joints = ""
    if gliding is not None:
        joints = "".join(
            f'<joint type="slide" axis="{axis}" armature="{HINGE_INERTIA!r}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1")
        )
    elif turning is not None:
        joints = f'<joint type="hinge" axis="{_text(turning.axis)}" armature="{HINGE_INERTIA!r}"/>'
    return f'<body pos="{_text(center)}">{joints}{"".join(parts)}</body>' if joints else ""


def _surface(body: BenchBody, friction: float, rolling: float) -> str:
    meets = int(body.dynamic)  # what is not dynamic meets only what is
    size = "6" if rolling else "3"  # dimensions of the cone: with rolling, and with spinning, which goes along with it
    surface = f'friction="{friction!r} {0.0 if rolling else 0.005!r} {rolling or 0.0001!r}" condim="{size}"'
    return f'{surface} density="{density(body)!r}" conaffinity="{meets}"'


def _geometry(shape: Shape, mesh: str) -> str:
    match shape:
        case Sphere():
            return f'type="sphere" size="{shape.radius!r}"'
        case Box():
            return f'type="box" size="{_text(0.5 * s for s in shape.size)}"'
        case Capsule() | Cylinder():
            return f'type="{shape.kind}" size="{shape.radius!r} {0.5 * shape.length!r}"'
        case Ellipsoid():
            return f'type="ellipsoid" size="{_text(shape.half_extents)}"'
        case ConvexHull():
            return f'type="mesh" mesh="{mesh}"'
    raise TypeError(f"no geom for {shape!r}")


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
