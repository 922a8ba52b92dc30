"""Manifolds of bodies that have moved a little: kept, or taken along, so that no narrow phase has to be run.

What counts is how the two bodies have moved against each other: by how much their copies of the anchor have come
apart, and how far their copies of the frame have turned, times the reach of the smaller body. Bodies that fall or ride
together do not move by this measure.

A face of three or four points is kept: its separations follow from the poses to second order. One or two points may
roll over both bodies, and their normal turns with them. Where they go is told by how the surfaces are curved there: a
corner has no radius in any direction, an edge and the side of a cylinder an endless one in one direction, a face in
all of them (``collide/curved.py``). These are the equations of rolling of Montana, "The kinematics of contact and
grasp", Int. J. Robotics Research 7(3), 1988, with radii in place of curvatures, so that corners and edges have a place
in them; solved for a whole step instead of a rate they are good to second order in its motion. How long the features
stay the same is known from the time when they were found: that is the lead of a manifold.

Costs 60 ns in place of 100 to 700 for a search; in a heap that settles two of three are taken along, in one that rests
nine of ten.
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.apart import FARTHEST, smaller_reach
from stiction.core.jit import jit
from stiction.core.state import LEAD, RADII
from stiction.core.vec import cross, dot, length, mat33, put_vec3, transpose, vec3

STILL = 1e-9
"""m, bodies that have moved by less than that have not moved."""
KEPT, KEPT_PART = 5e-4, 0.002
"""m, a manifold is kept or taken along until its bodies have moved by so much against each other, or by this part of
the smaller one if that is less; ..."""
TAKEN = 16.0
"""... one or two points by so many times more, if the bodies have no other features there."""
STEEPEST = 0.02
"""rad, a point whose normal would turn by more in a step is looked for anew."""
LONGEST = 1e6
"""The radius of what is flat, in parts of the smaller body, ..."""
SHARPEST = 1e-3
"""... and below which both together have none."""


@jit
def limit_of(pose, kinds, a, b):
    """How far two bodies may move against each other until their manifold is made anew, m."""
    return min(KEPT, KEPT_PART * smaller_reach(pose, kinds, a, b))


@jit
def is_kept(kinds, a, b, pose, manifolds, meta, row):
    """Whether the narrow phase would find the points that the manifold already has, where it has them."""
    moved = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION] - meta[row, s.MADE]
    if meta[row, s.POINTS] < 3.0:
        return meta[row, s.POINTS] > 0.0 and moved <= STILL
    if moved > FARTHEST:
        return False
    limit = limit_of(pose, kinds, a, b)
    if moved <= limit:
        return True
    Ra, Rb = mat33(pose, a + 1, s.POSE_ROTATION), mat33(pose, b + 1, s.POSE_ROTATION)
    ra, rb = Ra @ vec3(meta, row, s.ANCHOR_A), Rb @ vec3(meta, row, s.ANCHOR_B)
    shift = (vec3(pose, b + 1, s.POSE_X) + rb) - (vec3(pose, a + 1, s.POSE_X) + ra)
    dn = Rb @ vec3(manifolds, row, s.NORMAL_B) - Ra @ vec3(manifolds, row, s.NORMAL_A)
    du = Rb @ vec3(manifolds, row, s.TANGENT_B) - Ra @ vec3(manifolds, row, s.TANGENT_A)
    turn = math.sqrt(dot(dn, dn) + dot(du, du))
    return length(shift) + turn * smaller_reach(pose, kinds, a, b) <= limit


@jit
def rolls_on(kinds, a, b, pose, manifolds, meta, radii, row, farthest):
    """Take a manifold of one or two points along to where they have rolled; returns whether that could be done. Not if
    they have gone too far since they were looked for, or are more than ``farthest`` apart now, m.

    With a the change of the normal on A, m that of B's copy of it against A's, d the way of B's copy of the anchor
    from A's, all in the plane, and P the radii: A touches at P_A a and B at d - P_B (a - m), so (P_A + P_B) a = d + P_B
    m.
    """
    moved = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION]
    if meta[row, s.POINTS] > 2.0 or meta[row, s.LEAD] <= 0.0 or moved - meta[row, s.MADE] > FARTHEST:
        return False
    Ra, Rb = mat33(pose, a + 1, s.POSE_ROTATION), mat33(pose, b + 1, s.POSE_ROTATION)
    xa, xb = vec3(pose, a + 1, s.POSE_X), vec3(pose, b + 1, s.POSE_X)
    pa, pb = xa + Ra @ vec3(meta, row, s.ANCHOR_A), xb + Rb @ vec3(meta, row, s.ANCHOR_B)
    n, u = Ra @ vec3(manifolds, row, s.NORMAL_A), Ra @ vec3(manifolds, row, s.TANGENT_A)
    v = cross(n, u)
    nb, ub = Rb @ vec3(manifolds, row, s.NORMAL_B), Rb @ vec3(manifolds, row, s.TANGENT_B)
    d = pb - pa
    mu, mv, twist = dot(nb, u), dot(nb, v), dot(ub, v)
    smaller = smaller_reach(pose, kinds, a, b)
    longest = LONGEST * smaller
    auu, auv, avv = radii_at(radii, row, s.RADII_A, longest)
    buu, buv, bvv = radii_at(radii, row, s.RADII_B, longest)
    suu, suv, svv = auu + buu, auv + buv, avv + bvv
    du, dv = dot(d, u), dot(d, v)
    gu, gv = du + buu * mu + buv * mv, dv + buv * mu + bvv * mv
    area = suu * svv - suv * suv
    # two corners, or a rim and a corner in line with it: no direction follows from where they are
    if not area > SHARPEST * SHARPEST * smaller * smaller:
        return False
    au, av = (svv * gu - suv * gv) / area, (suu * gv - suv * gu) / area
    bu, bv = au - mu, av - mv
    if max(au * au + av * av, bu * bu + bv * bv) > STEEPEST * STEEPEST:
        return False
    # on either surface: how far the place goes, and by how much it falls behind the plane in which it was
    fu, fv, hu, hv = auu * au + auv * av, auv * au + avv * av, buu * bu + buv * bv, buv * bu + bvv * bv
    fall_a, fall_b = 0.5 * (fu * au + fv * av), 0.5 * (hu * bu + hv * bv)
    if auu + avv > buu + bvv:
        fu, fv = du - hu, dv - hv
    else:
        hu, hv = du - fu, dv - fv
    turned = max(au * au + av * av, bu * bu + bv * bv) + twist * twist
    went = math.sqrt(max(fu * fu + fv * fv, hu * hu + hv * hv)) + math.sqrt(turned) * smaller
    left = meta[row, s.LEAD] - went
    if not left >= 0.0:
        return False
    before = n
    n = n + u * au + v * av
    n = n * (1.0 / length(n))
    apart = dot(n, d) - fall_a - fall_b
    points = int(meta[row, s.POINTS])
    for k in range(points):
        if not manifolds[row, s.GAP + k] + opened(manifolds, row, k, apart, mu, mv) <= farthest:
            return False
    for k in range(points):
        manifolds[row, s.GAP + k] += opened(manifolds, row, k, apart, mu, mv)

    center = pa + u * fu + v * fv + before * (0.5 * apart - fall_a)
    carry_pull(manifolds, row, pa - center, n)
    put_frame(manifolds, meta, row, Ra, Rb, center - xa, center - xb, n, in_plane(u, n))
    meta[row, s.MADE], meta[row, s.LEAD] = moved, left
    return True


@jit
def opened(manifolds, row, k, apart, mu, mv):
    """How much farther point k is open where the anchor is so by ``apart``, and B's normal has turned by m."""
    return apart - mu * manifolds[row, s.PLACE_U + k] - mv * manifolds[row, s.PLACE_V + k]


