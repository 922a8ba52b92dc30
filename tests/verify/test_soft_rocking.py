"""A block that rocks on a cylinder: contact rolls along both, and what rocks must not swing up by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st

G, RADIUS, START = 9.81, 2.0, 0.03


@pytest.mark.parametrize(("length", "height"), [(1.0, 0.4), (3.0, 0.1), (3.0, 0.5)])
@pytest.mark.parametrize("dt", [1 / 60, 1 / 120])
def test_a_block_that_rocks_on_a_cylinder_keeps_its_period_and_never_swings_farther(
    length: float, height: float, dt: float
) -> None:
    """Rolling without slipping, V = m g ((R + b) cos(phi) + R phi sin(phi)), T = m (k^2 + b^2 + R^2 phi^2) phi'^2 / 2
    with b the half height and k the radius of gyration: phi'' = -g (R - b) / (k^2 + b^2) phi for small angles. An
    amplitude of 0.03 lengthens the period by R^2 phi^2 / (4 (k^2 + b^2)), 0.7 % at most."""
    b = 0.5 * height
    table = st.MaterialTable()
    table.set_pair("default", "default", static=0.9, dynamic=0.8)
    world = st.World(materials=table, sleeping=False, dt=dt)
    world.add(st.Cylinder(RADIUS, 4.0), static=True, orientation=(math.sqrt(0.5), math.sqrt(0.5), 0, 0))
    n, t = np.array([math.sin(START), 0, math.cos(START)]), np.array([math.cos(START), 0, -math.sin(START)])
    block = world.add(
        st.Box((length, 0.6, height)), mass=1.0, position=n * (RADIUS + b) - t * RADIUS * START,
        orientation=(math.cos(START / 2), 0, math.sin(START / 2), 0),
    )  # fmt: skip
    period = 2.0 * math.pi * math.sqrt(((length**2 + height**2) / 12 + b * b) / (G * (RADIUS - b)))
    angles = []
    for _ in range(math.ceil(10.0 / dt)):
        world.step()
        angles.append(2.0 * math.atan2(block.orientation[2], block.orientation[0]))
    angles = np.array(angles)
    assert np.abs(angles).max() < 1.005 * START
    k = np.flatnonzero(np.diff(np.sign(angles)))
    crossings = k + angles[k] / (angles[k] - angles[k + 1])
    assert 2.0 * float(np.diff(crossings).mean()) * dt == pytest.approx(period, rel=0.01)
    # what a swing loses is of the order of the step
    late = np.abs(angles[-math.ceil(period / dt) :]).max()
    assert late > START * math.exp(-10.0 * 12.0 * dt)
