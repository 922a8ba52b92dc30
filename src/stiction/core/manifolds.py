"""Manifolds: the contact points of a pair as the soft solver keeps them, and when they are looked for again.

A manifold is made from the contact points of the narrow phase and lives in the two bodies' own frames. While the bodies
have hardly moved against each other it is kept or taken along (``going_on.py``), and the narrow phase is not run.
Impulses go over to a new set of points by feature, else by place.

The points stand counterclockwise around the normal. The frame (n, u, v) of a manifold has u along the longer principal
axis of its face (``faces.py``); in a step it is turned to the axes of the pressure (``solve/blocks.py``).
"""

from __future__ import annotations

import math

from stiction.core import soft_rows as s
from stiction.core.apart import FARTHEST
from stiction.core.contact_space import contact_basis
from stiction.core.faces import measure_face, order_points
from stiction.core.going_on import carry_pull, keep_radii, lead_of, limit_of, put_frame
from stiction.core.jit import jit
from stiction.core.state import (
    CAPSULE,
    CYLINDER,
    DYNAMIC_MU,
    ELLIPSOID,
    FEATURE,
    KINEMATIC,
    MATERIAL,
    MOBILITY,
    NORMAL,
    POINT,
    RESTITUTION,
    ROLLING,
    SEPARATION,
    SHAPE,
    SIZE,
    SPHERE,
    STATIC_MU,
    SURFACE,
    TORSIONAL,
    V_START,
    W_START,
    V,
    W,
)
from stiction.core.vec import Vec3, column, cross, dot, length, mat33, put_vec3, transpose, vec3, wide

SAME_PLACE = 0.1
"""Of the patch's size: a point without a partner of the same feature inherits from the nearest old one this close."""
NOWHERE = 1e3
"""m, separation of a point that is not there: never near."""
FLAT = 1e-4
"""Of the size of a face: points whose separations differ by less are equally far."""
NOWHERE_YET = -1.0
"""What PLACED says of a manifold that was not there in the step before, or had other points."""
TOUCHED = 1e-6
"""m, half of a gap that makes no difference to where friction acts."""
PULL_BACK = 0.1
"""Of the way that a face that sticks has crept, in a step."""
CREEP = 0.002
"""Of the motion that a manifold is kept for: what has gone farther aside did not creep, and takes hold where it is."""
LEAP = 0.3
"""Of its arm: a point of contact that went farther in a step did not roll there."""


@jit
def clear_manifold(manifolds, meta, reports, row):
    """Nothing is known of a pair that begins to touch."""
    for k in range(s.MANIFOLD_WIDTH):
        manifolds[row, k] = 0.0
    for k in range(s.META_WIDTH):
        meta[row, k] = 0.0
    for k in range(s.REPORT_WIDTH):
        reports[row, k] = 0.0
    meta[row, s.MADE] = -1e30
    manifolds[row, s.FRESH] = s.NEW


