"""What the solvers ask of a contact row: its velocity, its matrix, its coefficients, and what an impulse does."""

from __future__ import annotations

from stiction.core.contact_space import (
    collision_velocity,
    contact_basis,
    contact_matrix,
    planar_velocity,
    to_contact,
    world_inverse_inertia,
)
from stiction.core.jit import jit
from stiction.core.state import (
    BODY_A,
    BODY_B,
    CENTER,
    INVERSE_INERTIA,
    INVERSE_MASS,
    K_ROW,
    MATERIAL,
    MU,
    NORMAL,
    ORIENTATION,
    POINT,
    POSITION,
    SEPARATION,
    SURFACE,
    TANGENTIAL,
    TOTAL,
    TOTAL_FRICTION,
    TWIST,
    WORLD_INERTIA,
    V,
    W,
    X,
)
from stiction.core.vec import Mat33, Vec3, cross, dot, mat33, put_mat33, put_vec3, quat, rotation, vec3


@jit
def prepare_bodies(bodies, n):
    """Centres of mass and inverse inertia tensors in world axes, and clean scratch."""
    for i in range(n):
        R = rotation(quat(bodies, i, ORIENTATION))
        put_vec3(bodies, i, X, vec3(bodies, i, POSITION) + R @ vec3(bodies, i, CENTER))
        if is_dynamic(bodies, i):
            put_mat33(bodies, i, WORLD_INERTIA, world_inverse_inertia(R, mat33(bodies, i, INVERSE_INERTIA)))


@jit
def prepare_contacts(bodies, kinds, table, contacts, tags, m, first, touching, n):
    """The matrix K and the coefficients of every contact, no impulses, and who touches which dynamic body."""
    for i in range(n + 1):
        first[i] = 0
    for c in range(m):
        a, b = tags[c, BODY_A], tags[c, BODY_B]
        put_vec3(contacts, c, POINT, meeting_point(bodies, contacts, c, a, b))
        ra, rb = arm(bodies, contacts, c, a), arm(bodies, contacts, c, b)
        K = contact_matrix(
            bodies[a, INVERSE_MASS], mat33(bodies, a, WORLD_INERTIA), ra,
            bodies[b, INVERSE_MASS], mat33(bodies, b, WORLD_INERTIA), rb,
            contact_basis(vec3(contacts, c, NORMAL)),
        )  # fmt: skip
        row = contacts[c, K_ROW : K_ROW + 6]
        row[0], row[1], row[2], row[3], row[4], row[5] = K.xx, K.xy, K.xz, K.yy, K.yz, K.zz
        for k in range(5):
            contacts[c, MU + k] = table[kinds[a, MATERIAL], kinds[b, MATERIAL], k]
        rebounds = table.shape[2] > TANGENTIAL
        contacts[c, MU + TANGENTIAL] = table[kinds[a, MATERIAL], kinds[b, MATERIAL], TANGENTIAL] if rebounds else 0.0
        contacts[c, TOTAL] = 0.0
        put_vec3(contacts, c, TOTAL_FRICTION, Vec3(0.0, 0.0, 0.0))
        put_vec3(contacts, c, TWIST, Vec3(0.0, 0.0, 0.0))
        first[a] += is_dynamic(bodies, a)
        first[b] += is_dynamic(bodies, b)

    total = 0
    for i in range(n + 1):
        here = first[i]
        first[i] = total
        total += here
    for c in range(m):
        for body in (tags[c, BODY_A], tags[c, BODY_B]):
            if is_dynamic(bodies, body):
                touching[first[body]] = c
                first[body] += 1
    for i in range(n, 0, -1):
        first[i] = first[i - 1]
    first[0] = 0


@jit
def meeting_point(bodies, contacts, c, a, b):
    """Where two surfaces will act on each other: half way between them, so that angular momentum is kept to the last
    digit; but where only one of the bodies moves, on its own surface, which will be there when they meet.

    A ball that is 7 cm above the floor, and gets there within the step, is pushed at its foot.
    """
    moves_a, moves_b = is_dynamic(bodies, a), is_dynamic(bodies, b)
    side = 0.0 if moves_a == moves_b else (-0.5 if moves_a else 0.5)
    return vec3(contacts, c, POINT) + vec3(contacts, c, NORMAL) * (side * contacts[c, SEPARATION])


