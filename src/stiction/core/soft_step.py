"""Time steps of the soft solver, as a table of contents: of one world, or of several that are alike, side by side.

Small worlds do not fill the eight lanes of a block. So worlds in which nothing is new wait until the others have found
their contacts, and are solved together: a lane asks nothing of its neighbours, and each world gets the bits that it
would get alone. What depends on more than a manifold's own world goes alone: cold passes, which end when all of them
agree, impacts, twice the substeps, laws of friction, the exact solver, threads.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.book import entries_at
from stiction.core.clock import lap, start_clock
from stiction.core.colouring import (
    GROUPS,
    colour_manifolds,
    count_blocks,
    count_rows,
    empty_blocks,
    fill_blocks,
    forget_colours,
)
from stiction.core.contact_work import drive_work
from stiction.core.find import list_manifolds
from stiction.core.integrate import first_not_finite, is_number, restore_body
from stiction.core.jit import jit
from stiction.core.ledger import note_edits, total_energy
from stiction.core.pieces import BLOCK, COUNT, FIRST, MOVER, MOVERS, PIECE, UNCUT_FOR, cut
from stiction.core.pieces import BLOCKS as BLOCKS_HERE
from stiction.core.slots import hand_out
from stiction.core.soft_book import (
    LEDGER,
    bounces_at,
    cache_at,
    desk_at,
    gravity_of,
    part_at,
    rows_of,
    scratch_at,
    soft_at,
    soft_of_all,
)
from stiction.core.soft_edits import is_touched, take_edits
from stiction.core.soft_lists import (
    begin_bodies,
    begin_others,
    drop_forces,
    first_bad_row,
    is_uneven,
    keep_states,
    list_awake,
    list_moving,
    list_touching,
    new_ones,
    unmark,
)
from stiction.core.soft_parts import (
    BOUNCE,
    COLLECT,
    FIND_PART,
    FINISH_PART,
    IMPACTS_PART,
    PAIRS_PART,
    REPORT,
    SOLVE_PART,
    call_find,
    call_finish,
    call_impacts,
    call_pairs,
    call_solve,
)
from stiction.core.soft_rows import members_from
from stiction.core.soft_scratch import (
    ACTIVE,
    ALWAYS,
    AWAKE,
    BLOCK_ROWS,
    BLOCKS,
    BOUNCING,
    FILL,
    FRESH,
    FROM,
    GLIDE,
    GROUP,
    HARD,
    MARK,
    MOVING,
    N_AWAKE,
    N_LAST,
    NEVER,
    PLACE,
    RESTLESS,
    ROLE,
    STALE,
    SUBSTEPS,
    TAKING_PART,
    TOUCH,
    TOUCHING,
    UNCUT,
    USED,
)
from stiction.core.solve.results import store_blocks
from stiction.core.solve.soft import NOTHING_NEW, SETTLING
from stiction.core.state import EDITS, FRICTION, IMPACTS, INITIAL, MECHANICAL, NUMERICAL, ROLLING_LOSS, WORK
from stiction.core.team import FIND, SOLVE, call, meet
from stiction.core.vec import length

DONE, MORE_PAIRS, MORE_SLOTS, MORE_BLOCKS, BLOWN_UP, MORE_CONTACTS, GOES = range(7)
"""Why a world has stopped, or that it has not."""

TAKEN, REASON, NUMBER, OUTCOME_WIDTH = range(4)
"""Columns of the outcomes."""

NOBODY, WAITS = 0, 1
"""Roles of a world in the middle of a step: none; its contacts are found and wait to be solved."""

SLOW = 0.375
"""A new contact that slips by less than this part of what gravity gives in a step begins stuck."""


@jit
def take_steps(steps, n, book, first, last, outcomes, one, bounces, laws, exact, team):
    """Steps of the worlds from ``first`` to before ``last``, of n bodies each, until each has taken so many.

    ``outcomes`` (worlds, OUTCOME_WIDTH) has how many it has taken, why it returned, and a number that goes with the
    reason. When there is no room for a step's pairs, slots, blocks or impacts a world stops before that step has
    changed anything but the manifolds, which are found anew or kept when it is taken again, with the room that is
    needed; when a body would no longer be finite, with that body, and all bodies as they were before.
    ``bounces``: whether a pair bounces; ``laws``: whether one has more than constant coefficients; ``exact``: whether
    this is the exact solver. ``team``: None, or the :class:`stiction.core.team.Team` whose other workers are in
    :func:`stiction.core.soft_entry.assist`.
    """
    notes, worlds = desk_at(book).notes, last - first
    going = 0
    places = places_of(desk_at(book))
    points = not (laws or exact)  # laws and the exact solver know only faces
    for k in range(worlds):
        notes[k, PLACE] = k * places
        going += begin_call(steps, n, book, first + k, notes[k], outcomes, one)
    while going > 0:
        k, room, alone = 0, 0, True
        while alone:
            alone = False
            while k < worlds and not alone:
                notes[k, ROLE] = NOBODY
                if outcomes[first + k, REASON] == GOES:
                    notes[k, FROM] = room
                    alone = find_contacts(n, book, first + k, notes[k], outcomes, one, bounces, laws, exact, team)
                    alone &= worlds > 1
                    room += notes[k, ACTIVE] if notes[k, ROLE] == WAITS and not alone else 0
                k += 1
            start, count = (k - 1, 1) if alone else (0, worlds)
            solve_worlds(
                n, book, first + start, count, notes[start:], outcomes, one, bounces, laws, points, exact, team
            )
            if alone:
                notes[start, ROLE] = NOBODY
        going = 0
        for w in range(first, last):
            going += end_call(steps, n, book, w, outcomes)


@jit
def begin_call(steps, n, book, w, note, outcomes, one):
    """Look at a world that has steps to take; returns 1 if it goes."""
    if outcomes[w, TAKEN] >= steps:
        return 0
    bodies, kinds, _, ledger, _, settings = rows_of(book, w)
    scratch, soft = scratch_at(book, w), soft_at(book, w, note[PLACE], one)
    outcomes[w, REASON], outcomes[w, NUMBER] = GOES, 0
    gravity = gravity_of(settings)
    if not is_touched(bodies, kinds, n, scratch.counts, scratch.pull, gravity, ledger):
        return 1
    broken = first_not_finite(bodies, n)
    if broken >= 0:
        for i in range(n):
            if not is_number(bodies, i):
                restore_body(bodies, i)
        outcomes[w, REASON], outcomes[w, NUMBER] = BLOWN_UP, broken
        return 0
    note_edits(bodies, n, gravity, ledger)
    take_edits(
        bodies, kinds, n, cache_at(book, w), soft.pose, soft.rows, soft.aux, scratch.bodies, scratch.counts,
        desk_at(book).lists[RESTLESS], gravity, length(gravity), settings.dt, settings.dt / settings.substeps,
    )  # fmt: skip
    return 1


@jit
def find_contacts(n, book, w, note, outcomes, one, bounces, laws, exact, team):
    """The first half of a step: who takes part, which pairs there are, their manifolds. Returns whether the world must
    be solved alone."""
    bodies, kinds, _, _, profile, settings = rows_of(book, w)
    soft, cache = soft_at(book, w, note[PLACE], one), cache_at(book, w)
    scratch, desk = scratch_at(book, w), desk_at(book)
    counts = scratch.counts
    gravity = gravity_of(settings)
    g, dt = length(gravity), settings.dt
    active_ones = desk.active[note[FROM] :]
    start_clock(profile)
    substeps = substeps_of(settings, counts, exact)
    h = dt / substeps
    active, awake, woke = 0, 0, True
    while woke:
        awake = list_awake(kinds, n, scratch.bodies, counts)
        begin_bodies(bodies, kinds, scratch.bodies[AWAKE], awake, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
        if note[FILL] != NEVER and awake > 0:
            note[FILL] = ALWAYS if note[FILL] == ALWAYS else NEVER
            begin_others(bodies, kinds, n, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
        lap(profile, 0)
        pairs = call_pairs(part_at(book, PAIRS_PART), (book, w, awake, dt))
        if pairs > cache.pairs.shape[0]:
            stop(n, book, w, outcomes, MORE_PAIRS, pairs)
            return False
        lap(profile, 1)
        find_points(book, w, note, pairs, 0, SLOW * g * dt, dt, one, team)
        wanted, needed = hand_out(cache, desk.looked, pairs, soft)
        if needed > cache.free.shape[0]:
            stop(n, book, w, outcomes, MORE_SLOTS, needed)
            return False
        if wanted > 0:
            find_points(book, w, note, pairs, 1, SLOW * g * dt, dt, one, team)
        active, woke = list_manifolds(bodies, kinds, n, cache.pairs, pairs, desk.looked, active_ones)
        counts[STALE] |= woke
        lap(profile, 2)
    hard = is_uneven(kinds, soft.aux, soft.meta, active_ones, active)
    if hard != counts[HARD]:
        # at once: springs that change while they carry a load would throw it up
        counts[HARD] = hard
        substeps = substeps_of(settings, counts, exact)
        h = dt / substeps
        begin_bodies(bodies, kinds, scratch.bodies[AWAKE], awake, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
    impacts = 0
    if bounces:
        impacts = call_impacts(part_at(book, IMPACTS_PART), (book, COLLECT, w, n, note[PLACE], note[FROM], active, one))
        if impacts > bounces_at(book, w)[0].shape[0]:
            stop(n, book, w, outcomes, MORE_CONTACTS, impacts)
            return False
    fresh = new_ones(soft.manifolds, active_ones, active)
    note[ROLE], note[ACTIVE], note[TAKING_PART] = WAITS, active, awake
    note[SUBSTEPS], note[FRESH], note[BOUNCING] = substeps, fresh, impacts
    lap(profile, 3)
    if laws or exact:
        return True
    return fresh > NOTHING_NEW or impacts > 0 or hard != 0


@jit
def find_points(book, w, note, pairs, again, slow, dt, one, team):
    """The narrow phase, by all workers; ``again`` (0 or 1) of pairs that have just got a slot."""
    call(team, FIND, pairs, again, 0, slow, dt)
    call_find(part_at(book, FIND_PART), (book, w, note[PLACE], pairs, again, slow, dt, one, team))
    meet(team)


@jit
def solve_worlds(n, book, first, worlds, notes, outcomes, one, bounces, laws, points, exact, team):
    """The second half of a step of those of so many worlds from ``first`` on that wait."""
    _, _, _, _, profile, settings = rows_of(book, first)
    desk, soft, dt = desk_at(book), soft_of_all(book, first, worlds, notes[0, PLACE], one), settings.dt
    substeps, fresh, many = 0, NOTHING_NEW, 0
    for j in range(worlds):
        if notes[j, ROLE] == WAITS:
            substeps, fresh = notes[j, SUBSTEPS], notes[j, FRESH]
            many += notes[j, ACTIVE]
    if substeps == 0:
        return
    h = dt / substeps

    # blocks
    pieces = 1
    counts = scratch_at(book, first).counts
    if counts[UNCUT] > 0:
        counts[UNCUT] -= 1
    elif worlds == 1 and many > PIECE and points and fresh == NOTHING_NEW and desk.pieces.shape[0] > 1:
        pieces = cut(
            rows_of(book, first).kinds, n, desk.active, many, desk.lists[GROUP], desk.lists[RESTLESS], desk.ordered,
            desk.pieces,
        )  # fmt: skip
        counts[UNCUT] = UNCUT_FOR if pieces == 1 else 0
    blocks, rows = 0, 0
    for piece in range(pieces):
        here = colour_piece(book, first, worlds, notes, piece, pieces, blocks, points)
        blocks, rows = blocks + here, rows + count_rows(desk.sizes[piece, :GROUPS], here)
    for j in range(worlds):
        if notes[j, ROLE] == WAITS:
            scratch_at(book, first + j).counts[BLOCK_ROWS] = rows
    if s.MEMBERS * blocks > soft.members.shape[0] or rows > soft.blocks.shape[0]:
        for j in range(worlds):
            if notes[j, ROLE] == WAITS:
                stop(n, book, first + j, outcomes, MORE_BLOCKS, blocks)
        return
    for k in range(s.ROW_WIDTH):
        soft.rows[0, k] = 0.0

    for j in range(worlds):
        desk.failed[j] = 0
        if notes[j, ROLE] == WAITS:
            notes[j, TOUCH] = 0
            scratch_at(book, first + j).counts[BLOCKS] = blocks
            if bounces:
                resolve_impacts(book, first + j, n, notes[j], one, h)

    moving = 0
    entries = entries_at(book, LEDGER, first, worlds, 0.0)
    friction, rolling = entries[FRICTION], entries[ROLLING_LOSS]
    for piece in range(pieces):
        here = desk.pieces[piece]
        own = members_from(soft, here[BLOCK])
        moving = fill_piece(book, first, worlds, notes, own, piece, pieces, moving, one)
        lap(profile, 3)
        if here[BLOCKS_HERE] > 0:
            call(team, SOLVE, piece, many, substeps, h, fresh)
            call_solve(
                part_at(book, SOLVE_PART),
                (book, first, worlds, notes[0, PLACE], piece, many, h, substeps, fresh, one, team, 0),
            )
        if pieces == 1:
            for j in range(worlds):
                if notes[j, ROLE] == WAITS:
                    desk.failed[j] = fails(book, first + j, n, j * places_of(desk), notes[j], outcomes, one, h)
        store_blocks(
            own.blocks, own.members, here[BLOCKS_HERE], soft.manifolds, soft.reports, soft.aux, h, dt / SETTLING,
            entries, desk.failed, laws, exact, many,
        )  # fmt: skip
    if pieces > 1 and fails(book, first, n, 0, notes[0], outcomes, one, h):
        # manifolds keep what the solver found for them
        desk.failed[0] = 1
        entries[FRICTION], entries[ROLLING_LOSS] = friction, rolling
    for j in range(worlds):
        if notes[j, ROLE] == WAITS and desk.failed[j] == 0:
            end_step(book, first + j, notes, j, outcomes, one, bounces, laws)


@jit
def places_of(desk):
    """How many rows of bodies a world has on the desk."""
    return desk.lists.shape[1] // desk.notes.shape[0]


@jit
def part_of(desk, notes, j, piece, pieces):
    """Active manifolds of world j in a piece, and how many they are."""
    if pieces > 1:
        return desk.ordered[desk.pieces[piece, FIRST] :], desk.pieces[piece, COUNT]
    return desk.active[notes[j, FROM] :], notes[j, ACTIVE]


@jit
def colour_piece(book, first, worlds, notes, piece, pieces, before, points):
    """Give the manifolds of a piece their colours; returns how many blocks they fill, after so many ``before``."""
    desk = desk_at(book)
    sizes, starts = desk.sizes[piece, :GROUPS], desk.sizes[piece, GROUPS:]
    forget_colours(sizes, starts)
    for j in range(worlds):
        if notes[j, ROLE] == WAITS:
            active, count = part_of(desk, notes, j, piece, pieces)
            colour_manifolds(
                active, count, rows_of(book, first + j).kinds, desk.lists[USED], sizes, starts, points
            )  # fmt: skip
    blocks = count_blocks(sizes)
    desk.pieces[piece, BLOCK], desk.pieces[piece, BLOCKS_HERE] = before, blocks
    return blocks


@jit
def fill_piece(book, first, worlds, notes, soft, piece, pieces, moving, one):
    """Who is in the blocks of a piece, and which bodies move with it, from ``moving`` on in their list; returns where
    the next ones begin."""
    desk, here = desk_at(book), desk_at(book).pieces[piece]
    sizes, starts, blocks = desk.sizes[piece, :GROUPS], desk.sizes[piece, GROUPS:], here[BLOCKS_HERE]
    places, slots = places_of(desk), soft.manifolds.shape[0] // worlds
    empty_blocks(sizes, starts, soft.members, blocks)
    here[MOVER] = moving
    for j in range(worlds):
        if notes[j, ROLE] == WAITS:
            active, count = part_of(desk, notes, j, piece, pieces)
            fill_blocks(active, count, starts, soft.members, blocks, j, places, slots)
            moving += list_bodies(book, first + j, j * places, active, count, moving, notes[j], one)
    here[MOVERS] = moving - here[MOVER]
    return moving


@jit
def resolve_impacts(book, w, n, note, one, h):
    """Impacts, which come before all contact that lasts."""
    bodies, kinds, _, _, _, settings = rows_of(book, w)
    soft, scratch, gravity = soft_at(book, w, note[PLACE], one), scratch_at(book, w), gravity_of(settings)
    if note[BOUNCING] > 0:
        call_impacts(part_at(book, IMPACTS_PART), (book, BOUNCE, w, n, note[PLACE], 0, note[BOUNCING], one))
        begin_bodies(
            bodies, kinds, scratch.bodies[AWAKE], note[TAKING_PART], soft.pose, soft.rows, soft.aux, gravity,
            length(gravity), settings.dt, h,
        )  # fmt: skip


@jit
def list_bodies(book, w, base, active, count, moving, note, one):
    """List who is in contact by so many active manifolds, and who of those moves, from ``moving`` on; returns how many
    these are."""
    bodies, kinds, _, _, _, settings = rows_of(book, w)
    soft, desk = soft_at(book, w, note[PLACE], one), desk_at(book)
    touched, mark = desk.lists[TOUCHING, base + note[TOUCH] :], desk.lists[MARK, base:]
    glide, normals = desk.lists[GLIDE, base + 1 :], desk.normals[base + 1 :]
    touching = list_touching(
        kinds, soft.manifolds, soft.meta, soft.pose, active, count, touched, mark, glide, normals
    )  # fmt: skip
    note[TOUCH] += touching
    gravity, movers = gravity_of(settings), desk.lists[MOVING, moving:]
    return list_moving(bodies, kinds, touched, touching, glide, normals, gravity, movers, base)


@jit
def fails(book, w, n, base, note, outcomes, one, h):
    """Whether a body would no longer be finite: then the world stops, as it was before the step."""
    bodies, kinds, _, _, _, settings = rows_of(book, w)
    soft, desk, awake = soft_at(book, w, note[PLACE], one), desk_at(book), scratch_at(book, w).bodies[AWAKE]
    touched, mark, gravity = desk.lists[TOUCHING, base:], desk.lists[MARK, base:], gravity_of(settings)
    bad = first_bad_row(bodies, kinds, awake, note[TAKING_PART], mark, soft.rows, gravity, settings.dt)
    if bad < 0:
        return False
    unmark(mark, touched, note[TOUCH])
    # the solver's rows of what does not move are not made anew in every step
    begin_bodies(
        bodies, kinds, touched, note[TOUCH], soft.pose, soft.rows, soft.aux, gravity, length(gravity), settings.dt, h
    )
    drop_forces(bodies, awake, note[TAKING_PART])
    stop(n, book, w, outcomes, BLOWN_UP, bad)
    return True


@jit
def end_step(book, w, notes, j, outcomes, one, bounces, laws):
    """Move the bodies of a world, whose note is the j-th, and let those sleep that are at rest."""
    bodies, kinds, _, ledger, profile, _ = rows_of(book, w)
    note, desk = notes[j], desk_at(book)
    soft, active = soft_at(book, w, note[PLACE], one), desk.active[note[FROM] :]
    ledger[WORK] += drive_work(bodies, kinds, active, note[ACTIVE], soft.manifolds, soft.meta, soft.pose, soft.reports)
    if bounces:
        call_impacts(part_at(book, IMPACTS_PART), (book, REPORT, w, 0, note[PLACE], 0, note[BOUNCING], one))
    lap(profile, 7)
    call_finish(part_at(book, FINISH_PART), (book, w, notes, j, j * places_of(desk), one, laws))
    outcomes[w, TAKEN] += 1
    lap(profile, 8)


@jit
def end_call(steps, n, book, w, outcomes):
    """Stop a world that has taken its steps; returns 1 if it goes on."""
    if outcomes[w, REASON] != GOES:
        return 0
    if outcomes[w, TAKEN] < steps:
        return 1
    stop(n, book, w, outcomes, DONE, 0)
    return 0


@jit
def stop(n, book, w, outcomes, reason, number):
    """End the call for a world: close its ledger, and remember the state of the bodies that are awake."""
    bodies, _, _, ledger, _, settings = rows_of(book, w)
    scratch, gravity = scratch_at(book, w), gravity_of(settings)
    close_soft_ledger(bodies, n, gravity, ledger)
    keep_states(bodies, scratch.bodies[AWAKE], scratch.counts[N_AWAKE])
    scratch.counts[N_LAST] = n
    scratch.pull[0], scratch.pull[1], scratch.pull[2] = gravity.x, gravity.y, gravity.z
    outcomes[w, REASON], outcomes[w, NUMBER] = reason, number


@jit
def substeps_of(settings, counts, exact):
    """How many substeps the next step takes."""
    return 2 * settings.substeps if counts[HARD] and not exact else settings.substeps


@jit
def close_soft_ledger(bodies, n, gravity, ledger):
    """What is left after work, friction and rolling is what the normal impulses took: those of impacts, and what the
    springs of soft contacts keep or give back for a while, so that the sum may fall a little.
    """
    kinetic, potential = total_energy(bodies, n, gravity)
    entered = ledger[INITIAL] + ledger[WORK] + ledger[EDITS] + ledger[NUMERICAL]
    entered -= ledger[FRICTION] + ledger[ROLLING_LOSS] + ledger[IMPACTS]
    ledger[IMPACTS] -= kinetic + potential - entered
    ledger[MECHANICAL] = kinetic + potential
