"""Body: a handle into the arrays of its world. Reading copies three numbers, setting takes effect at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.shapes import Shape

if TYPE_CHECKING:
    from stiction.world import World

Array = NDArray[np.float64]


class Body:
    """One rigid body of a world, made by :meth:`stiction.World.add`.

    Position and orientation are those of the shape's own frame; velocity is that of the centre of mass. All vectors are
    in world axes but ``inertia``. What a getter returns is a copy; use the world's arrays for many bodies at once.
    """

    __slots__ = ("_index", "_material", "_name", "_shape", "_world")

    def __init__(self, world: World, index: int, name: str, shape: Shape, material: str) -> None:
        self._world = world
        self._index = index
        self._name = name
        self._shape = shape
        self._material = material

    @property
    def index(self) -> int:
        """Row of this body in the world's arrays; it changes when an older body is removed."""
        if self._index < 0:
            raise InvalidInputError(f"body {self.name!r} was removed from its world and can no longer be used.")
        return self._index

    @property
    def name(self) -> str:
        """Unique in its world."""
        return self._name

    @property
    def shape(self) -> Shape:
        """What the body looks like."""
        return self._shape

    @property
    def material(self) -> str:
        """Its name in the world's table."""
        return self._material

    def __repr__(self) -> str:
        mobility = self.mobility if self._index >= 0 else "removed"
        return f"<Body {self.name!r} ({mobility} {self.shape.kind}, {self.material})>"

    # --- state --------------------------------------------------------------------------------------------------------

    @property
    def position(self) -> Array:
        """Origin of the shape's frame, (3,), m."""
        return self._get("POSITION", 3)

    @position.setter
    def position(self, value: ArrayLike) -> None:
        self._set("POSITION", checks.vector(f"position of body {self.name!r}", value))

    @property
    def orientation(self) -> Array:
        """Unit quaternion (w, x, y, z), (4,). Setting normalises."""
        return self._get("ORIENTATION", 4)

    @orientation.setter
    def orientation(self, value: ArrayLike) -> None:
        self._set("ORIENTATION", checks.unit_quaternion(f"orientation of body {self.name!r}", value))

    @property
    def velocity(self) -> Array:
        """Velocity of the centre of mass, (3,), m/s."""
        return self._get("V", 3)

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        velocity = checks.vector(f"velocity of body {self.name!r}", value)
        self._must_move("velocity", velocity)
        self._set("V", velocity)

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity in world axes, (3,), rad/s."""
        return self._get("W", 3)

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        spin = checks.vector(f"angular_velocity of body {self.name!r}", value)
        self._must_move("angular_velocity", spin)
        self._set("W", spin)

    @property
    def surface_velocity(self) -> Array:
        """Velocity of the surface relative to the body, in the shape's axes, (3,), m/s: a conveyor belt."""
        return self._get("SURFACE", 3)

    @surface_velocity.setter
    def surface_velocity(self, value: ArrayLike) -> None:
        self._set("SURFACE", checks.vector(f"surface_velocity of body {self.name!r}", value))

    # --- whom it meets ------------------------------------------------------------------------------------------------

    @property
    def layer(self) -> int:
        """A whole number whose bits are the layers that the body is on. Setting wakes it and what touches it."""
        return self._world._read_kind(self.index, "LAYER")

    @layer.setter
    def layer(self, value: int) -> None:
        self._world._write_kind(self.index, "LAYER", checks.layers(f"layer of body {self.name!r}", value))

    @property
    def mask(self) -> int:
        """A whole number whose bits are the layers that it meets, -1 for all. Setting wakes it and what touches it."""
        return self._world._read_kind(self.index, "MASK")

    @mask.setter
    def mask(self, value: int) -> None:
        self._world._write_kind(self.index, "MASK", checks.layers(f"mask of body {self.name!r}", value))

    @property
    def sensor(self) -> bool:
        """Whether the body only notices who overlaps it."""
        return self._world._read_kind(self.index, "SENSOR") != 0

    # --- mass ---------------------------------------------------------------------------------------------------------

    @property
    def mobility(self) -> str:
        """``static``, ``kinematic`` or ``dynamic``."""
        return self._world._mobility(self.index)

    @property
    def mass(self) -> float:
        """In kg; infinite unless dynamic. Setting scales the inertia tensor alike."""
        return float(self._get("MASS", 1)[0]) if self.mobility == "dynamic" else float("inf")

    @mass.setter
    def mass(self, value: float) -> None:
        mass = checks.mass(f"mass of body {self.name!r}", value)
        self._must_be_dynamic("mass")
        self._world._set_mass(self.index, mass, self.inertia * (mass / self.mass))

    @property
    def inertia(self) -> Array:
        """Inertia tensor about the centre of mass in the shape's axes, (3, 3), kg m^2."""
        return self._get("INERTIA", 9).reshape(3, 3)

    @inertia.setter
    def inertia(self, value: ArrayLike) -> None:
        inertia = checked_inertia(f"inertia of body {self.name!r}", value)
        self._must_be_dynamic("inertia")
        self._world._set_mass(self.index, self.mass, inertia)

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass in the world, (3,), m."""
        w, x, y, z = self.orientation
        local = self._get("CENTER", 3)
        turned = 2.0 * np.cross([x, y, z], local)
        center: Array = self.position + local + w * turned + np.cross([x, y, z], turned)
        return center

    @property
    def kinetic_energy(self) -> float:
        """Of translation and rotation, J; 0 unless dynamic."""
        return self._world._kinetic_energy(self.index)

    @property
    def friction_work(self) -> float:
        """Energy lost to friction and rolling resistance at this body's contacts so far, J.

        What two dynamic bodies lose to each other is shared half and half.
        """
        return float(self._get("FRICTION_WORK", 1)[0])

    @property
    def awake(self) -> bool:
        """Whether the body takes part in the simulation.

        Static bodies never do; ``soft`` leaves islands alone that are truly at rest; ``micro`` lets none sleep.
        """
        return self.mobility != "static" and not self._world._is_asleep(self.index)

    # --- forces -------------------------------------------------------------------------------------------------------

    def apply_force(self, force: ArrayLike, at: ArrayLike | None = None) -> None:
        """Add a force until the end of the next step.

        Args:
            force: (3,), N.
            at: point of application in the world, (3,), m; the centre of mass if left out.
        """
        f = checks.vector(f"force on body {self.name!r}", force)
        arm = self._arm(at)
        self._must_be_dynamic("force")
        with np.errstate(all="ignore"):
            self._add(FORCE=f, TORQUE=np.zeros(3) if arm is None else np.cross(arm, f))

    def apply_torque(self, torque: ArrayLike) -> None:
        """Add a torque, (3,), N m, until the end of the next step."""
        t = checks.vector(f"torque on body {self.name!r}", torque)
        self._must_be_dynamic("torque")
        with np.errstate(all="ignore"):
            self._add(TORQUE=t)

    def apply_impulse(self, impulse: ArrayLike, at: ArrayLike | None = None) -> None:
        """Change the velocities at once by an impulse.

        Args:
            impulse: (3,), N s.
            at: point of application in the world, (3,), m; the centre of mass if left out.
        """
        p = checks.vector(f"impulse on body {self.name!r}", impulse)
        arm = self._arm(at)
        self._must_be_dynamic("impulse")
        with np.errstate(all="ignore"):
            turning = np.zeros(3)
            if arm is not None:
                turning = self._world._world_inverse_inertia(self.index) @ np.cross(arm, p)
            self._add(V=p / self.mass, W=turning)

    # --- inside -------------------------------------------------------------------------------------------------------

    def _get(self, column: str, width: int) -> Array:
        return self._world._read(self.index, column, width)

    def _set(self, column: str, value: Array) -> None:
        self._world._write(self.index, column, value)

    def _add(self, **changes: Array) -> None:
        """Add to several columns, to all of them or, if a sum overflows, to none."""
        totals = {column: self._get(column, len(change)) + change for column, change in changes.items()}
        for total in totals.values():
            if not np.isfinite(total).all():
                raise InvalidInputError(f"what is applied to body {self.name!r} must stay finite, got {total}.")
        for column, total in totals.items():
            self._set(column, total)

    def _arm(self, at: ArrayLike | None) -> Array | None:
        return None if at is None else checks.vector("at", at) - self.center_of_mass

    def _must_be_dynamic(self, what: str) -> None:
        if self.mobility != "dynamic":
            raise InvalidInputError(
                f"{what} of body {self.name!r} has no effect, for it is {self.mobility}, not dynamic."
            )

    def _must_move(self, what: str, value: Array) -> None:
        if self.mobility == "static" and value.any():
            raise InvalidInputError(
                f"{what} of body {self.name!r} must be zero, for it is static (kinematic ones move)."
            )


def checked_inertia(name: str, value: Any) -> Array:
    """An inertia tensor (3, 3): symmetric, positive definite, principal moments that obey the triangle inequality."""
    try:
        inertia = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} must be three moments or a (3, 3) tensor, got {value!r}.") from None
    if inertia.shape == (3,):
        inertia = np.diag(inertia)
    if inertia.shape != (3, 3):
        raise InvalidInputError(f"{name} must be three moments or a (3, 3) tensor, got shape {inertia.shape}.")
    if not np.isfinite(inertia).all():
        raise InvalidInputError(f"{name} must be finite, got {value!r}.")
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=0.0):
        raise InvalidInputError(f"{name} must be symmetric, got {value!r}.")
    inertia = 0.5 * (inertia + inertia.T)
    low, middle, high = np.linalg.eigvalsh(inertia)
    if low <= 0.0:
        raise InvalidInputError(
            f"{name} must have positive principal moments, got {low:g}, {middle:g}, {high:g} kg m^2."
        )
    if high > (low + middle) * (1 + 1e-9):
        raise InvalidInputError(
            f"{name} must obey the triangle inequality (no principal moment above the sum of the others), "
            f"got {low:g}, {middle:g}, {high:g} kg m^2."
        )
    return inertia
