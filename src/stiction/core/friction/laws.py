"""Friction laws of a pair beyond two constants, as they come into a block of eight manifolds.

What they are made of, in the order in which it works:

coefficient   mu_d from speed or slip, told anew in every substep by that of the one before (:func:`follow_slip`)
tyres         friction that grows with slip, f = slip / (alpha / N): alpha = slip / mu of the substep before, and f is
              solved with it implicitly, so that a stiff tyre needs no small steps; it sticks where the wheel stands
grain         an ellipse instead of a circle, mu across the grain over mu along it. Friction is most dissipative
              (Goyal, Ruina, Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991), so with f = E g,
              E = R diag(1, ratio) R^T, the slip that goes with g is E^T slip, and in these *scaled* coordinates the
              limit is round again: the patch of the pressure at J^T E J x (J a quarter turn) has the same dissipation,
              |E (v + w J x)| = |E v + w J x'|
adhesion      a constant pull between points that touch. What the normals carry is that much more, and friction with it

Only worlds whose table has such pairs compile any of this. Sources of the laws: ``stiction.laws``.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row
from stiction.core.friction.pressure import Even
from stiction.core.jit import jit
from stiction.core.lanes import LANES, load, select, store
from stiction.core.solve.normals import Four
from stiction.core.state import (
    ADHESION,
    ADHESION_PRESSURE,
    DYNAMIC,
    DYNAMIC_ACROSS,
    DYNAMIC_MU,
    LAW,
    LAW_FIRST,
    MATERIAL,
    MOBILITY,
    STATIC_ACROSS,
    STATIC_MU,
)
from stiction.core.vec import Vec3, cross, dot, mat33, vec3

COULOMB, STRIBECK, CURVE, BRUSH, MAGIC = range(5)
"""Codes of the laws."""

SLOW_WHEEL = 1e-6
"""m/s, least speed that slip is a part of."""
PEAK = 1.5
"""Of the peak of a tyre's curve: friction is never more, whatever the slip of the substep before was."""
TOUCH = 1e-4
"""m, a point closer than this holds on."""
MOST_ALPHA = 1e4
"""m/s"""
TINY = 1e-30


@jit
def coefficient(table, i, j, speed):
    """mu_d of materials i and j that slide with ``speed`` (m/s), by Stribeck's law or by a curve."""
    mu_d = table[i, j, DYNAMIC_MU]
    if table[i, j, LAW] == STRIBECK:
        fade = math.exp(-math.pow(speed / table[i, j, LAW_FIRST], table[i, j, LAW_FIRST + 2]))
        return mu_d + (table[i, j, STATIC_MU] - mu_d) * fade + table[i, j, LAW_FIRST + 1] * speed
    k = LAW_FIRST
    if speed <= table[i, j, k]:
        return table[i, j, k + 1]
    while k + 3 < table.shape[2] and table[i, j, k + 2] > table[i, j, k]:
        v0, v1 = table[i, j, k], table[i, j, k + 2]
        if speed < v1:
            return table[i, j, k + 1] + (table[i, j, k + 3] - table[i, j, k + 1]) * (speed - v0) / (v1 - v0)
        k += 2
    return table[i, j, k + 1]


@jit
def tyre_coefficient(table, i, j, slip):
    """mu of a tyre at a slip (a part of the wheel's speed), and mu / slip, which has a limit where there is none."""
    peak = table[i, j, DYNAMIC_MU]
    if table[i, j, LAW] == BRUSH:
        stiffness = table[i, j, LAW_FIRST]
        if peak <= 0.0:
            return 0.0, 0.0
        theta = stiffness * slip / (3.0 * peak)
        if theta < 1.0:
            return peak * theta * (3.0 + theta * (theta - 3.0)), stiffness * (1.0 + theta * (theta / 3.0 - 1.0))
        return peak, peak / slip
    B, C, E = table[i, j, LAW_FIRST], table[i, j, LAW_FIRST + 1], table[i, j, LAW_FIRST + 2]
    x = B * slip
    if x < 1e-6:
        return peak * C * x, B * C * peak
    mu = peak * math.sin(C * math.atan(x - E * (x - math.atan(x))))
    return mu, mu / slip


@jit
def laws_of(wanted, kinds, table, soft):
    """What the passes need of laws beyond two constants: kinds, table and grain; None where none is wanted."""
    if wanted is None:
        return None
    return kinds, table, soft.grain


