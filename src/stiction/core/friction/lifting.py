"""A face of which a part lifts off: the moments of the pressure on the rest, by one step of Newton's method.

Pressure cannot pull: divided by what it is at its centre P it is max(0, 1 + s . r) with r from P, and beyond the line
1 + s . r = 0 the face lifts off. The line is what is not known, but from the polar (``pressure.py``) follows a guess,

    s = [3/2 + 0.417 (1 - t)] m + 9.54 E M m,

which is exact in a corner. The part of the face that it leaves has an area, a centroid c, a covariance Z
and third moments T, and the one linear pressure over this part that has its centre at P is 1 + g . (x - c) with
g = Z^-1 (P - c), times a constant. That is Newton's step on the convex problem that says what the pressure is
(docs/design/limit-surface.md); the second moments about P are

    M = Z + T g - (P - c)(P - c)^T,

with an error that is the square of the guess's, and exact while the whole face carries.

All functions run on numbers and on lanes alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stiction.core.friction.pressure import THINNEST, TINY, Spread, place_in, turned
from stiction.core.jit import jit
from stiction.core.lanes import any_of, greatest, least, select, size_of

FROM, OVER = 0.04, 0.08
"""t at which the first faces lift off, and over which what this module finds takes the place of the formula, ..."""
FROM_CORNER, OVER_CORNER = 0.4, 0.2
"""... and of a parallelogram, for which the formula is better: there it does only towards a corner."""
CROOKED = 0.0025
"""Each diagonal of a quadrilateral parts it into two triangles: from here on, by the squares of the differences of
their areas over the square of its own, it is no parallelogram at all."""
NEAREST = 4e-4
"""1 / |m| over the size of the face: nearer to its border the formula is as good in single precision."""

UNSOUND = 2.0
"""The formula's tr M is never off by such a factor: what is found must be."""
PARALLEL = 1e-9
"""A side whose ends differ by less in the pressure on them is along the line."""


class Line(NamedTuple):
    """Oblique axes in which a face lifts off at the line a = -1: of a place r from P, in the axes of the polar,
    a = s . r and b = e . r."""

    su: Any
    sv: Any
    eu: Any
    ev: Any


class Part(NamedTuple):
    """What carries of a face: integrals of 1, a, b, aa, ... up to third order, from a foot on its line or beyond it,
    each times a constant; and how far P is ahead of the foot."""

    one: Any
    a: Any
    b: Any
    aa: Any
    ab: Any
    bb: Any
    aaa: Any
    aab: Any
    abb: Any
    bbb: Any
    ahead: Any


class Corners(NamedTuple):
    """Eight corners of a face, counterclockwise, the first four (x, y), the others (z, w)."""

    x: Any
    y: Any
    z: Any
    w: Any


@jit
def with_lifting(spread, seen, even, x, y, eight, px, py, many, is_round):
    """The spread of a pressure whose centre is P, once more with what has lifted off of the face.

    Corners are (x, y), and where a face has ``many`` they are ``eight``. Most blocks have no such face, and go on.
    """
    t, _ = place_in(seen)
    if any_of(t > FROM):
        share = _share(seen, t, x, y, many, is_round)
        if any_of(share > 0.0):
            line = line_of(seen, even, spread)
            part = part_of(line, seen.turn, x, y, px, py)
            if any_of(many):
                part = choose_part(many, part_of_eight(line, seen.turn, eight, px, py), part)
            spread = blended(spread_over(part, line), spread, share)
    return spread


@jit
def _ramp(x):
    return greatest(least(x, 1.0), 0.0)


@jit
def _share(seen, t, x, y, many, is_round):
    """How far what this module finds takes the place of the formula, 0 to 1."""
    size2 = x.a * x.a + x.b * x.b + x.c * x.c + x.d * x.d + y.a * y.a + y.b * y.b + y.c * y.c + y.d * y.d
    # the diagonals, and twice the way from the middle of one to that of the other
    pu, pv, qu, qv = x.c - x.a, y.c - y.a, x.d - x.b, y.d - y.b
    gu, gv = x.a - x.b + x.c - x.d, y.a - y.b + y.c - y.d
    p, q, area = pu * gv - pv * gu, qu * gv - qv * gu, pu * qv - pv * qu
    zero = t - t
    crooked = select(many, zero + 1.0, least((p * p + q * q) / greatest(CROOKED * area * area, TINY), 1.0))
    share = greatest(crooked * _ramp((t - FROM) * (1.0 / OVER)), _ramp((t - FROM_CORNER) * (1.0 / OVER_CORNER)))
    near = 1.0 / greatest(NEAREST * NEAREST * size2 * (seen.mu * seen.mu + seen.mv * seen.mv), TINY)
    return select(is_round, zero, share * _ramp((near - 1.0) * (1.0 / 3.0)))


