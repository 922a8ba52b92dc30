"""Contacts of a sphere: with a sphere, a box, a cylinder and a plane. One point each.

All but the last also return the separation, whatever the margin.
"""

from __future__ import annotations

import math

from stiction.core.collide.manifold import emit
from stiction.core.jit import jit
from stiction.core.vec import Vec3, dot, length, rotation, transpose


@jit
def sphere_sphere(contacts, tags, count, a, pa, ra, b, pb, rb, margin):
    """The point half way between the surfaces, on the line of centres."""
    d = pb - pa
    distance = length(d)
    separation = distance - ra - rb
    if separation > margin:
        return count, separation
    normal = d * (1.0 / distance) if distance > 0.0 else Vec3(0.0, 0.0, 1.0)
    point = pa + normal * (ra + 0.5 * separation)
    return emit(contacts, tags, count, a, b, point, normal, separation, 0), separation


@jit
def sphere_box(contacts, tags, count, a, pa, radius, b, pb, qb, half, margin):
    """The point of the box nearest to the centre; from inside, the face that is nearest."""
    R = rotation(qb)
    c = transpose(R) @ (pa - pb)
    near = Vec3(
        min(max(c.x, -half.x), half.x), min(max(c.y, -half.y), half.y), min(max(c.z, -half.z), half.z)
    )  # fmt: skip
    d = c - near
    distance = length(d)
    if distance > 0.0:
        separation = distance - radius
        if separation > margin:
            return count, separation
        outward = d * (1.0 / distance)
    else:
        gx, gy, gz = half.x - abs(c.x), half.y - abs(c.y), half.z - abs(c.z)
        if gx <= gy and gx <= gz:
            outward = Vec3(math.copysign(1.0, c.x), 0.0, 0.0)
            separation = -gx - radius
        elif gy <= gz:
            outward = Vec3(0.0, math.copysign(1.0, c.y), 0.0)
            separation = -gy - radius
        else:
            outward = Vec3(0.0, 0.0, math.copysign(1.0, c.z))
            separation = -gz - radius
    normal = -(R @ outward)
    point = pa + normal * (radius + 0.5 * separation)
    return emit(contacts, tags, count, a, b, point, normal, separation, 0), separation


@jit
def sphere_plane(contacts, tags, count, a, pa, radius, b, n, offset, margin):
    """``n`` and ``offset`` of the plane in world coordinates."""
    separation = dot(n, pa) - offset - radius
    if separation > margin:
        return count
    return emit(contacts, tags, count, a, b, pa - n * (radius + 0.5 * separation), -n, separation, 0)


@jit
def sphere_cylinder(contacts, tags, count, a, pa, radius, b, pb, qb, size, margin):
    """The point of the cylinder nearest to the centre; from inside, the cap or the side, whichever is nearer."""
    R = rotation(qb)
    c = transpose(R) @ (pa - pb)
    r = math.sqrt(c.x * c.x + c.y * c.y)
    # outward from the axis; on the axis any direction will do
    u = Vec3(c.x / r, c.y / r, 0.0) if r > 0.0 else Vec3(1.0, 0.0, 0.0)
    side, cap = r - size.x, abs(c.z) - size.z
    up = Vec3(0.0, 0.0, math.copysign(1.0, c.z))
    if side <= 0.0 and cap <= 0.0:
        distance = max(side, cap)
        outward = u if side > cap else up
    else:
        beyond, above = max(side, 0.0), max(cap, 0.0)
        distance = math.sqrt(beyond * beyond + above * above)
        outward = (u * beyond + up * above) * (1.0 / distance)
    separation = distance - radius
    if separation > margin:
        return count, separation
    normal = -(R @ outward)
    point = pa + normal * (radius + 0.5 * separation)
    return emit(contacts, tags, count, a, b, point, normal, separation, 0), separation
