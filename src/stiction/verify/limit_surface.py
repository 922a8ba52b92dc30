"""Coulomb's law integrated over a face: what the friction of a contact patch is compared with.

A face presses with p = p0 + g . x, nowhere less than nothing, and moves with a twist (v_x, v_y, w) about the normal.
Each of its points resists with mu p against its own slip. Force and torque of all of them together have a closed form:
about the centre of rotation every point moves at right angles to its arm, and by Gauss' theorem the integrals over the
face become integrals along its edges (Goyal, Ruina, Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991,
for the limit surface; docs/design/limit-surface.md for the derivation).

Everything is per mu N: loads are one, forces are numbers without a unit, torques are lengths.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEWTON_STEPS = 60
"""For the pressure without tension: its problem is convex, and ten are usual."""
PATH = 8
"""Stations on the way from the middle of the face to the wanted centre of pressure, each the next one's start."""
SETTLED = 1e-12


class Face(NamedTuple):
    """A convex polygon, (k, 2) m, counterclockwise, that presses with p0 + slope . x >= 0; its load is one."""

    polygon: Array
    p0: float
    slope: Array


def moments(polygon: Array) -> tuple[float, Array, Array]:
    """Area (m^2), centroid (2,) and second moments about the centroid, (2, 2), per area, of a polygon (k, 2)."""
    middle = polygon.mean(axis=0)
    start = polygon - middle
    end = np.roll(start, -1, axis=0)
    twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
    area = 0.5 * float(twice.sum())
    centroid = twice @ (start + end) / (6.0 * area)
    pairs = np.einsum("e,ei,ej->ij", twice, start, start) + np.einsum("e,ei,ej->ij", twice, end, end)
    crossed = np.einsum("e,ei,ej->ij", twice, start, end)
    second = (2.0 * pairs + crossed + crossed.T) / (24.0 * area)
    return area, middle + centroid, second - np.outer(centroid, centroid)


def regular(corners: int, radius: float = 1.0, turned: float = 0.0) -> Array:
    """A regular polygon, (corners, 2); with hundreds of corners, a disc."""
    angle = 2.0 * np.pi * np.arange(corners) / corners + turned
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def rectangle(length: float, width: float) -> Array:
    """Corners of a rectangle around the origin, (4, 2)."""
    return 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])


def even_face(polygon: Array) -> Face:
    """The face of even pressure."""
    return Face(polygon, 1.0 / moments(polygon)[0], np.zeros(2))


def part_above(polygon: Array, p0: float, slope: Array) -> Array:
    """The part of a convex polygon where p0 + slope . x > 0, (k, 2); k = 0 if there is none."""
    p = p0 + polygon @ slope
    kept = []
    for k in range(len(polygon)):
        j = (k + 1) % len(polygon)
        if p[k] > 0.0:
            kept.append(polygon[k])
        if (p[k] > 0.0) != (p[j] > 0.0):
            kept.append(polygon[k] + (polygon[j] - polygon[k]) * (p[k] / (p[k] - p[j])))
    return np.array(kept).reshape(-1, 2)


def face_without_tension(polygon: Array, center: Array) -> Face:
    """The face whose pressure max(0, p0 + slope . x) has its centre at ``center``, (2,), strictly inside ``polygon``.

    The pressure is the gradient of a convex problem: of all p >= 0 with this load and this centre it has the least
    integral of p^2, and (p0, slope) are its multipliers. Newton's method on the dual, minimise
    1/2 int max(0, p0 + slope . x)^2 - p0 - slope . center, with the moments of the pressed part as its Hessian.

    Raises:
        ValueError: If ``center`` is not inside, or so near the border that no pressure is found.
    """
    area, centroid, second = moments(polygon)
    sides, arms = np.roll(polygon, -1, axis=0) - polygon, np.asarray(center) - polygon
    if (sides[:, 0] * arms[:, 1] - sides[:, 1] * arms[:, 0]).min() <= 0.0:
        raise ValueError(f"The centre of pressure {center} is not inside the face.")
    # in coordinates in which the face is as wide as it is long
    values, axes = np.linalg.eigh(second)
    widen = axes / np.sqrt(values)
    unit = (polygon - centroid) @ widen
    if np.linalg.det(widen) < 0.0:
        unit = unit[::-1]
    area = moments(unit)[0]
    wanted = (np.asarray(center) - centroid) @ widen
    x = np.array([1.0 / area, 0.0, 0.0])
    for station in np.linspace(0.0, 1.0, PATH + 1)[1:] ** 0.5:
        x = _newton(unit, x, station * wanted)
    slope = widen @ x[1:]
    p0 = float(x[0] - slope @ centroid)
    # back to the scale of the face, where areas are another
    scale = abs(float(np.linalg.det(widen)))
    p0, slope = p0 * scale, slope * scale
    pressed = part_above(polygon, p0, slope)
    return Face(pressed, p0, slope)


