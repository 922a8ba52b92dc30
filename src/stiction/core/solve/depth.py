"""Penetrations: what is deeper than its load presses in is moved out, and at which depth contacts begin.

A soft contact that is as deep as its load presses it in is at rest. What is deeper has begun so, or was driven there by
what a step does not see. If contact pushed that out as its spring would, bodies would keep the speed: what begins 10 cm
deep in the floor would jump up by 40 cm, and a light body between heavy ones would be thrown. So the solver is not told
of that part of a depth, and after the substeps bodies are moved out of it, and are no faster for it.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.jit import jit
from stiction.core.lanes import LANES, any_of, greatest, least, load, scatter, select, store
from stiction.core.solve.blocks import TINY, frame_of, get4, put4, vectors_of
from stiction.core.solve.normals import Four, highest, lowest
from stiction.core.solve.points import gap_now
from stiction.core.solve.soft import gaps_now
from stiction.core.vec import column, transpose

GENTLE = 0.02
"""m/s: as fast as that, besides what the load presses in, contact may push; the solver is not told of more."""

ROUNDS, RATE = 12, 0.3
"""Rounds over what is too deep, after the last substep, and of its depth, that is dug out in each. What two bodies are
moved apart by drives the lower one into what it lies on, so it takes some."""
FASTEST = 9.0
"""m/s, as fast as that bodies are moved apart; none keeps it."""


@jit
def bury_faces(i, blocks, index, count, exact):
    """Set what is too deep in block i apart, in B_BURIED: the solver finds it less deep by that. ``exact``: whether
    contacts are rigid."""
    o = first_row(index, i, count)
    gap, beta = get4(blocks, o + s.B_GAP), load(blocks, o + s.B_BETA)
    buried = beta - beta
    if any_of(lowest(gap) * beta < -GENTLE):
        buried = highest(all_too_fast(gap, beta, borne_by_faces(blocks, o, exact))) / beta
        put4(blocks, o + s.B_GAP, Four(gap.a + buried, gap.b + buried, gap.c + buried, gap.d + buried))
    store(blocks, o + s.B_BURIED, buried)


@jit
def bury_points(i, blocks, index, count):
    """:func:`bury_faces` for single points."""
    o = first_row(index, i, count)
    gap, beta = load(blocks, o + s.B_GAP), load(blocks, o + s.B_BETA)
    buried = beta - beta
    if any_of(gap * beta < -GENTLE):
        buried = too_fast(gap, beta, borne_by_points(blocks, o)) / beta
        store(blocks, o + s.B_GAP, gap + buried)
    store(blocks, o + s.B_BURIED, buried)


@jit
def is_buried(i, blocks, index, count):
    """Whether something in block i was too deep."""
    return any_of(load(blocks, first_row(index, i, count) + s.B_BURIED) > 0.0)


@jit
def any_buried(blocks, index, count):
    """Whether something was too deep."""
    for i in range(count):
        if is_buried(i, blocks, index, count):
            return True
    return False


@jit
def dig_faces_out(i, blocks, index, count, rows, aux, h, t, exact):
    """Move what was too deep in block i out of it for the time h, from the time t of the step on."""
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    buried, beta = load(blocks, o + s.B_BURIED), load(blocks, o + s.B_BETA)
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    gap = gaps_now(i, blocks, o, index, count, rows, transpose(B), x, y, t)
    gap = Four(gap.a - buried, gap.b - buried, gap.c - buried, gap.d - buried)
    each = all_too_fast(gap, beta, borne_by_faces(blocks, o, exact))
    move_apart(blocks, o, B, rows, aux, index, i, count, way_out(highest(each), buried, beta, h) * h)


@jit
def dig_points_out(i, blocks, index, count, rows, aux, h, t):
    """:func:`dig_faces_out` for single points."""
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    buried, beta = load(blocks, o + s.B_BURIED), load(blocks, o + s.B_BETA)
    gap = gap_now(i, blocks, o, index, count, rows, transpose(B), t) - buried
    way = way_out(too_fast(gap, beta, borne_by_points(blocks, o)), buried, beta, h)
    move_apart(blocks, o, B, rows, aux, index, i, count, way * h)


@jit
def way_out(fast, buried, beta, h):
    """The speed with which bodies are moved apart that contact would push too ``fast``, m/s, where they were buried."""
    return select(buried > 0.0, least(fast / beta * (RATE / h), FASTEST), beta - beta)


@jit
def too_fast(gap, beta, borne):
    """By how much contact would push faster than it may out of a penetration: than GENTLE, and ``borne``, m/s."""
    return greatest(gap * -beta - GENTLE - borne, 0.0)


@jit
def all_too_fast(gap, beta, borne):
    """:func:`too_fast` for four points."""
    return Four(
        too_fast(gap.a, beta, borne.a), too_fast(gap.b, beta, borne.b), too_fast(gap.c, beta, borne.c),
        too_fast(gap.d, beta, borne.d),
    )  # fmt: skip


@jit
def borne_by_points(blocks, o):
    """How fast contact would push out of the depth to which a load presses single points, m/s."""
    return load(blocks, o + s.B_SOFT) * load(blocks, o + s.B_LOAD)


@jit
def borne_by_faces(blocks, o, exact):
    """The same for the points of faces; rigid ones give way by nothing."""
    soft, lam = get4(blocks, o + s.B_SOFT), get4(blocks, o + s.B_LOAD)
    if exact is not None:
        return Four(lam.a - lam.a, lam.b - lam.b, lam.c - lam.c, lam.d - lam.d)
    return Four(soft.a * lam.a, soft.b * lam.b, soft.c * lam.c, soft.d * lam.d)


@jit
def move_apart(blocks, o, B, rows, aux, index, i, count, way):
    """Move the bodies of eight manifolds apart by ``way`` along the normals: where they are, and not how fast.

    They do not turn: a disc that lies deep in another one would be tilted by the point of its rim that is deepest, and
    its other side driven in. Two bodies keep their centre of mass, and the energy of their heights. What is moved out
    of one that stands still gains some, and AUX_LIFTED says how far it went (``core/gains.py``).
    """
    ma, mb = load(blocks, o + s.B_MASS_A), load(blocks, o + s.B_MASS_B)
    d = column(B, 0) * (way / greatest(ma + mb, TINY))
    for side, share in ((i, -ma), (i + count, mb)):
        move, turn = vectors_of(rows, index, side, s.ROW_D)
        move, zero = move + d * share, way - way
        scatter(rows, index, side, s.ROW_D, (move.x, move.y, move.z, zero, turn.x, turn.y, turn.z, zero))
    store(blocks, o + s.B_MISS, way)
    for lane in range(LANES):
        far = blocks[o + s.B_MISS, lane]
        if far > 0.0:
            note_lift(aux, index[i, lane], index[i + count, lane], far)


@jit
def note_lift(aux, a, b, far):
    """Enter how ``far`` a manifold has moved one of its bodies a and b out of the other one, if that is fixed."""
    if aux[a, s.AUX_MASS] == 0.0:
        aux[b, s.AUX_LIFTED] += far
    elif aux[b, s.AUX_MASS] == 0.0:
        aux[a, s.AUX_LIFTED] += far


@jit
def lift_block(i, blocks, index, count):
    """Begin quiet new contacts of block i as deep as their loads will have them in the end, without moving the bodies.

    Else a body that is put down gently would sink and tilt by some micrometres within a few substeps, fast enough to
    break loose on a slope that it should hold on. What is lent here is taken back slowly, and only where the load falls
    below that of the beginning (:func:`stiction.core.solve.results.store_lane`).
    """
    o = first_row(index, i, count)
    quiet = load(blocks, o + s.B_FRESH) > s.NEW
    gap, lam, gamma = get4(blocks, o + s.B_GAP), get4(blocks, o + s.B_LOAD), get4(blocks, o + s.B_SOFT)
    beta = load(blocks, o + s.B_BETA)
    lift = Four(
        lent(gap.a, lam.a, gamma.a, beta, quiet), lent(gap.b, lam.b, gamma.b, beta, quiet),
        lent(gap.c, lam.c, gamma.c, beta, quiet), lent(gap.d, lam.d, gamma.d, beta, quiet),
    )  # fmt: skip
    put4(blocks, o + s.B_LIFT, lift)
    put4(blocks, o + s.B_GAP, Four(gap.a - lift.a, gap.b - lift.b, gap.c - lift.c, gap.d - lift.d))


@jit
def lift_points(i, blocks, index, count):
    """:func:`lift_block` for points."""
    o = first_row(index, i, count)
    quiet = load(blocks, o + s.B_FRESH) > s.NEW
    gap = load(blocks, o + s.B_GAP)
    lift = lent(gap, load(blocks, o + s.B_LOAD), load(blocks, o + s.B_SOFT), load(blocks, o + s.B_BETA), quiet)
    store(blocks, o + s.B_LIFT, lift)
    store(blocks, o + s.B_GAP, gap - lift)


@jit
def lent(gap, lam, gamma, beta, quiet):
    """By how much a point is above the depth -gamma lambda / beta at which its spring carries its load."""
    zero = gap - gap
    return select(quiet & (lam > 0.0), greatest(gap + gamma * lam / beta, zero), zero)
