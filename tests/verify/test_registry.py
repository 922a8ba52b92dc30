"""How cases are run, judged, counted and written down."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator

import pytest

import stiction as st
from stiction import verify
from stiction.verify import registry

KEYS = {"case", "what", "formula", "expected", "measured", "error", "tolerance", "unit", "passed", "solver", "reason"}
ASKED_FOR = {"case", "formula", "expected", "measured", "error", "tolerance", "passed", "solver"}


def made(name: str, measurements: list[verify.Measurement], **limits: str) -> type[verify.Case]:
    """A case that yields given numbers."""

    class Made(verify.Case):
        title = formula = source = tolerance = tolerance_reason = "made for a test"
        known_limit = limits

        def measure(self, solver: str, dt: float) -> Iterator[verify.Measurement]:
            yield from measurements

    Made.name = name
    return Made


def test_names_are_unique_and_there_are_enough() -> None:
    names = [case.name for case in verify.all_cases()]
    assert len(names) == len(set(names)) >= 18


@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_rows_of_a_run_are_json(solver: str) -> None:
    rows = verify.run(["slide-to-roll", "free-fall"], solver=solver)
    plain = json.loads(json.dumps([row.as_dict() for row in rows], allow_nan=False))
    assert {row["case"] for row in plain} == {"slide-to-roll", "free-fall"}
    for row in plain:
        assert row.keys() == KEYS
        assert row.keys() >= ASKED_FOR
        assert row["passed"] is True
        assert row["solver"] == solver
        assert row["error"] == pytest.approx(abs(row["measured"] - row["expected"]), abs=1e-300)
        assert row["error"] <= row["tolerance"]


def test_what_never_happened_does_not_pass_and_is_null_in_json() -> None:
    case = made("never", [])()
    row = case.judge(verify.Measurement("time", 1.0, math.nan, 10.0, "s"), "micro")
    assert not row.passed
    assert row.as_dict()["measured"] is None
    assert row.as_dict()["error"] is None
    assert row.as_dict()["expected"] == 1.0


def test_a_relative_tolerance_becomes_absolute() -> None:
    row = made("relative", [])().judge(verify.Measurement("x", -200.0, -201.0, 0.01, "m", "relative"), "micro")
    assert (row.error, row.tolerance, row.passed) == (1.0, 2.0, True)


def test_progress_hears_of_each_case_before_it_runs() -> None:
    heard: list[str] = []
    verify.run(["backspin", "free-fall"], progress=heard.append)
    assert set(heard) == {"free-fall", "backspin"}
    order = [case.name for case in verify.all_cases()]
    assert heard == sorted(heard, key=order.index)


def test_a_name_given_twice_runs_once() -> None:
    assert len(verify.run(["billiard-throw", "billiard-throw"])) == len(verify.run(["billiard-throw"]))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"names": ["slide-to-rol"]}, "'slide-to-rol' (did you mean 'slide-to-roll'?)"),
        ({"names": ["free-fall", "Backspin"]}, "'Backspin' (did you mean 'backspin'?)"),
        ({"names": "free-fal"}, "'free-fal' (did you mean 'free-fall'?)"),
        ({"names": [], "dt": 0.0}, "dt must be above 0 s, got 0.0"),
        ({"names": [], "dt": math.nan}, "dt must be a finite number, got nan"),
        ({"names": [], "dt": 0.2}, "dt must be 0.05 s or less, got 0.2"),
        ({"names": ["pyramid"], "solver": "micro"}, "case 'pyramid' speaks of soft and exact only, got solver 'micro'"),
        ({"names": [], "solver": "mikro"}, "solver must be one of micro, soft, exact, got 'mikro'"),
    ],
)
def test_bad_input_is_one_sentence(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(st.InvalidInputError) as error:
        verify.run(**arguments)  # type: ignore[arg-type]  # wrong on purpose
    assert words in str(error.value)


def test_exact_is_verified_too() -> None:
    (row,) = [row for row in verify.run(["break-away"], solver="exact", dt=1 / 240) if "0.601" in row.what]
    assert row.passed


def test_known_limits_are_counted_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad = verify.Measurement("good", 1.0, 1.0, 0.1), verify.Measurement("bad", 1.0, 2.0, 0.1)
    cases = (made("plain", [good, bad, good]), made("limited", [bad, good], micro="it cannot"))
    monkeypatch.setattr(registry, "CASES", cases)
    rows = verify.run(solver="micro")
    assert verify.summarise(rows) == verify.Summary(passed=2, failed=1, known_limits=1, surprises=1)
    assert [row.expected_failure for row in rows] == [None, None, None, "it cannot", None]
    assert [row.surprise for row in rows] == [False, False, False, False, True]


def test_a_world_that_blows_up_is_a_row_that_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    class BlowsUp(made("blows-up", [])):  # type: ignore[misc]  # its base is made at run time
        def measure(self, solver: str, dt: float) -> Iterator[verify.Measurement]:
            yield verify.Measurement("before", 0.0, 0.0, 1.0)
            world = st.World(solver=solver, dt=dt)
            ball = world.add(st.Sphere(1.0), velocity=(1e308, 0, 0))
            ball.apply_force((1e308, 0, 0))
            world.step(10_000)
            yield verify.Measurement("after", 0.0, 0.0, 1.0)

    monkeypatch.setattr(registry, "CASES", (BlowsUp, made("next", [verify.Measurement("x", 0.0, 0.0, 1.0)])))
    rows = verify.run()
    assert [(row.case, row.what, row.passed) for row in rows] == [
        ("blows-up", "before", True),
        ("blows-up", "state", False),
        ("next", "x", True),
    ]
    assert "no longer finite" in str(rows[1].reason)


def test_an_iteration_limit_is_a_note_on_the_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    class Stops(made("stops", [])):  # type: ignore[misc]  # its base is made at run time
        def measure(self, solver: str, dt: float) -> Iterator[verify.Measurement]:
            world = st.World(solver=solver, dt=dt, iterations=1)
            world.add(st.Plane(), static=True)
            for k in range(9):
                world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5))
            world.step(10)
            yield verify.Measurement("x", 0.0, 0.0, 1.0)

    monkeypatch.setattr(registry, "CASES", (Stops,))
    (row,) = verify.run(solver="micro")
    assert row.passed
    assert row.expected_failure is None
    assert row.reason == "the solver hit its iteration limit in 1 of the worlds of this case"


@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_a_run_repeats_bit_by_bit(solver: str) -> None:
    names = ["stopping-distance", "rolling-down", "momentum"]
    first, second = (verify.run(names, solver=solver) for _ in range(2))
    assert first == second


def test_the_solver_is_that_of_a_world_nobody_sets_up() -> None:
    assert {row.solver for row in verify.run(["free-fall"])} == {st.World().solver}


def test_cases_that_do_not_speak_of_a_solver_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    zero = [verify.Measurement("x", 0.0, 0.0, 1.0)]
    one, other = made("one", zero), made("other", zero)
    other.solvers = ("micro",)
    monkeypatch.setattr(registry, "CASES", (one, other))
    assert [row.case for row in verify.run(solver="soft")] == ["one"]
    assert [row.case for row in verify.run(solver="micro")] == ["one", "other"]


def test_a_solver_may_have_a_tolerance_of_its_own() -> None:
    case = made("own", [])
    case.other_tolerance = {"soft": ("wide", "it is soft")}
    assert case().tolerance_of("soft") == ("wide", "it is soft")
    assert case().tolerance_of("micro") == (case.tolerance, case.tolerance_reason)