@jit
def arm(bodies, contacts, c, body):
    """From a body's centre of mass to the contact point."""
    return vec3(contacts, c, POINT) - vec3(bodies, body, X)


@jit
def matrix(contacts, c):
    """K of a contact."""
    k = contacts[c, K_ROW : K_ROW + 6]
    return Mat33(k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5])


@jit
def surface_velocity(bodies, body, n):
    """Velocity of a body's surface relative to the body itself (a belt), in the plane of the contact."""
    s = rotation(quat(bodies, body, ORIENTATION)) @ vec3(bodies, body, SURFACE)
    return planar_velocity(s, n)


@jit
def has_surface(bodies, body):
    """Whether the body's surface moves."""
    s = vec3(bodies, body, SURFACE)
    return s.x != 0.0 or s.y != 0.0 or s.z != 0.0


@jit
def is_dynamic(bodies, body):
    """Whether forces and impulses move the body."""
    return bodies[body, INVERSE_MASS] > 0.0


@jit
def slip(bodies, v, w, contacts, tags, c, B):
    """The collision velocity of a contact in contact coordinates, moving surfaces included.

    ``v, w`` are columns: V, W for the present velocities, V_START, W_START for those at the start.
    """
    a, b = tags[c, BODY_A], tags[c, BODY_B]
    ra, rb = arm(bodies, contacts, c, a), arm(bodies, contacts, c, b)
    u = collision_velocity(vec3(bodies, a, v), vec3(bodies, a, w), ra, vec3(bodies, b, v), vec3(bodies, b, w), rb)
    if has_surface(bodies, a):
        u = u + surface_velocity(bodies, a, vec3(contacts, c, NORMAL))
    if has_surface(bodies, b):
        u = u - surface_velocity(bodies, b, vec3(contacts, c, NORMAL))
    return to_contact(B, u)


@jit
def apply(bodies, contacts, tags, c, impulse):
    """Change the velocities of both bodies by a world impulse at the contact point, + on b and - on a."""
    for body, p in ((tags[c, BODY_A], -impulse), (tags[c, BODY_B], impulse)):
        if is_dynamic(bodies, body):
            put_vec3(bodies, body, V, vec3(bodies, body, V) + p * bodies[body, INVERSE_MASS])
            torque = cross(arm(bodies, contacts, c, body), p)
            put_vec3(bodies, body, W, vec3(bodies, body, W) + mat33(bodies, body, WORLD_INERTIA) @ torque)


@jit
def twist(bodies, tags, c, torque):
    """Change the angular velocities of both bodies by a world angular impulse, + on b and - on a."""
    for body, t in ((tags[c, BODY_A], -torque), (tags[c, BODY_B], torque)):
        put_vec3(bodies, body, W, vec3(bodies, body, W) + mat33(bodies, body, WORLD_INERTIA) @ t)


@jit
def relative_spin(bodies, w, tags, c):
    """w_A - w_B, world axes; ``w`` is the column W or W_START."""
    return vec3(bodies, tags[c, BODY_A], w) - vec3(bodies, tags[c, BODY_B], w)


@jit
def prescribed_velocity(bodies, contacts, c, body):
    """World velocity that is imposed on the contact by this body: a drive's, a belt's; zero for a free body."""
    velocity = Vec3(0.0, 0.0, 0.0)
    if not is_dynamic(bodies, body):
        velocity = vec3(bodies, body, V) + cross(vec3(bodies, body, W), arm(bodies, contacts, c, body))
    if has_surface(bodies, body):
        velocity = velocity + surface_velocity(bodies, body, vec3(contacts, c, NORMAL))
    return velocity


@jit
def work_of_drives(bodies, contacts, tags, c, impulse, torque):
    """Work (J) that drives and belts put in against the world impulse and angular impulse on b."""
    a, b = tags[c, BODY_A], tags[c, BODY_B]
    work = dot(impulse, prescribed_velocity(bodies, contacts, c, a) - prescribed_velocity(bodies, contacts, c, b))
    if not is_dynamic(bodies, a):
        work += dot(torque, vec3(bodies, a, W))
    if not is_dynamic(bodies, b):
        work -= dot(torque, vec3(bodies, b, W))
    return work
