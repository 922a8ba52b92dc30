"""Which bodies take part in a step of the soft solver, how they move in it, and where they are at its end."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import MANY, SINGLE, SOON, ask_for, ask_for_row
from stiction.core.gains import is_still
from stiction.core.integrate import keep_body
from stiction.core.jit import jit
from stiction.core.soft_bodies import (
    FALLS,
    GLIDES,
    NO_GLIDE,
    ROLLS,
    begin_body,
    finish_contact,
    finish_free,
    free_is_finite,
    row_is_finite,
)
from stiction.core.soft_scratch import AWAKE, N_AWAKE, STALE
from stiction.core.solve.soft import NEAR, NOTHING_NEW, QUIET_NEW, SOME_NEW, UNEVEN
from stiction.core.state import ASLEEP, DYNAMIC, FORCE, INVERSE_MASS, MOBILITY, STATIC, TORQUE
from stiction.core.vec import Vec3, cross, dot, mat33, put_vec3, vec3

UNDECIDED = -1


@jit
def list_awake(kinds, n, lists, counts):
    """List the bodies that take part: dynamic ones that do not sleep, and kinematic ones; returns their number."""
    if counts[STALE]:
        count = 0
        for i in range(n):
            if kinds[i, MOBILITY] != STATIC and not kinds[i, ASLEEP]:
                lists[AWAKE, count] = i
                count += 1
        counts[N_AWAKE] = count
        counts[STALE] = 0
    return counts[N_AWAKE]


@jit
def begin_bodies(bodies, kinds, awake, count, pose, rows, aux, gravity, g, dt, h):
    """Poses, bounds and solver rows of the bodies that are awake."""
    for k in range(count):
        begin_body(bodies, kinds, awake[k], pose, rows, aux, gravity, g, dt, h)


@jit
def begin_others(bodies, kinds, n, pose, rows, aux, gravity, g, dt, h):
    """The same of the bodies that are not awake."""
    for i in range(n):
        if kinds[i, MOBILITY] == STATIC or kinds[i, ASLEEP]:
            begin_body(bodies, kinds, i, pose, rows, aux, gravity, g, dt, h)


@jit
def list_touching(kinds, manifolds, meta, pose, active, count, touched, mark, glide, normals):
    """List the bodies in contact, and decide which of them glide; returns their number."""
    touching = 0
    for k in range(count):
        if count > MANY:
            ahead = active[min(k + SOON, count - 1), 2] + 1
            ask_for_row(manifolds, ahead, s.MANIFOLD_WIDTH, SINGLE)
            ask_for(meta, ahead, s.POINTS)
        row = active[k, 2] + 1
        load = manifolds[row, s.LOAD] + manifolds[row, s.LOAD + 1] + manifolds[row, s.LOAD + 2]
        counts = load + manifolds[row, s.LOAD + 3] > 0.0
        if manifolds[row, s.FRESH] > s.OLD:
            nearest = manifolds[row, s.GAP]
            for j in range(1, 4):
                nearest = min(nearest, manifolds[row, s.GAP + j])
            counts |= nearest < NEAR
        kind = NO_GLIDE
        n = Vec3(0.0, 0.0, 0.0)
        if meta[row, s.POINTS] == 1.0 or manifolds[row, s.STATE] == s.SLIDING:
            kind = ROLLS if meta[row, s.POINTS] == 1.0 else GLIDES
            n = mat33(pose, active[k, 0] + 1, s.POSE_ROTATION) @ vec3(manifolds, row, s.NORMAL_A)
        for side in range(2):
            i = active[k, side]
            if mark[i] == 0:
                mark[i] = 1
                touched[touching] = i
                glide[i] = UNDECIDED
                touching += 1
            if not counts or kinds[i, MOBILITY] != DYNAMIC or glide[i] == NO_GLIDE:
                continue
            if glide[i] == UNDECIDED:
                put_vec3(normals, i, 0, n)
                put_vec3(normals, i, 3, cross(vec3(manifolds, row, s.ARM_A if side == 0 else s.ARM_B), n))
                glide[i] = kind
            elif glide[i] != kind or abs(dot(n, vec3(normals, i, 0))) < 0.999:
                glide[i] = NO_GLIDE
    return touching


@jit
def list_moving(bodies, kinds, touched, touching, glide, normals, gravity, movers, base):
    """List the rows of those bodies in contact that move; returns their number. One that nothing holds yet falls."""
    moving = 0
    for k in range(touching):
        i = touched[k]
        if glide[i] == UNDECIDED:
            glide[i] = NO_GLIDE
            if kinds[i, MOBILITY] == DYNAMIC:
                a = gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS]
                put_vec3(normals, i, 0, a)
                glide[i] = FALLS
        if kinds[i, MOBILITY] != STATIC:
            movers[moving] = base + i + 1
            moving += 1
    return moving


@jit
def is_uneven(kinds, aux, meta, active, count):
    """1 if two movable bodies of very different mass lie on each other with a face, else 0."""
    for k in range(count):
        ma, mb = aux[active[k, 0] + 1, s.AUX_MASS], aux[active[k, 1] + 1, s.AUX_MASS]
        if ma > 0.0 and mb > 0.0 and (ma > UNEVEN * mb or mb > UNEVEN * ma):
            if meta[active[k, 2] + 1, s.POINTS] >= 3.0:
                return 1
    return 0


@jit
def new_ones(manifolds, active, count):
    """Which of the active manifolds are new in this step: none, some that move, or only quiet ones."""
    new = NOTHING_NEW
    for k in range(count):
        if count > MANY:
            ask_for(manifolds, active[min(k + SOON, count - 1), 2] + 1, s.FRESH)
        fresh = manifolds[active[k, 2] + 1, s.FRESH]
        if fresh == s.QUIET:
            new = QUIET_NEW
        elif fresh > s.OLD:
            return SOME_NEW
    return new


@jit
def first_bad_row(bodies, kinds, awake, count, mark, rows, gravity, dt):
    """A body whose new state would not be finite, or so large that its energy is not, or -1: nothing has been moved
    yet."""
    for k in range(count):
        i = awake[k]
        if mark[i]:
            if not row_is_finite(rows, i + 1):
                return i
        elif not free_is_finite(bodies, kinds, i, gravity, dt):
            return i
    return -1


@jit
def drop_forces(bodies, awake, count):
    """What was applied for the step that failed is gone with it."""
    for k in range(count):
        for c in range(3):
            bodies[awake[k], FORCE + c] = 0.0
            bodies[awake[k], TORQUE + c] = 0.0


@jit
def keep_states(bodies, awake, count):
    """Remember the state of the bodies that are awake, to which a body goes back that is broken from outside."""
    for k in range(count):
        keep_body(bodies, awake[k])


@jit
def finish_bodies(bodies, kinds, awake, count, mark, pose, rows, aux, gravity, dt, ledger):
    """Move all bodies, those in contact as the solver says; returns how many of these tumble, and whether one has not
    been still."""
    tumbling, lively = 0, False
    for k in range(count):
        i = awake[k]
        if mark[i] and kinds[i, MOBILITY] == DYNAMIC:
            tumbling += finish_contact(bodies, i, pose, rows, aux, dt, ledger)
            lively = lively or not is_still(bodies, i, rows, aux, gravity, dt)
        else:
            finish_free(bodies, kinds, i, pose, gravity, dt, ledger)
    return tumbling, lively


@jit
def unmark(mark, touched, touching):
    """Leave no mark on the desk."""
    for k in range(touching):
        mark[touched[k]] = 0
