"""The normal impulses of one manifold, up to four points, as one small complementarity problem.

All points share a normal, so they see only three of the manifold's six directions: how fast the anchor closes, and the
spin about the two tangents. A unit impulse at the point (x, y) of the plane is the force n with the torque (y, -x)
about (u, v), and the closing speed there is c = c_n + y w_u - x w_v; hence the matrix of the points,
A_kl = G_k K G_l^T with G = (1, y, -x), from the manifold's 3 x 3 block alone. It has rank three; the compliance of the
soft contact on its diagonal makes it regular, and decides how four points share a load.

A and its inverse are constant over a step. A pass takes one Newton step on all points; where an impulse comes out
negative, that point is taken out of the inverse by one sweep, worst first, which is exact for the points that remain.

All functions run on numbers and on lanes alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stiction.core.jit import jit
from stiction.core.lanes import any_of, greatest, least, select


class Four(NamedTuple):
    """A number for each of four points."""

    a: Any
    b: Any
    c: Any
    d: Any


class Sym4(NamedTuple):
    """A symmetric 4 x 4 matrix, upper triangle by rows."""

    aa: Any
    ab: Any
    ac: Any
    ad: Any
    bb: Any
    bc: Any
    bd: Any
    cc: Any
    cd: Any
    dd: Any


@jit
def point_matrix(k, x, y, here):
    """A_kl for the points ``here`` (1, else 0); a missing point is by itself, with 1 on the diagonal.

    ``k`` is (nn, nu, nv, uu, uv, vv) of the manifold's matrix: response of (c_n, w_u, w_v) to (N, T_u, T_v).
    """
    return Sym4(
        _entry(k, x.a, y.a, x.a, y.a) * here.a + (1.0 - here.a),
        _entry(k, x.a, y.a, x.b, y.b) * (here.a * here.b),
        _entry(k, x.a, y.a, x.c, y.c) * (here.a * here.c),
        _entry(k, x.a, y.a, x.d, y.d) * (here.a * here.d),
        _entry(k, x.b, y.b, x.b, y.b) * here.b + (1.0 - here.b),
        _entry(k, x.b, y.b, x.c, y.c) * (here.b * here.c),
        _entry(k, x.b, y.b, x.d, y.d) * (here.b * here.d),
        _entry(k, x.c, y.c, x.c, y.c) * here.c + (1.0 - here.c),
        _entry(k, x.c, y.c, x.d, y.d) * (here.c * here.d),
        _entry(k, x.d, y.d, x.d, y.d) * here.d + (1.0 - here.d),
    )


@jit
def _entry(k, xk, yk, xl, yl):
    nn, nu, nv, uu, uv, vv = k
    return nn + (yk + yl) * nu - (xk + xl) * nv + yk * yl * uu - (yk * xl + xk * yl) * uv + xk * xl * vv


@jit
def inverse_of_points(A, here):
    """A^-1 by 2 x 2 blocks; the rows of missing points are zero, so that they never get an impulse."""
    d = 1.0 / (A.aa * A.bb - A.ab * A.ab)
    p, q, r = A.bb * d, -A.ab * d, A.aa * d  # inverse of the upper left block
    e, f = p * A.ac + q * A.bc, p * A.ad + q * A.bd  # that times the upper right block
    g, h = q * A.ac + r * A.bc, q * A.ad + r * A.bd
    s = A.cc - A.ac * e - A.bc * g  # Schur complement
    t = A.cd - A.ac * f - A.bc * h
    u = A.dd - A.ad * f - A.bd * h
    d = 1.0 / (s * u - t * t)
    cc, cd, dd = u * d, -t * d, s * d
    ac, ad = -(e * cc + f * cd), -(e * cd + f * dd)
    bc, bd = -(g * cc + h * cd), -(g * cd + h * dd)
    return Sym4(
        (p - e * ac - f * ad) * here.a, (q - e * bc - f * bd) * (here.a * here.b), ac * (here.a * here.c),
        ad * (here.a * here.d), (r - g * bc - h * bd) * here.b, bc * (here.b * here.c), bd * (here.b * here.d),
        cc * here.c, cd * (here.c * here.d), dd * here.d,
    )  # fmt: skip


@jit
def times4(A, r):
    """A r"""
    return Four(
        A.aa * r.a + A.ab * r.b + A.ac * r.c + A.ad * r.d,
        A.ab * r.a + A.bb * r.b + A.bc * r.c + A.bd * r.d,
        A.ac * r.a + A.bc * r.b + A.cc * r.c + A.cd * r.d,
        A.ad * r.a + A.bd * r.b + A.cd * r.c + A.dd * r.d,
    )


@jit
def lowest(x):
    """The smallest of four."""
    return least(least(x.a, x.b), least(x.c, x.d))


@jit
def less4(a, b):
    """a - b"""
    return Four(a.a - b.a, a.b - b.b, a.c - b.c, a.d - b.d)


@jit
def highest(x):
    """The largest of four."""
    return greatest(greatest(x.a, x.b), greatest(x.c, x.d))


@jit
def non_negative(load, A):
    """Loads that solve the problem with load >= 0 instead of ``load``, the solution without that limit, A its inverse.

    While some load is negative the most negative one is set to zero, and the others get what that takes from them:
    load -= A_i load_i / A_ii, A -= A_i A_i^T / A_ii. At most four times.
    """
    for _ in range(4):
        worst = lowest(load)
        if not any_of(worst < 0.0):
            break
        # e is the worst point's unit vector in lanes where it is negative, else zero
        out = worst < 0.0
        ea = select(out & (load.a <= worst), 1.0, worst - worst)
        eb = select(out & (load.b <= worst), 1.0, worst - worst) * (1.0 - ea)
        ec = select(out & (load.c <= worst), 1.0, worst - worst) * (1.0 - ea - eb)
        ed = select(out & (load.d <= worst), 1.0, worst - worst) * (1.0 - ea - eb - ec)
        e = Four(ea, eb, ec, ed)
        col = times4(A, e)
        pivot = col.a * ea + col.b * eb + col.c * ec + col.d * ed
        inverse = select(pivot > 0.0, 1.0 / greatest(pivot, 1e-30), worst - worst)
        f = least(worst, 0.0) * inverse
        load = Four(
            (load.a - col.a * f) * (1.0 - ea), (load.b - col.b * f) * (1.0 - eb),
            (load.c - col.c * f) * (1.0 - ec), (load.d - col.d * f) * (1.0 - ed),
        )  # fmt: skip
        A = _without(A, col, inverse, e)
    return Four(greatest(load.a, 0.0), greatest(load.b, 0.0), greatest(load.c, 0.0), greatest(load.d, 0.0))


@jit
def _without(A, col, inverse, e):
    """The inverse of the matrix without the point e: A - col col^T / pivot, its row and column zero."""
    ka, kb, kc, kd = 1.0 - e.a, 1.0 - e.b, 1.0 - e.c, 1.0 - e.d
    fa, fb, fc, fd = col.a * inverse, col.b * inverse, col.c * inverse, col.d * inverse
    return Sym4(
        (A.aa - col.a * fa) * ka, (A.ab - col.a * fb) * (ka * kb), (A.ac - col.a * fc) * (ka * kc),
        (A.ad - col.a * fd) * (ka * kd), (A.bb - col.b * fb) * kb, (A.bc - col.b * fc) * (kb * kc),
        (A.bd - col.b * fd) * (kb * kd), (A.cc - col.c * fc) * kc, (A.cd - col.c * fd) * (kc * kd),
        (A.dd - col.d * fd) * kd,
    )  # fmt: skip
