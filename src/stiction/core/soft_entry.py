"""What Python calls to step a world of the soft solver: its arrays come in a book."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction.core.book import cube_at, matrix_at, vector_at, write_book
from stiction.core.collide.hulls import Hulls
from stiction.core.jit import entry, jit
from stiction.core.pairs import PairCache
from stiction.core.soft_rows import Soft
from stiction.core.soft_step import Scratch, take_steps
from stiction.core.state import Lists, Settings
from stiction.core.tree import Tree

BODIES, KINDS, TABLE, SETTINGS, LEDGER, CYCLES, TREE = range(7)
CACHE = TREE + len(Tree._fields)
SOFT = CACHE + len(PairCache._fields)
SCRATCH = SOFT + len(Soft._fields)
HULLS = SCRATCH + len(Scratch._fields)
BOUNCES = HULLS + len(Hulls._fields)
"""Pages at which the parts of a book begin."""

TAKEN, REASON, NUMBER, OUTCOME_WIDTH = range(4)
"""Columns of the outcomes."""


def book_of(
    bodies: Any, kinds: Any, table: Any, numbers: Any, ledger: Any, cycles: Any, tree: Any, cache: Any, soft: Any,
    scratch: Any, hulls: Any, *bounces: Any,
) -> np.ndarray:  # fmt: skip
    """The book that :func:`soft_step` reads. ``numbers``: the settings, (10,) float64; ``bounces``: contacts, tags,
    lists and report of the impacts, or nothing. Each array may be a block of many worlds."""
    return write_book(bodies, kinds, table, numbers, ledger, cycles, tree, cache, soft, scratch, hulls, bounces)


@entry
def soft_step(steps, n, book, first, last, outcomes, one, boxes_meet, hulls, bounces, rolls, laws, exact, team):
    """:func:`stiction.core.soft_step.take_steps` of the worlds from ``first`` to before ``last``, of n bodies each,
    until each has taken so many steps; ``one`` is 1 in the precision of the solver.

    ``outcomes`` (worlds, 3) int64 has how many each has taken, why its last call returned, and the number that goes
    with the reason; a world that has taken its steps is left alone.
    ``boxes_meet``, ``hulls``, ``bounces``, ``rolls``, ``laws`` and ``exact`` are None or 1: what no body of the worlds
    needs is not compiled.
    """
    for w in range(first, last):
        left = steps - outcomes[w, TAKEN]
        if left <= 0:
            continue
        reason, done, number = take_steps(
            left, matrix_at(book, BODIES, w, 0.0), matrix_at(book, KINDS, w, 0), n, tree_at(book, TREE, w),
            cache_at(book, CACHE, w), soft_at(book, SOFT, w, one), scratch_at(book, SCRATCH, w),
            cube_at(book, TABLE, w, 0.0), settings_at(book, SETTINGS, w), vector_at(book, LEDGER, w, 0.0),
            vector_at(book, CYCLES, w, 0), boxes_meet, hulls_at(book, HULLS, w, hulls),
            bounces_at(book, BOUNCES, w, bounces), rolls, laws, exact, team,
        )  # fmt: skip
        outcomes[w, TAKEN] += done
        outcomes[w, REASON], outcomes[w, NUMBER] = reason, number


@jit
def settings_at(book, k, w):
    """The constants of a call."""
    x = vector_at(book, k, w, 0.0)
    return Settings(x[0], x[1], x[2], x[3], int(x[4]), x[5], x[6] != 0.0, int(x[7]), x[8] != 0.0, x[9])


@jit
def tree_at(book, k, w):
    """The tree from page k."""
    return Tree(
        matrix_at(book, k, w, 0.0),
        matrix_at(book, k + 1, w, 0),
        vector_at(book, k + 2, w, 0),
        vector_at(book, k + 3, w, 0),
    )


@jit
def cache_at(book, k, w):
    """The pairs."""
    return PairCache(
        matrix_at(book, k, w, 0), matrix_at(book, k + 1, w, 0),
        matrix_at(book, k + 2, w, 0), vector_at(book, k + 3, w, 0),
        vector_at(book, k + 4, w, np.uint8(0)), matrix_at(book, k + 5, w, 0), vector_at(book, k + 6, w, 0),
    )  # fmt: skip


@jit
def soft_at(book, k, w, one):
    """The rows of the solver."""
    return Soft(
        matrix_at(book, k, w, one), matrix_at(book, k + 1, w, 0.0),
        matrix_at(book, k + 2, w, one), matrix_at(book, k + 3, w, one),
        matrix_at(book, k + 4, w, np.int32(0)), matrix_at(book, k + 5, w, one), matrix_at(book, k + 6, w, one),
        matrix_at(book, k + 7, w, 0.0), matrix_at(book, k + 8, w, one), matrix_at(book, k + 9, w, 0.0),
    )  # fmt: skip


@jit
def scratch_at(book, k, w):
    """The lists of a step."""
    return Scratch(
        matrix_at(book, k, w, 0), matrix_at(book, k + 1, w, 0),
        matrix_at(book, k + 2, w, 0.0), vector_at(book, k + 3, w, 0),
        matrix_at(book, k + 4, w, 0.0), matrix_at(book, k + 5, w, 0), matrix_at(book, k + 6, w, 0.0),
        vector_at(book, k + 7, w, 0.0),
    )  # fmt: skip


@jit
def hulls_at(book, k, w, wanted):
    """The table of polytopes, or None."""
    if wanted is None:
        return None
    return Hulls(
        matrix_at(book, k, w, 0), vector_at(book, k + 1, w, 0.0),
        matrix_at(book, k + 2, w, 0.0), matrix_at(book, k + 3, w, 0.0),
        matrix_at(book, k + 4, w, 0.0), matrix_at(book, k + 5, w, 0),
        vector_at(book, k + 6, w, 0), matrix_at(book, k + 7, w, 0),
    )  # fmt: skip


@jit
def bounces_at(book, k, w, wanted):
    """Rows of contacts, their tags, lists and the report of the impacts, or None."""
    if wanted is None:
        return None
    lists = Lists(
        vector_at(book, k + 2, w, 0), matrix_at(book, k + 3, w, 0),
        vector_at(book, k + 4, w, 0), vector_at(book, k + 5, w, 0),
        vector_at(book, k + 6, w, 0.0), vector_at(book, k + 7, w, 0), matrix_at(book, k + 8, w, 0.0),
        vector_at(book, k + 9, w, 0.0), matrix_at(book, k + 10, w, 0.0), matrix_at(book, k + 11, w, 0.0),
    )  # fmt: skip
    return matrix_at(book, k, w, 0.0), matrix_at(book, k + 1, w, 0), lists, matrix_at(book, k + 12, w, 0.0)
