"""Comparisons with other engines, some of them made up here: what is asked, how it is judged, told and drawn."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiction.bench.coefficients import RULES, combine, of_bodies
from stiction.bench.engines import Engine
from stiction.bench.scene import BenchBody, BenchScene, Gliding, ground
from stiction.errors import InvalidInputError
from stiction.shapes import Box, Sphere
from stiction.verify import against
from stiction.verify.against import COLUMNS, OWN, PEERS, Comparison, Reading, Score, Trial, all_trials, compare
from stiction.verify.against.page import page
from stiction.verify.against.plot import colour, deviations, figure, ink_on, save
from stiction.verify.against.report import cell, honours, markdown, reading, remarks, tolerance
from stiction.verify.against.trial import follow, stops
from stiction.verify.against.worker import ask_apart

DT = 1.0 / 60.0
TRIALS = {trial.name: trial for trial in all_trials()}
QUICK = ("hold-below-limit", "slide-to-roll", "rough-ball")


class Frictionless(Engine):
    """Bodies go on as they began, but for what pushes them; nothing is in their way."""

    name = module = distribution = "frictionless"
    bounces = False

    def _build(self, scene: BenchScene, dt: float) -> None:
        self.where = scene.positions.copy()
        self.speed = np.array([body.velocity for body in scene.bodies], dtype=np.float64)
        self.pushes = np.zeros_like(self.where)

    def _step(self) -> None:
        mass = np.array([(b.density or 1.0) * b.shape.mass_properties.volume for b in self.scene.bodies])
        moving = self.scene.dynamic[:, None]
        along = np.array([*self.scene.gravity[:2], 0.0])
        self.speed += np.where(moving, (along + self.pushes / mass[:, None]) * self.dt, 0.0)
        self.where += self.speed * self.dt

    def _push(self, index: int, force: Any) -> None:
        self.pushes[index] = force

    def _drive(self, index: int, position: Any, orientation: Any, velocity: Any, spin: Any) -> None:
        self.speed[index] = velocity

    def positions(self) -> Any:
        return self.where.copy()

    def orientations(self) -> Any:
        return self.scene.orientations.copy()

    def velocities(self) -> Any:
        return self.speed.copy()

    def angular_velocities(self) -> Any:
        return np.zeros_like(self.speed)


class Broken(Frictionless):
    name = "broken"

    def _step(self) -> None:
        raise RuntimeError("it fell apart")


@pytest.fixture(scope="module")
def own() -> Comparison:
    """stiction alone, in three trials."""
    return compare([], QUICK, isolated=False)


def with_others(comparison: Comparison) -> Comparison:
    """The same with two engines that are worse, in the places of others."""
    made = Comparison(comparison.trials, [OWN, "mujoco", "sapien"], {"pybullet": "pip install pybullet"}, DT, "soft")
    made.versions = dict.fromkeys(made.engines, "1.0")
    made.settings = dict.fromkeys(made.engines, "as they come")
    for trial in comparison.trials:
        made.scores[trial.name, OWN] = comparison.score(trial.name, OWN)
        for name, kind in (("mujoco", Frictionless), ("sapien", Broken)):
            score = trial.play(kind(), DT, 1)
            score.engine = name
            made.scores[trial.name, name] = score
    return made


def test_there_are_enough_trials_and_each_says_what_it_is() -> None:
    assert len(TRIALS) == len(all_trials()) >= 15
    for trial in all_trials():
        for text in (trial.title, trial.formula, trial.source, trial.unit, trial.tolerance_reason):
            assert text.strip() == text != ""
        assert trial.tolerance > 0.0
        assert type(trial).__doc__


@pytest.mark.parametrize("name", sorted(TRIALS))
def test_an_engine_without_friction_passes_no_trial_of_it(name: str) -> None:
    """A trial that cannot fail is worth nothing."""
    score = TRIALS[name].play(Frictionless(), DT, 1)
    if name in ("tower-of-ten", "heavy-on-light", "heavy-on-top", "card-house", "arch", "path-angle"):
        return  # nothing falls in this engine, and what is not braked goes straight
    assert score.passed is None or score.passed is False


@pytest.mark.parametrize("name", ["slide-to-roll", "push-and-release", "belt-drop", "balls-on-a-box"])
def test_stiction_is_asked_through_the_same_adapter(name: str) -> None:
    score = compare([], [name], isolated=False).score(name, OWN)
    assert score.skipped is None
    assert score.failed is None
    assert score.error < 0.02


def test_what_an_engine_cannot_express_is_said() -> None:
    reasons = {name: trial.play(Frictionless(), DT, 1).skipped for name, trial in TRIALS.items()}
    assert reasons["static-holds"] == "frictionless has one coefficient only"
    assert reasons["bouncing-ball"] == "frictionless has no coefficient of restitution"
    assert reasons["rolling-resistance"] == "frictionless has no rolling resistance"
    assert reasons["stopping-distance"] is None


def test_an_engine_that_breaks_down_has_failed() -> None:
    score = TRIALS["slide-to-roll"].play(Broken(), DT, 1)
    assert score.failed == "it fell apart"
    assert score.passed is False
    assert score.severity == 4.0


def test_the_worst_variant_counts_and_what_never_came_is_worst() -> None:
    assert Reading(1.0, (1.1, 0.8, 1.05)).worst == 0.8
    assert math.isnan(Reading(1.0, (5.0, math.nan)).worst)
    trial = TRIALS["stopping-distance"]
    assert trial.judge("x", Reading(2.0, (2.0, 1.98))).error == pytest.approx(0.01)
    never = trial.judge("x", Reading(2.0, (math.nan,)))
    assert never.passed is False
    assert cell(trial, never) == "never"


def test_severity_is_zero_on_the_edge() -> None:
    edge = Score("t", "e", 1.0, [1.01], 0.01, 0.01)
    assert edge.passed
    assert edge.severity == pytest.approx(0.0)
    assert Score("t", "e", 1.0, [1.0], 0.0, 0.01).severity == -4.0
    assert math.isnan(Score("t", "e", skipped="no").severity)


@pytest.mark.parametrize("rule", RULES)
def test_bodies_get_coefficients_that_make_those_of_pairs(rule: Any) -> None:
    floor = BenchBody(Box((1, 1, 1)), (0, 0, 0), density=None, surface="floor")
    box, ball = (BenchBody(Sphere(1.0), (0, 0, 0), surface=name) for name in ("box", "ball"))
    scene = BenchScene("pairs", (floor, box, ball), pairs=(("box", "floor", 0.4), ("ball", "box", 0.8)))
    a, b, c = of_bodies(scene, rule)
    assert min(a, b, c) >= 0.0
    assert combine(rule, a, b) == pytest.approx(0.4)
    assert combine(rule, b, c) == pytest.approx(0.8)
    alike = of_bodies(BenchScene("alike", (floor, box), friction=0.3), rule)
    assert combine(rule, *alike) == pytest.approx(0.3)


def test_pairs_that_no_rule_makes_are_refused() -> None:
    bodies = tuple(BenchBody(Sphere(1.0), (0, 0, 0), surface=name) for name in "abc")
    scene = BenchScene("odd", bodies, pairs=(("a", "b", 0.1), ("b", "c", 0.1), ("a", "c", 5.0)))
    with pytest.raises(InvalidInputError, match="no coefficients of bodies"):
        of_bodies(scene, "mean")


def test_forces_and_drives_reach_the_engine() -> None:
    belt = BenchBody(Box((9, 9, 1)), (0, 0, -0.5), density=None, kinematic=True)
    block = BenchBody(Box((1, 1, 1)), (0, 0, 0.5), density=2.0)
    push = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    scene = BenchScene("both", (belt, block), gliding=Gliding((1.0, 0.0, 0.0), (0.5, 0.0, 0.0)), force=lambda *_: push)
    track = follow(Frictionless(), scene, 1.0, 0.1, 4)
    assert len(track.positions) == 11
    assert track.moved(0)[0] == pytest.approx(1.25)
    assert track.velocities[-1, 1, 0] == pytest.approx(1.5)


def test_a_line_that_falls_stops_where_it_meets_zero() -> None:
    assert stops(np.array([1.0, 0.6, 0.2, 0.0]), 0.1) == pytest.approx(0.25)
    assert math.isnan(stops(np.array([1.0, 0.9, 0.8]), 0.1))


def test_columns_take_no_step_longer_than_their_own() -> None:
    assert set(COLUMNS) == {OWN, *PEERS}
    for name, column in COLUMNS.items():
        n = column.substeps(DT)
        assert DT / n <= column.kind.usual_dt * 1.001
        assert f"{1e3 * DT / n:.3g} ms" in column.settings(DT), name
    assert COLUMNS["mujoco"].kind.__name__ == "Pyramidal"
    assert COLUMNS["mujoco-elliptic"].kind.__name__ == "Adapter"


def test_a_missing_engine_is_named_and_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(COLUMNS["rapier3d"].kind, "module", "no_such_engine")
    found = compare(["rapier3d"], ["slide-to-roll"], isolated=False)
    assert found.engines == [OWN]
    assert found.missing == {"rapier3d": "pip install rapier3d"}
    assert "rapier3d: not installed (pip install rapier3d)" in remarks(found)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"engines": ["mujoko"]}, "did you mean 'mujoco'"),
        ({"engines": [], "names": ["slide-to-rol"]}, "did you mean 'slide-to-roll'"),
        ({"engines": [], "dt": 0.2}, "dt must be 0.05 s or less"),
    ],
)
def test_bad_input_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        compare(**given, isolated=False)


def test_one_engine_after_the_other_in_processes_of_their_own() -> None:
    scores = list(ask_apart(OWN, ["slide-to-roll"], DT))
    assert [score.trial for score in scores] == ["slide-to-roll"]
    assert scores[0].passed


def test_a_process_that_dies_takes_one_trial_with_it() -> None:
    scores = list(ask_apart("no-such-engine", ["slide-to-roll", "backspin"], DT))
    assert [score.trial for score in scores] == ["slide-to-roll", "backspin"]
    assert all(score.failed and "status" in score.failed for score in scores)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("peer", PEERS)
def test_peers_that_are_installed_answer(peer: str) -> None:
    if not COLUMNS[peer].kind.available():
        pytest.skip(f"{peer} is not installed")
    [score] = ask_apart(peer, ["slide-to-roll"], DT)
    assert score.failed is None
    assert score.error < 0.2, "5/7 of its speed, more or less"


def test_it_is_told_as_json_words_and_pages(own: Comparison) -> None:
    found = with_others(own)
    plain = json.loads(json.dumps(found.as_dict(), default=str))
    assert [trial["name"] for trial in plain["trials"]] == list(QUICK)
    assert found.passed(OWN) == (3, 3)
    assert found.passed("mujoco") < (3, 3), "there is something to fail"
    text = markdown(found)
    for trial in found.trials:
        assert f"### {trial.name}" in text
        assert trial.formula in text
    assert "**failed**" in text
    assert "stiction fails" not in " ".join(honours(found))
    worse = with_others(own)
    worse.scores[QUICK[1], OWN] = Score(QUICK[1], OWN, 1.0, [2.0], 1.0, 0.01)
    assert "stiction fails" in " ".join(honours(worse))
    made = page(found)
    assert made.startswith("<!doctype html>")
    assert "<script" not in made
    assert "src=" not in made
    assert "@import" not in made
    picture = made[made.index("<svg") : made.index("</svg>")]
    for trial in found.trials:
        assert trial.name in picture
        error = html.escape(cell(trial, found.score(trial.name, OWN)))
        assert error in made
        assert error not in picture, "errors are in the table above"


def test_cells_are_short(own: Comparison) -> None:
    trial, score = TRIALS["slide-to-roll"], own.score("slide-to-roll", OWN)
    assert cell(trial, score).endswith(" %")
    assert cell(trial, Score("t", "e", 1.0, [1.0], 1e-9, 0.01)) == "< 0.001 %"
    assert cell(trial, Score("t", "e", skipped="it has no balls")) == "–"
    assert reading(trial, Score("t", "e", skipped="no balls")) == "not expressible: no balls"
    assert tolerance(TRIALS["hold-below-limit"]) == "0.0167 mm/s"
    assert cell(TRIALS["hold-below-limit"], Score("t", "e", 0.0, [3e-8], 3e-8, 0.02)) == "3e-8 mm/s"


def test_pictures_are_drawn(own: Comparison, tmp_path: Path) -> None:
    found = with_others(own)
    assert len(figure(found).axes) == 2
    assert len(deviations(found).axes) == 1
    save(found, tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_colours_change_sides_at_the_tolerance() -> None:
    r, g, b = (int(colour(-3.0)[k : k + 2], 16) for k in (1, 3, 5))
    assert g > r and b > r, "green"
    r, g, b = (int(colour(3.0)[k : k + 2], 16) for k in (1, 3, 5))
    assert r > g and r > b, "red"
    assert colour(math.nan) == "#eef0f1"
    assert ink_on("#000000") == "#ffffff" != ink_on("#ffffff")


def test_the_names_of_the_package_are_there() -> None:
    assert set(against.__all__) <= set(vars(against))
    assert issubclass(type(all_trials()[0]), Trial)
    assert ground().density is None
