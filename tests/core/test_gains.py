"""Islands pay for what energy contact has made, and only for that."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

import stiction as st
from stiction.bench.engines.with_stiction import Adapter
from stiction.bench.scenes import make


def mechanical(world: st.World) -> float:
    now = world.energy()
    return now.kinetic + now.potential


def rises(world: st.World, steps: int) -> Iterator[float]:
    """By how much each step has raised the energy, J."""
    before = mechanical(world)
    for _ in range(steps):
        world.step()
        now = mechanical(world)
        yield now - before
        before = now


def smooth() -> st.World:
    """A floor without friction."""
    world = st.World(sleeping=False)
    world.materials.set_pair("default", "default", static=0.0, dynamic=0.0)
    world.add(st.Plane(), static=True)
    return world


def add_pair(world: st.World, x: float, speed: float, deep: float) -> tuple[st.Body, st.Body]:
    """A crate on another one, ``deep`` in it."""
    below = world.add(st.Box((0.4, 0.4, 0.2)), mass=1.0, position=(x, 0, 0.1), velocity=(speed, 0, 0))
    above = world.add(st.Box((0.4, 0.4, 0.2)), mass=1.0, position=(x, 0, 0.3 - deep), velocity=(speed, 0, 0))
    return below, above


@pytest.mark.parametrize("deep", [2e-3, 3e-3, 3e-2])
def test_crates_that_slide_pay_for_coming_out_of_each_other(deep: float) -> None:
    """Both, whichever of them rises; but for a fifth of a millimetre, twice as deep as springs are under what rests."""
    world = smooth()
    pair = add_pair(world, 0.0, 1.0, deep)
    start, before = mechanical(world), pair[1].position[2]
    assert max(rises(world, 120)) < 2.0 * 9.81 * 1e-4
    assert mechanical(world) < start + 2.0 * 9.81 * 2e-4
    rise = pair[1].position[2] - before
    assert rise > 0.75 * deep
    assert all(body.velocity[0] == pytest.approx(math.sqrt(1.0 - 9.81 * rise), rel=2e-3) for body in pair)


def test_nobody_pays_for_what_rests_somewhere_else() -> None:
    """Islands have accounts of their own."""
    world = smooth()
    add_pair(world, 0.0, 0.0, 3e-3)
    slides = world.add(st.Box((0.4, 0.4, 0.2)), mass=1.0, position=(10, 0, 0.1), velocity=(1, 0, 0))
    world.step(60)
    assert slides.velocity[0] == 1.0


def test_a_heap_pays_step_by_step() -> None:
    """Bodies that begin in each other and fall: what moves them apart costs them motion."""
    world = st.World(sleeping=False)
    world.add(st.Plane(), static=True)
    rng = np.random.default_rng(4)
    for _ in range(12):
        position = np.array([0, 0, 2.0]) + rng.uniform(-0.25, 0.25, size=3)
        world.add(st.Box((0.4, 0.3, 0.2)), density=500, position=position, orientation=rng.normal(size=4))
    start = mechanical(world)
    assert max(rises(world, 90)) < 1e-5 * start


def test_what_falls_from_rest_is_not_held() -> None:
    """A card that stands nearly upright on its edge falls within the time that its pendulum takes, though slowly."""
    times = []
    for dt in (1.0 / 60.0, 1.0 / 960.0):
        world = st.World(dt=dt)
        world.add(st.Plane(), static=True)
        lean = 0.02
        card = world.add(
            st.Box((0.01, 0.4, 0.8)), mass=1.0,
            position=(0.4 * math.sin(lean) + 0.005 * math.cos(lean), 0, 0.4 * math.cos(lean) - 0.005 * math.sin(lean)),
            orientation=(math.cos(lean / 2), 0, math.sin(lean / 2), 0),
        )  # fmt: skip
        steps = 0
        while card.position[2] > 0.2 and steps * dt < 5.0:
            world.step()
            steps += 1
        times.append(steps * dt)
    assert times[0] == pytest.approx(times[1], abs=0.05)


@pytest.mark.parametrize("seed", [31, 101, 105])
def test_a_heap_at_rest_does_not_jump(seed: int) -> None:
    """Loads press some of its stones millimetres into others, where a turn of a milliradian decides whether a face or
    edges touch: heaps jumped by tenths of a millimetre every few steps, and rose by 2e-6 to 8e-6 of their energy."""
    adapter = Adapter()
    adapter.build(make("heap", 24, seed), 1 / 60)
    world = adapter.world
    world.step()
    start = mechanical(world)
    world.step(299)
    assert max(rises(world, 60)) < 1e-7 * start
