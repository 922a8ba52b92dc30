"""Forces of all wheels of a vehicle on its chassis in one step, found together and implicitly.

Springs, tyres and brakes are stiff: a tyre that slips little is a damper of N stiffness / speed, which no explicit step
could follow. So forces are those that belong to the velocities at the *end* of the step, v' = v + dt M^-1 (J^T F + f),
for all wheels at once. Whatever dt is, that has no limit of stability, and where velocities stand still it is the law:

    spring     N = N_rest + k (compression at the end) + c (its rate at the end), and never below 0
    tyre       (F_f, F_s) = -(N / alpha) slip', alpha = |slip'| / mu(slip'), as in stiction.core.friction.laws
    wheel      I (w' - w) / dt = drive + brake - r F_f; the brake holds the wheel if it can, else it has its full torque

The equations are linear but for alpha, for which wheels are on the ground and for which are locked. These are found by
going round, from where the step before has left alpha. With the forces of a round, a tyre that slips so much that its
friction hardly grows any more takes a Newton step towards the slip that it would have alone, s + w N mu(s) = |slip
without its own force|, w being the inverse mass that it feels; below that the slip of the round serves. One that holds
goes towards mu(s) N = |its force|, so that wheels share by load what nothing else determines; and all together, where
they pull beyond what all can hold. Pairs without a tyre law have two coefficients:
found with the static one, those that slip let go, and it is found again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.core.friction.laws import BRUSH, COULOMB, SLOW_WHEEL, coefficient, tyre_coefficient
from stiction.core.state import DYNAMIC_MU, LAW, STATIC_MU

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ROUNDS = 60
"""Rounds in a step at most."""
DAMPED = 25
"""From this round on half of the change of alpha is taken: laws that fall steeply beyond their peak go to and fro."""
STEEPEST = -0.5
"""w N mu'(s) at least, where mu falls."""
LINEAR = 0.5
"""d ln mu / d ln s from which on mu / s hardly changes, so that the slip of a round serves the next one as it is."""
TOGETHER = 8.0
"""Power of the factor by which all wheels pull beyond what they can hold."""
ENOUGH = 1e-6
"""Of the largest force, change in a round that ends the rounds."""
STICKS = 1e-9
"""m/s, least slip, for alpha must not be zero."""
HOLDS, LETS_GO = 1e-6, 1e-5
"""m/s: where a pair has no tyre law but two coefficients, what slips less holds again, and what slips more lets go."""


@dataclass
class Wheels:
    """What the step asks of k wheels that may touch the ground.

    Attributes:
        J: (3 k, 6): for each wheel the rows of normal, forward and sideways direction, which take the velocity of the
            chassis (linear, angular) to that of its contact; their transpose takes forces to the chassis.
        hub: (2 k, 6): the same for forward and sideways velocity of the hubs.
        ground: (3 k,) m/s, velocity of the ground in these directions.
        push: (k,) N, force of the springs if nothing moved in the step.
        damping: (k,) N s/m, by how much that falls a speed of opening: c + k dt.
        spin: (k,) rad/s. radius: (k,) m. inertia: (k,) kg m^2, about the axle.
        drive: (k,) N m. brake: (k,) N m, the most that brakes can give.
        rows: (k, 2) rows of tyre and ground in the table of pairs.
    """

    J: Array
    hub: Array
    ground: Array
    push: Array
    damping: Array
    spin: Array
    radius: Array
    inertia: Array
    drive: Array
    brake: Array
    rows: NDArray[np.int64]


class Found(NamedTuple):
    """What came of it, of k wheels.

    Attributes:
        force: (k, 3) N on the chassis: normal, forward, sideways.
        slip: (k, 2) m/s that the tyres slip by at the end of the step.
        spin: (k,) rad/s, then.
        brake: (k,) N m, torque of the brakes on the wheels.
        speed: (k,) m/s of the hubs over the ground.
        alpha: (k,) m/s, slip over mu. sliding: (k,), for pairs without a tyre law.
    """

    force: Array
    slip: Array
    spin: Array
    brake: Array
    speed: Array
    alpha: Array
    sliding: Flags


