"""Fits of made-up data: they find what is there, their intervals hold it as often as they say, and they say what
cannot be known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from stiction.errors import InvalidInputError
from stiction.fit import Motion, Problem, Track, fit, parse_all
from stiction.fit.report import as_dict, draw, misfit
from stiction.fit.search import LOSSES, robust_total, weights
from stiction.scene import Scene

from .support import DYNAMIC, PAIR, STATIC, crate_scene, made_up, pulled_scene

TIMES = np.arange(0.0, 0.7, 0.05)
TRUTH = 0.33


class Tabulated(Problem):
    """A problem whose simulations are read off a table, so that a hundred fits take no longer than the table."""

    nodes = np.linspace(0.25, 0.41, 33)
    table: NDArray[np.float64]

    def simulate(self, x: object) -> list[Motion]:
        value = float(np.asarray(x)[0])
        k = min(int(np.searchsorted(self.nodes, value, side="right")) - 1, len(self.nodes) - 2)
        s = (value - self.nodes[k]) / (self.nodes[k + 1] - self.nodes[k])
        positions = (1.0 - s) * self.table[k] + s * self.table[k + 1]
        return [Motion(positions, np.tile([1.0, 0.0, 0.0, 0.0], (len(positions), 1)))]


@pytest.fixture(scope="module")
def tabulated() -> NDArray[np.float64]:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.25:0.41"], [TRUTH], TIMES, 0.0, 0)
    return np.array([problem.simulate([mu])[0].positions for mu in Tabulated.nodes])


def test_a_90_percent_interval_holds_the_truth_in_85_to_95_of_100(tabulated: NDArray[np.float64]) -> None:
    scene = crate_scene()
    parameters = parse_all([f"{DYNAMIC}=0.25:0.41"], scene.table)
    truth = tabulated[int(np.argmin(np.abs(Tabulated.nodes - TRUTH)))]
    rng = np.random.default_rng(20)
    held, widths = 0, []
    for _ in range(100):
        problem = Tabulated(scene, [Track("", TIMES, truth + 1e-3 * rng.normal(size=truth.shape))], parameters)
        problem.table = tabulated
        (found,) = fit(problem, starts=1).estimates
        held += found.low <= TRUTH <= found.high
        widths.append(found.high - found.low)
    assert 85 <= held <= 95
    assert np.mean(widths) < 0.02 * TRUTH, "an interval that holds everything would hold the truth too"


def test_push_and_release_gives_both_coefficients_within_one_percent() -> None:
    times = np.arange(0.0, 0.8, 0.01)
    problem = made_up(pulled_scene(), [f"{STATIC}=0.3:0.8", f"{DYNAMIC}=0.2:0.6"], [0.52, 0.37], times, 1e-3, 1)
    made = fit(problem, starts=3)
    static, dynamic = made.estimates
    assert static.value == pytest.approx(0.52, rel=0.01) and dynamic.value == pytest.approx(0.37, rel=0.01)
    assert static.low <= 0.52 <= static.high and dynamic.low <= 0.37 <= dynamic.high
    # when the crate lets go is known to a step, in which the pull grows by 0.3 N of 98 N
    assert static.high - static.low < 4.0 * 30.0 * 0.01 / (10.0 * 9.81)
    assert misfit(problem, made)["position"] == pytest.approx(1e-3, rel=0.1)


def test_a_pull_that_ends_too_early_tells_only_that_the_crate_held() -> None:
    scene = pulled_scene().to_dict()
    scene["pushes"][0]["until"] = 0.2  # 51 N of the 51.01 N that it would take
    times = np.arange(0.0, 0.8, 0.01)
    problem = made_up(Scene.from_dict(scene), [f"{STATIC}=0.4:0.8", f"{DYNAMIC}=0.2:0.6"], [0.52, 0.37], times, 1e-3, 1)
    made = fit(problem, starts=1)
    static, dynamic = made.estimates
    assert not static.seen and static.low == pytest.approx(0.52, abs=0.005) and static.high == 0.8
    assert not dynamic.seen and (dynamic.low, dynamic.high) == (0.2, 0.6)
    assert sum("do not see" in remark for remark in made.remarks) == 2


def test_static_friction_cannot_be_seen_in_a_pure_slide() -> None:
    problem = made_up(crate_scene(), [f"{STATIC}=0.5:1", f"{DYNAMIC}=0.2:0.45"], [0.6, 0.37], TIMES, 1e-3, 2)
    made = fit(problem, starts=1)
    static, dynamic = made.estimates
    assert not static.seen and (static.low, static.high) == (0.5, 1.0)
    assert dynamic.seen and dynamic.low <= 0.37 <= dynamic.high
    assert any("do not see wood-ground.static: from 0.5 to 1 nothing" in remark for remark in made.remarks)
    result = as_dict(problem, made, 0.9)
    assert [entry["seen"] for entry in result["parameters"]] == [False, True]


def test_what_one_parameter_does_another_can_undo() -> None:
    # the push is all that there is: twice the mass under twice the force moves alike, and friction goes with the mass
    scene = crate_scene(pushes=[{"body": "crate", "force": [20.0, 0.0, 0.0]}])
    free = ["bodies.crate.mass=5:20", "pushes[0].force[0]=10:40"]
    made = fit(made_up(scene, free, [10.0, 20.0], TIMES, 1e-3, 3), starts=1)
    assert not any(estimate.seen for estimate in made.estimates)
    assert any("only together" in remark for remark in made.remarks)


def test_outliers_move_a_robust_fit_less() -> None:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], TIMES, 1e-3, 4)
    problem.tracks[0].positions[8:10, 0] += 0.2
    plain, robust = fit(problem, starts=1), fit(problem, starts=1, loss="cauchy")
    assert abs(robust.x[0] - TRUTH) < 0.003 < abs(plain.x[0] - TRUTH)


@pytest.mark.parametrize("loss", LOSSES)
def test_weights_are_the_slopes_of_the_loss(loss: str) -> None:
    class Line:
        parameters = parse_all([DYNAMIC], crate_scene().table)

        def residuals(self, x: object) -> NDArray[np.float64]:
            return np.asarray(x, dtype=np.float64)

    from stiction.fit.search import Search

    total = robust_total(Search(Line()), loss, 2.0)
    for r in (0.3, 1.7, 5.0):
        slope = (total(np.array([r + 1e-6])) - total(np.array([r - 1e-6]))) / 2e-6
        assert slope == pytest.approx(2.0 * r * float(weights(loss, np.array([(r / 2.0) ** 2]))[0]), rel=1e-6)


def test_resampling_and_the_jacobian_agree() -> None:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], TIMES, 1e-3, 5)
    (a,), (b,) = fit(problem, starts=1).estimates, fit(problem, starts=1, bootstrap=60).estimates
    assert a.value == b.value and a.low != b.low
    assert 0.4 < (b.high - b.low) / (a.high - a.low) < 2.0


def test_a_scene_that_misses_something_is_told() -> None:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], np.arange(0.0, 0.7, 0.02), 1e-4, 6)
    problem.tracks[0].positions[:, 1] += 0.02 * np.sin(3.0 * problem.tracks[0].times)  # it drifts sideways
    made = fit(problem, starts=1)
    assert any("misses something" in remark for remark in made.remarks)


def test_ctrl_c_keeps_the_best_so_far() -> None:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], TIMES, 1e-3, 7)

    def press(state: object) -> None:
        if problem.simulations > 6:
            problem.simulations = -100  # once
            raise KeyboardInterrupt

    made = fit(problem, starts=1, on_progress=press)
    assert made.interrupted and 0.2 <= made.x[0] <= 0.5 and len(made.residuals) == problem.count


def test_the_same_seed_gives_the_same_bits() -> None:
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], TIMES, 1e-3, 8)
    first, second = (fit(problem, starts=1, bootstrap=3, seed=4) for _ in range(2))
    assert [e.as_dict() for e in first.estimates] == [e.as_dict() for e in second.estimates]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"starts": 0}, "starts must be a whole number, 1 or more, got 0."),
        ({"bootstrap": -1}, "bootstrap must be a whole number, 0 or more, got -1."),
        ({"loss": "hubert"}, "loss must be one of linear, soft_l1, huber, cauchy, got 'hubert'"),
        ({"level": 1.0}, "level must be above 0 and below 1, got 1.0."),
    ],
)
def test_options_are_checked(options: dict[str, object], sentence: str) -> None:
    problem = made_up(crate_scene(), [DYNAMIC], [TRUTH], TIMES, 1e-3, 9)
    with pytest.raises(InvalidInputError) as caught:
        fit(problem, **options)  # type: ignore[arg-type]  # wrong on purpose
    assert sentence in str(caught.value)


def test_the_figure_shows_a_column_a_body(tmp_path: object) -> None:
    from pathlib import Path

    problem = made_up(crate_scene(), [f"{PAIR}.dynamic=0.2:0.5"], [TRUTH], TIMES, 1e-3, 10)
    path = draw(problem, fit(problem, starts=1), Path(str(tmp_path)) / "left.png")
    assert path.stat().st_size > 20_000


@pytest.mark.filterwarnings("ignore")  # Optuna's own dependencies warn of one another
def test_trials_look_around_first() -> None:
    pytest.importorskip("optuna", reason="trials need Optuna, an extra")
    problem = made_up(crate_scene(), [f"{DYNAMIC}=0.2:0.5"], [TRUTH], TIMES, 1e-3, 11)
    phases = set()
    made = fit(problem, starts=1, trials=5, on_progress=lambda state: phases.add(state.phase))
    assert "trying (Optuna)" in phases and len(made.ends) == 2
    assert made.x[0] == pytest.approx(TRUTH, rel=0.01)
