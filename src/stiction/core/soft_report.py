"""Contacts of the soft solver as the world reports them: a row a contact point, made only when they are asked for."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.jit import entry
from stiction.core.manifolds import gap_at, tilt_of
from stiction.core.pairs import PAIR_A, PAIR_B, SLOT
from stiction.core.state import (
    BODY_A,
    BODY_B,
    CENTER,
    FEATURE,
    KINETIC,
    NORMAL,
    ORIENTATION,
    POINT,
    POSITION,
    SATURATED,
    SEPARATION,
    STATUS,
    TOTAL,
    TOTAL_FRICTION,
)
from stiction.core.vec import dot, put_vec3, quat, rotation, vec3, wide


@entry
def report_contacts(bodies, pairs, count, manifolds, meta, reports, contacts, tags):
    """Fill rows of contact points from the manifolds of all pairs, where the bodies are now; returns how many.

    Friction acts on the patch as a whole; it is told as forces at the points: each has its share of the force by its
    load, and of the torque by its load and its arm from the centre of pressure.
    """
    found = 0
    for k in range(count):
        a, b, row = pairs[k, PAIR_A], pairs[k, PAIR_B], pairs[k, SLOT] + 1
        points = int(meta[row, s.POINTS])
        if found + points > contacts.shape[0]:
            return found + 4 * (count - k)
        Ra, Rb = rotation(quat(bodies, a, ORIENTATION)), rotation(quat(bodies, b, ORIENTATION))
        xa = vec3(bodies, a, POSITION) + Ra @ vec3(bodies, a, CENTER)
        xb = vec3(bodies, b, POSITION) + Rb @ vec3(bodies, b, CENTER)
        n, u, v, tilt = tilt_of(manifolds, row, Ra, Rb)
        on_a, on_b = xa + Ra @ vec3(meta, row, s.ANCHOR_A), xb + Rb @ vec3(meta, row, s.ANCHOR_B)
        shift = dot(n, on_b - on_a)

        total, px, py = 0.0, 0.0, 0.0
        for j in range(points):
            load = reports[row, s.TOTAL_LOAD + j]
            total += load
            px += load * manifolds[row, s.PLACE_U + j]
            py += load * manifolds[row, s.PLACE_V + j]
        share = 1.0 / total if total > 0.0 else 0.0
        px, py, spread = px * share, py * share, 0.0
        for j in range(points):
            dx, dy = manifolds[row, s.PLACE_U + j] - px, manifolds[row, s.PLACE_V + j] - py
            spread += reports[row, s.TOTAL_LOAD + j] * (dx * dx + dy * dy)
        pull = wide(vec3(reports, row, s.TOTAL_PULL))
        twist = reports[row, s.TOTAL_TWIST] - (px * dot(pull, v) - py * dot(pull, u))
        # what is left of the spread when one point carries all is rounding
        size2 = meta[row, s.SIZE2]
        turning = twist / spread if spread > 1e-6 * total * size2 else 0.0
        for j in range(points):
            x, y = manifolds[row, s.PLACE_U + j], manifolds[row, s.PLACE_V + j]
            load = reports[row, s.TOTAL_LOAD + j]
            separation = gap_at(manifolds, row, j, shift, dot(tilt, u), dot(tilt, v))
            tags[found, BODY_A], tags[found, BODY_B] = a, b
            tags[found, FEATURE] = int(meta[row, s.FEATURES + j])
            tags[found, STATUS] = KINETIC | SATURATED if manifolds[row, s.STATE] == s.SLIDING else 0
            put_vec3(contacts, found, POINT, (on_a + on_b) * 0.5 + u * x + v * y)
            put_vec3(contacts, found, NORMAL, n)
            contacts[found, SEPARATION] = separation
            contacts[found, TOTAL] = load
            around = (v * (x - px) - u * (y - py)) * (turning * load)
            put_vec3(contacts, found, TOTAL_FRICTION, pull * (load * share) + around)
            found += 1
    return found
