"""Scenes of stacked boxes: a pyramid, a pile of columns, a tower. Each says where its boxes must stay."""

from __future__ import annotations

import math

import numpy as np

from stiction.bench import rotations
from stiction.bench.scene import DENSITY, BenchBody, BenchScene, ground, quaternion, vector
from stiction.shapes import Box

COLUMN = 10
"""Boxes in a column of the pile, whatever its size, so that the work for a box stays the same."""


def pyramid(base: int = 10, spacing: float = 1.05) -> BenchScene:
    """A flat pyramid of 1 m boxes: ``base`` in the lowest row, one fewer in each row above, exactly touching.

    Args:
        base: boxes in the lowest row; 10 make 55 boxes.
        spacing: between the middles of neighbours in a row, m.
    """
    cube = Box((1.0, 1.0, 1.0))
    bodies = [ground(spacing * base)]
    for row in range(base):
        count = base - row
        for k in range(count):
            bodies.append(BenchBody(cube, (spacing * (k - 0.5 * (count - 1)), 0.0, row + 0.5)))
    return BenchScene("pyramid", tuple(bodies), rest=np.array([body.position for body in bodies]))


def pyramid_of(n: int) -> BenchScene:
    """The pyramid whose number of boxes is nearest to ``n``."""
    return pyramid(max(1, round((math.sqrt(8.0 * n + 1.0) - 1.0) / 2.0)))


def pile(n: int = 1000, spacing: float = 1.5, gap: float = 0.05) -> BenchScene:
    """Columns of ten 1 m boxes on a square grid; 1,000 boxes are 10 x 10 columns.

    The boxes start ``gap`` m above each other and fall into place, so that contacts form under way. A body counts as
    out of its column when it is more than a quarter of a box from its place.

    Args:
        n: boxes; the last column may be shorter.
        spacing: between the middles of neighbouring columns, m.
        gap: of air below each box, m.
    """
    cube = Box((1.0, 1.0, 1.0))
    columns = math.ceil(n / COLUMN)
    side = math.ceil(math.sqrt(columns))
    bodies, rest = [ground(0.5 * spacing * side + 20.0)], [(0.0, 0.0, -1.0)]
    for k in range(n):
        column, level = divmod(k, COLUMN)
        row, place = divmod(column, side)
        x, y = spacing * (place - 0.5 * (side - 1)), spacing * (row - 0.5 * (side - 1))
        rest.append((x, y, level + 0.5))
        bodies.append(BenchBody(cube, (x, y, level + 0.5 + gap * (level + 1))))
    return BenchScene("pile", tuple(bodies), rest=np.array(rest))


def tower(count: int = 10, offset: float = 0.0, yaw: float = 0.0, heavy: float = 1.0, seed: int = 0) -> BenchScene:
    """One column of 1 m boxes, exactly touching.

    Args:
        count: boxes.
        offset: sideways, 1 sigma along x and along y, m.
        yaw: about the vertical, 1 sigma, rad.
        heavy: density of the topmost box over that of the others.
        seed: of offset and yaw.
    """
    rng = np.random.default_rng(seed)
    cube = Box((1.0, 1.0, 1.0))
    bodies = [ground()]
    for level in range(count):
        x, y = rng.normal(size=2) * offset
        turn = rotations.about((0.0, 0.0, 1.0), float(rng.normal()) * yaw)
        density = DENSITY * (heavy if level == count - 1 else 1.0)
        bodies.append(BenchBody(cube, vector((x, y, level + 0.5)), quaternion(turn), density=density))
    return BenchScene("tower", tuple(bodies), rest=np.array([body.position for body in bodies]))


def uneven_tower(count: int = 10, seed: int = 0) -> BenchScene:
    """A tower that somebody built by hand: boxes 5 mm and 0.05 rad (1 sigma) off."""
    return _renamed("tower-uneven", tower(count, offset=0.005, yaw=0.05, seed=seed))


def heavy_tower(count: int = 5, ratio: float = 100.0) -> BenchScene:
    """A tower with a top ``ratio`` times as heavy as each box below it."""
    return _renamed("tower-heavy", tower(count, heavy=ratio))


def _renamed(name: str, scene: BenchScene) -> BenchScene:
    return BenchScene(name, scene.bodies, rest=scene.rest)
