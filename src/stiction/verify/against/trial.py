"""What a trial is: a scene that every engine can build, one number to measure in it, and what the formula says.

A trial speaks of friction only through what can be seen from outside: where bodies are and how fast. It is asked in
several variants (directions, yaws, spins) where an engine may favour one of them; the worst variant counts.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from stiction.bench.engines import Engine
from stiction.bench.scene import BenchScene

Array = NDArray[np.float64]

G = 9.81
"""m/s^2"""
LAWS = "Newton's second law and Coulomb's law"


@dataclass(frozen=True)
class Track:
    """What was seen of one world, once a frame.

    Attributes:
        dt: s between frames.
        positions, velocities, spins: (frames, bodies, 3) m, m/s and rad/s; the first frame is the start.
        orientations: (frames, bodies, 4) quaternions (w, x, y, z).
    """

    dt: float
    positions: Array
    orientations: Array
    velocities: Array
    spins: Array

    def at(self, seconds: float) -> int:
        """Number of the frame at a time."""
        return min(round(seconds / self.dt), len(self.positions) - 1)

    def moved(self, body: int = 1) -> Array:
        """From start to end, (3,) m."""
        return np.asarray(self.positions[-1, body] - self.positions[0, body])

    def creep(self, begin: float, body: int = 1) -> float:
        """Mean speed from ``begin`` s to the end, m/s."""
        k = self.at(begin)
        way = self.positions[-1, body] - self.positions[k, body]
        return float(np.linalg.norm(way)) / ((len(self.positions) - 1 - k) * self.dt)


@dataclass(frozen=True)
class Reading:
    """What a formula says, and what the variants of a trial gave."""

    expected: float
    values: tuple[float, ...]

    @property
    def worst(self) -> float:
        """The value farthest from what is expected; NaN where one never came about."""
        return max(self.values, key=lambda value: math.inf if math.isnan(value) else abs(value - self.expected))


class Trial(ABC):
    """One question to all engines. Subclasses set the attributes and write :meth:`scenes` and :meth:`read`.

    Attributes:
        name: in kebab-case, unique.
        title: what must happen.
        formula, source: of what is expected.
        unit: of expected and measured.
        relative: whether error and tolerance are shares of what is expected (shown in %), or in ``unit``.
        tolerance: largest error that passes; the same for all engines.
        tolerance_reason: why it is that large.
        seconds: simulated.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    formula: ClassVar[str]
    source: ClassVar[str] = LAWS
    unit: ClassVar[str] = ""
    relative: ClassVar[bool] = True
    tolerance: ClassVar[float] = 0.01
    tolerance_reason: ClassVar[str] = "one per cent: what first-order integration at 1/60 s may cost"
    seconds: ClassVar[float] = 2.0

    @abstractmethod
    def scenes(self) -> Sequence[BenchScene]:
        """One world for each variant."""

    @abstractmethod
    def read(self, tracks: Sequence[Track]) -> Reading:
        """The number in question, from what became of each world."""

    def play(self, engine: Engine, dt: float, substeps: int) -> Score:
        """Run all variants in one engine.

        Args:
            engine: that is asked; worlds are made in it one after the other.
            dt: s between frames. substeps: steps that the engine takes in each.
        """
        scenes = self.scenes()
        for scene in scenes:
            reason = engine.supports(scene)
            if reason is not None:
                return Score(self.name, engine.name, skipped=reason)
        try:
            tracks = [follow(engine, scene, self.seconds, dt, substeps) for scene in scenes]
            reading = self.read(tracks)
        except (RuntimeError, ValueError, ArithmeticError) as error:
            return Score(self.name, engine.name, failed=str(error) or type(error).__name__)
        return self.judge(engine.name, reading)

    def judge(self, engine: str, reading: Reading) -> Score:
        """A score from a reading."""
        error = abs(reading.worst - reading.expected)
        if self.relative:
            error /= abs(reading.expected)
        return Score(self.name, engine, reading.expected, list(reading.values), error, self.tolerance)


@dataclass
class Score:
    """How one engine did in one trial.

    Attributes:
        trial, engine: by name.
        expected: by the formula. values: of the variants.
        error: of the worst variant, as a share of what is expected if the trial is relative.
        tolerance: of the trial.
        skipped: why the engine cannot express it. failed: how it broke down. Both None if there is a result.
    """

    trial: str
    engine: str
    expected: float = math.nan
    values: list[float] | None = None
    error: float = math.nan
    tolerance: float = math.nan
    skipped: str | None = None
    failed: str | None = None

    @property
    def passed(self) -> bool | None:
        """Whether the error is within the tolerance; None where the engine was not asked."""
        return None if self.skipped is not None else self.error <= self.tolerance

    @property
    def severity(self) -> float:
        """log10 of error over tolerance, 0 on the edge; at most 4, and 4 where there is nothing to measure."""
        if self.skipped is not None:
            return math.nan
        if not math.isfinite(self.error):
            return 4.0
        return min(4.0, max(-4.0, math.log10(max(self.error / self.tolerance, 1e-4))))

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {**asdict(self), "passed": self.passed}


def follow(engine: Engine, scene: BenchScene, seconds: float, dt: float, substeps: int) -> Track:
    """Build a world and watch it for a while, seeing it every ``dt`` s, in which it takes ``substeps`` steps."""
    engine.build(scene, dt / substeps)
    frames: list[tuple[Array, Array, Array, Array]] = [_look(engine)]
    for _ in range(max(1, round(seconds / dt))):
        for _ in range(substeps):
            engine.before_step()
            engine.step()
        frames.append(_look(engine))
    return Track(dt, *(np.array(column) for column in zip(*frames, strict=True)))


def _look(engine: Engine) -> tuple[Array, Array, Array, Array]:
    return engine.positions(), engine.orientations(), engine.velocities(), engine.angular_velocities()


def stops(sizes: Array, dt: float) -> float:
    """When a quantity that falls in a straight line reaches zero, s, by the step before; NaN if it does not "
    "come down."""
    for k in range(2, len(sizes)):
        if sizes[k] <= 1e-3 * sizes[0]:
            fell = sizes[k - 2] - sizes[k - 1]
            return float(dt * (k - 1 + (sizes[k - 1] / fell if fell > 0.0 else 0.0)))
    return math.nan
