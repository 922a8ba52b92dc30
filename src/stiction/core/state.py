"""The arrays of a world: one row a body, one row a contact point.

A row holds all numbers of its body or contact side by side, so that a contact reads the few cache lines it needs, and a
kernel gets two matrices instead of forty arrays (a NamedTuple of forty arrays costs 7 us a call and minutes to
compile). The names below are the columns in which a quantity starts; ``vec3(bodies, i, V)`` is the velocity of body i.
Nothing here knows of names, materials' words or Python objects, so many worlds can later live in the same arrays.
"""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

import numpy as np

from stiction.core.memory import zeros

SPHERE, BOX, PLANE, CAPSULE, CYLINDER, HULL, ELLIPSOID = range(7)
"""Codes of the shapes."""

STATIC, KINEMATIC, DYNAMIC = 0, 1, 2
"""Mobility: never moves; moves as it is told; moves as forces tell it."""

STATIC_MU, DYNAMIC_MU, RESTITUTION, ROLLING, TORSIONAL = range(5)
"""Columns of the pair table, and from MU on of a contact."""
TANGENTIAL = 5
"""Tangential restitution: a column that a table has where some pair has one, or any of the following."""
STATIC_ACROSS, DYNAMIC_ACROSS, ADHESION, ADHESION_PRESSURE, LAW, LAW_FIRST = range(6, 12)
"""Columns that a table has where some pair needs them: coefficients across the grain over those along it; force (N) and
pressure (Pa) with which a contact holds on; code and parameters of the law of sliding."""


def _starts(*widths: int) -> list[int]:
    return list(accumulate(widths, initial=0))


# --- bodies: (n, BODY_WIDTH) float64; vectors in world axes unless said otherwise -------------------------------------

# What is read together lies together.
(
    POSITION,  # 3, origin of the shape's frame, m
    ORIENTATION,  # 4, unit quaternion w, x, y, z
    V,  # 3, velocity of the centre of mass, m/s
    W,  # 3, angular velocity, rad/s
    CENTER,  # 3, centre of mass in the shape's frame, m
    SIZE,  # 4, sphere: radius; plane: normal and offset, in the shape's frame; else half lengths of its box; hull
    FORCE,  # 3, at the centre of mass, for one step, N
    TORQUE,  # 3, for one step, N m
    INVERSE_MASS,  # 1/kg, 0 unless dynamic
    REACH,  # farthest point of the shape from the origin of its frame, m
    BOUNDS,  # 6, box around the shape: lower corner, upper corner, m; once pairs are found, PUSH and PUSH_TURN
    INERTIA,  # 9, about the centre of mass, in the shape's axes, kg m^2
    INVERSE_INERTIA,  # 9, the same axes, 0 unless dynamic
    MASS,  # kg
    SURFACE,  # 3, velocity of the surface relative to the body, in the shape's axes, m/s
    REST,  # s, for how long the body has been at rest
    FRICTION_WORK,  # lost to friction and rolling resistance at this body's contacts so far, J
    MOTION,  # how far any of its points can have gone since the world began, m: displacement + reach x rotation
    LEAN,  # 3, what the body has turned because what it stands on gives way, world, rad (core/leaning.py)
    STANDS,  # 1 if it stands, else 0
    LAST,  # 14, last finite position, orientation, v, w and friction work
    X,  # 3, centre of mass, m
    WORLD_INERTIA,  # 9, inverse inertia in world axes, 0 unless dynamic
    V_START,  # 3, velocities after impacts, before forces and resting contact
    W_START,  # 3
    MEAN,  # whether the body moves with the mean of its old and new velocity (core.integrate)
    BODY_WIDTH,
) = _starts(3, 4, 3, 3, 3, 4, 3, 3, 1, 1, 6, 9, 9, 1, 3, 1, 1, 1, 3, 1, 14, 3, 9, 3, 3, 1)
PUSH, PUSH_TURN = BOUNDS, BOUNDS + 3  # way out of penetration, m and rad
SHORT_WIDTH = X
"""So many columns do for the soft solver where no body is kinematic; impacts work on a copy that has them all."""

SHAPE, MOBILITY, MATERIAL, LAYER, MASK, SENSOR, ASLEEP, ISLAND, KINDS_WIDTH = range(9)
"""Columns of the bodies' integers, (n, KINDS_WIDTH) int64. MATERIAL is a row of the pair table; two bodies meet if each
one's LAYER bits are among the other's MASK bits; a SENSOR overlaps and pushes nothing; ASLEEP bodies take no part;
ISLAND is the lowest body of those that fell asleep together."""

# --- contacts: (m, CONTACT_WIDTH) float64; "contact coordinates" have the normal first --------------------------------

