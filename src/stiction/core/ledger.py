"""The ledger of energy and the report of limits: what contacts took, drives gave and the integrator made."""

from __future__ import annotations

import math

from stiction.core.contact_rows import is_dynamic, relative_spin, slip, work_of_drives
from stiction.core.contact_space import contact_basis
from stiction.core.jit import jit
from stiction.core.state import (
    ACTIVE,
    BODY_A,
    BODY_B,
    CENTER,
    EDITS,
    FRICTION,
    FRICTION_WORK,
    IMPACTS,
    IMPULSE,
    INERTIA,
    INITIAL,
    LIMITS,
    MASS,
    MECHANICAL,
    NORMAL,
    ORIENTATION,
    POSITION,
    ROLLING_LOSS,
    START,
    STATUS,
    TOTAL,
    TOTAL_FRICTION,
    TWIST,
    VISITS,
    W_START,
    WORK,
    WORST,
    V,
    W,
)
from stiction.core.vec import dot, mat33, put_vec3, quat, rotation, transpose, vec3


@jit
def dissipation(bodies, contacts, tags, c):
    """Energy that one contact's impulse takes away, J: normal part, friction, and rolling resistance.

    An impulse g that changes the velocity from u0 to u1 while other impulses act with it does the work
    g . (u0 + u1) / 2: summed over all impulses of the step that is exactly the change of kinetic energy.
    """
    B = contact_basis(vec3(contacts, c, NORMAL))
    u0 = vec3(contacts, c, START)
    u1 = slip(bodies, V, W, contacts, tags, c, B)
    g = vec3(contacts, c, IMPULSE)
    normal = 0.5 * g.x * (u0.x + u1.x)
    friction = 0.5 * (g.y * (u0.y + u1.y) + g.z * (u0.z + u1.z))
    spin = relative_spin(bodies, W_START, tags, c) + relative_spin(bodies, W, tags, c)
    rolling = 0.5 * dot(B @ vec3(contacts, c, TWIST), spin)
    return normal, friction, rolling


@jit
def enter(bodies, contacts, tags, m, ledger):
    """Enter what the active contacts took, and what drives and belts gave; add the impulses to the step's total."""
    for c in range(m):
        if not tags[c, STATUS] & ACTIVE or contacts[c, IMPULSE] == 0.0:
            continue
        normal, friction, rolling = dissipation(bodies, contacts, tags, c)
        ledger[IMPACTS] += normal
        ledger[FRICTION] += friction
        ledger[ROLLING_LOSS] += rolling
        B = contact_basis(vec3(contacts, c, NORMAL))
        world = B @ vec3(contacts, c, IMPULSE)
        ledger[WORK] += work_of_drives(bodies, contacts, tags, c, world, B @ vec3(contacts, c, TWIST))
        contacts[c, TOTAL] += contacts[c, IMPULSE]
        friction_impulse = world - vec3(contacts, c, NORMAL) * contacts[c, IMPULSE]
        put_vec3(contacts, c, TOTAL_FRICTION, vec3(contacts, c, TOTAL_FRICTION) + friction_impulse)

        a, b = tags[c, BODY_A], tags[c, BODY_B]
        both = is_dynamic(bodies, a) and is_dynamic(bodies, b)
        for body in (a, b):
            if is_dynamic(bodies, body):
                bodies[body, FRICTION_WORK] += (friction + rolling) * (0.5 if both else 1.0)


@jit
def note(report, stage, visits, left, tolerance):
    """A limit that was hit is reported, with the error it left."""
    report[stage, VISITS] += visits
    if left > tolerance:
        report[stage, LIMITS] += 1
        report[stage, WORST] = max(report[stage, WORST], left)


@jit
def note_edits(bodies, n, gravity, ledger):
    """What bodies that were added, moved or pushed from outside since the last step changed, enters the ledger."""
    kinetic, potential = total_energy(bodies, n, gravity)
    if math.isnan(ledger[INITIAL]):
        ledger[INITIAL] = kinetic + potential
    else:
        change = kinetic + potential - ledger[MECHANICAL]
        if math.isfinite(change):
            ledger[EDITS] += change


@jit
def close_ledger(bodies, n, gravity, ledger):
    """Remember the mechanical energy with which a run of steps ends."""
    kinetic, potential = total_energy(bodies, n, gravity)
    if math.isfinite(kinetic + potential):
        ledger[MECHANICAL] = kinetic + potential


@jit
def total_energy(bodies, n, gravity):
    """Kinetic and potential energy of all dynamic bodies, J; heights are measured from the origin."""
    kinetic, potential = 0.0, 0.0
    for i in range(n):
        if is_dynamic(bodies, i):
            v = vec3(bodies, i, V)
            kinetic += 0.5 * bodies[i, MASS] * dot(v, v) + spin_energy(bodies, i)
            x = vec3(bodies, i, POSITION) + rotation(quat(bodies, i, ORIENTATION)) @ vec3(bodies, i, CENTER)
            potential -= bodies[i, MASS] * dot(gravity, x)
    return kinetic, potential


@jit
def spin_energy(bodies, i):
    """1/2 w . I w of a body, J."""
    return spin_energy_with(bodies, i, transpose(rotation(quat(bodies, i, ORIENTATION))) @ vec3(bodies, i, W))


@jit
def spin_energy_with(bodies, i, w):
    """The same with a spin w, in the body's axes."""
    return 0.5 * dot(w, mat33(bodies, i, INERTIA) @ w)
