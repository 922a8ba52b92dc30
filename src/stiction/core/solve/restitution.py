"""Bounces, after the substeps of a step: points that closed fast and were stopped get part of that speed back.

Newton's law with the closing speed just before the point was first loaded, as Catto's Box2D does it at the
end of a step, but the bounce brings friction along, limited by its own normal impulse, so that a ball's spin changes as it should.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.friction.patch import Surface, level, slide, times
from stiction.core.jit import jit
from stiction.core.lanes import all_of, any_of, gather, greatest, load, select, size_of, store
from stiction.core.solve.blocks import get3, get4, get6, put3, put4
from stiction.core.solve.normals import Four, Sym4, non_negative, times4
from stiction.core.solve.soft import frame_of, push_bodies, twist_of
from stiction.core.vec import Vec3, transpose

REFINEMENTS = 5
"""Newton steps with the softened inverse of the normals; each leaves 4 % of the error before it."""


@jit
def bounce_block(i, blocks, index, count, rows, threshold):
    """Let the points of block i that closed faster than ``threshold`` (m/s) bounce."""
    o = i * s.FIELDS
    e = load(blocks, o + s.B_RESTITUTION)
    closing, most = get4(blocks, o + s.B_CLOSING), get4(blocks, o + s.B_MOST)
    zero = e - e
    on = Four(
        _bounces(e, closing.a, most.a, threshold), _bounces(e, closing.b, most.b, threshold),
        _bounces(e, closing.c, most.c, threshold), _bounces(e, closing.d, most.d, threshold),
    )  # fmt: skip
    if not any_of((on.a + on.b + on.c + on.d) > 0.5):
        return
    B = frame_of(blocks, o)
    a, b = gather(rows, index, i, s.ROW_V), gather(rows, index, i + count, s.ROW_V)
    va, wa = Vec3(a[0], a[1], a[2]), Vec3(a[4], a[5], a[6])
    vb, wb = Vec3(b[0], b[1], b[2]), Vec3(b[4], b[5], b[6])
    v, w = twist_of(blocks, o, transpose(B), va, wa, vb, wb)
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    Kvv, Kww = get6(blocks, o + s.B_KVV), get6(blocks, o + s.B_KWW)
    k1, k2, k3 = get3(blocks, o + s.B_KWV), get3(blocks, o + s.B_KWV + 3), get3(blocks, o + s.B_KWV + 6)
    inverse = Sym4(
        load(blocks, o + s.B_INVERSE), load(blocks, o + s.B_INVERSE + 1), load(blocks, o + s.B_INVERSE + 2),
        load(blocks, o + s.B_INVERSE + 3), load(blocks, o + s.B_INVERSE + 4), load(blocks, o + s.B_INVERSE + 5),
        load(blocks, o + s.B_INVERSE + 6), load(blocks, o + s.B_INVERSE + 7), load(blocks, o + s.B_INVERSE + 8),
        load(blocks, o + s.B_INVERSE + 9),
    )  # fmt: skip
    lam = Four(zero, zero, zero, zero)
    for _ in range(REFINEMENTS):
        wanted = times4(
            inverse,
            Four(
                (v.x + y.a * w.y - x.a * w.z + e * closing.a) * on.a,
                (v.x + y.b * w.y - x.b * w.z + e * closing.b) * on.b,
                (v.x + y.c * w.y - x.c * w.z + e * closing.c) * on.c,
                (v.x + y.d * w.y - x.d * w.z + e * closing.d) * on.d,
            ),
        )  # fmt: skip
        new = Four(
            (lam.a + wanted.a) * on.a, (lam.b + wanted.b) * on.b, (lam.c + wanted.c) * on.c, (lam.d + wanted.d) * on.d
        )  # fmt: skip
        new = non_negative(new, inverse)
        da, db, dc, dd = new.a - lam.a, new.b - lam.b, new.c - lam.c, new.d - lam.d
        N = da + db + dc + dd
        Tu = y.a * da + y.b * db + y.c * dc + y.d * dd
        Tv = -(x.a * da + x.b * db + x.c * dc + x.d * dd)
        v = Vec3(
            v.x - (Kvv.xx * N + k2.x * Tu + k3.x * Tv), v.y - (Kvv.xy * N + k2.y * Tu + k3.y * Tv),
            v.z - (Kvv.xz * N + k2.z * Tu + k3.z * Tv),
        )  # fmt: skip
        w = Vec3(
            w.x - (k1.x * N + Kww.xy * Tu + Kww.xz * Tv), w.y - (k2.x * N + Kww.yy * Tu + Kww.yz * Tv),
            w.z - (k3.x * N + Kww.yz * Tu + Kww.zz * Tv),
        )  # fmt: skip
        lam = new

    # friction of the bounce
    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    F, Fi = get6(blocks, o + s.B_FRICTION), get6(blocks, o + s.B_FRICTION_INVERSE)
    surface = Surface(
        load(blocks, o + s.B_SURFACE), load(blocks, o + s.B_SURFACE + 1), load(blocks, o + s.B_SURFACE + 2),
        load(blocks, o + s.B_SURFACE + 3),
    )  # fmt: skip
    N = lam.a + lam.b + lam.c + lam.d
    limit = select(load(blocks, o + s.B_STATE) > 0.5, load(blocks, o + s.B_MU_D), load(blocks, o + s.B_MU_S)) * N
    slip = Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + get3(blocks, o + s.B_BELT)
    pull = times(Fi, slip)
    unit = 1.0 / greatest(limit, 1e-4 * (size_of(pull.x) + size_of(pull.y) + size_of(pull.z)) + 1e-30)
    g = pull * unit
    inside = level(g, surface) <= 1.0
    if not all_of(inside):
        g = slide(F, slip * unit, get3(blocks, o + s.B_PULL) * unit, surface)
        pull = Vec3(
            select(inside, pull.x, g.x * limit), select(inside, pull.y, g.y * limit), select(inside, pull.z, g.z * limit)
        )  # fmt: skip
    touched = N > 0.0
    pull = Vec3(select(touched, pull.x, zero), select(touched, pull.y, zero), select(touched, pull.z, zero))

    put4(blocks, o + s.B_TOTAL_LOAD, _sum(get4(blocks, o + s.B_TOTAL_LOAD), lam))
    put3(blocks, o + s.B_TOTAL_PULL, get3(blocks, o + s.B_TOTAL_PULL) + pull)
    store(blocks, o + s.B_WORK, load(blocks, o + s.B_WORK) + 0.5 * (pull.x * slip.x + pull.y * slip.y + pull.z * slip.z))
    force = Vec3(N, pull.x, pull.y)
    torque = Vec3(
        Tm * pull.z + px * pull.y - py * pull.x,
        y.a * lam.a + y.b * lam.b + y.c * lam.c + y.d * lam.d,
        -(x.a * lam.a + x.b * lam.b + x.c * lam.c + x.d * lam.d),
    )
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)


@jit
def _bounces(e, closing, most, threshold):
    """1 for a point that closed fast enough and was loaded, else 0."""
    zero = e - e
    return select((e > 0.0) & (closing > threshold) & (most > 0.0), zero + 1.0, zero)


@jit
def _sum(p, q):
    return Four(p.a + q.a, p.b + q.b, p.c + q.c, p.d + q.d)
