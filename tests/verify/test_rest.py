"""Static means static: what rests does not move, for as long as one likes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st

HOUR = 216_000


def make_tower(solver, angle_deg=20.0):
    """Five flat boxes on a slope, none of which may sleep."""
    a = math.radians(angle_deg)
    world = st.World(solver=solver, sleeping=False)
    world.materials.set_pair("default", "default", static=0.5, dynamic=0.4)
    n = np.array([math.sin(a), 0.0, math.cos(a)])
    world.add(st.Plane(n), static=True)
    turned = (math.cos(a / 2), 0, math.sin(a / 2), 0)
    tower = [
        world.add(st.Box((1, 1, 0.25)), position=n * (0.125 + 0.25 * k), orientation=turned) for k in range(5)
    ]  # fmt: skip
    return world, tower


@pytest.mark.parametrize(("solver", "steps"), [("soft", HOUR), ("exact", HOUR // 6)])
def test_tower_on_a_slope_stays_where_it_was_put(solver, steps):
    world, tower = make_tower(solver)
    places, turns = [body.position for body in tower], [body.orientation for body in tower]
    world.step(steps)
    for body, place, turn in zip(tower, places, turns, strict=True):
        assert np.linalg.norm(body.position - place) < 1e-6
        assert np.linalg.norm(body.orientation - turn) < 1e-6


def test_crate_on_a_tilting_and_shaking_plate_comes_back():
    """A plate that tilts by 0.3 rad and shakes carries its crate along, to micrometres."""
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.5)
    plate = world.add(st.Box((4, 4, 0.2)), kinematic=True, position=(0, 0, -0.1))
    crate = world.add(st.Box((0.5, 0.5, 0.3)), position=(0, 0, 0.15))
    world.step(10)
    start = crate.position - plate.position
    for k in range(1200):
        t = k * world.dt
        plate.angular_velocity = (0, 0.3 * 2 * math.pi / 10.0 * math.cos(2 * math.pi * t / 10.0), 0)
        plate.velocity = (0.05 * math.sin(2 * math.pi * 3.0 * t), 0, 0)
        world.step()
    plate.angular_velocity = plate.velocity = (0, 0, 0)
    world.step(120)
    w, _, y, _ = plate.orientation
    turned = 2.0 * math.atan2(y, w)
    d = crate.position - plate.position
    c, s = math.cos(turned), math.sin(turned)
    local = np.array([c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]])
    assert np.linalg.norm((local - start)[:2]) < 2e-4


@pytest.mark.parametrize("solver", ["soft", "exact"])
@pytest.mark.parametrize("share", [0.995, 1.005])
def test_crate_lets_go_at_the_right_force(solver, share):
    """After a minute at rest, pulled slowly."""
    world = st.World(solver=solver, sleeping=False)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.4)
    world.add(st.Plane(), static=True)
    crate = world.add(st.Box((1, 1, 0.3)), mass=100.0, position=(0, 0, 0.15))
    world.step(3600)
    limit = 0.6 * 100.0 * 9.81
    for k in range(240):
        crate.apply_force((share * limit * min(k / 120.0, 1.0), 0, 0), at=crate.position - (0, 0, 0.15))
        world.step()
    assert (crate.position[0] < 1e-5) == (share < 1.0)