@jit
def take_points(
    bodies, kinds, a, b, soft, row, contacts, tags, found, points, table, slow
):  # fmt: skip
    """Make the manifold anew from ``found`` contact points; ``slow`` (m/s) is the slip below which it begins stuck.

    ``points`` is the scratch of the narrow phase, which may hold the whole face.
    """
    manifolds, meta, reports, pose = soft.manifolds, soft.meta, soft.reports, soft.pose
    moved, before = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION], meta[row, s.MADE]
    meta[row, s.MADE] = moved
    Ra, Rb = mat33(pose, a + 1, s.POSE_ROTATION), mat33(pose, b + 1, s.POSE_ROTATION)
    xa, xb = vec3(pose, a + 1, s.POSE_X), vec3(pose, b + 1, s.POSE_X)
    n = vec3(contacts, 0, NORMAL)
    order_points(contacts, tags, found, n)
    center = vec3(contacts, 0, POINT)
    for k in range(1, found):
        center = center + vec3(contacts, k, POINT)
    center = center * (1.0 / found)
    if found <= 2:
        center = center + n * to_round_surface(
            bodies, kinds, a, b, contacts, found, transpose(Ra) @ n, transpose(Rb) @ n
        )

    meta[row, s.LEAD] = lead_of(points, found, limit_of(pose, kinds, a, b))
    same = meta[row, s.POINTS] == found
    for k in range(found):
        same &= meta[row, s.FEATURES + k] == tags[k, FEATURE]
    old_center = xa + Ra @ vec3(meta, row, s.ANCHOR_A)
    # most points are the ones of the step before, and no body has been edited
    if same and found == 1 and moved - before <= FARTHEST:
        manifolds[row, s.GAP] = contacts[0, SEPARATION] - reports[row, s.LIFT]
        u = column(contact_basis(n), 1)
        if meta[row, s.LEAD] > 0.0:
            keep_radii(points, n, u, soft.corners, row)
        carry_pull(manifolds, row, old_center - center, n)
        put_frame(manifolds, meta, row, Ra, Rb, center - xa, center - xb, n, u)
        return

    fresh = meta[row, s.POINTS] == 0
    if found > 2:
        reports[row, s.HELD] = 0.0
    elif not same:
        meta[row, s.PLACED] = NOWHERE_YET
    old_u = Ra @ vec3(manifolds, row, s.TANGENT_A)
    old_v = cross(Ra @ vec3(manifolds, row, s.NORMAL_A), old_u)
    old_x = (
        manifolds[row, s.PLACE_U],
        manifolds[row, s.PLACE_U + 1],
        manifolds[row, s.PLACE_U + 2],
        manifolds[row, s.PLACE_U + 3],
    )
    old_y = (
        manifolds[row, s.PLACE_V],
        manifolds[row, s.PLACE_V + 1],
        manifolds[row, s.PLACE_V + 2],
        manifolds[row, s.PLACE_V + 3],
    )
    u, spread2 = measure_face(contacts, tags, found, center, n, points, manifolds, soft.corners, row)
    meta[row, s.SIZE2] = spread2
    size2 = spread2 * SAME_PLACE * SAME_PLACE

    # impulses of the same points: by feature, else by place
    o0, o1, o2, o3 = (
        manifolds[row, s.LOAD],
        manifolds[row, s.LOAD + 1],
        manifolds[row, s.LOAD + 2],
        manifolds[row, s.LOAD + 3],
    )
    old_points = int(meta[row, s.POINTS])
    lift = (reports[row, s.LIFT], reports[row, s.LIFT + 1], reports[row, s.LIFT + 2], reports[row, s.LIFT + 3])
    for k in range(4):
        reports[row, s.LIFT + k] = 0.0
    taken = 0
    l0 = l1 = l2 = l3 = o0 - o0
    for attempt in range(2):
        for k in range(found):
            if fresh or (taken >> (4 + k)) & 1:
                continue
            d = vec3(contacts, k, POINT) - old_center
            x, y = dot(d, old_u), dot(d, old_v)
            best, match = size2, -1
            for j in range(old_points):
                if (taken >> j) & 1:
                    continue
                if attempt == 0:
                    if meta[row, s.FEATURES + j] == tags[k, FEATURE]:
                        match = j
                else:
                    dx, dy = x - old_x[j], y - old_y[j]
                    if dx * dx + dy * dy <= best:
                        best, match = dx * dx + dy * dy, j
            if match >= 0:
                taken |= (1 << match) | (1 << (4 + k))
                reports[row, s.LIFT + k] = lift[match]
                carried = o0 if match == 0 else (o1 if match == 1 else (o2 if match == 2 else o3))
                if k == 0:
                    l0 = carried
                elif k == 1:
                    l1 = carried
                elif k == 2:
                    l2 = carried
                else:
                    l3 = carried
    if not fresh:
        carry_pull(manifolds, row, old_center - center, n)

    for k in range(4):
        here = k < found
        manifolds[row, s.GAP + k] = contacts[k, SEPARATION] - reports[row, s.LIFT + k] if here else NOWHERE
        meta[row, s.FEATURES + k] = tags[k, FEATURE] if here else -1
    manifolds[row, s.LOAD], manifolds[row, s.LOAD + 1] = l0, l1
    manifolds[row, s.LOAD + 2], manifolds[row, s.LOAD + 3] = l2, l3
    meta[row, s.POINTS] = found
    meta[row, s.RISE] = rise_of(contacts, found, center, n, spread2)
    if meta[row, s.LEAD] > 0.0:
        keep_radii(points, n, u, soft.corners, row)
    put_frame(manifolds, meta, row, Ra, Rb, center - xa, center - xb, n, u)
    set_coefficients(kinds, table, a, b, manifolds, meta, row)
    if fresh:
        spread = math.sqrt(spread2)
        ra, rb = center - xa, center - xb
        va, wa = velocity_before(bodies, kinds, a)
        vb, wb = velocity_before(bodies, kinds, b)
        slip = va + cross(wa, ra) - vb - cross(wb, rb) + belt_velocity(bodies, pose, a, b)
        calm = length(slip) + spread * length(wa - wb) < slow
        manifolds[row, s.FRESH] = s.QUIET if calm else s.NEW
        slip = slip - n * dot(n, slip)
        fast = length(slip) + spread * abs(dot(wa - wb, n)) > slow
        manifolds[row, s.STATE] = s.SLIDING if fast else s.STUCK
        manifolds[row, s.OVER] = 0.0
        manifolds[row, s.SPIN] = 0.0
        manifolds[row, s.LEFT] = 0.0
        manifolds[row, s.ROLL] = manifolds[row, s.ROLL + 1] = 0.0
        put_vec3(manifolds, row, s.PULL, Vec3(0.0, 0.0, 0.0))


