"""Impacts that bounce, before the forces of a step: those of the lecture's solver, on the points of the manifolds.

Soft contacts cannot bounce by themselves: what they push out is damped away. So collisions with restitution are taken
as in ``micro``: in waves, the worst first, with Coulomb friction, never with more energy after than before. They cost
nothing in a step in which no point closes fast enough.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.contact_rows import prepare_bodies, prepare_contacts
from stiction.core.jit import jit
from stiction.core.solve.impacts import resolve_impacts
from stiction.core.state import (
    BODY_A,
    BODY_B,
    BODY_WIDTH,
    FEATURE,
    NORMAL,
    POINT,
    SEPARATION,
    TOTAL,
    TOTAL_FRICTION,
    V,
    W,
)
from stiction.core.vec import cross, dot, length, mat33, put_vec3, vec3


@jit
def collect_impacts(bodies, active, count, manifolds, meta, pose, contacts, tags, settings, g):
    """Rows of all points that may bounce, if any of them is about to; returns how many, which may exceed the room."""
    about_to = False
    found = 0
    for k in range(count):
        a, b, row = active[k, 0], active[k, 1], active[k, 2] + 1
        if meta[row, s.RESTITUTION] <= 0.0:
            continue
        xa, xb = vec3(pose, a + 1, s.POSE_X), vec3(pose, b + 1, s.POSE_X)
        Ra = mat33(pose, a + 1, s.POSE_ROTATION)
        n, u = Ra @ vec3(manifolds, row, s.NORMAL_A) * 1.0, Ra @ vec3(manifolds, row, s.TANGENT_A) * 1.0
        n = n * (1.0 / length(n))  # in single precision it is one to seven digits, which would make or take energy
        v = cross(n, u)
        shift = dot(n, vec3(manifolds, row, s.SHIFT) * 1.0)
        center = xa + Ra @ vec3(meta, row, s.ANCHOR_A) + n * (0.5 * shift)
        points = int(meta[row, s.POINTS])
        mean = 0.0
        for j in range(points):
            mean += manifolds[row, s.GAP + j] / points
        for j in range(points):
            p = center + u * manifolds[row, s.PLACE_U + j] + v * manifolds[row, s.PLACE_V + j]
            gap = manifolds[row, s.GAP + j] + shift
            p = p + n * (0.5 * (manifolds[row, s.GAP + j] - mean))
            va = vec3(bodies, a, V) + cross(vec3(bodies, a, W), p - xa)
            vb = vec3(bodies, b, V) + cross(vec3(bodies, b, W), p - xb)
            closing = dot(n, va - vb)
            about_to |= closing > settings.threshold and gap <= settings.dt * (closing + g * settings.dt)
            if found < contacts.shape[0]:
                tags[found, BODY_A], tags[found, BODY_B], tags[found, FEATURE] = a, b, 4 * row + j
                put_vec3(contacts, found, POINT, p)
                put_vec3(contacts, found, NORMAL, n)
                contacts[found, SEPARATION] = gap
            found += 1
    return found if about_to else 0


@jit
def bounce(bodies, kinds, n, table, contacts, tags, m, lists, settings, ledger, report, gravity, wide):
    """Resolve the impacts among m contact rows: velocities of the bodies change, and what friction has taken.

    Bodies that have not all columns (``state.SHORT_WIDTH``) are copied to ``wide``, and back.
    """
    _order, _pairs, first, touching, tree, group, gain, _last_ledger, _last_report, _points = lists
    short = bodies.shape[1] < BODY_WIDTH
    rows = wide if short else bodies
    if short:
        copy_rows(wide, bodies, n)
    prepare_bodies(rows, n)
    prepare_contacts(rows, kinds, table, contacts, tags, m, first, touching, n)
    resolve_impacts(rows, n, contacts, tags, m, first, touching, tree, group, gain, settings, ledger, report, gravity)
    if short:
        copy_rows(bodies, wide, n)


@jit
def copy_rows(to, rows, n):
    """Copy n rows, as many columns as both have."""
    for i in range(n):
        for k in range(min(to.shape[1], rows.shape[1])):
            to[i, k] = rows[i, k]


@jit
def report_bounces(contacts, tags, m, reports):
    """Add the impulses of the impacts to the reports of their manifolds."""
    for c in range(m):
        row, point = tags[c, FEATURE] >> 2, tags[c, FEATURE] & 3
        reports[row, s.TOTAL_LOAD + point] += contacts[c, TOTAL]
        for k in range(3):
            reports[row, s.TOTAL_PULL + k] += contacts[c, TOTAL_FRICTION + k]
