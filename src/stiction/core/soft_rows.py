"""The arrays of the soft solver: what lives as long as a pair of bodies does, and what a step makes of it.

Three kinds of rows, in the solver's own precision (float32 unless double is asked for):

manifolds   80 numbers a pair: frame, points, impulses, friction state. They live as long as the pair.
blocks      eight manifolds side by side, made anew each step from the manifolds, in the order of the colours: number k
            of the eight is a vector, so a block is FIELDS vectors of eight lanes, or POINT_FIELDS if all are points.
rows        how a body's velocities and place differ from those of the start of the step and of going on with them, one
            cache line a body, row 0 for nobody.

Positions stay in float64: a manifold keeps its anchors in the two bodies' own frames in float64, and only their
difference, a few millimetres, goes into the lanes; and a body keeps its velocities in float64, to which a step adds
what it has changed them by. So float32 costs nothing a kilometre from the origin, nor at a thousand metres a second.
"""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

import numpy as np

from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.memory import zeros


def _starts(*widths: int) -> list[int]:
    return list(accumulate(widths, initial=0))


# --- manifolds: (m, MANIFOLD_WIDTH); in groups of eight, as they are gathered -----------------------------------------

# fmt: off
(
    NORMAL_A, TANGENT_A, MU_S, MU_D,  # normal (a to b) and first tangent in the axes of a; the pair's coefficients
    NORMAL_B, TANGENT_B, STATE, OVER,  # the same directions in the axes of b; STUCK or SLIDING; substeps over the limit
    GAP, LOAD,  # 4 + 4: separations when the manifold was made, m; normal forces of the last substep, N
    PLACE_U, PLACE_V,  # 4 + 4: where the points are in the plane, from the anchor, m; for missing ones, faces.py
    PULL, SPIN, TORSIONAL, ROLLING, DRIFT_U, KIND,  # friction (world, N) and torque about n at the anchor, N m
    EVEN, ARM, LOP_U, LOP_V, COUNT, FRESH,  # 3 + 3, of an even load (friction/pressure.py); how many points
    SHIFT, ARM_A, ROLL,  # of b against a since the manifold was made; anchor from a's centre of mass, m; 2, torque, N m
    ARM_B, BELT, DRIFT_V, LEFT,  # the same from b, both in the middle of the step; velocity of what is in contact of a
    # against b besides that at the arms, as the step begins, world, m/s; DRIFT_U, DRIFT_V: how fast it changes, m/s^2
    MANIFOLD_WIDTH,
) = _starts(3, 3, 1, 1, 3, 3, 1, 1, 4, 4, 4, 4, 3, 1, 1, 1, 1, 1, 3, 1, 1, 1, 1, 1, 3, 3, 2, 3, 3, 1, 1)
# fmt: on

CORNER_U, CORNER_V, CORNERS_WIDTH = 0, 8, 16
"""Columns of the corners of faces that have more than four, (m, CORNERS_WIDTH), m: few do, so they lie apart."""

RADII_A, RADII_B = 0, 4
"""Columns in their place of manifolds of one or two points, how the bodies are curved there: 4 + 4, a direction in the
plane (cosine and sine from the first tangent), the radius of curvature along it and across it, m."""

FOUR, EIGHT, ELLIPSE = 0.0, 1.0, 2.0
"""Kinds of a face: the places of the points are its corners; it has its own; it is an ellipse."""

STUCK, SLIDING = 0.0, 1.0
"""States of a manifold: its static or its dynamic coefficient holds."""

(TOTAL_LOAD, TOTAL_PULL, TOTAL_TWIST, LIFT, HERE_A, HERE_B, REPORT_WIDTH) = _starts(4, 3, 1, 4, 3, 3)
"""Columns of the reports, (m, REPORT_WIDTH): normal impulses of the whole step a point, friction impulse (world) and
torque impulse about the normal at the anchor; by how much the points are held above where they will have sunk to, m;
where the anchor of one or two points was at the start of the step, from the centres of mass, world, m. Of a face the
same columns hold where b was against a when it took hold, in the axes of a, m, and whether it holds."""
PLACE, HELD = HERE_A, HERE_B

OLD, NEW, QUIET = 0.0, 1.0, 2.0
"""What FRESH says of a manifold: made before this step; in it; in it, and its bodies hardly move against each other."""

(MADE, LEAD, POINTS, FEATURES, ANCHOR_A, ANCHOR_B, PLACED, SIZE2, RESTITUTION, RISE, META_WIDTH) = _starts(
    1, 1, 1, 4, 3, 3, 1, 1, 1, 1
)
"""Columns of what a manifold keeps in float64: how far both bodies had moved when it was made, m; how far they
may move against each other until the narrow phase has to be run, m; how many points and their features (whole numbers);
the anchor in the axes of a and of b, from their centres of mass, m; how far both bodies had moved when the arms were
computed last, m; mean square distance of the points from the anchor, m^2;
the pair's coefficient of restitution; by how much points lie higher along the normal where they are further apart."""

