"""Scenes of many loose bodies: spheres, a heap of mixed shapes, a hopper, a rotating drum. All are seeded."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from stiction.bench import rotations
from stiction.bench.scene import BenchBody, BenchScene, Turning, container, ground, quaternion, static_box, vector
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Shape, Sphere

LAYERS = 10
"""Bodies above each other in heaps, whatever their size, so that the work for a body stays the same."""

MIXED = ("sphere", "box", "capsule", "cylinder", "hull")
SIMPLE = ("sphere", "box")


def heap(n: int = 1000, seed: int = 0, kinds: Sequence[str] = MIXED) -> BenchScene:
    """Bodies of many shapes and sizes, turned at random, dropped into a box without touching each other at first.

    Args:
        n: bodies; the floor grows with them, the height does not.
        seed: of shapes, sizes, places and turns.
        kinds: of shapes to draw from.
    """
    rng = np.random.default_rng(seed)
    reach = 0.4  # m, no body reaches farther from its middle
    side = _side(n)
    pitch, slack = 2.0 * reach + 0.1, 0.05
    half = 0.5 * side * pitch
    makers = [_MAKERS[kind] for kind in kinds]
    bodies = [ground(half), *container(half, half, pitch * LAYERS + 1.0)]
    for x, y, z in _lattice(n, side, pitch):
        shape = makers[rng.integers(len(makers))](rng, reach)
        place = np.array((x, y, z)) + rng.uniform(-slack, slack, 3)
        bodies.append(BenchBody(shape, vector(place), quaternion(rotations.random_quaternion(rng))))
    return BenchScene("heap", tuple(bodies))


def simple_heap(n: int = 1000, seed: int = 0) -> BenchScene:
    """The heap with spheres and boxes only."""
    scene = heap(n, seed, SIMPLE)
    return BenchScene("heap-simple", scene.bodies)


def spheres(n: int = 1000, seed: int = 0, radius: float = 0.25) -> BenchScene:
    """Equal spheres, a little off a lattice, dropped into a box.

    Args:
        n: spheres; the floor grows with them, the height does not.
        seed: of the places.
        radius: m.
    """
    rng = np.random.default_rng(seed)
    ball = Sphere(radius)
    side = _side(n)
    pitch, slack = 2.2 * radius, 0.1 * radius
    half = 0.5 * side * pitch
    bodies = [ground(half), *container(half, half, pitch * LAYERS + 1.0)]
    for place in _lattice(n, side, pitch):
        bodies.append(BenchBody(ball, vector(np.array(place) + rng.uniform(-slack, slack, 3))))
    return BenchScene("spheres", tuple(bodies))


def hopper(n: int = 10_000, seed: int = 0, radius: float = 0.1) -> BenchScene:
    """Spheres in a square silo with a funnel of four plates at 45 degrees; they run out and pile up below.

    Args:
        n: spheres.
        seed: of the places.
        radius: m. The outlet is at least four diameters wide.
    """
    rng = np.random.default_rng(seed)
    ball = Sphere(radius)
    pitch, slack = 2.2 * radius, 0.1 * radius
    side = max(6, math.ceil(0.9 * n ** (1.0 / 3.0)))
    half = 0.5 * side * pitch
    outlet = max(4.0 * radius, 0.25 * half)  # half of its width
    drop, plate = half - outlet, 0.2  # height of the funnel; thickness of its plates, m
    bottom = 2.0 + 0.5 * half  # height of the outlet above the ground
    layers = math.ceil(n / side**2)
    walls = layers * pitch + 1.0

    bodies = [ground(4.0 * half)]
    for quarter in range(4):
        turn = rotations.about((0.0, 0.0, 1.0), 0.5 * math.pi * quarter)
        R = rotations.matrix(turn)
        slope = rotations.product(turn, rotations.about((0.0, 1.0, 0.0), -0.25 * math.pi))
        # a plate's inner face runs from (outlet, bottom) to (half, bottom + drop); half its thickness lies outside
        shift = 0.5 * plate / math.sqrt(2.0)
        middle = np.array((0.5 * (half + outlet) + shift, 0.0, bottom + 0.5 * drop - shift))
        bodies.append(static_box((drop * math.sqrt(2.0), 2.0 * half, plate), vector(R @ middle), slope))
        upright = np.array((half + 0.5, 0.0, bottom + drop + 0.5 * walls))
        bodies.append(static_box((1.0, 2.0 * half + 2.0, walls), vector(R @ upright), turn))
    for x, y, z in _lattice(n, side, pitch):
        place = np.array((x, y, z + bottom + drop)) + rng.uniform(-slack, slack, 3)
        bodies.append(BenchBody(ball, vector(place)))
    return BenchScene("hopper", tuple(bodies), friction=0.5)


def drum(n: int = 500, seed: int = 0, staves: int = 24, rate: float = 1.0) -> BenchScene:
    """Spheres and boxes in a drum of ``staves`` kinematic boxes that turns about the horizontal axis y.

    Args:
        n: loose bodies, half of them boxes.
        seed: of kinds, places and turns.
        staves: boxes that make the ring.
        rate: rad/s.
    """
    rng = np.random.default_rng(seed)
    reach, wall = 0.2, 0.4  # m: size of the loose bodies; thickness of the staves
    pitch, slack = 2.0 * reach + 0.1, 0.05
    depth = 8
    side = max(2, math.ceil(math.sqrt(n / depth)))
    inner = 0.5 * side * pitch * math.sqrt(2.0) + 0.5  # the square of loose bodies fits into the ring
    height = inner + 2.0
    width = depth * pitch
    spread = math.pi / staves
    stave = Box((2.0 * (inner + wall) * math.tan(spread) + 0.02, width + 0.4, wall))

    bodies = [ground(top=0.0)]
    for k in range(staves):
        turn = rotations.about((0.0, 1.0, 0.0), 2.0 * spread * k)
        arm = rotations.matrix(turn) @ np.array((0.0, 0.0, inner + 0.5 * wall))
        there, speed = vector(arm + np.array((0.0, 0.0, height))), vector(np.cross((0.0, rate, 0.0), arm))
        bodies.append(BenchBody(stave, there, quaternion(turn), speed, (0.0, rate, 0.0), kinematic=True))
    lid = (2.0 * (inner + wall), 0.2, 2.0 * (inner + wall))
    bodies += [static_box(lid, (0.0, sign * (0.5 * width + 0.3), height)) for sign in (-1.0, 1.0)]
    for k in range(n):
        layer, rest = divmod(k, side * depth)
        row, place_y = divmod(rest, depth)
        cell = (row - 0.5 * (side - 1), place_y - 0.5 * (depth - 1), layer - 0.5 * (side - 1))
        place = pitch * np.array(cell) + np.array((0.0, 0.0, height)) + rng.uniform(-slack, slack, 3)
        shape = _MAKERS["sphere" if k % 2 else "box"](rng, reach)
        bodies.append(BenchBody(shape, vector(place), quaternion(rotations.random_quaternion(rng))))
    turning = Turning((0.0, 0.0, height), (0.0, 1.0, 0.0), rate)
    return BenchScene("drum", tuple(bodies), friction=0.5, turning=turning)


# --- places and shapes ------------------------------------------------------------------------------------------------


def _side(n: int) -> int:
    return max(2, math.ceil(math.sqrt(n / LAYERS)))


def _lattice(n: int, side: int, pitch: float) -> list[tuple[float, float, float]]:
    """The first n places of a square lattice, layer upon layer, the lowest a pitch above z = 0."""
    places = []
    for k in range(n):
        layer, rest = divmod(k, side * side)
        row, place = divmod(rest, side)
        middle = 0.5 * (side - 1)
        places.append((pitch * (place - middle), pitch * (row - middle), pitch * (layer + 1.0)))
    return places


def _sphere(rng: np.random.Generator, reach: float) -> Shape:
    return Sphere(reach * rng.uniform(0.4, 0.75))


def _box(rng: np.random.Generator, reach: float) -> Shape:
    # the half diagonal is at most sqrt(3) * 0.57 = 0.99 of the reach
    return Box(2.0 * reach * rng.uniform(0.3, 0.57, 3))


def _capsule(rng: np.random.Generator, reach: float) -> Shape:
    radius = reach * rng.uniform(0.25, 0.45)
    return Capsule(radius, reach * rng.uniform(0.3, 1.0))  # 0.45 + 1.0 / 2 is within the reach


def _cylinder(rng: np.random.Generator, reach: float) -> Shape:
    return Cylinder(reach * rng.uniform(0.3, 0.65), 2.0 * reach * rng.uniform(0.3, 0.7))


def _hull(rng: np.random.Generator, reach: float) -> Shape:
    """Twelve points on a squeezed sphere, moved so that the centre of mass is the origin."""
    points = rng.normal(size=(12, 3))
    points *= 0.6 * reach / np.linalg.norm(points, axis=1, keepdims=True)
    points *= rng.uniform(0.7, 1.0, 3)
    return ConvexHull(points - ConvexHull(points).mass_properties.center_of_mass)


_MAKERS: dict[str, Callable[[np.random.Generator, float], Shape]] = {
    "sphere": _sphere,
    "box": _box,
    "capsule": _capsule,
    "cylinder": _cylinder,
    "hull": _hull,
}
