"""Rolling and torsional resistance of a contact point, which the lecture leaves out: torques that have a length as
coefficient.

Rolling resistance: |m_t| <= delta g_n against the relative rolling (the two planar components of the angular velocity);
torsional: |m_n| <= tau g_n against the relative spin about the normal. delta and tau are lengths in m; a wheel of
radius r has the textbook's dimensionless coefficient c = delta / r. As for sliding, the torque that remains at its
limit is exactly opposite to the motion it resists.
"""

from __future__ import annotations

from stiction.core.contact_space import to_contact
from stiction.core.friction.coulomb import secular_friction
from stiction.core.jit import jit
from stiction.core.lanes import greatest, least, sqrt
from stiction.core.vec import Vec3, congruent, transpose

ROLLING_STEPS = 4


@jit
def resisting_torque(inverse_inertia, B, spin, torque, rolling, torsional, gn):
    """The angular impulse (N m s, contact coordinates) that replaces ``torque``.

    ``inverse_inertia`` is the sum of both bodies' in world axes, ``spin`` the relative angular velocity w_A - w_B
    that is there now, ``torque`` the angular impulse already applied, ``gn`` the normal impulse.
    """
    A = congruent(transpose(B), inverse_inertia)
    v = to_contact(B, spin)
    free = v + A @ torque
    m1, m2, _ = secular_friction(A.yy, A.yz, A.zz, free.y, free.z, rolling * gn)
    limit = torsional * gn
    mn = min(max(torque.x + v.x / A.xx, -limit), limit)
    return Vec3(mn, m1, m2)


@jit
def rolling_impulse(kuu, kuv, kvv, bu, bv, limit):
    """The angular impulse in the plane that stops the rolling (b_u, b_v) it meets, or of size ``limit`` if that is
    less.

    ``k`` is the response of the rolling to it, and what remains is opposite to the torque, by the secular equation as
    in ``secular_friction``; but with a fixed number of steps and without a branch, for numbers and for lanes.
    """
    zero = limit - limit
    alpha = zero
    tiny = 1e-30
    for _ in range(ROLLING_STEPS):
        a, c = kuu + alpha, kvv + alpha
        det = 1.0 / greatest(a * c - kuv * kuv, tiny)
        mu, mv = (c * bu - kuv * bv) * det, (a * bv - kuv * bu) * det
        size2 = mu * mu + mv * mv + tiny
        size = sqrt(size2)
        du, dv = (c * mu - kuv * mv) * det, (a * mv - kuv * mu) * det
        step = size2 / (mu * du + mv * dv + tiny) * (size - limit) / greatest(limit, 1e-6 * size + tiny)
        alpha = greatest(alpha + step, 0.0)
    a, c = kuu + alpha, kvv + alpha
    det = 1.0 / greatest(a * c - kuv * kuv, tiny)
    mu, mv = (c * bu - kuv * bv) * det, (a * bv - kuv * bu) * det
    size = sqrt(mu * mu + mv * mv + tiny)
    scale = least(limit / size, 1.0)
    return mu * scale, mv * scale
