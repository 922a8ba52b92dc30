"""Where to stand: a camera that sees everything that moves, as large as it fits, with little hidden.

For one direction of view the nearest place from which all points are seen follows in closed form, since the four sides
of the picture are planes of fixed direction: each pair of opposite sides pushes the camera back until both hold. Of
some directions around the scene the one is taken that shows bodies large, apart from each other and from the upper
side of every plane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIELD_OF_VIEW = math.radians(36.0)
"""Vertical; a long lens, so that what is near does not dwarf what is far."""
ASPECT = 1.6
"""Width over height that the picture is made for; wider windows show more at the sides."""
ELEVATION = math.radians(24.0)
MARGIN_SIDE, MARGIN_TOP, MARGIN_BOTTOM = 0.10, 0.16, 0.10
"""Shares of the half picture left free; more at the top, where the title is."""
LEAST_FACING = 0.3
"""Cosine between a plane's normal and the way to the camera below which the plane is seen too flat."""
MOST_POINTS = 400


@dataclass(frozen=True)
class Camera:
    """A place to look from.

    Attributes:
        position: (3,) in m.
        look_at: (3,) in m, amid what is seen; the reader turns the scene about it.
        field_of_view: vertical, in rad.
    """

    position: Array
    look_at: Array
    field_of_view: float


def place(points: Array, centers: Array, radii: Array, cores: Array, normals: Array) -> Camera:
    """Camera for a scene.

    Args:
        points: (p, 3) what must be in the picture, in m.
        centers: (k, n, 3) of n bodies at k times, in m; they should hide each other little.
        radii: (n,) of the balls around the bodies, in m.
        cores: (n,) of the balls within the bodies, in m: bodies whose cores touch are neighbours in a stack.
        normals: (q, 3) of the planes, whose upper sides should be seen.
    """
    best, best_score = None, -math.inf
    # half steps keep the view off the axes, where boxes show one face only; the first is the favourite where all tie
    for azimuth in np.radians(-52.5 + 15.0 * np.arange(24)):
        camera = _fit(points, float(azimuth))
        score = _visibility(camera, centers, radii, cores) * _facing(camera, normals)
        if score > best_score * (1.0 + 1e-6) or best is None:
            best, best_score = camera, score
    assert best is not None
    return best


def _frame(azimuth: float) -> tuple[Array, Array, Array]:
    """Unit vectors to the right, up and forward of a camera that stands at that azimuth and looks inwards."""
    ce, se = math.cos(ELEVATION), math.sin(ELEVATION)
    forward = -np.array([ce * math.cos(azimuth), ce * math.sin(azimuth), se])
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    return right, np.cross(right, forward), forward


def _fit(points: Array, azimuth: float) -> Camera:
    """Nearest camera of that direction that has all points in its picture.

    A point p is left of the right side of the picture when (p - e).r <= t (p - e).f, with the camera at e, to the right
    r, forward f and t the tangent of half the width: p.r - t p.f <= e.r - t e.f. The largest left side counts; added to
    the same for the left side it bounds e.f, and half their difference centres e.r. The same holds for top and bottom.
    """
    right, up, forward = _frame(azimuth)
    x, y, z = points @ right, points @ up, points @ forward
    tan = math.tan(FIELD_OF_VIEW / 2)
    side, top, bottom = tan * ASPECT * (1 - MARGIN_SIDE), tan * (1 - MARGIN_TOP), tan * (1 - MARGIN_BOTTOM)
    r_plus, r_minus = float((x - side * z).max()), float((-x - side * z).max())
    u_plus, u_minus = float((y - top * z).max()), float((-y - bottom * z).max())
    e_z = min(-(r_plus + r_minus) / (2 * side), -(u_plus + u_minus) / (top + bottom))
    e_x = (r_plus - r_minus) / 2
    # where the width decides, the height has play: stay in the middle of it
    low, high = u_plus + top * e_z, -u_minus - bottom * e_z
    e_y = (low + high) / 2
    position = e_x * right + e_y * up + e_z * forward
    depth = float(z.min() + z.max()) / 2 - e_z
    return Camera(position, position + depth * forward, FIELD_OF_VIEW)


def _facing(camera: Camera, normals: Array) -> float:
    """1 where every plane shows its upper side well and slopes show their profile, less where they do not.

    A slope seen straight from below or above looks like a level floor; seen from the side it is a slope.
    """
    if not len(normals):
        return 1.0
    back = camera.position - camera.look_at
    back /= np.linalg.norm(back)
    cosine = float((normals @ back).min())
    aside = np.abs(normals[:, 0] * back[1] - normals[:, 1] * back[0]) / math.cos(ELEVATION)
    steepness = np.hypot(normals[:, 0], normals[:, 1])
    profile = float((steepness - aside).max())
    return min(1.0, max(cosine, 0.01) / LEAST_FACING) * (1.0 - profile)


def _visibility(camera: Camera, centers: Array, radii: Array, cores: Array) -> float:
    """Size of the bodies in the picture at their mean distance, cut by the share that the worst neighbour may hide."""
    times, count = centers.shape[:2]
    if not count:
        return 1.0
    picked = np.unique(np.linspace(0, count - 1, min(count, MOST_POINTS // times)).astype(int))
    forward = camera.look_at - camera.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    relative = (centers[:, picked] - camera.position).reshape(-1, 3)
    depth = np.maximum(relative @ forward, 1e-9)
    picture = np.column_stack([relative @ right, relative @ np.cross(right, forward)]) / depth[:, None]
    size = np.tile(radii[picked], times) / depth
    gap = np.linalg.norm(picture[:, None] - picture[None], axis=2) / (size[:, None] + size[None])
    # what touches in space (a stack, or one body at rest at two times) overlaps from everywhere: no reason to move
    reach = np.tile(cores[picked], times)
    world = np.linalg.norm(relative[:, None] - relative[None], axis=2)
    gap[world <= 1.1 * (reach[:, None] + reach[None])] = np.inf
    hidden = 1.0 - np.minimum(gap.min(axis=1, initial=np.inf), 1.0)
    return float((1.0 - hidden).mean() * np.tile(radii[picked], times).mean() / depth.mean())
