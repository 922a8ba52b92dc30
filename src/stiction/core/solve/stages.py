"""The three stages of contact of one step: penetrations, impacts, resting contact.

Each sets up the contacts, lets ``micro`` (or its literal twin) resolve them, and enters what that took in the ledger.
"""

from __future__ import annotations

import math

from stiction.core.contact_rows import arm, is_dynamic, slip, work_of_drives
from stiction.core.contact_space import contact_basis
from stiction.core.islands import find_group, join
from stiction.core.jit import jit
from stiction.core.solve.literal import settle_literally
from stiction.core.solve.micro import TOLERANCE, dissipation, settle
from stiction.core.state import (
    ACTIVE,
    AIM,
    BODY_A,
    BODY_B,
    FORCE,
    FRICTION,
    FRICTION_WORK,
    IMPACT,
    IMPACTS,
    IMPULSE,
    INVERSE_MASS,
    K_ROW,
    LIMITS,
    MU,
    NORMAL,
    PENETRATION,
    PUSH,
    PUSH_TURN,
    RESTING,
    RESTITUTION,
    ROLLING_LOSS,
    SEPARATION,
    START,
    STATUS,
    TOTAL,
    TOTAL_FRICTION,
    TWIST,
    V_START,
    VISITS,
    W_START,
    WORK,
    WORLD_INERTIA,
    WORST,
    V,
    W,
)
from stiction.core.vec import Vec3, cross, dot, mat33, put_vec3, vec3
from stiction.core.worst import build, leaves_for, update, worst

SLOP = 1e-6
"""m: penetration that is left alone. Resting contact makes none, so this only keeps rounding from being chased."""

IMPACT_ROUNDS = 64
"""Most waves of impacts in one step (a Newton's cradle of k balls takes k)."""

RESTITUTION_CUT = 0.9
"""Factor by which restitution is lowered in a group of impacts that would create energy, until it does not."""


@jit
def resolve_penetrations(bodies, n, contacts, tags, m, first, touching, tree, report, iterations):
    """Move overlapping bodies apart along the normals, worst first, each body by its share of the inverse mass matrix.

    Positions are resolved before velocities, as in the book. Points and normals stay as they are while that is done.
    """
    leaves = leaves_for(m)
    deepest = 0.0
    for c in range(m):
        deepest = min(deepest, contacts[c, SEPARATION])
    if deepest >= -SLOP:
        return False

    for c in range(leaves):
        tree[leaves + c] = -contacts[c, SEPARATION] if c < m else 0.0
    build(tree, leaves)
    for i in range(n):
        put_vec3(bodies, i, PUSH, Vec3(0.0, 0.0, 0.0))
        put_vec3(bodies, i, PUSH_TURN, Vec3(0.0, 0.0, 0.0))

    limit = iterations * m
    visits = 0
    while tree[1] > SLOP and visits < limit:
        c = worst(tree, leaves)
        push = vec3(contacts, c, NORMAL) * ((tree[1] - 0.5 * SLOP) / contacts[c, K_ROW])
        for body, sign in ((tags[c, BODY_A], -1.0), (tags[c, BODY_B], 1.0)):
            if is_dynamic(bodies, body):
                put_vec3(bodies, body, PUSH, vec3(bodies, body, PUSH) + push * (sign * bodies[body, INVERSE_MASS]))
                turn = mat33(bodies, body, WORLD_INERTIA) @ cross(arm(bodies, contacts, c, body), push)
                put_vec3(bodies, body, PUSH_TURN, vec3(bodies, body, PUSH_TURN) + turn * sign)
        visits += 1
        for body in (tags[c, BODY_A], tags[c, BODY_B]):
            if is_dynamic(bodies, body):
                for k in range(first[body], first[body + 1]):
                    other = touching[k]
                    update(tree, leaves, other, -contacts[other, SEPARATION] - _opened(bodies, contacts, tags, other))
    for c in range(m):
        contacts[c, SEPARATION] += _opened(bodies, contacts, tags, c)
    _note(report, PENETRATION, visits, tree[1], SLOP)
    return True


