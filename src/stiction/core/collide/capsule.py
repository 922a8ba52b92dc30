"""Contacts of a capsule with another one, or with a sphere, which is a capsule of no length."""

from __future__ import annotations

import math

from stiction.core.collide.clip import clip_lines
from stiction.core.collide.manifold import emit
from stiction.core.jit import jit
from stiction.core.vec import Vec3, column, cross, dot, length, vec3


@jit
def perpendicular(u):
    """Some direction across u."""
    x, y, z = abs(u.x), abs(u.y), abs(u.z)
    e = Vec3(1.0, 0.0, 0.0) if x <= y and x <= z else (Vec3(0.0, 1.0, 0.0) if y <= z else Vec3(0.0, 0.0, 1.0))
    m = cross(u, e)
    size = length(m)
    return m * (1.0 / size) if size > 0.0 else e


@jit
def nearest_on_segments(p, u, q, v):
    """Where p + s u and q + t v come nearest to each other, s and t in 0 to 1 (Ericson, "Real-time collision
    detection", 2005, section 5.1.9)."""
    w = p - q
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    wu, wv = dot(w, u), dot(w, v)
    if uu <= 0.0:
        return 0.0, min(max(wv / vv, 0.0), 1.0) if vv > 0.0 else 0.0
    if vv <= 0.0:
        return min(max(-wu / uu, 0.0), 1.0), 0.0
    d = uu * vv - uv * uv
    s = min(max((uv * wv - wu * vv) / d, 0.0), 1.0) if d > 1e-14 * uu * vv else 0.0
    t = (uv * s + wv) / vv
    if t < 0.0:
        t, s = 0.0, min(max(-wu / uu, 0.0), 1.0)
    elif t > 1.0:
        t, s = 1.0, min(max((uv - wu) / uu, 0.0), 1.0)
    return s, t


@jit
def capsule_capsule(contacts, tags, count, a, A, b, B, origin, hulls, margin, points):
    """Two points where the capsules lie along each other, else one. Also returns the separation."""
    u, v = column(A.R, 2) * (2.0 * A.scale.z), column(B.R, 2) * (2.0 * B.scale.z)
    p, q = A.p - u * 0.5, B.p - v * 0.5
    s, t = nearest_on_segments(p, u, q, v)
    pa, pb = p + u * s, q + v * t
    d = pb - pa
    distance = length(d)
    separation = distance - A.radius - B.radius
    if separation > margin:
        return count, separation
    if distance > 1e-12 * (A.radius + B.radius):
        n = d * (1.0 / distance)
    else:
        # the axes meet: out across both, or across the only one
        n = cross(u, v)
        size = length(n)
        longer = u if length(u) > length(v) else v
        n = n * (1.0 / size) if size > 1e-9 * length(u) * length(v) else perpendicular(longer)
        n = n * math.copysign(1.0, dot(n, B.p - A.p))
    found = clip_lines(A, B, n, separation, a < b, hulls, margin, points)
    for i in range(found):
        count = emit(contacts, tags, count, a, b, origin + vec3(points, i, 0), n, points[i, 3], int(points[i, 4]))
    if found == 0:
        point = (pa + n * A.radius + pb - n * B.radius) * 0.5
        count = emit(contacts, tags, count, a, b, origin + point, n, separation, 0)
    return count, separation
