"""What a ray hits, and who is in a box or a ball: questions about shapes, asked of the tree.

All tests are exact up to rounding, for every shape: a ray against faces, round sides and caps by their formulas, boxes
and balls against shapes by their distance (:mod:`stiction.core.collide.gjk`). Surfaces belong to the shapes. Answers do
not depend on the shape of the tree.

The tree has to hold the shapes where they are now: after a step, or a change from outside, first
:func:`~stiction.core.broadphase.update_bounds`, then :func:`~stiction.core.pairs.find_moved`. Scratch of the pair cache
is used, so only one query at a time may run on it.
"""

from __future__ import annotations

import math

from stiction.core.collide.gjk import closest
from stiction.core.collide.hulls import CUBE, POINT, Convex, convex_of, face_count, face_plane, is_ellipsoid
from stiction.core.jit import jit
from stiction.core.pairs import FOUND, PLANES, PLANES_LIST, STACK
from stiction.core.state import (
    LAYER,
    ORIENTATION,
    PLANE,
    POSITION,
    SENSOR,
    SHAPE,
    SIZE,
)
from stiction.core.tree import LEFT, NONE, RIGHT, ROOT, query
from stiction.core.vec import Mat33, Vec3, column, cross, dot, length, quat, rotation, transpose, vec3

HIT_DISTANCE, HIT_NORMAL, HIT_WIDTH = 0, 1, 4
"""Columns of hits: distance from the origin of the ray, m; outward normal of the surface there, world."""

TOUCHING = 1e-9
"""m, shapes this near each other overlap."""


@jit
def may_be_found(kinds, i, mask):
    """Whether queries see body i: no sensors, and one of its layers has to be in the mask."""
    return kinds[i, SENSOR] == 0 and kinds[i, LAYER] & mask != 0


@jit
def world_plane(bodies, i):
    """Normal of a plane's half space in world axes, and its distance from the origin of the world along it."""
    n = rotation(quat(bodies, i, ORIENTATION)) @ vec3(bodies, i, SIZE)
    return n, bodies[i, SIZE + 3] + dot(n, vec3(bodies, i, POSITION))


# --- rays against shapes: the ray is o + t d with |d| = 1; an interval that ends before it begins is empty


@jit
def _ray_ball(o, d, r):
    """Where a ray is in the ball of radius r about 0.

    From the vector to the nearest point of the line, not from b^2 - 4 a c: that cancels far away (Haines et al.,
    "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019).
    """
    b = dot(o, d)
    nearest = o - d * b
    rest = r * r - dot(nearest, nearest)
    if rest < 0.0:
        return math.inf, -math.inf
    s = math.sqrt(rest)
    return -b - s, -b + s


@jit
def _ray_tube(o, d, axis, r):
    """Where a ray is in the endless cylinder of radius r about an axis through 0."""
    across, way = o - axis * dot(o, axis), d - axis * dot(d, axis)
    ww = dot(way, way)
    if ww < 1e-30:
        return (-math.inf, math.inf) if dot(across, across) <= r * r else (math.inf, -math.inf)
    c = cross(across, way)
    rest = r * r * ww - dot(c, c)
    if rest < 0.0:
        return math.inf, -math.inf
    b, s = dot(across, way), math.sqrt(rest)
    return (-b - s) / ww, (-b + s) / ww


@jit
def _ray_rounded(X, o, d):
    """First point of a ray in a sphere or a capsule: a tube between two balls, at one place for a sphere."""
    axis, h, r = column(X.R, 2), X.scale.z, X.radius
    away = o - axis * min(max(dot(o, axis), -h), h)
    if dot(away, away) <= r * r:
        return 0.0, -d
    # From outside, the first point in the union is the first in one of the three.
    best = math.inf
    for end in range(2):
        enter, leave = _ray_ball(o - axis * (h if end == 0 else -h), d, r)
        if 0.0 <= enter <= leave:
            best = min(best, enter)
    if h > 0.0:
        enter, leave = _ray_tube(o, d, axis, r)
        if 0.0 <= enter <= leave and abs(dot(o + d * enter, axis)) <= h:
            best = min(best, enter)
    if best == math.inf:
        return best, d
    p = o + d * best
    n = p - axis * min(max(dot(p, axis), -h), h)
    return best, n * (1.0 / length(n))