@jit
def _opened(bodies, contacts, tags, c):
    """How far the push so far has opened a contact, m."""
    a, b = tags[c, BODY_A], tags[c, BODY_B]
    da = vec3(bodies, a, PUSH) + cross(vec3(bodies, a, PUSH_TURN), arm(bodies, contacts, c, a))
    db = vec3(bodies, b, PUSH) + cross(vec3(bodies, b, PUSH_TURN), arm(bodies, contacts, c, b))
    moved_a = dot(vec3(contacts, c, NORMAL), da) if is_dynamic(bodies, a) else 0.0
    moved_b = dot(vec3(contacts, c, NORMAL), db) if is_dynamic(bodies, b) else 0.0
    return moved_b - moved_a


@jit
def resolve_impacts(
    bodies, n, contacts, tags, m, first, touching, tree, group, gain, settings, ledger, report, gravity
):
    """Collisions that bounce, in waves: all contacts that close fast enough now, then those that close because of it.

    Within a wave each contact aims at leaving with its restitution times its closing speed, friction acting all the
    while. Newton's restitution with friction can create energy (Kane and Levinson, 1985); a group of touching impacts
    that would do so gets less restitution until it does not. Contacts that close slower than the threshold, or do not
    bounce, are left to resting contact.
    """
    visits = 0
    left = 0.0
    for wave in range(IMPACT_ROUNDS):
        bouncing = 0
        for c in range(m):
            tags[c, STATUS] = 0
            restitution = contacts[c, MU + RESTITUTION]
            if restitution <= 0.0:
                continue
            u = slip(bodies, V, W, contacts, tags, c, contact_basis(vec3(contacts, c, NORMAL)))
            pull = closing_acceleration(bodies, contacts, tags, c, gravity)
            gap = max(contacts[c, SEPARATION], 0.0)
            if u.x > settings.threshold and gap <= settings.dt * (u.x + settings.dt * max(pull, 0.0)):
                tags[c, STATUS] = ACTIVE
                contacts[c, AIM] = -leaving_speed(u.x, restitution, 2.0 * pull * gap)
                put_vec3(contacts, c, START, u)
                put_vec3(contacts, c, IMPULSE, Vec3(0.0, 0.0, 0.0))
                put_vec3(contacts, c, TWIST, Vec3(0.0, 0.0, 0.0))
                bouncing += 1
        if bouncing == 0:
            break
        if wave == IMPACT_ROUNDS - 1:
            left = settings.threshold
        _remember_start(bodies, n)
        _group_impacts(bodies, n, contacts, tags, m, group)
        limit = settings.iterations * m
        done, residue = settle(bodies, contacts, tags, m, first, touching, tree, limit)
        visits += done
        for _ in range(100):
            if not _lower_restitution(bodies, n, contacts, tags, m, group, gain):
                break
            done, residue = settle(bodies, contacts, tags, m, first, touching, tree, limit)
            visits += done
        left = max(left, residue)
        _enter(bodies, contacts, tags, m, ledger)
    _note(report, IMPACT, visits, left, TOLERANCE)


@jit
def leaving_speed(closing, restitution, fall):
    """Speed after an impact that is resolved now, though the surfaces meet only after the gap between them is crossed.

    On the way down the square of the speed grows by ``fall`` = 2 a gap, is multiplied by e^2, and loses ``fall`` on the
    way up: so a ball bounces to e^2 of its height whatever the time step.
    """
    return math.sqrt(max(restitution * restitution * max(closing * closing + fall, 0.0) - fall, 0.0))


@jit
def closing_acceleration(bodies, contacts, tags, c, gravity):
    """How much gravity and applied forces speed up the closing of a contact, m/s^2."""
    pull = 0.0
    for body, sign in ((tags[c, BODY_A], 1.0), (tags[c, BODY_B], -1.0)):
        if is_dynamic(bodies, body):
            acceleration = gravity + vec3(bodies, body, FORCE) * bodies[body, INVERSE_MASS]
            pull += sign * dot(vec3(contacts, c, NORMAL), acceleration)
    return pull


@jit
def _remember_start(bodies, n):
    for i in range(n):
        put_vec3(bodies, i, V_START, vec3(bodies, i, V))
        put_vec3(bodies, i, W_START, vec3(bodies, i, W))


@jit
def _group_impacts(bodies, n, contacts, tags, m, group):
    """Union-find over the dynamic bodies that bounce off each other."""
    for i in range(n):
        group[i] = i
    for c in range(m):
        a, b = tags[c, BODY_A], tags[c, BODY_B]
        if tags[c, STATUS] & ACTIVE and is_dynamic(bodies, a) and is_dynamic(bodies, b):
            join(group, a, b)


