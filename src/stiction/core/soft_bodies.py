"""Bodies between the world's float64 rows and the soft solver's rows: loading, substeps, and moving at the end.

A body without contact is not the solver's business: it flies a whole step with the mean of its old and new velocity,
exactly. A body in contact moves with its new velocity in each substep, but one that only slides, in one plane, or rolls
on one point, moves along that plane with the mean, so that a stopping distance is not v h / 2 too short.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.broadphase import body_margin, set_bounds
from stiction.core.contact_space import world_inverse_inertia
from stiction.core.contact_work import note_tumbler
from stiction.core.integrate import NO_TURN, half_way, spin_freely, spin_in_contact
from stiction.core.jit import jit
from stiction.core.lanes import load_part, store_part
from stiction.core.leaning import begin_lean, forget_lean, keep_lean
from stiction.core.sleep import REST_SPEED
from stiction.core.state import (
    CENTER,
    DYNAMIC,
    FORCE,
    FRICTION_WORK,
    INERTIA,
    INVERSE_INERTIA,
    INVERSE_MASS,
    KINEMATIC,
    MOBILITY,
    MOTION,
    ORIENTATION,
    PLANE,
    POSITION,
    REACH,
    REST,
    SHAPE,
    SURFACE,
    TORQUE,
    V_START,
    W_START,
    WORK,
    V,
    W,
)
from stiction.core.vec import (
    Vec3,
    dot,
    length,
    mat33,
    put_mat33,
    put_quat,
    put_vec3,
    quat,
    rotation,
    transpose,
    turn,
    vec3,
    wide,
)

NO_GLIDE, GLIDES, ROLLS, FALLS = range(4)
"""How a body in contact moves within a substep: with its new velocity; along one plane with the mean; also turning
so; or, if its contacts carry nothing yet, with the mean of what gravity and forces do."""

ROUNDING = 1e-14
"""Of a spin energy, by which it may seem to have changed."""


@jit
def begin_body(bodies, kinds, i, pose, rows, aux, gravity, g, dt, h):
    """Everything that a step asks of body i where it is now: pose, bounds, and its row in the solver.

    One pass over the wide rows of the bodies; what comes later reads the narrow ones that this writes. ``gravity`` is a
    vector, ``g`` its length.
    """
    r = i + 1
    R = rotation(quat(bodies, i, ORIENTATION))
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    center = vec3(bodies, i, CENTER)
    margin = body_margin(bodies, kinds, i, g, dt)
    x = vec3(bodies, i, POSITION) + R @ center
    put_vec3(pose, r, s.POSE_X, x)
    put_mat33(pose, r, s.POSE_ROTATION, R)
    pose[r, s.POSE_MOTION], pose[r, s.POSE_REACH], pose[r, s.POSE_MARGIN] = bodies[i, MOTION], bodies[i, REACH], margin
    belt = vec3(bodies, i, SURFACE)
    pose[r, s.POSE_ODD] = 0.0 if belt.x == 0.0 and belt.y == 0.0 and belt.z == 0.0 else s.HAS_BELT
    if kinds[i, SHAPE] != PLANE:
        set_bounds(bodies, kinds, i, R, margin)

    for k in range(s.ROW_WIDTH):
        rows[r, k] = 0.0
    put_mat33(aux, r, s.AUX_ROTATION, R)
    aux[r, s.AUX_MASS] = bodies[i, INVERSE_MASS]
    if kinds[i, MOBILITY] == DYNAMIC:
        # that comes bit by bit, as gravity does
        inverse_inertia = mat33(bodies, i, INVERSE_INERTIA)
        free, middle, far = spin_in_contact(
            quat(bodies, i, ORIENTATION), R, mat33(bodies, i, INERTIA), inverse_inertia, w, dt
        )  # fmt: skip
        I = world_inverse_inertia(middle, inverse_inertia)
        a, angular = gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS], I @ vec3(bodies, i, TORQUE)
        put_vec3(rows, r, s.ROW_V, a * h)
        put_vec3(rows, r, s.ROW_W, (free * (1.0 / dt) + angular) * h)
        put_vec3(aux, r, s.AUX_FREE, free)
        pose[r, s.POSE_ODD] += s.TUMBLES if far else 0.0
        put_vec3(aux, r, s.AUX_INERTIA, Vec3(I.xx, I.xy, I.xz))
        put_vec3(aux, r, s.AUX_INERTIA + 3, Vec3(I.yy, I.yz, I.zz))
    else:
        # a kinematic body that is told another velocity takes it over in the course of the step, for contacts only:
        # in one substep it would ask friction for many times the force
        part = h / dt if kinds[i, MOBILITY] == KINEMATIC else 1.0
        new_v, new_w = v, w
        if kinds[i, MOBILITY] == KINEMATIC:
            v, w = vec3(bodies, i, V_START), vec3(bodies, i, W_START)
        put_vec3(rows, r, s.ROW_V, (new_v - v) * part)
        put_vec3(rows, r, s.ROW_W, (new_w - w) * part)
        for k in range(s.AUX_MASS, s.AUX_WORK):
            aux[r, k] = 0.0
    put_vec3(aux, r, s.AUX_OLD_V, Vec3(0.0, 0.0, 0.0))
    put_vec3(aux, r, s.AUX_OLD_W, Vec3(0.0, 0.0, 0.0))
    put_vec3(aux, r, s.AUX_START_V, v)
    put_vec3(aux, r, s.AUX_START_W, w)
    aux[r, s.AUX_WORK], aux[r, s.AUX_STRUCK], aux[r, s.AUX_LIFTED] = 0.0, 0.0, 0.0
    begin_lean(bodies, kinds, i, aux, gravity * (-1.0 / g if g > 0.0 else 0.0), x)


@jit
def move_rows(moving, first, end, glide, normals, rows, aux, h, last):
    """Displace the rows moving[first:end] by a substep, and start the next one unless this was the last.

    The next one starts from v' + (v' - v): gravity, forces and impulses of this substep act again (see ``solve.soft``).
    """
    for k in range(first, end):
        r = moving[k]
        new, old = load_part(rows, r, s.ROW_V), load_part(aux, r, s.AUX_OLD_V)
        store_part(rows, r, s.ROW_D, load_part(rows, r, s.ROW_D) + new * h)
        if glide[r] == FALLS:
            a = vec3(normals, r, 0)
            put_vec3(rows, r, s.ROW_D, vec3(rows, r, s.ROW_D) - a * (0.5 * h * h))
        elif glide[r] != NO_GLIDE:
            n = vec3(normals, r, 0)
            dv = wide(vec3(aux, r, s.AUX_OLD_V) - vec3(rows, r, s.ROW_V))
            dw = wide(vec3(aux, r, s.AUX_OLD_W) - vec3(rows, r, s.ROW_W))
            turn, along = n * dot(n, dw), dot(n, dv)
            if glide[r] == ROLLS:
                # what touches goes along n with its new velocity, however the body turns about it
                turn, along = dw, along + dot(dw, vec3(normals, r, 3))
            put_vec3(rows, r, s.ROW_D, vec3(rows, r, s.ROW_D) + (dv - n * along) * (0.5 * h))
            put_vec3(rows, r, s.ROW_TURN, vec3(rows, r, s.ROW_TURN) + turn * (0.5 * h))
        if not last:
            store_part(rows, r, s.ROW_V, new + (new - old))
            store_part(aux, r, s.AUX_OLD_V, new)


@jit
def row_is_finite(rows, r):
    """Whether everything in a body's row is a finite number."""
    total = 0.0
    for k in range(s.ROW_WIDTH):
        total += rows[r, k] * rows[r, k]
    return math.isfinite(total)