@jit
def _ray_ellipsoid(X, o, d):
    """First point of a ray in an ellipsoid: divided by its semi-axes, it is the ball of radius 1."""
    s, o, d_own = X.scale, transpose(X.R) @ o, transpose(X.R) @ d
    p, way = Vec3(o.x / s.x, o.y / s.y, o.z / s.z), Vec3(d_own.x / s.x, d_own.y / s.y, d_own.z / s.z)
    if dot(p, p) <= 1.0:
        return 0.0, -d
    speed = length(way)
    way = way * (1.0 / speed)
    enter, leave = _ray_ball(p, way, 1.0)
    if not 0.0 <= enter <= leave:
        return math.inf, d
    p = p + way * enter
    n = Vec3(p.x / s.x, p.y / s.y, p.z / s.z)
    return enter / speed, X.R @ (n * (1.0 / length(n)))


@jit
def _ray_faces(X, hulls, o, d):
    """First point of a ray in a box, a hull or a cylinder: the part of the ray behind all faces, and in the tube."""
    enter, leave, n = -math.inf, math.inf, d
    for f in range(face_count(X, hulls)):
        m, offset = face_plane(X, hulls, f)
        gap, closing = dot(m, o) - offset, -dot(m, d)
        if closing > 0.0:
            if gap / closing > enter:
                enter, n = gap / closing, m
        elif closing < 0.0:
            leave = min(leave, gap / closing)
        elif gap > 0.0:
            return math.inf, d
    if X.round:
        axis = column(X.R, 2)
        first, last = _ray_tube(o, d, axis, X.scale.x)
        leave = min(leave, last)
        if first > enter:
            enter = first
            if first < math.inf:
                p = o + d * first
                n = p - axis * dot(p, axis)
                n = n * (1.0 / length(n))
    if enter > leave or leave < 0.0:
        return math.inf, d
    if enter <= 0.0:
        return 0.0, -d
    return enter, n


@jit
def ray_shape(bodies, kinds, hulls, i, origin, d):
    """Distance at which a ray along the unit vector d enters body i, and the normal there.

    The distance is inf if it never does; 0 if it begins inside, and then the normal is -d.
    """
    if kinds[i, SHAPE] == PLANE:
        n, offset = world_plane(bodies, i)
        gap, closing = dot(n, origin) - offset, -dot(n, d)
        if gap <= 0.0:
            return 0.0, -d
        return (gap / closing if closing > 0.0 else math.inf), n
    p = vec3(bodies, i, POSITION)
    X = convex_of(bodies, kinds, i, p, hulls)
    if X.radius > 0.0:
        return _ray_rounded(X, origin - p, d)
    if is_ellipsoid(X):
        return _ray_ellipsoid(X, origin - p, d)
    return _ray_faces(X, hulls, origin - p, d)


# --- rays through the tree --------------------------------------------------------------------------------------------


@jit
def _slab(low, high, o, d, enter, leave):
    """The part of the interval in which o + t d is between low and high."""
    if d == 0.0:
        return (enter, leave) if low <= o <= high else (math.inf, -math.inf)
    a, b = (low - o) / d, (high - o) / d
    return max(enter, min(a, b)), min(leave, max(a, b))


@jit
def _ray_node(boxes, i, o, d, reach):
    """Distance at which a ray enters the box of node i, inf if it does not within its reach."""
    enter, leave = _slab(boxes[i, 0], boxes[i, 3], o.x, d.x, 0.0, reach)
    enter, leave = _slab(boxes[i, 1], boxes[i, 4], o.y, d.y, enter, leave)
    enter, leave = _slab(boxes[i, 2], boxes[i, 5], o.z, d.z, enter, leave)
    return enter if enter <= leave else math.inf


@jit
def _keep(hits, hit_bodies, count, i, t, n):
    """Put a hit in its place, by distance, then by body; without room the last one falls out. Returns the count."""
    room = hits.shape[0]
    k = min(count, room - 1)
    if count == room and (t > hits[k, HIT_DISTANCE] or (t == hits[k, HIT_DISTANCE] and i > hit_bodies[k])):
        return count
    while k > 0 and (hits[k - 1, HIT_DISTANCE] > t or (hits[k - 1, HIT_DISTANCE] == t and hit_bodies[k - 1] > i)):
        for c in range(HIT_WIDTH):
            hits[k, c] = hits[k - 1, c]
        hit_bodies[k] = hit_bodies[k - 1]
        k -= 1
    hits[k, HIT_DISTANCE], hit_bodies[k] = t, i
    hits[k, HIT_NORMAL], hits[k, HIT_NORMAL + 1], hits[k, HIT_NORMAL + 2] = n.x, n.y, n.z
    return min(count + 1, room)


