"""One time step of the soft solver, as a table of contents."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction.core import soft_rows as s
from stiction.core.clock import lap, start_clock
from stiction.core.colouring import COLOURS, colour_manifolds, fill_blocks
from stiction.core.find import list_manifolds, update_manifolds
from stiction.core.friction.laws import laws_of
from stiction.core.integrate import first_not_finite, is_number, keep_body, restore_body
from stiction.core.jit import entry, jit
from stiction.core.ledger import note_edits, total_energy
from stiction.core.manifolds import EDITED_MOTION, clear_manifold, drive_work
from stiction.core.pairs import BEGUN, PAIR_A, PAIR_B, PAIRS, SLOT, is_sensed, touch_body, update_pairs
from stiction.core.sleep import PERIOD, put_to_sleep, wake_island
from stiction.core.soft_bodies import (
    FALLS,
    GLIDES,
    NO_GLIDE,
    ROLLS,
    begin_body,
    finish_contact,
    finish_free,
    free_is_finite,
    row_is_finite,
)
from stiction.core.solve.bounces import bounce, collect_impacts, report_bounces
from stiction.core.solve.exact import TALLY, exact_of
from stiction.core.solve.passes import run_passes
from stiction.core.solve.results import store_blocks
from stiction.core.solve.soft import NEAR, NOTHING_NEW, QUIET_NEW, SETTLING, SOME_NEW, UNEVEN
from stiction.core.state import (
    ASLEEP,
    CONTACT_WIDTH,
    DYNAMIC,
    EDITS,
    FORCE,
    FRICTION,
    IMPACTS,
    INITIAL,
    INVERSE_MASS,
    LAST,
    MECHANICAL,
    MOBILITY,
    NUMERICAL,
    POSITION,
    ROLLING_LOSS,
    SCRATCH,
    STATIC,
    TAGS_WIDTH,
    TORQUE,
    WORK,
    V,
)
from stiction.core.team import COUNT, FIND, HOME, JOB, MOVING_BODIES, SOLVE, SUBSTEPS, call, meet
from stiction.core.vec import Vec3, length, mat33, vec3

DONE, MORE_PAIRS, MORE_BLOCKS, BLOWN_UP, MORE_CONTACTS = range(5)
"""Why :func:`take_steps` returned."""

AWAKE, TOUCHING, MOVING, MARK, USED, GLIDE, EDITED, GROUP, RESTLESS, BODY_LISTS = range(10)
"""Rows of the lists of bodies: those awake; those in contact; those of them that move; marks; scratch; how they move;
those that were changed from outside; two more of scratch."""

UNDECIDED = -1

SLOW = 0.375
"""A new contact that slips by less than this part of what gravity gives in a step begins stuck."""

N_AWAKE, N_ACTIVE, N_EDITED, N_KNOWN, STALE, STEP, WATCHED, HARD, BLOCKS, COUNTS = range(10)
"""Entries of the counts: bodies awake, active manifolds, bodies changed from outside, bodies seen before; whether the
list of those awake is out of date; steps so far; whether bodies that sleep may have been changed without a word;
whether a light body carries a heavy one; blocks of the last
step."""


PAIR_CONTACTS = 8
"""Room for the contact points of one pair."""


class Scratch(NamedTuple):
    """Lists of the soft step for n bodies and p pairs."""

    bodies: np.ndarray  # (BODY_LISTS, n) int64
    active: np.ndarray  # (p, 4) int64: a, b, slot, colour of the manifolds with points
    normals: np.ndarray  # (n, 3) of the plane in which a body glides, or the acceleration with which it falls
    counts: np.ndarray  # (COUNTS + 2 (COLOURS + 1),) int64, then sizes and starts of the colours
    contacts: np.ndarray  # scratch of one pair
    tags: np.ndarray
    points: np.ndarray
    tally: np.ndarray  # (TALLY,) of the exact solver


def make_scratch(n: int, p: int, colours: int) -> Scratch:
    """Room for n bodies and p pairs."""
    scratch = Scratch(
        bodies=np.zeros((BODY_LISTS, n), np.int64),
        active=np.zeros((p, 4), np.int64),
        normals=np.zeros((n, 3)),
        counts=np.zeros(COUNTS + 2 * (colours + 1), np.int64),
        contacts=np.zeros((PAIR_CONTACTS, CONTACT_WIDTH)),
        tags=np.zeros((PAIR_CONTACTS, TAGS_WIDTH), np.int64),
        points=np.zeros((SCRATCH, 5)),
        tally=np.zeros(TALLY),
    )
    scratch.counts[STALE] = 1
    return scratch


@jit
def take_steps(
    steps, bodies, kinds, n, tree, cache, soft, scratch, table, settings, ledger, profile, boxes_meet, hulls, bounces,
    rolls, laws, exact, team,
):  # fmt: skip
    """Up to ``steps`` steps of n bodies. Returns (reason, steps done, a number that goes with the reason).

    When there is no room for a step's pairs, blocks or impacts it returns before that step has changed anything but the
    manifolds, which are found anew or kept when it is taken again, with the room that is needed; when a body would no
    longer be finite, with that body, and all bodies as they were before.
    ``laws``: 1 where a pair has more than constant coefficients, ``exact``: 1 with the exact solver; else None.
    ``team``: None, or the :class:`stiction.core.team.Team` whose other workers are in :func:`assist`.
    """
    gravity = Vec3(settings.gravity_x, settings.gravity_y, settings.gravity_z)
    g, dt = length(gravity), settings.dt
    lists, laws = scratch.bodies, laws_of(laws, kinds, table, soft)
    exact = exact_of(exact, settings, scratch)
    broken = first_not_finite(bodies, n)
    if broken >= 0:
        for i in range(n):
            if not is_number(bodies, i):
                restore_body(bodies, i)
        return BLOWN_UP, 0, broken
    note_edits(bodies, n, gravity, ledger)
    h = dt / settings.substeps
    take_edits(bodies, kinds, n, cache, soft.pose, soft.rows, soft.aux, lists, scratch.counts, gravity, g, dt, h)
    for done in range(steps):
        start_clock(profile)
        substeps = substeps_of(settings, scratch.counts, exact)
        h = dt / substeps
        active, woke = 0, True
        while woke:
            awake = list_awake(kinds, n, lists, scratch.counts)
            begin_bodies(bodies, kinds, lists[AWAKE], awake, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
            lap(profile, 0)
            pairs = update_pairs(tree, cache, bodies, kinds, lists[AWAKE], awake, dt)
            if pairs > cache.pairs.shape[0]:
                close_soft_ledger(bodies, n, gravity, ledger)
                keep_states(bodies, lists[AWAKE], awake)
                return MORE_PAIRS, done, pairs
            for k in range(cache.counts[BEGUN]):
                clear_manifold(soft.manifolds, soft.meta, soft.reports, cache.begun[k, SLOT] + 1)
            lap(profile, 1)
            call(team, FIND, pairs, 0, 0, SLOW * g * dt, dt)
            update_manifolds(
                bodies, kinds, cache.pairs, pairs, soft, scratch.active, scratch.contacts, scratch.tags, scratch.points,
                table, SLOW * g * dt, dt, boxes_meet, hulls, team,
            )  # fmt: skip
            meet(team)
            active, woke = list_manifolds(bodies, kinds, n, cache.pairs, pairs, scratch.active)
            scratch.counts[STALE] |= woke
            lap(profile, 2)
        scratch.counts[N_ACTIVE] = active
        hard = is_uneven(kinds, soft.aux, soft.meta, scratch.active, active)
        if hard != scratch.counts[HARD]:
            # at once: springs that change while they carry a load would throw it up
            scratch.counts[HARD] = hard
            substeps = substeps_of(settings, scratch.counts, exact)
            h = dt / substeps
            begin_bodies(bodies, kinds, lists[AWAKE], awake, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
        blocks = arrange_blocks(kinds, soft, scratch, active, n)
        scratch.counts[BLOCKS] = blocks
        if blocks * s.FIELDS > soft.blocks.shape[0]:
            close_soft_ledger(bodies, n, gravity, ledger)
            keep_states(bodies, lists[AWAKE], awake)
            return MORE_BLOCKS, done, blocks
        impacts = 0
        if bounces is not None:
            contacts, tags, impact_lists, report = bounces
            impacts = collect_impacts(
                bodies, scratch.active, active, soft.manifolds, soft.meta, soft.pose, contacts, tags, settings, g
            )
            if impacts > contacts.shape[0]:
                close_soft_ledger(bodies, n, gravity, ledger)
                keep_states(bodies, lists[AWAKE], awake)
                return MORE_CONTACTS, done, impacts
            if impacts > 0:
                bounce(
                    bodies, kinds, n, table, contacts, tags, impacts, impact_lists, settings, ledger, report, gravity
                )
                begin_bodies(bodies, kinds, lists[AWAKE], awake, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
        touching = list_touching(
            kinds, soft.manifolds, soft.meta, soft.pose, scratch.active, active, lists, scratch.normals
        )

        moving = list_moving(bodies, kinds, lists, scratch.normals, touching, gravity)
        lap(profile, 3)
        if blocks > 0:
            fresh = new_ones(soft.manifolds, scratch.active, active)
            call(team, SOLVE, blocks, moving, substeps, h, fresh)
            run_passes(
                soft, lists[MOVING], lists[GLIDE], scratch.normals, scratch.counts[COUNTS:], blocks, moving, h,
                substeps, fresh, profile, rolls, laws, exact, team, 0,
            )  # fmt: skip

        bad = first_bad_row(bodies, kinds, lists, awake, soft.rows, gravity, dt)
        if bad >= 0:
            for k in range(touching):
                lists[MARK, lists[TOUCHING, k]] = 0
            # the solver's rows of what does not move are not made anew in every step
            begin_bodies(bodies, kinds, lists[TOUCHING], touching, soft.pose, soft.rows, soft.aux, gravity, g, dt, h)
            for k in range(s.ROW_WIDTH):
                soft.rows[0, k] = 0.0
            drop_forces(bodies, lists[AWAKE], awake)
            close_soft_ledger(bodies, n, gravity, ledger)
            keep_states(bodies, lists[AWAKE], awake)
            return BLOWN_UP, done, bad
        store_blocks(
            bodies, soft.blocks, soft.members, blocks, soft.manifolds, soft.reports, h, dt / SETTLING, ledger, laws
        )
        ledger[WORK] += drive_work(
            bodies, kinds, scratch.active, active, soft.manifolds, soft.meta, soft.pose, soft.reports
        )
        if bounces is not None:
            contacts, tags, _, _ = bounces
            report_bounces(contacts, tags, impacts, soft.reports)
        lap(profile, 7)
        finish_bodies(bodies, kinds, lists, awake, touching, soft.pose, soft.rows, gravity, dt, ledger)
        scratch.counts[STEP] += 1
        if settings.sleeping and scratch.counts[STEP] % PERIOD == 0:
            scratch.counts[STALE] |= 0 < put_to_sleep(
                bodies, kinds, lists[AWAKE], awake, scratch.active, active, soft.manifolds, soft.pose, lists[GROUP],
                lists[RESTLESS],
            )  # fmt: skip
        lap(profile, 8)
    close_soft_ledger(bodies, n, gravity, ledger)
    keep_states(bodies, lists[AWAKE], scratch.counts[N_AWAKE])
    return DONE, steps, 0


@entry
def assist(
    bodies, kinds, pairs, soft, scratch, contacts, tags, points, table, boxes_meet, hulls, rolls, laws, team, worker
):  # fmt: skip
    """Do a worker's share of all jobs of the leader, who is in :func:`take_steps`, until the team goes home.

    ``contacts``, ``tags`` and ``points`` are the worker's own scratch; only the leader keeps a profile.
    """
    lists, words, numbers = scratch.bodies, team.words, team.numbers
    laws = laws_of(laws, kinds, table, soft)
    while True:
        meet(team)
        if words[JOB] == HOME:
            return
        if words[JOB] == FIND:
            update_manifolds(
                bodies, kinds, pairs, words[COUNT], soft, scratch.active, contacts, tags, points, table, numbers[0],
                numbers[1], boxes_meet, hulls, team,
            )  # fmt: skip
            meet(team)
        else:
            run_passes(
                soft, lists[MOVING], lists[GLIDE], scratch.normals, scratch.counts[COUNTS:], words[COUNT],
                words[MOVING_BODIES], numbers[0], words[SUBSTEPS], int(numbers[1]), words, rolls, laws, None, team,
                worker,
            )  # fmt: skip


@entry
def dismiss(team):
    """Send the workers of the team home."""
    call(team, HOME, 0, 0, 0, 0.0, 0.0)


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


@jit
def take_edits(bodies, kinds, n, cache, pose, rows, aux, lists, counts, gravity, g, dt, h):
    """Look at bodies that were added or changed from outside since the last call, and wake what they are part of.

    Where views of the state have been handed out, bodies are compared with what they were: those that sleep or never
    move, to wake, as do those that are pushed; others that are elsewhere now have their manifolds looked for anew.
    """
    for i in range(counts[N_KNOWN], n):
        lists[EDITED, counts[N_EDITED]] = i
        counts[N_EDITED] += 1
    counts[N_KNOWN] = n
    if counts[WATCHED]:
        for i in range(n):
            lists[RESTLESS, i] = 0
        for k in range(counts[N_EDITED]):
            lists[RESTLESS, lists[EDITED, k]] = 1
        for i in range(n):
            if lists[RESTLESS, i]:
                continue
            if kinds[i, MOBILITY] == STATIC or kinds[i, ASLEEP]:
                if was_changed(bodies, i) or (kinds[i, ASLEEP] and is_pushed(bodies, i)):
                    lists[EDITED, counts[N_EDITED]] = i
                    counts[N_EDITED] += 1
            elif was_moved(bodies, i):
                pose[i + 1, s.POSE_MOTION] += EDITED_MOTION
    if counts[N_EDITED] > 0:
        # whatever touches a body that was changed has to notice
        for i in range(n):
            lists[RESTLESS, i] = 0
        for k in range(counts[N_EDITED]):
            lists[RESTLESS, lists[EDITED, k]] = 1
            wake_island(bodies, kinds, n, lists[EDITED, k])
        for j in range(cache.counts[PAIRS]):
            a, b = cache.pairs[j, PAIR_A], cache.pairs[j, PAIR_B]
            if (lists[RESTLESS, a] or lists[RESTLESS, b]) and not is_sensed(kinds, a, b):
                wake_island(bodies, kinds, n, a)
                wake_island(bodies, kinds, n, b)
    for k in range(counts[N_EDITED]):
        i = lists[EDITED, k]
        pose[i + 1, s.POSE_MOTION] += EDITED_MOTION  # its manifolds are looked for anew
        begin_body(bodies, kinds, i, pose, rows, aux, gravity, g, dt, h)
        keep_body(bodies, i)
        touch_body(cache, i)
        counts[STALE] = 1
    counts[N_EDITED] = 0


@jit
def is_pushed(bodies, i):
    """Whether a force or torque was applied to body i for the coming step."""
    for c in range(3):
        if bodies[i, FORCE + c] != 0.0 or bodies[i, TORQUE + c] != 0.0:
            return True
    return False


@jit
def was_changed(bodies, i):
    """Whether position, orientation or velocities of body i are not those that were kept."""
    if was_moved(bodies, i):
        return True
    for c in range(6):
        if bodies[i, LAST + 7 + c] != bodies[i, V + c]:
            return True
    return False


@jit
def was_moved(bodies, i):
    """Whether position or orientation of body i are not those that were kept."""
    for c in range(7):
        if bodies[i, LAST + c] != bodies[i, POSITION + c]:
            return True
    return False


@jit
def list_awake(kinds, n, lists, counts):
    """List the bodies that take part: dynamic ones that do not sleep, and kinematic ones; returns their number."""
    if counts[STALE]:
        count = 0
        for i in range(n):
            if kinds[i, MOBILITY] != STATIC and not kinds[i, ASLEEP]:
                lists[AWAKE, count] = i
                count += 1
        counts[N_AWAKE] = count
        counts[STALE] = 0
    return counts[N_AWAKE]


@jit
def begin_bodies(bodies, kinds, awake, count, pose, rows, aux, gravity, g, dt, h):
    """Poses, bounds and solver rows of the bodies that are awake."""
    for k in range(count):
        begin_body(bodies, kinds, awake[k], pose, rows, aux, gravity, g, dt, h)


@jit
def arrange_blocks(kinds, soft, scratch, active, n):
    """Colour the active manifolds and put them into blocks of eight; returns the number of blocks."""
    counts = scratch.counts
    sizes, starts = counts[COUNTS : COUNTS + COLOURS + 1], counts[COUNTS + COLOURS + 1 :]
    blocks = colour_manifolds(scratch.active, active, kinds, scratch.bodies[USED], sizes)
    if 3 * blocks <= soft.members.shape[0] and blocks * s.FIELDS <= soft.blocks.shape[0]:
        fill_blocks(scratch.active, active, sizes, starts, soft.members, blocks)
    return blocks


@jit
def list_touching(kinds, manifolds, meta, pose, active, count, lists, normals):
    """List the bodies in contact, and decide which of them glide; returns their number."""
    touching = 0
    for k in range(count):
        row = active[k, 2] + 1
        load = manifolds[row, s.LOAD] + manifolds[row, s.LOAD + 1] + manifolds[row, s.LOAD + 2]
        counts = load + manifolds[row, s.LOAD + 3] > 0.0
        if manifolds[row, s.FRESH] > s.OLD:
            nearest = manifolds[row, s.GAP]
            for j in range(1, 4):
                nearest = min(nearest, manifolds[row, s.GAP + j])
            counts |= nearest < NEAR
        kind = NO_GLIDE
        n = Vec3(0.0, 0.0, 0.0)
        if meta[row, s.POINTS] == 1.0 or manifolds[row, s.STATE] == s.SLIDING:
            kind = ROLLS if meta[row, s.POINTS] == 1.0 else GLIDES
            n = mat33(pose, active[k, 0] + 1, s.POSE_ROTATION) @ vec3(manifolds, row, s.NORMAL_A)
        for side in range(2):
            i = active[k, side]
            if lists[MARK, i] == 0:
                lists[MARK, i] = 1
                lists[TOUCHING, touching] = i
                lists[GLIDE, i] = UNDECIDED
                touching += 1
            if not counts or kinds[i, MOBILITY] != DYNAMIC or lists[GLIDE, i] == NO_GLIDE:
                continue
            if lists[GLIDE, i] == UNDECIDED:
                normals[i, 0], normals[i, 1], normals[i, 2] = n.x, n.y, n.z
                lists[GLIDE, i] = kind
            elif (
                lists[GLIDE, i] != kind or abs(n.x * normals[i, 0] + n.y * normals[i, 1] + n.z * normals[i, 2]) < 0.999
            ):
                lists[GLIDE, i] = NO_GLIDE
    return touching


@jit
def substeps_of(settings, counts, exact):
    """How many substeps the next step takes."""
    return 2 * settings.substeps if counts[HARD] and exact is None else settings.substeps


@jit
def is_uneven(kinds, aux, meta, active, count):
    """1 if two movable bodies of very different mass lie on each other with a face, else 0."""
    for k in range(count):
        ma, mb = aux[active[k, 0] + 1, s.AUX_MASS], aux[active[k, 1] + 1, s.AUX_MASS]
        if ma > 0.0 and mb > 0.0 and (ma > UNEVEN * mb or mb > UNEVEN * ma):
            if meta[active[k, 2] + 1, s.POINTS] >= 3.0:
                return 1
    return 0


@jit
def list_moving(bodies, kinds, lists, normals, touching, gravity):
    """List those of the bodies in contact that move; returns their number. One that nothing holds yet falls."""
    moving = 0
    for k in range(touching):
        i = lists[TOUCHING, k]
        if lists[GLIDE, i] == UNDECIDED:
            lists[GLIDE, i] = NO_GLIDE
            if kinds[i, MOBILITY] == DYNAMIC:
                a = gravity + vec3(bodies, i, FORCE) * bodies[i, INVERSE_MASS]
                normals[i, 0], normals[i, 1], normals[i, 2] = a.x, a.y, a.z
                lists[GLIDE, i] = FALLS
        if kinds[i, MOBILITY] != STATIC:
            lists[MOVING, moving] = i
            moving += 1
    return moving


@jit
def new_ones(manifolds, active, count):
    """Which of the active manifolds are new in this step: none, some that move, or only quiet ones."""
    new = NOTHING_NEW
    for k in range(count):
        fresh = manifolds[active[k, 2] + 1, s.FRESH]
        if fresh == s.QUIET:
            new = QUIET_NEW
        elif fresh > s.OLD:
            return SOME_NEW
    return new


@jit
def first_bad_row(bodies, kinds, lists, awake, rows, gravity, dt):
    """A body whose new state would not be finite, or so large that its energy is not, or -1: nothing has been moved
    yet."""
    for k in range(awake):
        i = lists[AWAKE, k]
        if lists[MARK, i]:
            if not row_is_finite(rows, i + 1):
                return i
        elif not free_is_finite(bodies, kinds, i, gravity, dt):
            return i
    return -1


@jit
def drop_forces(bodies, awake, count):
    """What was applied for the step that failed is gone with it."""
    for k in range(count):
        for c in range(3):
            bodies[awake[k], FORCE + c] = 0.0
            bodies[awake[k], TORQUE + c] = 0.0


@jit
def keep_states(bodies, awake, count):
    """Remember the state of the bodies that are awake, to which a body goes back that is broken from outside."""
    for k in range(count):
        keep_body(bodies, awake[k])


@jit
def finish_bodies(bodies, kinds, lists, awake, touching, pose, rows, gravity, dt, ledger):
    """Move all bodies, those in contact as the solver says."""
    for k in range(awake):
        i = lists[AWAKE, k]
        if lists[MARK, i] and kinds[i, MOBILITY] == DYNAMIC:
            finish_contact(bodies, i, pose, rows, dt, ledger)
        else:
            finish_free(bodies, kinds, i, pose, gravity, dt, ledger)
    for k in range(touching):
        lists[MARK, lists[TOUCHING, k]] = 0
