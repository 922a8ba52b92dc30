"""A task on a batch: seeds, steps and ends of episodes, without Gymnasium's forms."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.batch import Batch
from stiction.envs.task import Array, Chosen, Mask, Task, task_of
from stiction.errors import InvalidInputError

Observations = NDArray[np.float32]


class Outcome(NamedTuple):
    """What a step came to, (worlds, m) and (worlds,) each.

    A world whose state stopped being finite has ``failed``: its episode is truncated, and what is seen of it is its
    last finite state.
    """

    observations: Observations
    rewards: Array
    terminated: Mask
    truncated: Mask
    success: Mask
    failed: Mask


class Arena:
    """Episodes of a task in many worlds.

    Args:
        task: the task, or its name.
        worlds: how many.
        threads: that step them; as many as there are processors if left out.
        max_episode_steps: after which an episode is truncated; the task's own number if left out.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    def __init__(
        self, task: Task | str, worlds: int, threads: int | None = None, max_episode_steps: int | None = None
    ) -> None:
        self.task = task_of(task)
        self.longest = (
            self.task.episode
            if max_episode_steps is None
            else checks.integer("max_episode_steps", max_episode_steps, minimum=1)
        )
        self.batch = Batch(self.task.build(), worlds, threads=threads)
        self.limits: Array = np.array(self.task.limits, np.float64)
        self.streams: list[np.random.Generator | None] = [None] * worlds
        self._elapsed = np.zeros(worlds, np.int64)
        self.task.start(self.batch)

    def reset(self, chosen: Chosen) -> None:
        """Begin new episodes in these worlds, with draws from their :attr:`streams`."""
        self.batch.reset(chosen)
        self._elapsed[chosen] = 0
        streams = [self._stream(world) for world in chosen.tolist()]

        def draw(low: float | Array, high: float | Array) -> Array:
            a, b = np.broadcast_arrays(np.asarray(low, np.float64), np.asarray(high, np.float64))
            drawn: Array = np.stack([stream.random(a.shape) for stream in streams])
            scaled: Array = a + (b - a) * drawn
            return scaled

        if len(chosen):
            self.task.begin(self.batch, chosen, draw)

    def _stream(self, world: int) -> np.random.Generator:
        stream = self.streams[world]
        if stream is None:
            stream = self.streams[world] = np.random.default_rng()
        return stream

    def step(self, actions: ArrayLike) -> Outcome:
        """Let actions (worlds, k) act, clipped to -1 to 1.

        Raises:
            InvalidInputError: they are not finite, or of another shape; nothing has happened.
        """
        shape = len(self.batch), self.task.actions
        given = np.asarray(actions, np.float64)
        if given.shape != shape or not np.isfinite(given).all():
            raise InvalidInputError(f"actions must be finite and of shape {shape}, got {actions!r}.")
        acting = np.clip(given, -1.0, 1.0)
        for _ in range(self.task.drives):
            self.task.drive(self.batch, acting)
            self.batch.step(self.task.hold)
        self._elapsed += 1
        failed = self.batch.failed
        verdict = self.task.judge(self.batch, acting)
        terminated = verdict.terminated & ~failed
        truncated = failed | (~terminated & (self._elapsed >= self.longest))
        rewards = np.where(failed, 0.0, verdict.reward)
        return Outcome(self.observe(), rewards, terminated, truncated, verdict.success & ~failed, failed)

    def observe(self) -> Observations:
        """(worlds, m), clipped to what the task's limits allow; a new array each time."""
        return np.clip(self.task.observe(self.batch), -self.limits, self.limits).astype(np.float32)