@jit
def cast_ray(tree, cache, bodies, kinds, hulls, origin, d, reach, mask, hits, hit_bodies):
    """The nearest bodies that a ray of length ``reach`` (m, may be inf) along the unit vector d enters, nearest first.

    As many as there is room for in ``hits`` (k, HIT_WIDTH) and ``hit_bodies`` (k,), k > 0; returns their number. With
    k = 1 the tree is searched only as far as the nearest hit. To get all, call again with more room while all is used.
    """
    boxes, links, stack, room, count = tree.boxes, tree.links, cache.lists[STACK], hits.shape[0], 0
    for k in range(cache.counts[PLANES]):
        i = cache.lists[PLANES_LIST, k]
        if may_be_found(kinds, i, mask):
            t, n = ray_shape(bodies, kinds, hulls, i, origin, d)
            if t <= reach and t < math.inf:
                count = _keep(hits, hit_bodies, count, i, t, n)
    top = 0
    if tree.head[ROOT] != NONE:
        stack[0] = tree.head[ROOT]
        top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        limit = min(reach, hits[room - 1, HIT_DISTANCE]) if count == room else reach
        if _ray_node(boxes, node, origin, d, limit) == math.inf:
            continue
        if links[node, LEFT] == NONE:
            i = links[node, RIGHT]
            if may_be_found(kinds, i, mask):
                t, n = ray_shape(bodies, kinds, hulls, i, origin, d)
                if t <= limit and t < math.inf:
                    count = _keep(hits, hit_bodies, count, i, t, n)
        else:
            near, far = links[node, LEFT], links[node, RIGHT]
            if _ray_node(boxes, far, origin, d, limit) < _ray_node(boxes, near, origin, d, limit):
                near, far = far, near
            stack[top], stack[top + 1] = far, near
            top += 2
    return count


# --- regions ----------------------------------------------------------------------------------------------------------


@jit
def _overlaps(bodies, kinds, hulls, i, region, points):
    """Whether body i and a region, a box along the world's axes or a ball, have a point in common."""
    if kinds[i, SHAPE] == PLANE:
        n, offset = world_plane(bodies, i)
        h = region.scale
        return dot(n, region.p) - region.radius - abs(n.x) * h.x - abs(n.y) * h.y - abs(n.z) * h.z <= offset + TOUCHING
    X = convex_of(bodies, kinds, i, vec3(bodies, i, POSITION), hulls)
    limit = X.radius + region.radius + TOUCHING
    still, start = Vec3(0.0, 0.0, 0.0), region.p - X.p
    apart, bound, _, _, _ = closest(X, region, hulls, still, start, limit, TOUCHING, 1e-12)
    return not apart or bound <= limit


@jit
def _overlap(tree, cache, bodies, kinds, hulls, region, mask, points, out):
    room, found = out.shape[0], 0
    for k in range(cache.counts[PLANES]):
        i = cache.lists[PLANES_LIST, k]
        if may_be_found(kinds, i, mask) and _overlaps(bodies, kinds, hulls, i, region, points):
            if found < room:
                out[found] = i
            found += 1
    r = region.radius + TOUCHING
    low = region.p - region.scale - Vec3(r, r, r)
    high = region.p + region.scale + Vec3(r, r, r)
    near = cache.lists[FOUND]
    for k in range(query(tree, low.x, low.y, low.z, high.x, high.y, high.z, cache.lists[STACK], near)):
        i = near[k]
        if may_be_found(kinds, i, mask) and _overlaps(bodies, kinds, hulls, i, region, points):
            if found < room:
                out[found] = i
            found += 1
    return found


@jit
def overlap_box(tree, cache, bodies, kinds, hulls, center, half, mask, points, out):
    """Bodies whose shapes overlap the box along the world's axes with this centre and these half lengths.

    Returns their number, which may exceed the room of ``out`` (k,); they come in no particular order. ``points`` is
    scratch of the narrow phase, (SCRATCH, 5).
    """
    axes = Mat33(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    region = Convex(center, axes, half, 0.0, min(half.x, min(half.y, half.z)), CUBE, False)
    return _overlap(tree, cache, bodies, kinds, hulls, region, mask, points, out)


@jit
def overlap_sphere(tree, cache, bodies, kinds, hulls, center, radius, mask, points, out):
    """Bodies whose shapes overlap a ball; as :func:`overlap_box`."""
    axes = Mat33(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    region = Convex(center, axes, Vec3(0.0, 0.0, 0.0), radius, radius, POINT, False)
    return _overlap(tree, cache, bodies, kinds, hulls, region, mask, points, out)
