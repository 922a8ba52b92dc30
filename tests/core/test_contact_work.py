"""Bodies that tumble: they gain no more than what touches them gives, and that they get."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.core.solve.depth import GENTLE

from .support import random_unit

ROD = (0.4, 0.02, 0.02)


def hit(spin: float, paddle: float, dt: float = 1.0 / 60.0, **more: float) -> tuple[st.World, st.Body]:
    """A rod that spins in space, and a plate that flies into it."""
    world = st.World(gravity=(0, 0, 0), dt=dt)
    world.materials.set_pair("default", "default", static=0.5, dynamic=0.4, restitution=0.0, **more)
    world.add(st.Box((2, 2, 0.1)), kinematic=True, position=(0, 0, -0.25), velocity=(0, 0, paddle))
    rod = world.add(st.Box(ROD), density=1000, velocity=(0, 0, -1), angular_velocity=(0, spin, 0))
    return world, rod


@pytest.mark.parametrize("spin", [0.0, 60.0, 200.0])
def test_what_tumbles_takes_up_the_speed_of_what_hits_it(spin: float) -> None:
    """A plate at 20 m/s carries the rod along, however that turned: m v^2 / 2 is more than it had, or less."""
    world, rod = hit(spin, 20.0)
    world.step(30)
    assert rod.velocity[2] == pytest.approx(20.0, rel=0.02)
    assert rod.kinetic_energy == pytest.approx(rod.mass * 20.0**2 / 2, rel=0.03)


@pytest.mark.parametrize("spin", [30.0, 60.0, 200.0, 1000.0])
def test_what_tumbles_gains_nothing_from_a_wall(spin: float) -> None:
    """In no step: turning by up to 17 rad in each, at one pair of arms."""
    world, rod = hit(spin, 0.0)
    before = rod.kinetic_energy
    for _ in range(40):
        world.step()
        assert rod.kinetic_energy <= before * (1.0 + 1e-6)
        before = rod.kinetic_energy


def test_two_that_tumble_have_no_more_together(rng: np.random.Generator) -> None:
    for _ in range(20):
        world = st.World(gravity=(0, 0, 0))
        world.materials.set_pair("default", "default", static=0.5, dynamic=0.4)
        for sign in (-1.0, 1.0):
            world.add(
                st.Box(ROD), density=10.0 ** rng.uniform(2, 5), position=(0, 0, 0.15 * sign),
                orientation=random_unit(rng, 4), velocity=(0, 0, -2 * sign), angular_velocity=100 * rng.normal(size=3),
            )  # fmt: skip
        start = world.energy().kinetic
        for _ in range(40):
            world.step()
            assert world.energy().kinetic <= start * (1.0 + 1e-6)


def test_a_belt_gives_what_tumbles_its_speed() -> None:
    """Its friction throws a thin wheel that turns by a radian in a step as far as one that does not."""
    ends = []
    for dt in (1.0 / 60.0, 1.0 / 960.0):
        world = st.World(dt=dt)
        world.materials.set_pair("default", "default", static=0.5, dynamic=0.4)
        world.add(st.Box((40, 2, 1)), static=True, position=(0, 0, -0.5), surface_velocity=(8.0, 0, 0))
        wheel = world.add(
            st.Cylinder(0.05, 0.02), density=1000, position=(0, 0, 0.05), orientation=(0.5**0.5, 0.5**0.5, 0, 0)
        )  # fmt: skip
        world.step(round(1.0 / dt))
        ends.append((*wheel.velocity, np.linalg.norm(wheel.angular_velocity)))
    # it slips until it rolls on the belt, with a third of its speed
    np.testing.assert_allclose(ends[1][0], 8.0 / 3.0, rtol=0.01)
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.02, atol=0.02)


def test_a_force_may_make_what_tumbles_faster() -> None:
    """Work of applied forces and torques counts, too."""
    world = st.World()
    world.materials.set_pair("default", "default", static=0.0, dynamic=0.0)
    world.add(st.Plane(), static=True)
    plate = world.add(st.Box((0.4, 0.3, 0.02)), density=1000, position=(0, 0, 0.01), angular_velocity=(0, 0, 40.0))
    inertia = plate.mass * (0.4**2 + 0.3**2) / 12
    for _ in range(60):
        plate.apply_torque((0, 0, 20.0 * inertia))
        world.step()
    assert plate.angular_velocity[2] == pytest.approx(60.0, rel=1e-3)


def sunk(world: st.World, speed: float) -> st.Body:
    """A box of a kilogram that begins 5 cm deep in what lies at z = 0, and slides."""
    return world.add(st.Box((0.4, 0.4, 0.2)), mass=1.0, position=(0, 0, 0.05), velocity=(speed, 0, 0))


def test_what_is_moved_up_pays_with_its_motion() -> None:
    """v^2 / 2 becomes g z: a box that slides is slower for what it rises, and the energy of the world does not."""
    world = st.World()
    world.materials.set_pair("default", "default", static=0.0, dynamic=0.0)
    world.add(st.Plane(), static=True)
    box = sunk(world, 3.0)
    before = world.energy()
    for _ in range(60):
        world.step()
        now = world.energy()
        # the springs of its contacts may push at GENTLE
        assert now.kinetic + now.potential <= before.kinetic + before.potential + 9.81 * GENTLE * world.dt
        before = now
    assert box.position[2] == pytest.approx(0.1, abs=1e-3), "it is out"
    assert box.velocity[0] == pytest.approx(np.sqrt(3.0**2 - 2 * 9.81 * (box.position[2] - 0.05)), rel=1e-3)


def test_what_touches_it_pays_where_it_has_no_motion_itself() -> None:
    """A ball that flies against a box as that is moved out of the floor flies on more slowly; alone, the box gains."""
    speeds = []
    for deep in (0.05, 0.0):
        world = st.World()
        world.materials.set_pair("default", "default", static=0.0, dynamic=0.0, restitution=1.0)
        world.add(st.Plane(), static=True)
        world.add(st.Box((0.4, 0.4, 0.2)), mass=1000.0, position=(0, 0, 0.1 - deep))
        ball = world.add(st.Sphere(0.05), mass=1000.0, position=(0, 0, 0.251 - deep), velocity=(4, 0, -2))
        start = world.energy().kinetic
        world.step(3)
        speeds.append(ball.velocity[0])
        assert world.energy().kinetic <= start
    assert speeds[1] == pytest.approx(4.0, rel=1e-6)
    assert speeds[0] < 3.95


def test_what_rests_is_moved_out_all_the_same() -> None:
    world = st.World()
    world.add(st.Plane(), static=True)
    box = sunk(world, 0.0)
    world.step(60)
    assert box.position[2] == pytest.approx(0.1, abs=1e-3)
    assert np.abs(box.velocity).max() < 1e-3


def test_a_lift_does_not_ask_what_it_carries_to_pay() -> None:
    """A kinematic platform gives what energy it takes."""
    world = st.World()
    world.materials.set_pair("default", "default", static=0.0, dynamic=0.0)
    world.add(st.Box((20, 2, 1)), kinematic=True, position=(0, 0, -0.5), velocity=(0, 0, 0.5))
    box = sunk(world, 3.0)
    world.step(30)
    assert box.velocity[0] == pytest.approx(3.0, rel=1e-6)
