"""``micro_literal``: the slides word for word, kept beside the right law so that the difference can be seen.

The contact that closes fastest first; the change of velocity v_mu by the slides' case distinction;
g_max = Delta g v_mu; apply it, and again, until nothing closes faster than the book's 1 cm/s. Impulses are never
taken back, friction acts only together with a normal impulse, and the sliding case is not normalised: it multiplies
the slip by (1 - mu_dynamic) at every micro-collision, whatever the load. So a sliding crate slows down by a rate that
depends on dt and on the number of micro-collisions: a viscous law, not a Coulomb deceleration.
"""

from __future__ import annotations

from stiction.core.contact_rows import apply, is_dynamic, matrix, slip
from stiction.core.contact_space import contact_basis, maximal_impulse
from stiction.core.friction.coulomb import literal_change
from stiction.core.jit import jit
from stiction.core.state import (
    ACTIVE,
    AIM,
    BODY_A,
    BODY_B,
    DYNAMIC_MU,
    IMPULSE,
    MU,
    NORMAL,
    RESTITUTION,
    SLIDING,
    STATIC_MU,
    STATUS,
    V,
    W,
)
from stiction.core.vec import Vec3, put_vec3, vec3
from stiction.core.worst import build, leaves_for, update, worst

LITERAL_TOLERANCE = 0.01
"""m/s, the book's velocityEpsilon."""


@jit
def settle_literally(bodies, contacts, tags, m, first, touching, tree, threshold, limit):
    """Resolve closing contacts one micro-collision after the other. Returns visits and the closing speed left, m/s."""
    leaves = leaves_for(m)
    for c in range(leaves):
        tree[leaves + c] = _closing(bodies, contacts, tags, c) if c < m else 0.0
    build(tree, leaves)
    visits = 0
    while tree[1] > LITERAL_TOLERANCE and visits < limit:
        c = worst(tree, leaves)
        B = contact_basis(vec3(contacts, c, NORMAL))
        v = slip(bodies, V, W, contacts, tags, c, B)
        restitution = contacts[c, MU + RESTITUTION] if v.x > threshold else 0.0
        v = v - Vec3(contacts[c, AIM], 0.0, 0.0)
        mu_static = contacts[c, MU + STATIC_MU]
        mu_dynamic = contacts[c, MU + DYNAMIC_MU]
        v_mu, sticks = literal_change(v, restitution, mu_static, mu_dynamic)
        g = maximal_impulse(matrix(contacts, c), v_mu)
        apply(bodies, contacts, tags, c, B @ g)
        put_vec3(contacts, c, IMPULSE, vec3(contacts, c, IMPULSE) + g)
        tags[c, STATUS] = ACTIVE if sticks else ACTIVE | SLIDING
        visits += 1
        for body in (tags[c, BODY_A], tags[c, BODY_B]):
            if is_dynamic(bodies, body):
                for k in range(first[body], first[body + 1]):
                    other = touching[k]
                    update(tree, leaves, other, _closing(bodies, contacts, tags, other))
    return visits, tree[1]


@jit
def _closing(bodies, contacts, tags, c):
    """Closing speed beyond what may remain, m/s."""
    u = slip(bodies, V, W, contacts, tags, c, contact_basis(vec3(contacts, c, NORMAL)))
    return u.x - contacts[c, AIM]