def solve_wheels(
    wheels: Wheels, inverse_mass: Array, velocity: Array, dt: float, table: Array, alpha: Array, sliding: Flags
) -> Found:
    """The forces of one step.

    Args:
        wheels: k wheels, 1 or more.
        inverse_mass: (6, 6), of the chassis about its centre of mass, in world axes.
        velocity: (6,), that it would have at the end of the step without the wheels.
        dt: s.
        table: coefficients and laws of the pairs.
        alpha, sliding: (k,), as the step before has left them.
    """
    k = len(wheels.spin)
    n, f, s = 3 * np.arange(k), 3 * np.arange(k) + 1, 3 * np.arange(k) + 2
    A = dt * wheels.J @ inverse_mass @ wheels.J.T
    u0 = wheels.J @ velocity - wheels.ground
    r, gain = wheels.radius, dt / wheels.inertia
    alpha, sliding = alpha.copy(), sliding.copy()
    load = np.maximum(wheels.push, 1.0)
    on = wheels.push - wheels.damping * u0[n] > 0.0
    locked = (wheels.brake > 0.0) & (np.abs(wheels.spin) < 1e-12)
    brake = -np.sign(wheels.spin) * wheels.brake
    before: Array = np.full(3 * k, np.inf)
    F: Array = np.zeros(3 * k)
    spin, slip = wheels.spin, np.zeros((k, 2))
    speed: Array = np.zeros(k)
    over0 = wheels.hub @ velocity - np.delete(wheels.ground, n)
    to_hub = dt * wheels.hub @ inverse_mass @ wheels.J.T
    for turn in range(ROUNDS):
        S, b = A.copy(), -u0
        S[n, n] += 1.0 / wheels.damping
        b[n] += wheels.push / wheels.damping
        S[f, f] += alpha / load + np.where(locked, 0.0, r * r * gain)
        S[s, s] += alpha / load
        b[f] += np.where(locked, 0.0, r * (wheels.spin + gain * (wheels.drive + brake)))
        for off in np.flatnonzero(~on):
            rows = slice(3 * off, 3 * off + 3)
            S[rows], b[rows] = 0.0, 0.0
            S[rows, rows] = np.eye(3)
        F = np.asarray(np.linalg.solve(S, b), dtype=np.float64)
        u = u0 + A @ F

        # the ground does not pull, and takes up what comes down on it
        on = np.where(on, F[n] > 0.0, wheels.push - wheels.damping * u[n] > 0.0)
        load = np.maximum(F[n], 1e-3 * wheels.push.max() + 1e-9)
        wanted = -wheels.spin / gain - wheels.drive + r * F[f]  # what would stop the wheel
        spin = np.where(locked, 0.0, wheels.spin + gain * (wheels.drive + brake - r * F[f]))
        locked = (wheels.brake > 0.0) & np.where(locked, np.abs(wanted) <= wheels.brake, spin * brake >= 0.0)
        brake = np.where(locked, np.clip(wanted, -wheels.brake, wheels.brake), np.sign(wanted) * wheels.brake)
        slip[:, 0], slip[:, 1] = u[f] - r * spin, u[s]
        over = over0 + to_hub @ F
        speed = np.hypot(over[0::2], over[1::2])
        felt = 0.5 * (A[f, f] + A[s, s] + np.where(locked, 0.0, r * r * gain))
        free = np.hypot(slip[:, 0] - felt * F[f], slip[:, 1] - felt * F[s])
        slips, grip, used = np.hypot(slip[:, 0], slip[:, 1]), felt * load, np.hypot(F[f], F[s]) / load
        frictions = [
            _Friction(table, tyre, ground, float(speed[i]), bool(sliding[i]))
            for i, (tyre, ground) in enumerate(wheels.rows.tolist())
        ]
        holding = on & (slips < LETS_GO)
        most = sum(float(load[i]) * frictions[i].mu(max(float(slips[i]), STICKS)) for i in np.flatnonzero(holding))
        beyond = max(float((used * load)[holding].sum()) / most, 1.0) if most > 0.0 else 1.0
        for i, friction in enumerate(frictions):
            new = friction.alpha(float(slips[i]), float(free[i]), float(grip[i]), float(used[i]), beyond)
            alpha[i] = new if turn < DAMPED else 0.5 * (alpha[i] + new)
        if np.abs(F - before).max() <= ENOUGH * np.abs(F).max():
            go = ~sliding & (np.hypot(slip[:, 0], slip[:, 1]) > LETS_GO)
            if not go.any():
                break
            sliding |= go
            F = np.full(3 * k, np.inf)  # alpha is still that of the static coefficient
        before = F
    force = F.reshape(k, 3).copy()
    force[~on] = 0.0
    return Found(force, slip, spin, brake, speed, alpha, np.hypot(slip[:, 0], slip[:, 1]) > HOLDS)


class _Friction(NamedTuple):
    """The law of one tyre at the speed that its hub has."""

    table: Array
    tyre: int
    ground: int
    speed: float
    sliding: bool

    def mu(self, slip: float) -> float:
        """At a slip in m/s. A pair without a tyre law has its static coefficient until it lets go."""
        table, i, j = self.table, self.tyre, self.ground
        law = table[i, j, LAW] if table.shape[2] > LAW else COULOMB
        if law >= BRUSH:
            mu, _ = tyre_coefficient(table, i, j, slip / max(self.speed, SLOW_WHEEL))
            return float(mu)
        if not self.sliding:
            return float(table[i, j, STATIC_MU])
        return float(table[i, j, DYNAMIC_MU] if law == COULOMB else coefficient(table, i, j, slip))

    def alpha(self, slip: float, free: float, grip: float, used: float, beyond: float) -> float:
        """Slip over mu (m/s) for the next round.

        Args:
            slip: of this round, m/s. used: the coefficient that its force makes use of.
            free: slip without that force, m/s. grip: what friction takes from it for a mu of one, m/s.
            beyond: by what factor all wheels that hold pull beyond what they can, 1 if they do not.
        """
        slip = max(slip, STICKS)
        mu, step = self.mu(slip), 1e-4 * slip
        rise = (self.mu(slip + step) - mu) / step
        if slip < LETS_GO and mu > 0.0:
            # a step longer than this one would throw the load from wheel to wheel: each has what the others leave to it
            slip *= min(max(used / mu, 0.1), 10.0) * min(beyond**TOGETHER, 10.0)
        elif rise * slip < LINEAR * mu:
            slip -= (slip + grip * mu - free) / (1.0 + max(grip * rise, STEEPEST))
        slip = max(slip, STICKS)
        return slip / max(self.mu(slip), 1e-12)
