"""Motion between contacts: forces, the gyroscopic term, and moving the bodies.

Velocities go from v_start to v in a step. A body that rests, slides, rolls or flies moves with their mean, which is
exact for constant forces: semi-implicit Euler would make every stopping distance v dt / 2 too short. Only where the
mean would carry a contact into the other body (it has just landed), the new velocity is used alone.
"""

from __future__ import annotations

import math

from stiction.core.contact_rows import arm, is_dynamic
from stiction.core.contact_space import skew, world_inverse_inertia
from stiction.core.jit import jit
from stiction.core.ledger import spin_energy
from stiction.core.state import (
    BODY_A,
    BODY_B,
    CENTER,
    FORCE,
    FRICTION_WORK,
    INERTIA,
    INVERSE_MASS,
    KINEMATIC,
    LAST,
    LEDGER_WIDTH,
    MASS,
    MEAN,
    MOBILITY,
    NORMAL,
    NUMERICAL,
    ORIENTATION,
    POSITION,
    PUSH,
    PUSH_TURN,
    SEPARATION,
    TORQUE,
    TOTAL,
    V_START,
    W_START,
    WORK,
    WORLD_INERTIA,
    V,
    W,
    X,
)
from stiction.core.vec import (
    Quat,
    Vec3,
    cross,
    dot,
    inverse,
    length,
    mat33,
    put_quat,
    put_vec3,
    quat,
    rotation,
    transpose,
    turn,
    unit,
    vec3,
)

FAST = 1.2
"""rad: a body that turns by less than twice that in a step turns by the right angle about a changing axis."""
NO_TURN = 1e-6
"""rad, turning by less in a step changes nothing that matters."""
SMALL_TURN, FAR_TURN = 0.02, 0.2
"""A quarter of the turn of a step, rad, that no inertia minds; and how much of the trace of its inverse an entry may
have changed by in the middle of a step. That of a needle changes by the sine of the angle by which it tumbles."""
ROOT = 1e-8
"""A step of Newton's method, of what it improves, after which the next one would change nothing: it goes with the
square."""
BY_END, BY_MEAN, NO_LONGER = 0, 1, 2
"""Whether a body moves with its velocity at the end of the step or with the mean one, or with that in this round only.
"""
MEAN_TOLERANCE = 1e-7
"""m: a contact may be carried that far into the other body by moving with the mean velocity."""


@jit
def apply_forces(bodies, n, gravity, dt):
    """v_start, w_start <- velocities after impacts; v, w <- what gravity, forces and torques make of them."""
    for i in range(n):
        if is_dynamic(bodies, i):
            R = rotation(quat(bodies, i, ORIENTATION))
            w = gyroscopic(R, mat33(bodies, i, INERTIA), vec3(bodies, i, W), dt)
            v = vec3(bodies, i, V)
            put_vec3(bodies, i, V_START, v)
            put_vec3(bodies, i, W_START, w)
            put_vec3(bodies, i, V, v + (gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS]) * dt)
            put_vec3(bodies, i, W, w + (mat33(bodies, i, WORLD_INERTIA) @ vec3(bodies, i, TORQUE)) * dt)
        else:
            put_vec3(bodies, i, V_START, vec3(bodies, i, V))
            put_vec3(bodies, i, W_START, vec3(bodies, i, W))


@jit
def gyroscopic(R, inertia, w, dt):
    """Angular velocity after dt of Euler's equation, of a body that has not turned yet; all in world axes."""
    w0 = transpose(R) @ w
    w1, changes = euler(inertia, w0, dt)
    return R @ w1 if changes else w


@jit
def spin_freely(R, inertia, w, dt):
    """How a body turns in dt that nothing touches, as a rotation vector, and its angular velocity then, seen from the
    turned body; with it, whether the latter has changed.

    If a body turns about the mean angular velocity m of the mid-point rule by 2 atan(|m| dt / 2), angular momentum
    keeps its direction to rounding as well (Cayley's map; Hairer, Lubich, Wanner, "Geometric Numerical Integration",
    IV.8.3). The rule is told a time that makes this |m| dt, but for how much |w| changes in a step.
    """
    w0 = transpose(R) @ w
    speed = length(w0)
    time, close = dt, 0.5 * speed * dt < FAST
    if speed > 0.0 and close:
        time = 2.0 * math.tan(0.5 * speed * dt) / speed
    w1, changes = euler(inertia, w0, time)
    if not changes:
        return w * dt, w0, False
    middle = (w0 + w1) * 0.5
    m = length(middle)
    angle = dt
    if m > 0.0 and close:
        angle = 2.0 * math.atan(0.5 * m * time) / m
    return R @ (middle * angle), w1, True