@jit
def _group_of(bodies, tags, c, group):
    a, b = tags[c, BODY_A], tags[c, BODY_B]
    return find_group(group, a if is_dynamic(bodies, a) else b)


@jit
def _lower_restitution(bodies, n, contacts, tags, m, group, gain):
    """Lower the aim of every group whose impacts would create energy. Returns whether there was one."""
    for i in range(n):
        gain[i, 0] = 0.0
        gain[i, 1] = 0.0
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            normal, friction, rolling = dissipation(bodies, contacts, tags, c)
            g = _group_of(bodies, tags, c, group)
            gain[g, 0] -= normal + friction + rolling
            gain[g, 1] += contacts[c, IMPULSE] * abs(contacts[c, START])
    lowered = False
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            g = _group_of(bodies, tags, c, group)
            if gain[g, 0] > 1e-12 * gain[g, 1] and contacts[c, AIM] < 0.0:
                contacts[c, AIM] *= RESTITUTION_CUT
                if contacts[c, AIM] > -1e-3 * contacts[c, START]:
                    contacts[c, AIM] = 0.0
                lowered = True
    return lowered


@jit
def resolve_resting(bodies, contacts, tags, m, first, touching, tree, settings, ledger, report):
    """Resting contact: the speed that the forces of this step gave is taken away by micro-collisions.

    A contact that is still open may close by its gap within the step, and no further.
    """
    for c in range(m):
        tags[c, STATUS] = ACTIVE
        contacts[c, AIM] = max(contacts[c, SEPARATION], 0.0) / settings.dt
        B = contact_basis(vec3(contacts, c, NORMAL))
        put_vec3(contacts, c, START, slip(bodies, V_START, W_START, contacts, tags, c, B))
        put_vec3(contacts, c, IMPULSE, Vec3(0.0, 0.0, 0.0))
        put_vec3(contacts, c, TWIST, Vec3(0.0, 0.0, 0.0))
    limit = settings.iterations * m
    if settings.literal:
        visits, left = settle_literally(bodies, contacts, tags, m, first, touching, tree, settings.threshold, limit)
    else:
        visits, left = settle(bodies, contacts, tags, m, first, touching, tree, limit)
        _note(report, RESTING, visits, left, TOLERANCE)
    if settings.literal:
        _note(report, RESTING, visits, 0.0 if visits < limit else left, 0.0)
    _enter(bodies, contacts, tags, m, ledger)


@jit
def _note(report, stage, visits, left, tolerance):
    """A limit that was hit is reported, with the error it left."""
    report[stage, VISITS] += visits
    if left > tolerance:
        report[stage, LIMITS] += 1
        report[stage, WORST] = max(report[stage, WORST], left)


@jit
def _enter(bodies, contacts, tags, m, ledger):
    """Enter what the active contacts took, and what drives and belts gave; add the impulses to the step's total."""
    for c in range(m):
        if not tags[c, STATUS] & ACTIVE or contacts[c, IMPULSE] == 0.0:
            continue
        normal, friction, rolling = dissipation(bodies, contacts, tags, c)
        ledger[IMPACTS] += normal
        ledger[FRICTION] += friction
        ledger[ROLLING_LOSS] += rolling
        B = contact_basis(vec3(contacts, c, NORMAL))
        world = B @ vec3(contacts, c, IMPULSE)
        ledger[WORK] += work_of_drives(bodies, contacts, tags, c, world, B @ vec3(contacts, c, TWIST))
        contacts[c, TOTAL] += contacts[c, IMPULSE]
        friction_impulse = world - vec3(contacts, c, NORMAL) * contacts[c, IMPULSE]
        put_vec3(contacts, c, TOTAL_FRICTION, vec3(contacts, c, TOTAL_FRICTION) + friction_impulse)

        a, b = tags[c, BODY_A], tags[c, BODY_B]
        both = is_dynamic(bodies, a) and is_dynamic(bodies, b)
        for body in (a, b):
            if is_dynamic(bodies, body):
                bodies[body, FRICTION_WORK] += (friction + rolling) * (0.5 if both else 1.0)
