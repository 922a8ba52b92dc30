"""What a step has made of its manifolds: from the blocks back to rows, and into the ledger."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import ask_for_block, ask_for_bodies
from stiction.core.colouring import first_row, is_point_block
from stiction.core.friction.laws import force_in_plane
from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.leaning import hold
from stiction.core.state import FRICTION, LEDGER_WIDTH, ROLLING_LOSS
from stiction.core.vec import Vec3, cross, put_vec3

LEAST_LIFT, FARTHEST = 1e-9, 1e9
"""m"""


@jit
def store_blocks(blocks, index, count, manifolds, reports, aux, h, part, ledgers, failed, laws, exact, many):
    """Give the manifolds back what the step has made of them, and enter what friction and rolling resistance took.

    All rows are those of several worlds; of one that has ``failed`` nothing is stored. A lane that was padded names the
    manifold of nobody. ``laws``: whether the forces in the blocks are scaled (:mod:`stiction.core.friction.laws`);
    ``exact``: whether contacts are rigid; ``many``: how many manifolds the step has.
    """
    for i in range(count):
        o, points = first_row(index, i, count), is_point_block(index, i, count)
        ask_for_bodies(index, i + 1, count, aux, s.AUX_WORK, many)
        ask_for_block(index, i + 1, count, manifolds, s.MANIFOLD_WIDTH, many)
        ask_for_block(index, i + 1, count, reports, s.REPORT_WIDTH, many)
        for lane in range(LANES):
            row, world = index[i + 2 * count, lane], index[i + 3 * count, lane]
            if row > 0 and not failed[world]:
                slid = manifolds[row, s.STATE] == s.SLIDING or blocks[o + s.B_STATE, lane] == s.SLIDING
                scale = blocks[o + s.B_SCALE, lane] * 1.0
                friction, rolling = blocks[o + s.B_WORK, lane] * scale, 0.0
                if points:
                    store_point(blocks, o, lane, manifolds, reports, row, scale, scale / h, part)
                else:
                    whole = lies(blocks, o, lane, manifolds, row)
                    store_lane(blocks, o, lane, manifolds, reports, row, scale, scale / h, part, laws, whole)
                    rolling = blocks[o + s.B_ROLLED, lane] * scale
                    if whole and not exact:
                        hold(aux, index[i, lane], index[i + count, lane])
                manifolds[row, s.STATE], manifolds[row, s.OVER] = (
                    blocks[o + s.B_STATE, lane],
                    blocks[o + s.B_OVER, lane],
                )
                manifolds[row, s.LEFT], manifolds[row, s.FRESH] = blocks[o + s.B_LEFT, lane], s.OLD
                ledgers[LEDGER_WIDTH * world + FRICTION] += friction
                ledgers[LEDGER_WIDTH * world + ROLLING_LOSS] += rolling
                if slid or rolling > 0.0:
                    share_work(aux, index[i, lane], index[i + count, lane], friction + rolling)


@jit
def lies(blocks, o, lane, manifolds, row):
    """Whether a manifold is a face that is not new, sticks and carries with three of its points at least."""
    loaded = 0
    for k in range(int(manifolds[row, s.COUNT])):
        loaded += blocks[o + s.B_LOAD + k, lane] > 0.0
    return loaded > 2 and manifolds[row, s.FRESH] == s.OLD and blocks[o + s.B_STATE, lane] == s.STUCK


@jit
def share_work(aux, a, b, work):
    """Enter what a contact took for the bodies of rows a and b, half for each if both can move."""
    moves_a, moves_b = aux[a, s.AUX_MASS] > 0.0, aux[b, s.AUX_MASS] > 0.0
    share = 0.5 * work if moves_a and moves_b else work
    if moves_a:
        aux[a, s.AUX_WORK] += share
    if moves_b:
        aux[b, s.AUX_WORK] += share


@jit
def store_lane(blocks, o, lane, manifolds, reports, row, scale, rate, part, laws, whole):
    """The same for one manifold; impulses of the block times ``scale`` are impulses, times ``rate`` forces."""
    u, v = tangents_of(blocks, o, lane)
    arm = blocks[o + s.B_TORQUE, lane]
    px, py = blocks[o + s.B_CENTER, lane], blocks[o + s.B_CENTER + 1, lane]
    store_loads(blocks, o, lane, manifolds, reports, row, scale, rate, part, 4, whole)
    fu, fv = force_in_plane(blocks, o, lane, s.B_PULL, laws)
    fu, fv = fu * rate, fv * rate
    put_vec3(manifolds, row, s.PULL, u * fu + v * fv)
    manifolds[row, s.SPIN] = blocks[o + s.B_PULL + 2, lane] * (arm * rate) + px * fv - py * fu
    fu, fv = force_in_plane(blocks, o, lane, s.B_TOTAL_PULL, laws)
    fu, fv = fu * scale, fv * scale
    put_vec3(reports, row, s.TOTAL_PULL, u * fu + v * fv)
    reports[row, s.TOTAL_TWIST] = blocks[o + s.B_TOTAL_PULL + 2, lane] * (arm * scale) + px * fv - py * fu
    c, sn = blocks[o + s.B_TURN, lane], blocks[o + s.B_TURN + 1, lane]
    roll_u, roll_v = blocks[o + s.B_ROLL, lane] * rate, blocks[o + s.B_ROLL + 1, lane] * rate
    manifolds[row, s.ROLL], manifolds[row, s.ROLL + 1] = c * roll_u - sn * roll_v, sn * roll_u + c * roll_v


@jit
def store_point(blocks, o, lane, manifolds, reports, row, scale, rate, part):
    """The same for a point (:mod:`stiction.core.solve.points`)."""
    u, v = tangents_of(blocks, o, lane)
    store_loads(blocks, o, lane, manifolds, reports, row, scale, rate, part, 1, False)
    for k in range(1, 4):
        manifolds[row, s.LOAD + k] = reports[row, s.TOTAL_LOAD + k] = 0.0
    fu, fv = blocks[o + s.B_PULL, lane] * rate, blocks[o + s.B_PULL + 1, lane] * rate
    put_vec3(manifolds, row, s.PULL, u * fu + v * fv)
    fu, fv = blocks[o + s.B_TOTAL_PULL, lane] * scale, blocks[o + s.B_TOTAL_PULL + 1, lane] * scale
    put_vec3(reports, row, s.TOTAL_PULL, u * fu + v * fv)
    manifolds[row, s.SPIN] = reports[row, s.TOTAL_TWIST] = 0.0
    manifolds[row, s.ROLL] = manifolds[row, s.ROLL + 1] = 0.0


@jit
def tangents_of(blocks, o, lane):
    """The directions u and v of one manifold, world."""
    u = Vec3(blocks[o + s.B_TANGENT, lane], blocks[o + s.B_TANGENT + 1, lane], blocks[o + s.B_TANGENT + 2, lane])
    n = Vec3(blocks[o + s.B_NORMAL, lane], blocks[o + s.B_NORMAL + 1, lane], blocks[o + s.B_NORMAL + 2, lane])
    return u, cross(n, u)


@jit
def store_loads(blocks, o, lane, manifolds, reports, row, scale, rate, part, points, whole):
    """What the first ``points`` points of one manifold carry, and how far they are held above where that will have
    them; ``whole``: whether it :func:`lies`."""
    for k in range(points):
        manifolds[row, s.LOAD + k] = blocks[o + s.B_LOAD + k, lane] * rate
        reports[row, s.TOTAL_LOAD + k] = blocks[o + s.B_TOTAL_LOAD + k, lane] * scale
    if manifolds[row, s.FRESH] == s.QUIET:
        for k in range(points):
            reports[row, s.LIFT + k] = blocks[o + s.B_LIFT + k, lane]
            manifolds[row, s.GAP + k] -= blocks[o + s.B_LIFT + k, lane]
    least = FARTHEST
    if whole:
        # by as much at all of its points: a face that is straightened with time, against its load, makes the slow modes
        # of a stack swing up, as an integrator does in a loop without damping
        for k in range(points):
            if reports[row, s.LIFT + k] > 0.0:
                least = min(least, excess(blocks, o, lane, reports, row, k))
    for k in range(points):
        lift = reports[row, s.LIFT + k]
        if lift > 0.0:
            # what a point is lifted by beyond how deep its load has it is taken back slowly
            beyond = min(least, excess(blocks, o, lane, reports, row, k))
            if beyond > LEAST_LIFT:
                reports[row, s.LIFT + k] -= beyond * part
                manifolds[row, s.GAP + k] += beyond * part


@jit
def excess(blocks, o, lane, reports, row, k):
    """By how much point k is lifted beyond the depth at which its spring carries its load, m."""
    depth = blocks[o + s.B_SOFT + k, lane] * blocks[o + s.B_LOAD + k, lane] / blocks[o + s.B_BETA, lane]
    return reports[row, s.LIFT + k] - depth