@jit
def spin_in_contact(q, R, inertia, inverse_inertia, w, dt):
    """What contact finds of how a body turns: by how much its spin would change in dt if nothing touched it, world;
    its axes in the middle of that time, whose inertia impulses act on; and whether it tumbles too far for that.

    With the inertia of the start, and a spin that changes as it looks from the axes of the start, a body that rattles
    would lose or gain energy and angular momentum of the first order in dt. The mid-point rule and a turn by Cayley's
    map (:func:`spin_freely`) keep both; the turn is x + 2 (g x x + g x (g x x)) / (1 + g^2), g = m dt / 2. But a needle
    that tumbles far in a step has contacts that know nothing of that: for them it is as it was.
    """
    free = Vec3(0.0, 0.0, 0.0)
    if dot(w, w) * dt * dt <= NO_TURN * NO_TURN:
        return free, R, False
    w0 = transpose(R) @ w
    w1, changes = euler(inertia, w0, dt)
    middle, far = half_way(q, R, inverse_inertia, w, dt)
    if changes and far:
        free = R @ w1 - w
    elif changes:
        g, x = (R @ (w0 + w1)) * (0.25 * dt), R @ w1
        across = cross(g, x)
        free = x + (across + cross(g, across)) * (2.0 / (1.0 + dot(g, g))) - w
    return free, middle, far


@jit
def half_way(q, R, inverse_inertia, w, dt):
    """The axes of a body in the middle of the time dt in which it turns with spin w, by Cayley's map; or those of the
    start, and True, if its inertia would be too different by then."""
    half = w * (0.25 * dt)
    middle = rotation(unit(Quat(1.0, half.x, half.y, half.z) * q))
    if dot(half, half) > SMALL_TURN * SMALL_TURN:
        D = world_inverse_inertia(middle, inverse_inertia) + -world_inverse_inertia(R, inverse_inertia)
        far = FAR_TURN * (inverse_inertia.xx + inverse_inertia.yy + inverse_inertia.zz)
        if max(max(abs(D.xx), max(abs(D.yy), abs(D.zz))), max(abs(D.xy), max(abs(D.xz), abs(D.yz)))) > far:
            return R, True
    return middle, False


@jit
def euler(inertia, w0, dt):
    """Angular velocity after dt of Euler's equation I w' = -w x I w, by the implicit mid-point rule in body axes, and
    whether it is another one.

    The rule keeps the quadratic invariants w . I w and |I w|^2 exactly (Hairer, Lubich, Wanner, "Geometric Numerical
    Integration", IV.2.1), so a free top neither loses nor gains energy. Newton's method, usually two or three steps.
    """
    momentum = inertia @ w0
    torque = cross(w0, momentum)
    if dot(torque, torque) <= 1e-28 * dot(w0, w0) * dot(momentum, momentum):
        return w0, False
    w1 = w0
    for _ in range(10):
        middle = (w0 + w1) * 0.5
        spin = inertia @ middle
        f = inertia @ (w1 - w0) + cross(middle, spin) * dt
        # derivative of the torque term, dt/2 (S_middle I - S_spin); scaling its vectors scales the matrices
        half = 0.5 * dt
        J = inertia + skew(middle * half) @ inertia + -skew(spin * half)
        step = inverse(J) @ f
        w1 = w1 - step
        if dot(step, step) <= ROOT * ROOT * dot(w1, w1):
            return w1, True
    # of many turns a step Newton may not find the root; to turn on about the same axis keeps both invariants as well
    return w0, False


@jit
def choose_mean(bodies, n, contacts, tags, m, dt):
    """Which bodies move with the mean velocity: all, but those whose contacts that would close too far.

    A body that does not passes that on to those it touches, so that both sides of a contact move alike. All contacts
    are asked before any body changes, so it does not matter in which order they come.
    """
    for i in range(n):
        bodies[i, MEAN] = BY_MEAN
    changed = True
    while changed:
        changed = False
        for c in range(m):
            a, b = tags[c, BODY_A], tags[c, BODY_B]
            if contacts[c, TOTAL] <= 0.0 or not (_moves_by_mean(bodies, a) or _moves_by_mean(bodies, b)):
                continue
            normal = vec3(contacts, c, NORMAL)
            ua = _moving_velocity(bodies, a, arm(bodies, contacts, c, a))
            ub = _moving_velocity(bodies, b, arm(bodies, contacts, c, b))
            if dot(normal, ua - ub) * dt - max(contacts[c, SEPARATION], 0.0) > MEAN_TOLERANCE:
                bodies[a, MEAN] = bodies[b, MEAN] = NO_LONGER
                changed = True
        for i in range(n):
            if bodies[i, MEAN] == NO_LONGER:
                bodies[i, MEAN] = BY_END


@jit
def _moves_by_mean(bodies, i):
    return is_dynamic(bodies, i) and bodies[i, MEAN] != BY_END


@jit
def _moving_velocity(bodies, i, r):
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    if _moves_by_mean(bodies, i):
        v = (v + vec3(bodies, i, V_START)) * 0.5
        w = (w + vec3(bodies, i, W_START)) * 0.5
    return v + cross(w, r)


