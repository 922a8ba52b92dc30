"""Wheels of a vehicle: what they are, what they did, and how they share its weight. Values without a world."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.body import Body

Array = NDArray[np.float64]

DRIVES = ("front", "rear", "all")


@dataclass(frozen=True)
class Wheel:
    """A wheel of a :class:`Vehicle`.

    Attributes:
        position: of its hub when the vehicle stands on level ground, in the frame of the chassis' shape, (3,), m.
        radius: m. width: m, to be looked at only.
        mass: kg. It gives the wheel its inertia about the axle, m r^2 / 2; its weight belongs to the chassis.
        material: of the tyre, a name in the world's table of materials.
        steered: whether it turns with the steering wheel.
        drive: its share of the drive torque. brake: of the brake torque.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    position: tuple[float, float, float]
    radius: float = 0.3
    width: float = 0.2
    mass: float = 20.0
    material: str = "default"
    steered: bool = False
    drive: float = 0.0
    brake: float = 0.25

    def __post_init__(self) -> None:
        place = checks.vector("position of a wheel", self.position)
        object.__setattr__(self, "position", tuple(place.tolist()))
        for name in ("radius", "width"):
            object.__setattr__(self, name, checks.length(f"{name} of a wheel", getattr(self, name)))
        object.__setattr__(self, "mass", checks.mass("mass of a wheel", self.mass))
        for name in ("drive", "brake"):
            object.__setattr__(self, name, checks.non_negative(f"{name} of a wheel", getattr(self, name)))

    @property
    def inertia(self) -> float:
        """About the axle, kg m^2."""
        return 0.5 * self.mass * self.radius**2


def four_wheels(
    *,
    front: float,
    rear: float,
    track: float,
    hub_height: float,
    radius: float = 0.3,
    width: float = 0.2,
    wheel_mass: float = 20.0,
    tyre: str = "default",
    drive: str = "rear",
    brake_front: float = 0.6,
) -> list[Wheel]:
    """The wheels of a car: front left, front right, rear left, rear right; the chassis' x points forwards, y left.

    Args:
        front, rear: x of the two axles in the chassis' frame, m.
        track: distance from the left wheels to the right ones, m.
        hub_height: z of the hubs in the chassis' frame when it stands, m.
        radius, width, wheel_mass, tyre: of each wheel, m, m, kg, and a material.
        drive: "front", "rear" or "all": the axle that is driven.
        brake_front: share of the brake torque that the front axle has, 0 to 1.

    Raises:
        InvalidInputError: a value is not allowed.
    """
    x = checks.number("front", front), checks.number("rear", rear)
    if x[0] <= x[1]:
        raise InvalidInputError(f"front must be ahead of rear ({x[1]:g} m), got {front!r}.")
    half = 0.5 * checks.length("track", track)
    checks.one_of("drive", drive, DRIVES)
    share = checks.number("brake_front", brake_front)
    if not 0.0 <= share <= 1.0:
        raise InvalidInputError(f"brake_front must be 0 to 1, got {brake_front!r}.")
    driven = {"front": (0.5, 0.0), "rear": (0.0, 0.5), "all": (0.25, 0.25)}[drive]
    return [
        Wheel(
            position=(x[axle], side * half, checks.number("hub_height", hub_height)),
            radius=radius,
            width=width,
            mass=wheel_mass,
            material=tyre,
            steered=axle == 0,
            drive=driven[axle],
            brake=0.5 * (share if axle == 0 else 1.0 - share),
        )
        for axle, side in itertools.product((0, 1), (1.0, -1.0))
    ]


class WheelState(NamedTuple):
    """What a wheel did in the last step.

    Attributes:
        ground: the body that it stands on, or None.
        load: normal force, N.
        forward, sideways: tyre force on the vehicle along and across the wheel, N.
        slip: of the tyre over the ground, (2,), m/s along and across the wheel.
        slip_ratio: the same over the speed of the hub, as the laws of tyres have it.
        spin: rad/s, positive where it rolls forwards. steer: rad, to the left.
    """

    ground: Body | None
    load: float
    forward: float
    sideways: float
    slip: Array
    slip_ratio: float
    spin: float
    steer: float


class VehicleWork(NamedTuple):
    """Where the energy of a vehicle went so far, J.

    Attributes:
        drive: what the drive has put in.
        tyres: what tyres have lost by slipping. brakes: what brakes have taken. dampers: what the suspension has taken.
    """

    drive: float
    tyres: float
    brakes: float
    dampers: float


def rest_shares(places: Array, center: Array) -> Array:
    """Parts of the weight that wheels carry on level ground, (k,), in balance about the centre of mass.

    Of more than three wheels, the shares of least squares, as equal springs have them.

    Args:
        places: of the hubs, (k, 3). center: the centre of mass, (3,), m, in the same frame.

    Raises:
        InvalidInputError: fewer than three, in one line, or the vehicle would tip over.
    """
    if len(places) < 3:
        raise InvalidInputError(f"wheels must be three or more, got {len(places)}.")
    balance = np.stack([np.ones(len(places)), *(places - center).T[:2]])
    if np.linalg.matrix_rank(balance) < 3:
        raise InvalidInputError("wheels must not stand in one line.")
    shares: Array = np.linalg.lstsq(balance, np.array([1.0, 0.0, 0.0]))[0]
    if shares.min() <= 0.0:
        raise InvalidInputError(
            f"wheels must stand around the centre of mass at {center[:2].tolist()} m, got {places[:, :2].tolist()}."
        )
    return shares