# --- blocks: (rows of all blocks, 8) ----------------------------------------------------------------------------------

(
    # what points have too (solve.points), who use no more than the first of four numbers, and two of three
    B_NORMAL, B_TANGENT,  # frame n, u (and v = n x u), world
    B_ARM_A, B_ARM_B,  # anchor from the centres of mass, in the frame
    B_MASS_A, B_MASS_B,  # inverse masses, times the block's mass
    B_INERTIA_A, B_INERTIA_B,  # 6 + 6, inverse inertia in the frame, upper triangle, times the block's mass
    B_KVV,  # 6, the manifold's matrix: velocity by force, in the frame
    B_BETA,  # push-out rate, 1/s
    B_MU_S, B_MU_D,
    B_RIGID,  # 1 / K_nn at the centre of pressure: the load that would stop the closing that is left
    B_LEFT,  # closing speed that the soft contact left at the centre of pressure, m/s
    B_BELT,  # 3, slip of the start of the step and that of surfaces by themselves: u, v, T_m times spin
    B_DRIFT,  # 2, how fast that changes: u, v, m/s^2
    B_PULL,  # 3, friction: impulse along u and v, torque impulse about n at the centre of pressure over T_m
    B_STATE, B_OVER,
    B_TOTAL_PULL,  # 3, sums over the step
    B_SLIP,  # 3, slip at the end of the last substep
    B_WORK,  # what friction has taken in this step, J
    B_FRESH,  # NEW or QUIET for a manifold that is new in this step
    B_SCALE,  # the block's mass, kg: impulses are in units of it times m/s, so numbers are of order one at any scale
    B_MISS,  # by how much the manifold misses its laws, m/s (solve.exact, cold passes); else whether a pass struck it
    B_START,  # 3, a against b at the place of contact at the start of the step: closing speed, spin about u and v
    B_WANDER,  # how fast that closing speed changes because the place wanders away from the arms, m/s^2
    B_BURIED,  # by how much the points are deeper than their separations say (solve.depth), m
    B_GAP,  # 4, separations at the start of the step
    B_LOAD,  # 4, normal impulses
    B_TOTAL_LOAD,  # 4, sums over the step
    B_LIFT,  # 4, how much of the separations is not there, m
    B_SOFT,  # 4, compliance of the normals
    B_INVERSE,  # 10, inverse of the softened matrix of the normals, upper triangle
    B_INVERSE_STUCK,  # 10, the same where friction answers by sticking
    B_FRICTION_INVERSE,  # 6, the inverse of D K_P D; of points 3
    # and what only faces have
    B_FRICTION,  # 6, D K_P D
    B_KWV, B_KWW,  # 9 + 6, the manifold's matrix: spin by force and torque
    B_U, B_V,  # 4 + 4, places of the points
    B_CENTER,  # 2, centre of pressure in the plane
    B_TORQUE,  # T_m, torque of pure spinning per mu N, m
    B_SURFACE,  # 8, coefficients of the limit surface
    B_TURN,  # 2, cosine and sine of the angle of the frame in that of the manifold
    B_ROLLING, B_ROLL, B_ROLLED,  # length of rolling resistance, m; its torque impulse about u and v, 2; its work, J
    B_SCALED, B_ALPHA, B_ATTRACT,  # 4 + 1 + 4, of friction laws (friction.laws): force by scaled force; slip over mu;
    # impulse a substep with which the points hold on
    FIELDS,
) = _starts(
    3, 3, 3, 3, 1, 1, 6, 6, 6, 1, 1, 1, 1, 1, 3, 2, 3, 1, 1, 3, 3, 1, 1, 1, 1, 3, 1, 1, 4, 4, 4, 4, 4, 10, 10, 6,
    6, 9, 6, 4, 4, 2, 1, 8, 2, 1, 2, 1, 4, 1, 4,
)  # fmt: skip

POINT_FIELDS = B_FRICTION
"""A block of points ends where begins what only faces have."""

MEMBERS = 5
"""Rows of members a block, each as many behind the other as there are blocks: of bodies a and b, of the manifold, the
world, and in the first two lanes the sort, and the first row of the block (``colouring``)."""

# --- rows of bodies ---------------------------------------------------------------------------------------------------

