"""Rays, boxes and balls: what a world finds where, whatever was moved, added or removed since the last step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import stiction as st

SOLVERS = ["soft", "micro"]
CUBE = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
SHAPES: list[tuple[str, st.Shape]] = [
    ("sphere", st.Sphere(0.5)),
    ("box", st.Box((1, 1, 1))),
    ("capsule", st.Capsule(0.5, 1.0)),
    ("cylinder", st.Cylinder(0.5, 1.0)),
    ("ellipsoid", st.Ellipsoid((0.5, 0.7, 4.0))),
    ("hull", st.ConvexHull(CUBE)),
    ("plane", st.Plane((-1, 0, 0), 0.5)),
]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("name", "shape"), SHAPES, ids=[name for name, _ in SHAPES])
def test_a_ray_hits_every_shape_where_it_begins(solver: str, name: str, shape: st.Shape) -> None:
    """They all begin at x = 9.5."""
    world = st.World(solver=solver)
    body = world.add(shape, static=name == "plane", position=(10, 0, 0), name=name)
    hit = world.ray_cast((2, 0, 0.1), (3, 0, 0))
    assert hit is not None
    assert hit.body is body
    up = {"sphere": 0.5, "ellipsoid": 4.0}.get(name, math.inf)
    rim = 0.5 - 0.5 * math.sqrt(1.0 - (0.1 / up) ** 2)
    assert hit.distance == pytest.approx(7.5 + rim)
    np.testing.assert_allclose(hit.point, (9.5 + rim, 0, 0.1), atol=1e-12)
    assert hit.normal[0] < -0.97
    assert world.ray_cast((2, 0, 0.1), (-1, 0, 0)) is None
    assert world.ray_cast((2, 0, 0.1), (1, 0, 0), 7.4) is None
    assert world.ray_cast((2, 0, 0.1), (1, 0, 0), 7.6) is not None


def row_of_balls(solver: str) -> tuple[st.World, list[st.Body]]:
    world = st.World(gravity=(0, 0, 0), solver=solver)
    return world, [world.add(st.Sphere(0.5), position=(3 * k, 0, 0), layer=1 << k) for k in range(40)]


@pytest.mark.parametrize("solver", SOLVERS)
def test_all_hits_come_nearest_first_however_many(solver: str) -> None:
    world, balls = row_of_balls(solver)
    hits = world.ray_cast((200, 0, 0), (-2, 0, 0), all=True)
    assert [hit.body for hit in hits] == balls[::-1]
    np.testing.assert_allclose([hit.distance for hit in hits], [199.5 - 3 * k for k in range(39, -1, -1)])
    assert [hit.body for hit in world.ray_cast((-2, 0, 0), (1, 0, 0), 5.0, all=True)] == balls[:2]
    assert [hit.body for hit in world.ray_cast((-2, 0, 0), (1, 0, 0), all=True, mask=0b1010)] == [balls[1], balls[3]]
    assert world.ray_cast((-2, 0, 0), (0, 0, 1), all=True) == []


@pytest.mark.parametrize("solver", SOLVERS)
def test_many_rays_hit_what_each_alone_would(rng: np.random.Generator, solver: str) -> None:
    world = st.World(solver=solver)
    world.add(st.Plane((0, 0, 1), -6), static=True)
    for _, shape in SHAPES[:5]:
        for _ in range(6):
            world.add(shape, position=rng.uniform(-4, 4, size=3), orientation=rng.normal(size=4))
    origins, ways = rng.normal(size=(60, 3)) * 6, rng.normal(size=(60, 3))
    found = world.ray_cast_many(origins, ways)
    misses = 0
    for k in range(60):
        hit = world.ray_cast(origins[k], ways[k])
        if hit is None:
            misses += 1
            assert found.body[k] == -1
            assert found.distance[k] == math.inf
            assert np.isnan(found.point[k]).all()
            assert np.isnan(found.normal[k]).all()
        else:
            assert found.body[k] == hit.body.index
            assert found.distance[k] == pytest.approx(hit.distance, rel=1e-12, abs=1e-12)
            np.testing.assert_allclose(found.point[k], hit.point, atol=1e-10)
            np.testing.assert_allclose(found.normal[k], hit.normal, atol=1e-10)
    assert 0 < misses < 55
    fan = world.ray_cast_many((0, 0, 30), ways)
    assert fan.body.shape == (60,)
    assert world.ray_cast_many(origins, (0, 0, -1)).point.shape == (60, 3)
    assert world.ray_cast_many((0, 0, 30), (0, 0, -1)).body.shape == (1,)
    assert world.ray_cast_many(np.zeros((0, 3)), np.zeros((0, 3))).body.shape == (0,)


@pytest.mark.parametrize("solver", SOLVERS)
def test_boxes_and_balls_find_what_overlaps_them(solver: str) -> None:
    world, balls = row_of_balls(solver)
    assert world.overlap_box((3, 0, 0), (4.99, 1, 1)) == [balls[1]]
    assert world.overlap_box((3, 0, 0), (5.01, 1, 1)) == balls[:3]
    assert world.overlap_sphere((3, 0, 0), 2.49) == [balls[1]]
    assert world.overlap_sphere((3, 0, 0), 2.51) == balls[:3]
    assert world.overlap_sphere((3, 0, 0), 2.51, mask=0b101) == [balls[0], balls[2]]
    assert world.overlap_box((3, 0, 0), (5.01, 1, 1), mask=0b010) == [balls[1]]
    # the corner of a box does not reach a ball that its bounds do
    assert world.overlap_box((0.9, 0.9, 0), (1, 1, 1)) == []


@pytest.mark.parametrize("solver", SOLVERS)
def test_questions_see_bodies_where_they_are_now(solver: str) -> None:
    """After steps, setters, writing into a view, adding, removing; static, kinematic and fast bodies too."""
    world = st.World(gravity=(0, 0, 0), solver=solver)

    def seen(x: float) -> list[str]:
        return [body.name for body in world.overlap_sphere((x, 0, 0), 0.1)]

    assert seen(0.0) == []
    assert world.ray_cast((0, 0, 0), (1, 0, 0)) is None
    a = world.add(st.Sphere(0.5), name="a", velocity=(60, 0, 0))
    world.add(st.Box((1, 1, 1)), name="wall", static=True, position=(-50, 0, 0))
    lift = world.add(st.Box((1, 1, 1)), name="lift", kinematic=True, position=(-40, 0, 0), velocity=(0, 60, 0))
    assert seen(0.0) == ["a"]
    assert seen(-50.0) == ["wall"]
    world.step(10)
    assert seen(0.0) == []
    assert seen(10.0) == ["a"]
    assert seen(-40.0) == []
    lift.position = (20, 0, 0)
    assert seen(20.0) == ["lift"]
    a.position = (30, 0, 0)
    assert seen(10.0) == []
    assert seen(30.0) == ["a"]
    world.positions[1] = (60, 0, 0)
    assert seen(60.0) == ["wall"]
    b = world.add(st.Sphere(0.5), name="b", position=(30, 0, 0))
    assert seen(30.0) == ["a", "b"]
    world.remove(a)
    assert seen(30.0) == ["b"]
    hit = world.ray_cast((25, 0, 0), (1, 0, 0))
    assert hit is not None
    assert hit.body is b
    world.step()
    assert seen(30.0) == ["b"]


def test_asking_changes_nothing_of_what_comes() -> None:
    """Bit for bit, also when bodies were moved and planes added before the questions."""

    def run(ask: bool) -> str:
        table = st.MaterialTable()
        table.set_pair("default", "default", static=0.5, dynamic=0.4)
        world = st.World(materials=table)
        for k in range(5):
            world.add(st.Box((1, 1, 1)), position=(0.1 * k, 0, 0.5 + k))
        ball = world.add(st.Sphere(0.4), position=(-4, 0, 0.4), velocity=(8, 0, 0))
        for k in range(40):
            if k == 0:
                world.add(st.Plane(), static=True)
            if k == 20:
                ball.position = (0, -3, 0.4)
            if ask:
                world.ray_cast((-9, 0, 1), (1, 0, 0), all=True)
                world.overlap_sphere((0, 0, 1), 1.0)
            world.step(2)
        return world.state_hash()

    assert run(True) == run(False)


def test_sleeping_bodies_are_found_and_sleep_on() -> None:
    world = st.World()
    world.add(st.Plane(), static=True, name="floor")
    box = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    world.step(200)
    assert not box.awake
    hit = world.ray_cast((0, 0, 9), (0, 0, -1))
    assert hit is not None
    assert hit.body is box
    assert world.overlap_box((0, 0, 0.5), (0.1, 0.1, 0.1)) == [box]
    world.step()
    assert not box.awake


@pytest.mark.parametrize("solver", SOLVERS)
def test_inside_a_body_the_distance_is_zero(solver: str) -> None:
    world = st.World(solver=solver)
    ball = world.add(st.Sphere(1))
    hit = world.ray_cast((0.2, 0, 0), (0, 2, 0))
    assert hit is not None
    assert (hit.body, hit.distance) == (ball, 0.0)
    np.testing.assert_allclose(hit.point, (0.2, 0, 0))
    np.testing.assert_allclose(hit.normal, (0, -1, 0))


def test_sensors_are_not_found() -> None:
    world = st.World()
    world.add(st.Sphere(1), static=True, sensor=True)
    assert world.ray_cast((-5, 0, 0), (1, 0, 0)) is None
    assert world.overlap_sphere((0, 0, 0), 1) == []


BAD: list[tuple[str, dict[str, Any], str]] = [
    ("ray_cast", {"origin": (0, 0)}, r"^origin must have shape \(3,\), got shape \(2,\)"),
    ("ray_cast", {"origin": (0, 0, math.nan)}, "^origin must be 3 finite numbers"),
    ("ray_cast", {"direction": (0, 0, 0)}, r"^direction must not be the zero vector, got \(0, 0, 0\).$"),
    ("ray_cast", {"max_distance": 0}, "^max_distance must be above 0 m, got 0.$"),
    ("ray_cast", {"max_distance": math.nan}, "^max_distance must be a finite number, got nan.$"),
    ("ray_cast", {"max_distance": -math.inf}, "^max_distance must be a finite number, got -inf.$"),
    ("ray_cast", {"all": 1}, "^all must be True or False, got 1.$"),
    ("ray_cast", {"mask": 1.5}, "^mask must be a whole number of 64 bits"),
    (
        "ray_cast_many",
        {"origins": np.zeros((2, 2))},
        r"^origins must have shape \(k, 3\) or \(3,\), got shape \(2, 2\)",
    ),
    ("ray_cast_many", {"origins": "here"}, r"^origins must be finite vectors, \(k, 3\), got 'here'.$"),
    ("ray_cast_many", {"origins": np.zeros((2, 3))}, "^origins and directions must be as many, got 2 origins and 3"),
    (
        "ray_cast_many",
        {"directions": np.eye(3) * (1, 0, 1)},
        "^directions must not hold the zero vector, .* in row 1.$",
    ),
    ("ray_cast_many", {"directions": np.full((3, 3), math.inf)}, "^directions must be finite, got "),
    ("overlap_box", {"size": (1, 0, 1)}, r"^size must be three lengths above 0 m, got \(1, 0, 1\).$"),
    ("overlap_box", {"center": "x"}, "^center must be 3 finite numbers"),
    ("overlap_sphere", {"radius": -1}, "^radius must be above 0 m, got -1.$"),
    ("overlap_sphere", {"mask": None}, "^mask must be a whole number of 64 bits"),
]
GOOD: dict[str, dict[str, Any]] = {
    "ray_cast": {"origin": (0, 0, 0), "direction": (1, 0, 0)},
    "ray_cast_many": {"origins": np.zeros((3, 3)), "directions": np.eye(3)},
    "overlap_box": {"center": (0, 0, 0), "size": (1, 1, 1)},
    "overlap_sphere": {"center": (0, 0, 0), "radius": 1},
}


@pytest.mark.parametrize(("question", "wrong", "sentence"), BAD)
def test_bad_questions(question: str, wrong: dict[str, Any], sentence: str) -> None:
    with pytest.raises(st.InvalidInputError, match=sentence):
        getattr(st.World(), question)(**{**GOOD[question], **wrong})


# --- where the time goes ----------------------------------------------------------------------------------------------


def test_a_profile_tells_milliseconds_of_each_stage() -> None:
    world = st.World()
    world.add(st.Plane(), static=True)
    world.add(st.Sphere(0.5), position=(0, 0, 0.5))
    stages = world.profile(20)
    assert world.steps == 20
    assert len(stages) > 5
    assert all(isinstance(name, str) and 0.0 <= ms < 1e3 for name, ms in stages.items())
    assert sum(stages.values()) > 0.0
    assert world.profile(1).keys() == stages.keys()
    with pytest.raises(st.InvalidInputError, match=r"^steps must be a whole number, 1 or more, got 0.$"):
        world.profile(0)
    with pytest.raises(st.NotYetError, match=r"^profile is not there yet with solver 'micro'; solver 'soft' has it.$"):
        st.World(solver="micro").profile(5)
