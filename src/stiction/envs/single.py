"""One environment: a batch of one world in Gymnasium's form."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.envs.arena import Arena, Observations
from stiction.envs.picture import Eyes
from stiction.envs.spaces import RENDER_MODES, action_space, observation_space
from stiction.envs.task import Task


class StictionEnv(gymnasium.Env[Observations, NDArray[np.float32]]):
    """A task as a ``gymnasium.Env``: it goes, with the same seed, through the same bits as a world of the vector env.

    Args:
        task: ``"PuckPush"``, ``"TrayBalance"``, ``"Curling"``, or a :class:`Task`, whose docstrings tell what is seen,
            done and rewarded.
        render_mode: ``"rgb_array"``: :meth:`render` returns a picture. ``"human"``: the world is shown live in the
            browser, at ``env.unwrapped.eyes.viewer.url``, and each step takes as long as it does in the world.
        max_episode_steps: after which an episode is truncated; the task's own number if left out.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(RENDER_MODES), "render_fps": 15}  # type: ignore[misc]  # gymnasium declares it without ClassVar

    def __init__(
        self, task: Task | str = "PuckPush", render_mode: str | None = None, max_episode_steps: int | None = None
    ) -> None:
        if render_mode is not None:
            checks.one_of("render_mode", render_mode, RENDER_MODES)
        self.render_mode = render_mode
        self.arena = Arena(task, 1, 1, max_episode_steps)
        self.observation_space = observation_space(self.arena.task)
        self.action_space = action_space(self.arena.task)
        self.eyes = Eyes(self.arena, render_mode)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Begin an episode. The info is empty; there are no options."""
        super().reset(seed=seed)
        self.arena.streams[0] = self.np_random
        self.arena.reset(np.array([0]))
        self.eyes.look()
        return self.arena.observe()[0], {}

    def step(self, action: NDArray[np.float32]) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Act. The info has ``success`` (the aim was reached) and ``failed`` (the state stopped being finite)."""
        outcome = self.arena.step(np.asarray(action)[None])
        self.eyes.look()
        info = {"success": bool(outcome.success[0]), "failed": bool(outcome.failed[0])}
        return (
            outcome.observations[0], float(outcome.rewards[0]), bool(outcome.terminated[0]),
            bool(outcome.truncated[0]), info,
        )  # fmt: skip

    def render(self) -> NDArray[np.uint8] | None:
        """A picture (height, width, 3), or None where the viewer shows the world."""
        return self.eyes.picture(0)

    def close(self) -> None:
        """End the viewer, if there is one."""
        self.eyes.close()
