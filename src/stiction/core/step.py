"""One time step, as a table of contents; the entry kernels that Python calls."""

from __future__ import annotations

from stiction.core.broadphase import find_pairs, update_bounds
from stiction.core.collide.narrow import find_contacts
from stiction.core.contact_rows import prepare_bodies, prepare_contacts
from stiction.core.integrate import (
    apply_forces,
    choose_mean,
    first_not_finite,
    is_number,
    keep_state,
    move,
    push_out,
    restore_body,
    restore_state,
)
from stiction.core.jit import entry
from stiction.core.ledger import close_ledger, note_edits, total_energy
from stiction.core.solve.impacts import resolve_impacts
from stiction.core.solve.penetrations import resolve_penetrations
from stiction.core.solve.resting import resolve_resting
from stiction.core.vec import Vec3, length

DONE, MORE_PAIRS, MORE_CONTACTS, BLOWN_UP = 0, 1, 2, 3
"""Why :func:`step` returned."""


@entry
def step(
    steps, bodies, kinds, n, contacts, tags, lists, table, settings, ledger, report, boxes_meet, extras, hulls
):  # fmt: skip
    """Up to ``steps`` steps of n bodies. Returns (reason, steps done, a number that goes with the reason, contacts).

    ``boxes_meet`` and ``extras`` are None in worlds where no two boxes can meet, and where nothing bounces and friction
    is not literal; ``hulls``, the table of the convex hulls, is None in worlds of spheres, boxes and planes only: those
    branches are then never compiled.

    When there is no room for a step's pairs or contacts it returns before that step has changed anything, with the room
    that is needed; when a body's state is no longer finite, with that body, all bodies back at their last finite state.
    """
    gravity = Vec3(settings.gravity_x, settings.gravity_y, settings.gravity_z)
    g, dt = length(gravity), settings.dt
    order, pairs, first, touching, tree, group, gain, last_ledger, last_report, points = lists
    m = 0
    broken = first_not_finite(bodies, n)
    if broken >= 0:
        for i in range(n):
            if not is_number(bodies, i):
                restore_body(bodies, i)
        return BLOWN_UP, 0, broken, m
    note_edits(bodies, n, gravity, ledger)
    for done in range(steps):
        keep_state(bodies, n, ledger, last_ledger, report, last_report)

        update_bounds(bodies, kinds, n, g, dt)
        meeting = find_pairs(bodies, kinds, n, order, pairs)
        if meeting > pairs.shape[0]:
            close_ledger(bodies, n, gravity, ledger)
            return MORE_PAIRS, done, meeting, m
        found = find_contacts(bodies, kinds, pairs, meeting, contacts, tags, g, dt, points, boxes_meet, hulls)
        if found > contacts.shape[0]:
            close_ledger(bodies, n, gravity, ledger)
            return MORE_CONTACTS, done, found, 0
        m = found

        # twice where penetrations had to be pushed out: a push moves and turns bodies
        for pushed in (False, True):
            prepare_bodies(bodies, n)
            prepare_contacts(bodies, kinds, table, contacts, tags, m, first, touching, n)
            if pushed or not resolve_penetrations(
                bodies, n, contacts, tags, m, first, touching, tree, report, settings.iterations
            ):
                break
            push_out(bodies, n, gravity, ledger)
        if extras is not None:
            resolve_impacts(
                bodies, n, contacts, tags, m, first, touching, tree, group, gain, settings, ledger, report, gravity
            )
        apply_forces(bodies, n, gravity, dt)
        resolve_resting(bodies, contacts, tags, m, first, touching, tree, settings, ledger, report, extras)
        choose_mean(bodies, n, contacts, tags, m, dt)
        move(bodies, kinds, n, gravity, dt, ledger)

        bad = first_not_finite(bodies, n)
        if bad >= 0:
            restore_state(bodies, n, ledger, last_ledger, report, last_report)
            close_ledger(bodies, n, gravity, ledger)
            return BLOWN_UP, done, bad, m
    keep_state(bodies, n, ledger, last_ledger, report, last_report)
    close_ledger(bodies, n, gravity, ledger)
    return DONE, steps, 0, m


@entry
def energy(bodies, n, gravity_x, gravity_y, gravity_z):
    """Kinetic and potential energy of the first n bodies, J."""
    return total_energy(bodies, n, Vec3(gravity_x, gravity_y, gravity_z))