ROW_V, ROW_W, ROW_D, ROW_TURN, ROW_WIDTH = 0, 4, 8, 12, 16
"""Columns of a body's row: by how much velocity and spin differ from those at the start of the step, and displacement
and rotation vector from what these would have made."""

AUX_START_V, AUX_START_W, AUX_ROTATION, AUX_MASS, AUX_INERTIA, AUX_WORK = 0, 4, 8, 17, 18, 24
AUX_LEAN, AUX_HEIGHT, AUX_STANDS, AUX_HELD, AUX_STRUCK, AUX_OLD_V, AUX_OLD_W = 25, 28, 29, 30, 31, 32, 36
AUX_FREE, AUX_GIVEN, AUX_OWES, AUX_LIFTED, AUX_PULLED, AUX_GAIN, AUX_WIDTH = 40, 43, 44, 45, 46, 47, 48
AUX_HAS = AUX_STRUCK
"""Columns beside it, three cache lines: velocities at the start of the step; rotation matrix (9), inverse mass, and the
upper triangle of the inverse inertia in world axes; what friction and rolling have taken at its contacts in this step,
J; its lean, its height against gravity, m, whether it stands, and whether it will (``leaning``); what the row had as
velocities at the start of the substep; by how much its spin would change in the step if nothing touched it; what
those that touch it gave it in the step, if it tumbles, J; what it owes others that tumble, or its island, for what
contact has pushed, J; how far it was moved out of fixed bodies, m; work of what pulls at it besides contact, J; what
its island has gained, J, and has as kinetic energy (``gains``), once nobody asks any more who was struck."""

POSE_X, POSE_ROTATION, POSE_MOTION, POSE_REACH, POSE_MARGIN, POSE_ODD, POSE_WIDTH = 0, 3, 12, 13, 14, 15, 16
"""Columns of a body's pose, (n + 1, POSE_WIDTH) float64, two cache lines: centre of mass, m; rotation matrix; how far
it had moved when the step began, m (``state.MOTION``); its farthest point from the origin of its frame, m; how far it
can come towards another body in this step, m; what is odd about it."""

HAS_BELT, TUMBLES = 1.0, 4.0
"""What may be odd about a body, to be added for two: its surface moves by itself; it turns so far in a step that where
and how it is touched has nothing to do with where it was."""


class Soft(NamedTuple):
    """Arrays of the soft solver with room for n bodies, m pairs that touch and as many manifolds in blocks."""

    manifolds: np.ndarray  # (m + 1, MANIFOLD_WIDTH), row 0 is nobody's: what pads a block
    meta: np.ndarray  # (m + 1, META_WIDTH) float64
    reports: np.ndarray  # (m + 1, REPORT_WIDTH)
    blocks: np.ndarray  # (rows of all blocks, 8)
    members: np.ndarray  # (MEMBERS x blocks, 8) int32: rows of bodies a and b, and of the manifold; the world; the kind
    rows: np.ndarray  # (n + 1, ROW_WIDTH)
    aux: np.ndarray  # (n + 1, AUX_WIDTH)
    pose: np.ndarray  # (n + 1, POSE_WIDTH) float64
    corners: np.ndarray  # (m + 1, CORNERS_WIDTH)
    grain: np.ndarray  # (n + 1, 3) float64, direction of the surface in the shape's axes, or zero


@jit
def members_from(soft, first):
    """The same arrays, whose blocks have the members that begin with those of block ``first``."""
    return Soft(
        soft.manifolds, soft.meta, soft.reports, soft.blocks, soft.members[first * MEMBERS :], soft.rows, soft.aux,
        soft.pose, soft.corners, soft.grain,
    )  # fmt: skip


def make_soft(n: int, m: int, dtype: type = np.float32, blocks: int | None = None, rows: int | None = None) -> Soft:
    """Zeroed arrays. Unless it is said how many blocks there are, room for all manifolds: each colour may leave a
    block that is partly filled; and unless it is said how many rows these have, all may be faces."""
    if blocks is None:
        blocks = m // LANES + 128 + m // 16
    return Soft(
        manifolds=zeros((m + 1, MANIFOLD_WIDTH), dtype),
        meta=zeros((m + 1, META_WIDTH)),
        reports=zeros((m + 1, REPORT_WIDTH), dtype),
        blocks=zeros((blocks * FIELDS if rows is None else rows, LANES), dtype),
        members=zeros((MEMBERS * blocks, LANES), np.int32),
        rows=zeros((n + 1, ROW_WIDTH), dtype),
        aux=zeros((n + 1, AUX_WIDTH), dtype),
        pose=zeros((n + 1, POSE_WIDTH)),
        corners=zeros((m + 1, CORNERS_WIDTH), dtype),
        grain=zeros((n + 1, 3)),
    )