@jit
def prepare_laws(i, blocks, index, count, manifolds, aux, laws):
    """Of the lanes of block i: direction and ratio of the grain, and the limit of tyres.

    The first three of B_SCALED are the cosine and sine of the grain in the plane, and the ratio, for :func:`stretch`.
    """
    kinds, table, grain = laws
    o = first_row(index, i, count)
    for lane in range(LANES):
        row = index[i + 2 * count, lane]
        c, sn, ratio = 1.0, 0.0, 1.0
        if row > 0:
            a, b = index[i, lane], index[i + count, lane]
            ma, mb = kinds[a - 1, MATERIAL], kinds[b - 1, MATERIAL]
            sliding = manifolds[row, s.STATE] == s.SLIDING
            wanted = table[ma, mb, DYNAMIC_ACROSS if sliding else STATIC_ACROSS]
            if wanted != 1.0:
                Ra = mat33(aux, a, s.AUX_ROTATION)
                d = Ra @ vec3(grain, a, 0)
                if dot(d, d) == 0.0:
                    d = mat33(aux, b, s.AUX_ROTATION) @ vec3(grain, b, 0)
                n, u = Ra @ vec3(manifolds, row, s.NORMAL_A), Ra @ vec3(manifolds, row, s.TANGENT_A)
                x, y = dot(d, u), dot(d, cross(n, u))
                size = math.sqrt(x * x + y * y)
                if size > 1e-3:  # a grain along the normal has no direction in the plane
                    c, sn, ratio = x / size, y / size, wanted
            if table[ma, mb, LAW] >= BRUSH:
                limit = PEAK * table[ma, mb, DYNAMIC_MU]
                blocks[o + s.B_MU_S, lane] = blocks[o + s.B_MU_D, lane] = limit
        blocks[o + s.B_SCALED, lane], blocks[o + s.B_SCALED + 1, lane] = c, sn
        blocks[o + s.B_SCALED + 2, lane] = ratio
        blocks[o + s.B_ALPHA, lane] = 0.0


@jit
def hold_on(i, blocks, index, count, manifolds, corners, laws, h):
    """The impulse a substep with which each point of a manifold holds on: its share of the force, if any touches, and
    of the pressure on the whole face, if it touches itself."""
    kinds, table, _ = laws
    o = first_row(index, i, count)
    for lane in range(LANES):
        for k in range(4):
            blocks[o + s.B_ATTRACT + k, lane] = 0.0
        row = index[i + 2 * count, lane]
        if row <= 0:
            continue
        ma, mb = kinds[index[i, lane] - 1, MATERIAL], kinds[index[i + count, lane] - 1, MATERIAL]
        force, pressure = table[ma, mb, ADHESION], table[ma, mb, ADHESION_PRESSURE]
        if force <= 0.0 and pressure <= 0.0:
            continue
        points, touching = int(manifolds[row, s.COUNT]), 0
        for k in range(points):
            if blocks[o + s.B_GAP + k, lane] < TOUCH:
                touching += 1
        if touching == 0:
            continue
        share = force / touching
        if pressure > 0.0 and points > 2:
            share += pressure * face_area(manifolds, corners, row) / points
        share = share * h / blocks[o + s.B_SCALE, lane]
        for k in range(points):
            if blocks[o + s.B_GAP + k, lane] < TOUCH:
                blocks[o + s.B_ATTRACT + k, lane] = share


@jit
def face_area(manifolds, corners, row):
    """Area of the face of a manifold, m^2."""
    if manifolds[row, s.KIND] == s.ELLIPSE:
        # (r - c)^T W (r - c) = 4
        uu, uv, vv = manifolds[row, s.EVEN], manifolds[row, s.EVEN + 1], manifolds[row, s.EVEN + 2]
        return 4.0 * math.pi / math.sqrt(uu * vv - uv * uv)
    twice = 0.0
    if manifolds[row, s.KIND] == s.EIGHT:
        for k in range(8):
            j = (k + 1) % 8
            twice += corners[row, s.CORNER_U + k] * corners[row, s.CORNER_V + j]
            twice -= corners[row, s.CORNER_U + j] * corners[row, s.CORNER_V + k]
    else:
        for k in range(4):
            j = (k + 1) % 4
            twice += manifolds[row, s.PLACE_U + k] * manifolds[row, s.PLACE_V + j]
            twice -= manifolds[row, s.PLACE_U + j] * manifolds[row, s.PLACE_V + k]
    return 0.5 * abs(twice)


