"""Narrow phase: from pairs of bodies to contact points, one pair family a file."""

from __future__ import annotations

from stiction.core.broadphase import body_margin
from stiction.core.collide.box_box import box_box
from stiction.core.collide.box_plane import box_plane
from stiction.core.collide.capsule import capsule_capsule
from stiction.core.collide.convex import convex_convex
from stiction.core.collide.ellipsoid import ellipsoid_plane
from stiction.core.collide.hulls import convex_of
from stiction.core.collide.on_plane import cylinder_plane, hull_plane
from stiction.core.collide.sphere import sphere_box, sphere_cylinder, sphere_plane, sphere_sphere
from stiction.core.jit import jit
from stiction.core.state import BOX, CAPSULE, CYLINDER, ELLIPSOID, ORIENTATION, PLANE, POSITION, SHAPE, SIZE, SPHERE
from stiction.core.vec import Vec3, dot, quat, rotation, vec3


@jit
def find_contacts(bodies, kinds, pairs, npairs, contacts, tags, gravity, dt, points, boxes_meet, hulls):
    """Fill ``contacts`` from the pairs; returns how many there are, which may exceed the room.

    ``points``, ``boxes_meet`` and ``hulls`` are those of :func:`pair_contacts`.
    """
    count, nowhere = 0, Vec3(0.0, 0.0, 0.0)
    for k in range(npairs):
        a, b = pairs[k, 0], pairs[k, 1]
        margin = body_margin(bodies, kinds, a, gravity, dt) + body_margin(bodies, kinds, b, gravity, dt)
        count, _, _ = pair_contacts(
            bodies, kinds, a, b, margin, nowhere, contacts, tags, count, points, boxes_meet, hulls
        )
    return count


@jit
def pair_contacts(bodies, kinds, a, b, margin, hint, contacts, tags, count, points, boxes_meet, hulls):
    """Write up to four contact points of bodies a and b that are no farther apart than ``margin``, from row ``count``.

    ``hint`` is the direction, of any length, from a to b that was found for this pair a moment ago, or zero. Returns
    the new count, which may exceed the room; and, if there is no new point, a direction to begin with the next time
    (zero if there is none) and a separation that the bodies have at least. ``points`` is scratch, (SCRATCH, 5).

    ``boxes_meet`` is None in worlds where no box can meet another one, and ``hulls``, the table of the convex hulls, in
    worlds of spheres, boxes and planes: those branches, which are most of the machine code, are then never compiled.
    """
    # planes come last, else the shape with the lower code first
    swapped = kinds[a, SHAPE] == PLANE or (kinds[b, SHAPE] != PLANE and kinds[a, SHAPE] > kinds[b, SHAPE])
    if swapped:
        a, b, hint = b, a, -hint
    one, other = kinds[a, SHAPE], kinds[b, SHAPE]
    pa, pb = vec3(bodies, a, POSITION), vec3(bodies, b, POSITION)
    qa, qb = quat(bodies, a, ORIENTATION), quat(bodies, b, ORIENTATION)
    sa, sb = vec3(bodies, a, SIZE), vec3(bodies, b, SIZE)
    margin += 1e-6 * (sa.x + sb.x)
    toward, gap = Vec3(0.0, 0.0, 0.0), margin

    if other == PLANE:
        n, offset = world_plane(bodies, b)
        if one == SPHERE:
            count = sphere_plane(contacts, tags, count, a, pa, sa.x, b, n, offset, margin)
        elif one == BOX:
            count = box_plane(contacts, tags, count, a, pa, qa, sa, b, n, offset, margin, points)
        elif hulls is not None:
            A = convex_of(bodies, kinds, a, Vec3(0.0, 0.0, 0.0), hulls)
            offset -= dot(n, pa)
            if one == CYLINDER:
                count = cylinder_plane(contacts, tags, count, a, A, b, n, offset, pa, margin)
            elif one == ELLIPSOID:
                count = ellipsoid_plane(contacts, tags, count, a, A, b, n, offset, pa, margin)
            else:
                count = hull_plane(contacts, tags, count, a, A, b, n, offset, pa, hulls, margin, points)
    elif other == SPHERE:
        count, gap = sphere_sphere(contacts, tags, count, a, pa, sa.x, b, pb, sb.x, margin)
    elif other == BOX:
        if one == SPHERE:
            count, gap = sphere_box(contacts, tags, count, a, pa, sa.x, b, pb, qb, sb, margin)
        elif boxes_meet is not None:
            count, toward, gap = box_box(contacts, tags, count, a, pa, qa, sa, b, pb, qb, sb, margin, hint, points)
    elif hulls is not None:
        if one == SPHERE and other == CYLINDER:
            count, gap = sphere_cylinder(contacts, tags, count, a, pa, sa.x, b, pb, qb, sb, margin)
        else:
            # near the origin, so that places far away cost no digits
            A = convex_of(bodies, kinds, a, Vec3(0.0, 0.0, 0.0), hulls)
            B = convex_of(bodies, kinds, b, pb - pa, hulls)
            if (one == SPHERE or one == CAPSULE) and other == CAPSULE:
                count, gap = capsule_capsule(contacts, tags, count, a, A, b, B, pa, hulls, margin, points)
            else:
                count, toward, gap = convex_convex(contacts, tags, count, a, A, b, B, pa, hint, hulls, margin, points)
    return count, -toward if swapped else toward, gap


@jit
def world_plane(bodies, i):
    """Normal and offset of plane i in world coordinates: points with n . x = offset lie on it."""
    n = rotation(quat(bodies, i, ORIENTATION)) @ vec3(bodies, i, SIZE)
    return n, bodies[i, SIZE + 3] + dot(n, vec3(bodies, i, POSITION))