(
    POINT,  # 3, world, half way between the surfaces, m
    NORMAL,  # 3, world, from a to b
    SEPARATION,  # m, negative when the shapes overlap
    K_ROW,  # 6, upper triangle of the contact matrix, by rows, 1/kg
    AIM,  # 3, collision velocity that may remain, contact coordinates, m/s
    START,  # 3, collision velocity before the impulses, contact coordinates, m/s
    IMPULSE,  # 3, on b, contact coordinates, N s
    TWIST,  # 3, rolling and torsional angular impulse on b, contact coordinates, N m s
    TOTAL,  # normal impulse of the whole step, impacts included, N s
    TOTAL_FRICTION,  # 3, friction impulse of the whole step on b, world, N s
    MU,  # 6, the pair's row of the table, tangential restitution included
    CONTACT_WIDTH,
) = _starts(3, 3, 1, 6, 3, 3, 3, 3, 1, 3, 6)

BODY_A, BODY_B, FEATURE, STATUS, TAGS_WIDTH = range(5)
"""Columns of the contacts' integers, (m, TAGS_WIDTH) int64: the bodies, lower one first; the feature, the same for the
same pair of corners, edges or faces from step to step; and the solver's status."""


ACTIVE, KINETIC, SATURATED = 1, 2, 4
"""Bits of a contact's status: takes part in what is being resolved; has let go, so mu_d holds; its impulse lies on the
friction cone."""
SLIDING = KINETIC | SATURATED
"""Status of a contact that slides."""


class Lists(NamedTuple):
    """Pairs, order and adjacency, rebuilt every step."""

    order: np.ndarray  # (n,) int64 bodies by lower x, kept from step to step
    pairs: np.ndarray  # (p, 2) int64 bodies whose bounds overlap
    first: np.ndarray  # (n + 1,) int64 body i's contacts are touching[first[i]:first[i + 1]]
    touching: np.ndarray  # (2m,) int64
    tree: np.ndarray  # (2 x the power of two that holds m,) float64 tournament tree of the contacts' errors
    group: np.ndarray  # (n,) int64 union-find
    gain: np.ndarray  # (n, 2) energy change of a group, and its scale
    ledger: np.ndarray  # (LEDGER_WIDTH,) float64 the ledger at the last finite state
    report: np.ndarray  # (3, REPORT_WIDTH) float64 the report then
    points: np.ndarray  # (SCRATCH, 5) candidates of one manifold: point, separation, feature


FRICTION, ROLLING_LOSS, IMPACTS, WORK, NUMERICAL, EDITS, INITIAL, MECHANICAL, LEDGER_WIDTH = range(9)
"""Entries of the ledger, (LEDGER_WIDTH,) float64, J. Sums since the world began: lost to friction, to rolling
resistance, in impacts; put in by forces, drives and belts; made by the integrator; put in by changes from outside. Then
the mechanical energy at the beginning (nan before the first step), and at the end of the last step."""

PENETRATION, IMPACT, RESTING = 0, 1, 2
"""Stages of contact, rows of the report."""
VISITS, LIMITS, WORST, REPORT_WIDTH = range(4)
"""Columns of the report, (3, REPORT_WIDTH) float64: contacts resolved, steps in which the limit was hit, and the
largest error that this left (m for penetrations, m/s for the others)."""


class Settings(NamedTuple):
    """Constants of a call."""

    gravity_x: float
    gravity_y: float
    gravity_z: float
    dt: float
    iterations: int  # visits a contact and stage, at most; passes a substep of the exact solver
    threshold: float  # m/s, approach speeds below it are resting contact
    literal: bool
    substeps: int  # of the soft solver
    sleeping: bool  # whether the soft solver lets bodies sleep
    tolerance: float  # m/s, of the exact solver


FACE, LARGEST_FACE = 144, 16
"""Row of the scratch whose first number says how many corners of a face stand in the rows after it; at most so many."""
RADII = FACE + 1 + LARGEST_FACE
"""The row that says how the first body is curved where the pair touches with one or two points, and the next one, the
second: a direction, the radius along it, or less than 0 if nothing is known, and across it."""
LEAD = RADII + 2
"""The row whose first number says how far that is from where the bodies have other features, m."""
SCRATCH = LEAD + 1
"""Rows that the narrow phase needs to work in: two buffers of 64 points, spare, a face, and what is known of one or two
points."""


def make_bodies(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Zeroed rows for n bodies, each at the origin and upright: their numbers and their integers."""
    bodies = zeros((n, BODY_WIDTH))
    bodies[:, ORIENTATION] = 1.0
    return bodies, np.zeros((n, KINDS_WIDTH), np.int64)


def make_contacts(m: int) -> tuple[np.ndarray, np.ndarray]:
    """Room for m contact points: their numbers and their integers."""
    return np.zeros((m, CONTACT_WIDTH)), np.zeros((m, TAGS_WIDTH), np.int64)


def make_lists(n: int, m: int, p: int) -> Lists:
    """Room for n bodies, m contact points and p pairs."""
    return Lists(
        order=np.arange(n, dtype=np.int64),
        pairs=np.zeros((p, 2), np.int64),
        first=np.zeros(n + 1, np.int64),
        touching=np.zeros(2 * m, np.int64),
        tree=np.zeros(2 << max(m - 1, 0).bit_length()),
        group=np.zeros(n, np.int64),
        gain=np.zeros((n, 2)),
        ledger=np.zeros(LEDGER_WIDTH),
        report=np.zeros((3, REPORT_WIDTH)),
        points=np.zeros((SCRATCH, 5)),
    )
