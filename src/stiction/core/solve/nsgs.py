"""Nonsmooth Gauss-Seidel: contact after contact gets the impulse that its own 3 x 3 problem asks for.

Jean, "The non-smooth contact dynamics method", CMAME 177 (1999). A sweep costs one product with W (9 multiplications a
block, each block read once) and one local solution a contact; nothing is kept but r. It needs no full rank: where many
contacts carry one body, as nearly always between rigid bodies, it ends at one of the many solutions. It converges
linearly at best, and slowly where impulses have far to travel.

With ``alpha`` above zero it solves the proximal problem W + alpha 1, q - alpha anchor instead: stiffer, and equal to
the problem itself once r has come to rest at the anchor.
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


@entry
def natural_map(pointers, indices, blocks, q, mu, r, rho):
    """|r - P_K(r - rho (u + (mu |u_t|, 0, 0)))| over all contacts, not divided by anything."""
    total = 0.0
    for i in range(len(mu)):
        u = velocity_at(i, pointers, indices, blocks, q, r)
        raised = u.x + mu[i] * math.sqrt(u.y * u.y + u.z * u.z)
        p = cone_projection(r[i, 0] - rho * raised, r[i, 1] - rho * u.y, r[i, 2] - rho * u.z, mu[i])
        dx, dy, dz = r[i, 0] - p.x, r[i, 1] - p.y, r[i, 2] - p.z
        total += dx * dx + dy * dy + dz * dz
    return math.sqrt(total)


@jit
def visit(i, pointers, indices, blocks, places, q, mu, extra, r, anchor, alpha, which, omega):
    """Give contact i the impulse that its local solver asks for."""
    D = blocks[places[i]]
    old = Vec3(r[i, 0], r[i, 1], r[i, 2])
    pull = Vec3(old.x - anchor[i, 0], old.y - anchor[i, 1], old.z - anchor[i, 2]) * alpha
    # What differs between W's block and K (a block that its file has made unsymmetric, ``extra``) acts at the old
    # impulse, through u: it slows the way to the solution and does not move it.
    xy, xz, yz = 0.5 * (D[0, 1] + D[1, 0]), 0.5 * (D[0, 2] + D[2, 0]), 0.5 * (D[1, 2] + D[2, 1])
    more = alpha + extra[i]
    K = Mat33(D[0, 0] + more, xy, xz, xy, D[1, 1] + more, yz, xz, yz, D[2, 2] + more)
    b = K @ old - velocity_at(i, pointers, indices, blocks, q, r) - pull
    new = local_solution(which, K, b, old, mu[i])
    if omega != 1.0:
        new = old + (new - old) * omega
        new = cone_projection(new.x, new.y, new.z, mu[i])
    r[i, 0], r[i, 1], r[i, 2] = new.x, new.y, new.z


@entry
def sweep(pointers, indices, blocks, places, q, mu, extra, r, order, turn, anchor, alpha, which, omega, sweeps):
    """So many sweeps over the contacts in ``order``; r (n, 3) is changed in place.

    With ``turn`` every second sweep goes backwards. ``places`` says where the diagonal blocks are, ``extra`` (n,) is
    added to the diagonal of those that are singular, ``which`` is the local solver, ``omega`` over- or under-relaxes.
    """
    n = len(mu)
    for done in range(sweeps):
        for k in range(n):
            i = order[n - 1 - k] if turn and done % 2 == 1 else order[k]
            visit(i, pointers, indices, blocks, places, q, mu, extra, r, anchor, alpha, which, omega)
