"""The pacer: frames at an even rate, whatever threads and steps take. Time goes by only where a test says so."""

from __future__ import annotations

import numpy as np
import pytest

import stiction as st
from stiction.view.pacer import LEAST_REST, MOST_LATE, SHORTEST, Pacer
from stiction.view.server import FRAMES_PER_SECOND
from stiction.view.session import LiveSession

PERIOD = 1.0 / FRAMES_PER_SECOND


class Wall:
    """A wall clock, and rests on it that end late by what ``wakes`` gives for each."""

    def __init__(self, wakes: np.ndarray) -> None:
        self.now = 0.0
        self._wakes = iter(wakes.tolist())

    def __call__(self) -> float:
        return self.now

    def rest(self, seconds: float) -> None:
        self.now += seconds + next(self._wakes)


def frames_in(seconds: float, costs: np.ndarray, wakes: np.ndarray) -> tuple[np.ndarray, float]:
    """When frames began that cost so many seconds each, and the time that went by with them."""
    wall = Wall(wakes)
    pacer = Pacer(PERIOD, wall)
    began, passed = [], 0.0
    for cost in costs.tolist():
        wall.rest(pacer.rest())
        if wall.now > seconds:
            break
        began.append(wall.now)
        passed += pacer.begin()
        wall.now += cost
    return np.array(began), passed


def test_frames_come_30_times_a_second_though_every_rest_ends_late(rng: np.random.Generator) -> None:
    began, passed = frames_in(20.0, rng.uniform(0.005, 0.03, 1000), rng.uniform(0.0, 4e-3, 1000))
    assert len(began) == pytest.approx(600, abs=1)
    assert passed == pytest.approx(20.0, abs=2 * PERIOD)


def test_frames_that_take_too_long_are_made_up_for(rng: np.random.Generator) -> None:
    # one frame in ten takes two periods and a half
    costs = np.where(np.arange(1000) % 10 == 5, 2.5 * PERIOD, 0.01)
    began, passed = frames_in(20.0, costs, rng.uniform(0.0, 1e-3, 1000))
    assert len(began) == pytest.approx(600, abs=2)
    assert passed == pytest.approx(20.0, abs=3 * PERIOD)
    # but none of them comes so soon that a client would not see the one before
    assert np.diff(began).min() > SHORTEST * PERIOD


def test_who_is_far_behind_goes_on_from_where_it_is() -> None:
    began, _ = frames_in(20.0, np.full(1000, 0.12), np.zeros(1000))
    assert np.diff(began) == pytest.approx(0.12 + LEAST_REST)
    costs = np.where(np.arange(100) == 10, 5.0, 0.01)
    gaps = np.diff(frames_in(9.0, costs, np.zeros(100))[0])
    # 5 s are lost, and the frames after them come at the usual rate
    assert gaps[11:] == pytest.approx(PERIOD)


def test_every_frame_moves_the_world_by_as_much(rng: np.random.Generator) -> None:
    taken = []
    session = LiveSession(st.World(dt=PERIOD / 2), advance=taken.append, clock=lambda: 0.0)
    session.playing = True
    wall = Wall(rng.uniform(0.0, 8e-3, 300))
    pacer = Pacer(PERIOD, wall)
    for _ in range(300):
        wall.rest(pacer.rest())
        session.tick(pacer.begin())
    assert set(taken) == {1, 2}
    assert taken.count(1) == 2  # before it is known what a step takes


def test_steps_get_what_a_late_frame_has_left_of_its_time() -> None:
    wall = Wall(np.array([0.02, 0.0]))
    pacer = Pacer(PERIOD, wall)
    wall.rest(pacer.rest())
    assert pacer.begin() == PERIOD
    assert pacer.left() == pytest.approx(SHORTEST * PERIOD)
    wall.now += 0.01
    wall.rest(pacer.rest())
    pacer.begin()
    assert wall.now == pytest.approx(0.02 + (1 + SHORTEST) * PERIOD)
    assert pacer.left() < PERIOD


def test_what_is_no_longer_made_up_for_goes_by_for_the_world() -> None:
    wall = Wall(np.array([1.0]))
    pacer = Pacer(PERIOD, wall)
    wall.rest(pacer.rest())
    assert pacer.begin() == PERIOD + MOST_LATE
    assert pacer.left() == pytest.approx(PERIOD)
