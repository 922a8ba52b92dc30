"""The tasks' physics: friction decides, as closed forms say."""

from __future__ import annotations

import numpy as np
import pytest

from stiction.envs import curling, puck_push, tray_balance
from stiction.envs.arena import Arena
from stiction.envs.cross_entropy import CrossEntropy, play, train
from stiction.envs.policies import PUSH_PARAMETERS, push_policy
from stiction.errors import InvalidInputError

G = 9.81


def an_arena(task: str, worlds: int) -> Arena:
    arena = Arena(task, worlds)
    arena.streams[:] = [np.random.default_rng(world) for world in range(worlds)]
    arena.reset(np.arange(worlds))
    return arena


def test_a_puck_stops_where_its_patches_let_it() -> None:
    """Over two patches: v^2 = 2 g (mu_1 d_1 + mu_2 d_2), where the centre crosses from one to the other."""
    arena = an_arena("PuckPush", 3)
    task, batch = arena.task, arena.batch
    assert isinstance(task, puck_push.PuckPush)
    here, beyond = np.array([0.1, 0.2, 0.3]), np.array([0.3, 0.1, 0.5])
    row = puck_push.ALONG
    task.coefficients[:, row], task.coefficients[:, row + 1] = here, beyond
    batch.positions[:, 1, 0], batch.positions[:, 1, 1] = 0.2, 0.0
    batch.velocities[:, 1, 0] = v = 1.15
    for _ in range(20):
        arena.step(np.tile([-1.0, 0.0], (3, 1)))
    left = v**2 / (2 * G) - here * (puck_push.PATCH - 0.2)
    expected = puck_push.PATCH + left / beyond
    np.testing.assert_allclose(batch.velocities[:, 1], 0.0, atol=1e-6)
    # friction changes at the first step beyond the seam, and a step is up to 2 cm long
    np.testing.assert_allclose(batch.positions[:, 1, 0], expected, atol=0.02)


def test_the_floor_can_be_another_one() -> None:
    arena = Arena(puck_push.PuckPush((0.4, 0.4)), 2)
    arena.reset(np.arange(2))
    assert isinstance(arena.task, puck_push.PuckPush)
    assert (arena.task.coefficients == 0.4).all()
    for friction in ((0.4, 0.1), (-0.1, 0.1), 0.3):
        with pytest.raises(InvalidInputError, match="friction must"):
            puck_push.PuckPush(friction)


def test_arriving_is_rewarded_and_ends_the_episode() -> None:
    arena = an_arena("PuckPush", 2)
    task = arena.task
    assert isinstance(task, puck_push.PuckPush)
    arena.batch.positions[0, 1, :2] = task.target[0]
    outcome = arena.step(np.zeros((2, 2)))
    assert outcome.success.tolist() == outcome.terminated.tolist() == [True, False]
    assert outcome.rewards[0] > 1.0
    assert outcome.rewards[1] == pytest.approx(-0.002, abs=1e-6)


def test_gentle_trays_keep_their_cups_and_hasty_ones_do_not() -> None:
    arena = an_arena("TrayBalance", 2)
    gentle = 0.9 * tray_balance.LEAST * G / tray_balance.STRONGEST
    over = np.zeros(2, np.bool_)
    for _ in range(30):
        outcome = arena.step([[gentle, 0.0], [1.0, 0.0]])
        over |= outcome.terminated
    slid = outcome.observations[0, 3:6]
    np.testing.assert_allclose(slid, 0.0, atol=2e-3)
    assert over.tolist() == [False, True]
    assert outcome.observations[0, 1] == pytest.approx(30 / 15 * gentle * tray_balance.STRONGEST, rel=1e-5)


def test_leaning_into_it_holds_the_cups_where_a_level_tray_loses_them() -> None:
    """A tray that is tilted by t and accelerates by a = g tan t feels level to its cups."""
    arena = an_arena("TrayBalance", 2)
    task = arena.task
    assert isinstance(task, tray_balance.TrayBalance)
    accelerations = []
    for _ in range(18):
        a = G * np.tan(task.tilt[0])
        accelerations.append(a)
        arena.step([[a / tray_balance.STRONGEST, 0.2], [a / tray_balance.STRONGEST, 0.0]])
    seen = arena.observe()
    assert max(accelerations) > 1.2 * tray_balance.STATIC * tray_balance.LEAST * G
    assert np.abs(seen[0, 3:6]).max() < 0.2 * np.abs(seen[1, 3:6]).max()


