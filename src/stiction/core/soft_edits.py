"""Bodies that were added or changed from outside since the last call: they wake, with all that they touch."""

from __future__ import annotations

import math

from stiction.core.apart import EDITED_MOTION
from stiction.core.integrate import keep_body
from stiction.core.jit import jit
from stiction.core.pairs import PAIR_A, PAIR_B, PAIRS, is_sensed, touch_body
from stiction.core.sleep import wake_island
from stiction.core.soft_bodies import begin_body
from stiction.core.soft_scratch import EDITED, N_EDITED, N_KNOWN, N_LAST, STALE, WATCHED
from stiction.core.state import ASLEEP, FORCE, INITIAL, LAST, MOBILITY, MOTION, POSITION, STATIC, TORQUE, V


@jit
def is_touched(bodies, kinds, n, counts, pull, gravity, ledger):
    """Whether anything may have been changed from outside since the last call, which ended with n bodies in a field
    ``pull``: else energies are what they were, and nobody has to wake.

    Where views of the state have been handed out, that is a look at all bodies.
    """
    if counts[N_EDITED] > 0 or counts[N_KNOWN] < n or counts[N_LAST] != n or math.isnan(ledger[INITIAL]):
        return True
    if pull[0] != gravity.x or pull[1] != gravity.y or pull[2] != gravity.z:
        return True
    if counts[WATCHED]:
        for i in range(n):
            if was_changed(bodies, i) or (kinds[i, ASLEEP] and is_pushed(bodies, i)):
                return True
    return False


@jit
def take_edits(bodies, kinds, n, cache, pose, rows, aux, listed, counts, restless, gravity, g, dt, h):
    """Look at bodies that were added or changed from outside since the last call, and wake what they are part of.

    Where views of the state have been handed out, bodies are compared with what they were: those that sleep or never
    move, to wake, as do those that are pushed; others that are elsewhere now have their manifolds looked for anew.
    ``restless`` (n,) is scratch.
    """
    for i in range(counts[N_KNOWN], n):
        listed[EDITED, counts[N_EDITED]] = i
        counts[N_EDITED] += 1
    counts[N_KNOWN] = n
    if counts[WATCHED]:
        for i in range(n):
            restless[i] = 0
        for k in range(counts[N_EDITED]):
            restless[listed[EDITED, k]] = 1
        for i in range(n):
            if restless[i]:
                continue
            if kinds[i, MOBILITY] == STATIC or kinds[i, ASLEEP]:
                if was_changed(bodies, i) or (kinds[i, ASLEEP] and is_pushed(bodies, i)):
                    listed[EDITED, counts[N_EDITED]] = i
                    counts[N_EDITED] += 1
            elif was_moved(bodies, i):
                bodies[i, MOTION] += EDITED_MOTION
    if counts[N_EDITED] > 0:
        # whatever touches a body that was changed has to notice
        for i in range(n):
            restless[i] = 0
        for k in range(counts[N_EDITED]):
            restless[listed[EDITED, k]] = 1
            wake_island(bodies, kinds, n, listed[EDITED, k])
        for j in range(cache.counts[PAIRS]):
            a, b = cache.pairs[j, PAIR_A], cache.pairs[j, PAIR_B]
            if (restless[a] or restless[b]) and not is_sensed(kinds, a, b):
                wake_island(bodies, kinds, n, a)
                wake_island(bodies, kinds, n, b)
    for k in range(counts[N_EDITED]):
        i = listed[EDITED, k]
        bodies[i, MOTION] += EDITED_MOTION  # its manifolds are looked for anew
        begin_body(bodies, kinds, i, pose, rows, aux, gravity, g, dt, h)
        keep_body(bodies, i)
        touch_body(cache, i)
        counts[STALE] = 1
    counts[N_EDITED] = 0


@jit
def is_pushed(bodies, i):
    """Whether a force or torque was applied to body i for the coming step."""
    for c in range(3):
        if bodies[i, FORCE + c] != 0.0 or bodies[i, TORQUE + c] != 0.0:
            return True
    return False


@jit
def was_changed(bodies, i):
    """Whether position, orientation or velocities of body i are not those that were kept."""
    if was_moved(bodies, i):
        return True
    for c in range(6):
        if bodies[i, LAST + 7 + c] != bodies[i, V + c]:
            return True
    return False


@jit
def was_moved(bodies, i):
    """Whether position or orientation of body i are not those that were kept."""
    for c in range(7):
        if bodies[i, LAST + c] != bodies[i, POSITION + c]:
            return True
    return False
