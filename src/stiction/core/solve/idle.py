"""Blocks of manifolds that are open: bodies are near, and nothing presses.

In a heap a fifth of the manifolds with points carry nothing (of equal spheres two thirds): they are there for what may
come within the step. ``colouring`` has them lie together, and a pass over them need only see that it stays so.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.jit import jit
from stiction.core.lanes import all_of, any_of, load, size_of, store
from stiction.core.solve.blocks import get3, get4, put3
from stiction.core.vec import Vec3


@jit
def belt_now(blocks, o, h):
    """B_BELT at the end of a substep."""
    belt = get3(blocks, o + s.B_BELT)
    return Vec3(belt.x + load(blocks, o + s.B_DRIFT) * h, belt.y + load(blocks, o + s.B_DRIFT + 1) * h, belt.z)


@jit
def stays_open(blocks, o, v, w, x, y, aim, near, h, cold, counts, rolls):
    """Whether no manifold of a block carries anything or comes to do so in this pass, nor changes its state: then what
    a pass would write is written, and bodies stay as they are.

    Points that are not near and close more slowly than ``aim`` carry nothing; without a load nothing can stick, and
    what slides and owes nothing goes on so. ``v`` and ``w`` as from :func:`twist_now`.
    """
    if any_of(near):
        return False
    lam, pull = get4(blocks, o + s.B_LOAD), get3(blocks, o + s.B_PULL)
    force = lam.a + lam.b + lam.c + lam.d + size_of(pull.x) + size_of(pull.y) + size_of(pull.z)
    if rolls is not None:
        force = force + size_of(load(blocks, o + s.B_ROLL)) + size_of(load(blocks, o + s.B_ROLL + 1))
    if not all_of(force <= 0.0):
        return False
    idle = (v.x + y.a * w.y - x.a * w.z <= aim.a) & (v.x + y.b * w.y - x.b * w.z <= aim.b)
    idle = idle & (v.x + y.c * w.y - x.c * w.z <= aim.c) & (v.x + y.d * w.y - x.d * w.z <= aim.d)
    if counts:
        idle = idle & keeps_state(blocks, o)
    if not all_of(idle):
        return False
    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    leave_open(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm), h, cold, counts)
    return True


@jit
def keeps_state(blocks, o):
    """Whether manifolds without a load go on as they are: they slide and owe nothing, or are nobody's."""
    nobody = load(blocks, o + s.B_MASS_A) + load(blocks, o + s.B_MASS_B) <= 0.0
    slides = load(blocks, o + s.B_STATE) > 0.5
    return nobody | (slides & (size_of(load(blocks, o + s.B_OVER)) <= 0.0))


@jit
def leave_open(blocks, o, slip, h, cold, counts):
    """Write what a pass over open manifolds would; ``slip``: without B_BELT."""
    zero = slip.x - slip.x
    store(blocks, o + s.B_MISS, zero)
    if counts:
        belt = belt_now(blocks, o, h)
        put3(blocks, o + s.B_BELT, belt)
        put3(blocks, o + s.B_SLIP, slip + belt)
        store(blocks, o + s.B_LEFT, zero)
