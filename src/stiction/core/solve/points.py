"""Blocks of single points that resist neither spinning nor rolling: three directions instead of six.

A point has no extent. All that it does is a force at the anchor, so of the manifold's matrix only K_vv is left, of the
matrix of the normals one number, and of the limit surface Coulomb's circle. A pass is that of ``solve.soft`` and a step
that of ``solve.blocks``, with x = y = 0 and T_m = 0; what is said there about why holds here too. It costs a third of
one over faces, and three quarters of the manifolds of a heap are points.

A manifold is solved here or there by what it is itself (``colouring.way_of``), whoever is beside it.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.friction.coulomb import limited_impulse
from stiction.core.jit import jit
from stiction.core.lanes import all_of, any_of, gather, greatest, least, load, select, size_of, splat, sqrt, store
from stiction.core.solve.blocks import (
    TINY,
    bodies_of,
    frame_of,
    get3,
    get6,
    patch_matrix,
    push_bodies,
    put3,
    put_bodies,
    start_twist,
    twist_now,
    twist_of,
    vectors_of,
)
from stiction.core.solve.blows import BLOW, is_marked, note_open, passing, take_blow_at_points
from stiction.core.solve.idle import belt_now, keeps_state, leave_open
from stiction.core.solve.soft import (
    BEYOND_DOUBT,
    ENOUGH,
    GRACE,
    NEAR,
    NEARLY,
    OVERLOAD,
    SWEEPS,
    TOUCHES,
    allowed,
    decide_state,
    dynamic_now,
    has_error,
    keep_friction,
    unit_of,
)
from stiction.core.vec import Vec3, columns, cross, dot, transpose


@jit
def prepare_points(i, blocks, index, count, manifolds, aux, h, dt, beta, soft, beta_stiff, soft_stiff):
    """Fill block i, as :func:`stiction.core.solve.blocks.prepare_block` does for faces."""
    o = first_row(index, i, count)
    rows = i + 2 * count
    Ra, ma, Ia, _, mb, Ib, scale = bodies_of(i, blocks, index, count, aux)
    ga = gather(manifolds, index, rows, s.NORMAL_A)
    gb = gather(manifolds, index, rows, s.NORMAL_B)
    gl = gather(manifolds, index, rows, s.GAP)
    gf = gather(manifolds, index, rows, s.PULL)
    gm = gather(manifolds, index, rows, s.EVEN)
    gx = gather(manifolds, index, rows, s.SHIFT)
    gy = gather(manifolds, index, rows, s.ARM_B)

    h_scale = h / scale
    zero, one = splat(blocks, 0.0), splat(blocks, 1.0)
    here = select(gm[6] > 0.5, one, zero)

    n, u = Ra @ Vec3(ga[0], ga[1], ga[2]), Ra @ Vec3(ga[3], ga[4], ga[5])
    v = cross(n, u)
    B = columns(n, u, v)
    C = transpose(B)
    ra, rb = C @ Vec3(gx[3], gx[4], gx[5]), C @ Vec3(gy[0], gy[1], gy[2])
    Ia, Ib = C @ Ia @ B, C @ Ib @ B
    Ka, _ = patch_matrix(ma, Ia, ra)
    Kb, _ = patch_matrix(mb, Ib, rb)
    K = Ka + Kb
    put3(blocks, o + s.B_NORMAL, n)
    put3(blocks, o + s.B_TANGENT, u)
    put_bodies(blocks, o, ra, rb, ma, mb, Ia, Ib, K)

    # where nobody moves, as in a lane that is left over, K is zero
    nobody = select(K.xx > 0.0, zero, one)
    fixed = least(ma, mb) <= 0.0
    gamma = (K.xx + nobody) * select(fixed, soft_stiff, one * soft)
    uu, vv = K.yy + nobody, K.zz + nobody
    over = 1.0 / (uu * vv - K.yz * K.yz)
    iuu, iuv, ivv = vv * over, -K.yz * over, uu * over
    answered = K.xy * (K.xy * iuu + K.xz * iuv) + K.xz * (K.xy * iuv + K.xz * ivv)
    store(blocks, o + s.B_SOFT, gamma)
    store(blocks, o + s.B_INVERSE, here / (K.xx + nobody + gamma))
    store(blocks, o + s.B_INVERSE_STUCK, here / (K.xx + nobody - answered + gamma))
    put3(blocks, o + s.B_FRICTION_INVERSE, Vec3(iuu, iuv, ivv))
    store(blocks, o + s.B_BETA, select(fixed, beta_stiff, one * beta))
    store(blocks, o + s.B_RIGID, 1.0 / greatest(K.xx, TINY))

    store(blocks, o + s.B_MU_S, ga[6])
    store(blocks, o + s.B_MU_D, ga[7])
    store(blocks, o + s.B_STATE, gb[6])
    store(blocks, o + s.B_OVER, gb[7])
    store(blocks, o + s.B_FRESH, gm[7])
    store(blocks, o + s.B_LEFT, gy[7])
    store(blocks, o + s.B_GAP, gl[0] + dot(n, Vec3(gx[0], gx[1], gx[2])))
    store(blocks, o + s.B_LOAD, gl[4] * here * h_scale)
    pull = Vec3(gf[0], gf[1], gf[2]) * h_scale
    put3(blocks, o + s.B_PULL, Vec3(dot(pull, u), dot(pull, v), zero))
    belt = Vec3(gy[3], gy[4], gy[5])
    v0, _ = start_twist(blocks, o, index, i, count, aux, C)
    early = dot(belt, n)
    put3(blocks, o + s.B_START, Vec3(v0.x + early, zero, zero))
    store(blocks, o + s.B_WANDER, early * (-2.0 / dt))
    put3(blocks, o + s.B_BELT, Vec3(dot(belt, u) + v0.y, dot(belt, v) + v0.z, zero))
    store(blocks, o + s.B_DRIFT, gf[6])
    store(blocks, o + s.B_DRIFT + 1, gy[6])
    store(blocks, o + s.B_TOTAL_LOAD, zero)
    put3(blocks, o + s.B_TOTAL_PULL, Vec3(zero, zero, zero))
    store(blocks, o + s.B_WORK, zero)
    store(blocks, o + s.B_LIFT, zero)


@jit
def gap_now(i, blocks, o, index, count, rows, C, t):
    """Separation of the points: that of the start of the step, less what a has come closer in the time t since."""
    da, ta = vectors_of(rows, index, i, s.ROW_D)
    db, tb = vectors_of(rows, index, i + count, s.ROW_D)
    d, _ = twist_of(blocks, o, C, da, ta, db, tb)
    closing = load(blocks, o + s.B_START) + load(blocks, o + s.B_WANDER) * (0.5 * t)
    return load(blocks, o + s.B_GAP) - (d.x + closing * t)


@jit
def warm_points(i, blocks, index, count, rows):
    """Apply the impulses that the points of block i bring along from the step before."""
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    v, _, va, wa, vb, wb = twist_now(i, blocks, o, index, count, rows, transpose(B), 0.0)
    pull, belt = get3(blocks, o + s.B_PULL), get3(blocks, o + s.B_BELT)
    zero = v.x - v.x
    put3(blocks, o + s.B_SLIP, Vec3(v.y + belt.x, v.z + belt.y, zero))
    force, torque = Vec3(load(blocks, o + s.B_LOAD), pull.x, pull.y), Vec3(zero, zero, zero)
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)


@jit
def solve_points(i, blocks, index, count, rows, aux, h, t, cold, counts):
    """One pass over block i, as :func:`stiction.core.solve.soft.solve_block` does it for faces."""
    o = first_row(index, i, count)
    B = frame_of(blocks, o)
    C = transpose(B)
    v, _, va, wa, vb, wb = twist_now(i, blocks, o, index, count, rows, C, t + h)
    gap = gap_now(i, blocks, o, index, count, rows, C, t)
    aim = allowed(gap, load(blocks, o + s.B_BETA), h)
    near = gap < NEAR
    closing = v.x - greatest(aim, gap - gap)
    hits = closing > BLOW
    again = not cold and not counts
    if again:
        hits = hits & is_marked(blocks, o)
        if not any_of(hits):
            note_open(blocks, o, gap)
            return
    if points_stay_open(blocks, o, v, aim, near, h, cold, counts):
        return

    K = get6(blocks, o + s.B_KVV)
    inverse = get3(blocks, o + s.B_FRICTION_INVERSE)
    mu_s, mu_d = load(blocks, o + s.B_MU_S), dynamic_now(blocks, o, load(blocks, o + s.B_MU_D))
    rigid, left0 = load(blocks, o + s.B_RIGID), load(blocks, o + s.B_LEFT)
    belt = belt_now(blocks, o, h)
    lam0, pull0 = load(blocks, o + s.B_LOAD), get3(blocks, o + s.B_PULL)
    zero = left0 - left0
    lam, pull, left = lam0, Vec3(pull0.x, pull0.y, zero), left0
    gamma = select(gap > (-TOUCHES if cold else 0.0), zero, load(blocks, o + s.B_SOFT))
    sliding = load(blocks, o + s.B_STATE) > 0.5
    going = load(blocks, o + s.B_FRESH) > 0.5
    if again:
        going = hits
    elif not cold:
        going = going | ~going
    hits = hits & going
    inside, excess = sliding, zero

    answer = _answer(inverse, v, belt)
    stick = pull + answer
    limit = mu_s * lam
    together = (dot(stick, stick) <= BEYOND_DOUBT * limit * limit) & ~sliding
    normal = select(together, load(blocks, o + s.B_INVERSE_STUCK), load(blocks, o + s.B_INVERSE))
    expected = answer * select(together, zero + 1.0, zero)
    for sweep in range(SWEEPS):
        if sweep > 0:
            going = going & ~together
            if not any_of(going):
                break
        # normals
        error = v.x - (K.xy * expected.x + K.xz * expected.y) - aim - gamma * lam
        if sweep > 0:
            going = going & has_error(error, lam, ENOUGH + NEARLY * K.xx * lam)
            if not any_of(going):
                break
        new = greatest(lam + normal * error, 0.0)
        if cold or again or sweep > 0:
            new = select(going, new, lam)
        N = new - lam
        v = Vec3(v.x - K.xx * N, v.y - K.xy * N, v.z - K.xz * N)
        lam = new

        # friction
        answer = _answer(inverse, v, belt)
        stick = pull + answer
        now = select(sliding, v.x, v.x - (K.xy * answer.x + K.xz * answer.y))
        left = select(going, now, left) if sweep > 0 else now
        N = select(near, greatest(lam + (left - left0) * rigid, 0.0), lam)
        unit = unit_of(select(sliding, mu_d, mu_s) * N, stick)
        over = dot(stick, stick) * unit * unit
        excess = select(going, over, excess) if sweep > 0 else over
        inside = excess <= select(sliding, zero + 1.0, zero + (BEYOND_DOUBT if cold else OVERLOAD))
        if not all_of(inside):
            if not cold:
                sliding = sliding | (going & ~inside)
            limit = select(sliding, mu_d, mu_s * GRACE) * N
            slides = ~inside & (limit > 0.0)
            free = stick * select(inside, zero + 1.0, zero)
            if any_of(slides):
                fu, fv = _limited(K, v, belt, pull, limit)
                free = Vec3(select(slides, fu, free.x), select(slides, fv, free.y), zero)
            stick = free
        if cold or again or sweep > 0:
            stick = Vec3(select(going, stick.x, pull.x), select(going, stick.y, pull.y), zero)
        du, dv = stick.x - pull.x, stick.y - pull.y
        v = Vec3(v.x - (K.xy * du + K.xz * dv), v.y - (K.yy * du + K.yz * dv), v.z - (K.yz * du + K.zz * dv))
        pull = stick
        expected = expected * zero

    du, dv = pull.x - pull0.x, pull.y - pull0.y
    force, torque = Vec3(lam - lam0, du, dv), Vec3(zero, zero, zero)
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)

    store(blocks, o + s.B_LOAD, lam)
    put3(blocks, o + s.B_PULL, pull)
    if any_of(hits):
        once = passing(closing, hits, again)
        blow, pulled = take_blow_at_points(blocks, o, B, aux, index, i, count, once, lam, force.x, pull)
        if not counts:
            net, drawn = (blow, pulled) if cold else (force.x, Vec3(du, dv, zero))
            store(blocks, o + s.B_TOTAL_LOAD, load(blocks, o + s.B_TOTAL_LOAD) + net)
            keep_friction(blocks, o, drawn, Vec3(v.y + belt.x, v.z + belt.y, zero), sliding)
    if cold:
        change = greatest(size_of(K.yy * du + K.yz * dv), size_of(K.yz * du + K.zz * dv))
        store(blocks, o + s.B_MISS, greatest(size_of(lam - lam0) / rigid, change))
    else:
        store(blocks, o + s.B_MISS, select(hits, zero + 1.0, zero))
    if counts:
        put3(blocks, o + s.B_BELT, belt)
        store(blocks, o + s.B_LEFT, select(near, left, 0.0))
        decide_state(blocks, o, sliding, inside, excess)
        store(blocks, o + s.B_TOTAL_LOAD, load(blocks, o + s.B_TOTAL_LOAD) + lam)
        keep_friction(blocks, o, pull, Vec3(v.y + belt.x, v.z + belt.y, zero), sliding)


@jit
def _answer(inverse, v, belt):
    """The friction that would stop the slip; ``inverse``: that of the matrix of the two tangents, uu, uv, vv."""
    slip_u, slip_v = v.y + belt.x, v.z + belt.y
    return Vec3(
        inverse.x * slip_u + inverse.y * slip_v, inverse.y * slip_u + inverse.z * slip_v, slip_u - slip_u
    )  # fmt: skip


@jit
def _limited(K, v, belt, pull, limit):
    """The friction that stops the slip, or what can be had of it, in place of ``pull``."""
    bu = v.y + belt.x + K.yy * pull.x + K.yz * pull.y
    bv = v.z + belt.y + K.yz * pull.x + K.zz * pull.y
    return limited_impulse(K.yy, K.yz, K.zz, bu, bv, limit)


@jit
def points_stay_open(blocks, o, v, aim, near, h, cold, counts):
    """:func:`stiction.core.solve.idle.stays_open` for points."""
    if any_of(near):
        return False
    pull = get3(blocks, o + s.B_PULL)
    idle = (load(blocks, o + s.B_LOAD) + size_of(pull.x) + size_of(pull.y) <= 0.0) & (v.x <= aim)
    if counts:
        idle = idle & keeps_state(blocks, o)
    if not all_of(idle):
        return False
    leave_open(blocks, o, Vec3(v.y, v.z, v.x - v.x), h, cold, counts)
    return True


@jit
def miss_of_points(i, blocks, index, count, rows, h, t):
    """By how many m/s the points of block i miss their laws after a step: as
    :func:`stiction.core.solve.exact.miss_of_block`."""
    o = first_row(index, i, count)
    C = transpose(frame_of(blocks, o))
    v, _, _, _, _, _ = twist_now(i, blocks, o, index, count, rows, C, t)
    gap = gap_now(i, blocks, o, index, count, rows, C, t) + v.x * h
    lam, pull, belt = load(blocks, o + s.B_LOAD), get3(blocks, o + s.B_PULL), get3(blocks, o + s.B_BELT)
    zero = lam - lam
    error = v.x - allowed(gap, zero, h)
    normal = select(error > 0.0, error, least(size_of(error), lam / load(blocks, o + s.B_RIGID)))

    K = get6(blocks, o + s.B_KVV)
    stick = pull + _answer(get3(blocks, o + s.B_FRICTION_INVERSE), v, belt)
    sliding = load(blocks, o + s.B_STATE) > 0.5
    limit = select(sliding, load(blocks, o + s.B_MU_D), load(blocks, o + s.B_MU_S)) * greatest(lam, 0.0)
    fu, fv = _limited(K, v, belt, pull, limit)
    inside = dot(stick, stick) <= limit * limit
    du, dv = select(inside, stick.x, fu) - pull.x, select(inside, stick.y, fv) - pull.y
    du, dv = K.yy * du + K.yz * dv, K.yz * du + K.zz * dv
    return greatest(normal, sqrt(du * du + dv * dv))
