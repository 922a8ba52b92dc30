"""The default solver: many substeps of one soft pass.

A step is cut into substeps of h. In each, every body gets its velocities, then every manifold is solved once, in blocks
of eight that share no body: its normals as one small complementarity problem, then the friction of its patch as one
element, twice over. Contacts are soft (Catto, "Soft constraints", GDC 2011): a spring and damper so stiff that
omega h = 0.65, which is as stiff as warm starting allows; what sinks in is load / (mass omega^2).

Costs: bodies 1 a substep, manifolds 1 + 1 a substep and two inner sweeps (no cold passes, no relaxation).

Warm starting needs no pass of its own. Arms and inertia are those of the start of the step, so the impulses of the last
substep, applied again, change velocities by as much as they did then: with v the velocity before it and v' after it
(gravity included), the next substep starts from v' + (v' - v).
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.friction.patch import Surface, level, slide, times
from stiction.core.jit import jit
from stiction.core.lanes import LANES, all_of, any_of, gather, greatest, least, load, scatter, select, size_of, splat, store
from stiction.core.solve.blocks import get3, get4, get6, put3, put4
from stiction.core.solve.normals import Four, Sym4, lowest, non_negative, times4
from stiction.core.vec import Mat33, Vec3, columns, cross, dot, put_vec3, transpose

SUBSTEPS = 8
SWEEPS, FRESH_SWEEPS = 2, 12
"""Alternations of normals and friction within a manifold; more in the first substep of a new one, which has nothing to
start from and would break away by the error that is left."""
STIFFNESS = 0.65
"""omega h of a contact between two bodies that can move; twice that where one of them cannot."""
DAMPING = 20.0
"""Damping ratio; half of it where one body cannot move. High, so that penetrations fade without a bounce."""
PUSH = 3.0
"""m/s, fastest push out of a penetration."""
GRACE = 1.3
"""While a manifold sticks, its friction may go so far beyond the static limit for ``PATIENCE`` substeps, since loads
that have not converged make the limit a noisy one."""
PATIENCE = 3.0
OVERLOAD = 1.25
"""Phi above which it lets go at once."""
ENOUGH = 1e-6
"""m/s, error of the normals that ends the sweeps."""
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
def frame_of(blocks, o):
    """The directions n, u, v of eight patches as the columns of a matrix."""
    n, u = get3(blocks, o + s.B_NORMAL), get3(blocks, o + s.B_TANGENT)
    return columns(n, u, cross(n, u))


@jit
def symmetric(m):
    """A full matrix from its upper triangle."""
    return Mat33(m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz)


@jit
def push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque):
    """Apply a force and a torque at the anchor, in the frame, to b and their opposites to a; store the velocities."""
    arm_a, arm_b = get3(blocks, o + s.B_ARM_A), get3(blocks, o + s.B_ARM_B)
    dwa = times(get6(blocks, o + s.B_INERTIA_A), cross(arm_a, force) + torque)
    dwb = times(get6(blocks, o + s.B_INERTIA_B), cross(arm_b, force) + torque)
    f = B @ force
    va = va - f * load(blocks, o + s.B_MASS_A)
    vb = vb + f * load(blocks, o + s.B_MASS_B)
    wa, wb = wa - B @ dwa, wb + B @ dwb
    o8 = wa.x - wa.x
    scatter(rows, index, i, s.ROW_V, (va.x, va.y, va.z, o8, wa.x, wa.y, wa.z, o8))
    scatter(rows, index, i + count, s.ROW_V, (vb.x, vb.y, vb.z, o8, wb.x, wb.y, wb.z, o8))


@jit
def twist_of(blocks, o, C, va, wa, vb, wb):
    """Velocity of a against b at the anchor, and their relative spin, in the frame: the lecture's collision velocity."""
    arm_a, arm_b = get3(blocks, o + s.B_ARM_A), get3(blocks, o + s.B_ARM_B)
    wa, wb = C @ wa, C @ wb
    return C @ (va - vb) + cross(wa, arm_a) - cross(wb, arm_b), wa - wb