@jit
def to_round_surface(bodies, kinds, a, b, contacts, found, na, nb):
    """From the middle of a penetration along the normal to where what rolls has its full radius, m.

    Half way a ball would roll on a radius that is short by half of what it sinks. Where both are round, each is short
    by the same part of its radius. ``na`` and ``nb``: the normal in the axes of either body.
    """
    round_a, round_b = curvature(bodies, kinds, a, found, na), curvature(bodies, kinds, b, found, nb)
    if round_a == round_b:
        return 0.0
    deep = 0.0
    for k in range(found):
        deep = max(deep, -contacts[k, SEPARATION])
    return 0.5 * deep * (round_a - round_b) / (round_a + round_b)


@jit
def curvature(bodies, kinds, i, found, n):
    """Of the side on which body i may roll, 1/m; 0 of what has none, and of a cylinder that stands on its rim.

    An ellipsoid has two, and rolls with a mixture of them that depends on where to. Against what is flat it does not
    matter which; against what is round their geometric mean is never wrong by more than the root of their ratio. It is
    the root of Gauss' curvature, h^4 / (a b c)^2 where it reaches h far along its normal n.
    """
    if not is_round(kinds, i, found):
        return 0.0
    if kinds[i, SHAPE] == ELLIPSOID:
        s = vec3(bodies, i, SIZE)
        x, y, z = s.x * n.x, s.y * n.y, s.z * n.z
        return (x * x + y * y + z * z) / (s.x * s.y * s.z)
    return 1.0 / bodies[i, SIZE]


@jit
def is_round(kinds, i, points):
    """Whether body i rolls on a smooth side where it has so many points of contact."""
    shape = kinds[i, SHAPE]
    return shape == SPHERE or shape == CAPSULE or shape == ELLIPSOID or (shape == CYLINDER and points == 2)


@jit
def rise_of(contacts, found, center, n, spread2):
    """By how much points lie higher along n where the bodies are further apart there: half, or minus half, by whose
    side is the even one; 0 where both lie flat on each other."""
    mean = 0.0
    for k in range(found):
        mean += contacts[k, SEPARATION] / found
    mixed, wide = 0.0, 0.0
    for k in range(found):
        apart = contacts[k, SEPARATION] - mean
        mixed += apart * dot(vec3(contacts, k, POINT) - center, n)
        wide += apart * apart
    return mixed / wide if wide > found * FLAT * FLAT * spread2 else 0.0


