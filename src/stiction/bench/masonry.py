"""Scenes that friction alone holds up: a house of cards, and an arch of wedge stones without mortar."""

from __future__ import annotations

import math

import numpy as np

from stiction.bench import rotations
from stiction.bench.scene import BenchBody, BenchScene, ground, quaternion, static_box, vector
from stiction.shapes import Box, ConvexHull

Y_AXIS = (0.0, 1.0, 0.0)


def card_house(
    storeys: int = 5,
    lean: float = math.radians(20.0),
    length: float = 1.0,
    width: float = 0.7,
    thickness: float = 0.02,
    gap: float = 0.002,
) -> BenchScene:
    r"""A house of cards in the plane of x and z: pairs of leaning cards, and flat cards from tip to tip.

    A leaning card of length L and thickness t, at the angle a from the vertical, touches its partner along one edge,
    and what is above it along another: with the tips' common edge at x = 0 and the feet on z = 0,

    - its middle is at x = -(L sin a + t cos a) / 2, z = (L cos a + t sin a) / 2,
    - its lowest edge is at x = -L sin a, its highest one at x = -t cos a, z = L cos a + t sin a.

    Flat cards reach from tip to tip, ``gap`` m apart, and the feet of the next storey stand just inside the tips below.
    A card is a strut along a: it holds while the coefficient of friction is above tan a at feet and tips (0.36 at 20
    degrees; the scene has 0.6), and flat cards tie the pairs of a storey together by friction.

    Args:
        storeys: of the house; five need 30 leaning and 10 flat cards.
        lean: angle from the vertical, rad.
        length: of a leaning card, m. width: along y, m. thickness: m.
        gap: between neighbouring pairs and between flat cards, m.
    """
    s, c = math.sin(lean), math.cos(lean)
    height = length * c + thickness * s
    pitch = 2.0 * (length * s + thickness * c) + gap
    leaning = Box((thickness, width, length))
    flat = Box((pitch - gap, width, thickness))
    middle_x, middle_z = 0.5 * (length * s + thickness * c), 0.5 * height
    right, left = quaternion(rotations.about(Y_AXIS, lean)), quaternion(rotations.about(Y_AXIS, -lean))

    bodies = [ground()]
    for storey in range(storeys):
        pairs = storeys - storey
        foot = storey * (height + thickness)
        for k in range(pairs):
            x = pitch * (k - 0.5 * (pairs - 1))
            bodies.append(BenchBody(leaning, (x - middle_x, 0.0, foot + middle_z), right))
            bodies.append(BenchBody(leaning, (x + middle_x, 0.0, foot + middle_z), left))
        for k in range(pairs - 1):
            x = pitch * (k - 0.5 * (pairs - 2))
            bodies.append(BenchBody(flat, (x, 0.0, foot + height + 0.5 * thickness)))
    rest = np.array([body.position for body in bodies])
    return BenchScene("card-house", tuple(bodies), rest=rest, tolerance=0.1)


def arch(stones: int = 21, radius: float = 5.0, thickness: float = 1.0, depth: float = 1.0) -> BenchScene:
    """A half circle of equal wedge stones between two static abutments, exactly fitting.

    A half circle stands by itself if it is thicker than 0.1075 of its mean radius (Milankovitch 1907) and does not
    slide; this one has 0.2.

    Args:
        stones: number of wedges.
        radius: of the middle line, m.
        thickness: radial, m. depth: along the axis, m.
    """
    half = 0.5 * math.pi / stones
    corners = np.array(
        [
            (r * math.sin(angle), y, r * math.cos(angle))
            for angle in (-half, half)
            for r in (radius - 0.5 * thickness, radius + 0.5 * thickness)
            for y in (-0.5 * depth, 0.5 * depth)
        ]
    )
    center = ConvexHull(corners).mass_properties.center_of_mass
    wedge = ConvexHull(corners - center)

    base = 1.0
    block = (thickness + 1.0, depth + 1.0, base)
    bodies = [ground(top=-base)]
    bodies += [static_box(block, (side * radius, 0.0, -0.5 * base)) for side in (-1.0, 1.0)]
    for k in range(stones):
        # the wedge was made at the crown; turning it about the arch's axis puts it in its place
        turn = rotations.about(Y_AXIS, (2 * k + 1) * half - 0.5 * math.pi)
        bodies.append(BenchBody(wedge, vector(rotations.matrix(turn) @ center), quaternion(turn)))
    rest = np.array([body.position for body in bodies])
    return BenchScene("arch", tuple(bodies), rest=rest, floor=-base)
