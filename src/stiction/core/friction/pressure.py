"""From the loads of a patch to its limit surface: what the pressure under a face must be if its centre is known.

Pressure is linear and cannot pull, so it is known once its centre P is: p = max(0, p0 + g . x). Where P lies near the
border of the face only a corner or a strip of it carries, and all moments shrink. To find that pressure takes an
iteration that clips the face; what friction needs of it, its second moments M about P, follows within a few per cent
from the face alone, as seen from P. Seen from there a side at distance d with the outward normal n is the point n / d,
and the points of all sides are the corners of the *polar* polygon. With its covariance C and its centroid m,

    M^-1 = f C + h m m^T + (1 - t) E.

It has the poles that M^-1 must have at the border, it changes with any stretching of the plane as M^-1 does, and a side
that is short or nearly in line with its neighbour makes no difference. (With f = 12, h = 3, E = 0 it is the Hessian of
the universal barrier of convex optimisation: Nesterov and Nemirovskii, 1994.) t runs from 0 in the middle to 1 at a
corner; E makes M exact for an even load. Of faces that are no parallelograms the formula is up to 30 % off, in its
shape more than in its size: where a part of them lifts off, ``lifting.py`` adds one step of that iteration.
docs/design/limit-surface.md says how good all this is, and where f, h and the coefficients of the surface come from.

All functions run on numbers and on lanes alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stiction.core.friction.patch import Surface, arm_of_pressure
from stiction.core.jit import jit
from stiction.core.lanes import greatest, least, select, size_of, sqrt

NEAREST = 1e-6
"""Of the square of the face's size: less than this is the product of a side and its distance from P never taken to
be, for in single precision P is not known better."""
ISOTROPIC = 1e-3
"""A patch whose widths differ by less has no axes of its own."""
ELLIPSE = 0.3865
"""j of an ellipse, and twice its area over the root of the determinant of its covariance."""
ELLIPSE_AREA = 25.13274
ROUND_F = 14.48 + 0.115 * ELLIPSE
"""f in the middle of an ellipse, where 16 C = W."""
SQUARE_A, SQUARE_C = 0.344, 0.472
"""Coefficients of an evenly loaded square, ..."""
CAP_A, CAP_C = 0.411, 0.468
"""... and of a round cap: a disc that slides and spins goes as far as it should within 0.25 %, and comes to its end at
the right ratio of both within 0.2 % (0.5 % with the numbers that are best for a mean twist, 0.404 and 0.472)."""
TINY = 1e-30
THINNEST = 1e-16
"""Determinant of M^-1 over the square of its trace: of a strip 10^8 times as long as wide."""


class Turn(NamedTuple):
    """A rotation in the plane of the patch, by its cosine and sine."""

    c: Any
    s: Any


class Polar(NamedTuple):
    """A face as seen from a point: covariance and centroid of its polar, and twice its area, in axes turned by
    ``turn``."""

    uu: Any
    uv: Any
    vv: Any
    mu: Any
    mv: Any
    twice: Any
    turn: Any


class Even(NamedTuple):
    """What is known of a face for an even load, in the axes of its places: E (1/m^2), by how much the mean arm differs
    from the formula's, and the skewness of the pressure; of an ellipse its W, the same, and its centre, m."""

    uu: Any
    uv: Any
    vv: Any
    arm: Any
    u: Any
    v: Any


class Spread(NamedTuple):
    """M of a pressure in the axes of a polar, and its determinant. Where a part of the face has lifted off
    (``lifting.py``), the slope of the pressure over the pressure at P, and by which share that was taken into account.
    """

    uu: Any
    uv: Any
    vv: Any
    det: Any
    gu: Any
    gv: Any
    share: Any


class Pressed(NamedTuple):
    """What friction needs of a pressure: its principal axes against the given ones, T_m and the surface."""

    turn: Any
    torque: Any
    surface: Any


@jit
def _side(xa, ya, xb, yb, smallest):
    """The side from a to b, seen from the origin: its normal over its distance."""
    tx, ty = xb - xa, yb - ya
    over = 1.0 / greatest(xa * ty - ya * tx, smallest)
    return ty * over, -tx * over


