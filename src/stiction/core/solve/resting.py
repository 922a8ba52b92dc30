"""Resting contact: the train of micro-collisions that takes away, step by step, the speed that forces have given."""

from __future__ import annotations

from stiction.core.contact_rows import slip
from stiction.core.contact_space import contact_basis
from stiction.core.jit import jit
from stiction.core.ledger import enter, note
from stiction.core.solve.literal import LITERAL_TOLERANCE, settle_literally
from stiction.core.solve.micro import TOLERANCE, settle, share_load, visit_limit
from stiction.core.solve.penetrations import SLOP
from stiction.core.state import (
    ACTIVE,
    AIM,
    IMPULSE,
    NORMAL,
    RESTING,
    SEPARATION,
    START,
    STATUS,
    TWIST,
    V_START,
    W_START,
)
from stiction.core.vec import Vec3, put_vec3, vec3


@jit
def resolve_resting(bodies, contacts, tags, m, first, touching, tree, settings, ledger, report, extras):
    """Resting contact: the speed that the forces of this step gave is taken away by micro-collisions.

    A contact that is still open may close by its gap within the step, and no further. Gaps of rounding size count as
    none: four corners of a face with four different gaps would ask of a rigid body what it cannot do.
    """
    for c in range(m):
        tags[c, STATUS] = ACTIVE
        put_vec3(contacts, c, AIM, Vec3(max(contacts[c, SEPARATION] - SLOP, 0.0) / settings.dt, 0.0, 0.0))
        B = contact_basis(vec3(contacts, c, NORMAL))
        put_vec3(contacts, c, START, slip(bodies, V_START, W_START, contacts, tags, c, B))
        put_vec3(contacts, c, IMPULSE, Vec3(0.0, 0.0, 0.0))
        put_vec3(contacts, c, TWIST, Vec3(0.0, 0.0, 0.0))
    limit = visit_limit(settings.iterations, m)
    if extras is not None and settings.literal:
        visits, left = settle_literally(bodies, contacts, tags, m, first, touching, tree, settings.threshold, limit)
        note(report, RESTING, visits, left, LITERAL_TOLERANCE)
    else:
        share_load(bodies, contacts, tags, m)
        visits, left = settle(bodies, contacts, tags, m, first, touching, tree, limit)
        note(report, RESTING, visits, left, TOLERANCE)
    enter(bodies, contacts, tags, m, ledger)