@jit
def velocity_before(bodies, kinds, i):
    """Velocities of body i as the step begins; a kinematic one takes up those it has been told in the course of it."""
    if kinds[i, MOBILITY] == KINEMATIC:
        return vec3(bodies, i, V_START), vec3(bodies, i, W_START)
    return vec3(bodies, i, V), vec3(bodies, i, W)


@jit
def set_coefficients(kinds, table, a, b, manifolds, meta, row):
    """The pair's row of the table."""
    i, j = kinds[a, MATERIAL], kinds[b, MATERIAL]
    manifolds[row, s.MU_S], manifolds[row, s.MU_D] = table[i, j, STATIC_MU], table[i, j, DYNAMIC_MU]
    meta[row, s.RESTITUTION] = table[i, j, RESTITUTION]
    manifolds[row, s.ROLLING], manifolds[row, s.TORSIONAL] = table[i, j, ROLLING], table[i, j, TORSIONAL]


@jit
def belt_velocity(bodies, pose, a, b):
    """Velocity of the surface of a relative to its body, less that of b, world, m/s."""
    return (
        mat33(pose, a + 1, s.POSE_ROTATION) @ vec3(bodies, a, SURFACE)
        - mat33(pose, b + 1, s.POSE_ROTATION) @ vec3(bodies, b, SURFACE)
    )  # fmt: skip


@jit
def refresh_manifold(bodies, kinds, a, b, manifolds, meta, reports, pose, aux, row, dt):
    """What changes from step to step: the arms to the anchor, how far b is from where it was, and belts.

    One or two points may roll along both bodies. Their arms are those of the middle of the step, if the points go on as
    in the last one: forces at the places of its start would make what rocks swing up, by a part omega^2 dt / 4 a second
    (with the velocity of the mean, [x, v] goes over into [x, v] with the determinant 1 + omega^2 dt^2 / 2; from the
    middle it is 1).

    What is in contact at the time t of the step, though, has the velocity q (t - dt / 2) more than what is so in the
    middle, q = w_a x r_a' - w_b x r_b'. If contact stopped what is at these arms all through the step, a body that
    rolls on a side that is not round would come to each next place with q dt and lose that as in an impact, q . K^-1 q
    dt / 2 of its energy a second; enough to turn a tippe top over that should go on rolling upright.
    """
    ra = mat33(pose, a + 1, s.POSE_ROTATION) @ vec3(meta, row, s.ANCHOR_A)
    rb = mat33(pose, b + 1, s.POSE_ROTATION) @ vec3(meta, row, s.ANCHOR_B)
    odd = pose[a + 1, s.POSE_ODD] + pose[b + 1, s.POSE_ODD]
    if odd >= s.TUMBLES:
        forget_impulses(manifolds, row)
    up, half = load_along_normal(manifolds, meta, pose, a, row)
    # the surfaces where they will touch, and where the load is
    arm_a, arm_b = ra - half, rb + half
    put_vec3(manifolds, row, s.SHIFT, (vec3(pose, b + 1, s.POSE_X) + rb) - (vec3(pose, a + 1, s.POSE_X) + ra))
    if meta[row, s.POINTS] > 2.0:
        put_vec3(manifolds, row, s.ARM_A, up + arm_a)
        put_vec3(manifolds, row, s.ARM_B, up + arm_b)
        put_drift(bodies, kinds, a, b, manifolds, row, pose, Vec3(0.0, 0.0, 0.0))
        if odd > 0.0:
            put_vec3(manifolds, row, s.BELT, belt_velocity(bodies, pose, a, b))
        else:
            limit = limit_of(pose, kinds, a, b)
            keep_place(manifolds, reports, row, mat33(pose, a + 1, s.POSE_ROTATION), CREEP * limit, dt)
        return
    moved = pose[a + 1, s.POSE_MOTION] + pose[b + 1, s.POSE_MOTION]
    if moved != meta[row, s.PLACED]:  # a step may be begun twice
        fresh = meta[row, s.PLACED] == NOWHERE_YET
        meta[row, s.PLACED] = moved
        ahead_a, ahead_b = go_on(reports, row, s.HERE_A, arm_a, fresh), go_on(reports, row, s.HERE_B, arm_b, fresh)
        # where a turntable is in the middle is told by how its velocity drifts
        ahead_a = ahead_a * (0.0 if kinds[a, MOBILITY] == KINEMATIC else 1.0)
        ahead_b = ahead_b * (0.0 if kinds[b, MOBILITY] == KINEMATIC else 1.0)
        put_vec3(manifolds, row, s.ARM_A, up + arm_a + ahead_a)
        put_vec3(manifolds, row, s.ARM_B, up + arm_b + ahead_b)
        early = Vec3(0.0, 0.0, 0.0)
        if is_round(kinds, a, meta[row, s.POINTS]) or is_round(kinds, b, meta[row, s.POINTS]):
            # and its places wander from as far before the middle to as far behind it
            early = cross(vec3(aux, b + 1, s.AUX_START_W), ahead_b) - cross(vec3(aux, a + 1, s.AUX_START_W), ahead_a)
        put_drift(bodies, kinds, a, b, manifolds, row, pose, early * (-2.0 / dt))
        put_vec3(manifolds, row, s.BELT, early)
        if odd > 0.0:
            n = mat33(pose, a + 1, s.POSE_ROTATION) @ vec3(manifolds, row, s.NORMAL_A)
            belt = belt_velocity(bodies, pose, a, b)
            put_vec3(manifolds, row, s.BELT, early + belt - n * dot(n, belt))


