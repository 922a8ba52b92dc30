"""The cross-entropy method: learning the numbers of a policy from the best of many tries.

R. Rubinstein, "The cross-entropy method for combinatorial and continuous optimization", Methodology and Computing in
Applied Probability 1 (1999); for policies: I. Szita and A. Lörincz, "Learning Tetris using the noisy cross-entropy
method", Neural Computation 18 (2006).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.envs.arena import Arena, Observations
from stiction.errors import InvalidInputError

Array = NDArray[np.float64]
Policy = Callable[[Array, Observations], Array]
"""Parameters (worlds, p) and observations (worlds, m) to actions (worlds, k): each world has its own parameters."""


class Scores(NamedTuple):
    """What episodes came to, (worlds,) each: the sum of rewards, and whether the aim was reached."""

    returns: Array
    success: NDArray[np.bool_]


def play(arena: Arena, act: Callable[[Observations], Array], seeds: ArrayLike) -> Scores:
    """An episode in every world.

    Args:
        arena: the worlds.
        act: gives the actions (worlds, k).
        seeds: (worlds,) of their beginnings; worlds with the same seed begin alike.
    """
    for world, seed in enumerate(np.asarray(seeds).tolist()):
        arena.streams[world] = np.random.Generator(np.random.PCG64(seed))
    arena.reset(np.arange(len(arena.batch)))
    observations = arena.observe()
    returns, success = np.zeros(len(arena.batch)), np.zeros(len(arena.batch), np.bool_)
    running = np.ones(len(arena.batch), np.bool_)
    while running.any():
        outcome = arena.step(act(observations))
        observations = outcome.observations
        returns += np.where(running, outcome.rewards, 0.0)
        success |= running & outcome.success
        running &= ~(outcome.terminated | outcome.truncated)
    return Scores(returns, success)


class CrossEntropy:
    """A normal distribution of parameters that moves to where the best of them were.

    Args:
        mean: (p,) where to begin.
        deviation: of each parameter at first.
        candidates: parameters drawn in a generation.
        elite: how many of them count as the best.
        seed: of the draws.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    def __init__(self, mean: ArrayLike, deviation: float, *, candidates: int, elite: int, seed: int = 0) -> None:
        self.mean: Array = np.array(mean, np.float64)
        self.deviation: Array = np.full(self.mean.shape, checks.positive("deviation", deviation))
        self.candidates = checks.integer("candidates", candidates, minimum=2)
        self.elite = checks.integer("elite", elite, minimum=1)
        if self.elite >= self.candidates:
            raise InvalidInputError(f"elite must be less than candidates, {candidates}, got {elite!r}.")
        self._draws = np.random.default_rng(checks.integer("seed", seed, minimum=0))

    def ask(self) -> Array:
        """(candidates, p) parameters to try."""
        drawn: Array = self.mean + self.deviation * self._draws.normal(size=(self.candidates, len(self.mean)))
        return drawn

    def tell(self, parameters: Array, scores: Array) -> None:
        """Move towards the best of the parameters (candidates, p), whose scores (candidates,) are to be high."""
        best = parameters[np.argsort(-scores, kind="stable")[: self.elite]]
        self.mean = best.mean(axis=0)
        # some of the old spread stays, so that it does not close in on the first good place
        self.deviation = 0.9 * best.std(axis=0) + 0.1 * self.deviation


def train(
    arena: Arena, policy: Policy, search: CrossEntropy, generations: int, *, seed: int = 0,
    tell: Callable[[int, Scores], None] | None = None,
) -> list[Scores]:  # fmt: skip
    """Learn a policy. The worlds of the arena are shared among the candidates, who all begin in the same places.

    Args:
        arena: its number of worlds must be a multiple of the number of candidates.
        policy: what acts.
        search: what draws parameters and learns from them.
        generations: how many.
        seed: of the places.
        tell: is called after each generation with its number and scores.

    Returns:
        The scores of each generation.

    Raises:
        InvalidInputError: the worlds cannot be shared equally.
    """
    each, left = divmod(len(arena.batch), search.candidates)
    if left or not each:
        raise InvalidInputError(
            f"the worlds of arena must be a multiple of the {search.candidates} candidates, got {len(arena.batch)}."
        )
    history = []
    for generation in range(checks.integer("generations", generations, minimum=1)):
        parameters = search.ask()
        spread = np.repeat(parameters, each, axis=0)
        seeds = np.tile((seed + 1) * 10**6 + generation * each + np.arange(each), search.candidates)
        scores = play(arena, lambda seen, spread=spread: policy(spread, seen), seeds)  # type: ignore[misc]  # mypy infers no default
        search.tell(parameters, scores.returns.reshape(-1, each).mean(axis=1))
        history.append(scores)
        if tell is not None:
            tell(generation, scores)
    return history
