"""The Coulomb law of one contact point, as an impulse in contact space.

Everything is in contact coordinates (x along the normal, y and z in the plane) and in the signs of ``contact_space``:
``b`` is the collision velocity that the impulse has to deal with, less what may remain of it; K g is what
it takes away.

Laws for the same point, so that they can be compared:

``coulomb_impulse``     the right one: stick inside the cone, else slide with friction exactly along the slip
                        that remains
``clipped_impulse``     the book's (Millington, "Game Physics Engine Development"), and most engines': the sticking
                        impulse scaled back onto the cone, which points along K^-1 b and not along the slip
``literal_change``      the slides': a case distinction on velocities, whose sliding case is not normalised
``secular_friction``    the right one for a normal impulse that is already known (planar block alone)
``limited_impulse``     the same for numbers and for lanes, in a few steps
"""

from __future__ import annotations

import math

from stiction.core.contact_space import maximal_impulse
from stiction.core.jit import jit
from stiction.core.lanes import any_of, greatest, least, select, sqrt
from stiction.core.vec import Vec3

NEWTON_STEPS = 30
CONVERGED = 1e-13
LIMITED_STEPS = 4
"""They leave 3e-5 rad of the direction where one tangent is thirty times as heavy as the other, and on the average of
such points 3e-9."""
CLOSE = 1e-6
"""Of the limit. From there the direction is as good as single precision."""
TINY, LEAST_AIM = 1e-30, 1e-14


@jit
def coulomb_impulse(K, b, mu_stick, mu_slide):
    """The impulse g of one contact that obeys Signorini's condition and Coulomb's law together.

    b.x <= 0 is a contact that opens: no impulse. Otherwise the sticking impulse K^-1 b, if it lies inside the cone of
    ``mu_stick``. Otherwise the body slides: |g_t| = mu_slide g_n, and the slip that remains is alpha g_t with
    alpha > 0, so friction is exactly opposite to sliding. With the normal eliminated, S = K_tt - k k^T / K_nn, this is
    the trust-region (secular) equation |(S + alpha 1)^-1 b'| = mu g_n(alpha), solved by safeguarded Newton steps on
    1 - mu g_n / |g_t|, linear in alpha for an isotropic contact (Conn, Gould, Toint, "Trust-Region Methods", 7.3).

    Returns g and whether it sticks.
    """
    if b.x <= 0.0:
        return Vec3(0.0, 0.0, 0.0), False
    inv_knn = 1.0 / K.xx
    s11 = K.yy - K.yx * K.yx * inv_knn
    s12 = K.yz - K.yx * K.zx * inv_knn
    s22 = K.zz - K.zx * K.zx * inv_knn
    b1 = b.y - K.yx * b.x * inv_knn
    b2 = b.z - K.zx * b.x * inv_knn

    det = s11 * s22 - s12 * s12
    g1 = (s22 * b1 - s12 * b2) / det
    g2 = (s11 * b2 - s12 * b1) / det
    gn = (b.x - K.yx * g1 - K.zx * g2) * inv_knn
    gt = math.sqrt(g1 * g1 + g2 * g2)
    if gt <= mu_stick * gn:
        return Vec3(gn, g1, g2), True
    if mu_slide <= 0.0:
        return Vec3(b.x * inv_knn, 0.0, 0.0), False

    # alpha is bracketed: at low the impulse is too far out, at high it is inside the cone
    alpha, low, high = 0.0, 0.0, math.inf
    for _ in range(NEWTON_STEPS):
        excess = gt - mu_slide * gn
        if abs(excess) <= CONVERGED * gt:
            break
        if excess > 0.0:
            low = alpha
        else:
            high = alpha
        # derivative of the impulse: g' = -(S + alpha 1)^-1 g
        d1 = -((s22 + alpha) * g1 - s12 * g2) / det
        d2 = -((s11 + alpha) * g2 - s12 * g1) / det
        dn = -(K.yx * d1 + K.zx * d2) * inv_knn
        slope = mu_slide * (dn * gt * gt - gn * (g1 * d1 + g2 * d2)) / (gt * gt)
        step = excess / slope if slope > 0.0 else -1.0
        alpha += step
        if not (low < alpha < high):
            alpha = 2.0 * low + s11 + s22 if high == math.inf else 0.5 * (low + high)
        det = (s11 + alpha) * (s22 + alpha) - s12 * s12
        g1 = ((s22 + alpha) * b1 - s12 * b2) / det
        g2 = ((s11 + alpha) * b2 - s12 * b1) / det
        gn = (b.x - K.yx * g1 - K.zx * g2) * inv_knn
        gt = math.sqrt(g1 * g1 + g2 * g2)
    return Vec3(gn, g1, g2), False