@jit
def forget_impulses(manifolds, row):
    """Begin a step without those of the last one: at other arms they would throw a needle that tumbles."""
    for k in range(4):
        manifolds[row, s.LOAD + k] = 0.0
    put_vec3(manifolds, row, s.PULL, Vec3(0.0, 0.0, 0.0))
    manifolds[row, s.SPIN] = manifolds[row, s.ROLL] = manifolds[row, s.ROLL + 1] = 0.0


@jit
def put_drift(bodies, kinds, a, b, manifolds, row, pose, wander):
    """Enter how fast the velocity of what is in contact changes besides that at the arms: because its place wanders
    over the bodies, and because turntables carry their surfaces round; world, m/s^2."""
    if kinds[a, MOBILITY] == KINEMATIC or kinds[b, MOBILITY] == KINEMATIC:
        wander = wander + carried_round(bodies, kinds, a, b) - carried_round(bodies, kinds, b, a)
    if dot(wander, wander) > 0.0:
        Ra = mat33(pose, a + 1, s.POSE_ROTATION)
        n, u = Ra @ vec3(manifolds, row, s.NORMAL_A), Ra @ vec3(manifolds, row, s.TANGENT_A)
        manifolds[row, s.DRIFT_U], manifolds[row, s.DRIFT_V] = dot(wander, u), dot(wander, cross(n, u))
    else:
        manifolds[row, s.DRIFT_U] = manifolds[row, s.DRIFT_V] = 0.0


@jit
def load_along_normal(manifolds, meta, pose, a, row):
    """From the anchor along the normal to where the load is, and half of what gap there still is, world, m.

    The anchor is half way between the bodies, and half way to points that are only near. But a card that leans on its
    edge has friction at the edge; and bodies that will have met by then rub at their own surfaces, not half way over
    the gap that is still between them when the step begins.
    """
    points = int(meta[row, s.POINTS])
    load, loaded, mean, nearest = 0.0, 0.0, 0.0, manifolds[row, s.GAP] * 1.0
    for k in range(points):
        load += manifolds[row, s.LOAD + k]
        loaded += manifolds[row, s.LOAD + k] * manifolds[row, s.GAP + k]
        mean += manifolds[row, s.GAP + k] / points
        nearest = min(nearest, manifolds[row, s.GAP + k] * 1.0)
    rise = meta[row, s.RISE] * (loaded / load - mean) if load > 0.0 else 0.0
    half = 0.5 * max(nearest, 0.0)
    if rise == 0.0 and half < TOUCHED:
        return Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)
    n = mat33(pose, a + 1, s.POSE_ROTATION) @ vec3(manifolds, row, s.NORMAL_A)
    return n * rise, n * half


