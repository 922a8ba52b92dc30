"""Friction over a contact patch: one element per manifold, a force and a torque at the centre of pressure.

Coulomb's law, integrated over a face with linear pressure, limits force and torque together by a convex *limit surface*
(Goyal, Ruina, Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991). Four corners with a cone each are a
poor copy of it (a spinning crate stops almost twice too fast); here it is a sextic, fitted to the exact integral to
0.1 to 0.6 % (docs/design/limit-surface.md):

    Phi(g) = |g|^2 + z^2 [ c_u x^2 + c_v y^2 + z (l_u x + l_v y) + a_u x^4 + a_m x^2 y^2 + a_v y^4 + s z y^3 ] <= 1

with g = (x, y, z) = (F_u, F_v, T / T_m) / (mu N), (u, v) the principal axes of the pressure, and T_m
the torque per mu N of pure spinning. Sliding is associated: slip = lambda grad Phi with lambda >= 0, hence friction
dissipates as much as it can. A point has T_m = 0: then the surface is the circle of Coulomb's law and what is solved is
the secular equation.

All functions run on numbers and on lanes alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stiction.core.jit import jit
from stiction.core.lanes import any_of, greatest, least, select, size_of, sqrt
from stiction.core.vec import Vec3, dot

SECULAR_STEPS = 2
NEWTON_STEPS = 12
"""At most; the first is the last for most that slid before."""
WIDE_STEPS, WIDE, NARROW = 4, 0.5, 0.2
"""How far a step may go, on a surface of radius one: two of 50,000 random problems would go round in circles from cold
on a lopsided surface."""
SETTLED = 1e-3
"""A Newton step shorter than this leaves an error of about its square: rounding, in single precision."""
RADIAL_STEPS = 2
TINY = 1e-18
FAR = 1.4
"""Every surface lies inside the ball of this radius squared, and Phi grows along every ray until there."""


class Surface(NamedTuple):
    """Coefficients of the limit surface's terms: four of sixth order, four of fourth order."""

    au: Any
    am: Any
    av: Any
    cu: Any
    cv: Any
    lu: Any
    lv: Any
    s: Any


class Sym3(NamedTuple):
    """A symmetric 3 x 3 matrix."""

    xx: Any
    xy: Any
    xz: Any
    yy: Any
    yz: Any
    zz: Any


@jit
def times(A, g):
    """A g"""
    return Vec3(
        A.xx * g.x + A.xy * g.y + A.xz * g.z,
        A.xy * g.x + A.yy * g.y + A.yz * g.z,
        A.xz * g.x + A.yz * g.y + A.zz * g.z,
    )


@jit
def inverse_sym(A):
    """A^-1 of a symmetric positive definite matrix, by cofactors."""
    a = A.yy * A.zz - A.yz * A.yz
    b = A.xz * A.yz - A.xy * A.zz
    c = A.xy * A.yz - A.xz * A.yy
    d = 1.0 / (A.xx * a + A.xy * b + A.xz * c)
    return Sym3(
        a * d, b * d, c * d,
        (A.xx * A.zz - A.xz * A.xz) * d, (A.xy * A.xz - A.xx * A.yz) * d,
        (A.xx * A.yy - A.xy * A.xy) * d,
    )  # fmt: skip


@jit
def arm_of_pressure(Mu, Mv):
    """kappa: mean arm of a patch over its root mean square arm, by q = sqrt(M_v / M_u) <= 1.

    A fit to kappa = [sqrt(1 + q^2) + asinh(q) / 2q + (q^2 / 2) asinh(1/q)] / sqrt(3 (1 + q^2)), the parallelogram's,
    within 2e-4. Returns q and kappa.
    """
    q = sqrt(Mv / (Mu + TINY))
    return q, 0.8662 + q * q * (1.2705 - 2.3751 * sqrt(q) + 1.3058 * q - 0.1302 * q * q)


@jit
def terms(g, k):
    """The terms of fourth and of sixth order of Phi(g)."""
    x2, y2, z2 = g.x * g.x, g.y * g.y, g.z * g.z
    fourth = k.cu * x2 + k.cv * y2 + g.z * (k.lu * g.x + k.lv * g.y)
    sixth = x2 * (k.au * x2 + k.am * y2) + y2 * (k.av * y2 + k.s * g.y * g.z)
    return z2 * fourth, z2 * sixth


@jit
def phi(g, k):
    """Phi(g): 1 on the limit surface, less inside."""
    fourth, sixth = terms(g, k)
    return dot(g, g) + (fourth + sixth)


@jit
def level(g, k):
    """Phi(g) near the surface, and something above 1 far outside, where terms of sixth order may bend Phi back to 0."""
    size = dot(g, g)
    return select(size > FAR, size, phi(g, k))


@jit
def gradient(g, k):
    """grad Phi"""
    x2, y2, z2 = g.x * g.x, g.y * g.y, g.z * g.z
    gx, gy = k.cu + k.am * y2 + 2.0 * k.au * x2, k.cv + k.am * x2 + 2.0 * k.av * y2
    Q = 0.5 * (x2 * (gx + k.cu) + y2 * (gy + k.cv))
    z3, lop = z2 * g.z, k.s * y2
    return Vec3(
        2.0 * g.x * (1.0 + z2 * gx) + z3 * k.lu,
        2.0 * g.y * (1.0 + z2 * gy) + z3 * (k.lv + 3.0 * lop),
        2.0 * g.z * (1.0 + Q) + 3.0 * z2 * (k.lu * g.x + (k.lv + lop) * g.y),
    )


