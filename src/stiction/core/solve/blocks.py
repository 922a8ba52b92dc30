"""From manifolds to blocks: what a pass needs of eight manifolds, computed once a step, eight at a time.

The lecture's contact matrix K takes an impulse at a point to a change of velocity there. A manifold is a rigid patch:
it has six directions, a force and a torque at its anchor, and its matrix is built of the same pieces, m^-1 1, S_r and
I^-1 (``contact_space``):

    K_vv = m^-1 1 - S_r I^-1 S_r,   K_wv = I^-1 S_r,   K_ww = I^-1,   summed over both bodies,

in the axes (n, u, v) of the patch. Normal impulses and the friction of the patch are solved inside these 6 x 6 numbers,
without touching the bodies in between.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.contact_space import inverse_mass_matrix, skew
from stiction.core.friction.laws import hold_on, keep_scaled, prepare_laws, scaled_force, scaling_at, stretch, stretched
from stiction.core.friction.lifting import Corners, with_lifting
from stiction.core.friction.patch import Surface, Sym3, inverse_sym, times
from stiction.core.friction.pressure import (
    CAP_A,
    CAP_C,
    Even,
    choose_polar,
    polar_of,
    polar_of_eight,
    polar_of_ellipse,
    pressed,
    spread_of,
)
from stiction.core.jit import jit
from stiction.core.lanes import any_of, gather, greatest, least, load, scatter, select, splat, sqrt, store
from stiction.core.leaning import without_lean
from stiction.core.solve.normals import Four, Sym4, inverse_of_points, point_matrix
from stiction.core.vec import Mat33, Vec3, columns, cross, dot, transpose

POINT_TORQUE = 1e-4
"""A patch whose mean arm is below this part of the size of its points' spread is a point."""
TINY = 1e-30
CARRIED = 2.0
"""Of the static limit: more torque than that is not brought along from the step before."""


@jit
def get3(blocks, k):
    """Three neighbouring vectors of a block as a Vec3 of lanes."""
    return Vec3(load(blocks, k), load(blocks, k + 1), load(blocks, k + 2))


@jit
def get4(blocks, k):
    """Four of them, one a point."""
    return Four(load(blocks, k), load(blocks, k + 1), load(blocks, k + 2), load(blocks, k + 3))


@jit
def get6(blocks, k):
    """Six of them, a symmetric matrix."""
    return Sym3(
        load(blocks, k), load(blocks, k + 1), load(blocks, k + 2),
        load(blocks, k + 3), load(blocks, k + 4), load(blocks, k + 5),
    )  # fmt: skip


@jit
def put3(blocks, k, v):
    """Store three lanes."""
    store(blocks, k, v.x)
    store(blocks, k + 1, v.y)
    store(blocks, k + 2, v.z)


@jit
def put4(blocks, k, v):
    """Store four lanes."""
    store(blocks, k, v.a)
    store(blocks, k + 1, v.b)
    store(blocks, k + 2, v.c)
    store(blocks, k + 3, v.d)


@jit
def put6(blocks, k, m):
    """Store a symmetric matrix."""
    store(blocks, k, m.xx)
    store(blocks, k + 1, m.xy)
    store(blocks, k + 2, m.xz)
    store(blocks, k + 3, m.yy)
    store(blocks, k + 4, m.yz)
    store(blocks, k + 5, m.zz)


@jit
def put10(blocks, k, m):
    """Store a symmetric matrix of four points."""
    store(blocks, k, m.aa)
    store(blocks, k + 1, m.ab)
    store(blocks, k + 2, m.ac)
    store(blocks, k + 3, m.ad)
    store(blocks, k + 4, m.bb)
    store(blocks, k + 5, m.bc)
    store(blocks, k + 6, m.bd)
    store(blocks, k + 7, m.cc)
    store(blocks, k + 8, m.cd)
    store(blocks, k + 9, m.dd)


@jit
def surface_at(blocks, o):
    """The limit surfaces of a block."""
    k = o + s.B_SURFACE
    return Surface(
        load(blocks, k), load(blocks, k + 1), load(blocks, k + 2), load(blocks, k + 3), load(blocks, k + 4),
        load(blocks, k + 5), load(blocks, k + 6), load(blocks, k + 7),
    )  # fmt: skip