@jit
def finish_contact(bodies, i, pose, rows, aux, dt, ledger):
    """Take velocities and displacement of a dynamic body in contact over from its row; returns whether it tumbles."""
    r = i + 1
    v0, w0 = vec3(bodies, i, V), vec3(bodies, i, W)
    v1, w1 = v0 + wide(vec3(rows, r, s.ROW_V)), w0 + wide(vec3(rows, r, s.ROW_W))
    put_vec3(bodies, i, V, v1)
    put_vec3(bodies, i, W, w1)
    work = enter_work(bodies, i, v0 + v1, w0 + w1, dt, ledger)
    bodies[i, FRICTION_WORK] += aux[r, s.AUX_WORK]
    dx, angle = v0 * dt + wide(vec3(rows, r, s.ROW_D)), w0 * dt + wide(vec3(rows, r, s.ROW_TURN))
    keep_lean(bodies, i, aux, angle)
    R, q = mat33(pose, r, s.POSE_ROTATION), quat(bodies, i, ORIENTATION)
    _go(bodies, i, pose, dx, angle, dt)
    if dot(angle, angle) > NO_TURN * NO_TURN:
        # the turn is a sum over substeps, and not quite the one for which the spin is right
        now = rotation(quat(bodies, i, ORIENTATION))
        middle, _ = half_way(q, R, mat33(bodies, i, INVERSE_INERTIA), w0, dt)
        may, has = spin_energy_after(bodies, i, R, middle, now, w0, w1, wide(vec3(aux, r, s.AUX_FREE)))
        may = max(may, 0.0)
        if has > may * (1.0 + ROUNDING):
            put_vec3(bodies, i, W, w1 * math.sqrt(may / has))
    return note_tumbler(bodies, i, pose, aux, vec3(bodies, i, W), work, dt)


