"""How far a long command is: a bar on a terminal, a line in a log."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

from stiction.cli.console import err, say


@contextmanager
def progress(title: str, quiet: bool, doing: str = "simulating") -> Iterator[Callable[[int, int], None]]:
    """A bar on a terminal, a line in a log. The first step may have to compile the kernels, and says so.

    Args:
        title: of what runs.
        quiet: say nothing in a log.
        doing: what goes on, in a word.

    Yields:
        What to call with the steps done and the steps there are.
    """
    from stiction.core import jit

    first = "compiling kernels (once on this machine, about 20 s)" if jit.is_cold() else doing
    if not err.is_terminal:
        if not quiet:
            say(f"{title}: {first} …")
        yield lambda done, total: None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total}"),
    )
    with Progress(*columns, TimeRemainingColumn(), console=err, transient=True) as bar:
        task = bar.add_task(first, total=None)

        def on_progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, description=doing)

        yield on_progress