def _newton(polygon: Array, x: Array, center: Array) -> Array:
    """(p0, slope) of the dual problem, from a start ``x``."""
    right = np.array([1.0, *center])

    def state(x: Array) -> tuple[float, Array, Array]:
        part = part_above(polygon, x[0], x[1:])
        if len(part) < 3:
            return np.inf, right, np.eye(3)
        area, middle, second = moments(part)
        H = area * np.block([[np.ones((1, 1)), middle[None]], [middle[:, None], second + np.outer(middle, middle)]])
        return float(0.5 * x @ H @ x - right @ x), H @ x - right, H

    value, residual, H = state(x)
    for _ in range(NEWTON_STEPS):
        if _size(residual) < SETTLED:
            return x
        step = -np.linalg.solve(H, residual)
        length = 1.0
        while length > 1e-9:
            new_value, new_residual, new_H = state(x + length * step)
            falls = new_value <= value + 1e-4 * length * float(residual @ step)
            # near the solution the value falls by less than it is rounded to, what is left of the equations does not
            if falls or _size(new_residual) < 0.5 * _size(residual):
                break
            length *= 0.5
        x, value, residual, H = x + length * step, new_value, new_residual, new_H
    if _size(residual) > 1e-8:
        raise ValueError(f"No pressure without tension was found with its centre at {center}.")
    return x


def _size(residual: Array) -> float:
    return float(np.abs(residual).max())


def friction_of(face: Face, twists: Array) -> Array:
    """Force and torque about the origin, (n, 3), of a face at twists (v_x, v_y, w), (n, 3), w != 0.

    Not on the body but from it, so that twist . wrench is what is dissipated, per mu N.
    """
    v, w = twists[:, :2], twists[:, 2]
    center = np.stack([-v[:, 1], v[:, 0]], axis=1) / w[:, None]
    pressure = face.p0 + center @ face.slope
    radial, arms = np.zeros_like(v), np.zeros_like(w)
    for start, end in zip(face.polygon, np.roll(face.polygon, -1, axis=0), strict=True):
        length = float(np.hypot(*(end - start)))
        if length == 0.0:
            continue
        t = (end - start) / length
        n = np.array([t[1], -t[0]])
        d = (start - center) @ n
        lower, upper = (start - center) @ t, (end - center) @ t
        r0, r1 = np.hypot(lower, d), np.hypot(upper, d)
        near = np.where(d == 0.0, 1.0, np.abs(d))
        I0 = np.where(d == 0.0, 0.0, np.arcsinh(upper / near) - np.arcsinh(lower / near))
        I1 = r1 - r0
        half = 0.5 * (upper * r1 - lower * r0)
        I2, IR = half - 0.5 * d * d * I0, half + 0.5 * d * d * I0
        IuR = (r1**3 - r0**3) / 3.0
        gn, gt = float(face.slope @ n), float(face.slope @ t)
        along_n = 0.5 * d * d * I0 * pressure + d * d / 3.0 * (gn * d * I0 + gt * I1)
        along_t = 0.5 * d * I1 * pressure + d / 3.0 * (gn * d * I1 + gt * I2)
        radial += along_n[:, None] * n + along_t[:, None] * t
        arms += d * IR * pressure / 3.0 + 0.25 * d * (gn * d * IR + gt * IuR)
    sign = np.sign(w)
    force = sign[:, None] * np.stack([-radial[:, 1], radial[:, 0]], axis=1)
    torque = sign * arms + center[:, 0] * force[:, 1] - center[:, 1] * force[:, 0]
    return np.column_stack([force, torque])


def friction_about(face: Face, center: Array, twists: Array) -> Array:
    """The same with the slip and the torque taken at a point ``center``, (2,)."""
    return friction_of(Face(face.polygon - center, face.p0 + float(face.slope @ center), face.slope), twists)


def pressure_moments(face: Face, center: Array) -> Array:
    """Second moments of the pressure about ``center``, (2, 2), m^2, exact: an edge's triangles with the first corner.

    Of a product of three linear functions over a triangle only the values at the corners are needed:
    the integral of l_i l_j l_k is A / 10, A / 30 or A / 60 for three, two or no equal indices.
    """
    points = face.polygon - center
    p = face.p0 + face.polygon @ face.slope
    total = np.zeros((2, 2))
    for k in range(1, len(points) - 1):
        x, w = points[[0, k, k + 1]], p[[0, k, k + 1]]
        a, b = x[1] - x[0], x[2] - x[0]
        area = 0.5 * float(a[0] * b[1] - a[1] * b[0])
        weights = (w.sum() + w[:, None] + w[None, :]) * (1.0 + np.eye(3))
        total += area / 60.0 * x.T @ weights @ x
    return total


def mean_arm(face: Face, center: Array) -> float:
    """Torque of pure spinning about ``center`` per mu N, m."""
    return float(friction_about(face, center, np.array([[0.0, 0.0, 1.0]]))[0, 2])


def directions(n: int) -> Array:
    """(n, 3) unit vectors with z > 0, evenly spread: twists from spin to translation."""
    k = np.arange(n) + 0.5
    z, angle = k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(angle), s * np.sin(angle), z], axis=1)
