"""All passes of a step over its manifolds, by one worker or by several."""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.ahead import ask_for_block, ask_for_bodies
from stiction.core.clock import lap
from stiction.core.colouring import COLOURS, blocks_of_colour, count_colours, is_point_block
from stiction.core.jit import jit
from stiction.core.lanes import LANES
from stiction.core.soft_bodies import move_rows
from stiction.core.solve.blocks import prepare_block
from stiction.core.solve.blows import MOST_BLOWS, any_struck, mark_struck, note_struck
from stiction.core.solve.depth import (
    ROUNDS,
    any_buried,
    bury_faces,
    bury_points,
    dig_faces_out,
    dig_points_out,
    is_buried,
    lift_block,
    lift_points,
)
from stiction.core.solve.exact import iterate, rigidity
from stiction.core.solve.points import prepare_points, solve_points, warm_points
from stiction.core.solve.soft import (
    COLD_ENOUGH,
    COLD_PASSES,
    MOST_COLD_PASSES,
    MOST_COLD_WORK,
    NOTHING_NEW,
    SOME_NEW,
    has_fresh,
    last_change,
    softness,
    solve_block,
    warm_block,
)
from stiction.core.team import meet, share


@jit
def run_passes(
    soft, movers, glide, normals, sizes, count, many, moving, h, substeps, fresh, profile, rolls, laws, exact, team,
    worker,
):  # fmt: skip
    """Prepare, warm start, cold passes for what is new, and all substeps.

    ``count`` blocks in the order of their colours, whose numbers of manifolds are ``sizes``, of a step that has
    ``many`` manifolds, and ``moving`` bodies; ``fresh``: which manifolds are new; ``laws``: see :func:`prepare_block`;
    ``exact``: None, or what :func:`iterate` needs; with either there are no blocks of points. Every worker does a share
    of each colour, and they meet before the next one.
    """
    blocks, index, manifolds, rows, aux = soft.blocks, soft.members, soft.manifolds, soft.rows, soft.aux
    beta, compliance, beta_stiff, compliance_stiff = softness(h) if exact is None else rigidity(h)
    rounds = count_rounds(sizes, team)
    first, last = share(team, worker, 0, count)
    for i in range(first, last):
        ask_for_bodies(index, i + 1, count, aux, s.AUX_ROTATION, many)
        ask_for_bodies(index, i + 1, count, aux, s.AUX_INERTIA, many)
        ask_for_block(index, i + 1, count, manifolds, s.MANIFOLD_WIDTH, many)
        if laws is None and exact is None and is_point_block(index, i, count):
            prepare_points(
                i, blocks, index, count, manifolds, aux, h, h * substeps, beta, compliance, beta_stiff, compliance_stiff
            )  # fmt: skip
            bury_points(i, blocks, index, count)
        else:
            prepare_block(
                i, blocks, index, count, manifolds, soft.corners, aux, h, h * substeps, beta, compliance, beta_stiff,
                compliance_stiff, laws,
            )  # fmt: skip
            bury_faces(i, blocks, index, count, exact)
    meet(team)
    for r in range(rounds):
        first, last = blocks_of(sizes, r, count, team, worker)
        for i in range(first, last):
            if laws is None and exact is None and is_point_block(index, i, count):
                warm_points(i, blocks, index, count, rows)
            else:
                warm_block(i, blocks, index, count, rows, aux, laws)
        meet(team)
    if fresh > NOTHING_NEW and exact is None:
        most = COLD_PASSES if fresh == SOME_NEW else max(COLD_PASSES, min(MOST_COLD_PASSES, MOST_COLD_WORK // count))
        for turn in range(most):
            for r in range(rounds):
                first, last = blocks_of(sizes, r, count, team, worker)
                for i in range(first, last):
                    if has_fresh(i, blocks, index, count):
                        solve_any(i, blocks, index, count, rows, aux, h, 0.0, True, False, rolls, laws, exact)
                meet(team)
            if turn % COLD_PASSES == COLD_PASSES - 1:
                ends = last_change(blocks, index, count) < COLD_ENOUGH
                meet(team)  # who is late must not see what the next pass has changed
                if ends:
                    break
        first, last = share(team, worker, 0, count)
        for i in range(first, last):
            if not has_fresh(i, blocks, index, count):
                continue
            if is_point_block(index, i, count):
                lift_points(i, blocks, index, count)
            else:
                lift_block(i, blocks, index, count)
        meet(team)
    if worker == 0:
        lap(profile, 4)
    first_body, last_body = share(team, worker, 0, moving)
    for substep in range(substeps):
        turn = 1 + substep * (MOST_BLOWS + 1)
        if exact is not None:
            iterate(blocks, index, count, rows, aux, h, substep * h, rolls, laws, exact)
        for r in range(rounds):
            first, last = blocks_of(sizes, r, count, team, worker)
            for i in range(first, last):
                ask_for_bodies(index, i + 1, count, rows, s.ROW_V, count * LANES)
                ask_for_bodies(index, i + 1, count, rows, s.ROW_TURN, count * LANES)
                solve_any(i, blocks, index, count, rows, aux, h, substep * h, False, True, rolls, laws, exact)
                if exact is None:
                    note_struck(i, blocks, index, count, aux, turn)
            meet(team)
        if exact is None:
            answer_blows(
                blocks, index, sizes, rounds, count, rows, aux, h, substep * h, turn, rolls, laws, team, worker
            )
        if worker == 0:
            lap(profile, 5)
        move_rows(movers, first_body, last_body, glide, normals, rows, aux, h, substep == substeps - 1)
        meet(team)
        if worker == 0:
            lap(profile, 6)
    if worker == 0 and any_buried(blocks, index, count):
        # by the leader alone: it is little, and seldom
        dt = h * substeps
        for _ in range(ROUNDS):
            for i in range(count):
                if not is_buried(i, blocks, index, count):
                    continue
                if laws is None and exact is None and is_point_block(index, i, count):
                    dig_points_out(i, blocks, index, count, rows, aux, dt / ROUNDS, dt)
                else:
                    dig_faces_out(i, blocks, index, count, rows, aux, dt / ROUNDS, dt, exact)


@jit
def answer_blows(blocks, index, sizes, rounds, count, rows, aux, h, t, turn, rolls, laws, team, worker):
    """Pass over what blows have struck until nothing closes fast any more; ``turn``: the number of the pass before."""
    for blow in range(1, MOST_BLOWS + 1):
        if not any_struck(blocks, index, count):
            return
        meet(team)  # who is late must not see what the next pass strikes
        for r in range(rounds):
            first, last = blocks_of(sizes, r, count, team, worker)
            for i in range(first, last):
                if mark_struck(i, blocks, index, count, aux, turn + blow):
                    solve_any(i, blocks, index, count, rows, aux, h, t, False, False, rolls, laws, None)
                    note_struck(i, blocks, index, count, aux, turn + blow)
            meet(team)


@jit
def solve_any(i, blocks, index, count, rows, aux, h, t, cold, counts, rolls, laws, exact):
    """One pass over block i: of points, or as :func:`solve_block`."""
    if laws is None and exact is None and is_point_block(index, i, count):
        solve_points(i, blocks, index, count, rows, aux, h, t, cold, counts)
    else:
        solve_block(i, blocks, index, count, rows, aux, h, t, cold, counts, rolls, laws, exact)


@jit
def count_rounds(sizes, team):
    """Colours in use, and one for the manifolds that have none; a leader that is alone takes all blocks in one
    round."""
    return 1 if team is None else count_colours(sizes) + 1


@jit
def blocks_of(sizes, r, count, team, worker):
    """The worker's blocks in round r. What has no colour comes last, and is for the leader, one after the other."""
    if team is None:
        return 0, count
    first = 0
    for c in range(r):
        first += blocks_of_colour(sizes, c)
    here = blocks_of_colour(sizes, r) if r < COLOURS else 0
    if here == 0:
        return (first, count) if worker == 0 else (first, first)
    return share(team, worker, first, here)
