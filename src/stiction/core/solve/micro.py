"""``micro``: the lecture's solver. Resting contact is a train of micro-collisions, the worst one resolved first.

Slide "How to implement friction?" and the book behind it (Millington, "Game Physics Engine Development", chapters
14 and 15): pick the contact with the largest error, give it the impulse that its law demands, see what that did to the
contacts that share a body with it, repeat until no error is left or the limit is reached. Nothing is remembered from
step to step.

Two things are done better than there. The impulses of one contact *add up*, and it is their sum that obeys the law, so
an impulse that was too large is taken back (a Gauss-Southwell sweep over a nonsmooth problem; the book's never takes
one back). And static or dynamic is decided when all have come to rest: first every contact may hold with mu_s; those
that then still slip let go, and all is resolved again with mu_d for them. Deciding earlier lets one corner that happens
to be lightly loaded break loose, and the whole crate after it.

Cost: about 0.4 us a visit in a crate, 2 us in a pile; a crate at rest takes 10 to 60 visits, a pile thousands.
Error left: at most ``TOLERANCE``, unless the limit is hit, which is reported.
"""

from __future__ import annotations

import math

from stiction.core.contact_rows import apply, arm, is_dynamic, matrix, relative_spin, slip, twist
from stiction.core.contact_space import contact_basis
from stiction.core.friction.coulomb import coulomb_impulse
from stiction.core.friction.rolling import resisting_torque
from stiction.core.jit import jit
from stiction.core.state import (
    ACTIVE,
    AIM,
    BODY_A,
    BODY_B,
    DYNAMIC_MU,
    IMPULSE,
    K_ROW,
    KINETIC,
    MU,
    NORMAL,
    ROLLING,
    SATURATED,
    STATIC_MU,
    STATUS,
    TORSIONAL,
    TWIST,
    WORLD_INERTIA,
    V,
    W,
)
from stiction.core.vec import length, mat33, put_vec3, vec3
from stiction.core.worst import build, leaves_for, update, worst

TOLERANCE = 1e-6
"""m/s: a contact whose velocity is that close to what its law demands is resolved."""
SLIP_SPEED = 1e-4
"""m/s: a contact that slips faster than this with mu_s lets go."""
BEYOND_DOUBT = 4.0
"""Slip in units of the largest error from which on a contact lets go although not all has settled."""


FEW_CONTACTS = 32
"""Worlds with fewer contacts than this may take as many visits as if they had so many: a single crate just below the
threshold needs some thousand, and they cost it no more than a millisecond."""


@jit
def visit_limit(iterations, m):
    """How many contacts may be resolved in one stage of a step of a world of m contacts."""
    return iterations * max(m, FEW_CONTACTS)


@jit
def share_load(bodies, contacts, tags, m):
    """Before the worst contact comes first, all active ones get at once the normal impulse that each needs alone.

    For a face that lies flat this is already the answer, the same load on every corner; starting with the worst one
    would leave the load on two corners, which is an answer too, but not a pretty one. Elsewhere it is a first guess,
    and what is too much of it is taken back.
    """
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            u = slip(bodies, V, W, contacts, tags, c, contact_basis(vec3(contacts, c, NORMAL)))
            contacts[c, IMPULSE] = max(u.x - contacts[c, AIM], 0.0) / contacts[c, K_ROW]
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            apply(bodies, contacts, tags, c, vec3(contacts, c, NORMAL) * contacts[c, IMPULSE])


@jit
def settle(bodies, contacts, tags, m, first, touching, tree, limit):
    """Resolve the active contacts, worst first. Returns the number of visits and the error that is left, m/s."""
    leaves = leaves_for(m)
    for c in range(leaves):
        tree[leaves + c] = 0.0
    for c in range(m):
        if tags[c, STATUS] & ACTIVE:
            tree[leaves + c] = error(bodies, contacts, tags, c)
    build(tree, leaves)

    visits = 0
    while visits < limit:
        # half way to the limit something will not settle: what slides beyond doubt must not be held by mu_s for that
        settled = tree[1] <= TOLERANCE
        if settled or visits == limit // 2:
            speed = SLIP_SPEED if settled else max(SLIP_SPEED, BEYOND_DOUBT * tree[1])
            more = let_go(bodies, contacts, tags, m, tree, leaves, speed)
            if settled and not more:
                break
        c = worst(tree, leaves)
        resolve(bodies, contacts, tags, c)
        visits += 1
        for body in (tags[c, BODY_A], tags[c, BODY_B]):
            if is_dynamic(bodies, body):
                for k in range(first[body], first[body + 1]):
                    other = touching[k]
                    if tags[other, STATUS] & ACTIVE:
                        update(tree, leaves, other, error(bodies, contacts, tags, other))
    return visits, tree[1]


