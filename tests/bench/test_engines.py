"""Each engine that is installed builds the same worlds, lets things fall as they must, and is judged alike."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stiction.bench import granular, make, rotations
from stiction.bench.engines import ENGINES, PEERS, Engine, engine_class
from stiction.bench.scene import BenchBody, BenchScene, ground
from stiction.bench.stability import judge
from stiction.errors import InvalidInputError
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Shape, Sphere

DT = 1.0 / 60.0

SHAPES: dict[str, Shape] = {
    "box": Box((0.4, 0.6, 0.8)),
    "sphere": Sphere(0.3),
    "capsule": Capsule(0.2, 0.6),
    "cylinder": Cylinder(0.3, 0.8),
    "ellipsoid": Ellipsoid((0.6, 0.5, 0.4)),
    "hull": ConvexHull([(x, y, z) for x in (-0.2, 0.2) for y in (-0.3, 0.3) for z in (-0.4, 0.4)]),
}


@pytest.fixture(params=ENGINES)
def engine(request: pytest.FixtureRequest) -> Engine:
    kind = engine_class(request.param)
    if not kind.available():
        pytest.skip(f"{request.param} is not installed")
    return kind()


def _run(engine: Engine, scene: BenchScene, seconds: float) -> None:
    engine.build(scene, DT)
    for _ in range(round(seconds / DT)):
        engine.before_step()
        engine.step()


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", SHAPES)
def test_a_body_falls_for_a_second_and_lands(engine: Engine, kind: str) -> None:
    """From 0.5 m, which takes 0.32 s; upright, so that its height says which way its axis points."""
    shape = SHAPES[kind]
    half = {"sphere": 0.3, "capsule": 0.5}.get(kind, 0.4)
    scene = BenchScene("fall", (ground(), BenchBody(shape, (0.2, 0.1, 0.5 + half))))
    reason = engine.supports(scene)
    if reason is not None:
        pytest.skip(reason)
    engine.build(scene, DT)
    assert engine.positions() == pytest.approx(scene.positions, abs=1e-6)
    for _ in range(10):
        engine.step()
    fallen = engine.positions()[1, 2] - scene.positions[1, 2]
    exact = -0.5 * 9.81 * (10 * DT) ** 2
    assert fallen == pytest.approx(exact, rel=0.12), "free fall, as first-order integrators have it"
    for _ in range(80):
        engine.step()
    assert engine.positions()[1] == pytest.approx((0.2, 0.1, half), abs=0.02)
    assert abs(engine.orientations()[1, 0]) > 0.99
    assert np.linalg.norm(engine.velocities()[1]) < 0.2
    end = judge(scene, engine.positions(), engine.orientations(), engine.velocities())
    assert end.lost == 0
    assert max(end.overlap or 0.0, end.ground_depth) < 0.02


@pytest.mark.filterwarnings("ignore")
def test_a_turned_body_keeps_its_orientation_and_velocities(engine: Engine) -> None:
    turn = rotations.about((0.0, 0.6, 0.8), 0.7)
    w, x, y, z = turn
    body = BenchBody(Box((0.4, 0.6, 0.8)), (0, 0, 9.0), (w, x, y, z), (1.0, -2.0, 0.5), (0.0, 0.0, 2.0))
    scene = BenchScene("free", (ground(), body), gravity=(0.0, 0.0, 0.0))
    engine.build(scene, DT)
    assert abs(engine.orientations()[1] @ turn) == pytest.approx(1.0, abs=1e-6)
    assert engine.velocities()[1] == pytest.approx((1.0, -2.0, 0.5), abs=1e-6)
    engine.step()
    assert engine.positions()[1] == pytest.approx((DT, -2.0 * DT, 9.0 + 0.5 * DT), abs=1e-4)
    after = rotations.product(rotations.about((0.0, 0.0, 1.0), 2.0 * DT), turn)
    assert abs(engine.orientations()[1] @ after) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.filterwarnings("ignore")
def test_friction_is_that_of_the_scene(engine: Engine) -> None:
    """A box at 3 m/s stops after v^2 / (2 mu g), whatever rule combines the coefficients of two bodies."""
    box = BenchBody(Box((1.0, 1.0, 0.4)), (0.0, 0.0, 0.2), velocity=(3.0, 0.0, 0.0))
    _run(engine, BenchScene("slide", (ground(), box), friction=0.4), 1.5)
    assert engine.positions()[1, 0] == pytest.approx(9.0 / (2.0 * 0.4 * 9.81), rel=0.05)


@pytest.mark.filterwarnings("ignore")
def test_a_small_pyramid_stands(engine: Engine) -> None:
    scene = make("pyramid", 6)
    _run(engine, scene, 1.0)
    end = judge(scene, engine.positions(), engine.orientations(), engine.velocities())
    assert end.stands
    assert end.out == 0
    assert end.drift is not None and end.drift < 0.05


@pytest.mark.filterwarnings("ignore")
def test_a_drum_carries_its_load_along(engine: Engine) -> None:
    scene = granular.drum(12)
    reason = engine.supports(scene)
    if reason is not None:
        assert "kinematic" in reason
        return
    _run(engine, scene, 1.5)
    where = engine.positions()
    for index, position, _ in scene.driven_at(1.5):
        assert where[index] == pytest.approx(position, abs=1e-3), "the ring is where it must be"
    end = judge(scene, where, engine.orientations(), engine.velocities())
    assert end.lost == 0
    turning = scene.turning
    assert turning is not None
    from_axis = (where[scene.dynamic] - np.array(turning.center))[:, [0, 2]]
    assert np.linalg.norm(from_axis, axis=1).max() < 2.0, "inside the ring"
    assert from_axis[:, 0].mean() < -0.2, "dragged to where the ring rises"


def test_a_missing_shape_is_a_reason_not_an_error() -> None:
    class Narrow(engine_class("robox3d")):  # type: ignore[misc]  # a base class found by name
        kinds = frozenset({"box"})

    assert Narrow().supports(make("spheres", 10)) == "robox3d has no sphere"
    assert Narrow().supports(make("pile", 10)) is None


def test_engines_are_found_by_name() -> None:
    assert set(PEERS) < set(ENGINES)
    assert engine_class("stiction").available()
    with pytest.raises(InvalidInputError, match="did you mean 'mujoco'"):
        engine_class("mujocoo")


def test_a_fallen_and_a_lost_body_are_counted() -> None:
    scene = make("tower", 3)
    positions, still = scene.positions.copy(), np.zeros((4, 3))
    assert judge(scene, positions, scene.orientations, still).stands
    positions[2, 0] += 0.3
    positions[3, 2] = math.nan
    end = judge(scene, positions, scene.orientations, still)
    assert (end.stands, end.out, end.lost) == (False, 2, 1)
    positions[3] = (0.0, 0.0, -5.0)
    assert judge(scene, positions, scene.orientations, still).lost == 1