@jit
def _nearer(u, v, best):
    """Of two sides the nearer one; ``best`` is (u, v, u^2 + v^2)."""
    size = u * u + v * v
    nearer = size > best[2]
    return select(nearer, u, best[0]), select(nearer, v, best[1]), greatest(size, best[2])


@jit
def direction_of(u, v):
    """Cosine and sine of the direction of (u, v), that of u for a vector of no length."""
    length = sqrt(u * u + v * v)
    over = 1.0 / greatest(length, TINY)
    return Turn(select(length > TINY, u * over, over - over + 1.0), select(length > TINY, v * over, over - over))


@jit
def _fan(sums, au, av, bu, bv):
    """Add area and moments of the triangle (0, a, b) to (area, u, v, uu, uv, vv), up to constant factors."""
    w = au * bv - av * bu
    su, sv = au + bu, av + bv
    return (
        sums[0] + w, sums[1] + w * su, sums[2] + w * sv, sums[3] + w * (su * su - au * bu),
        sums[4] + w * (su * sv - 0.5 * (au * bv + av * bu)), sums[5] + w * (sv * sv - av * bv),
    )  # fmt: skip


@jit
def _polar_of(sums, turn):
    """Covariance and centroid from the sums of ``_fan``, and the square of the area over the determinant."""
    twice = sums[0]
    share = 1.0 / greatest(twice, TINY)
    mu, mv = sums[1] * share * (1.0 / 3.0), sums[2] * share * (1.0 / 3.0)
    share = share * (1.0 / 6.0)
    return Polar(sums[3] * share - mu * mu, sums[4] * share - mu * mv, sums[5] * share - mv * mv, mu, mv, twice, turn)


@jit
def polar_of(x, y, px, py):
    """The polar polygon of a face with four corners (x, y), counterclockwise, seen from P.

    Its first axis is the direction of the nearest side, else single precision would lose the small moment beside the
    large one.
    """
    size2 = x.a * x.a + x.b * x.b + x.c * x.c + x.d * x.d + y.a * y.a + y.b * y.b + y.c * y.c + y.d * y.d
    smallest = greatest(NEAREST * size2, TINY)
    xa, xb, xc, xd = x.a - px, x.b - px, x.c - px, x.d - px
    ya, yb, yc, yd = y.a - py, y.b - py, y.c - py, y.d - py
    au, av = _side(xa, ya, xb, yb, smallest)
    bu, bv = _side(xb, yb, xc, yc, smallest)
    cu, cv = _side(xc, yc, xd, yd, smallest)
    du, dv = _side(xd, yd, xa, ya, smallest)
    best = _nearer(du, dv, _nearer(cu, cv, _nearer(bu, bv, (au, av, au * au + av * av))))
    turn = direction_of(best[0], best[1])
    c, s = turn.c, turn.s
    au, av = c * au + s * av, c * av - s * au
    bu, bv = c * bu + s * bv, c * bv - s * bu
    cu, cv = c * cu + s * cv, c * cv - s * cu
    du, dv = c * du + s * dv, c * dv - s * du
    zero = au - au
    sums = _fan((zero, zero, zero, zero, zero, zero), au, av, bu, bv)
    sums = _fan(_fan(_fan(sums, bu, bv, cu, cv), cu, cv, du, dv), du, dv, au, av)
    return _polar_of(sums, turn)


