"""Contact makes no energy: what it has given an island, the bodies of the island give back by moving more slowly.

Ideal contact takes energy or keeps it. A real one is a spring that pushes out of what is deeper than its load presses
it in, and moves bodies apart that a step has driven into each other. So the energy of an island, bodies that touch each
other, is compared with what it was before the step, and with what its contacts have done: the work of the loads of deep
ones along their normals, and what it takes to move bodies out of fixed ones. The lesser of both is what contact has
made, and the island pays for it with its motion, as long as it has some. Neither alone would do: a load that pushes one
body up as another one sinks has made nothing; and integrators err to and fro, so a card that topples would be held back
for what is taken from it only whenever it is too fast.

Costs: nothing where all is at rest; else one look at each body in contact, and where one has gained, a union of the
pairs that touch.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.contact_work import kinetic, kinetic_at_start, load_and_tilt, rise_of, slow_down, tumbles
from stiction.core.islands import find_group, join_pairs
from stiction.core.jit import jit
from stiction.core.manifolds import gap_at, tilt_of
from stiction.core.solve.soft import softness
from stiction.core.state import DYNAMIC, KINEMATIC, MASS, MOBILITY, REACH, V, W
from stiction.core.vec import cross, dot, length, mat33, vec3, wide

ROUNDING, STILL = 1e-7, 1e-7
"""What may be gained unnoticed: this part of a kinetic energy, and so much a mass, J/kg: that of ten nanometres."""
NOTABLE = 0.003
"""m/s: a contact is deep from where its spring alone would push so fast; not as deep lies what rests."""


@jit
def take_gains_back(bodies, kinds, active, count, touched, touching, group, soft, gravity, dt, h):
    """Slow islands down that contact has given energy in a step of substeps h. ``group`` (n,) is scratch."""
    if not any_gained(bodies, kinds, touched, touching, soft, gravity, dt):
        return
    find_islands(kinds, active, count, touched, touching, group)
    if not any_island_gained(bodies, kinds, touched, touching, group, soft, gravity, dt):
        return
    push_out_rate, _, _, _ = softness(h)
    enter_work_of_loads(bodies, kinds, active, count, group, soft, NOTABLE / push_out_rate, dt)
    for k in range(touching):
        i = touched[k]
        if kinds[i, MOBILITY] == DYNAMIC and not tumbles(soft.pose, i + 1):
            r = find_group(group, i) + 1
            due, has = min(soft.aux[r, s.AUX_GAIN], soft.aux[r, s.AUX_OWES]), soft.aux[r, s.AUX_HAS]
            if due > 0.0 and has > 0.0:
                slow_down(bodies, i, math.sqrt(max(1.0 - due / has, 0.0)))


@jit
def any_gained(bodies, kinds, touched, touching, soft, gravity, dt):
    """Whether a body has gained more than rounding: if none has, no island has."""
    for k in range(touching):
        i = touched[k]
        if kinds[i, MOBILITY] == DYNAMIC and not is_still(bodies, i, soft.rows, soft.aux, gravity, dt):
            gain, has = gain_of(bodies, i, soft, gravity)
            if gain > ROUNDING * has + STILL * bodies[i, MASS]:
                return True
    return False


@jit
def is_still(bodies, i, rows, aux, gravity, dt):
    """Whether body i has hardly any energy to have gained, for less than an exact answer takes."""
    r = i + 1
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    way = wide(vec3(aux, r, s.AUX_START_V)) * dt + wide(vec3(rows, r, s.ROW_D))
    return dot(v, v) + bodies[i, REACH] * bodies[i, REACH] * dot(w, w) < STILL and -dot(gravity, way) < 0.5 * STILL


@jit
def gain_of(bodies, i, soft, gravity):
    """What body i has gained in a step beyond the work of what pulls at it besides contact, and its kinetic energy."""
    has, had = kinetic(bodies, i), kinetic_at_start(bodies, i, soft)
    return has - had + rise_of(bodies, i, soft, gravity) - soft.aux[i + 1, s.AUX_PULLED], has


@jit
def find_islands(kinds, active, count, touched, touching, group):
    """Group bodies that touch each other, or are about to; what cannot move is alone."""
    for k in range(touching):
        group[touched[k]] = touched[k]
    join_pairs(kinds, active, count, group)


@jit
def any_island_gained(bodies, kinds, touched, touching, group, soft, gravity, dt):
    """Sum gains and kinetic energies of each island, at the row of its lowest body; returns whether an island has
    gained more than rounding."""
    aux = soft.aux
    for k in range(touching):
        r = touched[k] + 1
        aux[r, s.AUX_GAIN] = aux[r, s.AUX_HAS] = aux[r, s.AUX_OWES] = 0.0
    for k in range(touching):
        i = touched[k]
        if kinds[i, MOBILITY] == DYNAMIC and not is_still(bodies, i, soft.rows, soft.aux, gravity, dt):
            gain, has = gain_of(bodies, i, soft, gravity)
            r = find_group(group, i) + 1
            aux[r, s.AUX_GAIN] += gain - STILL * bodies[i, MASS]
            # what tumbles has paid for its way before, and must not stop: what does not tumble is dug out for nothing
            aux[r, s.AUX_HAS] += 0.0 if tumbles(soft.pose, i + 1) else has
            # what it was moved up by out of fixed ones, at most
            aux[r, s.AUX_OWES] += bodies[i, MASS] * length(gravity) * aux[i + 1, s.AUX_LIFTED]
    gained = False
    for k in range(touching):
        r = touched[k] + 1
        gained |= aux[r, s.AUX_GAIN] > ROUNDING * aux[r, s.AUX_HAS]
    return gained


@jit
def enter_work_of_loads(bodies, kinds, active, count, group, soft, deep, dt):
    """Enter what the loads of islands that have gained have pushed apart, where they were ``deep``, m. What something
    drives may gain anything."""
    aux = soft.aux
    for k in range(count):
        a, b = active[k, 0], active[k, 1]
        r = find_group(group, a if kinds[a, MOBILITY] == DYNAMIC else b) + 1
        if aux[r, s.AUX_GAIN] <= 0.0:
            continue
        if is_driven(bodies, kinds, soft, a) or is_driven(bodies, kinds, soft, b):
            aux[r, s.AUX_GAIN] = 0.0
        elif depth_of(a, b, active[k, 2] + 1, soft) > deep:
            aux[r, s.AUX_OWES] += max(work_of_load(a, b, active[k, 2] + 1, soft, dt), 0.0)


@jit
def depth_of(a, b, row, soft):
    """How deep the deepest point of a manifold was when the step began, m."""
    manifolds, pose = soft.manifolds, soft.pose
    n, u, v, tilt = tilt_of(manifolds, row, mat33(pose, a + 1, s.POSE_ROTATION), mat33(pose, b + 1, s.POSE_ROTATION))
    shift = dot(n, wide(vec3(manifolds, row, s.SHIFT)))
    depth = 0.0
    for j in range(int(soft.meta[row, s.POINTS])):
        depth = max(depth, -gap_at(manifolds, row, j, shift, dot(tilt, u), dot(tilt, v)))
    return depth


@jit
def work_of_load(a, b, row, soft, dt):
    """Work along the normals of what a manifold carried, by the mean force of the step and how its bodies went, J."""
    force, torque = load_and_tilt(soft.manifolds, soft.meta, soft.pose, soft.reports, a, row)
    work = 0.0
    for i, arm, sign in ((a, s.ARM_A, -1.0), (b, s.ARM_B, 1.0)):
        r = i + 1
        way = wide(vec3(soft.aux, r, s.AUX_START_V)) * dt + wide(vec3(soft.rows, r, s.ROW_D))
        turn = wide(vec3(soft.aux, r, s.AUX_START_W)) * dt + wide(vec3(soft.rows, r, s.ROW_TURN))
        work += sign * (dot(force, way + cross(turn, wide(vec3(soft.manifolds, row, arm)))) + dot(torque, turn))
    return work / dt


@jit
def is_driven(bodies, kinds, soft, i):
    """Whether body i moves by itself, or its surface does."""
    odd = soft.pose[i + 1, s.POSE_ODD]
    if odd == s.HAS_BELT or odd == s.HAS_BELT + s.TUMBLES:
        return True
    if kinds[i, MOBILITY] != KINEMATIC:
        return False
    # it may have been told to stop, or to go, just now
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    v0, w0 = vec3(soft.aux, i + 1, s.AUX_START_V), vec3(soft.aux, i + 1, s.AUX_START_W)
    return dot(v, v) + dot(w, w) + dot(v0, v0) + dot(w0, w0) > 0.0
