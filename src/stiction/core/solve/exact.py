"""Signorini's condition and Coulomb's law to a tolerance: nonsmooth Gauss-Seidel over whole manifolds.

Contacts are rigid. In each substep the passes of ``solve.soft`` go over all blocks again and again: each solves the
normals of a manifold as one small complementarity problem and the friction of its patch on the limit surface, given
what all others do (Moreau, Jean; for point contacts see Acary, Brémond, Huber, "On solving contact problems with
Coulomb friction: formulations and numerical comparisons", 2018). Where four points of a face leave the normals
undetermined, a compliance in the *inverse* alone makes a proximal-point step of it, which changes nothing where it
comes to rest.

They end when the *miss* is below the tolerance: the largest speed by which a manifold's velocities differ from those
of its own law, given its impulses (:func:`miss_of_block`). That is the natural map of the problem in the metric of the
manifold's own matrix: zero if and only if it is solved, and in m/s, so that it means the same for a pebble and a tower.
(The De Saxcé form has no counterpart for limit surfaces that are no cones over a disc.)

Static and dynamic: converged with the coefficient of each manifold's state, then those that stick at the static limit
let go, those that slide and could hold stick, and the problem is converged again; a manifold that let go stays so for
the rest of the substep.

Costs: bodies 1, manifolds 1 a pass; a check of the miss as much as a pass, every fifth.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.colouring import first_row, is_point_block
from stiction.core.friction.laws import scaled_slip
from stiction.core.friction.patch import choose3, level, slide, times
from stiction.core.jit import entry, jit
from stiction.core.lanes import LANES, all_of, any_of, greatest, least, load, select, size_of, sqrt, store
from stiction.core.solve.blocks import frame_of, get3, get4, get6, prepare_block, put3, surface_at, twist_now
from stiction.core.solve.idle import belt_now
from stiction.core.solve.normals import Four
from stiction.core.solve.points import miss_of_points, prepare_points
from stiction.core.solve.soft import allowed, gaps_now, softness, solve_block, unit_of
from stiction.core.vec import Vec3, dot, transpose

COMPLIANCE = 0.05
"""Of a point, in the inverse, as a part of its own 1/m. With a small one four points that do not lie in a plane to the
last digit fling the load back and forth; with this one a tower of ten crooked cubes comes to rest."""
PUSH_OUT = 0.02
"""Part of a penetration that is pushed out in a substep; rigid contacts make none but by the turning of bodies. What is
pushed keeps its speed, so a large part would keep towers rocking."""
CHECK = 5
"""Passes from one look at the miss to the next."""
ROUNDS = 6
"""Times that states may change in a substep."""
OVER = 1e-6
"""Beyond the limit surface by this much (of Phi) is beyond it."""

PASSES, SOLVES, HITS, WORST, LAST_MISS, LOGGED, LOG, TALLY = 0, 1, 2, 3, 4, 5, 6, 262
"""Entries of the tally: passes and substeps so far; substeps in which the limit of passes was hit, and the largest
miss, m/s, that this left; the last miss; and the misses of the last substep, LOGGED of them from LOG on."""


@jit
def exact_of(wanted, settings, scratch):
    """What :func:`iterate` needs: tolerance, passes a substep at most, and the tally; None with another solver."""
    if wanted is None:
        return None
    return settings.tolerance, settings.iterations, scratch.tally


@jit
def rigidity(h):
    """What :func:`stiction.core.solve.soft.softness` is for soft contacts."""
    return PUSH_OUT / h, COMPLIANCE, PUSH_OUT / h, COMPLIANCE


@jit
def iterate(blocks, index, count, rows, aux, h, t, rolls, laws, exact):
    """Passes until the miss of all blocks is below the tolerance. ``exact``: tolerance (m/s), passes, and the tally."""
    tolerance, most, tally = exact
    tally[SOLVES] += 1.0
    tally[LOGGED] = 0.0
    passes, miss = 0, 0.0
    for turn in range(ROUNDS):
        while passes < most:
            for i in range(count):
                solve_block(i, blocks, index, count, rows, aux, h, t, False, False, rolls, laws, exact)
            passes += 1
            if passes % CHECK == 1 or passes == most:
                miss = miss_of_all(blocks, index, count, rows, h, t, laws, False)
                entry = int(tally[LOGGED])
                if LOG + entry < TALLY:
                    tally[LOG + entry] = miss
                    tally[LOGGED] = entry + 1.0
                if miss <= tolerance:
                    break
        if passes >= most or not settle_states(blocks, index, count, turn == 0):
            break
    tally[PASSES] += passes
    tally[LAST_MISS] = miss
    if miss > tolerance:
        tally[HITS] += 1.0
        tally[WORST] = max(tally[WORST], miss)


@jit
def settle_states(blocks, index, count, first):
    """Let those go that stick at the static limit and, the first time, stick what could; whether any changed."""
    changed = False
    for i in range(count):
        o = first_row(index, i, count)
        sliding = load(blocks, o + s.B_STATE) > 0.5
        over = load(blocks, o + s.B_OVER)
        new = sliding | (over > 1.0 + OVER)
        if first:
            new = new & ~(sliding & (over <= 1.0))
        changed |= any_of((new & ~sliding) | (sliding & ~new))
        zero = over - over
        store(blocks, o + s.B_STATE, select(new, zero + 1.0, zero))
    return changed


@jit
def miss_of_all(blocks, index, count, rows, h, t, laws, moved):
    """The largest miss of all blocks at the time t of the step, m/s."""
    worst = 0.0
    for i in range(count):
        if laws is None and moved and is_point_block(index, i, count):
            miss = miss_of_points(i, blocks, index, count, rows, h, t)
        else:
            miss = miss_of_block(i, blocks, index, count, rows, h, t, laws, moved)
        o = first_row(index, i, count)
        store(blocks, o + s.B_MISS, miss)
        for lane in range(LANES):
            if index[i + 2 * count, lane] > 0:
                worst = max(worst, blocks[o + s.B_MISS, lane])
    return worst


@entry
def measure_miss(blocks, index, count, rows, h, substeps, laws):
    """The largest miss of the blocks as the last step, of so many substeps, has left them, m/s."""
    return miss_of_all(blocks, index, count, rows, h, h * substeps, laws, True)


@entry
def measure_miss_again(blocks, index, count, manifolds, corners, rows, aux, h, substeps):
    """The same of a piece of a world of the default solver without friction laws, whose blocks others have filled since
    (:mod:`stiction.core.pieces`): they are made anew from what the step has left in the manifolds.

    Friction is taken at the centre of pressure of the last loads then, not of the first ones: where that wanders within
    a step, the miss is another one.
    """
    beta, compliance, beta_stiff, compliance_stiff = softness(h)
    for i in range(count):
        if is_point_block(index, i, count):
            prepare_points(
                i, blocks, index, count, manifolds, aux, h, h * substeps, beta, compliance, beta_stiff, compliance_stiff
            )
        else:
            prepare_block(
                i, blocks, index, count, manifolds, corners, aux, h, h * substeps, beta, compliance, beta_stiff,
                compliance_stiff, None,
            )  # fmt: skip
        o = first_row(index, i, count)
        put3(blocks, o + s.B_BELT, belt_now(blocks, o, h * substeps))
    return miss_of_all(blocks, index, count, rows, h, h * substeps, None, True)


@jit
def miss_of_block(i, blocks, index, count, rows, h, t, laws, moved):
    """By how many m/s the manifolds of block i miss their laws.

    At a point with load it is the size of the closing speed over the wanted one, without it what closes too fast, and
    never more than what taking the load away would do. For friction it is the change of slip that the manifold's own
    solution would make. ``moved``: the bodies have gone the way of the substep already.
    """
    o = first_row(index, i, count)
    C = transpose(frame_of(blocks, o))
    v, w, _, _, _, _ = twist_now(i, blocks, o, index, count, rows, C, t if moved else t + h)
    x, y = get4(blocks, o + s.B_U), get4(blocks, o + s.B_V)
    gap = gaps_now(i, blocks, o, index, count, rows, C, x, y, t)
    closing = Four(
        v.x + y.a * w.y - x.a * w.z, v.x + y.b * w.y - x.b * w.z,
        v.x + y.c * w.y - x.c * w.z, v.x + y.d * w.y - x.d * w.z,
    )  # fmt: skip
    if moved:
        gap = Four(
            gap.a + closing.a * h, gap.b + closing.b * h, gap.c + closing.c * h, gap.d + closing.d * h
        )  # fmt: skip
    lam = get4(blocks, o + s.B_LOAD)
    stiffness = 1.0 / load(blocks, o + s.B_RIGID)
    beta = load(blocks, o + s.B_BETA)
    if moved:
        beta = beta - beta
    aim = Four(
        allowed(gap.a, beta, h), allowed(gap.b, beta, h), allowed(gap.c, beta, h), allowed(gap.d, beta, h)
    )  # fmt: skip
    normal = greatest(
        greatest(_miss(closing.a - aim.a, lam.a, stiffness), _miss(closing.b - aim.b, lam.b, stiffness)),
        greatest(_miss(closing.c - aim.c, lam.c, stiffness), _miss(closing.d - aim.d, lam.d, stiffness)),
    )

    px, py, Tm = load(blocks, o + s.B_CENTER), load(blocks, o + s.B_CENTER + 1), load(blocks, o + s.B_TORQUE)
    F, Fi = get6(blocks, o + s.B_FRICTION), get6(blocks, o + s.B_FRICTION_INVERSE)
    surface = surface_at(blocks, o)
    belt = get3(blocks, o + s.B_BELT) if moved else belt_now(blocks, o, h)
    pull = get3(blocks, o + s.B_PULL)
    slip = scaled_slip(blocks, o, Vec3(v.y - w.x * py, v.z + w.x * px, w.x * Tm) + belt, laws)
    stick = pull + times(Fi, slip)
    sliding = load(blocks, o + s.B_STATE) > 0.5
    limit = select(sliding, load(blocks, o + s.B_MU_D), load(blocks, o + s.B_MU_S)) * (
        greatest(lam.a, 0.0) + greatest(lam.b, 0.0) + greatest(lam.c, 0.0) + greatest(lam.d, 0.0)
    )
    unit = unit_of(limit, stick)
    inside = level(stick * unit, surface) <= 1.0
    if not all_of(inside):
        g = slide(F, (slip + times(F, pull)) * unit, pull * unit, surface, ~inside)
        stick = choose3(inside, stick, choose3(limit > 0.0, g * limit, pull - pull))
    change = times(F, stick - pull)
    tangential = dot(change, change)
    if laws is not None:
        # a tyre's slip is its law; what it misses is the lag of a substep, and is not told
        tangential = select(load(blocks, o + s.B_ALPHA) > 0.0, tangential - tangential, tangential)
    return greatest(normal, sqrt(tangential))


@jit
def _miss(error, lam, stiffness):
    """Of one point that closes too fast by ``error``, or too slowly though it carries a load."""
    return select(error > 0.0, error, least(size_of(error), lam * stiffness))
