"""How far a long command is, told in one place: a bar on a terminal, lines in a log, nothing with ``--quiet``."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Protocol

from stiction.cli.console import err, is_quiet, say

LOG_EVERY = 10.0
"""s from one line to the next where there is no terminal for a bar."""
WINDOW = 5.0
"""s over which a pace is measured."""


class Show(Protocol):
    """Tells how far something is: what goes on, what is done of what there is (None if unknown), and a few words."""

    def __call__(self, doing: str, done: int = 0, total: int | None = None, told: str = "") -> None: ...


class Pace:
    """How fast something goes, as of late. It counts from the first note, so that what came before, such as compiling,
    does not count.

    Args:
        clock: seconds from some moment on.

    Attributes:
        rate: done a second, 0 while unknown.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._notes: deque[tuple[float, int]] = deque()
        self.rate = 0.0

    def note(self, done: int) -> None:
        """So much is done by now."""
        now = self._clock()
        self._notes.append((now, done))
        while len(self._notes) > 2 and now - self._notes[1][0] > WINDOW:
            self._notes.popleft()
        began, before = self._notes[0]
        if now > began and done > before:
            self.rate = (done - before) / (now - began)

    def left(self, missing: int) -> float:
        """How long the rest takes at that rate, s; NaN while unknown."""
        return missing / self.rate if self.rate else math.nan


@contextmanager
def bar(quiet: bool = False, every: float = LOG_EVERY) -> Iterator[Show]:
    """The bar that all commands share.

    Args:
        quiet: write no lines into a log; a terminal has its bar all the same.
        every: s from one line of a log to the next; what goes on is told whenever it changes.
    """
    if is_quiet() or (quiet and not err.is_terminal):
        yield lambda doing, done=0, total=None, told="": None
        return
    if err.is_terminal:
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(None),
            TextColumn("{task.fields[told]}"),
        )
        with Progress(*columns, console=err, transient=True, expand=True) as live:
            task = live.add_task("starting", total=None, told="")

            def show(doing: str, done: int = 0, total: int | None = None, told: str = "") -> None:
                live.update(task, description=doing, completed=done, total=total, told=told)

            yield show
        return
    last, before = -math.inf, ""

    def tell(doing: str, done: int = 0, total: int | None = None, told: str = "") -> None:
        nonlocal last, before
        if doing == before and time.monotonic() - last < every:
            return
        last, before = time.monotonic(), doing
        say(f"  {doing}: {told}" if told else f"  {doing} …")

    yield tell


@contextmanager
def progress(
    title: str,
    quiet: bool = False,
    doing: str = "simulating",
    *,
    dt: float | None = None,
    unit: str = "steps",
    compiles: bool = True,
) -> Iterator[Callable[[int, int], None]]:
    """How far a run is: steps, steps a second, simulated time and time left.

    Args:
        title: of what runs.
        quiet: write no lines into a log.
        doing: what goes on, in a word.
        dt: time step, s; without it there is no simulated time.
        unit: what is counted.
        compiles: the first one may have to compile kernels, and says so when it does.

    Yields:
        What to call with the steps done and the steps there are.
    """
    pace = Pace()
    with ExitStack() as stack:
        show = stack.enter_context(bar(quiet))
        named = "{}" if err.is_terminal else f"{title}: {{}}"
        show(named.format(doing))
        if compiles:
            from stiction.cli.kernels import noting_times

            stack.enter_context(noting_times(lambda: show(named.format("compiling kernels, once on this machine"))))

        def on_progress(done: int, total: int) -> None:
            pace.note(done)
            told = [f"{done}/{total} {unit}"]
            if pace.rate:
                told.append(f"{pace.rate:.{0 if pace.rate >= 10.0 else 2}f} {unit}/s")
            if dt is not None:
                told.append(f"{done * dt:.2f} of {total * dt:.2f} s")
            if pace.rate and done < total:
                told.append(f"{span(pace.left(total - done))} left")
            show(named.format(doing), done, total, ", ".join(told))

        yield on_progress


@contextmanager
def counting(total: int | None = None, quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """How far a list of jobs is.

    Args:
        total: how many there are, if that is known.
        quiet: write no lines into a log.

    Yields:
        What to call with a job's name before it begins.
    """
    pace = Pace()
    begun = 0
    with bar(quiet) as show:

        def on_begin(name: str) -> None:
            nonlocal begun
            pace.note(begun)
            of_all = f"/{total}" if total else ""
            left = f", {span(pace.left(total - begun))} left" if total and pace.rate else ""
            begun += 1
            show(name, begun - 1, total, f"{begun}{of_all}{left}" if err.is_terminal else "")

        yield on_begin


def span(seconds: float) -> str:
    """A length of time in a unit that suits it."""
    if not math.isfinite(seconds):
        return "?"
    if seconds < 1.0:
        return f"{1e3 * seconds:.3g} ms"
    if seconds < 120.0:
        return f"{seconds:.3g} s"
    minutes = seconds / 60.0
    return f"{minutes:.3g} min" if minutes < 120.0 else f"{minutes / 60.0:.3g} h"