@jit
def radii_at(radii, row, k, longest):
    """The matrix of the radii of one body in the plane, uu, uv, vv, m: how far the place of contact goes when the
    normal turns by a radian. Made here of what it is made of, for its entries alone, in single precision, would not be
    zero across what is endless along it."""
    c, sn = float(radii[row, k]), float(radii[row, k + 1])
    across = min(float(radii[row, k + 3]), longest)
    more = min(float(radii[row, k + 2]), longest) - across
    return across + more * c * c, more * c * sn, across + more * sn * sn


@jit
def in_plane(u, n):
    """A tangent that was one of nearly the same normal, as one of the normal n."""
    u = u - n * dot(n, u)
    return u * (1.0 / length(u))


@jit
def carry_pull(manifolds, row, back, n):
    """Friction of the step before at a new anchor and across a new normal n; ``back``: from there to the old anchor,
    to which the torque about the normal belongs, world, m."""
    pull = vec3(manifolds, row, s.PULL)
    manifolds[row, s.SPIN] += dot(cross(back, pull), n)
    put_vec3(manifolds, row, s.PULL, pull - n * dot(pull, n))


@jit
def put_frame(manifolds, meta, row, Ra, Rb, ra, rb, n, u):
    """Enter the normal and the first tangent, and the anchor, which is at ra and rb from the centres of mass, in the
    axes of both bodies."""
    put_vec3(manifolds, row, s.NORMAL_A, transpose(Ra) @ n)
    put_vec3(manifolds, row, s.TANGENT_A, transpose(Ra) @ u)
    put_vec3(manifolds, row, s.NORMAL_B, transpose(Rb) @ n)
    put_vec3(manifolds, row, s.TANGENT_B, transpose(Rb) @ u)
    put_vec3(meta, row, s.ANCHOR_A, transpose(Ra) @ ra)
    put_vec3(meta, row, s.ANCHOR_B, transpose(Rb) @ rb)


@jit
def keep_radii(points, n, u, radii, row):
    """Enter how the bodies are curved at one or two points, as the narrow phase told it, in the plane of n and u."""
    v = cross(n, u)
    for k in range(2):
        d = vec3(points, RADII + k, 0)
        c, sn = dot(d, u), dot(d, v)
        size = math.sqrt(c * c + sn * sn)
        c, sn = (c / size, sn / size) if size > 0.0 else (1.0, 0.0)
        o = s.RADII_A if k == 0 else s.RADII_B
        radii[row, o], radii[row, o + 1] = c, sn
        radii[row, o + 2], radii[row, o + 3] = points[RADII + k, 3], points[RADII + k, 4]


@jit
def lead_of(points, found, limit):
    """How far the bodies may move against each other until ``found`` points have to be looked for anew, if no more than
    ``limit`` is allowed without a look at what else there is, m."""
    known = points[RADII, 3] >= 0.0 and points[RADII + 1, 3] >= 0.0
    if found > 2 or not known:
        return 0.0
    return min(max(limit, points[LEAD, 0]), TAKEN * limit)
