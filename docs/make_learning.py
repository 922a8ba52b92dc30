"""Train the policy of learning.md, draw its curve and write its numbers: ``python docs/make_learning.py`` (minutes)."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from markers import replace
from numpy.typing import NDArray

from stiction.envs.arena import Arena, Observations
from stiction.envs.cross_entropy import CrossEntropy, Scores, play, train
from stiction.envs.policies import PUSH_PARAMETERS, push_policy
from stiction.envs.puck_push import LEAST, MOST, PuckPush
from stiction.plot.canvas import dress, legend, save, sheet
from stiction.view import style

PAGE = Path(__file__).with_name("learning.md")
PICTURE = Path(__file__).with_name("_static") / "learning-curve.png"
CANDIDATES, EACH, ELITE, GENERATIONS = 128, 4, 16, 20
FLOORS = ((0.08, 0.12), (0.12, 0.2), (0.2, 0.35), (0.35, 0.5))
SPINS = (-1.0, -0.5, 0.0, 0.5, 1.0)


def main() -> None:
    """Train, test on places that were not trained on, draw, write."""
    arena = Arena("PuckPush", CANDIDATES * EACH)
    worlds = len(arena.batch)
    fresh = 5 * 10**8 + np.arange(worlds)
    draws = np.random.default_rng(1)

    def at_random(seen: Observations) -> NDArray[np.float64]:
        return draws.uniform(-1.0, 1.0, (len(seen), 2))

    chance = play(arena, at_random, fresh)
    search = CrossEntropy(np.zeros(PUSH_PARAMETERS), 1.0, candidates=CANDIDATES, elite=ELITE, seed=1)
    history = train(arena, push_policy, search, GENERATIONS, tell=_progress)
    mean = np.tile(search.mean, (worlds, 1))

    def as_learned(seen: Observations) -> NDArray[np.float64]:
        return push_policy(mean, seen)

    learned = play(arena, as_learned, fresh)
    elsewhere = {limits: play(Arena(PuckPush(limits), worlds), as_learned, fresh) for limits in FLOORS}
    _draw(history, chance, learned)
    replace(PAGE, "training", _told(history, chance, learned, elsewhere))
    replace(PAGE, "spin", _spins())


def _progress(generation: int, scores: Scores) -> None:
    share = 100.0 * scores.success.mean()
    print(f"generation {generation + 1} of {GENERATIONS}: {share:.0f} % arrive", file=sys.stderr, flush=True)


def _draw(history: list[Scores], chance: Scores, learned: Scores) -> None:
    figure = sheet("PuckPush: a policy of 12 numbers learns to push")
    left, right = figure.subplots(1, 2)
    x = np.arange(1, len(history) + 1)
    of_candidates = np.array([scores.returns.reshape(CANDIDATES, EACH).mean(axis=1) for scores in history])
    low, middle, high = np.quantile(of_candidates, (0.1, 0.5, 0.9), axis=1)
    left.fill_between(x, low, high, color=style.SERIES[0], alpha=0.2, lw=0, label="8 of 10 candidates")
    left.plot(x, middle, color=style.SERIES[0], lw=2, label="median candidate")
    right.plot(x, [100.0 * scores.success.mean() for scores in history], color=style.SERIES[0], lw=2)
    for axes, value, base in (
        (left, learned.returns.mean(), chance.returns.mean()),
        (right, 100.0 * learned.success.mean(), 100.0 * chance.success.mean()),
    ):
        axes.axhline(base, color=style.MUTED_INK, ls="--", lw=1.3, label="actions at random")
        axes.plot(len(history) + 0.6, value, "o", color=style.SERIES[1], label="what was learned, new places")
        axes.set(xlabel="generation", xlim=(0.5, len(history) + 1.0), xticks=range(1, len(history) + 1, 3))
        dress(axes)
    left.set_ylabel("sum of rewards of an episode")
    right.set_ylabel("episodes that arrive, %")
    right.set_ylim(-3.0, 103.0)
    legend(figure, left.get_legend_handles_labels()[0])
    save(figure, PICTURE)


def _told(
    history: list[Scores], chance: Scores, learned: Scores, elsewhere: Mapping[tuple[float, float], Scores]
) -> Iterable[str]:
    yield f"![Sums of rewards and share of arrivals over {len(history)} generations](_static/{PICTURE.name})"
    yield ""
    yield "| policy | mean sum of rewards | arrive |"
    yield "| --- | --- | --- |"
    for name, scores in (
        ("actions at random", chance), ("first generation", history[0]), ("last generation", history[-1]),
        ("what was learned, on new places", learned),
        *((f"the same, all coefficients from {low} to {high}", scores) for (low, high), scores in elsewhere.items()),
    ):  # fmt: skip
        yield f"| {name} | {scores.returns.mean():.2f} | {100.0 * scores.success.mean():.0f} % |"
    yield ""
    yield (
        f"{len(history)} generations of {CANDIDATES} candidates, who all play on the same {EACH} floors, new ones in "
        f"every generation. Coefficients are from {LEAST} to {MOST}."
    )


def _spins() -> Iterable[str]:
    """The same throw with other spins, without sweeping, on the same ice."""
    arena = Arena("Curling", len(SPINS))
    actions = np.zeros((len(SPINS), 4))
    actions[:, 2] = SPINS
    for world in range(len(SPINS)):
        arena.streams[world] = np.random.default_rng(0)
    arena.reset(np.arange(len(SPINS)))
    arena.step(actions)
    spins = arena.batch.angular_velocities[:, 1, 2].copy()
    for _ in range(arena.task.episode):
        arena.step(actions)
    yield "| spin after 1/4 s, rad/s | stops at x, m | to the left, m |"
    yield "| --- | --- | --- |"
    for spin, (x, y, _) in zip(spins, arena.batch.positions[:, 1], strict=True):
        yield f"| {round(float(spin), 2) + 0.0:+.2f} | {x:.2f} | {round(float(y), 3) + 0.0:+.3f} |"


if __name__ == "__main__":
    main()