@jit
def vectors_of(rows, index, i, k):
    """The vectors in columns k and k + 4 of the rows of eight bodies, which row i of ``index`` names."""
    g = gather(rows, index, i, k)
    return Vec3(g[0], g[1], g[2]), Vec3(g[4], g[5], g[6])


@jit
def body_of(aux, index, i):
    """Rotation matrix, inverse mass and inverse inertia (world) of the eight bodies in row i of ``index``."""
    g, k = gather(aux, index, i, s.AUX_ROTATION), gather(aux, index, i, s.AUX_ROTATION + 8)
    R = Mat33(g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], k[0])
    return R, k[1], Mat33(k[2], k[3], k[4], k[3], k[5], k[6], k[4], k[6], k[7])


@jit
def bodies_of(i, blocks, index, count, aux):
    """Rotation matrices, inverse masses and inertias of both bodies of block i, and the mass that is their unit: one of
    the pair's own, else mm and 100 m would not both fit into single precision."""
    Ra, ma, Ia = body_of(aux, index, i)
    Rb, mb, Ib = body_of(aux, index, i + count)
    scale = 1.0 / greatest(ma + mb, TINY)
    store(blocks, first_row(index, i, count) + s.B_SCALE, scale)
    return Ra, ma * scale, scaled(Ia, scale), Rb, mb * scale, scaled(Ib, scale), scale


@jit
def put_bodies(blocks, o, ra, rb, ma, mb, Ia, Ib, Kvv):
    """Store what a pass needs of both bodies, in the frame of the patch."""
    put3(blocks, o + s.B_ARM_A, ra)
    put3(blocks, o + s.B_ARM_B, rb)
    store(blocks, o + s.B_MASS_A, ma)
    store(blocks, o + s.B_MASS_B, mb)
    put6(blocks, o + s.B_INERTIA_A, upper(Ia))
    put6(blocks, o + s.B_INERTIA_B, upper(Ib))
    put6(blocks, o + s.B_KVV, upper(Kvv))


@jit
def twist_of(blocks, o, C, va, wa, vb, wb):
    """Velocity of a against b at the anchor, and their relative spin, in the frame: the lecture's collision
    velocity."""
    arm_a, arm_b = get3(blocks, o + s.B_ARM_A), get3(blocks, o + s.B_ARM_B)
    wa, wb = C @ wa, C @ wb
    return C @ (va - vb) + cross(wa, arm_a) - cross(wb, arm_b), wa - wb


@jit
def start_twist(blocks, o, index, i, count, aux, C):
    """That of the start of the step: rows say only how it has changed since."""
    va, wa = vectors_of(aux, index, i, s.AUX_START_V)
    vb, wb = vectors_of(aux, index, i + count, s.AUX_START_V)
    return twist_of(blocks, o, C, va, wa, vb, wb)


@jit
def twist_now(i, blocks, o, index, count, rows, C, t):
    """The twist that normals meet, velocity of closing and spins about u and v, is that at the time t of the step; of
    the slip there is only what has changed since its start, for the rest is in B_BELT. Also the velocities in the
    rows."""
    va, wa = vectors_of(rows, index, i, s.ROW_V)
    vb, wb = vectors_of(rows, index, i + count, s.ROW_V)
    v, w = twist_of(blocks, o, C, va, wa, vb, wb)
    start = get3(blocks, o + s.B_START)
    closing = start.x + load(blocks, o + s.B_WANDER) * t
    return Vec3(v.x + closing, v.y, v.z), Vec3(w.x, w.y + start.y, w.z + start.z), va, wa, vb, wb


@jit
def frame_of(blocks, o):
    """The directions n, u, v of eight patches as the columns of a matrix."""
    n, u = get3(blocks, o + s.B_NORMAL), get3(blocks, o + s.B_TANGENT)
    return columns(n, u, cross(n, u))


