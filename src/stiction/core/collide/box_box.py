"""Contacts of two boxes: separating axes, then the incident face clipped against the reference face.

Gottschalk, Lin, Manocha, "OBBTree", SIGGRAPH 1996 (the 15 axes); clipping after Sutherland and Hodgman, 1974. The axis
of least overlap wins, faces before edges unless an edge is clearly better, so that the manifold does not flicker.

Boxes that are apart may be nearest to each other with a corner beside all faces, which none of the 15 axes sees. What
is found is then farther than the best axis says, and the corners are tried one by one: boxes that are apart are
nearest with a corner of either one, or with two edges that cross, whose axis is then the best of the 15.
"""

from __future__ import annotations

import math

from stiction.core.collide.manifold import ENDLESS, emit, lasting, put_lead, put_radii, reduce
from stiction.core.jit import jit
from stiction.core.vec import Vec3, column, cross, dot, rotation, transpose

FACE_PREFERENCE = 0.005
"""An edge axis must be better than the best face by this part of the smallest half length."""
LEANING = 5e-5
"""... and if its axis is within 0.01 rad of the normal of that face (cosines differ by this), and so is the direction
that was found last, it must be no face at all: boxes that lie on each other with their faces have leaned, and where the
edges cross is a corner of the patch."""
TOUCHING = 1e-9
"""Corners that are nearer than this part of the smallest half length have no direction of their own; a corner must be
nearer than an earlier one by more than this part of the square of its distance."""
PARALLEL = 1e-8
"""Edges whose cross product is shorter than the root of this are parallel: their axis is that of a face."""


@jit
def _get(v, k):
    return v.x if k == 0 else (v.y if k == 1 else v.z)


@jit
def _reach(half, c):
    """Half the extent of a box along an axis whose components in the box's axes are c."""
    return half.x * abs(c.x) + half.y * abs(c.y) + half.z * abs(c.z)


@jit
def _octant(v):
    """A bit for each component above 0."""
    return (1 if v.x > 0.0 else 0) | (2 if v.y > 0.0 else 0) | (4 if v.z > 0.0 else 0)


@jit
def box_box(contacts, tags, count, a, pa, qa, ha, b, pb, qb, hb, margin, hint, points):
    """Feature of a point: axis (0 to 14; 15 and 16 are a corner of a and of b), then incident face and corner or clip
    edge, or both edges, or the corner and what of the other box is nearest to it.

    ``hint`` is a direction in which b may be found, of any length, or zero: it is tried first. Returns the new count,
    and, with no new point, a direction along which they are apart, and how far. ``points`` is scratch, (16, 5).
    """
    Ra = rotation(qa)
    Rb = rotation(qb)
    RaT = transpose(Ra)
    RbT = transpose(Rb)
    d = pb - pa
    size, known = dot(hint, hint), hint
    if size > 0.0:
        e = known = hint * (1.0 / math.sqrt(size))
        separation = dot(d, e) - _reach(ha, RaT @ e) - _reach(hb, RbT @ e)
        if separation > margin:
            return count, e, separation

    face, best_face, face_normal = -1, -math.inf, d
    small = min(min(ha.x, min(ha.y, ha.z)), min(hb.x, min(hb.y, hb.z)))
    slack = FACE_PREFERENCE * small
    for k in range(6):
        e = column(Ra, k) if k < 3 else column(Rb, k - 3)
        s = dot(d, e)
        separation = abs(s) - _reach(ha, RaT @ e) - _reach(hb, RbT @ e)
        if separation > margin:
            return count, e if s > 0.0 else -e, separation
        if separation > best_face + slack:
            face, best_face, face_normal = k, separation, e if s > 0.0 else -e
    edge, best_edge, edge_normal = -1, -math.inf, d
    for i in range(3):
        for j in range(3):
            e = cross(column(Ra, i), column(Rb, j))
            e2 = dot(e, e)
            if e2 > PARALLEL:
                e = e * (1.0 / math.sqrt(e2))
                s = dot(d, e)
                separation = abs(s) - _reach(ha, RaT @ e) - _reach(hb, RbT @ e)
                if separation > margin:
                    return count, e if s > 0.0 else -e, separation
                if separation > best_edge:
                    edge, best_edge, edge_normal = 6 + 3 * i + j, separation, e if s > 0.0 else -e

    best = max(best_face, best_edge)
    apart, found = best > 0.0, 0
    clear = best_edge > best_face + slack + lasting(known, face_normal, -best_face, small)
    leans = clear and min(dot(edge_normal, face_normal), dot(known, face_normal)) > 1.0 - LEANING
    if leans or not clear:
        out = face_normal
        if face < 3:
            found = _clip(pa, Ra, ha, face, out, pb, Rb, hb, margin, points, face)
        else:
            out = -face_normal
            found = _clip(pb, Rb, hb, face - 3, out, pa, Ra, ha, margin, points, face)
        found = reduce(points, found, out)
        if leans and found < 3:
            found = 0
        if apart and found > 0:
            deepest = points[0, 3]
            for i in range(1, found):
                deepest = min(deepest, points[i, 3])
            if deepest > best + slack:
                found = 0  # the nearest place lies beside the face, or is not among the four
    if found == 0:
        # the edges are clearly nearer, or no corner of the one box lies over the face of the other
        if edge >= 0 and best_edge >= best_face - slack:
            crossing, count = _edge_edge(
                contacts, tags, count, a, pa, Ra, ha, b, pb, Rb, hb, edge_normal, best_edge, edge, apart, points
            )
            if crossing:
                return count, edge_normal, best_edge
        if apart:
            otherwise = face_normal if best_face >= best_edge else edge_normal
            return _corner(contacts, tags, count, a, pa, Ra, ha, b, pb, Rb, hb, margin, otherwise, best)
    if found <= 2:
        # corners and edges, which have no radius across the face either
        put_radii(points, (face < 3) == (a < b), face_normal, ENDLESS, ENDLESS)
        put_radii(points, (face < 3) == (b < a), face_normal, 0.0, 0.0)
        if face < 3:
            put_lead(points, _inside(pa, Ra, ha, face, found, points))
        else:
            put_lead(points, _inside(pb, Rb, hb, face - 3, found, points))
    for i in range(found):
        p = Vec3(points[i, 0], points[i, 1], points[i, 2])
        count = emit(contacts, tags, count, a, b, p, face_normal, points[i, 3], int(points[i, 4]))
    return count, face_normal, best_face


