"""Which values the runs of a sweep have, and that an id says what a run is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

import stiction
from stiction.sweep import from_dict
from stiction.sweep.points import ENGINE

from .support import CRATE, spec

MASS = {"key": "bodies.crate.mass", "values": [1, 2, 3]}
SOBOL = [
    {"key": "bodies.crate.velocity[0]", "name": "vx", "sobol": [-1, 3]},
    {"key": "materials.pairs.crate-floor.static", "name": "mu", "logsobol": [0.1, 1.0]},
]


@pytest.mark.parametrize("scramble", [True, False])
def test_sobol_points_are_scipys(scramble: bool) -> None:
    points = from_dict(spec(parameters=SOBOL, samples=16, seed=7, scramble=scramble)).points
    unit = qmc.Sobol(2, scramble=scramble, rng=7).random(16)
    got = np.array([list(point.values.values()) for point in points])
    assert np.array_equal(got[:, 0], qmc.scale(unit[:, :1], -1, 3)[:, 0])
    assert np.allclose(np.log10(got[:, 1]), unit[:, 1] - 1.0, rtol=0, atol=1e-15)


def test_a_grid_is_multiplied_with_the_same_samples() -> None:
    points = from_dict(spec(parameters=[MASS, *SOBOL], samples=4)).points
    assert len(points) == 12
    assert [point.values["mass"] for point in points] == [1] * 4 + [2] * 4 + [3] * 4
    assert [point.values["mu"] for point in points][:4] == [point.values["mu"] for point in points][8:]
    assert [point.number for point in points] == list(range(12))


def test_another_random_parameter_leaves_the_first_as_it_was() -> None:
    one = {"key": "bodies.crate.velocity[0]", "name": "a", "uniform": [0, 1]}
    two = {"key": "bodies.crate.velocity[1]", "name": "b", "loguniform": [0.1, 1]}
    alone = from_dict(spec(parameters=[one], samples=5, seed=1)).points
    both = from_dict(spec(parameters=[two, one], samples=5, seed=1)).points
    assert [p.values["a"] for p in alone] == [p.values["a"] for p in both]
    assert all(0.1 <= p.values["b"] < 1.0 for p in both)
    other = from_dict(spec(parameters=[one], samples=5, seed=2)).points
    assert [p.values["a"] for p in alone] != [p.values["a"] for p in other]


def test_a_finer_grid_keeps_the_ids_of_the_runs_that_it_shares() -> None:
    def runs(count: int, **changes: object) -> set[str]:
        speed = {"key": "bodies.crate.velocity[0]", "name": "v", "linspace": [0, 1, count]}
        return {point.run for point in from_dict(spec(parameters=[speed], **changes)).points}

    assert len(runs(5)) == 5
    assert runs(3) < runs(5)
    assert runs(3) == runs(3, title="another title")
    for change in (
        {"duration": 0.25},
        {"every": 2},
        {"metrics": [{"name": "way", "value": "displacement('crate')"}]},
        {"scene": {**CRATE, "world": {"dt": 0.01}}},
        {"derived": [{"key": "bodies.crate.mass", "value": "1 + v"}]},
    ):
        assert not runs(3, **change) & runs(3), change


def test_the_files_of_the_engine_are_there() -> None:
    package = Path(stiction.__file__).parent
    assert [pattern for pattern in ENGINE if not list(package.glob(pattern))] == []


def test_every_point_of_a_large_sweep_is_made_when_it_is_asked_for() -> None:
    speed = {"key": "bodies.crate.velocity[0]", "name": "v", "linspace": [0, 1, 10_000]}
    side = {"key": "bodies.crate.velocity[1]", "name": "w", "linspace": [0, 1, 10_000]}
    points = from_dict(spec(parameters=[speed, side])).points
    assert len(points) == 10**8
    assert points[10**8 - 1].values == {"v": 1.0, "w": 1.0}
    assert points[12_345].values == {"v": pytest.approx(1 / 9999), "w": pytest.approx(2345 / 9999)}
    with pytest.raises(IndexError):
        points[10**8]
