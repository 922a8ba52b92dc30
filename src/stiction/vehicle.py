"""A vehicle: a chassis that is a body of the world, and wheels that are rays from it with a spin of their own.

Each wheel looks for the ground along the chassis' downward axis. A spring and damper carry the chassis over it, and the
tyre gives the friction that the law of its pair says for the slip it has (:mod:`stiction.laws`), in combined slip. The
forces act on the chassis, and their opposites on the ground where it can move. How they are found is told in
:mod:`stiction.tyre_forces`.

Wheels are no bodies, because nothing outside a step can hold a light wheel to a heavy chassis stiffly enough while the
step itself finds what its tyre does: with wheels as bodies, guided by springs, a car with locked wheels stops several
per cent too late at 1/60 s. Nothing but the ground below it touches a wheel, therefore.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.body import Body
from stiction.errors import InvalidInputError
from stiction.queries import RayHit
from stiction.shapes import Cylinder
from stiction.wheels import VehicleWork, Wheel, WheelState, rest_shares
from stiction.world import World

if TYPE_CHECKING:
    from stiction.tyre_forces import Found

Array = NDArray[np.float64]

MOST_STEER_DEG = 70.0
"""Largest steering angle, degrees."""
MOST_HITS = 8
"""Bodies that a ray looks at: the chassis, and what there is above the ground."""
LEAST_UPRIGHT = 0.1
"""Cosine between the ground's normal and the chassis' axis below which a wheel does not stand on it."""


@dataclass
class _Run:
    """What changes from step to step, an entry a wheel."""

    spin: Array
    angle: Array
    alpha: Array
    sliding: NDArray[np.bool_]
    lift: Array
    """Of the hubs above where they are at rest, m."""
    work: Array = field(default_factory=lambda: np.zeros(4))


class Vehicle:
    """A chassis on wheels.

    >>> import stiction as st
    >>> world = st.World()
    >>> world.materials.set_pair("tyre", "road", static=1.0, dynamic=0.9, law=st.BrushTyre(15))
    >>> road = world.add(st.Plane(), static=True, material="road")
    >>> body = world.add(st.Box((4, 1.6, 0.5)), mass=1200, position=(0, 0, 0.55), velocity=(20, 0, 0))
    >>> wheels = st.four_wheels(front=1.3, rear=-1.3, track=1.5, hub_height=-0.25, tyre="tyre")
    >>> car = st.Vehicle(world, body, wheels)
    >>> car.brake = 1.0
    >>> car.step(160)
    >>> round(float(body.position[0]), 1)
    22.6

    Args:
        world: where it drives. chassis: a dynamic body of it; x points forwards, y to the left, z up.
        wheels: three or more, not in one line; :func:`four_wheels` makes those of a car.
        frequency: of the suspension, Hz: how the load of each wheel would bounce on its spring.
        damping: its damping ratio.
        drive_torque: at full throttle, N m, of all wheels together. brake_torque: at full brake, N m.
        visible: add a kinematic cylinder for each wheel that meets nothing, to be looked at.

    Raises:
        InvalidInputError: a value is not allowed; the world is as before.
    """

    def __init__(
        self,
        world: World,
        chassis: Body,
        wheels: Iterable[Wheel],
        *,
        frequency: float = 1.5,
        damping: float = 0.5,
        drive_torque: float = 2000.0,
        brake_torque: float = 10_000.0,
        visible: bool = True,
    ) -> None:
        world._own("chassis", chassis)
        if chassis.mobility != "dynamic":
            raise InvalidInputError(f"chassis must be dynamic, and {chassis.name!r} is {chassis.mobility}.")
        self.world, self.chassis, self.wheels = world, chassis, tuple(wheels)
        for wheel in self.wheels:
            if wheel.material not in world.materials:
                world.materials.pair(wheel.material, wheel.material)  # raises, and names the nearest one
        places = np.array([wheel.position for wheel in self.wheels]).reshape(-1, 3)
        self._places = places
        shares = rest_shares(places, _center(chassis))
        frequency = checks.positive("frequency", frequency, "Hz")
        ratio = checks.non_negative("damping", damping)
        self._drive_torque = checks.non_negative("drive_torque", drive_torque, "N m")
        self._brake_torque = checks.non_negative("brake_torque", brake_torque, "N m")
        carried = shares * chassis.mass
        self._carried = carried
        self._stiffness = carried * (2.0 * math.pi * frequency) ** 2
        self._damping = 2.0 * ratio * np.sqrt(self._stiffness * carried)
        self._throttle = self._brake = self._steer = 0.0
        k = len(self.wheels)
        self._radius = np.array([wheel.radius for wheel in self.wheels])
        self._run = _Run(np.zeros(k), np.zeros(k), np.ones(k), np.zeros(k, np.bool_), np.zeros(k))
        self._run.spin = self._hub_velocities(np.zeros(k))[:, 0] / self._radius
        self._states = [WheelState(None, 0.0, 0.0, 0.0, np.zeros(2), 0.0, w, 0.0) for w in self._run.spin.tolist()]
        self._applied = -1
        self._table: tuple[tuple[int, tuple[str, ...]], Array] | None = None
        self._shown: list[Body] = self._add_wheels() if visible else []

    def __repr__(self) -> str:
        return f"<Vehicle on {self.chassis.name!r} with {len(self.wheels)} wheels, {self.speed:.3g} m/s>"

    # --- controls -----------------------------------------------------------------------------------------------------

    @property
    def throttle(self) -> float:
        """Part of the drive torque, -1 to 1."""
        return self._throttle

    @throttle.setter
    def throttle(self, value: float) -> None:
        self._throttle = _within("throttle", value, -1.0, 1.0)

    @property
    def brake(self) -> float:
        """Part of the brake torque, 0 to 1."""
        return self._brake

    @brake.setter
    def brake(self, value: float) -> None:
        self._brake = _within("brake", value, 0.0, 1.0)

    @property
    def steer(self) -> float:
        """Steering angle of the middle of the steered axle, rad to the left; see :meth:`steering_angles`."""
        return self._steer

    @steer.setter
    def steer(self, value: float) -> None:
        self._steer = _within("steer", value, -math.radians(MOST_STEER_DEG), math.radians(MOST_STEER_DEG))

    # --- what it does -------------------------------------------------------------------------------------------------

    @property
    def speed(self) -> float:
        """Along the chassis' x, m/s."""
        R = self.world._rotation(self.chassis.index)
        return float(R[:, 0] @ self.chassis.velocity)

    @property
    def states(self) -> tuple[WheelState, ...]:
        """What each wheel did in the last step."""
        return tuple(self._states)

    @property
    def work(self) -> VehicleWork:
        """Where its energy went so far. The world's ledger has what tyres lose as friction, the rest as work."""
        return VehicleWork(*self._run.work.tolist())

    def steering_angles(self) -> Array:
        """Angle of each wheel, (k,), rad to the left.

        All axles point to one centre on the line of those that are not steered (Ackermann).
        """
        angles = np.zeros(len(self.wheels))
        if self._steer == 0.0:
            return angles
        steered = [wheel.position[0] for wheel in self.wheels if wheel.steered]
        fixed = [wheel.position[0] for wheel in self.wheels if not wheel.steered]
        if not steered:
            return angles
        line = float(np.mean(fixed)) if fixed else 0.0
        middle = float(np.mean(steered))
        if abs(middle - line) < 1e-9:
            return np.array([self._steer if wheel.steered else 0.0 for wheel in self.wheels])
        center = (middle - line) / math.tan(self._steer)
        for k, wheel in enumerate(self.wheels):
            if wheel.steered:
                x, y, _ = wheel.position
                angles[k] = math.atan((x - line) / (center - y))
        return angles

    def step(self, n: int = 1) -> None:
        """Take n steps of the world with the controls as they are. See :meth:`apply` for several vehicles.

        Raises:
            InvalidInputError: n is not a whole number, 1 or more.
            SimulationError: as in :meth:`World.step`.
        """
        for _ in range(checks.integer("n", n, minimum=1)):
            self.apply()
            self.world.step()

    def apply(self) -> None:
        """Apply the forces of the wheels for the coming step; once before each :meth:`World.step`.

        Raises:
            InvalidInputError: it was called before in this step.
        """
        from stiction.tyre_forces import Wheels, solve_wheels

        world, chassis, run = self.world, self.chassis, self._run
        if self._applied == world.steps:
            raise InvalidInputError("apply of a vehicle must be called once a step, got a second call.")
        self._applied = world.steps
        dt = world.dt
        R, velocity = world._rotation(chassis.index), np.concatenate([chassis.velocity, chassis.angular_velocity])
        center = chassis.position + R @ _center(chassis)
        inverse = np.zeros((6, 6))
        inverse[:3, :3] = np.eye(3) / chassis.mass
        inverse[3:, 3:] = world._world_inverse_inertia(chassis.index)
        pending = np.concatenate([chassis._get("FORCE", 3), chassis._get("TORQUE", 3)])
        free = velocity + dt * (inverse @ pending)
        free[:3] += world.gravity * dt

        steer, hits = self.steering_angles(), self._look_down(R)
        on = [k for k, hit in enumerate(hits) if hit is not None]
        share = np.array([[wheel.drive, wheel.brake] for wheel in self.wheels])
        drive = share[:, 0] * (self._throttle * self._drive_torque)
        brake = share[:, 1] * (self._brake * self._brake_torque)
        inertia = np.array([wheel.inertia for wheel in self.wheels])
        self._states = [WheelState(None, 0.0, 0.0, 0.0, np.zeros(2), 0.0, 0.0, a) for a in steer.tolist()]
        old_spin = run.spin.copy()
        # wheels in the air
        turned = old_spin + dt / inertia * drive
        run.spin = np.sign(turned) * np.maximum(np.abs(turned) - dt / inertia * brake, 0.0)
        taken = (run.spin - turned) * inertia / dt
        total = np.zeros(6)
        if on:
            J, hub, ground, push = self._geometry(R, center, steer, hits, on)
            found = solve_wheels(
                Wheels(
                    J=J,
                    hub=hub,
                    ground=ground,
                    push=push,
                    damping=self._damping[on] + self._stiffness[on] * dt,
                    spin=old_spin[on],
                    radius=self._radius[on],
                    inertia=inertia[on],
                    drive=drive[on],
                    brake=brake[on],
                    rows=self._rows(hits, on),
                ),
                inverse,
                free,
                dt,
                self._pair_table(hits),
                run.alpha[on],
                run.sliding[on],
            )
            run.spin[on], run.alpha[on], run.sliding[on], taken[on] = (
                found.spin, found.alpha, found.sliding, found.brake
            )  # fmt: skip
            total = J.T @ found.force.ravel()
            self._tell(found, on, hits, steer)
            self._press(hits, on, J, found.force)
            before = (J @ velocity - ground).reshape(-1, 3)
            slip = np.stack([before[:, 1] - self._radius[on] * old_spin[on], before[:, 2]], axis=1)
            lost = -0.5 * dt * float((found.force[:, 1:] * (slip + found.slip)).sum())
            run.work[1] += lost
            world._note_friction(chassis.index, lost)
            opening = (J @ (free + dt * (inverse @ total)) - ground)[0::3]
            run.work[3] += dt * float((self._damping[on] * opening**2)[found.force[:, 0] > 0.0].sum())
        # what a wheel's spin gains or loses the chassis feels
        axles = np.stack([-np.sin(steer), np.cos(steer), np.zeros(len(steer))], axis=1) @ R.T
        total[3:] -= (inertia * (run.spin - old_spin) / dt) @ axles
        mean = 0.5 * (run.spin + old_spin)
        run.work[0] += dt * float(drive @ mean)
        run.work[2] -= dt * float(taken @ mean)
        chassis.apply_force(total[:3])
        chassis.apply_torque(total[3:])
        run.angle += dt * mean
        self._states = [state._replace(spin=w) for state, w in zip(self._states, run.spin.tolist(), strict=True)]
        self._move_wheels(R, steer, velocity + 0.5 * dt * (inverse @ (total + pending)), mean)

    # --- inside -------------------------------------------------------------------------------------------------------

    def _look_down(self, R: Array) -> list[RayHit | None]:
        """The ground under each wheel. The ray begins a diameter above the hub, so that no kerb swallows it."""
        droop = self._weights() / self._stiffness
        radius = self._radius
        starts = self.chassis.position + (self._places + 2.0 * radius[:, None] * (0.0, 0.0, 1.0)) @ R.T
        ways = np.broadcast_to(-R[:, 2], starts.shape).copy()
        reach = 3.0 * radius + droop
        rows, bodies, counts = self.world._cast(starts, ways, float(reach.max()), checks.ALL_LAYERS, MOST_HITS)
        found: list[RayHit | None] = []
        lift = -droop
        for k, count in enumerate(counts.tolist()):
            found.append(None)
            for row, index in zip(rows[k, :count], bodies[k, :count].tolist(), strict=True):
                upright = row[1:4] @ R[:, 2] > LEAST_UPRIGHT
                if index != self.chassis.index and upright and row[0] <= reach[k]:
                    body = self.world._bodies[index]
                    found[k] = RayHit(body, starts[k] + row[0] * ways[k], row[1:4].copy(), float(row[0]))
                    lift[k] = 3.0 * radius[k] - row[0]
                    break
        self._run.lift = lift
        return found

    def _weights(self) -> Array:
        """What each wheel carries at rest on level ground, (k,), N."""
        return self._carried * float(np.linalg.norm(self.world.gravity))

    def _geometry(
        self, R: Array, center: Array, steer: Array, hits: Sequence[RayHit | None], on: list[int]
    ) -> tuple[Array, Array, Array, Array]:
        """J, the rows of the hubs, the ground's velocities, and the force of the springs, of the wheels ``on``."""
        seen = [hit for k in on if (hit := hits[k]) is not None]
        normal, point = np.array([hit.normal for hit in seen]), np.array([hit.point for hit in seen])
        heading = np.stack([np.cos(steer[on]), np.sin(steer[on]), np.zeros(len(on))], axis=1) @ R.T
        forward = heading - normal * (normal * heading).sum(axis=1, keepdims=True)
        forward /= np.linalg.norm(forward, axis=1, keepdims=True)
        axes = np.stack([normal, forward, _cross(normal, forward)], axis=1)
        arms = (point - center)[:, None, :]
        hubs = self.chassis.position + self._places[on] @ R.T
        J = np.concatenate([axes, _cross(arms, axes)], axis=2)
        hub = np.concatenate([axes[:, 1:], _cross((hubs - center)[:, None, :], axes[:, 1:])], axis=2)
        velocity = np.array([_surface_velocity(self.world, hit) for hit in seen])
        ground = np.einsum("kij,kj->ki", axes, velocity).ravel()
        push = self._weights()[on] + self._stiffness[on] * self._run.lift[on]
        return J.reshape(-1, 6), hub.reshape(-1, 6), ground, push

    def _pair_table(self, hits: Sequence[RayHit | None]) -> Array:
        """Coefficients of tyres and grounds, made anew only when something changed."""
        names = self._materials(hits)
        key = (self.world.materials.version, names)
        if self._table is None or self._table[0] != key:
            self._table = key, self.world.materials.to_array(list(names))
        return self._table[1]

    def _materials(self, hits: Sequence[RayHit | None]) -> tuple[str, ...]:
        grounds = [hit.body.material for hit in hits if hit is not None]
        return tuple(dict.fromkeys([*(wheel.material for wheel in self.wheels), *grounds]))

    def _rows(self, hits: Sequence[RayHit | None], on: list[int]) -> NDArray[np.int64]:
        names = self._materials(hits)
        pairs = [(self.wheels[k].material, hit.body.material) for k in on if (hit := hits[k]) is not None]
        return np.array([[names.index(a), names.index(b)] for a, b in pairs], dtype=np.int64)

    def _tell(self, found: Found, on: list[int], hits: Sequence[RayHit | None], steer: Array) -> None:
        for row, k in enumerate(on):
            hit = hits[k]
            assert hit is not None
            load, forward, sideways = found.force[row].tolist()
            speed = max(float(found.speed[row]), 1e-6)
            slip = found.slip[row].copy()
            ratio = float(np.hypot(*slip)) / speed
            ground = hit.body if load > 0.0 else None
            self._states[k] = WheelState(ground, load, forward, sideways, slip, ratio, 0.0, float(steer[k]))

    def _press(self, hits: Sequence[RayHit | None], on: list[int], J: Array, force: Array) -> None:
        """Give the ground what it gives the wheels, where it can move."""
        for row, k in enumerate(on):
            hit = hits[k]
            if hit is not None and hit.body.mobility == "dynamic":
                hit.body.apply_force(-J[3 * row : 3 * row + 3, :3].T @ force[row], at=hit.point)

    def _hub_velocities(self, steer: Array) -> Array:
        """Along, across and up, (k, 3) m/s."""
        R, made = self.world._rotation(self.chassis.index), []
        for wheel, angle in zip(self.wheels, steer.tolist(), strict=True):
            arm = R @ (np.array(wheel.position) - _center(self.chassis))
            v = R.T @ (self.chassis.velocity + np.cross(self.chassis.angular_velocity, arm))
            c, s = math.cos(angle), math.sin(angle)
            made.append((c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]))
        return np.array(made)

    # --- wheels to look at --------------------------------------------------------------------------------------------

    def _add_wheels(self) -> list[Body]:
        shown = []
        for k, wheel in enumerate(self.wheels):
            shape = Cylinder(wheel.radius, wheel.width)
            # the material is that of the chassis: they touch nothing, and a tyre's law would be compiled for them
            more = {"name": f"{self.chassis.name} wheel {k}", "material": self.chassis.material}
            shown.append(self.world.add(shape, kinematic=True, layer=0, mask=0, **more))  # type: ignore[arg-type]  # texts
        self._shown = shown
        R, still = self.world._rotation(self.chassis.index), np.zeros(len(shown))
        self._move_wheels(R, still, np.concatenate([self.chassis.velocity, self.chassis.angular_velocity]), still)
        return shown

    def _move_wheels(self, R: Array, steer: Array, velocity: Array, spin: Array) -> None:
        """Put the cylinders where the wheels are now, and let them go on with the chassis."""
        if not self._shown:
            return
        arms = (self._places + self._run.lift[:, None] * (0.0, 0.0, 1.0)) @ R.T
        places = self.chassis.position + arms
        velocities = velocity[:3] + _cross(velocity[3:], arms - R @ _center(self.chassis))
        for k, body in enumerate(self._shown):
            axle = R @ np.array((-math.sin(steer[k]), math.cos(steer[k]), 0.0))
            body.position = places[k]
            body.orientation = _wheel_orientation(self.chassis.orientation, float(steer[k]), float(self._run.angle[k]))
            body.velocity = velocities[k]
            body.angular_velocity = velocity[3:] + axle * spin[k]


