"""Contacts of an ellipsoid: with a plane in closed form, with a ball or another ellipsoid by Newton's method.

With M = R diag(a^2, b^2, c^2) R^T an ellipsoid reaches h(n) = sqrt(n . M n) far along the unit vector n, at the point
M n / h. One point each: what is smooth rolls, so neither the point nor the normal may jump from step to step.
"""

from __future__ import annotations

from stiction.core.collide.capsule import perpendicular
from stiction.core.collide.hulls import POINT, ellipsoid_point, is_ellipsoid
from stiction.core.collide.manifold import emit
from stiction.core.jit import jit
from stiction.core.vec import Vec3, cross, dot, length, transpose

NEWTONS = 8
SETTLED = 1e-14
"""Steps of Newton's method that turn the normal by less (rad) end it."""


@jit
def ellipsoid_plane(contacts, tags, count, a, A, b, n, offset, origin, margin):
    """The lowest point. ``offset`` is the height of the origin over the plane, negated."""
    p = _reach(A, -n)
    separation = dot(n, p) - offset
    if separation > margin:
        return count
    return emit(contacts, tags, count, a, b, origin + p - n * (0.5 * separation), -n, separation, 0)


@jit
def is_smooth(X):
    """Whether the core has one curvature or another everywhere: an ellipsoid, or the centre of a ball."""
    return is_ellipsoid(X) or X.hull == POINT


@jit
def sharpen(A, B, n):
    """From a direction n that is nearly the best one for two smooth cores to the best one; also sigma and the points.

    The gradient of sigma(n) on the sphere of directions is the part t of w_b - w_a across n, its second derivative
    -(Q + sigma 1), where Q is the sum of the two shapes' matrices of radii of curvature: it is the largest where that
    is negative, and Newton's step is (Q + sigma 1)^-1 t.
    """
    wa, wb = _reach(A, n), _reach(B, -n)
    sigma = dot(n, wb - wa)
    for _ in range(NEWTONS):
        u = perpendicular(n)
        v = cross(n, u)
        a_uu, a_uv, a_vv = _radii(A, n, u, v)
        b_uu, b_uv, b_vv = _radii(B, n, u, v)
        uu, uv, vv = a_uu + b_uu + sigma, a_uv + b_uv, a_vv + b_vv + sigma
        determinant = uu * vv - uv * uv
        if determinant <= 0.0 or uu + vv <= 0.0:
            break
        t = wb - wa
        tu, tv = dot(t, u), dot(t, v)
        step = u * ((vv * tu - uv * tv) / determinant) + v * ((uu * tv - uv * tu) / determinant)
        m = n + step
        m = m * (1.0 / length(m))
        pa, pb = _reach(A, m), _reach(B, -m)
        reached = dot(m, pb - pa)
        if reached < sigma - SETTLED * (A.small + B.small):
            break  # too far away for this method
        n, sigma, wa, wb = m, reached, pa, pb
        if length(step) < SETTLED:
            break
    return n, sigma, wa, wb


@jit
def _reach(X, n):
    """The point that lies farthest along n."""
    return X.p + X.R @ ellipsoid_point(X.scale, transpose(X.R) @ n)


@jit
def _radii(X, n, u, v):
    """The matrix of radii of curvature where X reaches farthest along n, in the axes u and v across it, m.

    This is the second derivative of h: M / h - (M n)(M n)^T / h^3.
    """
    s, to_x = X.scale, transpose(X.R)
    a, b, c = _scaled(s, to_x @ n), _scaled(s, to_x @ u), _scaled(s, to_x @ v)
    h = length(a)
    if h == 0.0:
        return 0.0, 0.0, 0.0
    a = a * (1.0 / h)
    ab, ac = dot(a, b), dot(a, c)
    return (dot(b, b) - ab * ab) / h, (dot(b, c) - ab * ac) / h, (dot(c, c) - ac * ac) / h


@jit
def _scaled(s, m):
    return Vec3(s.x * m.x, s.y * m.y, s.z * m.z)
