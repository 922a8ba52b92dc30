"""The environments in Gymnasium's forms: its checker, seeds, ends of episodes, failures, what there is to see."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from stiction import envs
from stiction.envs.single import StictionEnv
from stiction.envs.vector import StictionVectorEnv
from stiction.errors import InvalidInputError

MODES = list(AutoresetMode)


def some_actions(steps: int, env: Any, seed: int = 0) -> NDArray[np.float32]:
    shape = (steps, *env.action_space.shape)
    return np.random.default_rng(seed).uniform(-1.0, 1.0, shape).astype(np.float32)


@pytest.mark.parametrize("task", envs.TASKS)
def test_gymnasiums_checker_is_content(task: str) -> None:
    env = gymnasium.make(f"stiction/{task}-v0", render_mode="rgb_array")
    check_env(env.unwrapped)  # warnings are errors here; with the pictures and the live view
    env.close()


@pytest.mark.parametrize("task", envs.TASKS)
def test_a_world_goes_through_the_bits_of_a_plain_environment(task: str) -> None:
    many = StictionVectorEnv(task, 3, max_episode_steps=25, threads=2)
    actions = some_actions(40, many)
    seen = [many.reset(seed=5)[0], *(many.step(action)[0] for action in actions)]
    for world in (0, 2):
        env = StictionEnv(task, max_episode_steps=25)
        observation, _ = env.reset(seed=5 + world)
        np.testing.assert_array_equal(seen[0][world], observation)
        over = False
        for step, action in enumerate(actions):
            if over:
                (observation, _), over = env.reset(), False
            else:
                observation, _, terminated, truncated, _ = env.step(action[world])
                over = terminated or truncated
            np.testing.assert_array_equal(seen[step + 1][world], observation)


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.value)
def test_episodes_end_as_those_of_gymnasiums_own_vector_environment(mode: AutoresetMode) -> None:
    own = gymnasium.make_vec("stiction/TrayBalance-v0", 3, autoreset_mode=mode, max_episode_steps=12)
    assert isinstance(own, StictionVectorEnv)
    theirs = gymnasium.vector.SyncVectorEnv(
        [lambda: StictionEnv("TrayBalance", max_episode_steps=12)] * 3, autoreset_mode=mode
    )
    assert own.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"] is mode
    assert own.single_observation_space == theirs.single_observation_space
    assert data_equivalence(own.reset(seed=3), theirs.reset(seed=3), exact=True)
    ends = np.zeros(3, np.int64)
    for step, action in enumerate(some_actions(40, own)):
        action[0] = 0.9, 0.0  # so that one world ends before the others
        a, b = own.step(action), theirs.step(action)
        assert data_equivalence(a[:4], b[:4], exact=True), step
        assert data_equivalence(a[4], b[4], exact=True), step
        over = a[2] | a[3]
        ends += over
        if mode is AutoresetMode.DISABLED and over.any():
            with pytest.raises(ResetNeeded):
                own.step(action)
            a, b = (env.reset(options={"reset_mask": over.copy()}) for env in (own, theirs))
            assert data_equivalence(a, b, exact=True), step
    assert ends.min() >= 2
    assert len(set(ends.tolist())) > 1


def test_a_masked_reset_leaves_the_others_alone() -> None:
    env = StictionVectorEnv("PuckPush", 4)
    env.reset(seed=0)
    for action in some_actions(10, env):
        env.step(action)
    before = env.arena.batch.hashes()
    mask = np.array([False, True, False, True])
    observations, _ = env.reset(seed=0, options={"reset_mask": mask})
    after = env.arena.batch.hashes()
    assert [a == b for a, b in zip(before, after, strict=True)] == (~mask).tolist()
    np.testing.assert_array_equal(observations[mask], StictionVectorEnv("PuckPush", 4).reset(seed=0)[0][mask])


def test_without_a_seed_episodes_differ() -> None:
    env = StictionVectorEnv("PuckPush", 2)
    first, _ = env.reset(seed=0)
    second, _ = env.reset()
    assert (first[:, :2] != second[:, :2]).all()
    assert (first[0, :2] != first[1, :2]).all()


def test_a_world_that_blows_up_is_truncated_and_comes_back() -> None:
    env = StictionVectorEnv("PuckPush", 3)
    env.reset(seed=0)
    alike = StictionVectorEnv("PuckPush", 3)
    alike.reset(seed=0)
    still = np.zeros((3, 2), np.float32)
    env.arena.batch.forces[1, 1] = 1e300
    observations, rewards, terminated, truncated, infos = env.step(still)
    expected = alike.step(still)[0]
    assert infos["failed"].tolist() == truncated.tolist() == [False, True, False]
    assert not terminated.any()
    assert np.isfinite(observations).all()
    assert np.isfinite(rewards).all()
    np.testing.assert_array_equal(observations[[0, 2]], expected[[0, 2]])
    *_, truncated, infos = env.step(still)
    assert not truncated.any()
    assert not infos["failed"].any()


@pytest.mark.parametrize("task", envs.TASKS)
def test_a_picture_shows_what_moves(task: str) -> None:
    env = StictionEnv(task, render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    for action in some_actions(8, env):
        env.step(action)
    second = env.render()
    assert first is not None
    assert second is not None
    assert first.dtype == np.uint8
    assert first.shape == second.shape
    assert first.shape[1] == env.arena.task.view.width
    changed = (first != second).any(axis=2).mean()
    assert 0.0 < changed < 0.2


def test_the_live_view_shows_the_first_world() -> None:
    env = StictionVectorEnv("Curling", 2, render_mode="human")
    env.reset(seed=0)
    viewer: Any = env.eyes.viewer
    try:
        for action in some_actions(3, env):
            env.step(action)
        with viewer.lock:
            viewer.session.playing = True
            viewer.session.tick(0.1)  # the program steps the world, the play button does not
            np.testing.assert_array_equal(viewer.session.frame().positions, env.arena.batch.positions[0])
            assert viewer.session.world.time == env.arena.batch.time[0] > 0.0
        assert env.render() is None
    finally:
        env.close()
    assert env.eyes.viewer is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"task": "PuckPull"}, "task must be one of .*did you mean 'PuckPush'"),
        ({"task": 3}, "task must be a Task or one of"),
        ({"num_envs": 0}, "num_envs must be a whole number, 1 or more"),
        ({"autoreset_mode": "Never"}, "autoreset_mode must be one of NextStep, SameStep, Disabled"),
        ({"render_mode": "ansi"}, "render_mode must be one of human, rgb_array"),
        ({"max_episode_steps": 0}, "max_episode_steps must be a whole number"),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        StictionVectorEnv(**arguments)


def test_bad_steps_and_resets_change_nothing() -> None:
    env = StictionVectorEnv("PuckPush", 2)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros((2, 2), np.float32))
    env.reset(seed=0)
    before = env.arena.batch.hashes()
    for actions in (np.zeros((3, 2)), np.zeros(2), np.full((2, 2), np.nan)):
        with pytest.raises(InvalidInputError, match=r"actions must be finite and of shape \(2, 2\)"):
            env.step(actions)
    for mask in (np.ones(3, np.bool_), [True, False], np.zeros(2, np.bool_)):
        with pytest.raises(InvalidInputError, match="reset_mask must"):
            env.reset(options={"reset_mask": mask})
    for seed in ([1], -1, [0, -1]):
        with pytest.raises(InvalidInputError, match="seed must"):
            env.reset(seed=seed)
    assert env.arena.batch.hashes() == before


def test_without_gymnasium_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InvalidInputError, match=r'StictionEnv needs Gymnasium: pip install "stiction\[gym\]"'):
        _ = envs.StictionEnv
    assert envs.PuckPush().name == "PuckPush"
    with pytest.raises(AttributeError, match="no attribute 'Puck'"):
        _ = envs.Puck


def test_importing_the_environments_loads_no_compiler() -> None:
    code = "import sys, stiction.envs; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
