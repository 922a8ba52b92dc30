"""Islands and sleep: bodies that are truly at rest take no part in a step until something touches them.

An island is a set of bodies that touch each other; it sleeps when each of its bodies has gone nowhere for half a second
and no contact of it slides, touches a body that moves by itself, or a moving surface. "Nowhere" is 20 um/s: a crate
that slides at 1 mm/s, or a ball that rolls that slowly, never sleeps.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.integrate import keep_body
from stiction.core.islands import find_group, join_pairs
from stiction.core.jit import jit
from stiction.core.state import ASLEEP, DYNAMIC, ISLAND, KINEMATIC, MOBILITY, REST, V, W
from stiction.core.vec import Vec3, dot, put_vec3, vec3

REST_SPEED = 2e-5
"""m/s, of the fastest point of a body that is at rest."""
REST_TIME = 0.5
"""s, for which all bodies of an island have to be at rest."""
PERIOD = 16
"""Steps from one look for islands that may sleep to the next: a look costs as much as a stage of the step."""


@jit
def put_to_sleep(bodies, kinds, awake, count, active, contacts, manifolds, pose, group, restless):
    """Put islands that are at rest to sleep; returns how many bodies that were.

    ``awake`` lists ``count`` bodies, ``active`` (rows: a, b, slot, colour) the manifolds of the step; ``group`` and
    ``restless`` are scratch, (n,) int64.
    """
    candidates = 0
    for k in range(count):
        i = awake[k]
        group[i], restless[i] = i, 0
        candidates += kinds[i, MOBILITY] == DYNAMIC and bodies[i, REST] >= REST_TIME
    if candidates == 0:
        return 0
    join_pairs(kinds, active, contacts, group)
    for k in range(count):
        i = awake[k]
        if kinds[i, MOBILITY] == DYNAMIC and bodies[i, REST] < REST_TIME:
            restless[find_group(group, i)] = 1
    for k in range(contacts):
        a, b, row = active[k, 0], active[k, 1], active[k, 2] + 1
        driven = _is_driven(bodies, kinds, pose, a) or _is_driven(bodies, kinds, pose, b)
        # without friction nothing ever sticks
        slides = manifolds[row, s.STATE] == s.SLIDING and manifolds[row, s.MU_D] > 0.0
        if driven or slides:
            for i in (a, b):
                if kinds[i, MOBILITY] == DYNAMIC:
                    restless[find_group(group, i)] = 1
    slept = 0
    for k in range(count):
        i = awake[k]
        if kinds[i, MOBILITY] == DYNAMIC:
            root = find_group(group, i)
            if not restless[root]:
                _fall_asleep(bodies, kinds, i, root)
                slept += 1
    return slept


@jit
def _is_driven(bodies, kinds, pose, i):
    """Whether body i moves, or its surface does, whatever touches it."""
    if pose[i + 1, s.POSE_ODD] > 0.0:
        return True
    v, w = vec3(bodies, i, V), vec3(bodies, i, W)
    return kinds[i, MOBILITY] == KINEMATIC and dot(v, v) + dot(w, w) > 0.0


@jit
def _fall_asleep(bodies, kinds, i, island):
    kinds[i, ASLEEP], kinds[i, ISLAND] = 1, island
    zero = Vec3(0.0, 0.0, 0.0)
    put_vec3(bodies, i, V, zero)
    put_vec3(bodies, i, W, zero)
    keep_body(bodies, i)


@jit
def wake_island(bodies, kinds, n, i):
    """Wake body i and all that fell asleep with it."""
    if kinds[i, ASLEEP]:
        island = kinds[i, ISLAND]
        for j in range(n):
            if kinds[j, ASLEEP] and kinds[j, ISLAND] == island:
                kinds[j, ASLEEP] = 0
                bodies[j, REST] = 0.0