@jit
def polar_of_eight(x, y, z, w, px, py):
    """The same of a face with eight corners, the first four (x, y), the others (z, w)."""
    size2 = x.a * x.a + x.b * x.b + x.c * x.c + x.d * x.d + y.a * y.a + y.b * y.b + y.c * y.c + y.d * y.d
    size2 = size2 + (z.a * z.a + z.b * z.b + z.c * z.c + z.d * z.d + w.a * w.a + w.b * w.b + w.c * w.c + w.d * w.d)
    smallest = greatest(NEAREST * size2, TINY)
    xa, xb, xc, xd, xe, xf, xg, xh = (
        x.a - px, x.b - px, x.c - px, x.d - px, z.a - px, z.b - px, z.c - px, z.d - px
    )  # fmt: skip
    ya, yb, yc, yd, ye, yf, yg, yh = (
        y.a - py, y.b - py, y.c - py, y.d - py, w.a - py, w.b - py, w.c - py, w.d - py
    )  # fmt: skip
    au, av = _side(xa, ya, xb, yb, smallest)
    bu, bv = _side(xb, yb, xc, yc, smallest)
    cu, cv = _side(xc, yc, xd, yd, smallest)
    du, dv = _side(xd, yd, xe, ye, smallest)
    eu, ev = _side(xe, ye, xf, yf, smallest)
    fu, fv = _side(xf, yf, xg, yg, smallest)
    gu, gv = _side(xg, yg, xh, yh, smallest)
    hu, hv = _side(xh, yh, xa, ya, smallest)
    best = _nearer(du, dv, _nearer(cu, cv, _nearer(bu, bv, (au, av, au * au + av * av))))
    best = _nearer(hu, hv, _nearer(gu, gv, _nearer(fu, fv, _nearer(eu, ev, best))))
    turn = direction_of(best[0], best[1])
    c, s = turn.c, turn.s
    au, av = c * au + s * av, c * av - s * au
    bu, bv = c * bu + s * bv, c * bv - s * bu
    cu, cv = c * cu + s * cv, c * cv - s * cu
    du, dv = c * du + s * dv, c * dv - s * du
    eu, ev = c * eu + s * ev, c * ev - s * eu
    fu, fv = c * fu + s * fv, c * fv - s * fu
    gu, gv = c * gu + s * gv, c * gv - s * gu
    hu, hv = c * hu + s * hv, c * hv - s * hu
    zero = au - au
    sums = _fan((zero, zero, zero, zero, zero, zero), au, av, bu, bv)
    sums = _fan(_fan(_fan(_fan(sums, bu, bv, cu, cv), cu, cv, du, dv), du, dv, eu, ev), eu, ev, fu, fv)
    sums = _fan(_fan(_fan(sums, fu, fv, gu, gv), gu, gv, hu, hv), hu, hv, au, av)
    return _polar_of(sums, turn)


@jit
def choose_polar(mask, a, b):
    """Of a and b, lane by lane."""
    return Polar(
        select(mask, a.uu, b.uu), select(mask, a.uv, b.uv), select(mask, a.vv, b.vv), select(mask, a.mu, b.mu),
        select(mask, a.mv, b.mv), select(mask, a.twice, b.twice),
        Turn(select(mask, a.turn.c, b.turn.c), select(mask, a.turn.s, b.turn.s)),
    )  # fmt: skip


@jit
def polar_of_ellipse(even, px, py):
    """The same of the ellipse (r - c)^T W (r - c) = 4 with W and c in ``even``: an ellipse again, with
    C = (W + g g^T / D) / 4 D and m = g / D, where g = W r and D = 4 - r^T W r.
    """
    ru, rv = px - even.u, py - even.v
    gu, gv = even.uu * ru + even.uv * rv, even.uv * ru + even.vv * rv
    over = 1.0 / greatest(4.0 - ru * gu - rv * gv, NEAREST)
    turn = direction_of(gu, gv)
    uu, uv, vv = turned(even.uu, even.uv, even.vv, turn.c, turn.s)
    g = turn.c * gu + turn.s * gv
    uu, uv, vv = 0.25 * over * (uu + g * g * over), 0.25 * over * uv, 0.25 * over * vv
    return Polar(uu, uv, vv, g * over, over - over, ELLIPSE_AREA * sqrt(greatest(uu * vv - uv * uv, 0.0)), turn)


@jit
def place_in(polar):
    """t and j of the module's formula: 0 in the middle of a face, 1 at a corner; -1 for a triangle, 0 for a
    parallelogram."""
    mu, mv = polar.mu, polar.mv
    det = greatest(polar.uu * polar.vv - polar.uv * polar.uv, 0.0)
    far = 2.0 * (mu * mu * polar.vv - 2.0 * mu * mv * polar.uv + mv * mv * polar.uu)
    t = least(far / greatest(0.5 * far + 8.0 * det, TINY), 1.0)
    return t, greatest(least(polar.twice * polar.twice / greatest(144.0 * det, TINY) - 4.0, ELLIPSE), -1.0)


