"""Many environments: a batch of worlds in Gymnasium's form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from stiction import checks
from stiction.envs.arena import Arena, Observations, Outcome
from stiction.envs.picture import Eyes
from stiction.envs.spaces import RENDER_MODES, action_space, observation_space
from stiction.envs.task import Array, Mask, Task
from stiction.errors import InvalidInputError


class StictionVectorEnv(VectorEnv[Observations, NDArray[np.float32], NDArray[Any]]):
    """A task as a ``gymnasium.vector.VectorEnv``: all worlds are stepped by one compiled call.

    World i, seeded with ``seed + i``, goes through the same bits as :class:`StictionEnv` seeded so, for any number of
    worlds and threads.

    Args:
        task: ``"PuckPush"``, ``"TrayBalance"``, ``"Curling"``, or a :class:`Task`.
        num_envs: how many worlds.
        autoreset_mode: ``"NextStep"`` (the step after an end begins a new episode, its action does nothing),
            ``"SameStep"`` (at once; the last observation is in ``info["final_obs"]``) or ``"Disabled"`` (the caller
            does, with ``reset(options={"reset_mask": mask})``).
        render_mode: as :class:`StictionEnv` has it; the browser shows the first world.
        max_episode_steps: after which an episode is truncated; the task's own number if left out.
        threads: that step the worlds; as many as there are processors if left out.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    def __init__(
        self,
        task: Task | str = "PuckPush",
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        threads: int | None = None,
    ) -> None:
        if render_mode is not None:
            checks.one_of("render_mode", render_mode, RENDER_MODES)
        if not isinstance(autoreset_mode, AutoresetMode):
            modes = [mode.value for mode in AutoresetMode]
            autoreset_mode = AutoresetMode(checks.one_of("autoreset_mode", autoreset_mode, modes))
        self.num_envs = checks.integer("num_envs", num_envs, minimum=1)
        self.autoreset_mode = autoreset_mode
        self.metadata = {"render_modes": list(RENDER_MODES), "render_fps": 15, "autoreset_mode": autoreset_mode}
        self.render_mode = render_mode
        self.arena = Arena(task, self.num_envs, threads, max_episode_steps)
        self.single_observation_space = observation_space(self.arena.task)
        self.single_action_space = action_space(self.arena.task)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.eyes = Eyes(self.arena, render_mode)
        self._ended: Mask = np.ones(self.num_envs, np.bool_)
        self._begun = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Begin new episodes.

        Args:
            seed: world i takes ``seed + i``; or one for each world. Left out, worlds go on with their streams.
            options: ``{"reset_mask": (num_envs,) bool}`` chooses worlds; the others are left as they are.

        Raises:
            InvalidInputError: the seeds or the mask do not fit; nothing has happened.
        """
        mask = self._mask(options)
        seeds = self._seeds(seed)
        chosen = np.flatnonzero(mask)
        for world in chosen.tolist():
            if seeds[world] is not None:
                self.arena.streams[world], _ = seeding.np_random(seeds[world])
        self.arena.reset(chosen)
        self._ended[chosen] = False
        self._begun = True
        self.eyes.look()
        return self.arena.observe(), {}

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)):
            first = checks.integer("seed", seed, minimum=0)
            return [first + world for world in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InvalidInputError(f"seed must be a whole number or {self.num_envs} of them, got {len(seed)}.")
        return [None if one is None else checks.integer("seed", one, minimum=0) for one in seed]

    def _mask(self, options: dict[str, Any] | None) -> Mask:
        if options is None or "reset_mask" not in options:
            return np.ones(self.num_envs, np.bool_)
        mask = options["reset_mask"]
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            raise InvalidInputError(f"reset_mask must be a numpy array of {self.num_envs} bools, got {mask!r}.")
        if not mask.any():
            raise InvalidInputError("reset_mask must choose a world at least, got none.")
        return mask

    def step(self, actions: NDArray[np.float32]) -> tuple[Observations, Array, Mask, Mask, dict[str, Any]]:
        """Act in all worlds. Infos are (num_envs,) arrays ``success`` and ``failed``, each with a mask ``_success`` …

        Raises:
            ResetNeeded: before the first reset; with resets disabled, an episode is over and was not reset.
            InvalidInputError: actions are not finite, or of another shape.
        """
        waiting = self._ended.copy()
        if not self._begun or (self.autoreset_mode is AutoresetMode.DISABLED and waiting.any()):
            raise ResetNeeded(
                f"reset must be called before step: world {int(np.flatnonzero(waiting)[0])} waits for it."
            )
        outcome = self.arena.step(actions)
        ended = (outcome.terminated | outcome.truncated) & ~waiting
        infos: dict[str, Any] = {}
        told = ~waiting
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            if ended.any():
                self._tell_last(infos, outcome, ended)
            told = told & ~ended
            again = ended | waiting
            self._ended = np.zeros(self.num_envs, np.bool_)
        else:
            again = waiting
            self._ended = ended
        observations = outcome.observations
        if again.any():
            self.arena.reset(np.flatnonzero(again))
            observations = self.arena.observe()
        infos |= _told(outcome, told)
        self.eyes.look()
        return (
            observations, np.where(waiting, 0.0, outcome.rewards), outcome.terminated & ~waiting,
            outcome.truncated & ~waiting, infos,
        )  # fmt: skip

    def _tell_last(self, infos: dict[str, Any], outcome: Outcome, ended: Mask) -> None:
        """What episodes ended with, in the form of Gymnasium's own vector envs."""
        last = np.full(self.num_envs, None, dtype=object)
        for world in np.flatnonzero(ended).tolist():
            last[world] = outcome.observations[world].copy()
        infos["final_obs"], infos["_final_obs"] = last, ended.copy()
        infos["final_info"], infos["_final_info"] = _told(outcome, ended), ended.copy()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture (height, width, 3) of each world, or None where the viewer shows the first one."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(frame for world in range(self.num_envs) if (frame := self.eyes.picture(world)) is not None)

    def close_extras(self, **kwargs: Any) -> None:
        """End the viewer, if there is one."""
        self.eyes.close()


def _told(outcome: Outcome, worlds: Mask) -> dict[str, NDArray[Any]]:
    """Infos of these worlds."""
    return {
        "success": outcome.success & worlds,
        "_success": worlds.copy(),
        "failed": outcome.failed & worlds,
        "_failed": worlds.copy(),
    }
