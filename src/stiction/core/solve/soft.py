"""The default solver: many substeps of one soft pass.

A step is cut into substeps of h. In each, every body gets its velocities, then every manifold is solved once, in blocks
of eight that share no body: its normals as one small complementarity problem, then the friction of its patch as one
element, twice over. Contacts are soft (Catto, "Soft constraints", GDC 2011): a spring and damper so stiff that
omega h = 0.65, which is as stiff as warm starting allows; what sinks in is load / (mass omega^2).

Costs: bodies 1 a substep, manifolds 1 + 1 a substep and two inner sweeps (no cold passes, no relaxation).

Warm starting needs no pass of its own. Arms and inertia are those of the start of the step, so the impulses of the last
substep, applied again, change velocities by as much as they did then: with v the velocity before it and v' after it
(gravity included), the next substep starts from v' + (v' - v).

Rows of bodies say by how much velocities and places differ from those of the start of the step and of going on with
them. What rounding does to them is a part of what changes in a step, and not of how fast the bodies are.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.friction.coulomb import limited_impulse
from stiction.core.friction.laws import follow_slip, real_force, scaled_slip
from stiction.core.friction.patch import Sym3, choose3, inverse_sym, level, slide, times
from stiction.core.jit import jit
from stiction.core.lanes import LANES, all_of, any_of, greatest, least, load, select, size_of, sqrt, store
from stiction.core.solve.blocks import (
    frame_of,
    get3,
    get4,
    get6,
    push_bodies,
    put3,
    put4,
    surface_at,
    twist_now,
    twist_of,
    vectors_of,
)
from stiction.core.solve.blows import BLOW, closing_of, is_marked, note_open, passing, take_blow
from stiction.core.solve.idle import belt_now, stays_open
from stiction.core.solve.normals import Four, Sym4, highest, less4, lowest, non_negative, times4
from stiction.core.vec import Vec3, dot, transpose

SWEEPS = 2
"""Alternations of normals and friction within a manifold, where they are not solved together."""
COLD_PASSES = 8
"""Passes over new manifolds before the first substep: they have nothing to start from, and would break away by the
error that is left."""
MOST_COLD_PASSES, MOST_COLD_WORK, COLD_ENOUGH = 4000, 100_000, 1e-7
"""Where all that is new is quiet, as in a scene that is built at rest, passes go on until the last one has changed no
velocity by more than this, m/s, or so many blocks have been solved (0.2 s): a tower on a slope would slip and lean by
millimetres before its loads are found."""
NOTHING_NEW, SOME_NEW, QUIET_NEW = 0, 1, 2
"""Which manifolds are new in a step: none; some that move; only quiet ones."""
STIFFNESS = 0.65
"""omega h of a contact between two bodies that can move; twice that where one of them cannot."""
DAMPING = 10.0
"""Damping ratio; half of it where one body cannot move. High, so that penetrations fade without a bounce."""
PUSH = 3.0
"""m/s, fastest push out of a penetration (but see ``solve.depth``)."""
PATIENCE = 3.0
"""A manifold that sticks may pull beyond the static limit for so many substeps running before it lets go, ..."""
OVERLOAD = 1.25
"""... but at once if Phi is above this, which is an eighth too much force: loads that have not converged make the
limit a noisy one, though not that noisy."""
GRACE, BEYOND_DOUBT = 1.3, 1.69
"""How far beyond the limit friction may go in a cold pass, and its square."""
ENOUGH = 1e-6
"""m/s, error of the normals that ends the sweeps, ..."""
NEARLY = 0.01
"""... besides this part of what their load does: the next substep goes on from there."""
UNEVEN = 30.0
"""Ratio of masses of two bodies on top of each other from which on a world takes twice the substeps: what the light one
carries sinks by load / (light mass omega^2), and omega h is bounded."""
SETTLING = 1.0
"""s, in which a point that is held above the depth of its load sinks to 1/e of that."""
TOUCHES = 1e-6
"""m, a new contact that is no deeper begins as a rigid one."""
LEAST_LOAD = 1e-6
"""m/s: what a load counts as at least where something is divided by it, in the units of a block."""
NEAR = 1e-4
"""m, a point closer than this carries the load that friction counts on."""


@jit
def softness(h):
    """Push-out rate (1/s) and relative compliance, of contacts between movable bodies and with fixed ones."""
    w, z = STIFFNESS, DAMPING
    w2, z2 = 2.0 * w, 0.5 * z
    return (
        w / (2.0 * z + w) / h, 1.0 / (w * (2.0 * z + w)),
        w2 / (2.0 * z2 + w2) / h, 1.0 / (w2 * (2.0 * z2 + w2)),
    )  # fmt: skip


@jit
def get10(blocks, k):
    """A symmetric matrix of four points."""
    return Sym4(
        load(blocks, k), load(blocks, k + 1), load(blocks, k + 2), load(blocks, k + 3), load(blocks, k + 4),
        load(blocks, k + 5), load(blocks, k + 6), load(blocks, k + 7), load(blocks, k + 8), load(blocks, k + 9),
    )  # fmt: skip


@jit
def choose4(mask, a, b):
    """Of a and b, lane by lane."""
    return Four(select(mask, a.a, b.a), select(mask, a.b, b.b), select(mask, a.c, b.c), select(mask, a.d, b.d))


@jit
def choose10(mask, a, b):
    """Of a and b, lane by lane."""
    return Sym4(
        select(mask, a.aa, b.aa), select(mask, a.ab, b.ab), select(mask, a.ac, b.ac), select(mask, a.ad, b.ad),
        select(mask, a.bb, b.bb), select(mask, a.bc, b.bc), select(mask, a.bd, b.bd), select(mask, a.cc, b.cc),
        select(mask, a.cd, b.cd), select(mask, a.dd, b.dd),
    )  # fmt: skip


@jit
def unit_of(limit, pull):
    """1 / limit; a limit of nearly nothing must not make numbers whose sixth power is out of range."""
    return 1.0 / greatest(limit, 1e-4 * (size_of(pull.x) + size_of(pull.y) + size_of(pull.z)) + 1e-30)


@jit
def warm_block(i, blocks, index, count, rows, aux, laws):
    """Apply the impulses that the manifolds of block i bring along from the step before."""
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    lam = get4(blocks, o + s.B_LOAD)
    pull = get3(blocks, o + s.B_PULL)
    px, py = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1)
    C = transpose(B)
    if laws is not None:
        # the slip that the step before has left: that of now has what forces give in a substep, and no friction yet
        still = Vec3(px - px, px - px, px - px)
        keep_slip(blocks, o, still, still, px, py, laws)
        follow_slip(i, blocks, index, count, rows, aux, 0.0, laws)
    v, w, va, wa, vb, wb = twist_now(i, blocks, o, index, count, rows, C, 0.0)
    keep_slip(blocks, o, v, w, px, py, laws)
    if laws is not None:
        pull = real_force(blocks, o, pull, laws)
        lam = less4(lam, get4(blocks, o + s.B_ATTRACT))
    force = Vec3(lam.a + lam.b + lam.c + lam.d, pull.x, pull.y)
    torque = Vec3(
        pull.z * load(blocks, o + s.B_TORQUE) + px * pull.y - py * pull.x,
        y.a * lam.a + y.b * lam.b + y.c * lam.c + y.d * lam.d + load(blocks, o + s.B_ROLL),
        -(x.a * lam.a + x.b * lam.b + x.c * lam.c + x.d * lam.d) + load(blocks, o + s.B_ROLL + 1),
    )
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)


@jit
def keep_slip(blocks, o, v, w, px, py, laws):
    """Note the slip at the centre of pressure (px, py) of manifolds with velocity v and spin w at the anchor."""
    slip = Vec3(v.y - w.x * py, v.z + w.x * px, w.x * load(blocks, o + s.B_TORQUE))
    put3(blocks, o + s.B_SLIP, scaled_slip(blocks, o, slip + get3(blocks, o + s.B_BELT), laws))


@jit
def gaps_now(i, blocks, o, index, count, rows, C, x, y, t):
    """Separations of the points: those of the start of the step, less what a has come closer in the time t since."""
    da, ta = vectors_of(rows, index, i, s.ROW_D)
    db, tb = vectors_of(rows, index, i + count, s.ROW_D)
    d, turned = twist_of(blocks, o, C, da, ta, db, tb)
    start = get3(blocks, o + s.B_START)
    closing = start.x + load(blocks, o + s.B_WANDER) * (0.5 * t)
    d = Vec3(d.x + closing * t, d.y, d.z)
    turned = Vec3(turned.x, turned.y + start.y * t, turned.z + start.z * t)
    gap = get4(blocks, o + s.B_GAP)
    return Four(
        gap.a - (d.x + y.a * turned.y - x.a * turned.z), gap.b - (d.x + y.b * turned.y - x.b * turned.z),
        gap.c - (d.x + y.c * turned.y - x.c * turned.z), gap.d - (d.x + y.d * turned.y - x.d * turned.z),
    )  # fmt: skip


@jit
def solve_block(i, blocks, index, count, rows, aux, h, t, cold, counts, rolls, laws, exact):
    """One pass over block i in the substep of length h that begins at the time t of the step: normals, then friction,
    twice over.

    In a ``cold`` pass only manifolds that are new take part, and in one that neither is cold nor ``counts`` only those
    that blows strike (:mod:`stiction.core.solve.blows`); both change nothing but the impulses. One that counts ends a
    substep. ``rolls`` is None in worlds without rolling resistance;
    ``laws`` as in :func:`prepare_block`; ``exact`` is None but for the rigid contacts of
    :mod:`stiction.core.solve.exact`, whose state is decided there.
    """
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    C = transpose(B)
    v, w, va, wa, vb, wb = twist_now(i, blocks, o, index, count, rows, C, t + h)

    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    gap = gaps_now(i, blocks, o, index, count, rows, C, x, y, t)
    beta = load(blocks, o + s.B_BETA)
    aim = Four(
        allowed(gap.a, beta, h), allowed(gap.b, beta, h), allowed(gap.c, beta, h), allowed(gap.d, beta, h)
    )  # fmt: skip
    near = lowest(gap) < NEAR
    again = exact is None and not cold and not counts
    if again and not any_of((closing_of(v, w, x, y, aim) > BLOW) & is_marked(blocks, o)):
        note_open(blocks, o, beta)
        return
    if exact is None and laws is None and stays_open(blocks, o, v, w, x, y, aim, near, h, cold, counts, rolls):
        return

    Kvv, Kww = get6(blocks, o + s.B_KVV), get6(blocks, o + s.B_KWW)
    k1, k2, k3 = get3(blocks, o + s.B_KWV), get3(blocks, o + s.B_KWV + 3), get3(blocks, o + s.B_KWV + 6)
    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    F, Fi = get6(blocks, o + s.B_FRICTION), get6(blocks, o + s.B_FRICTION_INVERSE)
    surface = surface_at(blocks, o)
    mu_s, mu_d = load(blocks, o + s.B_MU_S), load(blocks, o + s.B_MU_D)
    if exact is None:
        mu_d = dynamic_now(blocks, o, mu_d)
    rigid, left0 = load(blocks, o + s.B_RIGID), load(blocks, o + s.B_LEFT)
    belt = belt_now(blocks, o, h)
    lam0, pull0 = get4(blocks, o + s.B_LOAD), get3(blocks, o + s.B_PULL)
    roll_u0, roll_v0 = load(blocks, o + s.B_ROLL), load(blocks, o + s.B_ROLL + 1)
    lam, pull, roll_u, roll_v, left = lam0, pull0, roll_u0, roll_v0, left0
    gamma = get4(blocks, o + s.B_SOFT)
    zero = left0 - left0
    # a gap is closed by a rigid contact, for what a soft one leaves would become a penetration; and a new contact that
    # touches gets the load that it will have in the end, to which it is lifted (lift_block)
    rigid_from = (-TOUCHES if cold else 0.0) if exact is None else -1e30
    gamma = Four(
        select(gap.a > rigid_from, zero, gamma.a), select(gap.b > rigid_from, zero, gamma.b),
        select(gap.c > rigid_from, zero, gamma.c), select(gap.d > rigid_from, zero, gamma.d),
    )  # fmt: skip
    sliding = load(blocks, o + s.B_STATE) > 0.5
    going = load(blocks, o + s.B_FRESH) > 0.5
    hits = going
    if exact is None:
        closing = closing_of(v, w, x, y, aim)
        hits = closing > BLOW
    if again:
        going = hits & is_marked(blocks, o)
    elif not cold:
        going = going | ~going
    hits = hits & going
    inside, excess = sliding, zero

    # Where friction can stick, the normals are told so: what they do to the slip will be answered by friction, and what
    # that does to them is in the inverse already. So one sweep solves both; elsewhere they alternate.
    slip = scaled_slip(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt, laws)
    limit = mu_s * (lam.a + lam.b + lam.c + lam.d)
    if laws is not None:
        # a tyre gives way: slip = alpha pull / N is what a solved one has left
        alpha = load(blocks, o + s.B_ALPHA)
        yields = alpha > 0.0
        if any_of(yields):
            alpha = alpha / greatest(lam.a + lam.b + lam.c + lam.d, LEAST_LOAD)
            Fi = inverse_sym(Sym3(F.xx + alpha, F.xy, F.xz, F.yy + alpha, F.yz, F.zz + alpha))
            slip = slip - pull * alpha
    answer = times(Fi, slip)
    stick = pull + answer
    if exact is None:
        together = (dot(stick, stick) <= BEYOND_DOUBT * limit * limit) & ~sliding
    else:
        # what is solved so must stick in the end, else passes would come to rest where nothing is solved
        together = (level(stick * unit_of(limit, stick), surface) <= 1.0) & ~sliding
    if laws is not None:
        together = together & ~yields
    inverse = get10(blocks, o + s.B_INVERSE_STUCK)
    if not all_of(together):
        inverse = choose10(together, inverse, get10(blocks, o + s.B_INVERSE))
    expected = real_force(blocks, o, answer, laws) * select(together, zero + 1.0, zero)
    for sweep in range(SWEEPS):
        if sweep > 0:
            going = going & ~together
            if not any_of(going):
                break
        # normals: aim at a closing speed, less where the contact gives way
        turning = Tm * expected.z + px * expected.y - py * expected.x
        cn = v.x - (Kvv.xy * expected.x + Kvv.xz * expected.y + k1.x * turning)
        wu = w.y - (k2.y * expected.x + k2.z * expected.y + Kww.xy * turning)
        wv = w.z - (k3.y * expected.x + k3.z * expected.y + Kww.xz * turning)
        error = Four(
            cn + y.a * wu - x.a * wv - aim.a - gamma.a * lam.a, cn + y.b * wu - x.b * wv - aim.b - gamma.b * lam.b,
            cn + y.c * wu - x.c * wv - aim.c - gamma.c * lam.c, cn + y.d * wu - x.d * wv - aim.d - gamma.d * lam.d,
        )  # fmt: skip
        if sweep > 0:
            # which lanes go on must not depend on what else is in their block: the others are masked
            enough = ENOUGH + NEARLY * Kvv.xx * (lam.a + lam.b + lam.c + lam.d)
            going = going & (has_error(error.a, lam.a, enough) | has_error(error.b, lam.b, enough)
                             | has_error(error.c, lam.c, enough) | has_error(error.d, lam.d, enough))  # fmt: skip
            if not any_of(going):
                break
        wanted = times4(inverse, error)
        new = Four(lam.a + wanted.a, lam.b + wanted.b, lam.c + wanted.c, lam.d + wanted.d)
        if any_of(lowest(new) < 0.0):
            new = non_negative(new, inverse)
        if cold or again or sweep > 0:
            new = choose4(going, new, lam)
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

        # friction
        slip = scaled_slip(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt, laws)
        answer = times(Fi, slip) if laws is None else times(Fi, slip - pull * alpha)
        stick = pull + answer
        answer = real_force(blocks, o, answer, laws)
        # its load is that of a rigid contact, which would have stopped the closing that the soft one lets grow
        turning = Tm * answer.z + px * answer.y - py * answer.x
        stuck_left = v.x - (Kvv.xy * answer.x + Kvv.xz * answer.y + k1.x * turning)
        now = select(sliding, v.x, stuck_left) + py * w.y - px * w.z
        left = select(going, now, left) if sweep > 0 else now
        N = lam.a + lam.b + lam.c + lam.d
        if exact is None:
            N = select(near, greatest(N + (left - left0) * rigid, 0.0), N)
        over = level(stick * unit_of(select(sliding, mu_d, mu_s) * N, stick), surface)
        excess = select(going, over, excess) if sweep > 0 else over
        grace = (BEYOND_DOUBT if cold else OVERLOAD) if exact is None else 1.0
        inside = excess <= select(sliding, zero + 1.0, zero + grace)
        if not all_of(inside):
            # in a cold pass nothing lets go; it may only not pull harder than it ever could
            if exact is None and not cold:
                sliding = sliding | (going & ~inside)
            limit = select(sliding, mu_d, mu_s * (GRACE if exact is None else 1.0)) * N
            # without a load there is no friction, and no g
            slides = ~inside & (limit > 0.0)
            free = choose3(inside, stick, pull - pull)
            if any_of(slides):
                unit = unit_of(limit, stick)
                # the problem divided by the limit: A = F, so numbers stay near one whatever the masses
                g = slide(F, (slip + times(F, pull)) * unit, pull * unit, surface, slides)
                free = choose3(slides, g * limit, free)
            stick = free
        if cold or again or sweep > 0:
            stick = choose3(going, stick, pull)
        df = real_force(blocks, o, stick - pull, laws)
        Tn = Tm * df.z + px * df.y - py * df.x
        v = Vec3(
            v.x - (Kvv.xy * df.x + Kvv.xz * df.y + k1.x * Tn), v.y - (Kvv.yy * df.x + Kvv.yz * df.y + k1.y * Tn),
            v.z - (Kvv.yz * df.x + Kvv.zz * df.y + k1.z * Tn),
        )  # fmt: skip
        w = Vec3(
            w.x - (k1.y * df.x + k1.z * df.y + Kww.xx * Tn), w.y - (k2.y * df.x + k2.z * df.y + Kww.xy * Tn),
            w.z - (k3.y * df.x + k3.z * df.y + Kww.xz * Tn),
        )  # fmt: skip
        pull = stick
        expected = expected * zero
        if rolls is not None:
            rolling_limit = (lam.a + lam.b + lam.c + lam.d) * load(blocks, o + s.B_ROLLING)
            bu, bv = w.y + Kww.yy * roll_u + Kww.yz * roll_v, w.z + Kww.yz * roll_u + Kww.zz * roll_v
            mu_u, mu_v = limited_impulse(Kww.yy, Kww.yz, Kww.zz, bu, bv, rolling_limit)
            if cold or again or sweep > 0:
                mu_u, mu_v = select(going, mu_u, roll_u), select(going, mu_v, roll_v)
            du, dv = mu_u - roll_u, mu_v - roll_v
            v = Vec3(v.x - (k2.x * du + k3.x * dv), v.y - (k2.y * du + k3.y * dv), v.z - (k2.z * du + k3.z * dv))
            w = Vec3(
                w.x - (Kww.xy * du + Kww.xz * dv), w.y - (Kww.yy * du + Kww.yz * dv), w.z - (Kww.yz * du + Kww.zz * dv)
            )  # fmt: skip
            roll_u, roll_v = mu_u, mu_v

    da, db, dc, dd = lam.a - lam0.a, lam.b - lam0.b, lam.c - lam0.c, lam.d - lam0.d
    df = real_force(blocks, o, pull - pull0, laws)
    force = Vec3(da + db + dc + dd, df.x, df.y)
    torque = Vec3(
        Tm * df.z + px * df.y - py * df.x,
        y.a * da + y.b * db + y.c * dc + y.d * dd + (roll_u - roll_u0),
        -(x.a * da + x.b * db + x.c * dc + x.d * dd) + (roll_v - roll_v0),
    )
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)

    put4(blocks, o + s.B_LOAD, lam)
    put3(blocks, o + s.B_PULL, pull)
    if cold:
        moved = highest(
            Four(size_of(lam.a - lam0.a), size_of(lam.b - lam0.b), size_of(lam.c - lam0.c), size_of(lam.d - lam0.d))
        )
        change = times(F, pull - pull0)
        store(blocks, o + s.B_MISS, greatest(moved / rigid, greatest(size_of(change.x), size_of(change.y))))
    if rolls is not None:
        store(blocks, o + s.B_ROLL, roll_u)
        store(blocks, o + s.B_ROLL + 1, roll_v)
        if counts:
            rolled = load(blocks, o + s.B_ROLLED) + (roll_u * w.y + roll_v * w.z)
            store(blocks, o + s.B_ROLLED, rolled)
    if exact is not None:
        store(blocks, o + s.B_OVER, excess)
    elif any_of(hits):
        once = passing(closing, hits, again)
        blow, pulled = take_blow(
            blocks, o, B, aux, index, i, count, once, x, y, lam, Four(da, db, dc, dd), pull, roll_u, roll_v, rolls, laws
        )
        if not counts:
            # what goes on is in the sums of the next pass that counts; after a cold pass so is what was before
            net, drawn = (blow, pulled) if cold else (Four(da, db, dc, dd), pull - pull0)
            slip = scaled_slip(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt, laws)
            keep_sums(blocks, o, net, drawn, slip, sliding)
    if exact is None and not cold:
        store(blocks, o + s.B_MISS, select(hits, zero + 1.0, zero))
    if counts:
        put3(blocks, o + s.B_BELT, belt)
        store(blocks, o + s.B_LEFT, select(near, left, 0.0))
        if exact is None:
            decide_state(blocks, o, sliding, inside, excess)
        slip = scaled_slip(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt, laws)
        slides = sliding if exact is None else sliding | ~sliding
        if laws is None:
            keep_sums(blocks, o, lam, pull, slip, slides)
        else:
            keep_sums(blocks, o, less4(lam, get4(blocks, o + s.B_ATTRACT)), pull, slip, slides | yields)
            follow_slip(i, blocks, index, count, rows, aux, 1.0, laws)


@jit
def has_error(error, lam, enough):
    """Whether a point closes too fast, or carries a load and does not close as it should."""
    return (error > enough) | ((error < -enough) & (lam > 0.0))


@jit
def allowed(gap, beta, h):
    """Closing speed that is aimed at: over a gap what closes it in a substep, in a penetration a push out of it."""
    return select(gap > 0.0, gap * (1.0 / h), greatest(gap * beta, -PUSH))


@jit
def decide_state(blocks, o, sliding, inside, excess):
    """Stuck or sliding, from the whole patch: stuck until force and torque together exceed the static limit surface for
    a few substeps running, sliding until the dynamic one would not be reached.

    A patch that lets go has been held for these substeps too long. What was held beyond the dynamic limit, in units of
    its load, is owed to it as a negative OVER, and given back by :func:`dynamic_now` in as few substeps as it takes.
    """
    before = load(blocks, o + s.B_OVER)
    zero = before - before
    over = select(excess > 1.0, greatest(before, zero) + 1.0, zero)
    state = select(sliding, select(inside, zero, zero + 1.0), select(over >= PATIENCE, zero + 1.0, zero))
    mu_s, mu_d = load(blocks, o + s.B_MU_S), load(blocks, o + s.B_MU_D)
    held = select(sliding, greatest(before, zero), over)
    debt = held * greatest(sqrt(least(excess, OVERLOAD)) * mu_s - mu_d, zero)
    owed = select(sliding & (before <= 0.0), least(before + mu_d, zero), -debt)
    store(blocks, o + s.B_STATE, state)
    store(blocks, o + s.B_OVER, select(state > 0.5, owed, over))


@jit
def dynamic_now(blocks, o, mu_d):
    """The dynamic coefficient, less what is owed."""
    return greatest(mu_d + least(load(blocks, o + s.B_OVER), 0.0), 0.0)


@jit
def keep_sums(blocks, o, net, pull, slip, sliding):
    """Impulses of the step so far, ``net`` along the normals, and what friction took where it slides: its impulse times
    the mean slip."""
    total = get4(blocks, o + s.B_TOTAL_LOAD)
    put4(blocks, o + s.B_TOTAL_LOAD, Four(total.a + net.a, total.b + net.b, total.c + net.c, total.d + net.d))
    keep_friction(blocks, o, pull, slip, sliding)


@jit
def keep_friction(blocks, o, pull, slip, sliding):
    """The part of :func:`keep_sums` that is friction's."""
    put3(blocks, o + s.B_TOTAL_PULL, get3(blocks, o + s.B_TOTAL_PULL) + pull)
    before = get3(blocks, o + s.B_SLIP)
    work = load(blocks, o + s.B_WORK)
    store(blocks, o + s.B_WORK, select(sliding, work + dot(pull, before + slip) * 0.5, work))
    put3(blocks, o + s.B_SLIP, slip)


@jit
def last_change(blocks, index, count):
    """By how much the last cold pass has changed a velocity at most, m/s."""
    worst = 0.0
    for i in range(count):
        if has_fresh(i, blocks, index, count):
            o = first_row(index, i, count)
            for lane in range(LANES):
                if blocks[o + s.B_FRESH, lane] > s.OLD:
                    worst = max(worst, blocks[o + s.B_MISS, lane])
    return worst


@jit
def has_fresh(i, blocks, index, count):
    """Whether a manifold of block i is new in this step."""
    return any_of(load(blocks, first_row(index, i, count) + s.B_FRESH) > 0.5)
