"""Narrow phase: from pairs of bodies to contact points, one pair family a file."""

from __future__ import annotations

from stiction.core.broadphase import body_margin
from stiction.core.collide.box_box import box_box
from stiction.core.collide.box_plane import box_plane
from stiction.core.collide.sphere import sphere_box, sphere_plane, sphere_sphere
from stiction.core.jit import jit
from stiction.core.state import BOX, ORIENTATION, POSITION, SHAPE, SIZE, SPHERE
from stiction.core.vec import dot, quat, rotation, vec3


@jit
def find_contacts(bodies, kinds, pairs, npairs, contacts, tags, gravity, dt, points, boxes_meet):
    """Fill ``contacts`` from the pairs; returns how many there are, which may exceed the room.

    ``boxes_meet`` is None in worlds where no box can meet another one: the branch, which is most of the machine code,
    is then never compiled.
    """
    count = 0
    for k in range(npairs):
        # the shape with the lower code first
        a, b = pairs[k, 0], pairs[k, 1]
        if kinds[a, SHAPE] > kinds[b, SHAPE]:
            a, b = b, a
        margin = body_margin(bodies, kinds, a, gravity, dt) + body_margin(bodies, kinds, b, gravity, dt)
        pa, pb = vec3(bodies, a, POSITION), vec3(bodies, b, POSITION)
        qa, qb = quat(bodies, a, ORIENTATION), quat(bodies, b, ORIENTATION)
        sa, sb = vec3(bodies, a, SIZE), vec3(bodies, b, SIZE)
        margin += 1e-6 * (sa.x + sb.x)
        if kinds[a, SHAPE] == SPHERE:
            if kinds[b, SHAPE] == SPHERE:
                count = sphere_sphere(contacts, tags, count, a, pa, sa.x, b, pb, sb.x, margin)
            elif kinds[b, SHAPE] == BOX:
                count = sphere_box(contacts, tags, count, a, pa, sa.x, b, pb, qb, sb, margin)
            else:
                n, offset = world_plane(bodies, b)
                count = sphere_plane(contacts, tags, count, a, pa, sa.x, b, n, offset, margin)
        elif kinds[a, SHAPE] == BOX:
            if kinds[b, SHAPE] == BOX:
                if boxes_meet is not None:
                    count = box_box(contacts, tags, count, a, pa, qa, sa, b, pb, qb, sb, margin, points)
            else:
                n, offset = world_plane(bodies, b)
                count = box_plane(contacts, tags, count, a, pa, qa, sa, b, n, offset, margin, points)
    return count


@jit
def world_plane(bodies, i):
    """Normal and offset of plane i in world coordinates: points with n . x = offset lie on it."""
    n = rotation(quat(bodies, i, ORIENTATION)) @ vec3(bodies, i, SIZE)
    return n, bodies[i, SIZE + 3] + dot(n, vec3(bodies, i, POSITION))
