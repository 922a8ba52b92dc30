"""What Python calls to step worlds of the soft solver: their arrays come in a book."""

from __future__ import annotations

from stiction.core.jit import entry
from stiction.core.soft_step import take_steps


@entry
def soft_step(
    steps, n, book, first, last, together, outcomes, one, boxes_meet, hulls, bounces, rolls, laws, exact, team
):  # fmt: skip
    """:func:`stiction.core.soft_step.take_steps` of the worlds from ``first`` to before ``last``, so many of them
    side by side as there is room for on the desk, ``together``; ``one`` is 1 in the precision of the solver.

    A world that has taken its steps is left alone.
    ``boxes_meet``, ``hulls``, ``bounces``, ``rolls``, ``laws`` and ``exact`` are None or 1: what no body of the worlds
    needs is not compiled.
    """
    for w in range(first, last, together):
        take_steps(
            steps, n, book, w, min(w + together, last), outcomes, one, boxes_meet, hulls, bounces, rolls, laws, exact,
            team,
        )  # fmt: skip
