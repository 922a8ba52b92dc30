"""Broad phase: pairs of bodies whose bounds overlap, by sort and sweep along x (Baraff, 1992).

The order is kept from step to step, so the insertion sort costs one pass while little moves. Planes are unbounded and
meet every moving body.
"""

from __future__ import annotations

from stiction.core.contact_rows import is_dynamic
from stiction.core.jit import jit
from stiction.core.pairs import layers_agree
from stiction.core.state import (
    BOUNDS,
    ELLIPSOID,
    FORCE,
    INVERSE_MASS,
    MOBILITY,
    ORIENTATION,
    PLANE,
    POSITION,
    SHAPE,
    SIZE,
    SPHERE,
    STATIC,
    V,
    W,
)
from stiction.core.vec import Vec3, length, put_vec3, quat, rotation, vec3


@jit
def body_margin(bodies, kinds, i, gravity, dt):
    """How far a body can come towards another one in this step, m: contacts are found that far ahead."""
    if kinds[i, MOBILITY] == STATIC:
        return 0.0
    size = vec3(bodies, i, SIZE)
    reach = size.x if kinds[i, SHAPE] == SPHERE else length(size)
    speed = length(vec3(bodies, i, V)) + reach * length(vec3(bodies, i, W))
    if is_dynamic(bodies, i):
        speed += (gravity + length(vec3(bodies, i, FORCE)) * bodies[i, INVERSE_MASS]) * dt
    return speed * dt


@jit
def update_bounds(bodies, kinds, n, gravity, dt):
    """The axis-aligned box around each bounded shape, grown by its margin."""
    for i in range(n):
        bound_body(bodies, kinds, i, gravity, dt)


@jit
def bound_body(bodies, kinds, i, gravity, dt):
    """The same for one body."""
    if kinds[i, SHAPE] != PLANE:
        R = rotation(quat(bodies, i, ORIENTATION))
        set_bounds(bodies, kinds, i, R, body_margin(bodies, kinds, i, gravity, dt))


@jit
def set_bounds(bodies, kinds, i, R, margin):
    """The same for one body with rotation matrix R."""
    p, s = vec3(bodies, i, POSITION), vec3(bodies, i, SIZE)
    if kinds[i, SHAPE] == SPHERE:
        ex = ey = ez = s.x
    elif kinds[i, SHAPE] == ELLIPSOID:
        ex = length(Vec3(R.xx * s.x, R.xy * s.y, R.xz * s.z))
        ey = length(Vec3(R.yx * s.x, R.yy * s.y, R.yz * s.z))
        ez = length(Vec3(R.zx * s.x, R.zy * s.y, R.zz * s.z))
    else:
        ex = abs(R.xx) * s.x + abs(R.xy) * s.y + abs(R.xz) * s.z
        ey = abs(R.yx) * s.x + abs(R.yy) * s.y + abs(R.yz) * s.z
        ez = abs(R.zx) * s.x + abs(R.zy) * s.y + abs(R.zz) * s.z
    grow = margin + 1e-6 * (ex + ey + ez)
    put_vec3(bodies, i, BOUNDS, Vec3(p.x - ex - grow, p.y - ey - grow, p.z - ez - grow))
    put_vec3(bodies, i, BOUNDS + 3, Vec3(p.x + ex + grow, p.y + ey + grow, p.z + ez + grow))


@jit
def find_pairs(bodies, kinds, n, order, pairs):
    """Pairs (i < j) of which at least one is dynamic, and whose layers agree; returns how many, maybe beyond the room.

    A plane meets every dynamic body: a test of the bounds against it costs as much as the narrow phase does.
    """
    room = pairs.shape[0]

    for k in range(1, n):
        i = order[k]
        low = bodies[i, BOUNDS]
        j = k - 1
        # ties by index: the order, and with it every result, is a function of the positions alone
        while j >= 0 and (bodies[order[j], BOUNDS] > low or (bodies[order[j], BOUNDS] == low and order[j] > i)):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = i

    found = 0
    for k in range(n):
        i = order[k]
        if kinds[i, SHAPE] == PLANE:
            for j in range(n):
                if is_dynamic(bodies, j) and layers_agree(kinds, i, j):
                    if found < room:
                        pairs[found, 0], pairs[found, 1] = min(i, j), max(i, j)
                    found += 1
            continue
        for other in range(k + 1, n):
            j = order[other]
            if bodies[j, BOUNDS] > bodies[i, BOUNDS + 3]:
                break
            if kinds[j, SHAPE] == PLANE or not (is_dynamic(bodies, i) or is_dynamic(bodies, j)):
                continue
            if (
                bodies[i, BOUNDS + 1] <= bodies[j, BOUNDS + 4]
                and bodies[j, BOUNDS + 1] <= bodies[i, BOUNDS + 4]
                and bodies[i, BOUNDS + 2] <= bodies[j, BOUNDS + 5]
                and bodies[j, BOUNDS + 2] <= bodies[i, BOUNDS + 5]
                and layers_agree(kinds, i, j)
            ):
                if found < room:
                    pairs[found, 0], pairs[found, 1] = min(i, j), max(i, j)
                found += 1
    return found
