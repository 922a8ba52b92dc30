"""Stacks do not buckle: forces act where they would if no contact gave way."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st
from stiction.core import state
from stiction.core.collide.box_box import box_box
from stiction.core.vec import Quat, Vec3

from .support import compiled


def tower(n: int, noise: float = 0.0, seed: int = 0, **settings) -> st.World:
    """Cubes of 1 m upon each other, with offsets of ``noise`` (m, 1 sigma)."""
    rng = np.random.default_rng(seed)
    world = st.World(sleeping=False, **settings)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.6)
    world.add(st.Plane(), static=True)
    for k in range(n):
        x, y = rng.normal(0.0, noise, 2) if noise > 0.0 else (0.0, 0.0)
        world.add(st.Box((1, 1, 1)), mass=1000.0, position=(x, y, 0.5 + k))
    return world


def standing(world: st.World) -> np.ndarray:
    """For each body whether it stands."""
    return world._store.bodies[: len(world), state.STANDS] > 0.0


def leans(world: st.World) -> np.ndarray:
    """How far each body leans, rad."""
    return np.linalg.norm(world._store.bodies[: len(world), state.LEAN : state.LEAN + 3], axis=1)


@pytest.mark.parametrize("n", [30, 60])
def test_a_tall_tower_does_not_buckle(n):
    """With springs alone the weight bends every tower of more than 22: this of 30 goes 38 mm aside in 20 s."""
    world = tower(n)
    before = world.positions.copy()
    world.run(20.0)
    assert np.abs(world.positions - before)[:, :2].max() < 1e-4
    assert standing(world)[1:].all()


def test_a_crooked_tower_does_not_swing_up():
    """It sways about where it stands; what is lent to its contacts must not be taken back against the load."""
    world = tower(25, noise=0.005)
    before = world.positions.copy()
    widest = []
    for _ in range(4):
        widest.append(0.0)
        for _ in range(20):
            world.run(0.5)
            widest[-1] = max(widest[-1], float(np.abs(world.positions - before)[:, :2].max()))
    assert max(widest) < 0.03
    assert max(widest[2:]) < 1.1 * max(widest[:2])


def test_whole_worlds_that_are_turned_stand_alike():
    """Gravity may point anywhere; nothing stands where there is none."""
    world = st.World(sleeping=False, gravity=(9.81, 0, 0))
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.6)
    world.add(st.Plane((-1, 0, 0)), static=True)
    for k in range(4):
        world.add(st.Box((1, 1, 1)), position=(-0.5 - k, 0, 0))
    world.step(10)
    assert standing(world)[1:].all()
    world.gravity = (0, 0, 0)
    world.step(10)
    assert not standing(world)[2:].any()


def test_what_turns_does_not_stand():
    """What lies on a plate that turns does not lean; once the plate is still it stands."""
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.6)
    plate = world.add(st.Box((4, 4, 0.2)), kinematic=True, position=(0, 0, -0.1))
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    plate.angular_velocity = (0, 0.05, 0)
    world.step(30)
    assert not standing(world).any()
    assert leans(world).max() == 0.0
    plate.angular_velocity = (0, 0, 0)
    world.step(10)
    assert standing(world)[1]
    assert leans(world).max() < 1e-3  # it rocks once, back to where it was


def test_a_tower_that_topples_stands_no_more():
    """A tower of five that turns about its lower edge has forgotten all leans five steps later, and falls as a rod."""
    world = tower(5)
    world.step(30)
    assert standing(world)[1:].all()
    spin = 0.6
    for body in list(world)[1:]:
        x, _, z = body.position - np.array([0.5, 0, 0])
        body.velocity, body.angular_velocity = (spin * z, 0, -spin * x), (0, spin, 0)
    world.step(7)
    assert not standing(world)[1:].any()
    assert leans(world).max() == 0.0


def test_two_that_hold_each_other_in_the_air_do_not_stand():
    """A pile that falls stands on nothing, though its faces stick."""
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.6)
    for k in range(2):
        world.add(st.Box((1, 1, 1)), position=(0, 0, 100 + k))
    world.step(20)
    assert not standing(world).any()


def test_loads_are_those_of_rigid_bodies():
    """A weight beside the middle of a column tilts both; the load of the foot is where statics has it, to a micrometre.

    With the arms of what leans it is 34 um farther out.
    """
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.6)
    world.add(st.Plane(), static=True)
    world.add(st.Box((0.2, 0.2, 2.0)), mass=10.0, position=(0, 0, 1.0))
    world.step(60)
    world.add(st.Box((0.2, 0.2, 0.2)), mass=10.0, position=(0.03, 0, 2.1))
    world.run(10.0)
    assert standing(world)[1:].all()
    assert 1e-5 < leans(world)[1] < 1e-4
    contacts = world.contacts()
    foot = contacts[contacts["body_a"] == 0]
    place = float(foot["point"][:, 0] @ foot["normal_impulse"] / foot["normal_impulse"].sum())
    assert abs(place - 0.015) < 1e-6


@pytest.mark.parametrize(("lean", "hint", "points"), [(0.004, 1.0, 4), (0.004, 0.0, 1), (0.02, 1.0, 1)])
def test_boxes_that_lie_on_each_other_keep_their_patch(lean, hint, points):
    """A beam that lies across another one and leans by 4 mrad keeps the four corners that they share.

    One of them is where the two nearest edges cross; of boxes that had no patch before it is all that is found.
    """
    below, above = Vec3(0.1, 0.025, 0.05), Vec3(0.025, 0.1, 0.05)
    half = math.sqrt(0.5) * math.sin(0.5 * lean)
    turned = Quat(math.cos(0.5 * lean), -half, -half, 0.0)
    contacts, tags = state.make_contacts(16)
    found, _, _ = compiled(box_box)(
        contacts, tags, 0, 0, Vec3(0.0, 0.0, 0.0), Quat(1.0, 0.0, 0.0, 0.0), below, 1, Vec3(0.08, 0.08, 0.1), turned,
        above, 0.01, Vec3(0.0, 0.0, hint), np.zeros((state.SCRATCH, 5)),
    )  # fmt: skip
    assert found == points
