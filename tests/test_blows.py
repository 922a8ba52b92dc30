"""Bodies that fall in a row and do not bounce come to rest as they land; nothing is thrown by what stops another."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st
from stiction.bench.engines.with_stiction import Adapter
from stiction.bench.scenes import make

FALL = 2.0


def row_of_balls(number: int, ratio: float) -> tuple[st.World, list[st.Body]]:
    """Balls over a floor, each a little apart from the one below; the uppermost may be heavier."""
    world = st.World(sleeping=False)
    world.add(st.Plane(), static=True)
    masses = [10.0] * (number - 1) + [10.0 * ratio]
    return world, [
        world.add(st.Sphere(0.2), mass=mass, position=(0, 0, 0.2 + 0.4 * k + FALL + 0.01 * k))
        for k, mass in enumerate(masses)
    ]


@pytest.mark.parametrize("number", [1, 2, 3, 5])
@pytest.mark.parametrize("ratio", [1.0, 10.0])
def test_a_row_of_balls_does_not_come_back(number: int, ratio: float) -> None:
    """Two of them did with a quarter of their speed, and with two fifths under a heavy one."""
    world, balls = row_of_balls(number, ratio)
    landed, back, deep = False, 0.0, 0.0
    for _ in range(100):
        world.step()
        landed |= bool(balls[0].position[2] < 0.21)
        if landed:
            back = max(back, *(float(ball.velocity[2]) for ball in balls))
            deep = max(deep, 0.2 - float(balls[0].position[2]))
    assert landed
    assert back < 0.05 * math.sqrt(2.0 * 9.81 * FALL)
    assert deep < 0.015
    assert max(abs(float(ball.velocity[2])) for ball in balls) < 0.05


@pytest.mark.parametrize("number", [1, 2, 4])
@pytest.mark.parametrize("solver", ["soft", "exact"])
def test_what_strikes_a_row_goes_on_with_all_of_it(number: int, solver: str) -> None:
    """Without restitution all have the speed of the centre of mass in the end, and none had more on the way."""
    world = st.World(gravity=(0, 0, 0), solver=solver, sleeping=False)
    world.materials.set_pair("default", "default", static=0.0, dynamic=0.0)
    balls = [world.add(st.Sphere(0.2), mass=1.0, position=(0.4 * k, 0, 0)) for k in range(number)]
    balls.append(world.add(st.Sphere(0.2), mass=2.0, position=(-0.5, 0, 0), velocity=(3, 0, 0)))
    together = 6.0 / (2.0 + number)
    fastest = 0.0
    for _ in range(30):
        world.step()
        fastest = max(fastest, *(float(ball.velocity[0]) for ball in balls[:-1]))
        assert sum(ball.mass * ball.velocity[0] for ball in balls) == pytest.approx(6.0, rel=1e-6)
    np.testing.assert_allclose([ball.velocity[0] for ball in balls], together, rtol=0.06)
    assert fastest < 1.06 * together


def test_a_blow_is_in_the_reports() -> None:
    """The impulses of a step in which a ball lands are what it has changed its speed by, as Coulomb's law says."""
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.2, dynamic=0.2)
    world.add(st.Plane(), static=True)
    speed = 4.0
    ball = world.add(st.Sphere(0.2), mass=3.0, position=(0, 0, 0.2 + speed / 120), velocity=(9, 0, -speed))
    world.step()
    (contact,) = world.contacts()
    assert ball.velocity[2] == pytest.approx(0.0, abs=0.03)
    assert contact["normal_impulse"] == pytest.approx(3.0 * (ball.velocity[2] + speed + 9.81 * world.dt), rel=1e-5)
    np.testing.assert_allclose(contact["friction_impulse"], [3.0 * (ball.velocity[0] - 9.0), 0, 0], rtol=1e-5)
    assert 9.0 - ball.velocity[0] == pytest.approx(0.2 * (speed + 9.81 * world.dt), rel=1e-3)
    slip = 0.5 * (9.0 + ball.velocity[0] + 0.2 * ball.angular_velocity[1] * -1.0)
    assert world.energy().friction == pytest.approx(-contact["friction_impulse"][0] * slip, rel=0.01)


def test_heaps_hardly_ever_gain_energy_from_one_step_to_the_next(rng: np.random.Generator) -> None:
    """Never more than they began with; and of what they have lost they get back what springs give that push bodies out
    of each other that rest, or less."""
    rises = []
    for _ in range(20):
        adapter = Adapter()
        adapter.build(make("heap", 24, int(rng.integers(1 << 30))), 1 / 60)
        world = adapter.world
        world.step()
        start = low = world.energy().kinetic + world.energy().potential
        rise = 0.0
        for _ in range(150):
            world.step()
            now = world.energy().kinetic + world.energy().potential
            rise, low = max(rise, now - low), min(low, now)
            assert now <= start * (1.0 + 1e-9)
        rises.append(rise / start)
    assert max(rises) < 5e-4
    assert np.median(rises) < 1e-7