@jit
def warm_block(i, blocks, index, count, rows):
    """Apply the impulses that the manifolds of block i bring along from the step before."""
    o = i * s.FIELDS
    B = frame_of(blocks, o)
    a, b = gather(rows, index, i, s.ROW_V), gather(rows, index, i + count, s.ROW_V)
    va, wa = Vec3(a[0], a[1], a[2]), Vec3(a[4], a[5], a[6])
    vb, wb = Vec3(b[0], b[1], b[2]), Vec3(b[4], b[5], b[6])
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    lam = get4(blocks, o + s.B_LOAD)
    pull = get3(blocks, o + s.B_PULL)
    px, py = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1)
    v, w = twist_of(blocks, o, transpose(B), va, wa, vb, wb)
    put3(blocks, o + s.B_SLIP, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * load(blocks, o + s.B_TORQUE)))
    force = Vec3(lam.a + lam.b + lam.c + lam.d, pull.x, pull.y)
    torque = Vec3(
        pull.z * load(blocks, o + s.B_TORQUE) + px * pull.y - py * pull.x,
        y.a * lam.a + y.b * lam.b + y.c * lam.c + y.d * lam.d,
        -(x.a * lam.a + x.b * lam.b + x.c * lam.c + x.d * lam.d),
    )
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)


@jit
def solve_block(i, blocks, index, count, rows, h, first):
    """One pass over block i: normals, then friction, twice over; in the first substep new manifolds go on alone."""
    o = i * s.FIELDS
    B = frame_of(blocks, o)
    C = transpose(B)
    a, b = gather(rows, index, i, s.ROW_V), gather(rows, index, i + count, s.ROW_V)
    va, wa = Vec3(a[0], a[1], a[2]), Vec3(a[4], a[5], a[6])
    vb, wb = Vec3(b[0], b[1], b[2]), Vec3(b[4], b[5], b[6])
    v, w = twist_of(blocks, o, C, va, wa, vb, wb)

    # separations now: those of the start, less what a has come closer since
    a, b = gather(rows, index, i, s.ROW_D), gather(rows, index, i + count, s.ROW_D)
    d, turned = twist_of(
        blocks, o, C, Vec3(a[0], a[1], a[2]), Vec3(a[4], a[5], a[6]), Vec3(b[0], b[1], b[2]), Vec3(b[4], b[5], b[6])
    )
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    gap = get4(blocks, o + s.B_GAP)
    gap = Four(
        gap.a - (d.x + y.a * turned.y - x.a * turned.z), gap.b - (d.x + y.b * turned.y - x.b * turned.z),
        gap.c - (d.x + y.c * turned.y - x.c * turned.z), gap.d - (d.x + y.d * turned.y - x.d * turned.z),
    )  # fmt: skip
    beta = load(blocks, o + s.B_BETA)
    aim = Four(
        allowed(gap.a, beta, h), allowed(gap.b, beta, h), allowed(gap.c, beta, h), allowed(gap.d, beta, h)
    )  # fmt: skip
    near = lowest(gap) < NEAR

    keep_closing(blocks, o, x, y, v, w)
    Kvv, Kww = get6(blocks, o + s.B_KVV), get6(blocks, o + s.B_KWW)
    k1, k2, k3 = get3(blocks, o + s.B_KWV), get3(blocks, o + s.B_KWV + 3), get3(blocks, o + s.B_KWV + 6)
    inverse = Sym4(
        load(blocks, o + s.B_INVERSE), load(blocks, o + s.B_INVERSE + 1), load(blocks, o + s.B_INVERSE + 2),
        load(blocks, o + s.B_INVERSE + 3), load(blocks, o + s.B_INVERSE + 4), load(blocks, o + s.B_INVERSE + 5),
        load(blocks, o + s.B_INVERSE + 6), load(blocks, o + s.B_INVERSE + 7), load(blocks, o + s.B_INVERSE + 8),
        load(blocks, o + s.B_INVERSE + 9),
    )  # fmt: skip
    gamma = get4(blocks, o + s.B_SOFT)
    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    F, Fi = get6(blocks, o + s.B_FRICTION), get6(blocks, o + s.B_FRICTION_INVERSE)
    surface = Surface(
        load(blocks, o + s.B_SURFACE), load(blocks, o + s.B_SURFACE + 1), load(blocks, o + s.B_SURFACE + 2),
        load(blocks, o + s.B_SURFACE + 3),
    )  # fmt: skip
    mu_s, mu_d = load(blocks, o + s.B_MU_S), load(blocks, o + s.B_MU_D)
    rigid, left0 = load(blocks, o + s.B_RIGID), load(blocks, o + s.B_LEFT)
    left = left0
    belt = get3(blocks, o + s.B_BELT)
    lam0, pull0 = get4(blocks, o + s.B_LOAD), get3(blocks, o + s.B_PULL)
    state = load(blocks, o + s.B_STATE)
    sliding = state > 0.5
    mu = select(sliding, mu_d, mu_s * GRACE)
    lam, pull = lam0, pull0
    limit = splat(blocks, 0.0)
    inside = sliding
    slip = belt
    fresh = load(blocks, o + s.B_FRESH) > 0.5
    sweeps = FRESH_SWEEPS if first and any_of(fresh) else SWEEPS
    going = fresh | ~fresh
    for sweep in range(sweeps):
        # normals: aim at a closing speed, less where the contact gives way
        error = Four(
            v.x + y.a * w.y - x.a * w.z - aim.a - gamma.a * lam.a,
            v.x + y.b * w.y - x.b * w.z - aim.b - gamma.b * lam.b,
            v.x + y.c * w.y - x.c * w.z - aim.c - gamma.c * lam.c,
            v.x + y.d * w.y - x.d * w.z - aim.d - gamma.d * lam.d,
        )  # fmt: skip
        if sweep > 0:
            # which lanes go on must not depend on what else is in their block: the others are masked
            going = going & (has_error(error.a, lam.a) | has_error(error.b, lam.b) | has_error(error.c, lam.c)
                             | has_error(error.d, lam.d))  # fmt: skip
            if sweep >= SWEEPS:
                going = going & fresh
            if not any_of(going):
                break
        wanted = times4(inverse, error)
        new = Four(lam.a + wanted.a, lam.b + wanted.b, lam.c + wanted.c, lam.d + wanted.d)
        if any_of(lowest(new) < 0.0):
            new = non_negative(new, inverse)
        if sweep > 0:
            new = Four(
                select(going, new.a, lam.a), select(going, new.b, lam.b), select(going, new.c, lam.c),
                select(going, new.d, lam.d),
            )  # fmt: skip
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

        # friction: its load is that of a rigid contact, which would have stopped the closing that the soft one lets grow
        N = lam.a + lam.b + lam.c + lam.d
        left = v.x + py * w.y - px * w.z
        N = select(near, greatest(N + (left - left0) * rigid, 0.0), N)
        slip = Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt
        limit = mu * N
        stick = pull + times(Fi, slip)
        # a load of nearly nothing must not make numbers whose sixth power is out of range
        unit = 1.0 / greatest(limit, 1e-4 * (size_of(stick.x) + size_of(stick.y) + size_of(stick.z)) + 1e-30)
        g = stick * unit
        inside = level(g, surface) <= 1.0
        if not all_of(inside):
            last = pull * unit
            free = (slip + times(F, pull)) * unit
            # the problem divided by the limit: A = F, so numbers stay near one whatever the masses
            g = slide(F, free, last, surface)
            stick = Vec3(
                select(inside, stick.x, g.x * limit), select(inside, stick.y, g.y * limit),
                select(inside, stick.z, g.z * limit),
            )  # fmt: skip
        if sweep > 0:
            stick = Vec3(
                select(going, stick.x, pull.x), select(going, stick.y, pull.y), select(going, stick.z, pull.z)
            )  # fmt: skip
        df = stick - pull
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

    put4(blocks, o + s.B_LOAD, lam)
    put3(blocks, o + s.B_PULL, pull)
    store(blocks, o + s.B_LEFT, select(near, left, 0.0))
    decide_state(blocks, o, state, inside, pull, limit * (mu_s / greatest(mu, 1e-30)), surface)
    keep_sums(blocks, o, lam, pull, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt)

    da, db, dc, dd = lam.a - lam0.a, lam.b - lam0.b, lam.c - lam0.c, lam.d - lam0.d
    df = pull - pull0
    force = Vec3(da + db + dc + dd, df.x, df.y)
    torque = Vec3(
        Tm * df.z + px * df.y - py * df.x,
        y.a * da + y.b * db + y.c * dc + y.d * dd,
        -(x.a * da + x.b * db + x.c * dc + x.d * dd),
    )
    push_bodies(blocks, o, B, rows, index, i, count, va, wa, vb, wb, force, torque)