@jit
def spin_energy_after(bodies, i, R, middle, now, w0, w1, free):
    """Spin energy that body i may have after a step that turned it from the axes R to those of ``now``, and the one
    that it has, J.

    It had one with w0, and to that comes the work of the torques that changed its spin to w1, beyond the change
    ``free`` that takes no torque: by the mean of its spins, and the inertia of the ``middle`` that impulses acted on.
    That is what contact has taken from others or from the way of the body, and so no more than there was.
    """
    I = mat33(bodies, i, INERTIA)
    half = transpose(middle)
    work = dot(half @ ((w0 + w1) * 0.5), I @ (half @ (w1 - w0 - free)))
    first, last = transpose(R) @ w0, transpose(now) @ w1
    return 0.5 * dot(first, I @ first) + work, 0.5 * dot(last, I @ last)


@jit
def finish_free(bodies, kinds, i, pose, gravity, dt, ledger):
    """A whole step of a body that touches nothing, or of a kinematic one."""
    v0, w0 = vec3(bodies, i, V), vec3(bodies, i, W)
    if kinds[i, MOBILITY] != DYNAMIC:
        put_vec3(bodies, i, V_START, v0)
        put_vec3(bodies, i, W_START, w0)
        _go(bodies, i, pose, v0 * dt, w0 * dt, dt)
        return
    forget_lean(bodies, i)
    R = mat33(pose, i + 1, s.POSE_ROTATION)
    angle, w1, changes = spin_freely(R, mat33(bodies, i, INERTIA), w0, dt)
    I = world_inverse_inertia(R, mat33(bodies, i, INVERSE_INERTIA))
    dv = (gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS]) * dt
    dw = (I @ vec3(bodies, i, TORQUE)) * dt
    enter_work(bodies, i, v0 + v0 + dv, w0 + w0 + dw, dt, ledger)
    _go(bodies, i, pose, v0 * dt + dv * (0.5 * dt), angle + dw * (0.5 * dt), dt)
    put_vec3(bodies, i, V, v0 + dv)
    put_vec3(bodies, i, W, (rotation(quat(bodies, i, ORIENTATION)) @ w1 if changes else w0) + dw)


@jit
def free_is_finite(bodies, kinds, i, gravity, dt):
    """Whether a body without contact will have a finite state after a step."""
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    if kinds[i, MOBILITY] == DYNAMIC:
        v = v + (gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS]) * dt
        w = w + vec3(bodies, i, TORQUE) * dt
    x = vec3(bodies, i, POSITION) + v * dt
    return math.isfinite(dot(x, x) + dot(v, v) + dot(w, w))


@jit
def enter_work(bodies, i, twice_v, twice_w, dt, ledger):
    """Work of applied forces and torques over a step, by the mean velocities, J: enters the ledger, and is returned."""
    pulled, turned = dot(vec3(bodies, i, FORCE), twice_v), dot(vec3(bodies, i, TORQUE), twice_w)
    ledger[WORK] += 0.5 * dt * pulled
    ledger[WORK] += 0.5 * dt * turned
    return 0.5 * dt * (pulled + turned)


@jit
def _go(bodies, i, pose, dx, angle, dt):
    """Displace and turn body i; its forces are used up."""
    way = length(dx) + bodies[i, REACH] * length(angle)
    bodies[i, MOTION] += way
    bodies[i, REST] = bodies[i, REST] + dt if way < REST_SPEED * dt else 0.0
    x = vec3(pose, i + 1, s.POSE_X) + dx
    q = turn(quat(bodies, i, ORIENTATION), angle)
    put_quat(bodies, i, ORIENTATION, q)
    center = vec3(bodies, i, CENTER)
    if center.x != 0.0 or center.y != 0.0 or center.z != 0.0:
        x = x - rotation(q) @ center
    put_vec3(bodies, i, POSITION, x)
    zero = Vec3(0.0, 0.0, 0.0)
    put_vec3(bodies, i, FORCE, zero)
    put_vec3(bodies, i, TORQUE, zero)
