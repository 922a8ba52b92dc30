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
from stiction.core.vec import Vec3, congruent, transpose


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