@jit
def keep_closing(blocks, o, x, y, v, w):
    """Remember how fast points close as long as they have not been loaded in this step."""
    if any_of(load(blocks, o + s.B_RESTITUTION) > 0.0):
        most, closing = get4(blocks, o + s.B_MOST), get4(blocks, o + s.B_CLOSING)
        put4(
            blocks,
            o + s.B_CLOSING,
            Four(
                select(most.a > 0.0, closing.a, v.x + y.a * w.y - x.a * w.z),
                select(most.b > 0.0, closing.b, v.x + y.b * w.y - x.b * w.z),
                select(most.c > 0.0, closing.c, v.x + y.c * w.y - x.c * w.z),
                select(most.d > 0.0, closing.d, v.x + y.d * w.y - x.d * w.z),
            ),
        )  # fmt: skip


@jit
def has_error(error, lam):
    """Whether a point closes too fast, or carries a load and does not close as it should."""
    return (error > ENOUGH) | ((error < -ENOUGH) & (lam > 0.0))


@jit
def allowed(gap, beta, h):
    """Closing speed that is aimed at: over a gap what closes it in a substep, in a penetration a push out of it."""
    return select(gap > 0.0, gap * (1.0 / h), greatest(gap * beta, -PUSH))


@jit
def decide_state(blocks, o, state, inside, pull, limit, surface):
    """Stuck or sliding, from the whole patch: stuck until force and torque together exceed the static limit surface for
    a few substeps running, sliding until the dynamic one would not be reached.
    """
    over = load(blocks, o + s.B_OVER)
    zero = over - over
    unit = 1.0 / greatest(limit, 1e-4 * (size_of(pull.x) + size_of(pull.y) + size_of(pull.z)) + 1e-30)
    excess = level(pull * unit, surface)
    over = select(excess > 1.0, over + 1.0, zero)
    lets_go = (over >= PATIENCE) | (excess > OVERLOAD)
    state = select(state > 0.5, select(inside, zero, zero + 1.0), select(lets_go, zero + 1.0, zero))
    store(blocks, o + s.B_STATE, state)
    store(blocks, o + s.B_OVER, select(state > 0.5, zero, over))


