"""A case that cannot fail is worth nothing: change the physics by a per cent and the right cases must notice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction import verify
from stiction.shapes import MassProperties

Change = Callable[[pytest.MonkeyPatch], None]


def coefficients(**factors: float) -> Change:
    """Every pair of materials gets other coefficients than the case has asked for."""
    original = st.MaterialTable.set_pair

    def set_pair(self: st.MaterialTable, a: str, b: str, **given: Any) -> None:
        for name, factor in factors.items():
            if given.get(name):
                given[name] *= factor
        original(self, a, b, **given)

    return lambda patch: patch.setattr(st.MaterialTable, "set_pair", set_pair)


def gravity(factor: float) -> Change:
    """Every world has another gravity."""
    original = st.World.__init__

    def init(self: st.World, *, gravity: Any = (0.0, 0.0, -9.81), **given: Any) -> None:
        original(self, np.asarray(gravity) * factor, **given)

    return lambda patch: patch.setattr(st.World, "__init__", init)


def at_birth(**factors: float) -> Change:
    """Every body is added with another velocity, spin or mass."""
    original = st.World.add

    def add(self: st.World, shape: st.Shape, **given: Any) -> st.Body:
        for name, factor in factors.items():
            if given.get(name) is not None:
                given[name] = np.asarray(given[name]) * factor
        return original(self, shape, **given)

    return lambda patch: patch.setattr(st.World, "add", add)


def inertia(factor: float) -> Change:
    """Every ball, box, capsule and cylinder resists turning more."""

    def apply(patch: pytest.MonkeyPatch) -> None:
        for shape in (st.Box, st.Sphere, st.Capsule, st.Cylinder):
            original = vars(shape)["mass_properties"].func

            def other(self: st.Shape, original: Any = original) -> MassProperties:
                volume, center, tensor = (getattr(original(self), k) for k in ("volume", "center_of_mass", "inertia"))
                return MassProperties(volume, center, tensor * factor)

            patch.setattr(shape, "mass_properties", property(other))

    return apply


def damping(linear: float, angular: float) -> Change:
    """Every step keeps a little less (or more) than all of a velocity."""
    original = st.World.step

    def step(self: st.World, n: int = 1) -> None:
        for _ in range(n):
            original(self)
            self.velocities[:] *= linear
            self.angular_velocities[:] *= angular

    return lambda patch: patch.setattr(st.World, "step", step)


def drifting(speed: float) -> Change:
    """Every step leaves all bodies with a little more speed along x."""
    original = st.World.step

    def step(self: st.World, n: int = 1) -> None:
        for _ in range(n):
            original(self)
            self.velocities[1:, 0] += speed

    return lambda patch: patch.setattr(st.World, "step", step)


def forces(factor: float) -> Change:
    """Every force is stronger than the case has said."""
    original = st.Body.apply_force

    def apply_force(self: st.Body, force: Any, at: Any = None) -> None:
        original(self, np.asarray(force) * factor, at)

    return lambda patch: patch.setattr(st.Body, "apply_force", apply_force)


CASES = {case.name: case for case in verify.all_cases()}

CHANGES: dict[str, tuple[Change, str]] = {
    "mu 1 % more": (
        coefficients(static=1.01, dynamic=1.01),
        "stopping-distance thin-sheet spin-down-on-corners threshold-angle incline-sliding incline-sideways "
        "two-coefficients tip-or-slide ladder push-and-release pulled-block belt-drop belt-crossing crate-on-lorry "
        "accelerating-plate slide-to-roll backspin rolling-down oblique-impact billiard-throw "
        "slide-and-spin-of-a-face spin-down-of-a-face brake-distances wedge sliding-rod "
        "tyre-curve-brush tyre-curve-magic stribeck-stop",
    ),
    "mu 1 % less": (
        coefficients(static=0.99, dynamic=0.99),
        "stopping-distance threshold-angle two-coefficients tip-or-slide ladder push-and-release crate-on-lorry "
        "break-away creep-below-threshold break-away-with-torque wedge two-cards",
    ),
    "mu_d 1 % less": (
        coefficients(dynamic=0.99),
        "stopping-distance spin-down-on-corners incline-sliding two-coefficients push-and-release pulled-block "
        "belt-drop crate-on-lorry",
    ),
    "mu 5 % less": (coefficients(static=0.95, dynamic=0.95), "three-logs shaken-plate balls-on-a-box"),
    "mu_s 5 % more": (
        coefficients(static=1.05),
        "threshold-angle two-coefficients break-away stick-slip ladder pulled-block crate-on-lorry crate-on-turntable",
    ),
    "restitution 1 % less": (
        coefficients(restitution=0.99),
        "bouncing-ball oblique-impact two-bodies billiard-throw newtons-cradle rod-impact",
    ),
    "rolling resistance 1 % more": (coefficients(rolling=1.01), "rolling-resistance rolling-resistance-on-slope"),
    "rolling resistance 2 % more": (coefficients(rolling=1.02), "balance-on-an-edge"),
    "tangential restitution 1 % less": (coefficients(tangential_restitution=0.99), "superball"),
    "adhesion 2 % more": (coefficients(adhesion=1.02, adhesion_pressure=1.02), "pull-off"),
    "mu across the grain 1 % more": (coefficients(static_across=1.01, dynamic_across=1.01), "grain-on-slope"),
    "torsional resistance 1 % more": (coefficients(torsional=1.01), "torsional-resistance"),
    "gravity 1 % more": (gravity(1.01), "free-fall bouncing-ball push-to-tip rolling-resistance torsional-resistance"),
    "velocity 1 % more": (
        at_birth(velocity=1.01),
        "free-fall two-bodies rod-impact ball-on-turntable slide-to-roll-energy energy-ledger stopping-distance",
    ),
    "spin 1 % more": (at_birth(angular_velocity=1.01), "ball-on-turntable tumbling-period precession backspin"),
    "mass 1 % more": (at_birth(mass=1.01), "constant-force push-to-tip push-and-release belt-drop"),
    "inertia 1 % more": (
        inertia(1.01),
        "constant-force rod-impact oblique-impact slide-to-roll rolling-down spin-down-on-corners accelerating-plate "
        "follow-and-draw",
    ),
    "inertia 10 % more": (inertia(1.1), "disc-ends-together sliding-rod"),
    "velocities damped by 1e-4 a step": (
        damping(0.9999, 1.0),
        "free-fall momentum two-bodies newtons-cradle slow-roll",
    ),
    "spins damped by 1e-4 a step": (
        damping(1.0, 0.9999),
        "spinning-top tumbling-period precession torsional-resistance slide-to-roll-energy tippe-top rattleback",
    ),
    "energy of an impact grows by 1e-6": (damping(1.0 + 1e-6, 1.0 + 1e-6), "impact-energy"),
    "gravity 10 % more": (gravity(1.1), "sink-of-soft-contacts"),
    "everything keeps 2 mm/s": (
        drifting(2e-3),
        "tower-of-ten heavy-on-light crooked-tower pyramid heavy-on-top kapla-tower",
    ),
    "everything keeps 10 cm/s": (drifting(0.1), "arch"),
    "velocities damped by 1e-2 a step": (damping(0.99, 0.99), "domino-wave"),
    "forces 1 % more": (forces(1.01), "constant-force push-to-tip push-and-release pulled-block balls-on-a-box"),
}


@pytest.mark.parametrize(
    ("solver", "change", "name"),
    [
        (solver, change, name)
        for change, (_, names) in CHANGES.items()
        for name in names.split()
        for solver in CASES[name].solvers
        if solver not in CASES[name].known_limit
        # what never comes to rest costs the exact solver all its passes in every step of a minute, and shows no more
        if not (solver == "exact" and change.startswith("everything keeps"))
    ],
)
def test_a_small_change_of_the_physics_is_noticed(
    solver: str, change: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    CHANGES[change][0](monkeypatch)
    rows = verify.run([name], solver=solver, dt=1 / 240 if solver == "exact" else 1 / 60)
    assert any(not row.passed for row in rows)


def test_every_case_that_must_pass_is_seen_to_fail() -> None:
    seen = {name for _, names in CHANGES.values() for name in names.split()}
    must_pass = {case.name for case in verify.all_cases() if set(case.solvers) - case.known_limit.keys()}
    assert must_pass - seen == set()