@jit
def ellipse_at(blocks, o):
    """The symmetric matrix E of block o, xx, xy and yy, from direction and ratio of the grain."""
    c, sn, r = load(blocks, o + s.B_SCALED), load(blocks, o + s.B_SCALED + 1), load(blocks, o + s.B_SCALED + 2)
    return c * c + r * sn * sn, (1.0 - r) * c * sn, sn * sn + r * c * c


@jit
def stretched(blocks, o, x, y):
    """Four places of each lane as the pressure is seen in scaled coordinates: J^T E J r."""
    xx, xy, yy = ellipse_at(blocks, o)
    return (
        Four(yy * x.a - xy * y.a, yy * x.b - xy * y.b, yy * x.c - xy * y.c, yy * x.d - xy * y.d),
        Four(xx * y.a - xy * x.a, xx * y.b - xy * x.b, xx * y.c - xy * x.c, xx * y.d - xy * x.d),
    )


@jit
def stretch(blocks, o, px, py, even, is_round):
    """The same for the centre of pressure, and for what is known of an even load."""
    xx, xy, yy = ellipse_at(blocks, o)
    # P = J^T E J, and its inverse, E / det
    over = 1.0 / (xx * yy - xy * xy)
    ixx, ixy, iyy = xx * over, xy * over, yy * over
    auu, auv = ixx * even.uu + ixy * even.uv, ixx * even.uv + ixy * even.vv
    avu, avv = ixy * even.uu + iyy * even.uv, ixy * even.uv + iyy * even.vv
    made = Even(
        auu * ixx + auv * ixy, auu * ixy + auv * iyy, avu * ixy + avv * iyy, even.arm,
        select(is_round, yy * even.u - xy * even.v, even.u), select(is_round, xx * even.v - xy * even.u, even.v),
    )  # fmt: skip
    return yy * px - xy * py, xx * py - xy * px, made


@jit
def keep_scaled(blocks, o, c, sn):
    """Write the matrix E Q from scaled forces to forces along u and v (xx, xy, yx, yy), Q the turn (c, sn) of the axes
    of the pressure; returns the turn of the frame itself, which is none where there is a grain.
    """
    xx, xy, yy = ellipse_at(blocks, o)
    r = load(blocks, o + s.B_SCALED + 2)
    one = r - r + 1.0
    zero = r - r
    plain = (r > 0.999999) & (r < 1.000001)
    store(blocks, o + s.B_SCALED, select(plain, one, xx * c + xy * sn))
    store(blocks, o + s.B_SCALED + 1, select(plain, zero, xy * c - xx * sn))
    store(blocks, o + s.B_SCALED + 2, select(plain, zero, xy * c + yy * sn))
    store(blocks, o + s.B_SCALED + 3, select(plain, one, yy * c - xy * sn))
    return select(plain, c, one), select(plain, sn, zero)


@jit
def scaling_at(blocks, o):
    """E of block o, from scaled forces to forces along u and v: xx, xy, yx, yy."""
    k = o + s.B_SCALED
    return load(blocks, k), load(blocks, k + 1), load(blocks, k + 2), load(blocks, k + 3)


@jit
def scaled_slip(blocks, o, slip, laws):
    """E^T slip: what the slip is in scaled coordinates."""
    if laws is None:
        return slip
    xx, xy, yx, yy = scaling_at(blocks, o)
    return Vec3(xx * slip.x + yx * slip.y, xy * slip.x + yy * slip.y, slip.z)


@jit
def real_force(blocks, o, g, laws):
    """E g: the force that a scaled one is."""
    if laws is None:
        return g
    xx, xy, yx, yy = scaling_at(blocks, o)
    return Vec3(xx * g.x + xy * g.y, yx * g.x + yy * g.y, g.z)


@jit
def force_in_plane(blocks, o, lane, k, laws):
    """The same of one lane, for the force that begins at row k, scaled if there are ``laws``: its parts along u, v."""
    x, y = blocks[o + k, lane], blocks[o + k + 1, lane]
    if not laws:
        return x, y
    e = o + s.B_SCALED
    return blocks[e, lane] * x + blocks[e + 1, lane] * y, blocks[e + 2, lane] * x + blocks[e + 3, lane] * y


