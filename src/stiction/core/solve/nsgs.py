"""Nonsmooth Gauss-Seidel: contact after contact gets the impulse that its own 3 x 3 problem asks for.

Jean, "The non-smooth contact dynamics method", CMAME 177 (1999). A sweep costs one product with W (9 multiplications a
block, each block read once) and one local solution a contact; nothing is kept but r. It needs no full rank: where many
contacts carry one body, as nearly always between rigid bodies, it ends at one of the many solutions. It converges
linearly at best, slowly where impulses have far to travel: an error that is a hundred times smaller may take a
hundred times as many sweeps.

With ``alpha`` above zero it solves the proximal problem W + alpha 1, q - alpha anchor instead: stiffer, and equal to the
problem itself once r has come to rest at the anchor.
"""

from __future__ import annotations

import math

from stiction.core.friction.local import cone_projection, local_solution
from stiction.core.jit import entry, jit
from stiction.core.vec import Mat33, Vec3


@jit
def block_times(block, r):
    """A block of W times an impulse."""
    return Vec3(
        block[0, 0] * r[0] + block[0, 1] * r[1] + block[0, 2] * r[2],
        block[1, 0] * r[0] + block[1, 1] * r[1] + block[1, 2] * r[2],
        block[2, 0] * r[0] + block[2, 1] * r[1] + block[2, 2] * r[2],
    )


@jit
def velocity_at(i, pointers, indices, blocks, q, r):
    """u_i = (W r + q)_i."""
    u = Vec3(q[i, 0], q[i, 1], q[i, 2])
    for k in range(pointers[i], pointers[i + 1]):
        u = u + block_times(blocks[k], r[indices[k]])
    return u


@jit
def natural_map_norm(pointers, indices, blocks, q, mu, r, rho):
    """|r - P_K(r - rho (u + (mu |u_t|, 0, 0)))| over all contacts, not yet divided by |q|."""
    total = 0.0
    for i in range(len(mu)):
        u = velocity_at(i, pointers, indices, blocks, q, r)
        raised = u.x + mu[i] * math.sqrt(u.y * u.y + u.z * u.z)
        p = cone_projection(r[i, 0] - rho * raised, r[i, 1] - rho * u.y, r[i, 2] - rho * u.z, mu[i])
        dx, dy, dz = r[i, 0] - p.x, r[i, 1] - p.y, r[i, 2] - p.z
        total += dx * dx + dy * dy + dz * dz
    return math.sqrt(total)


@entry
def natural_map(pointers, indices, blocks, q, mu, r, rho):
    """:func:`natural_map_norm` for Python."""
    return natural_map_norm(pointers, indices, blocks, q, mu, r, rho)


@jit
def visit(i, pointers, indices, blocks, places, q, mu, r, anchor, alpha, which, omega):
    """Give contact i the impulse that its local solver asks for."""
    b = -velocity_at(i, pointers, indices, blocks, q, r)
    D = blocks[places[i]]
    old = Vec3(r[i, 0], r[i, 1], r[i, 2])
    # Files hold W with rounding of their own: the local solvers get its symmetric part, the rest acts at the old impulse
    xy, xz, yz = 0.5 * (D[0, 1] + D[1, 0]), 0.5 * (D[0, 2] + D[2, 0]), 0.5 * (D[1, 2] + D[2, 1])
    K = Mat33(D[0, 0] + alpha, xy, xz, xy, D[1, 1] + alpha, yz, xz, yz, D[2, 2] + alpha)
    pull = Vec3(old.x - anchor[i, 0], old.y - anchor[i, 1], old.z - anchor[i, 2])
    b = b + K @ old - pull * alpha
    new = local_solution(which, K, b, old, mu[i])
    if omega != 1.0:
        new = old + (new - old) * omega
        new = cone_projection(new.x, new.y, new.z, mu[i])
    r[i, 0], r[i, 1], r[i, 2] = new.x, new.y, new.z


@entry
def sweep(pointers, indices, blocks, places, q, mu, r, order, turn, anchor, alpha, which, omega, sweeps, enough, every):
    """Up to ``sweeps`` sweeps over the contacts in ``order``; r (n, 3) is changed in place.

    With ``turn`` every second sweep goes backwards. ``omega`` over- or under-relaxes. Every ``every`` sweeps the natural
    map of the problem itself (rho = 1) is taken; at ``enough`` or less, and where r is not finite, it stops.
    Returns the number of sweeps done and the last natural map.
    """
    n = len(mu)
    error = math.inf
    done = 0
    while done < sweeps:
        backwards = turn and done % 2 == 1
        for k in range(n):
            i = order[n - 1 - k] if backwards else order[k]
            visit(i, pointers, indices, blocks, places, q, mu, r, anchor, alpha, which, omega)
        done += 1
        if done % every == 0 or done == sweeps:
            error = natural_map_norm(pointers, indices, blocks, q, mu, r, 1.0)
            if not error > enough:
                break
    return done, error
