"""Impacts: collisions that bounce, wave after wave, each with Coulomb friction and no more energy than before."""

from __future__ import annotations

import math

from stiction.core.contact_rows import is_dynamic, slip
from stiction.core.contact_space import contact_basis
from stiction.core.islands import find_group, join
from stiction.core.jit import jit
from stiction.core.ledger import dissipation, enter, note
from stiction.core.solve.micro import TOLERANCE, settle, share_load, visit_limit
from stiction.core.solve.penetrations import SLOP
from stiction.core.state import (
    ACTIVE,
    AIM,
    BODY_A,
    BODY_B,
    FORCE,
    IMPACT,
    IMPULSE,
    INVERSE_MASS,
    MU,
    NORMAL,
    RESTITUTION,
    SEPARATION,
    START,
    STATUS,
    TANGENTIAL,
    TWIST,
    V_START,
    W_START,
    V,
    W,
)
from stiction.core.vec import Vec3, dot, length, put_vec3, vec3

IMPACT_WAVES = 64
"""Most waves of impacts in one step (a Newton's cradle of k balls takes k)."""

RESTITUTION_CUT = 0.9
"""Factor by which restitution is lowered in a group of impacts that would create energy, until it does not."""

MOST_CUTS = 100
"""Times that may be done; after 66 of them no restitution is left."""


@jit
def resolve_impacts(
    bodies, n, contacts, tags, m, first, touching, tree, group, gain, settings, ledger, report, gravity
):
    """Collisions that bounce, in waves: all contacts that close fast enough now, then those that close because of it.

    Within a wave each contact aims at leaving with its restitution times its closing speed, friction acting all the
    while; where it sticks, tangential restitution reverses the slip (Garwin, "Kinematics of an Ultraelastic Rough
    Ball", Am. J. Phys. 37, 1969; Walton, "Numerical simulation of inelastic, frictional particle-particle
    interactions", 1993). Newton's restitution with friction can create energy (Kane and Levinson, 1985); a group of
    touching impacts that would do so gets less restitution until it does not. Contacts that close slower than the
    threshold, or do not bounce, are left to resting contact.
    """
    visits = 0
    left = 0.0
    for wave in range(0 if settings.literal else IMPACT_WAVES):
        if not _choose_bouncing(bodies, contacts, tags, m, settings, gravity):
            break
        if wave == IMPACT_WAVES - 1:
            left = settings.threshold
        _remember_start(bodies, n)
        _group_impacts(bodies, n, contacts, tags, m, group)
        limit = visit_limit(settings.iterations, m)
        share_load(bodies, contacts, tags, m)
        residue = 0.0
        for _ in range(MOST_CUTS):
            done, residue = settle(bodies, contacts, tags, m, first, touching, tree, limit)
            visits += done
            if not _lower_restitution(bodies, n, contacts, tags, m, group, gain):
                break
        left = max(left, residue)
        enter(bodies, contacts, tags, m, ledger)
    note(report, IMPACT, visits, left, TOLERANCE)


@jit
def _choose_bouncing(bodies, contacts, tags, m, settings, gravity):
    """Make those contacts active that close fast enough to bounce and meet within this step. Returns whether any do."""
    bouncing = False
    for c in range(m):
        tags[c, STATUS] = 0
        restitution = contacts[c, MU + RESTITUTION]
        if restitution <= 0.0:
            continue
        u = slip(bodies, V, W, contacts, tags, c, contact_basis(vec3(contacts, c, NORMAL)))
        pull = closing_acceleration(bodies, contacts, tags, c, gravity)
        gap = max(contacts[c, SEPARATION], 0.0)
        if u.x > settings.threshold and gap - SLOP <= settings.dt * (u.x + settings.dt * max(pull, 0.0)):
            tags[c, STATUS] = ACTIVE
            leaves = leaving_speed(u.x, restitution, 2.0 * pull * gap)
            rebound = contacts[c, MU + TANGENTIAL]
            put_vec3(contacts, c, AIM, Vec3(-leaves, -rebound * u.y, -rebound * u.z))
            put_vec3(contacts, c, START, u)
            put_vec3(contacts, c, IMPULSE, Vec3(0.0, 0.0, 0.0))
            put_vec3(contacts, c, TWIST, Vec3(0.0, 0.0, 0.0))
            bouncing = True
    return bouncing


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
            gain[g, 1] += length(vec3(contacts, c, IMPULSE)) * length(vec3(contacts, c, START))
    lowered = False
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            g = _group_of(bodies, tags, c, group)
            aim = vec3(contacts, c, AIM)
            if gain[g, 0] > 1e-12 * gain[g, 1] and (aim.x < 0.0 or aim.y != 0.0 or aim.z != 0.0):
                aim = aim * RESTITUTION_CUT
                if length(aim) < 1e-3 * contacts[c, START]:
                    aim = Vec3(0.0, 0.0, 0.0)
                put_vec3(contacts, c, AIM, aim)
                lowered = True
    return lowered