@jit
def hessian(g, k):
    """The matrix of second derivatives of Phi."""
    x2, y2, z2 = g.x * g.x, g.y * g.y, g.z * g.z
    gx, gy = k.cu + k.am * y2 + 2.0 * k.au * x2, k.cv + k.am * x2 + 2.0 * k.av * y2
    Q = 0.5 * (x2 * (gx + k.cu) + y2 * (gy + k.cv))
    lop = k.s * y2
    return Sym3(
        2.0 + 2.0 * z2 * (gx + 4.0 * k.au * x2),
        4.0 * z2 * k.am * g.x * g.y,
        4.0 * g.x * g.z * gx + 3.0 * z2 * k.lu,
        2.0 + 2.0 * z2 * (gy + 4.0 * k.av * y2 + 3.0 * k.s * g.y * g.z),
        4.0 * g.y * g.z * gy + 3.0 * z2 * (k.lv + 3.0 * lop),
        2.0 + 2.0 * Q + 6.0 * g.z * (k.lu * g.x + (k.lv + lop) * g.y),
    )


@jit
def onto_surface(g, k):
    """g scaled onto the surface: for a g of length one and s the square of the scale, s + C s^2 + B s^3 = 1, by one
    step of Halley's method from s = 1 and two of Newton's.

    Only a length of one keeps C and B, which are of fourth and sixth order, within bounds.
    """
    g = g * (1.0 / sqrt(dot(g, g) + TINY))
    C, B = terms(g, k)
    total, slope, bend = C + B, 1.0 + 2.0 * C + 3.0 * B, C + 3.0 * B
    s = 1.0 - total * slope / (slope * slope - total * bend)  # within 1e-2
    for _ in range(RADIAL_STEPS):
        s = s - (s + s * s * (C + B * s) - 1.0) / (1.0 + s * (2.0 * C + 3.0 * B * s))
    return g * sqrt(greatest(s, 0.0))


@jit
def _shifted(A, shift):
    return Sym3(A.xx + shift, A.xy, A.xz, A.yy + shift, A.yz, A.zz + shift)


@jit
def _on_ball(A, b, g):
    """|(A + alpha 1)^-1 b| = 1 by Newton steps on 1/|g| - 1 from alpha = 0: the secular equation, g = A^-1 b."""
    alpha = A.xx - A.xx
    for _ in range(SECULAR_STEPS):
        M = inverse_sym(_shifted(A, alpha))
        g = times(M, b)
        q2 = dot(g, g) + TINY
        q = sqrt(q2)
        alpha = greatest(alpha + q2 / (dot(g, times(M, g)) + TINY) * (q - 1.0), 0.0)
    return times(inverse_sym(_shifted(A, alpha)), b)


@jit
def _residual(A, b, g, k):
    """r = b - A g, its part along the normal of the surface lambda = r . grad / |grad|^2, and |r - lambda grad|^2."""
    r = b - times(A, g)
    d = gradient(g, k)
    along = greatest(dot(r, d) / (dot(d, d) + TINY), 0.0)
    rest = r - d * along
    return r, d, along, dot(rest, rest)


@jit
def choose3(mask, a, b):
    """Of a and b, lane by lane."""
    return Vec3(select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z))


@jit
def slide(A, b, last, k, wanted):
    """The friction g on the surface whose slip b - A g is along its outward normal.

    ``A`` is mu N D K_P D with D = diag(1, 1, T_m), ``b`` the slip D (v_u, v_v, w_n) without this friction, ``last``
    the g of the pass before; only lanes that are ``wanted`` are solved to the end. Starts from the better of ``last``
    and the secular equation on the unit ball; Newton steps with the constraint, each put back onto the surface, until
    they are short. That is one step where nothing changed since ``last``, two or three from cold, and six at worst
    where the torque is a small one, as that of torsional resistance at a point.
    """
    cold = onto_surface(_on_ball(A, b, last), k)
    warm = onto_surface(last, k)
    _, _, _, miss_cold = _residual(A, b, cold, k)
    _, _, _, miss_warm = _residual(A, b, warm, k)
    g = choose3(miss_warm < miss_cold, warm, cold)
    going = wanted
    for step_number in range(NEWTON_STEPS):
        reach = WIDE if step_number < WIDE_STEPS else NARROW
        r, d, along, _ = _residual(A, b, g, k)
        H = hessian(g, k)
        M = inverse_sym(
            Sym3(
                A.xx + along * H.xx,
                A.xy + along * H.xy,
                A.xz + along * H.xz,
                A.yy + along * H.yy,
                A.yz + along * H.yz,
                A.zz + along * H.zz,
            )
        )
        rest = r - d * along
        Md = times(M, d)
        rest = rest - d * (dot(rest, Md) / (dot(d, Md) + TINY))
        step = times(M, rest)
        largest = greatest(greatest(size_of(step.x), size_of(step.y)), size_of(step.z))
        # what a lane gets must not depend on how long others of its block go on: the others are masked
        g = choose3(going, onto_surface(g + step * least(reach / (largest + TINY), 1.0), k), g)
        going = going & (largest > SETTLED)
        if not any_of(going):
            break
    return g
