"""Sensors: they see who overlaps them, and nobody notices them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stiction as st


def world_of(**more: Any) -> st.World:
    """Nothing bounces."""
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.5, dynamic=0.5)
    return st.World(materials=table, **more)


SHAPES: list[st.Shape] = [
    st.Sphere(0.5),
    st.Box((1, 1, 1)),
    st.Capsule(0.5, 1.0),
    st.Cylinder(0.5, 1.0),
    st.Ellipsoid((0.5, 0.3, 0.8)),
    st.ConvexHull([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]),
]
NAMES = ["sphere", "box", "capsule", "cylinder", "ellipsoid", "hull"]


@pytest.mark.parametrize("eye", [*SHAPES, st.Plane((1, 0, 0), -0.5)], ids=[*NAMES, "plane"])
@pytest.mark.parametrize("shape", SHAPES, ids=NAMES)
def test_a_sensor_sees_every_shape_exactly(eye: st.Shape, shape: st.Shape) -> None:
    """Along x all of them reach from -0.5 to 0.5, and the plane ends where its twin in the middle would."""
    world = world_of(gravity=(0, 0, 0))
    at = (0, 0, 0) if not isinstance(eye, st.Plane) else (1, 0, 0)
    sensor = world.add(eye, static=True, sensor=True, position=at)
    body = world.add(shape, position=(5, 0, 0))
    for x, seen in ((1 + 1e-6, False), (1 - 1e-6, True), (7, False), (0.0, True)):
        body.position = (x, 0, 0)
        assert world.overlaps(sensor) == ([body] if seen else [])


def test_a_sensor_neither_pushes_nor_is_pushed_nor_wakes() -> None:
    """A stack behaves bit for bit as without the sensors that it is in, and sleeps in them."""

    def run(sensors: bool) -> st.World:
        world = world_of()
        world.add(st.Plane(), static=True)
        for k in range(4):
            world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5 + k))
        world.add(st.Sphere(0.3), position=(-4, 5, 0.3), velocity=(9, 0, 0))
        if sensors:
            world.add(st.Box((3, 3, 3)), static=True, sensor=True, position=(0, 0, 1))
            world.add(st.Box((9, 12, 1)), kinematic=True, sensor=True, position=(-3, 0, 0.5), velocity=(0.1, 0, 0))
            world.add(st.Sphere(2), sensor=True, position=(0, 0, 9))
        world.step(400)
        return world

    plain, sensed = run(False), run(True)
    n = len(plain)
    np.testing.assert_array_equal(plain.positions, sensed.positions[:n])
    np.testing.assert_array_equal(plain.velocities, sensed.velocities[:n])
    assert [body.awake for body in plain] == [body.awake for body in sensed.bodies[:n]]
    assert not sensed["box 1"].awake
    assert "box 1" in [body.name for body in sensed.overlaps(sensed.bodies[n])]
    fallen = sensed.bodies[-1].position[2]
    assert fallen == pytest.approx(9 - 0.5 * 9.81 * (400 / 60) ** 2)
    assert all(not (sensed.bodies[i].sensor or sensed.bodies[j].sensor) for i, j in _pairs(sensed.contacts()))


def _pairs(rows: Any) -> list[tuple[int, int]]:
    return list(zip(rows["body_a"].tolist(), rows["body_b"].tolist(), strict=True))


def test_moving_or_removing_a_sensor_wakes_nobody() -> None:
    world = world_of()
    world.add(st.Plane(), static=True)
    box = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    sensor = world.add(st.Sphere(1), kinematic=True, sensor=True, position=(4, 0, 0.5))
    world.step(200)
    assert not box.awake
    assert world.overlaps(sensor) == []
    sensor.position = (1, 0, 0.5)
    assert world.overlaps(sensor) == [box]
    world.step(5)
    sensor.position = (0.5, 0, 0.5)
    world.step(5)
    assert not box.awake
    world.remove(sensor)
    world.step(5)
    assert not box.awake


def test_whom_a_sensor_sees() -> None:
    """Not another sensor, nobody of a foreign layer, and static bodies only if it is dynamic."""
    world = world_of(gravity=(0, 0, 0))
    dynamic = world.add(st.Sphere(1), sensor=True)
    kinematic = world.add(st.Sphere(1), sensor=True, kinematic=True)
    static = world.add(st.Sphere(1), sensor=True, static=True, mask=2)
    floor = world.add(st.Plane(), static=True, layer=3)
    lift = world.add(st.Box((1, 1, 1)), kinematic=True, layer=2)
    ball = world.add(st.Sphere(0.1), position=(0, 0, 0.5))
    assert world.overlaps(dynamic) == [floor, lift, ball]
    assert world.overlaps(kinematic) == [lift, ball]
    assert world.overlaps(static) == [lift]


def test_an_eye_a_million_metres_away_is_as_sharp() -> None:
    world = world_of(gravity=(0, 0, 0))
    at = np.array([1e6, -2e6, 3e6])
    sensor = world.add(st.Cylinder(0.5, 1.0), static=True, sensor=True, position=at)
    body = world.add(st.Capsule(0.5, 1.0), position=at + np.array([0.999999, 0, 0]))
    assert world.overlaps(sensor) == [body]
    body.position = at + np.array([1.000001, 0, 0])
    assert world.overlaps(sensor) == []


def test_bad_sensors() -> None:
    world = world_of()
    with pytest.raises(st.InvalidInputError, match=r"^sensor must be True or False, got 1.$"):
        world.add(st.Sphere(1), sensor=1)  # type: ignore[arg-type]  # that is the point
    assert len(world) == 0
    body = world.add(st.Sphere(1))
    assert not body.sensor
    with pytest.raises(
        st.InvalidInputError, match=r"^sensor must be a body added with sensor=True, got <Body 'sphere 0'"
    ):
        world.overlaps(body)
    with pytest.raises(st.InvalidInputError, match=r"^sensor must be a body of this world, got None.$"):
        world.overlaps(None)  # type: ignore[arg-type]  # that is the point
    with pytest.raises(
        st.NotYetError, match=r"^sensors are not there yet with solver 'micro'; solver 'soft' has them.$"
    ):
        st.World(solver="micro").add(st.Sphere(1), sensor=True)