@jit
def scaled_force(blocks, o, f, laws):
    """E^-1 f: the scaled force of a real one."""
    if laws is None:
        return f
    xx, xy, yx, yy = scaling_at(blocks, o)
    d = 1.0 / (xx * yy - xy * yx)
    return Vec3((yy * f.x - xy * f.y) * d, (xx * f.y - yx * f.x) * d, f.z)


@jit
def follow_slip(i, blocks, index, count, rows, aux, now, laws):
    """Coefficients of block i for the next substep, from the slip that this one has left.

    ``now``: 1, or 0 where the velocities are still those of the start of the step, whatever the rows say.
    """
    kinds, table, _ = laws
    o = first_row(index, i, count)
    for lane in range(LANES):
        if index[i + 2 * count, lane] <= 0:
            continue
        a, b = index[i, lane], index[i + count, lane]
        ma, mb = kinds[a - 1, MATERIAL], kinds[b - 1, MATERIAL]
        law = table[ma, mb, LAW]
        if law == COULOMB:
            continue
        # the slip along u and v: E^-T of the scaled one
        k = o + s.B_SCALED
        xx, xy, yx, yy = blocks[k, lane], blocks[k + 1, lane], blocks[k + 2, lane], blocks[k + 3, lane]
        gx, gy, gz = blocks[o + s.B_SLIP, lane], blocks[o + s.B_SLIP + 1, lane], blocks[o + s.B_SLIP + 2, lane]
        d = 1.0 / (xx * yy - xy * yx)
        x, y = (yy * gx - yx * gy) * d, (xx * gy - xy * gx) * d
        speed = math.sqrt(x * x + y * y + gz * gz)
        if law < BRUSH:
            blocks[o + s.B_MU_D, lane] = coefficient(table, ma, mb, speed)
        else:
            wheel = max(wheel_speed(i, blocks, o, lane, index, count, rows, aux, now, kinds), SLOW_WHEEL)
            _, slope = tyre_coefficient(table, ma, mb, speed / wheel)
            blocks[o + s.B_ALPHA, lane] = min(wheel / max(slope, TINY), MOST_ALPHA)


@jit
def wheel_speed(i, blocks, o, lane, index, count, rows, aux, now, kinds):
    """How fast the centre of a wheel goes over the road, m/s: its slip, less what its spin has in that. The wheel is
    the body that is free to move; of two such, the one that spins faster."""
    a, b = index[i, lane], index[i + count, lane]
    va, wa = vec3(rows, a, s.ROW_V) * now, vec3(rows, a, s.ROW_W) * now
    vb, wb = vec3(rows, b, s.ROW_V) * now, vec3(rows, b, s.ROW_W) * now
    wa0, wb0 = vec3(aux, a, s.AUX_START_W), vec3(aux, b, s.AUX_START_W)
    n, u = _vector(blocks, o + s.B_NORMAL, lane), _vector(blocks, o + s.B_TANGENT, lane)
    v = cross(n, u)
    a_is_wheel = kinds[a - 1, MOBILITY] == DYNAMIC
    if a_is_wheel and kinds[b - 1, MOBILITY] == DYNAMIC:
        a_is_wheel = dot(wa0 + wa, wa0 + wa) >= dot(wb0 + wb, wb0 + wb)
    arm_a, arm_b = _vector(blocks, o + s.B_ARM_A, lane), _vector(blocks, o + s.B_ARM_B, lane)
    arm_a, arm_b = n * arm_a.x + u * arm_a.y + v * arm_a.z, n * arm_b.x + u * arm_b.y + v * arm_b.z
    # the slip of the start of the step is in B_BELT, with the spin that the wheel had
    if a_is_wheel:
        d = va - vb - cross(wb, arm_b) - cross(wa0, arm_a)
    else:
        d = va + cross(wa, arm_a) - vb + cross(wb0, arm_b)
    x, y = dot(d, u) + blocks[o + s.B_BELT, lane], dot(d, v) + blocks[o + s.B_BELT + 1, lane]
    return math.sqrt(x * x + y * y)


@jit
def _vector(blocks, k, lane):
    return Vec3(blocks[k, lane], blocks[k + 1, lane], blocks[k + 2, lane])