@jit
def line_of(seen, even, spread):
    """The line beyond which the face lifts off, guessed from its polar.

    b is along the one of the polar's axes along which the pressure changes less, by the width of the patch. Were a and
    b at right angles, single precision would lose the width of a sliver.
    """
    t, _ = place_in(seen)
    mu, mv = spread.uu * seen.mu + spread.uv * seen.mv, spread.uv * seen.mu + spread.vv * seen.mv
    euu, euv, evv = turned(even.uu, even.uv, even.vv, seen.turn.c, seen.turn.s)
    by = 1.5 + 0.417 * (1.0 - t)
    su = by * seen.mu + 9.54 * (euu * mu + euv * mv)
    sv = by * seen.mv + 9.54 * (euv * mu + evv * mv)
    along_u = su * su * spread.uu > sv * sv * spread.vv
    zero = t - t
    one = zero + 1.0
    return Line(
        su, sv, select(along_u, zero, select(sv > 0.0, -one, one)),
        select(along_u, select(su > 0.0, one, -one), zero),
    )  # fmt: skip


@jit
def _along(line, turn, x, y):
    """A place from P, which is given in the axes of the places, in those of the line."""
    u, v = turn.c * x + turn.s * y, turn.c * y - turn.s * x
    return line.su * u + line.sv * v, line.eu * u + line.ev * v


@jit
def _side(part, p, q):
    """Add what a side from p to q adds to the moments: the triangle of the foot and what the line leaves of the side.

    The line itself adds nothing, as the foot lies on it.
    """
    foot = -part.ahead
    over = q[0] - p[0]
    slope = (q[1] - p[1]) / select(size_of(over) > PARALLEL, over, over - over + 1.0)
    pa, qa = greatest(p[0], foot), greatest(q[0], foot)
    pb, qb = p[1] + slope * (pa - p[0]), q[1] + slope * (qa - q[0])
    pa, qa = pa - foot, qa - foot
    w = pa * qb - pb * qa
    a, b = pa + qa, pb + qb
    aa, bb, mixed = pa * qa, pb * qb, pa * qb + pb * qa
    both = a * b - (2.0 / 3.0) * mixed
    return Part(
        part.one + w, part.a + w * a, part.b + w * b,
        part.aa + w * (a * a - aa), part.ab + w * (a * b - 0.5 * mixed), part.bb + w * (b * b - bb),
        part.aaa + w * a * (a * a - 2.0 * aa), part.aab + w * (a * both - (2.0 / 3.0) * aa * b),
        part.abb + w * (b * both - (2.0 / 3.0) * bb * a), part.bbb + w * b * (b * b - 2.0 * bb), part.ahead,
    )  # fmt: skip


@jit
def part_of(line, turn, x, y, px, py):
    """What carries of a face with four corners (x, y), counterclockwise; ``turn`` is the polar's."""
    a, b = _along(line, turn, x.a - px, y.a - py), _along(line, turn, x.b - px, y.b - py)
    c, d = _along(line, turn, x.c - px, y.c - py), _along(line, turn, x.d - px, y.d - py)
    # a line that is beyond the face may as well touch it
    ahead = least(greatest(greatest(-a[0], -b[0]), greatest(-c[0], -d[0])), 1.0)
    zero = ahead - ahead
    part = Part(zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, ahead)
    return _side(_side(_side(_side(part, a, b), b, c), c, d), d, a)


@jit
def part_of_eight(line, turn, eight, px, py):
    """The same of a face with eight corners."""
    x, y, z, w = eight
    a, b = _along(line, turn, x.a - px, y.a - py), _along(line, turn, x.b - px, y.b - py)
    c, d = _along(line, turn, x.c - px, y.c - py), _along(line, turn, x.d - px, y.d - py)
    e, f = _along(line, turn, z.a - px, w.a - py), _along(line, turn, z.b - px, w.b - py)
    g, h = _along(line, turn, z.c - px, w.c - py), _along(line, turn, z.d - px, w.d - py)
    far = greatest(greatest(greatest(-a[0], -b[0]), greatest(-c[0], -d[0])), greatest(-e[0], -f[0]))
    ahead = least(greatest(far, greatest(-g[0], -h[0])), 1.0)
    zero = ahead - ahead
    part = Part(zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, ahead)
    part = _side(_side(_side(_side(part, a, b), b, c), c, d), d, e)
    return _side(_side(_side(_side(part, e, f), f, g), g, h), h, a)


