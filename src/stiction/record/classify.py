"""What every body of a world is doing, judged from the contacts of the last step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.hashing import PARTS, STATE_WIDTH
from stiction.motion import Motion
from stiction.world import World

TURNING_SHARE = 0.1
"""A body turns over its contact if that gives its centre at least this share of its speed (1 for a rolling ball)."""
TURNING_SPEED = 1e-3
"""m/s: turning that moves the centre more slowly than this is not seen."""


def fixed_bodies(world: World) -> NDArray[np.bool_]:
    """(n,) which bodies are static or kinematic."""
    state = world._state
    fixed: NDArray[np.bool_] = world._store.kinds[: len(world), state.MOBILITY] != state.DYNAMIC
    return fixed


def classify(world: World) -> NDArray[np.uint8]:
    """(n,) values of :class:`stiction.motion.Motion` after a step, one a body in their order, see :func:`judge`."""
    state = world._store.column(world._state.POSITION, STATE_WIDTH)
    return judge(state, fixed_bodies(world), world.contacts())


def judge(state: NDArray[np.float64], fixed: NDArray[np.bool_], rows: NDArray[Any]) -> NDArray[np.uint8]:
    """(n,) values of :class:`stiction.motion.Motion` of n bodies.

    A body slides if one of its loaded contact points does not stick. It rolls if all of them stick and it turns over
    one of them: |w x r|, the speed that the turning gives its centre, is notable compared with the speed it has. Spin
    about the normal is not rolling, and turning together with the other body, as on a turntable, is neither. Before
    the first step nothing is known of contacts, so every body that can move is free.

    Args:
        state: (n, 13), see :data:`stiction.hashing.STATE_WIDTH`.
        fixed: (n,) which of them are static or kinematic.
        rows: of ``CONTACT_DTYPE``.
    """
    n = len(state)
    loaded = np.flatnonzero(rows["normal_impulse"] > 0.0)
    # numpy's own kind of index, and take instead of brackets: several times as fast
    a, b = (rows[name].take(loaded).astype(np.intp) for name in ("body_a", "body_b"))
    held = rows["sticking"].take(loaded)
    slips = np.flatnonzero(~held)
    touched, slides, rolls = (np.zeros(n, np.bool_) for _ in range(3))
    for body in (a, b):
        touched[body] = True
        slides[body.take(slips)] = True

    # of a contact between bodies that are known already, nothing new can be said
    known = slides | fixed
    rest = np.flatnonzero(held & ~(known.take(a) & known.take(b)))
    a, b, loaded = a.take(rest), b.take(rest), loaded.take(rest)
    normal, point = (rows[name].take(loaded, axis=0) for name in ("normal", "point"))
    of_a, of_b = state.take(a, axis=0), state.take(b, axis=0)
    spin = of_a[:, PARTS["angular_velocities"]] - of_b[:, PARTS["angular_velocities"]]
    spin -= normal * _dot(normal, spin)[:, None]
    turning = _dot(spin, spin)
    for body, own in ((a, of_a), (b, of_b)):
        if known.take(body).all():
            continue  # the ground
        arm = point - own[:, PARTS["positions"]]
        velocity = own[:, PARTS["velocities"]]
        speed = np.maximum(TURNING_SPEED**2, TURNING_SHARE**2 * _dot(velocity, velocity))
        rolls[body.compress(turning * _dot(arm, arm) > speed)] = True

    motion = np.full(n, Motion.FREE, np.uint8)
    motion[touched] = Motion.STICKING
    motion[rolls] = Motion.ROLLING
    motion[slides] = Motion.SLIDING
    motion[fixed] = Motion.FIXED
    return motion


def lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) of vectors (n, 3); several times as fast as :func:`numpy.linalg.norm`, which is made for long rows."""
    vectors = np.ascontiguousarray(vectors)
    return np.sqrt(_dot(vectors, vectors))


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Row by row."""
    result: NDArray[np.float64] = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    return result