@jit
def keep_sums(blocks, o, lam, pull, slip):
    """Impulses of the step so far, the largest load, and what friction took: its impulse times the mean slip."""
    total, most = get4(blocks, o + s.B_TOTAL_LOAD), get4(blocks, o + s.B_MOST)
    put4(blocks, o + s.B_TOTAL_LOAD, Four(total.a + lam.a, total.b + lam.b, total.c + lam.c, total.d + lam.d))
    put4(
        blocks,
        o + s.B_MOST,
        Four(greatest(most.a, lam.a), greatest(most.b, lam.b), greatest(most.c, lam.c), greatest(most.d, lam.d)),
    )
    put3(blocks, o + s.B_TOTAL_PULL, get3(blocks, o + s.B_TOTAL_PULL) + pull)
    before = get3(blocks, o + s.B_SLIP)
    store(blocks, o + s.B_WORK, load(blocks, o + s.B_WORK) + dot(pull, before + slip) * 0.5)
    put3(blocks, o + s.B_SLIP, slip)


@jit
def store_blocks(blocks, index, count, manifolds, reports):
    """Give the manifolds back what the step has made of them; returns the work of friction, J.

    A lane that was padded names the manifold of nobody.
    """
    work = 0.0
    for i in range(count):
        o = i * s.FIELDS
        for lane in range(LANES):
            row = index[i + 2 * count, lane]
            if row > 0:
                work += store_lane(blocks, o, lane, manifolds, reports, row)
    return work


@jit
def store_lane(blocks, o, lane, manifolds, reports, row):
    """The same for one manifold."""
    u = Vec3(blocks[o + s.B_TANGENT, lane], blocks[o + s.B_TANGENT + 1, lane], blocks[o + s.B_TANGENT + 2, lane])
    n = Vec3(blocks[o + s.B_NORMAL, lane], blocks[o + s.B_NORMAL + 1, lane], blocks[o + s.B_NORMAL + 2, lane])
    v = cross(n, u)
    arm = blocks[o + s.B_TORQUE, lane]
    px, py = blocks[o + s.B_CENTER, lane], blocks[o + s.B_CENTER + 1, lane]
    for k in range(4):
        manifolds[row, s.LOAD + k] = blocks[o + s.B_LOAD + k, lane]
        reports[row, s.TOTAL_LOAD + k] = blocks[o + s.B_TOTAL_LOAD + k, lane]
    fu, fv = blocks[o + s.B_PULL, lane], blocks[o + s.B_PULL + 1, lane]
    put_vec3(manifolds, row, s.PULL, u * fu + v * fv)
    manifolds[row, s.SPIN] = blocks[o + s.B_PULL + 2, lane] * arm + px * fv - py * fu
    fu, fv = blocks[o + s.B_TOTAL_PULL, lane], blocks[o + s.B_TOTAL_PULL + 1, lane]
    put_vec3(reports, row, s.TOTAL_PULL, u * fu + v * fv)
    reports[row, s.TOTAL_TWIST] = blocks[o + s.B_TOTAL_PULL + 2, lane] * arm + px * fv - py * fu
    manifolds[row, s.STATE], manifolds[row, s.OVER] = blocks[o + s.B_STATE, lane], blocks[o + s.B_OVER, lane]
    manifolds[row, s.LEFT] = blocks[o + s.B_LEFT, lane]
    manifolds[row, s.FRESH] = 0.0
    return float(blocks[o + s.B_WORK, lane])
