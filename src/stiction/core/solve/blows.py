"""Blows: what closes so fast that stopping it is an impulse of this moment, and no force that goes on.

The impulses of a substep act again in the next one, for most of them are loads, which change slowly. A blow does not
act again: if it did, what falls in a row would be thrown up by what had stopped it. Two equal balls, one over the
other, came back with a quarter of their speed, and under a heavy one with almost half of it, though nothing bounces.

One pass answers a blow, and hands it on as another one: the lower ball stops, and the upper one drives it on into the
ground. So passes follow until nothing closes fast any more, over the blocks of bodies that the last one has struck;
each takes energy, as a train of collisions does.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.friction.laws import real_force
from stiction.core.jit import jit
from stiction.core.lanes import LANES, any_of, greatest, load, select, store
from stiction.core.solve.blocks import TINY, push_bodies, put3, put4, vectors_of
from stiction.core.solve.normals import Four, highest, less4
from stiction.core.vec import Vec3

BLOW = 0.1
"""m/s: what closes faster than that, besides what would close its gap in the substep, is a blow."""
MOST_BLOWS = 12
"""Passes that may follow one in which something was struck."""


@jit
def closing_of(v, w, x, y, aim):
    """How fast the fastest point of a face closes beyond what closes its gap, m/s."""
    zero = v.x - v.x
    return highest(
        Four(
            v.x + y.a * w.y - x.a * w.z - greatest(aim.a, zero), v.x + y.b * w.y - x.b * w.z - greatest(aim.b, zero),
            v.x + y.c * w.y - x.c * w.z - greatest(aim.c, zero), v.x + y.d * w.y - x.d * w.z - greatest(aim.d, zero),
        )
    )  # fmt: skip


@jit
def passing(closing, hits, again):
    """The part of an impulse that does not act again, 0 where nothing ``hits``.

    But for passes that follow blows, which come ``again``, what would stop BLOW or less may be a load that sets in; it
    grows together with the closing speed, and becomes less from BLOW on.
    """
    zero = closing - closing
    load_of_it = zero if again else (BLOW * BLOW) / greatest(closing * closing, TINY)
    return select(hits, 1.0 - load_of_it, zero)


@jit
def take_blow(blocks, o, B, aux, index, i, count, once, x, y, lam, change, pull, roll_u, roll_v, rolls, laws):
    """Let the part ``once`` of what came to the normal impulses ``lam`` of faces at (x, y) in a pass not act again, and
    as much of friction as of their load. What a point has let go of is gone. Returns both parts."""
    blow = Four(
        once * greatest(change.a, 0.0), once * greatest(change.b, 0.0), once * greatest(change.c, 0.0),
        once * greatest(change.d, 0.0),
    )  # fmt: skip
    N = blow.a + blow.b + blow.c + blow.d
    share = N / greatest(lam.a + lam.b + lam.c + lam.d, TINY)
    pulled, du, dv = pull * share, roll_u * share, roll_v * share
    put4(blocks, o + s.B_LOAD, less4(lam, blow))
    put3(blocks, o + s.B_PULL, pull - pulled)
    if rolls is not None:
        store(blocks, o + s.B_ROLL, roll_u - du)
        store(blocks, o + s.B_ROLL + 1, roll_v - dv)
    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    f = real_force(blocks, o, pulled, laws)
    torque = Vec3(
        Tm * f.z + px * f.y - py * f.x, y.a * blow.a + y.b * blow.b + y.c * blow.c + y.d * blow.d + du,
        -(x.a * blow.a + x.b * blow.b + x.c * blow.c + x.d * blow.d) + dv,
    )  # fmt: skip
    strike(blocks, o, B, aux, index, i, count, Vec3(N, f.x, f.y), torque)
    return blow, pulled


@jit
def take_blow_at_points(blocks, o, B, aux, index, i, count, once, lam, change, pull):
    """:func:`take_blow` for single points."""
    blow = once * greatest(change, 0.0)
    pulled = pull * (blow / greatest(lam, TINY))
    store(blocks, o + s.B_LOAD, lam - blow)
    put3(blocks, o + s.B_PULL, pull - pulled)
    zero = lam - lam
    strike(blocks, o, B, aux, index, i, count, Vec3(blow, pulled.x, pulled.y), Vec3(zero, zero, zero))
    return blow, pulled


@jit
def strike(blocks, o, B, aux, index, i, count, force, torque):
    """Keep an impulse that bodies were given from acting again: the next substep starts from v' + (v' - v)."""
    va, wa = vectors_of(aux, index, i, s.AUX_OLD_V)
    vb, wb = vectors_of(aux, index, i + count, s.AUX_OLD_V)
    push_bodies(blocks, o, B, aux, index, i, count, va, wa, vb, wb, force, torque, s.AUX_OLD_V)


@jit
def note_struck(i, blocks, index, count, aux, turn):
    """Note the bodies that block i has struck in a pass, by its number, ``turn``."""
    o = first_row(index, i, count)
    if not any_of(is_marked(blocks, o)):
        return
    for lane in range(LANES):
        if blocks[o + s.B_MISS, lane] > 0.5:
            for r in (index[i, lane], index[i + count, lane]):
                if aux[r, s.AUX_MASS] > 0.0:
                    aux[r, s.AUX_STRUCK] = turn


@jit
def mark_struck(i, blocks, index, count, aux, turn):
    """Mark the manifolds of block i of whose bodies one was struck in pass number ``turn`` or the one before it;
    returns whether there are any. What others of the block do must not depend on it."""
    o = first_row(index, i, count)
    found = False
    for lane in range(LANES):
        last = max(aux[index[i, lane], s.AUX_STRUCK], aux[index[i + count, lane], s.AUX_STRUCK])
        struck = last > turn - 1.5
        blocks[o + s.B_MISS, lane] = 1.0 if struck else 0.0
        found |= struck
    return found


@jit
def is_marked(blocks, o):
    """Which manifolds of a block are marked."""
    return load(blocks, o + s.B_MISS) > 0.5


@jit
def any_struck(blocks, index, count):
    """Whether something was struck in the last pass."""
    for i in range(count):
        if any_of(is_marked(blocks, first_row(index, i, count))):
            return True
    return False


@jit
def note_open(blocks, o, like):
    """Nothing was struck."""
    store(blocks, o + s.B_MISS, like - like)