@jit
def move(bodies, kinds, n, gravity, dt, ledger):
    """Positions and orientations at the end of the step; the work of applied forces; forces are used up."""
    for i in range(n):
        if is_dynamic(bodies, i):
            v0, w0 = vec3(bodies, i, V_START), vec3(bodies, i, W_START)
            v1, w1 = vec3(bodies, i, V), vec3(bodies, i, W)
            dx, angle = v1 * dt, w1 * dt
            if bodies[i, MEAN] == BY_MEAN:
                dx, angle = (v0 + v1) * (0.5 * dt), (w0 + w1) * (0.5 * dt)
            spin_before = spin_energy(bodies, i)
            place(bodies, i, dx, angle)
            # what gravity gave in kinetic energy and took in potential energy need not be equal, nor need the
            # rotation have kept the spin energy: the ledger says by how much
            gained = bodies[i, MASS] * dot(gravity, (v0 + v1) * (0.5 * dt) - dx)
            ledger[NUMERICAL] += gained + spin_energy(bodies, i) - spin_before
            ledger[WORK] += 0.5 * dt * dot(vec3(bodies, i, FORCE), v0 + v1)
            ledger[WORK] += 0.5 * dt * dot(vec3(bodies, i, TORQUE), w0 + w1)
        elif kinds[i, MOBILITY] == KINEMATIC:
            place(bodies, i, vec3(bodies, i, V) * dt, vec3(bodies, i, W) * dt)
        put_vec3(bodies, i, FORCE, Vec3(0.0, 0.0, 0.0))
        put_vec3(bodies, i, TORQUE, Vec3(0.0, 0.0, 0.0))


@jit
def push_out(bodies, n, gravity, ledger):
    """Carry out the push that resolve_penetrations has found, and enter the energy it made."""
    for i in range(n):
        if is_dynamic(bodies, i):
            dx = vec3(bodies, i, PUSH)
            spin_before = spin_energy(bodies, i)
            place(bodies, i, dx, vec3(bodies, i, PUSH_TURN))
            ledger[NUMERICAL] += spin_energy(bodies, i) - spin_before - bodies[i, MASS] * dot(gravity, dx)


@jit
def place(bodies, i, dx, angle):
    """Shift the centre of mass by dx and turn about it by the rotation vector ``angle``."""
    q = turn(quat(bodies, i, ORIENTATION), angle)
    x = vec3(bodies, i, X) + dx
    put_vec3(bodies, i, X, x)
    put_quat(bodies, i, ORIENTATION, q)
    put_vec3(bodies, i, POSITION, x - rotation(q) @ vec3(bodies, i, CENTER))


@jit
def first_not_finite(bodies, n):
    """Index of the first body whose state is not finite, or so large that its energy is not, or -1."""
    for i in range(n):
        if not math.isfinite(size_of_state(bodies, i)):
            return i
    return -1


@jit
def size_of_state(bodies, i):
    """Sum of the squares of position, orientation and velocities of a body."""
    total = 0.0
    for start, width in ((POSITION, 7), (V, 6)):
        for k in range(start, start + width):
            total += bodies[i, k] * bodies[i, k]
    return total


@jit
def is_number(bodies, i):
    """Whether nothing in the state of a body is nan or infinite."""
    for start, width in ((POSITION, 7), (V, 6)):
        for k in range(start, start + width):
            if not math.isfinite(bodies[i, k]):
                return False
    return True


@jit
def copy_rows(source, target):
    """Entry by entry: an assignment of whole arrays takes Numba four seconds more to compile."""
    for i in range(source.shape[0]):
        for k in range(source.shape[1]):
            target[i, k] = source[i, k]


@jit
def keep_state(bodies, n, ledger, last_ledger, report, last_report):
    """Remember position, orientation, velocities and friction work of every body, the ledger and the report."""
    copy_rows(report, last_report)
    for k in range(LEDGER_WIDTH):
        last_ledger[k] = ledger[k]
    for i in range(n):
        keep_body(bodies, i)
        bodies[i, LAST + 13] = bodies[i, FRICTION_WORK]


@jit
def keep_body(bodies, i):
    """Remember position, orientation and velocities of one body."""
    for k in range(7):
        bodies[i, LAST + k] = bodies[i, POSITION + k]
    for k in range(6):
        bodies[i, LAST + 7 + k] = bodies[i, V + k]


@jit
def restore_body(bodies, i):
    """Put back position, orientation and velocities of one body."""
    for k in range(7):
        bodies[i, POSITION + k] = bodies[i, LAST + k]
    for k in range(6):
        bodies[i, V + k] = bodies[i, LAST + 7 + k]


@jit
def restore_state(bodies, n, ledger, last_ledger, report, last_report):
    """Put back what keep_state remembered."""
    copy_rows(last_report, report)
    for k in range(LEDGER_WIDTH):
        ledger[k] = last_ledger[k]
    for i in range(n):
        restore_body(bodies, i)
        bodies[i, FRICTION_WORK] = bodies[i, LAST + 13]
