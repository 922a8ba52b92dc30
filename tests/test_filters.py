"""Layers and masks: who meets whom."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stiction as st

SOLVERS = ["soft", "micro"]
WALL, GHOST, BALL = 1, 2, 4


def table() -> st.MaterialTable:
    """No bounces."""
    made = st.MaterialTable()
    made.set_pair("default", "default", static=0.5, dynamic=0.5)
    return made


@pytest.mark.parametrize("solver", SOLVERS)
def test_both_masks_have_to_agree(solver: str) -> None:
    """Of four balls over a floor, only the one falls through that the floor does not meet, or that does not meet it."""
    world = st.World(solver=solver, materials=table())
    world.add(st.Plane(), static=True, layer=WALL, mask=~GHOST)
    sets: list[dict[str, int]] = [{}, {"layer": GHOST}, {"mask": ~WALL}, {"layer": GHOST | BALL, "mask": WALL}]
    balls = [world.add(st.Sphere(0.5), position=(3 * k, 0, 0.6), **bits) for k, bits in enumerate(sets)]
    world.step(60)
    assert [ball.position[2] > 0.4 for ball in balls] == [True, False, False, True]
    assert [(ball.layer, ball.mask) for ball in balls] == [(1, -1), (GHOST, -1), (1, ~WALL), (GHOST | BALL, WALL)]


@pytest.mark.parametrize("solver", SOLVERS)
def test_bodies_of_one_layer_can_pass_through_each_other(solver: str) -> None:
    world = st.World(gravity=(0, 0, 0), solver=solver, materials=table())
    left = world.add(st.Sphere(0.5), position=(-2, 0, 0), velocity=(4, 0, 0), layer=BALL, mask=~BALL)
    right = world.add(st.Sphere(0.5), position=(2, 0, 0), velocity=(-4, 0, 0), layer=BALL, mask=~BALL)
    world.step(60)
    np.testing.assert_allclose(left.position, (2, 0, 0), atol=1e-9)
    np.testing.assert_allclose(right.position, (-2, 0, 0), atol=1e-9)
    assert len(world.contacts()) == 0


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_mask_that_changes_takes_effect_at_once(solver: str) -> None:
    """Also below a body that sleeps on another one that sleeps."""
    world = st.World(solver=solver, materials=table())
    floor = world.add(st.Plane(), static=True)
    low = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    high = world.add(st.Box((1, 1, 1)), position=(0, 0, 1.5))
    world.step(150)
    floor.mask = GHOST
    world.step(10)
    assert low.velocity[2] < -1.0
    assert high.velocity[2] < -1.0
    floor.mask = -1
    low.layer = high.layer = GHOST
    low.position, high.position = (0, 0, 0.5), (0, 0, 1.5)
    low.velocity = high.velocity = (0, 0, 0)
    world.step(20)
    assert high.position[2] == pytest.approx(1.5, abs=0.02)


def test_filters_that_exclude_nothing_change_nothing() -> None:
    """Bit for bit."""

    def run(**bits: int) -> str:
        world = st.World(materials=table())
        world.add(st.Plane(), static=True, **bits)
        for k in range(4):
            world.add(st.Box((1, 1, 1)), position=(0.1 * k, 0, 0.5 + k), **bits)
        world.step(60)
        return world.state_hash()

    assert run() == run(layer=-1, mask=1) == run(layer=2**40, mask=2**40 | 1) == run(layer=-(2**63), mask=-1)


@pytest.mark.parametrize("name", ["layer", "mask"])
@pytest.mark.parametrize("wrong", [1.0, True, "all", None, [1, 2], 2**63, -(2**63) - 1])
def test_bad_bits(name: str, wrong: Any) -> None:
    world = st.World()
    with pytest.raises(st.InvalidInputError, match=rf"^{name} must be a whole number of 64 bits, one a layer \(-1"):
        world.add(st.Sphere(1), **{name: wrong})
    assert len(world) == 0
    body = world.add(st.Sphere(1))
    with pytest.raises(st.InvalidInputError, match=rf"^{name} of body 'sphere 0' must be a whole number of 64 bits"):
        setattr(body, name, wrong)
    assert (body.layer, body.mask) == (1, -1)
