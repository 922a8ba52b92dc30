"""The parts of a step of the soft solver that are kernels by themselves, which it calls by their addresses.

They are the step's heaviest, and all that has variants but for precision and threads: so a world with another shape or
another law has to compile that one part which knows of it. Each takes the book, and finds its arrays there.
"""

from __future__ import annotations

from stiction.core.contact_work import give_to_tumblers, hold_tumblers
from stiction.core.find import update_manifolds
from stiction.core.friction.laws import laws_of
from stiction.core.gains import take_gains_back
from stiction.core.jit import part
from stiction.core.pairs import update_pairs
from stiction.core.parts import Crew, Number, Switch, Table, caller
from stiction.core.pieces import BLOCK, BLOCKS, MOVER, MOVERS
from stiction.core.sleep import PERIOD, put_to_sleep
from stiction.core.soft_book import (
    bounces_at,
    cache_at,
    desk_at,
    gravity_of,
    hulls_at,
    rows_of,
    scratch_at,
    soft_at,
    soft_of_all,
    tree_at,
)
from stiction.core.soft_lists import begin_bodies, finish_bodies, unmark
from stiction.core.soft_rows import members_from
from stiction.core.soft_scratch import (
    ACTIVE,
    AWAKE,
    FROM,
    GLIDE,
    GROUP,
    MARK,
    MOVING,
    PLACE,
    RESTLESS,
    STALE,
    STEP,
    SUBSTEPS,
    TAKING_PART,
    TOUCH,
    TOUCHING,
)
from stiction.core.solve.bounces import bounce, collect_impacts, report_bounces
from stiction.core.solve.exact import exact_of
from stiction.core.solve.passes import run_passes
from stiction.core.vec import length

PAIRS_PART, FIND_PART, SOLVE_PART, FINISH_PART, IMPACTS_PART = range(5)
"""Where the address of each is on the page of parts; that of the impacts is 0 where nothing bounces."""

COLLECT, BOUNCE, REPORT = range(3)
"""What is to be done about impacts."""


@part
def pairs(book: Table, w: int, awake: int, dt: float) -> int:
    """:func:`stiction.core.pairs.update_pairs` for the first ``awake`` of the bodies awake."""
    bodies, kinds, _, _, _, _ = rows_of(book, w)
    return update_pairs(
        tree_at(book, w), cache_at(book, w), bodies, kinds, scratch_at(book, w).bodies[AWAKE], awake, dt
    )


@part
def find(
    book: Table, w: int, place: int, count: int, again: int, slow: float, dt: float, one: Number, team: Crew,
    boxes_meet: Switch, hulls: Switch,
) -> int:  # fmt: skip
    """:func:`stiction.core.find.update_manifolds` of so many pairs of a world, whose bodies begin at ``place`` on the
    desk; ``again`` of those that have got a slot."""
    bodies, kinds, table, _, _, _ = rows_of(book, w)
    desk = desk_at(book)
    update_manifolds(
        bodies, kinds, cache_at(book, w).pairs, count, again, soft_at(book, w, place, one), desk.looked, desk.contacts,
        desk.tags, desk.points, table, slow, dt, boxes_meet, hulls_at(book, w, hulls), team,
    )  # fmt: skip
    return 0


@part
def solve(
    book: Table, w: int, worlds: int, place: int, piece: int, many: int, h: float, substeps: int, fresh: int,
    one: Number, team: Crew, worker: int, rolls: Switch, laws: Switch, exact: Switch,
) -> int:  # fmt: skip
    """:func:`stiction.core.solve.passes.run_passes` over the blocks of a piece of so many worlds from w on, which have
    ``many`` manifolds."""
    _, kinds, table, _, profile, settings = rows_of(book, w)
    soft, desk = soft_of_all(book, w, worlds, place, one), desk_at(book)
    here = desk.pieces[piece]
    run_passes(
        members_from(soft, here[BLOCK]), desk.lists[MOVING, here[MOVER] :], desk.lists[GLIDE], desk.normals,
        desk.sizes[piece], here[BLOCKS], many, here[MOVERS], h, substeps, fresh, profile, rolls,
        laws_of(laws, kinds, table, soft), exact_of(exact, settings, scratch_at(book, w)), team, worker,
    )  # fmt: skip
    return 0


@part
def finish(book: Table, w: int, notes: Table, j: int, base: int, one: Number, laws: int) -> int:
    """The end of a step of a world, whose note is the j-th and whose lists on the desk begin at ``base``: move its
    bodies, let them pay for what contact has made, and let those sleep that are at rest; returns how many these are."""
    bodies, kinds, _, ledger, _, settings = rows_of(book, w)
    note, desk, scratch = notes[j], desk_at(book), scratch_at(book, w)
    soft, gravity, dt = soft_at(book, w, note[PLACE], one), gravity_of(settings), settings.dt
    awake, taking_part = scratch.bodies[AWAKE], note[TAKING_PART]
    active, contacts = desk.active[note[FROM] :], note[ACTIVE]
    mark, touched, touching = desk.lists[MARK, base:], desk.lists[TOUCHING, base:], note[TOUCH]
    tumbling, lively = finish_bodies(
        bodies, kinds, awake, taking_part, mark, soft.pose, soft.rows, soft.aux, gravity, dt, ledger
    )
    if tumbling > 0:
        give_to_tumblers(bodies, active, contacts, touched, touching, soft, gravity, laws)
        hold_tumblers(bodies, kinds, touched, touching, soft, gravity)
    group, h = desk.lists[GROUP], dt / note[SUBSTEPS]
    if lively:
        take_gains_back(bodies, kinds, active, contacts, touched, touching, group, soft, gravity, dt, h)
    unmark(mark, touched, touching)
    counts = scratch.counts
    counts[STEP] += 1
    if not settings.sleeping or counts[STEP] % PERIOD != 0:
        return 0
    slept = put_to_sleep(
        bodies, kinds, awake, taking_part, active, contacts, soft.manifolds, soft.pose, group, desk.lists[RESTLESS]
    )
    if slept > 0:
        counts[STALE] = 1
        # who meets them later sees them where they are now
        g = length(gravity)
        begin_bodies(bodies, kinds, awake, taking_part, soft.pose, soft.rows, soft.aux, gravity, g, dt, dt)
    return slept


@part
def impacts(book: Table, job: int, w: int, n: int, place: int, start: int, count: int, one: Number) -> int:
    """What bounces in a world: list it among the active manifolds, ``count`` from ``start`` on; or resolve ``count``
    impacts that were listed, or report them.

    Returns how many there are to resolve, which may exceed the room for them.
    """
    bodies, kinds, table, ledger, _, settings = rows_of(book, w)
    soft, gravity = soft_at(book, w, place, one), gravity_of(settings)
    contacts, tags, lists, report, wide = bounces_at(book, w)
    if job == COLLECT:
        active = desk_at(book).active[start:]
        return collect_impacts(
            bodies, active, count, soft.manifolds, soft.meta, soft.pose, contacts, tags, settings, length(gravity)
        )
    if job == BOUNCE:
        bounce(bodies, kinds, n, table, contacts, tags, count, lists, settings, ledger, report, gravity, wide)
    else:
        report_bounces(contacts, tags, count, soft.reports)
    return count


call_pairs, call_find, call_solve, call_finish, call_impacts = (
    caller(each) for each in (pairs, find, solve, finish, impacts)
)