@jit
def turned(uu, uv, vv, c, s):
    """A symmetric tensor in axes turned by the angle with this cosine and sine."""
    half = c * s * (vv - uu)
    cc, cs, ss = c * c, 2.0 * c * s, s * s
    return cc * uu + cs * uv + ss * vv, half + (cc - ss) * uv, ss * uu - cs * uv + cc * vv


@jit
def factors(t, j):
    """f, h, and the mean arm over that of a parallelogram with the same M, where nothing is known of an even load."""
    f = 14.48 - 2.52 * t + j * (0.115 - 2.9 * t)
    h = 16.39 - 6.28 * t + j * (1.956 - 0.236 * t)
    return f, h, 1.0 - 0.037 * t * (1.0 + t) + 0.017 * j


@jit
def spread_of(seen, even, is_round):
    """M of a pressure whose face looks like ``seen``, a polar, from its centre. Of an ellipse (``is_round``) ``even``
    has W and its middle."""
    (t, j), c, s = place_in(seen), seen.turn.c, seen.turn.s
    f, h, _ = factors(t, j)
    zero = t - t
    euu, euv, evv = turned(even.uu, even.uv, even.vv, c, s)
    # of an ellipse f C = f W / 16 in the middle
    part = (1.0 - t) * select(is_round, zero + (1.0 - ROUND_F / 16.0), zero + 1.0)
    # M^-1, and M from it
    wuu = f * seen.uu + h * seen.mu * seen.mu + part * euu
    wuv = f * seen.uv + h * seen.mu * seen.mv + part * euv
    wvv = f * seen.vv + h * seen.mv * seen.mv + part * evv
    # what is known of an odd face may leave no pressure at all; a patch is never taken to be narrower than that
    trace = greatest(wuu + wvv, 0.0)
    det = greatest(wuu * wvv - wuv * wuv, THINNEST * trace * trace)
    over = 1.0 / greatest(det, TINY)
    return Spread(wvv * over, -wuv * over, wuu * over, select(det > TINY, over, zero), zero, zero, zero)


@jit
def pressed(seen, even, is_round, spread):
    """The patch of a pressure with this spread: axes, mean arm, limit surface. A patch without any extent has an arm
    of 0."""
    (t, j), c, s = place_in(seen), seen.turn.c, seen.turn.s
    _, _, arm = factors(t, j)
    calm = 1.0 - t
    zero = t - t
    uu, uv, vv = spread.uu, spread.uv, spread.vv

    # principal axes, the longer one first; a patch that has none keeps the axes it is given in
    apart, mixed, total = uu - vv, 2.0 * uv, uu + vv
    width = sqrt(apart * apart + mixed * mixed)
    axes = width > ISOTROPIC * total
    cos2 = apart / greatest(width, TINY)
    pc, ps = sqrt(greatest(0.5 + 0.5 * cos2, 0.0)), sqrt(greatest(0.5 - 0.5 * cos2, 0.0))
    ps = select(mixed < 0.0, -ps, ps)
    pc, ps = select(axes, pc, c), select(axes, ps, -s)
    turn = Turn(c * pc - s * ps, s * pc + c * ps)
    Mu = 0.5 * (total + width)
    Mv = spread.det / greatest(Mu, TINY)
    q, kappa = arm_of_pressure(Mu, least(Mv, Mu))
    # a line that is loaded off its middle, as two corners of a face: there f and h leave the patch too long
    line = greatest(1.0 - 20.0 * q, 0.0) * greatest(-j, 0.0) * greatest(least(5.0 * t - 2.0, 1.0), 0.0)
    arm = (arm + calm * even.arm) * (1.0 - 0.08 * line)
    # where a part of the face has lifted off, by the slope of the pressure (along u by way of M, as below)
    gu = (uu * spread.gu + uv * spread.gv) * pc + (uv * spread.gu + vv * spread.gv) * ps
    gv = spread.gv * pc - spread.gu * ps
    lifted = lifted_arm(q, gu * gu / greatest(Mu, TINY), Mv * gv * gv) + 0.635 * calm * even.arm
    arm = select(spread.share > 0.0, arm + spread.share * (lifted - arm), arm)
    torque = kappa * sqrt(Mu + Mv) * greatest(least(arm, 1.3), 0.7)

    # how lopsided the pressure is: where its centre lies in the face, and that of an even load
    # (M^1/2 m; at a border m is long, and what it has along u would be lost in it: there by way of M m)
    along = (uu * seen.mu + uv * seen.mv) * pc + (uv * seen.mu + vv * seen.mv) * ps
    eu = along / greatest(sqrt(Mu), TINY)
    ev = sqrt(Mv) * (seen.mv * pc - seen.mu * ps)
    ku, kv = calm * (turn.c * even.u + turn.s * even.v), calm * (turn.c * even.v - turn.s * even.u)
    ku, kv = select(is_round, zero, ku), select(is_round, zero, kv)
    return Pressed(turn, torque, lopsided_surface(q, t, j, eu, ev, ku, kv))


