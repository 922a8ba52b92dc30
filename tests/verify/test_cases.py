"""Every closed form, at two time steps: what a solver should pass it passes; what it cannot has a size and a reason."""

from __future__ import annotations

import math
from typing import Any

import pytest

import stiction as st
from stiction import verify

SOLVER = "micro"
CASES = {case.name: case for case in verify.all_cases()}
LIMITS = {name: case for name, case in CASES.items() if SOLVER in case.known_limit}

LARGEST = {
    "creep-below-threshold": 2e-5,  # m/s
    "slide-and-spin": 0.2,  # m
    "spin-down-of-a-face": 0.75,  # s
    "tower-of-ten": 0.05,  # m/s and m
    "heavy-on-light": 0.01,  # m/s and m
}
"""How large the error of a known limit may become at dt = 1/60 s before somebody should ask why: about three times what
it is, so that a limit cannot quietly turn into a fault."""


@pytest.mark.parametrize("dt", [1 / 60, 1 / 240], ids=["60 Hz", "240 Hz"])
@pytest.mark.parametrize("name", sorted(CASES.keys() - LIMITS.keys()))
def test_a_case_passes(name: str, dt: float) -> None:
    rows = verify.run([name], solver=SOLVER, dt=dt)
    assert rows
    failed = [
        f"{row.what}: {row.measured:.9g}, not {row.expected:.9g} +- {row.tolerance:.2g} {row.unit}"
        for row in rows
        if not row.passed
    ]
    assert failed == []


@pytest.mark.parametrize("name", sorted(LIMITS))
def test_a_known_limit_is_measured_and_has_a_reason(name: str) -> None:
    rows = verify.run([name], solver=SOLVER)
    assert rows
    for row in rows:
        assert row.known_limit
        assert row.reason == LIMITS[name].known_limit[SOLVER]
        assert len(row.reason.split()) > 10, "a reason is a sentence"
        assert math.isfinite(row.measured)
        assert row.error < LARGEST[name]
        assert row.expected_failure == (None if row.passed else row.reason)
        assert row.surprise == row.passed


def test_more_visits_cure_heavy_on_light_as_its_reason_says(monkeypatch: pytest.MonkeyPatch) -> None:
    original = st.World.__init__

    def init(self: st.World, **given: Any) -> None:
        original(self, **given, iterations=10_000)

    monkeypatch.setattr(st.World, "__init__", init)
    assert all(row.surprise for row in verify.run(["heavy-on-light"], solver=SOLVER))


def test_every_known_limit_has_a_largest_size() -> None:
    assert LARGEST.keys() == LIMITS.keys()


def test_a_known_limit_is_one_of_this_solver_only() -> None:
    case = CASES["tower-of-ten"]
    row = case.judge(verify.Measurement("distance", 1.0, 0.5, 0.1, "m"), "another solver")
    assert not row.known_limit
    assert verify.summarise([row]) == (0, 1, 0, 0)


@pytest.mark.parametrize("name", sorted(CASES))
def test_a_case_says_what_it_is(name: str) -> None:
    case = CASES[name]
    assert name == name.lower()
    assert set(name) <= set("abcdefghijklmnopqrstuvwxyz-")
    for text in (case.title, case.formula, case.source, case.tolerance, case.tolerance_reason):
        assert text.strip() == text != ""
    assert type(case).__doc__
    assert type(case).measure.__doc__


def test_tolerances_are_tight() -> None:
    """No tolerance above 5 % of what it is about, but for angles on a grid and for sizes around zero."""
    loose = {}
    for name in sorted(CASES.keys() - LIMITS.keys() - {"precession", "spinning-top"}):
        for row in verify.run([name]):
            if row.expected != 0.0 and row.tolerance > 0.05 * abs(row.expected):
                loose[f"{name}: {row.what}"] = row.tolerance / abs(row.expected)
    assert loose == {}
