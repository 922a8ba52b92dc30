"""Many runs: engines on scenes of several sizes, in turn, each in a process of its own.

Engines take turns (A B C A B C ...), so that a machine that gets slower or hotter meanwhile is unfair to none, and the
median over the turns is told. Every run has a fresh process by default: an engine that changes rounding, opens threads
or leaks cannot disturb the next one, and one that crashes ends its own run only.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from stiction import checks
from stiction.bench import scenes
from stiction.bench.engines import ENGINES, OWN, PEERS, engine_class
from stiction.bench.single import Outcome, Task, run_here
from stiction.bench.stability import Stability
from stiction.errors import InvalidInputError

Progress = Callable[[str], None]


@dataclass
class Row:
    """All runs of one engine on one scene of one size.

    Attributes:
        engine, scene: by name.
        bodies: dynamic ones.
        outcomes: of the runs that were not skipped, in order.
        skipped: why there are none.
    """

    engine: str
    scene: str
    bodies: int = 0
    outcomes: list[Outcome] = field(default_factory=list)
    skipped: str | None = None

    @property
    def good(self) -> list[Outcome]:
        """Runs that did not fail."""
        return [outcome for outcome in self.outcomes if outcome.failed is None]

    @property
    def failed(self) -> str | None:
        """How the first run that failed did so, if none went well."""
        if self.good or not self.outcomes:
            return None
        return self.outcomes[0].failed

    @property
    def settled(self) -> bool:
        """Whether the time limit let it come to measured steps; times of a scene that still settles are no result."""
        return bool(self.good) and all(outcome.steps > 0 for outcome in self.good)

    def median(self, what: str = "wall") -> float:
        """Median over the runs of a time in ms a step; NaN without runs."""
        values = [getattr(outcome, what) for outcome in self.good]
        return float(statistics.median(values)) if values else math.nan

    @property
    def spread(self) -> tuple[float, float]:
        """Smallest and largest wall time over the runs, ms a step."""
        values = [outcome.wall for outcome in self.good] or [math.nan]
        return min(values), max(values)

    @property
    def stability(self) -> Stability | None:
        """Of the last run; engines repeat themselves, so that one is as good as another."""
        return self.good[-1].stability if self.good else None


class Table(list[Row]):
    """Rows, and how they compare."""

    def ratio(self, row: Row) -> float:
        """Time of a row over that of the fastest peer on the same scene at the same size; NaN if one has no result."""
        group = (row.scene, row.bodies)
        times = [r.median() for r in self if r.engine in PEERS and r.settled and (r.scene, r.bodies) == group]
        return row.median() / min(times) if times and row.settled else math.nan


@dataclass(frozen=True)
class Plan:
    """What to measure. Names are checked when it is made.

    Attributes:
        scenes, engines: by name. sizes: of the scenes that come in sizes; each one's own if empty.
        runs: turns of each engine.
        isolated: each run in a process of its own.
        solver, dt, settle, steps, limit, seed, profile: as in :class:`Task`.
    """

    scenes: tuple[str, ...] = scenes.DEFAULT_SCENES
    engines: tuple[str, ...] = ENGINES
    sizes: tuple[int, ...] = ()
    runs: int = 3
    isolated: bool = True
    solver: str | None = None
    dt: float = 1.0 / 60.0
    settle: int = 120
    steps: int = 180
    limit: float = 60.0
    seed: int | None = None
    profile: bool = False

    def __post_init__(self) -> None:
        for name in self.scenes:
            checks.one_of("scene", name, scenes.SCENES)
        for name in self.engines:
            checks.one_of("engine", name, ENGINES)
        for size in self.sizes:
            checks.integer("sizes", size, minimum=1)
        checks.integer("runs", self.runs, minimum=1)
        checks.integer("settle", self.settle, minimum=0)
        checks.integer("steps", self.steps, minimum=1)
        checks.positive("dt", self.dt, "s")
        checks.positive("limit", self.limit, "s")
        if self.solver is not None:
            from stiction.world import World

            World(solver=self.solver)  # raises where this version does not have it
        if not self.engines:
            raise InvalidInputError("engines must name at least one, got none.")

    def groups(self) -> Iterator[tuple[str, int | None]]:
        """Each scene at each of its sizes."""
        for name in self.scenes:
            sizes = self.sizes if self.sizes and scenes.SCENES[name].scalable else (None,)
            for size in sizes:
                yield name, size

    def task(self, engine: str, scene: str, size: int | None) -> Task:
        """One run of this plan."""
        own = engine == OWN
        given = {"dt": self.dt, "settle": self.settle, "steps": self.steps, "limit": self.limit, "seed": self.seed}
        return Task(engine, scene, size, self.solver if own else None, profile=self.profile and own, **given)  # type: ignore[arg-type]  # a dict of mixed values


def run_plan(plan: Plan, table: Table, progress: Progress | None = None) -> None:
    """Run the plan and append to the table as results come, so that an interrupted plan leaves what it has.

    Args:
        plan: what to measure.
        table: rows are appended to it.
        progress: told what is about to run.
    """
    run: Callable[[Task], Outcome] = run_here
    if plan.isolated:
        from stiction.bench.worker import run_apart

        run = run_apart
    for scene, size in plan.groups():
        rows = [Row(engine, scene) for engine in plan.engines]
        for turn in range(plan.runs):
            for row in rows:
                if row.skipped is not None or row.failed is not None:
                    continue
                if progress is not None:
                    progress(
                        f"{scene}{'' if size is None else f' {size}'}, {row.engine}, run {turn + 1} of {plan.runs}"
                    )
                _take(row, run(plan.task(row.engine, scene, size)))
                if not any(known is row for known in table):
                    table.append(row)


def _take(row: Row, outcome: Outcome) -> None:
    row.bodies = max(row.bodies, outcome.bodies)
    if outcome.skipped is not None:
        row.skipped = outcome.skipped
        row.outcomes.clear()
    else:
        row.outcomes.append(outcome)


def installed(names: Iterable[str] = PEERS) -> tuple[str, ...]:
    """Those of the engines that can be imported here."""
    return tuple(name for name in names if engine_class(name).available())
