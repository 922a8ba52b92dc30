"""What Python calls to step worlds of the soft solver: their arrays come in a book."""

from __future__ import annotations

from stiction.core.jit import entry
from stiction.core.parts import Crew, Number, Table
from stiction.core.soft_book import part_at
from stiction.core.soft_parts import FIND_PART, SOLVE_PART, call_find, call_solve
from stiction.core.soft_step import take_steps
from stiction.core.team import COUNT, FIND, HOME, JOB, MANY, SUBSTEPS, call, meet


@entry
def soft_step(
    steps: int, n: int, book: Table, first: int, last: int, together: int, outcomes: Table, one: Number, bounces: int,
    laws: int, exact: int, team: Crew,
) -> int:  # fmt: skip
    """:func:`stiction.core.soft_step.take_steps` of the worlds from ``first`` to before ``last``, so many of them
    side by side as there is room for on the desk, ``together``; ``one`` is 1 in the precision of the solver.

    A world that has taken its steps is left alone. What no body of the worlds needs is not compiled: ``bounces``,
    ``laws`` and ``exact`` say whether the parts in the book (:mod:`stiction.core.soft_parts`) know of it.
    """
    for w in range(first, last, together):
        take_steps(steps, n, book, w, min(w + together, last), outcomes, one, bounces, laws, exact, team)
    return 0


@entry
def assist(book: Table, one: Number, team: Crew, worker: int) -> int:
    """Do a worker's share of all jobs of the leader, who is in :func:`soft_step` with one world, until the team goes
    home.

    The scratch in the ``book`` is the worker's own.
    """
    words, numbers = team.words, team.numbers
    while True:
        meet(team)
        if words[JOB] == HOME:
            return 0
        if words[JOB] == FIND:
            call_find(
                part_at(book, FIND_PART), (book, 0, 0, words[COUNT], words[MANY], numbers[0], numbers[1], one, team)
            )
            meet(team)
        else:
            h, fresh = numbers[0], int(numbers[1])
            call_solve(
                part_at(book, SOLVE_PART),
                (book, 0, 1, 0, words[COUNT], words[MANY], h, words[SUBSTEPS], fresh, one, team, worker),
            )


@entry
def dismiss(team: Crew) -> int:
    """Send the workers of the team home."""
    call(team, HOME, 0, 0, 0, 0.0, 0.0)
    return 0
