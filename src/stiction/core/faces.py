"""What the face of a manifold is known to do under an even load: once a manifold, for ``friction/pressure.py``.

The face is the polygon of the points that the narrow phase found. Where it chose four of more, ``collide/manifold.py``
has remembered them all: up to eight are the corners of the face, more are taken for an ellipse with their moments. A
round cap is the disc through its four points. Integrals over the polygon are sums over its sides
(``docs/design/limit-surface.md``).
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.collide.manifold import ROUND, SAME_PLACE2, remembered
from stiction.core.contact_space import contact_basis
from stiction.core.friction.pressure import (
    Even,
    factors,
    place_in,
    polar_of,
    polar_of_eight,
    polar_of_ellipse,
    pressed,
    spread_of,
)
from stiction.core.jit import jit
from stiction.core.solve.normals import Four
from stiction.core.state import FACE, FEATURE, POINT, SEPARATION
from stiction.core.vec import Vec3, column, cross, dot, length, vec3

ISOTROPIC = 1e-3
"""A face whose second moments differ by less is as wide as it is long."""
SLENDER = 1e-9
"""A polygon whose area is below this part of the square of its size is a line."""
GHOST = 0.02
"""Of its length: how wide a strip stands for a line, which lies on one side of it."""
INNER = 1e-6
"""A corner at which a polygon turns back by more than this part of its squared size lies inside the others."""
LINE_EVEN, LINE_ARM = 3.8698847242680072, 0.06251613341098453
"""What :func:`_keep_even` would find for two points a metre apart: one whole moment, 1/12 m^2, and a mean arm of 1/4 m.
Of other lengths the first goes with the inverse square, the second not at all."""
CALM = 0.05
"""1 - t is not taken to be less where it divides."""


@jit
def order_points(contacts, tags, found, n):
    """Bring four points into a counterclockwise order around n, seen against it; the first one stays."""
    if found < 3:
        return
    for i, j in ((1, 2), (2, 3), (1, 2)):
        if j < found and _turns_back(contacts, i, j, n):
            for k in range(3):
                contacts[i, POINT + k], contacts[j, POINT + k] = contacts[j, POINT + k], contacts[i, POINT + k]
            contacts[i, SEPARATION], contacts[j, SEPARATION] = contacts[j, SEPARATION], contacts[i, SEPARATION]
            tags[i, FEATURE], tags[j, FEATURE] = tags[j, FEATURE], tags[i, FEATURE]


@jit
def _turns_back(contacts, i, j, n):
    origin = vec3(contacts, 0, POINT)
    return dot(cross(vec3(contacts, i, POINT) - origin, vec3(contacts, j, POINT) - origin), n) < 0.0


@jit
def measure_face(contacts, tags, found, center, n, points, manifolds, apart, row):
    """Write places, shape and even load of the face into its manifold; returns its first axis u, and its size^2 (m^2).

    u is the longer principal axis, of a face that is as wide as it is long its first side. The points are in order.
    ``apart``: the corners of faces that have more than four.
    """
    for k in range(4):
        manifolds[row, s.PLACE_U + k] = manifolds[row, s.PLACE_V + k] = 0.0
    for k in (s.EVEN, s.EVEN + 1, s.EVEN + 2, s.ARM, s.LOP_U, s.LOP_V):
        manifolds[row, k] = 0.0
    manifolds[row, s.COUNT], manifolds[row, s.KIND] = found, s.FOUR
    basis = contact_basis(n)
    e1, e2 = column(basis, 1), column(basis, 2)
    if found == 1:
        return e1, 0.0
    if found == 2:
        return _measure_line(contacts, n, e1, manifolds, row)

    corners = found
    disc = (tags[0, FEATURE] & ROUND) != 0
    if not disc:
        corners = max(corners, remembered(points))
    more = corners > found
    for k in range(corners):
        d = (vec3(points, FACE + 1 + k, 0) if more else vec3(contacts, k, POINT)) - center
        points[FACE + 1 + k, 3], points[FACE + 1 + k, 4] = dot(d, e1), dot(d, e2)
    if more:
        _sort_around(points, corners)
    sxx, sxy, syy = 0.0, 0.0, 0.0
    for k in range(found):
        d = vec3(contacts, k, POINT) - center
        x, y = dot(d, e1), dot(d, e2)
        sxx, sxy, syy = sxx + x * x, sxy + x * y, syy + y * y
    sxx, sxy, syy = sxx / found, sxy / found, syy / found
    size2 = sxx + syy
    corners = _merge(points, corners, SAME_PLACE2 * size2)
    corners = _without_inner(points, corners, INNER * size2)
    area, gx, gy, mxx, mxy, myy, tx, ty = _integrals(points, corners)
    flat = corners < 3 or area <= SLENDER * size2
    if disc:
        gx, gy, mxx, mxy, myy = 0.0, 0.0, 0.25 * size2, 0.0, 0.25 * size2
    elif flat:
        mxx, mxy, myy = sxx / 3.0, sxy / 3.0, syy / 3.0

    wide, mixed = mxx - myy, 2.0 * mxy
    if abs(wide) + abs(mxy) < ISOTROPIC * (mxx + myy):
        d = vec3(contacts, 1, POINT) - vec3(contacts, 0, POINT)
        c, sn = dot(d, e1), dot(d, e2)
    else:  # half of the angle of (wide, mixed)
        width = math.sqrt(wide * wide + mixed * mixed)
        c, sn = (width + wide, mixed) if wide > 0.0 else (abs(mixed), math.copysign(width - wide, mixed))
    size = math.sqrt(c * c + sn * sn)
    c, sn = (c / size, sn / size) if size > 0.0 else (1.0, 0.0)
    u, v = e1 * c + e2 * sn, e2 * c - e1 * sn
    for k in range(4):
        d = vec3(contacts, k, POINT) - center if k < found else Vec3(0.0, 0.0, 0.0)
        manifolds[row, s.PLACE_U + k], manifolds[row, s.PLACE_V + k] = dot(d, u), dot(d, v)
    if found == 3:  # a fourth corner in the middle of the third side changes nothing
        manifolds[row, s.PLACE_U + 3] = 0.5 * (manifolds[row, s.PLACE_U] + manifolds[row, s.PLACE_U + 2])
        manifolds[row, s.PLACE_V + 3] = 0.5 * (manifolds[row, s.PLACE_V] + manifolds[row, s.PLACE_V + 2])
    if flat:
        return u, size2

    muu = c * c * mxx + 2.0 * c * sn * mxy + sn * sn * myy
    muv = c * sn * (myy - mxx) + (c * c - sn * sn) * mxy
    mvv = sn * sn * mxx - 2.0 * c * sn * mxy + c * c * myy
    over = 1.0 / (muu * mvv - muv * muv)
    wuu, wuv, wvv = mvv * over, -muv * over, muu * over
    gu, gv = c * gx + sn * gy, c * gy - sn * gx
    arm = math.sqrt(size2) * 2.0 / 3.0 if disc else _mean_arm(points, corners, gx, gy)
    if disc or corners > 8:
        manifolds[row, s.KIND] = s.ELLIPSE
        manifolds[row, s.LOP_U], manifolds[row, s.LOP_V] = gu, gv
        _keep_even(manifolds, apart, row, Even(wuu, wuv, wvv, 0.0, gu, gv), gu, gv, arm)
    else:
        if corners != found or (more and not _are_the_points(contacts, found, center, e1, e2, points, size2)):
            manifolds[row, s.KIND] = s.EIGHT
            _keep_corners(points, corners, c, sn, apart, row)
        _keep_even(manifolds, apart, row, Even(wuu, wuv, wvv, 0.0, 0.0, 0.0), gu, gv, arm)
        scale = 1.0 / (arm * arm * arm)
        manifolds[row, s.LOP_U], manifolds[row, s.LOP_V] = (c * tx + sn * ty) * scale, (c * ty - sn * tx) * scale
    return u, size2


@jit
def _measure_line(contacts, n, e1, manifolds, row):
    """Two points: a narrow strip with its even load on one of its long sides. Nothing is known of its width."""
    d = vec3(contacts, 1, POINT) - vec3(contacts, 0, POINT)
    d = d - n * dot(n, d)
    size = length(d)
    if size < 1e-12:
        return e1, 0.0
    half = 0.5 * size
    manifolds[row, s.PLACE_U], manifolds[row, s.PLACE_U + 1] = -half, half
    manifolds[row, s.PLACE_U + 2], manifolds[row, s.PLACE_U + 3] = half, -half
    manifolds[row, s.PLACE_V + 2] = manifolds[row, s.PLACE_V + 3] = GHOST * size
    manifolds[row, s.EVEN], manifolds[row, s.ARM] = LINE_EVEN / (size * size), LINE_ARM
    return d * (1.0 / size), half * half


@jit
def _keep_corners(points, corners, c, sn, apart, row):
    """Write three to eight corners as eight, in axes turned by this angle: a corner within a side changes nothing."""
    kept, more = 0, 8 - corners
    for k in range(corners):
        i, j = FACE + 1 + k, FACE + 1 + _after(k, corners)
        parts = 1 + more // corners + (1 if k < more % corners else 0)
        for part in range(parts):
            x = points[i, 3] + (points[j, 3] - points[i, 3]) * part / parts
            y = points[i, 4] + (points[j, 4] - points[i, 4]) * part / parts
            apart[row, s.CORNER_U + kept], apart[row, s.CORNER_V + kept] = c * x + sn * y, c * y - sn * x
            kept += 1


@jit
def _four(manifolds, row, k):
    """Four numbers of a manifold, in double precision."""
    return Four(
        float(manifolds[row, k]), float(manifolds[row, k + 1]), float(manifolds[row, k + 2]),
        float(manifolds[row, k + 3]),
    )  # fmt: skip


@jit
def seen_from(manifolds, apart, row, even, gu, gv):
    """The polar of the face of a manifold."""
    kind = manifolds[row, s.KIND]
    if kind == s.ELLIPSE:
        return polar_of_ellipse(even, gu, gv)
    if kind == s.EIGHT:
        return polar_of_eight(
            _four(apart, row, s.CORNER_U), _four(apart, row, s.CORNER_V),
            _four(apart, row, s.CORNER_U + 4), _four(apart, row, s.CORNER_V + 4), gu, gv,
        )  # fmt: skip
    return polar_of(_four(manifolds, row, s.PLACE_U), _four(manifolds, row, s.PLACE_V), gu, gv)


@jit
def _keep_even(manifolds, apart, row, known, gu, gv, arm):
    """Write what makes M^-1 the one that is ``known`` (of an ellipse, its W), and the mean arm ``arm``, when the centre
    of pressure is (gu, gv)."""
    is_round = manifolds[row, s.KIND] == s.ELLIPSE
    seen = seen_from(manifolds, apart, row, known, gu, gv)
    t, j = place_in(seen)
    f, h, k = factors(t, j)
    calm = max(1.0 - t, CALM)
    euu, euv, evv = known.uu, known.uv, known.vv
    if not is_round:
        uu, uv = f * seen.uu + h * seen.mu * seen.mu, f * seen.uv + h * seen.mu * seen.mv
        vv = f * seen.vv + h * seen.mv * seen.mv
        # back to the axes of the places
        c, sn = seen.turn.c, seen.turn.s
        euu = (euu - (c * c * uu - 2.0 * c * sn * uv + sn * sn * vv)) / calm
        euv = (euv - (c * sn * (uu - vv) + (c * c - sn * sn) * uv)) / calm
        evv = (evv - (sn * sn * uu + 2.0 * c * sn * uv + c * c * vv)) / calm
        if abs(euu) + abs(evv) > known.uu + known.vv:  # nearly two corners in one place: the formula alone is better
            euu = euv = evv = 0.0
    manifolds[row, s.EVEN], manifolds[row, s.EVEN + 1], manifolds[row, s.EVEN + 2] = euu, euv, evv
    even = Even(euu, euv, evv, 0.0, known.u, known.v)
    found = pressed(seen, even, is_round, spread_of(seen, even, is_round)).torque
    manifolds[row, s.ARM] = (arm / found - 1.0) * k / calm


@jit
def _sort_around(points, corners):
    """Sort the corners by their angle around the middle of all of them; column 2 becomes the angle."""
    mx, my = 0.0, 0.0
    for k in range(FACE + 1, FACE + 1 + corners):
        mx, my = mx + points[k, 3] / corners, my + points[k, 4] / corners
    for k in range(FACE + 1, FACE + 1 + corners):
        points[k, 2] = math.atan2(points[k, 4] - my, points[k, 3] - mx)
        j = k
        while j > FACE + 1 and points[j, 2] < points[j - 1, 2]:
            for q in range(2, 5):
                points[j, q], points[j - 1, q] = points[j - 1, q], points[j, q]
            j -= 1


@jit
def _merge(points, corners, near2):
    """Drop corners that are in the same place as the one before, as those of a thin sheet are, whose upper face is
    near too; returns how many are left. A side without length would be a point of the polar in the wrong place."""
    kept = 0
    for k in range(FACE + 1, FACE + 1 + corners):
        last = FACE + kept if kept > 0 else FACE + corners
        dx, dy = points[k, 3] - points[last, 3], points[k, 4] - points[last, 4]
        if dx * dx + dy * dy > near2:
            kept += 1
            points[FACE + kept, 3], points[FACE + kept, 4] = points[k, 3], points[k, 4]
    return kept


@jit
def _are_the_points(contacts, found, center, e1, e2, points, size2):
    """Whether as many corners as points are in their places. What is left of more corners need not be."""
    for k in range(FACE + 1, FACE + 1 + found):
        nearest = size2
        for j in range(found):
            d = vec3(contacts, j, POINT) - center
            x, y = dot(d, e1) - points[k, 3], dot(d, e2) - points[k, 4]
            nearest = min(nearest, x * x + y * y)
        if nearest > SAME_PLACE2 * size2:
            return False
    return True


@jit
def _without_inner(points, corners, least):
    """Drop a corner at which the polygon turns back, as the deepest of four points may lie between the others; returns
    how many are left."""
    k = 0
    while k < corners and corners > 3:
        i, j, m = FACE + (k if k > 0 else corners), FACE + 1 + k, FACE + 1 + _after(k, corners)
        ax, ay = points[j, 3] - points[i, 3], points[j, 4] - points[i, 4]
        bx, by = points[m, 3] - points[j, 3], points[m, 4] - points[j, 4]
        if ax * by - ay * bx < -least:
            corners -= 1
            for q in range(j, FACE + 1 + corners):
                points[q, 3], points[q, 4] = points[q + 1, 3], points[q + 1, 4]
            k = 0
        else:
            k += 1
    return corners


@jit
def _integrals(points, corners):
    """Of the polygon in columns 3 and 4: area; centroid; second moments about it, per area; the integral of r |r|^2
    about it, per area."""
    area, gx, gy = 0.0, 0.0, 0.0
    for k in range(corners):
        i, j = FACE + 1 + k, FACE + 1 + _after(k, corners)
        twice = points[i, 3] * points[j, 4] - points[j, 3] * points[i, 4]
        area += 0.5 * twice
        gx += twice * (points[i, 3] + points[j, 3])
        gy += twice * (points[i, 4] + points[j, 4])
    over = 1.0 / area if area > 0.0 else 0.0
    gx, gy = gx * over / 6.0, gy * over / 6.0
    xx, xy, yy, tx, ty = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(corners):
        i, j = FACE + 1 + k, FACE + 1 + _after(k, corners)
        ax, ay, bx, by = points[i, 3] - gx, points[i, 4] - gy, points[j, 3] - gx, points[j, 4] - gy
        twice = ax * by - bx * ay
        sx, sy, aa, bb, ab = ax + bx, ay + by, ax * ax + ay * ay, bx * bx + by * by, ax * bx + ay * by
        xx += twice * (ax * ax + bx * bx + ax * bx)
        yy += twice * (ay * ay + by * by + ay * by)
        xy += twice * (2.0 * (ax * ay + bx * by) + ax * by + bx * ay)
        # of the triangle (0, a, b): twice / 5 times the mean over the side of r |r|^2
        tx += twice * (sx * (aa + bb + ab) + 2.0 * (ax * aa + bx * bb) + ax * ab + bx * ab)
        ty += twice * (sy * (aa + bb + ab) + 2.0 * (ay * aa + by * bb) + ay * ab + by * ab)
    xx, xy, yy, tx, ty = xx * over / 12.0, xy * over / 24.0, yy * over / 12.0, tx * over / 60.0, ty * over / 60.0
    return area, gx, gy, xx, xy, yy, tx, ty


@jit
def _mean_arm(points, corners, gx, gy):
    """Mean distance of the polygon's points from (gx, gy)."""
    total, area = 0.0, 0.0
    for k in range(corners):
        i, j = FACE + 1 + k, FACE + 1 + _after(k, corners)
        ax, ay, bx, by = points[i, 3] - gx, points[i, 4] - gy, points[j, 3] - gx, points[j, 4] - gy
        tx, ty = bx - ax, by - ay
        side = math.sqrt(tx * tx + ty * ty)
        twice = ax * by - bx * ay
        area += 0.5 * twice
        if side > 0.0 and twice != 0.0:
            d = twice / side
            lower, upper = (ax * tx + ay * ty) / side, (bx * tx + by * ty) / side
            ra, rb = math.sqrt(ax * ax + ay * ay), math.sqrt(bx * bx + by * by)
            near = abs(d)
            # asinh(x / near) = log((x + r) / near), where r^2 = x^2 + near^2
            far = upper + rb if upper > 0.0 else near * near / (rb - upper)
            logs = math.log(far / (lower + ra if lower > 0.0 else near * near / (ra - lower)))
            total += d / 6.0 * (upper * rb - lower * ra + d * d * logs)
    return total / area


@jit
def _after(k, corners):
    """The next corner, all the way round."""
    return k + 1 if k + 1 < corners else 0