@jit
def _edge_edge(contacts, tags, count, a, pa, Ra, ha, b, pb, Rb, hb, normal, separation, axis, apart, points):
    """The nearest points of the two edges whose cross product is the normal.

    Returns whether they cross, and the new count. If the boxes are apart, the lines may pass each other beyond an end
    of an edge: then a corner is nearer than they are, and nothing is written.
    """
    i, j = (axis - 6) // 3, (axis - 6) % 3
    na = transpose(Ra) @ normal
    nb = transpose(Rb) @ normal
    sa = Vec3(math.copysign(ha.x, na.x), math.copysign(ha.y, na.y), math.copysign(ha.z, na.z))
    sb = Vec3(-math.copysign(hb.x, nb.x), -math.copysign(hb.y, nb.y), -math.copysign(hb.z, nb.z))
    u, v = column(Ra, i), column(Rb, j)
    # middle of each edge: the corner, less its component along the edge
    qa = pa + Ra @ sa - u * _get(sa, i)
    qb = pb + Rb @ sb - v * _get(sb, j)
    w = qb - qa
    uv = dot(u, v)
    scale = 1.0 / (1.0 - uv * uv)
    s = (dot(w, u) - uv * dot(w, v)) * scale
    t = (uv * dot(w, u) - dot(w, v)) * scale
    if apart and (abs(s) > _get(ha, i) or abs(t) > _get(hb, j)):
        return False, count
    s = min(max(s, -_get(ha, i)), _get(ha, i))
    t = min(max(t, -_get(hb, j)), _get(hb, j))
    point = (qa + u * s + qb + v * t) * 0.5
    put_radii(points, a < b, u, ENDLESS, 0.0)
    put_radii(points, b < a, v, ENDLESS, 0.0)
    # as collide.curved says: to the next edge of either box, and to the ends of these
    lead = min(_next_edge(ha, na, i), _next_edge(hb, nb, j))
    put_lead(points, max(min(lead, min(_get(ha, i) - abs(s), _get(hb, j) - abs(t))), 0.0))
    # which of the four parallel edges of either box: the signs of its corner, less that along the edge
    edges = (_octant(sa) & ~(1 << i)) << 3 | (_octant(sb) & ~(1 << j))
    return True, emit(contacts, tags, count, a, b, point, normal, separation, axis << 8 | edges)


@jit
def _next_edge(half, n, i):
    """Half of how much less far the next parallel of an edge along axis i reaches along n."""
    y, z = (i + 1) % 3, (i + 2) % 3
    return min(_get(half, y) * abs(_get(n, y)), _get(half, z) * abs(_get(n, z)))