@jit
def choose_part(mask, p, q):
    """Of p and q, lane by lane."""
    return Part(
        select(mask, p.one, q.one), select(mask, p.a, q.a), select(mask, p.b, q.b), select(mask, p.aa, q.aa),
        select(mask, p.ab, q.ab), select(mask, p.bb, q.bb), select(mask, p.aaa, q.aaa), select(mask, p.aab, q.aab),
        select(mask, p.abb, q.abb), select(mask, p.bbb, q.bbb), select(mask, p.ahead, q.ahead),
    )  # fmt: skip


@jit
def spread_over(part, line):
    """The spread of the pressure on a part of a face."""
    over = 1.0 / greatest(part.one, TINY)
    two, three = over * (1.0 / 6.0), over * 0.1
    ca, cb = part.a * over * (1.0 / 3.0), part.b * over * (1.0 / 3.0)
    zaa, zab, zbb = part.aa * two - ca * ca, part.ab * two - ca * cb, part.bb * two - cb * cb
    taaa = part.aaa * three - ca * (3.0 * zaa + ca * ca)
    taab = part.aab * three - 2.0 * ca * zab - cb * (zaa + ca * ca)
    tabb = part.abb * three - 2.0 * cb * zab - ca * (zbb + cb * cb)
    tbbb = part.bbb * three - cb * (3.0 * zbb + cb * cb)
    # P from the centroid, and the pressure 1 + g . (x - c)
    ra, rb = part.ahead - ca, -cb
    det = 1.0 / greatest(zaa * zbb - zab * zab, TINY)
    ga, gb = (zbb * ra - zab * rb) * det, (zaa * rb - zab * ra) * det
    aa = zaa + ga * taaa + gb * taab - ra * ra
    ab = zab + ga * taab + gb * tabb - ra * rb
    bb = zbb + ga * tabb + gb * tbbb - rb * rb
    at = 1.0 / (1.0 + ga * ra + gb * rb)  # what is divided by is at least 1
    ga, gb = ga * at, gb * at
    # back to the axes of the polar: u = ua a + ub b, v = va a + vb b
    across = line.su * line.ev - line.sv * line.eu
    turns = 1.0 / greatest(across, TINY)
    ua, ub, va, vb = line.ev * turns, -line.sv * turns, -line.eu * turns, line.su * turns
    uu = ua * ua * aa + 2.0 * ua * ub * ab + ub * ub * bb
    uv = ua * va * aa + (ua * vb + ub * va) * ab + ub * vb * bb
    vv = va * va * aa + 2.0 * va * vb * ab + vb * vb * bb
    gu, gv = line.su * ga + line.eu * gb, line.sv * ga + line.ev * gb
    one = uu - uu + 1.0
    return Spread(uu, uv, vv, greatest(uu * vv - uv * uv, THINNEST * (uu + vv) * (uu + vv)), gu, gv, one)


@jit
def blended(found, spread, share):
    """What was ``found`` in place of what the formula says, by a share."""
    # of a sliver that is loaded at its tip single precision leaves no M at all
    seen, formula = found.uu + found.vv, spread.uu + spread.vv
    sound = (found.uu > 0.0) & (found.vv > 0.0) & (seen > formula * (1.0 / UNSOUND)) & (seen < formula * UNSOUND)
    some, rest = sound & (share > 0.0), 1.0 - share
    uu, uv = share * found.uu + rest * spread.uu, share * found.uv + rest * spread.uv
    vv = share * found.vv + rest * spread.vv
    trace = uu + vv
    return Spread(
        select(some, uu, spread.uu), select(some, uv, spread.uv), select(some, vv, spread.vv),
        select(some, greatest(uu * vv - uv * uv, THINNEST * trace * trace), spread.det),
        select(some, found.gu, spread.gu), select(some, found.gv, spread.gv), select(some, share, spread.share),
    )  # fmt: skip