@jit
def keep_place(manifolds, reports, row, Ra, creep, dt):
    """Pull a face that sticks back to where it took hold: as a velocity of the surface of a, by a part a step.

    What rounding makes creep, 1e-6 m in ten minutes, so stays where it is for hours. Friction has to give that pull as
    any other, so it lets go at the same force. The place is kept in the axes of a; what is farther than ``creep`` (m)
    from it takes hold anew.
    """
    shift = vec3(manifolds, row, s.SHIFT)
    back = Vec3(0.0, 0.0, 0.0)
    # a face that rocks turns about its edge, and its middle goes aside
    lies = manifolds[row, s.STATE] == s.STUCK
    for k in range(int(manifolds[row, s.COUNT])):
        lies = lies and manifolds[row, s.LOAD + k] > 0.0
    if not lies:
        reports[row, s.HELD] = 0.0
    else:
        off = shift - Ra @ vec3(reports, row, s.PLACE)
        n = Ra @ vec3(manifolds, row, s.NORMAL_A)
        off = off - n * dot(n, off)
        if reports[row, s.HELD] == 0.0 or length(off) > creep:
            reports[row, s.HELD] = 1.0
            put_vec3(reports, row, s.PLACE, transpose(Ra) @ shift)
            # the place as it was rounded, for a step may be begun twice
            off = shift - Ra @ vec3(reports, row, s.PLACE)
            off = off - n * dot(n, off)
        back = off * (-PULL_BACK / dt)
    put_vec3(manifolds, row, s.BELT, back)


@jit
def go_on(reports, row, column, arm, fresh):
    """Half of what the arm has changed by since the step before, world, m; keeps it for the next step."""
    old = vec3(reports, row, column)
    put_vec3(reports, row, column, arm)
    # in the precision of what was kept: at rest it is exactly zero
    way = vec3(reports, row, column) - old
    return way * (0.5 if not fresh and dot(way, way) < LEAP * LEAP * dot(arm, arm) else 0.0)


@jit
def carried_round(bodies, kinds, i, other):
    """How fast the velocity of the surface of kinematic body i changes under a body that moves over it: w x v."""
    if kinds[i, MOBILITY] != KINEMATIC:
        return Vec3(0.0, 0.0, 0.0)
    w = vec3(bodies, i, W)
    return cross(w, vec3(bodies, other, V))


@jit
def tilt_of(manifolds, row, Ra, Rb):
    """Normal and tangents of a manifold, and by how much b has turned against a since it was made, world, rad."""
    n, u = Ra @ wide(vec3(manifolds, row, s.NORMAL_A)), Ra @ wide(vec3(manifolds, row, s.TANGENT_A))
    nb, ub = Rb @ wide(vec3(manifolds, row, s.NORMAL_B)), Rb @ wide(vec3(manifolds, row, s.TANGENT_B))
    v = cross(n, u)
    return n, u, v, (cross(n, nb) + cross(u, ub) + cross(v, cross(nb, ub))) * 0.5


@jit
def gap_at(manifolds, row, j, shift, tilt_u, tilt_v):
    """Separation of point j, m, where b has moved by ``shift`` along the normal and turned by these angles."""
    x, y = manifolds[row, s.PLACE_U + j], manifolds[row, s.PLACE_V + j]
    return manifolds[row, s.GAP + j] + shift + tilt_u * y - tilt_v * x