@jit
def lifted_arm(q, su, sv):
    """The mean arm over that of a parallelogram with the same M, where a part of the face has lifted off: by the
    squares of the slope of the pressure along u and v."""
    return 0.978 + sv * (0.544 + 0.203 * q - 4.407 * su - 3.933 * sv)


@jit
def lopsided_surface(q, t, j, eu, ev, ku, kv):
    """The surface's coefficients by q = sqrt(M_v / M_u) <= 1, t and j (-1 of a triangle, 0 of a parallelogram, ELLIPSE
    of a cap), and how lopsided the pressure is along u and v.

    For q = 1 they are isotropic, as there the axes are arbitrary.
    """
    w = 1.0 - q
    three, roundness = greatest(-j, 0.0), q * (1.0 - t) * greatest(j, 0.0) * (1.0 / ELLIPSE)
    a = SQUARE_A + (CAP_A - SQUARE_A) * roundness - 0.176 * three * q
    c = SQUARE_C + (CAP_C - SQUARE_C) * roundness + t * (0.325 * three - 0.273)
    # no face is more lopsided along u, for a parallelogram is not at all
    skew = least(ku * ku, three)
    au = a + w * (-1.531 + 1.602 * w * w + three * (0.264 - 0.384 * w))
    am = 2.0 * a - w * (0.89 + 0.875 * w)
    av = a + w * (2.199 - 0.523 * w * w - 0.288 * three)
    cu = c + w * (0.123 - 1.12 * w)
    cv = c + w * (w * (0.419 - 0.394 * three) + 0.68 * skew)
    lu = ev * (1.251 - w * (1.152 + three * (0.975 - 0.825 * w))) + kv * (0.962 * w * t - 0.614)
    lv = ku * (0.614 - w * (0.354 + 1.047 * t))
    lv = lv - eu * (1.251 + w * (ev * ev * (40.257 + 31.779 * w) - 2.856 * t * t))
    s = w * (ku * (1.576 + 0.81 * w) - eu * (3.228 + 2.601 * w))
    return _kept_convex(Surface(au, am, av, cu, cv, lu, lv, s), q, t, three, skew)


@jit
def _kept_convex(k, q, t, three, skew):
    """The surface with its odd terms made small enough for it to be convex and for every ray to meet it once: within
    a polygon of l_v and s, and an ellipse of that and l_u. One face in a hundred is touched, by a sixth at most.

    Towards a corner they fade: a corner is pressed as x (1 - x) along, which is not lopsided; and there the centre of
    pressure of what rocks leaps about, and with odd terms as large as in the middle heaps are slower to come to rest.
    """
    qq = q * q
    up, across = 1.0 / (2.353 + 0.619 * skew - 1.402 * qq), 1.0 / (2.142 - 0.233 * qq)
    far = greatest(size_of(k.lv * (1.0 / 0.952) + k.s * up), size_of(k.lv * (1.0 / 0.682) - k.s * across))
    far = greatest(far, size_of(k.lv) / (0.425 + 0.17 * three + 0.387 * q))
    aside = k.lu / (0.27 + 0.494 * q - 0.075 * t * (1.0 - q))
    over = (1.0 - t * t) / greatest(sqrt(far * far + aside * aside), 1.0)
    return Surface(k.au, k.am, k.av, k.cu, k.cv, k.lu * over, k.lv * over, k.s * over)