@jit
def push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque, column=s.ROW_V):
    """Apply a force and a torque at the anchor, in the frame, to b and their opposites to a; store the velocities, or
    what else is in ``column``."""
    arm_a, arm_b = get3(blocks, o + s.B_ARM_A), get3(blocks, o + s.B_ARM_B)
    dwa = times(get6(blocks, o + s.B_INERTIA_A), cross(arm_a, force) + torque)
    dwb = times(get6(blocks, o + s.B_INERTIA_B), cross(arm_b, force) + torque)
    f = B @ force
    va = va - f * load(blocks, o + s.B_MASS_A)
    vb = vb + f * load(blocks, o + s.B_MASS_B)
    wa, wb = wa - B @ dwa, wb + B @ dwb
    o8 = wa.x - wa.x
    scatter(rows, index, i, column, (va.x, va.y, va.z, o8, wa.x, wa.y, wa.z, o8))
    scatter(rows, index, i + count, column, (vb.x, vb.y, vb.z, o8, wb.x, wb.y, wb.z, o8))


@jit
def upper(m):
    """The upper triangle of a symmetric matrix."""
    return Sym3(m.xx, m.xy, m.xz, m.yy, m.yz, m.zz)


@jit
def patch_matrix(mass, inertia, r):
    """One body's share of the manifold's matrix: K_vv, K_wv and K_ww = I^-1, all in the frame of the patch."""
    turn = inertia @ skew(r)
    return inverse_mass_matrix(mass) + -(skew(r) @ turn), turn


@jit
def scaled(m, factor):
    """A matrix times a number."""
    return Mat33(
        m.xx * factor, m.xy * factor, m.xz * factor, m.yx * factor, m.yy * factor, m.yz * factor, m.zx * factor,
        m.zy * factor, m.zz * factor,
    )  # fmt: skip


@jit
def full(m):
    """A full matrix from its upper triangle."""
    return Mat33(m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz)


@jit
def soften(A, gamma):
    """A with compliance on its diagonal."""
    return Sym4(
        A.aa + gamma.a, A.ab, A.ac, A.ad, A.bb + gamma.b, A.bc, A.bd, A.cc + gamma.c, A.cd, A.dd + gamma.d
    )  # fmt: skip