def _center(chassis: Body) -> Array:
    """Centre of mass in the frame of the shape, (3,), m."""
    return chassis._get("CENTER", 3)


def _cross(a: Array, b: Array) -> Array:
    """a x b of the last axis; numpy's own takes four times as long for a few vectors."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    y = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    return np.stack([x, y, a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], axis=-1)


def _within(name: str, value: float, low: float, high: float) -> float:
    number = checks.number(name, value)
    if not low <= number <= high:
        raise InvalidInputError(f"{name} must be {low:g} to {high:g}, got {value!r}.")
    return number


def _surface_velocity(world: World, hit: RayHit) -> Array:
    """Of the ground where a ray hits it, belts included, (3,), m/s."""
    body = hit.body
    belt = body.surface_velocity
    if body.mobility == "static" and not belt.any():
        return np.zeros(3)
    turning = np.cross(body.angular_velocity, hit.point - body.center_of_mass)
    velocity: Array = body.velocity + turning + world._rotation(body.index) @ belt
    return velocity


def _wheel_orientation(chassis: Array, steer: float, angle: float) -> Array:
    """Quaternion of a cylinder whose axis z is the axle, turned by ``steer`` about the chassis' z and by its spin."""
    from stiction.core.vec import Quat

    def about(half: float, x: float, y: float, z: float) -> Quat:
        return Quat(math.cos(half), x * math.sin(half), y * math.sin(half), z * math.sin(half))

    to_axle = about(-0.25 * math.pi, 1.0, 0.0, 0.0)
    return np.array(Quat(*chassis) * about(0.5 * steer, 0, 0, 1) * about(0.5 * angle, 0, 1, 0) * to_axle)