@jit
def _corner(contacts, tags, count, a, pa, Ra, ha, b, pb, Rb, hb, margin, otherwise, bound):
    """The corner of either box that is nearest to the other one; the boxes are apart, by ``bound`` along ``otherwise``
    at least. Returns what :func:`box_box` does."""
    least, middle, gap, feature = math.inf, pa, pb - pa, 0
    for side in range(2):
        p, R, h, q, S, g = pa, Ra, ha, pb, Rb, hb
        if side == 1:
            p, R, h, q, S, g = pb, Rb, hb, pa, Ra, ha
        # both in the axes of the box whose corners are not tried
        T = transpose(S)
        d, W = T @ (p - q), T @ R
        for corner in range(8):
            c = Vec3(h.x if corner & 1 else -h.x, h.y if corner & 2 else -h.y, h.z if corner & 4 else -h.z)
            v = d + W @ c
            w = Vec3(min(max(v.x, -g.x), g.x), min(max(v.y, -g.y), g.y), min(max(v.z, -g.z), g.z))
            # a corner of either one may be nearest to a corner of the other one
            if dot(v - w, v - w) < least * (1.0 - TOUCHING):
                least = dot(v - w, v - w)
                # in the axes of that box: a difference of two places in the world would keep their rounding
                middle, gap = q + S @ ((v + w) * 0.5), S @ (w - v if side == 0 else v - w)
                # beyond which of the faces, either way
                outside = _octant(v - g) | _octant(-v - g) << 3
                feature = (15 + side) << 9 | outside << 3 | corner
    distance = math.sqrt(least)
    normal = otherwise
    if distance > TOUCHING * min(min(ha.x, min(ha.y, ha.z)), min(hb.x, min(hb.y, hb.z))):
        normal = gap * (1.0 / distance)
    if distance <= margin:
        return emit(contacts, tags, count, a, b, middle, normal, distance, feature), normal, distance
    separation = dot(pb - pa, normal) - _reach(ha, transpose(Ra) @ normal) - _reach(hb, transpose(Rb) @ normal)
    if separation > bound:
        return count, normal, separation
    return count, otherwise, bound


@jit
def _clip(pr, Rr, hr, k, n, pi, Ri, hi, margin, points, axis):
    """Clip the face of the incident box that looks most against n to the reference face k; n points out of it.

    Works in the reference face: u, v in the plane, w the height over it. Rows 8 to 15 of ``points``
    are the second buffer.
    """
    i, j = (k + 1) % 3, (k + 2) % 3
    u, v = column(Rr, i), column(Rr, j)
    hu, hv, hk = _get(hr, i), _get(hr, j), _get(hr, k)

    m = transpose(Ri) @ n
    face = 0
    if abs(m.y) > abs(_get(m, face)):
        face = 1
    if abs(m.z) > abs(_get(m, face)):
        face = 2
    side = -1.0 if _get(m, face) > 0.0 else 1.0
    center = pi + column(Ri, face) * (side * _get(hi, face)) - pr
    e1 = column(Ri, (face + 1) % 3) * _get(hi, (face + 1) % 3)
    e2 = column(Ri, (face + 2) % 3) * _get(hi, (face + 2) % 3)
    for corner in range(4):
        p = center + e1 * (1.0 if corner == 0 or corner == 3 else -1.0) + e2 * (1.0 if corner < 2 else -1.0)
        points[corner, 0], points[corner, 1] = dot(p, u), dot(p, v)
        points[corner, 3], points[corner, 4] = dot(p, n) - hk, corner

    found, source = 4, 0
    for plane in range(4):
        coordinate = plane >> 1
        sign = 1.0 if plane & 1 else -1.0
        limit = hu if coordinate == 0 else hv
        target = 8 - source
        kept = 0
        for q in range(found):
            here, there = source + q, source + (q + 1) % found
            d0 = sign * points[here, coordinate] - limit
            d1 = sign * points[there, coordinate] - limit
            if d0 <= 0.0 and kept < 8:
                for c in range(5):
                    points[target + kept, c] = points[here, c]
                kept += 1
            if (d0 < 0.0 < d1 or d1 < 0.0 < d0) and kept < 8:
                f = d0 / (d0 - d1)
                for c in range(4):
                    points[target + kept, c] = points[here, c] + f * (points[there, c] - points[here, c])
                points[target + kept, 4] = 4 + 2 * plane + (1 if d1 > 0.0 else 0)
                kept += 1
        found, source = kept, target

    # back to the world: the point lies half way between the reference face and the incident one
    base = (axis << 8) | ((2 * face + (1 if side > 0.0 else 0)) << 4)
    touching = 0
    for q in range(found):
        row = source + q
        separation = points[row, 3]
        if separation <= margin:
            p = pr + u * points[row, 0] + v * points[row, 1] + n * (hk + 0.5 * separation)
            feature = base | int(points[row, 4])
            points[touching, 0], points[touching, 1], points[touching, 2] = p.x, p.y, p.z
            points[touching, 3], points[touching, 4] = separation, feature
            touching += 1
    return touching


@jit
def _inside(p, R, half, k, found, points):
    """How far the first ``found`` points are within the border of face k of a box, m."""
    i, j = (k + 1) % 3, (k + 2) % 3
    least = math.inf
    for c in range(found):
        d = Vec3(points[c, 0] - p.x, points[c, 1] - p.y, points[c, 2] - p.z)
        least = min(least, min(_get(half, i) - abs(dot(d, column(R, i))), _get(half, j) - abs(dot(d, column(R, j)))))
    return max(least, 0.0)