@jit
def prepare_block(i, blocks, index, count, manifolds, corners, aux, h, dt, beta, soft, beta_stiff, soft_stiff, laws):
    """Fill block i. ``index`` rows i, i + count, i + 2 count name the bodies a, b and the manifolds of its lanes.

    ``beta`` (1/s) and ``soft`` (compliance, a part of the point's own 1/m) of a contact between two bodies that can
    move; the ``stiff`` ones where one of them cannot. ``corners``: those of faces with more than four. ``laws``: kinds,
    table and grain, or None where no pair has more than constant coefficients.
    """
    o = first_row(index, i, count)
    rows = i + 2 * count
    Ra, ma, Ia, Rb, mb, Ib, scale = bodies_of(i, blocks, index, count, aux)
    ga = gather(manifolds, index, rows, s.NORMAL_A)
    gb = gather(manifolds, index, rows, s.NORMAL_B)
    gl = gather(manifolds, index, rows, s.GAP)
    gp = gather(manifolds, index, rows, s.PLACE_U)
    gf = gather(manifolds, index, rows, s.PULL)
    gm = gather(manifolds, index, rows, s.EVEN)
    gx = gather(manifolds, index, rows, s.SHIFT)
    gy = gather(manifolds, index, rows, s.ARM_B)

    h_scale = h / scale

    # the patch, from the loads of the last substep; an even load where there is none yet
    zero, one = splat(blocks, 0.0), splat(blocks, 1.0)
    points = gm[6]
    here = Four(
        select(points > 0.5, one, zero), select(points > 1.5, one, zero), select(points > 2.5, one, zero),
        select(points > 3.5, one, zero),
    )  # fmt: skip
    x, y = Four(gp[0], gp[1], gp[2], gp[3]), Four(gp[4], gp[5], gp[6], gp[7])
    lam = Four(gl[4] * here.a * h_scale, gl[5] * here.b * h_scale, gl[6] * here.c * h_scale, gl[7] * here.d * h_scale)
    put4(blocks, o + s.B_LOAD, lam)
    loaded = lam.a + lam.b + lam.c + lam.d > 0.0
    w = Four(
        select(loaded, lam.a, here.a), select(loaded, lam.b, here.b),
        select(loaded, lam.c, here.c), select(loaded, lam.d, here.d),
    )  # fmt: skip
    share = 1.0 / greatest(w.a + w.b + w.c + w.d, TINY)
    px = (w.a * x.a + w.b * x.b + w.c * x.c + w.d * x.d) * share
    py = (w.a * y.a + w.b * y.b + w.c * y.c + w.d * y.d) * share
    even = Even(gm[0], gm[1], gm[2], gm[3], gm[4], gm[5])
    is_round, many = gf[7] > 1.5, (gf[7] > 0.5) & (gf[7] < 1.5)
    fu, fv, pu, pv = x, y, px, py
    if laws is not None:
        prepare_laws(i, blocks, index, count, manifolds, aux, laws)
        fu, fv = stretched(blocks, o, x, y)
        pu, pv, even = stretch(blocks, o, px, py, even, is_round)
    seen = polar_of(fu, fv, pu, pv)
    if any_of(is_round):
        seen = choose_polar(is_round, polar_of_ellipse(even, pu, pv), seen)
    # of a face with more than four corners the first four, and the others
    eu, ev, gu, gv = fu, fv, fu, fv
    if any_of(many):
        k, m = gather(corners, index, rows, s.CORNER_U), gather(corners, index, rows, s.CORNER_V)
        eu, ev = Four(k[0], k[1], k[2], k[3]), Four(m[0], m[1], m[2], m[3])
        gu, gv = Four(k[4], k[5], k[6], k[7]), Four(m[4], m[5], m[6], m[7])
        if laws is not None:
            eu, ev = stretched(blocks, o, eu, ev)
            gu, gv = stretched(blocks, o, gu, gv)
        seen = choose_polar(many, polar_of_eight(eu, ev, gu, gv, pu, pv), seen)
    size2 = x.a * x.a + x.b * x.b + x.c * x.c + x.d * x.d + y.a * y.a + y.b * y.b + y.c * y.c + y.d * y.d
    spread = spread_of(seen, even, is_round)
    spread = with_lifting(spread, seen, even, fu, fv, Corners(eu, ev, gu, gv), pu, pv, many, is_round)
    patch = pressed(seen, even, is_round, spread)
    is_face = patch.torque * patch.torque > POINT_TORQUE * POINT_TORQUE * size2
    torsional = gf[4] / greatest(ga[7], 1e-6)
    # no mean arm is longer than the root of the sum of the squares of all
    Tm = select(is_face, least(patch.torque, sqrt(size2)), zero)
    Tm = sqrt(Tm * Tm + torsional * torsional)
    # a point has no direction: with torsional resistance it is a small round cap
    surface = patch.surface
    store(blocks, o + s.B_SURFACE, select(is_face, surface.au, CAP_A))
    store(blocks, o + s.B_SURFACE + 1, select(is_face, surface.am, 2.0 * CAP_A))
    store(blocks, o + s.B_SURFACE + 2, select(is_face, surface.av, CAP_A))
    store(blocks, o + s.B_SURFACE + 3, select(is_face, surface.cu, CAP_C))
    store(blocks, o + s.B_SURFACE + 4, select(is_face, surface.cv, CAP_C))
    store(blocks, o + s.B_SURFACE + 5, select(is_face, surface.lu, 0.0))
    store(blocks, o + s.B_SURFACE + 6, select(is_face, surface.lv, 0.0))
    store(blocks, o + s.B_SURFACE + 7, select(is_face, surface.s, 0.0))
    store(blocks, o + s.B_TORQUE, Tm)
    store(blocks, o + s.B_MU_S, ga[6])
    store(blocks, o + s.B_MU_D, ga[7])

    # everything from here on is in the axes of the pressure
    c, sn = select(is_face, patch.turn.c, one), select(is_face, patch.turn.s, zero)
    if laws is not None:
        # with a grain these axes are those of the scaled forces alone
        c, sn = keep_scaled(blocks, o, c, sn)
    store(blocks, o + s.B_TURN, c)
    store(blocks, o + s.B_TURN + 1, sn)
    px, py = c * px + sn * py, c * py - sn * px
    x, y = (
        Four(c * x.a + sn * y.a, c * x.b + sn * y.b, c * x.c + sn * y.c, c * x.d + sn * y.d),
        Four(c * y.a - sn * x.a, c * y.b - sn * x.b, c * y.c - sn * x.c, c * y.d - sn * x.d),
    )
    store(blocks, o + s.B_CENTER, px)
    store(blocks, o + s.B_CENTER + 1, py)
    put4(blocks, o + s.B_U, x)
    put4(blocks, o + s.B_V, y)

    # the frame turns with a; b's copy of it says how far b has turned against a since the manifold was made
    n, u = Ra @ Vec3(ga[0], ga[1], ga[2]), Ra @ Vec3(ga[3], ga[4], ga[5])
    v = cross(n, u)
    nb, ub = Rb @ Vec3(gb[0], gb[1], gb[2]), Rb @ Vec3(gb[3], gb[4], gb[5])
    turned = (cross(n, nb) + cross(u, ub) + cross(v, cross(nb, ub))) * 0.5
    u, v = u * c + v * sn, v * c - u * sn
    B = columns(n, u, v)
    C = transpose(B)
    shift = dot(n, Vec3(gx[0], gx[1], gx[2]))
    tilt_u, tilt_v = dot(turned, u), dot(turned, v)
    put3(blocks, o + s.B_NORMAL, n)
    put3(blocks, o + s.B_TANGENT, u)
    put4(
        blocks,
        o + s.B_GAP,
        Four(
            gl[0] + shift + (tilt_u * y.a - tilt_v * x.a), gl[1] + shift + (tilt_u * y.b - tilt_v * x.b),
            gl[2] + shift + (tilt_u * y.c - tilt_v * x.c), gl[3] + shift + (tilt_u * y.d - tilt_v * x.d),
        ),
    )  # fmt: skip

    if laws is not None:
        hold_on(i, blocks, index, count, manifolds, corners, laws, h)

    # the manifold's matrix
    ra = without_lean(aux, index, i, C, C @ Vec3(gx[3], gx[4], gx[5]))
    rb = without_lean(aux, index, i + count, C, C @ Vec3(gy[0], gy[1], gy[2]))
    Ia, Ib = C @ Ia @ B, C @ Ib @ B
    Ka, Ta = patch_matrix(ma, Ia, ra)
    Kb, Tb = patch_matrix(mb, Ib, rb)
    Kvv, Kwv, Kww = Ka + Kb, Ta + Tb, Ia + Ib
    put_bodies(blocks, o, ra, rb, ma, mb, Ia, Ib, Kvv)
    put3(blocks, o + s.B_KWV, Vec3(Kwv.xx, Kwv.xy, Kwv.xz))
    put3(blocks, o + s.B_KWV + 3, Vec3(Kwv.yx, Kwv.yy, Kwv.yz))
    put3(blocks, o + s.B_KWV + 6, Vec3(Kwv.zx, Kwv.zy, Kwv.zz))
    put6(blocks, o + s.B_KWW, upper(Kww))

    # the normals' matrix, its compliance and its inverse
    normal_part = (Kvv.xx, Kwv.yx, Kwv.zx, Kww.yy, Kww.yz, Kww.zz)
    A = point_matrix(normal_part, x, y, here)
    fixed = least(ma, mb) <= 0.0
    ratio = select(fixed, soft_stiff, one * soft)
    gamma = Four(A.aa * ratio, A.bb * ratio, A.cc * ratio, A.dd * ratio)
    put10(blocks, o + s.B_INVERSE, inverse_of_points(soften(A, gamma), here))
    put4(blocks, o + s.B_SOFT, gamma)
    store(blocks, o + s.B_BETA, select(fixed, beta_stiff, one * beta))

    # D K_P D: slip at P is v_u - y w_n, v_v + x w_n; a force there is also a torque x F_v - y F_u at the anchor
    nu, nv, nn = Kwv.xy, Kwv.xz, Kww.xx
    kuz, kvz = nu - py * nn, nv + px * nn
    kuu = Kvv.yy - 2.0 * py * nu + py * py * nn
    kuv = Kvv.yz + px * nu - py * nv - px * py * nn
    kvv = Kvv.zz + 2.0 * px * nv + px * px * nn
    # what normals and friction do to each other: closing and tilting of a friction impulse
    hu = Vec3(Kvv.xy - py * Kwv.xx, Kwv.yy - py * Kww.xy, Kwv.zy - py * Kww.xz)
    hv = Vec3(Kvv.xz + px * Kwv.xx, Kwv.yz + px * Kww.xy, Kwv.zz + px * Kww.xz)
    if laws is not None:
        # scaled forces: E^T K E, and H E
        xx, xy, yx, yy = scaling_at(blocks, o)
        au, av, bu, bv = kuu * xx + kuv * yx, kuv * xx + kvv * yx, kuu * xy + kuv * yy, kuv * xy + kvv * yy
        kuu, kuv, kvv = xx * au + yx * av, xx * bu + yx * bv, xy * bu + yy * bv
        kuz, kvz = xx * kuz + yx * kvz, xy * kuz + yy * kvz
        hu, hv = hu * xx + hv * yx, hu * xy + hv * yy
    nobody = select(Kvv.xx > 0.0, zero, one)
    friction = Sym3(
        kuu + nobody, kuv, kuz * Tm, kvv + nobody, kvz * Tm, nn * Tm * Tm + select(Tm > 0.0, nobody, one)
    )  # fmt: skip
    put6(blocks, o + s.B_FRICTION, friction)
    inverse = inverse_sym(friction)
    put6(blocks, o + s.B_FRICTION_INVERSE, inverse)
    # what the normals meet when friction answers by sticking: K_n - H F^-1 H^T
    H = Mat33(hu.x, hv.x, Kwv.xx * Tm, hu.y, hv.y, Kww.xy * Tm, hu.z, hv.z, Kww.xz * Tm)
    X = H @ full(inverse) @ transpose(H)
    stuck_part = (
        Kvv.xx - X.xx, Kwv.yx - X.xy, Kwv.zx - X.xz, Kww.yy - X.yy, Kww.yz - X.yz, Kww.zz - X.zz
    )  # fmt: skip
    stuck = point_matrix(stuck_part, x, y, here)
    put10(blocks, o + s.B_INVERSE_STUCK, inverse_of_points(soften(stuck, gamma), here))
    knn = Kvv.xx + 2.0 * (py * Kwv.yx - px * Kwv.zx) + py * py * Kww.yy - 2.0 * px * py * Kww.yz + px * px * Kww.zz
    store(blocks, o + s.B_RIGID, 1.0 / greatest(knn, TINY))

    pull = Vec3(gf[0], gf[1], gf[2]) * h_scale
    fu, fv = dot(pull, u), dot(pull, v)
    spin = gf[3] * h_scale - (px * fv - py * fu)
    # what a long face has carried is too much for the small one that may have come in its place
    most = ga[6] * (lam.a + lam.b + lam.c + lam.d) * CARRIED
    pull = Vec3(fu, fv, select(Tm > 0.0, greatest(least(spin / greatest(Tm, TINY), most), -most), zero))
    put3(blocks, o + s.B_PULL, scaled_force(blocks, o, pull, laws))
    store(blocks, o + s.B_STATE, gb[6])
    store(blocks, o + s.B_OVER, gb[7])
    store(blocks, o + s.B_LEFT, gy[7])
    belt = Vec3(gy[3], gy[4], gy[5])
    v0, w0 = start_twist(blocks, o, index, i, count, aux, C)
    early = select(points < 2.5, dot(belt, n), zero)
    put3(blocks, o + s.B_START, Vec3(v0.x + early, w0.y, w0.z))
    store(blocks, o + s.B_WANDER, early * (-2.0 / dt))
    put3(
        blocks, o + s.B_BELT, Vec3(dot(belt, u) + v0.y - w0.x * py, dot(belt, v) + v0.z + w0.x * px, w0.x * Tm)
    )  # fmt: skip
    store(blocks, o + s.B_DRIFT, c * gf[6] + sn * gy[6])
    store(blocks, o + s.B_DRIFT + 1, c * gy[6] - sn * gf[6])
    put4(blocks, o + s.B_TOTAL_LOAD, Four(zero, zero, zero, zero))
    put3(blocks, o + s.B_TOTAL_PULL, Vec3(zero, zero, zero))
    store(blocks, o + s.B_WORK, zero)
    store(blocks, o + s.B_ROLLED, zero)
    store(blocks, o + s.B_FRESH, gm[7])
    put4(blocks, o + s.B_LIFT, Four(zero, zero, zero, zero))
    store(blocks, o + s.B_ROLLING, gf[5])
    store(blocks, o + s.B_ROLL, (c * gx[6] + sn * gx[7]) * h_scale)
    store(blocks, o + s.B_ROLL + 1, (c * gx[7] - sn * gx[6]) * h_scale)