@jit
def secular_friction(k11, k12, k22, b1, b2, limit):
    """The planar impulse for a known limit mu g_n: stick if |K_t^-1 b| <= limit, else |(K_t + alpha 1)^-1 b| = limit.

    ``k11, k12, k22`` are the planar block of K, ``b1, b2`` the planar velocity without this impulse.
    Returns g1, g2 and whether it sticks. Used for forces in the plane and for rolling torques alike.
    """
    det = k11 * k22 - k12 * k12
    g1 = (k22 * b1 - k12 * b2) / det
    g2 = (k11 * b2 - k12 * b1) / det
    size = math.sqrt(g1 * g1 + g2 * g2)
    if size <= limit:
        return g1, g2, True
    if limit <= 0.0:
        return 0.0, 0.0, False
    alpha = 0.0
    for _ in range(NEWTON_STEPS):
        if size - limit <= CONVERGED * limit:
            break
        # Newton on 1/limit - 1/|g|: concave in alpha, so the steps from alpha = 0 never overshoot
        d1 = ((k22 + alpha) * g1 - k12 * g2) / det
        d2 = ((k11 + alpha) * g2 - k12 * g1) / det
        alpha += (size - limit) / limit * size * size / (g1 * d1 + g2 * d2)
        det = (k11 + alpha) * (k22 + alpha) - k12 * k12
        g1 = ((k22 + alpha) * b1 - k12 * b2) / det
        g2 = ((k11 + alpha) * b2 - k12 * b1) / det
        size = math.sqrt(g1 * g1 + g2 * g2)
    return g1, g2, False


@jit
def limited_impulse(kuu, kuv, kvv, bu, bv, limit):
    """The planar impulse K^-1 b, or that of size ``limit`` if this is less: as :func:`secular_friction`, for lanes too,
    and in no more than a fixed number of steps.

    They begin where |b| = limit (largest eigenvalue + alpha), which is never too far: so alpha only grows, until |g| is
    CLOSE to the limit. A lane that has come there stays, so that it does not matter who else goes on.
    """
    middle, half = 0.5 * (kuu + kvv), 0.5 * (kuu - kvv)
    largest = middle + sqrt(half * half + kuv * kuv)
    size = sqrt(bu * bu + bv * bv)
    aim = greatest(limit, 1e-6 * size / (largest + TINY) + LEAST_AIM)
    alpha = greatest(size / aim - largest, 0.0)
    gu, gv = bu, bv
    for k in range(LIMITED_STEPS + 1):
        a, c = kuu + alpha, kvv + alpha
        det = 1.0 / greatest(a * c - kuv * kuv, TINY)
        gu, gv = (c * bu - kuv * bv) * det, (a * bv - kuv * bu) * det
        size2 = gu * gu + gv * gv + TINY
        size = sqrt(size2)
        going = size > aim * (1.0 + CLOSE)
        if k == LIMITED_STEPS or not any_of(going):
            break
        du, dv = (c * gu - kuv * gv) * det, (a * gv - kuv * gu) * det
        step = size2 / (gu * du + gv * dv + TINY) * (size - aim) / aim
        alpha = select(going, alpha + step, alpha)
    scale = least(limit / size, 1.0)
    return gu * scale, gv * scale


@jit
def clipped_impulse(K, b, mu):
    """The sticking impulse, scaled back onto the cone along its own direction; J_n is then found anew.

    The rule of the book behind the lecture and of most engines: its friction is 6 to 32 degrees off the slip direction
    on a sliding box. Kept to be compared with. Returns g and whether it sticks.
    """
    if b.x <= 0.0:
        return Vec3(0.0, 0.0, 0.0), False
    g = maximal_impulse(K, b)
    size = math.sqrt(g.y * g.y + g.z * g.z)
    if size <= mu * g.x:
        return g, True
    y, z = g.y / size, g.z / size
    gn = b.x / (K.xx + mu * (K.xy * y + K.xz * z))
    return Vec3(gn, mu * gn * y, mu * gn * z), False


@jit
def literal_change(v, restitution, mu_static, mu_dynamic):
    """v_mu: the change of velocity by impact and friction, read word for word from the slides.

    Slide "Friction as impulses": remove v_planar if |v_planar| <= v_C mu_static, else v_planar mu_dynamic. The first is
    the friction cone in velocity space, true only for a point mass; the second scales the slip by (1 - mu_dynamic) at
    every micro-collision, however light its load. Returns v_mu in contact coordinates and whether it sticks.
    """
    speed = math.sqrt(v.y * v.y + v.z * v.z)
    sticks = speed <= v.x * mu_static
    scale = 1.0 if sticks else mu_dynamic
    return Vec3(v.x * (1.0 + restitution), v.y * scale, v.z * scale), sticks
