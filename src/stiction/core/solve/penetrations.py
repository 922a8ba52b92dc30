"""Penetrations: overlapping bodies are moved apart before velocities are resolved, the deepest contact first."""

from __future__ import annotations

from stiction.core.contact_rows import arm, is_dynamic
from stiction.core.jit import jit
from stiction.core.ledger import note
from stiction.core.solve.micro import visit_limit
from stiction.core.state import (
    BODY_A,
    BODY_B,
    INVERSE_MASS,
    K_ROW,
    NORMAL,
    PENETRATION,
    PUSH,
    PUSH_TURN,
    SEPARATION,
    WORLD_INERTIA,
)
from stiction.core.vec import Vec3, cross, dot, mat33, put_vec3, vec3
from stiction.core.worst import build, leaves_for, update, worst

SLOP = 1e-6
"""m: penetration that is left alone. Resting contact makes none, so this only keeps rounding from being chased."""


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

    limit = visit_limit(iterations, m)
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
    note(report, PENETRATION, visits, tree[1], SLOP)
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