def test_a_stone_goes_as_far_as_the_ice_lets_it_and_sweeping_carries_it() -> None:
    arena = an_arena("Curling", 2)
    task = arena.task
    assert isinstance(task, curling.Curling)
    task.coefficient[:] = 0.0105
    actions = np.array([[0.0, 0.0, 0.0, -1.0], [-0.9, 0.0, 0.0, 1.0]])
    v = curling.SPEED + curling.SPEED_RANGE * actions[:, 0]
    ended = np.zeros(2, np.bool_)
    while not ended.all():
        outcome = arena.step(actions)
        ended |= outcome.terminated | outcome.truncated
    expected = v**2 / (2 * G * 0.0105 * np.array([1.0, 1.0 - curling.SWEEP]))
    np.testing.assert_allclose(arena.batch.positions[:, curling.STONE, 0], expected, rtol=2e-3)


def test_who_reads_the_ice_and_sweeps_arrives_from_observations_alone() -> None:
    arena = an_arena("Curling", 40)
    seen = arena.observe()
    # full sweeping makes the roughest ice as fast as the fastest one is at the least
    slowest = curling.MOST * (1.0 - curling.SWEEP)
    speed = np.sqrt(2 * G * slowest * np.hypot(seen[:, 0], seen[:, 1]))
    actions = np.zeros((40, 4))
    actions[:, 0] = (speed - curling.SPEED) / curling.SPEED_RANGE
    actions[:, 1] = np.arctan2(seen[:, 1], seen[:, 0]) / curling.ANGLE
    success, over = np.zeros(40, np.bool_), np.zeros(40, np.bool_)
    dt = arena.batch.dt * arena.task.hold
    ice, before = np.full(40, curling.MOST), speed
    while not over.all():
        outcome = arena.step(actions)
        seen = outcome.observations.astype(np.float64)
        v, ahead = np.hypot(seen[:, 2], seen[:, 3]), np.maximum(seen[:, 0], 1e-3)
        if not over.any():
            ice = (before - v) / (dt * G * (1.0 - curling.SWEEP * np.maximum(actions[:, 3], 0.0)))
        wanted = v**2 / (2 * G * ahead)
        actions[:, 3] = np.clip((1.0 - wanted / ice) / curling.SWEEP, 0.0, 1.0)
        before = v
        success |= outcome.success & ~over
        over |= outcome.terminated | outcome.truncated
    assert success.mean() > 0.9


def test_spin_carries_a_stone_farther_and_mirrors() -> None:
    arena = an_arena("Curling", 3)
    task = arena.task
    assert isinstance(task, curling.Curling)
    task.coefficient[:] = 0.009
    for _ in range(task.episode):
        arena.step([[0.0, 0.0, spin, 0.0] for spin in (-1.0, 0.0, 1.0)])
    x, y = arena.batch.positions[:, curling.STONE, :2].T
    assert x[0] == pytest.approx(x[2], abs=1e-4)
    assert x[0] > x[1] + 0.5
    assert y[0] == pytest.approx(-y[2], abs=1e-4)
    assert abs(y[1]) < 1e-4


def test_a_policy_learns_to_push_and_always_in_the_same_way() -> None:
    means = []
    for generations in (8, 1):
        search = CrossEntropy(np.zeros(PUSH_PARAMETERS), 1.0, candidates=16, elite=5, seed=1)
        history = train(Arena("PuckPush", 48, max_episode_steps=80), push_policy, search, generations)
        means.append([scores.returns.mean() for scores in history])
    assert means[0][0] == means[1][0]
    assert means[0][-1] > means[0][0] + 0.4


def test_worlds_with_the_same_seed_play_alike() -> None:
    arena = Arena("PuckPush", 3)
    scores = play(arena, lambda seen: push_policy(np.ones((3, PUSH_PARAMETERS)), seen), [4, 9, 4])
    assert scores.returns[0] == scores.returns[2] != scores.returns[1]


def test_a_search_that_cannot_be() -> None:
    with pytest.raises(InvalidInputError, match="elite must be less than candidates, 4, got 4"):
        CrossEntropy([0.0], 1.0, candidates=4, elite=4)
    search = CrossEntropy(np.zeros(PUSH_PARAMETERS), 1.0, candidates=4, elite=2)
    with pytest.raises(InvalidInputError, match="a multiple of the 4 candidates, got 6"):
        train(Arena("PuckPush", 6), push_policy, search, 1)
