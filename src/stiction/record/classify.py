"""What every body of a world is doing, judged from the contacts of the last step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction.motion import Motion
from stiction.world import World

TURNING_SHARE = 0.1
"""A body turns over its contact if that gives its centre at least this share of its speed (1 for a rolling ball)."""
TURNING_SPEED = 1e-3
"""m/s: turning that moves the centre more slowly than this is not seen."""


def fixed_bodies(world: World) -> NDArray[np.bool_]:
    """(n,) which bodies are static or kinematic."""
    return np.fromiter((body.mobility != "dynamic" for body in world), np.bool_, len(world))


def classify(world: World, fixed: NDArray[np.bool_] | None = None) -> NDArray[np.uint8]:
    """(n,) values of :class:`stiction.motion.Motion`, one a body in order of creation.

    A body slides if one of its loaded contact points does not stick. It rolls if all of them stick and it turns over
    one of them: |w x r|, the speed that the turning gives its centre, is notable compared with the speed it has. Spin
    about the normal is not rolling, and turning together with the other body, as on a turntable, is neither. Before
    the first step nothing is known of contacts, so every body that can move is free.

    Args:
        world: a world after a step.
        fixed: (n,) what :func:`fixed_bodies` gives, for callers that ask often.
    """
    n = len(world)
    fixed = fixed_bodies(world) if fixed is None else fixed
    rows = world.contacts()
    rows = rows[rows["normal_impulse"] > 0.0]

    touched, slides, rolls = (np.zeros(n, np.bool_) for _ in range(3))
    a, b = rows["body_a"], rows["body_b"]
    held = rows["sticking"]
    for body in (a, b):
        touched[body] = True
        slides[body[~held]] = True

    normal = rows["normal"]
    spin = world.angular_velocities[a] - world.angular_velocities[b]
    spin -= normal * np.sum(normal * spin, axis=1, keepdims=True)
    for body in (a, b):
        arm = np.linalg.norm(rows["point"] - world.positions[body], axis=1)
        turning = np.linalg.norm(spin, axis=1) * arm
        speed = np.linalg.norm(world.velocities[body], axis=1)
        rolls[body[held & (turning > np.maximum(TURNING_SPEED, TURNING_SHARE * speed))]] = True

    motion = np.full(n, Motion.FREE, np.uint8)
    motion[touched] = Motion.STICKING
    motion[rolls] = Motion.ROLLING
    motion[slides] = Motion.SLIDING
    motion[fixed] = Motion.FIXED
    return motion
