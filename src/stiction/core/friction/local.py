"""One contact of many, with the impulses of all others held: the local solvers of a sweep.

Each gets the contact's own matrix K (symmetric), b = -(velocity without this contact's impulse), the impulse r that it
has now, and mu; components are (normal, two in the plane), and u = K r - b. What they return is

``secular``     the exact solution of Signorini's and Coulomb's laws together (``coulomb_impulse``); ``alternate`` where
                that is not unique, mu |K_nt| >= K_nn: an exact solver would jump between solutions from sweep to sweep
``alternate``   the normal impulse for the old friction, then exact friction for that normal impulse
``newton``      the exact solution again, by semismooth Newton steps on Alart and Curnier's equations
``projection``  one step r - rho (u + (mu |u_t|, 0, 0)), projected onto the cone (De Saxcé and Feng)
``clamp``       the normal impulse, then the sticking friction scaled back to mu r_n: what most engines do, and wrong
                wherever K has two different masses in the plane, for it then points along K_t^-1 b, not along the slip

All but ``clamp`` have the solutions of the problem as their fixed points.
"""

from __future__ import annotations

import math

from stiction.core.friction.coulomb import coulomb_impulse, secular_friction
from stiction.core.jit import jit
from stiction.core.vec import Mat33, Vec3, inverse

SECULAR, ALTERNATE, NEWTON, PROJECTION, CLAMP = 0, 1, 2, 3, 4
NEWTON_STEPS = 30
NEWTON_ENOUGH = 1e-14
"""Of |b| + |K r|: rounding."""


@jit
def cone_projection(x, y, z, mu):
    """The point of the cone sqrt(y^2 + z^2) <= mu x that is nearest to (x, y, z)."""
    t = math.sqrt(y * y + z * z)
    if t <= mu * x:
        return Vec3(x, y, z)
    if mu * t <= -x:
        return Vec3(0.0, 0.0, 0.0)
    n = (x + mu * t) / (1.0 + mu * mu)
    s = mu * n / t
    return Vec3(n, s * y, s * z)


@jit
def velocity(K, b, r):
    """u = K r - b."""
    v = K @ r
    return v - b


@jit
def alternate(K, b, r, mu):
    """Normal impulse for the friction there is, then exact friction within mu times that normal impulse."""
    n = max(0.0, (b.x - K.xy * r.y - K.xz * r.z) / K.xx)
    y, z, _ = secular_friction(K.yy, K.yz, K.zz, b.y - K.yx * n, b.z - K.zx * n, mu * n)
    return Vec3(n, y, z)


@jit
def clamp(K, b, r, mu):
    """Normal impulse, then the friction that would stick, scaled back along its own direction."""
    n = max(0.0, (b.x - K.xy * r.y - K.xz * r.z) / K.xx)
    by, bz = b.y - K.yx * n, b.z - K.zx * n
    det = K.yy * K.zz - K.yz * K.zy
    y, z = (K.zz * by - K.yz * bz) / det, (K.yy * bz - K.zy * by) / det
    size, limit = math.sqrt(y * y + z * z), mu * n
    if size > limit:
        y, z = y * limit / size, z * limit / size
    return Vec3(n, y, z)


@jit
def projection(K, b, r, mu):
    """One projected step with De Saxcé's correction; rho is 1 / |K|, by the largest sum of a row."""
    u = velocity(K, b, r)
    top = abs(K.xx) + abs(K.xy) + abs(K.xz)
    top = max(top, abs(K.yx) + abs(K.yy) + abs(K.yz))
    rho = 1.0 / max(top, abs(K.zx) + abs(K.zy) + abs(K.zz))
    slip = math.sqrt(u.y * u.y + u.z * u.z)
    return cone_projection(r.x - rho * (u.x + mu * slip), r.y - rho * u.y, r.z - rho * u.z, mu)


@jit
def newton(K, b, r, mu):
    """Semismooth Newton steps on Alart and Curnier's equations; the secular equation where they do not arrive.

    r_n = max(0, r_n - rho u_n) and r_t = the nearest point to r_t - rho u_t in the disk of radius
    mu max(0, r_n - rho u_n); Alart, Curnier, "A mixed formulation for frictional contact problems prone to Newton like
    solution methods", CMAME 92 (1991). Newton's method on them need not converge, so it is given a limit.
    """
    rho_n, rho_t = 1.0 / K.xx, 2.0 / (K.yy + K.zz)
    for _ in range(NEWTON_STEPS):
        u = velocity(K, b, r)
        pn, py, pz = r.x - rho_n * u.x, r.y - rho_t * u.y, r.z - rho_t * u.z
        if pn <= 0.0:
            if r.x == 0.0 and r.y == 0.0 and r.z == 0.0:
                return r
            r = Vec3(0.0, 0.0, 0.0)
            continue
        radius, size = mu * pn, math.sqrt(py * py + pz * pz)
        if size <= radius:
            f = Vec3(rho_n * u.x, rho_t * u.y, rho_t * u.z)
            A = Mat33(
                rho_n * K.xx, rho_n * K.xy, rho_n * K.xz,
                rho_t * K.yx, rho_t * K.yy, rho_t * K.yz,
                rho_t * K.zx, rho_t * K.zy, rho_t * K.zz,
            )  # fmt: skip
        else:
            ey, ez = py / size, pz / size
            f = Vec3(rho_n * u.x, r.y - radius * ey, r.z - radius * ez)
            # P turns a change of p_t into one of its nearest point; the radius changes with p_n
            k = radius / size
            pyy, pyz, pzz = k * (1.0 - ey * ey), -k * ey * ez, k * (1.0 - ez * ez)
            qx, qy, qz = 1.0 - rho_n * K.xx, -rho_n * K.xy, -rho_n * K.xz
            A = Mat33(
                rho_n * K.xx, rho_n * K.xy, rho_n * K.xz,
                rho_t * (pyy * K.yx + pyz * K.zx) - mu * ey * qx,
                1.0 - pyy * (1.0 - rho_t * K.yy) + pyz * rho_t * K.zy - mu * ey * qy,
                -pyz * (1.0 - rho_t * K.zz) + pyy * rho_t * K.yz - mu * ey * qz,
                rho_t * (pyz * K.yx + pzz * K.zx) - mu * ez * qx,
                -pyz * (1.0 - rho_t * K.yy) + pzz * rho_t * K.zy - mu * ez * qy,
                1.0 - pzz * (1.0 - rho_t * K.zz) + pyz * rho_t * K.yz - mu * ez * qz,
            )  # fmt: skip
        off = abs(f.x) + abs(f.y) + abs(f.z)
        if not off < 1e300:
            break
        if off <= NEWTON_ENOUGH * (abs(r.x) + abs(r.y) + abs(r.z) + abs(rho_n * b.x)):
            return r
        r = r - inverse(A) @ f
    g, _ = coulomb_impulse(K, b, mu, mu)
    return g


@jit
def local_solution(which, K, b, r, mu):
    """The new impulse of one contact by the local solver with that number."""
    if which == SECULAR:
        if mu * math.sqrt(K.yx * K.yx + K.zx * K.zx) >= K.xx:  # friction can hold this contact shut by itself
            return alternate(K, b, r, mu)
        g, _ = coulomb_impulse(K, b, mu, mu)
        return g
    if which == ALTERNATE:
        return alternate(K, b, r, mu)
    if which == NEWTON:
        return newton(K, b, r, mu)
    if which == PROJECTION:
        return projection(K, b, r, mu)
    return clamp(K, b, r, mu)