@jit
def resolve(bodies, contacts, tags, c):
    """Replace the impulse of one contact by the one its law demands, and its torque likewise."""
    B = contact_basis(vec3(contacts, c, NORMAL))
    K = matrix(contacts, c)
    old = vec3(contacts, c, IMPULSE)
    mu = friction_coefficient(contacts, tags, c)

    # what the collision velocity would be without this contact's own impulse, less what may remain of it
    free = slip(bodies, V, W, contacts, tags, c, B) + K @ old - vec3(contacts, c, AIM)
    new, sticks = coulomb_impulse(K, free, mu, mu)
    apply(bodies, contacts, tags, c, B @ (new - old))
    put_vec3(contacts, c, IMPULSE, new)
    tags[c, STATUS] = (tags[c, STATUS] & (ACTIVE | KINETIC)) | (0 if sticks else SATURATED)

    if resists_turning(contacts, c):
        missing = missing_torque(bodies, contacts, tags, c, B)
        twist(bodies, tags, c, B @ missing)
        put_vec3(contacts, c, TWIST, vec3(contacts, c, TWIST) + missing)


@jit
def friction_coefficient(contacts, tags, c):
    """mu_s while the contact holds, mu_d once it has let go."""
    return contacts[c, MU + (DYNAMIC_MU if tags[c, STATUS] & KINETIC else STATIC_MU)]


@jit
def resists_turning(contacts, c):
    """Whether the pair of materials has a rolling or torsional coefficient."""
    return contacts[c, MU + ROLLING] > 0.0 or contacts[c, MU + TORSIONAL] > 0.0


@jit
def missing_torque(bodies, contacts, tags, c, B):
    """The angular impulse that the contact's turning resistance demands beyond the one it has, contact coordinates."""
    inertia = mat33(bodies, tags[c, BODY_A], WORLD_INERTIA) + mat33(bodies, tags[c, BODY_B], WORLD_INERTIA)
    spin = relative_spin(bodies, W, tags, c)
    held = vec3(contacts, c, TWIST)
    rolling, torsional = contacts[c, MU + ROLLING], contacts[c, MU + TORSIONAL]
    return resisting_torque(inertia, B, spin, held, rolling, torsional, contacts[c, IMPULSE]) - held


@jit
def error(bodies, contacts, tags, c):
    """How far the velocity of a contact is from what its law demands of its present impulse, m/s."""
    B = contact_basis(vec3(contacts, c, NORMAL))
    u = slip(bodies, V, W, contacts, tags, c, B) - vec3(contacts, c, AIM)
    g = vec3(contacts, c, IMPULSE)
    if g.x <= 0.0:
        return max(u.x, 0.0)

    slipping = math.sqrt(u.y * u.y + u.z * u.z)
    if tags[c, STATUS] & SATURATED:
        # on the cone: the slip must lie along the impulse, and the impulse must not lie outside
        size = math.sqrt(g.y * g.y + g.z * g.z)
        if size > 0.0:
            along = (u.y * g.y + u.z * g.z) / size
            across = abs(u.y * g.z - u.z * g.y) / size
            outside = (size - friction_coefficient(contacts, tags, c) * g.x) * contacts[c, K_ROW + 3]
            slipping = max(across if along > 0.0 else slipping, outside)
        else:
            slipping = 0.0
    turning = turning_error(bodies, contacts, tags, c, B) if resists_turning(contacts, c) else 0.0
    return max(abs(u.x), max(slipping, turning))


@jit
def turning_error(bodies, contacts, tags, c, B):
    """The change of angular velocity that the missing torque would make, at the contact's longer arm, m/s."""
    missing = B @ missing_torque(bodies, contacts, tags, c, B)
    worst_part = 0.0
    for body in (tags[c, BODY_A], tags[c, BODY_B]):
        if is_dynamic(bodies, body):
            change = length(mat33(bodies, body, WORLD_INERTIA) @ missing)
            worst_part = max(worst_part, change * length(arm(bodies, contacts, c, body)))
    return worst_part


@jit
def let_go(bodies, contacts, tags, m, tree, leaves, speed):
    """Contacts that slip faster than ``speed`` although mu_s holds them become kinetic. Returns whether that leaves
    anything to resolve.

    Those without a load too: they may be loaded when the others have let go, and then they slip already.
    """
    for c in range(m):
        if tags[c, STATUS] & ACTIVE and not tags[c, STATUS] & KINETIC:
            u = slip(bodies, V, W, contacts, tags, c, contact_basis(vec3(contacts, c, NORMAL))) - vec3(contacts, c, AIM)
            if math.sqrt(u.y * u.y + u.z * u.z) > speed:
                tags[c, STATUS] |= KINETIC
                update(tree, leaves, c, error(bodies, contacts, tags, c))
    return tree[1] > TOLERANCE
