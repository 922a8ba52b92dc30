"""Worlds that step with several threads: the same bits, and errors that say what is allowed."""

from __future__ import annotations

import gc
import threading

import numpy as np
import pytest

import stiction as st


def heap(threads: int, count: int) -> st.World:
    """Shapes of every kind that fall on each other."""
    world = st.World(threads=threads)
    world.add(st.Plane(), static=True)
    rng = np.random.default_rng(7)
    corners = rng.normal(size=(10, 3))
    shapes = [
        st.Box((0.5, 0.4, 0.3)), st.Sphere(0.25), st.Capsule(0.15, 0.4), st.Cylinder(0.2, 0.4),
        st.Ellipsoid((0.3, 0.2, 0.15)),
        st.ConvexHull(0.3 * corners / np.linalg.norm(corners, axis=1)[:, None]),
    ]  # fmt: skip
    for i in range(count):
        x, y, z = i % 5, i // 5 % 5, i // 25
        world.add(
            shapes[i % len(shapes)],
            position=np.array([x, y, 1 + z]) * 0.6 + rng.uniform(-0.1, 0.1, 3),
            orientation=rng.normal(size=4),
        )
    return world


def test_any_number_of_threads_gives_the_same_bits() -> None:
    hashes = {}
    for threads in (1, 2, 3):
        world = heap(threads, 100)
        world.step(30)
        for _ in range(30):
            world.step()
        hashes[threads] = world.state_hash()
    assert len(set(hashes.values())) == 1, hashes


def test_threads_take_part_where_bodies_come_go_and_sleep() -> None:
    worlds = [heap(threads, 40) for threads in (1, 2)]
    for world in worlds:
        world.step(20)
        world.remove(next(body for body in world.bodies if body.name.startswith("sphere")))
        world.add(st.Box((0.5, 0.5, 0.5)), position=(1, 1, 4))
        world.step(200)
    assert worlds[0].state_hash() == worlds[1].state_hash()


def test_worlds_with_threads_step_at_the_same_time() -> None:
    worlds = [heap(2, 30) for _ in range(3)]
    worlds[0].step()  # compiled
    others = [threading.Thread(target=world.step, args=(40,)) for world in worlds[1:]]
    for other in others:
        other.start()
    worlds[0].step(39)
    for other in others:
        other.join(60)
        assert not other.is_alive()
    assert len({world.state_hash() for world in worlds}) == 1


def test_threads_end_with_their_world() -> None:
    before = set(threading.enumerate())
    world = heap(3, 10)
    world.step()
    mine = set(threading.enumerate()) - before
    assert {thread.name.split("_")[0] for thread in mine} == {"stiction"}
    del world
    gc.collect()
    for thread in mine:
        thread.join(60)
        assert not thread.is_alive()


def test_a_step_that_fails_sends_the_workers_home() -> None:
    world = heap(2, 30)
    world.step()
    world.bodies[3].velocity = (0, 0, 1e200)
    with pytest.raises(st.SimulationError):
        world.step(50)
    world.bodies[3].velocity = (0, 0, 0)
    world.step(5)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2"])
def test_threads_are_a_whole_number(threads: object) -> None:
    with pytest.raises(st.InvalidInputError, match="threads must be a whole number, 1 or more"):
        st.World(threads=threads)  # type: ignore[arg-type]  # on purpose


def test_too_many_threads() -> None:
    with pytest.raises(st.InvalidInputError, match="threads must be 256 or less, got 100000"):
        st.World(threads=100_000)


def test_micro_has_one_thread() -> None:
    with pytest.raises(st.NotYetError, match="threads must be 1 with solver 'micro', got 2"):
        st.World(solver="micro", threads=2)
