"""Contact space: the heart of the lecture. How fast a contact point moves, and how an impulse there changes that.

Slide titles are quoted from "PSE Game Physics, Session (7) Friction" (Atanasov, Neumann, Schreiber, 2011).

Signs, everywhere in this package: the contact normal n points from body A to body B. The collision velocity is that of
A's point seen from B, u = v_A - v_B, as in the lecture; so v_C = n . u is positive while the bodies approach. An
impulse g (in contact coordinates: normal first, then the two planar directions) acts with +g on B and with -g on A,
and changes the collision velocity by -K g. The impulse that removes a velocity v is then simply g = K^-1 v: the normal
impulse is positive where bodies push, and friction points along the slip of A that it takes away.

Convention: for a rotation M^-T = M, so the slides' M^-T I^-1 M^T is M I^-1 M^T, which with column vectors and M = R,
the rotation from the body's axes to the world's, is the R I^-1 R^T of this package. The slides' chain u = S_p B,
dr = I^-1 u, dv = dr S_p (-1), B^-1 dv is read as K_angular = B^T (-S_p I^-1 S_p) B, with S_p to the left of dr: to its
right it would be row-vector notation, in which dr S_p = dr x p needs no (-1), and B would stand between the two S_p.
K must come out symmetric and positive definite.
"""

from __future__ import annotations

import math

from stiction.core.jit import jit
from stiction.core.vec import Mat33, Vec3, columns, congruent, cross, dot, inverse, transpose


@jit
def contact_basis(n):
    """B, the transformation from contact to world coordinates: its columns are n, t1, t2, right-handed.

    Slide "Friction as impulses", figure "Friction collision basis". The planar pair is continuous in n but for one
    direction, without a square root of small numbers: Duff et al., "Building an orthonormal basis, revisited",
    J. Comput. Graph. Tech. 6(1), 2017.
    """
    sign = math.copysign(1.0, n.z)
    a = -1.0 / (sign + n.z)
    b = n.x * n.y * a
    t1 = Vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x)
    t2 = Vec3(b, sign + n.y * n.y * a, -n.y)
    return columns(n, t1, t2)


@jit
def point_velocity(v, w, r):
    """Velocity of the point at arm r of a body: v + w x r."""
    return v + cross(w, r)


@jit
def collision_velocity(va, wa, ra, vb, wb, rb):
    """v_collision = v_A - v_B at the contact point. Slide "Friction as impulses" (Worksheet 6, slide 16)."""
    return point_velocity(va, wa, ra) - point_velocity(vb, wb, rb)


@jit
def planar_velocity(u, n):
    """v_planar = v_collision - n v_C, with v_C = n . v_collision. Slide "Friction as impulses"."""
    return u - n * dot(n, u)


@jit
def skew(v):
    """S_v, the skew matrix with S_v x = v x x. Slide "The skew-symmetric matrix"."""
    o = v.x - v.x
    return Mat33(o, -v.z, v.y, v.z, o, -v.x, -v.y, v.x, o)


@jit
def impulsive_torque(r, B):
    """u = S_p B: the torque of a unit impulse in each of the three contact directions, one a column.

    Slide "The algorithm for angular motion", step 1.
    """
    return skew(r) @ B


@jit
def rotation_change(inverse_inertia, u):
    """dr = I^-1 u with I^-1 in world axes: the change of angular velocity a unit impulse, one a column.

    Slide "The algorithm for angular motion", step 2 (there M^-T I^-1 M^T u).
    """
    return inverse_inertia @ u


@jit
def rotation_to_velocity(r, dr):
    """dv_r = -S_p dr = dr x p: the change of the contact point's velocity by that rotation, one a column.

    Slide "The algorithm for angular motion", step 3; x x v = -S_v x gives the (-1).
    """
    return -(skew(r) @ dr)


@jit
def to_contact(B, dv):
    """B^-1 dv = B^T dv: into contact coordinates. Slide "The algorithm for angular motion", step 4."""
    return transpose(B) @ dv


@jit
def inverse_mass_matrix(inverse_mass):
    """m^-1 1: the velocity of a unit impulse through linear motion, as a matrix to be added to the angular one.

    Slide "The algorithm for linear motion".
    """
    o = inverse_mass - inverse_mass
    return Mat33(inverse_mass, o, o, o, inverse_mass, o, o, o, inverse_mass)


@jit
def velocity_per_impulse(inverse_mass, inverse_inertia, r, B):
    """One body's share of K: the change of its contact velocity a unit impulse, all in contact coordinates."""
    u = impulsive_torque(r, B)
    dr = rotation_change(inverse_inertia, u)
    dv = rotation_to_velocity(r, dr)
    return inverse_mass_matrix(inverse_mass) + to_contact(B, dv)


@jit
def contact_matrix(ma, ia, ra, mb, ib, rb, B):
    """K: the sum of both bodies' shares, (3, 3), in 1/kg. Symmetric and positive definite if a body can move.

    ``ma, mb`` are inverse masses, ``ia, ib`` inverse inertia tensors in world axes, ``ra, rb`` arms to the point.
    """
    return velocity_per_impulse(ma, ia, ra, B) + velocity_per_impulse(mb, ib, rb, B)


@jit
def impulse_per_velocity(K):
    """Delta g = Delta v^-1, the inverse of K. Slide "Angular motion to velocity"."""
    return inverse(K)


@jit
def maximal_impulse(K, v_mu):
    """g_max = Delta g v_mu: the impulse that makes the whole change of velocity v_mu.

    Slide "Angular motion to velocity".
    """
    return impulse_per_velocity(K) @ v_mu


@jit
def world_inverse_inertia(R, inverse_inertia):
    """R I^-1 R^T: the inverse inertia tensor in world axes (the slides' M^-T I^-1 M^T)."""
    return congruent(R, inverse_inertia)
