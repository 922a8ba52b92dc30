"""Work of contact over a step: what drives put in, and what bodies that tumble may gain by it.

A needle that turns by a radian in a step is touched at other places all the time, while its contacts have one arm each
in a step. What they do to it has little to do with what it is like, but one thing holds for whatever happens in
between: contact makes no energy. So such a body gets no more of it than those that touch it have given.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.jit import jit
from stiction.core.ledger import spin_energy, spin_energy_with
from stiction.core.manifolds import belt_velocity
from stiction.core.state import (
    CENTER,
    DYNAMIC,
    INERTIA,
    KINEMATIC,
    MASS,
    MOBILITY,
    ORIENTATION,
    POSITION,
    V_START,
    W_START,
    V,
    W,
)
from stiction.core.vec import cross, dot, mat33, put_vec3, quat, rotation, transpose, vec3, wide

FAST_TURN = 0.5
"""rad in a step, from which on a body that is not as a ball counts as one that tumbles."""


@jit
def drive_work(bodies, kinds, active, count, manifolds, meta, pose, reports):
    """Work (J) that kinematic bodies and moving surfaces put in over a step, before the bodies are moved."""
    work = 0.0
    for k in range(count):
        a, b, row = active[k, 0], active[k, 1], active[k, 2] + 1
        odd = pose[a + 1, s.POSE_ODD] + pose[b + 1, s.POSE_ODD] > 0.0
        if not odd and kinds[a, MOBILITY] != KINEMATIC and kinds[b, MOBILITY] != KINEMATIC:
            continue
        force, torque = impulse_of(manifolds, meta, pose, reports, a, row)
        work += dot(force, belt_velocity(bodies, pose, a, b))
        for i, arm, sign in ((a, s.ARM_A, 1.0), (b, s.ARM_B, -1.0)):
            if kinds[i, MOBILITY] == KINEMATIC:
                w = (vec3(bodies, i, W) + vec3(bodies, i, W_START)) * 0.5
                v = (vec3(bodies, i, V) + vec3(bodies, i, V_START)) * 0.5 + cross(w, vec3(manifolds, row, arm))
                work += sign * (dot(force, v) + dot(torque, w))
    return work


@jit
def impulse_of(manifolds, meta, pose, reports, a, row):
    """Impulse and angular impulse at the anchor that a manifold gave b in a step, world, N s and N m s."""
    force, torque = load_and_tilt(manifolds, meta, pose, reports, a, row)
    n = mat33(pose, a + 1, s.POSE_ROTATION) @ vec3(manifolds, row, s.NORMAL_A)
    return force + vec3(reports, row, s.TOTAL_PULL), torque + n * reports[row, s.TOTAL_TWIST]


@jit
def load_and_tilt(manifolds, meta, pose, reports, a, row):
    """The part of :func:`impulse_of` along the normal, N s and N m s."""
    Ra = mat33(pose, a + 1, s.POSE_ROTATION)
    n, u = Ra @ vec3(manifolds, row, s.NORMAL_A), Ra @ vec3(manifolds, row, s.TANGENT_A)
    load, tilt_u, tilt_v = 0.0, 0.0, 0.0
    for j in range(int(meta[row, s.POINTS])):
        load += reports[row, s.TOTAL_LOAD + j]
        tilt_u += reports[row, s.TOTAL_LOAD + j] * manifolds[row, s.PLACE_V + j]
        tilt_v -= reports[row, s.TOTAL_LOAD + j] * manifolds[row, s.PLACE_U + j]
    return n * load, u * tilt_u + cross(n, u) * tilt_v


@jit
def load_of(meta, reports, row):
    """The normal impulse that a manifold carried in its last step, N s."""
    load = 0.0
    for j in range(int(meta[row, s.POINTS])):
        load += reports[row, s.TOTAL_LOAD + j]
    return load


@jit
def note_tumbler(bodies, i, pose, aux, w1, work, dt):
    """Whether body i has tumbled in a step, or the step has made it so fast that it will; notes so, and the ``work`` of
    what pulls at it besides contact, J."""
    r = i + 1
    aux[r, s.AUX_PULLED] = work
    if not tumbles(pose, r):
        I = mat33(bodies, i, INERTIA)
        if dot(w1, w1) * dt * dt <= FAST_TURN * FAST_TURN or (I.xx == I.yy and I.yy == I.zz):
            return False
        pose[r, s.POSE_ODD] += s.TUMBLES
    aux[r, s.AUX_GIVEN], aux[r, s.AUX_OWES] = work, 0.0
    return True


@jit
def give_to_tumblers(bodies, active, count, touched, touching, soft, gravity, laws):
    """Enter what contact may have given bodies that tumble in a step: its impulse, by the mean velocity of what touches
    them there, or of both if both tumble. Belts and attraction may give any energy.

    Of two that tumble, one gives what the other gets. If it owes more than it has, all get their share of that.
    """
    pose, aux = soft.pose, soft.aux
    pairs = 0
    for k in range(count):
        a, b = active[k, 0] + 1, active[k, 1] + 1
        odd = pose[a, s.POSE_ODD] + pose[b, s.POSE_ODD]
        if odd < s.TUMBLES:
            continue
        by_a, by_b = powers(active, k, soft)
        if laws or (odd != s.TUMBLES and odd != 2.0 * s.TUMBLES):
            by_a, by_b = math.inf, -math.inf
        elif odd == 2.0 * s.TUMBLES:
            flow = 0.5 * (by_a + by_b)
            aux[a if flow > 0.0 else b, s.AUX_OWES] += abs(flow)
            pairs += 1
            continue
        if tumbles(pose, a):
            aux[a, s.AUX_GIVEN] -= by_b
        if tumbles(pose, b):
            aux[b, s.AUX_GIVEN] += by_a
    if pairs == 0:
        return
    for k in range(touching):
        r = touched[k] + 1
        if tumbles(pose, r) and aux[r, s.AUX_OWES] > 0.0:
            has, lifted = means_of(bodies, touched[k], soft, gravity)
            aux[r, s.AUX_OWES] = min(max(has - lifted, 0.0) / aux[r, s.AUX_OWES], 1.0)
    for k in range(count):
        a, b = active[k, 0] + 1, active[k, 1] + 1
        if laws or pose[a, s.POSE_ODD] + pose[b, s.POSE_ODD] != 2.0 * s.TUMBLES:
            continue
        by_a, by_b = powers(active, k, soft)
        flow = 0.5 * (by_a + by_b)
        flow *= aux[a if flow > 0.0 else b, s.AUX_OWES]
        aux[a, s.AUX_GIVEN] -= flow
        aux[b, s.AUX_GIVEN] += flow


@jit
def powers(active, k, soft):
    """The impulse of the pair active[k] by the mean velocities of its first and of its second body, J."""
    a, b, row = active[k, 0] + 1, active[k, 1] + 1, active[k, 2] + 1
    force, torque = impulse_of(soft.manifolds, soft.meta, soft.pose, soft.reports, a - 1, row)
    by_a = mean_power(soft.aux, soft.rows, a, force, torque, vec3(soft.manifolds, row, s.ARM_A))
    by_b = mean_power(soft.aux, soft.rows, b, force, torque, vec3(soft.manifolds, row, s.ARM_B))
    return by_a, by_b


@jit
def mean_power(aux, rows, r, force, torque, arm):
    """An impulse by the mean velocity in the step of the body of row r where it acts, J."""
    v = wide(vec3(aux, r, s.AUX_START_V)) + wide(vec3(rows, r, s.ROW_V)) * 0.5
    w = wide(vec3(aux, r, s.AUX_START_W)) + wide(vec3(rows, r, s.ROW_W)) * 0.5
    return dot(force, v + cross(w, arm)) + dot(torque, w)


@jit
def slow_down(bodies, i, part):
    """Leave body i that part of its velocities."""
    put_vec3(bodies, i, V, vec3(bodies, i, V) * part)
    put_vec3(bodies, i, W, vec3(bodies, i, W) * part)


@jit
def kinetic(bodies, i):
    """Kinetic energy of body i now, J."""
    v = vec3(bodies, i, V)
    return 0.5 * bodies[i, MASS] * dot(v, v) + spin_energy(bodies, i)


@jit
def kinetic_at_start(bodies, i, soft):
    """Kinetic energy of body i when the step began, J."""
    r = i + 1
    v, w = wide(vec3(soft.aux, r, s.AUX_START_V)), wide(vec3(soft.aux, r, s.AUX_START_W))
    turning = spin_energy_with(bodies, i, transpose(mat33(soft.pose, r, s.POSE_ROTATION)) @ w)
    return 0.5 * bodies[i, MASS] * dot(v, v) + turning


@jit
def rise_of(bodies, i, soft, gravity):
    """What the height of body i has gained in a step that has moved it, J."""
    return -bodies[i, MASS] * dot(gravity, displacement(bodies, i, soft))


@jit
def means_of(bodies, i, soft, gravity):
    """The kinetic energy that body i had at the start of a step and what it was given in it, and how much of that went
    into its height, J."""
    given = soft.aux[i + 1, s.AUX_GIVEN]
    return kinetic_at_start(bodies, i, soft) + given, rise_of(bodies, i, soft, gravity)


@jit
def tumbles(pose, r):
    """Whether the body of row r has turned far in the step, or soon will."""
    return pose[r, s.POSE_ODD] >= s.TUMBLES


@jit
def displacement(bodies, i, soft):
    """How far the centre of mass of body i has come in a step that has moved it."""
    now = rotation(quat(bodies, i, ORIENTATION))
    return vec3(bodies, i, POSITION) + now @ vec3(bodies, i, CENTER) - vec3(soft.pose, i + 1, s.POSE_X)


@jit
def hold_tumblers(bodies, kinds, touched, touching, soft, gravity):
    """Slow bodies down that have tumbled in a step, if they have more energy after it than before it and what they were
    given in it; those that could not even rise so far for it go back."""
    for k in range(touching):
        i = touched[k]
        if kinds[i, MOBILITY] != DYNAMIC or not tumbles(soft.pose, i + 1):
            continue
        has, lifted = means_of(bodies, i, soft, gravity)
        now, may = kinetic(bodies, i), max(has - lifted, 0.0)
        if now > may:
            slow_down(bodies, i, math.sqrt(may / now))
        if lifted > max(has, 0.0):
            back = 1.0 - max(has, 0.0) / lifted
            put_vec3(bodies, i, POSITION, vec3(bodies, i, POSITION) - displacement(bodies, i, soft) * back)
