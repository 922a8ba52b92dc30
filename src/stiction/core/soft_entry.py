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


def book_of(
    bodies: Any, kinds: Any, table: Any, settings: Settings, ledger: Any, cycles: Any, tree: Tree, cache: PairCache,
    soft: Soft, scratch: Scratch, hulls: Hulls, *bounces: Any,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The book that :func:`soft_step` reads, and an array in it that nobody else keeps. ``bounces``: contacts, tags,
    lists and report of the impacts, or nothing."""
    numbers = np.array(settings, np.float64)
    return write_book(
        bodies, kinds, table, numbers, ledger, cycles, tree, cache, soft, scratch, hulls, bounces
    ), numbers


@entry
def soft_step(steps, n, book, one, boxes_meet, hulls, bounces, rolls, laws, exact, team):
    """:func:`stiction.core.soft_step.take_steps` of n bodies; ``one`` is 1 in the precision of the solver.

    ``boxes_meet``, ``hulls``, ``bounces``, ``rolls``, ``laws`` and ``exact`` are None or 1: what no body of the world
    needs is not compiled.
    """
    return take_steps(
        steps, matrix_at(book, BODIES, 0.0), matrix_at(book, KINDS, 0), n, tree_at(book, TREE), cache_at(book, CACHE),
        soft_at(book, SOFT, one), scratch_at(book, SCRATCH), cube_at(book, TABLE, 0.0), settings_at(book, SETTINGS),
        vector_at(book, LEDGER, 0.0), vector_at(book, CYCLES, 0), boxes_meet, hulls_at(book, HULLS, hulls),
        bounces_at(book, BOUNCES, bounces), rolls, laws, exact, team,
    )  # fmt: skip


@jit
def settings_at(book, k):
    """The constants of a call."""
    x = vector_at(book, k, 0.0)
    return Settings(x[0], x[1], x[2], x[3], int(x[4]), x[5], x[6] != 0.0, int(x[7]), x[8] != 0.0, x[9])


@jit
def tree_at(book, k):
    """The tree from page k."""
    return Tree(
        matrix_at(book, k, 0.0), matrix_at(book, k + 1, 0), vector_at(book, k + 2, 0), vector_at(book, k + 3, 0)
    )


@jit
def cache_at(book, k):
    """The pairs."""
    return PairCache(
        matrix_at(book, k, 0), matrix_at(book, k + 1, 0), matrix_at(book, k + 2, 0), vector_at(book, k + 3, 0),
        vector_at(book, k + 4, np.uint8(0)), matrix_at(book, k + 5, 0), vector_at(book, k + 6, 0),
    )  # fmt: skip


@jit
def soft_at(book, k, one):
    """The rows of the solver."""
    return Soft(
        matrix_at(book, k, one), matrix_at(book, k + 1, 0.0), matrix_at(book, k + 2, one), matrix_at(book, k + 3, one),
        matrix_at(book, k + 4, np.int32(0)), matrix_at(book, k + 5, one), matrix_at(book, k + 6, one),
        matrix_at(book, k + 7, 0.0), matrix_at(book, k + 8, one), matrix_at(book, k + 9, 0.0),
    )  # fmt: skip


@jit
def scratch_at(book, k):
    """The lists of a step."""
    return Scratch(
        matrix_at(book, k, 0), matrix_at(book, k + 1, 0), matrix_at(book, k + 2, 0.0), vector_at(book, k + 3, 0),
        matrix_at(book, k + 4, 0.0), matrix_at(book, k + 5, 0), matrix_at(book, k + 6, 0.0),
        vector_at(book, k + 7, 0.0),
    )  # fmt: skip


@jit
def hulls_at(book, k, wanted):
    """The table of polytopes, or None."""
    if wanted is None:
        return None
    return Hulls(
        matrix_at(book, k, 0), vector_at(book, k + 1, 0.0), matrix_at(book, k + 2, 0.0), matrix_at(book, k + 3, 0.0),
        matrix_at(book, k + 4, 0.0), matrix_at(book, k + 5, 0), vector_at(book, k + 6, 0), matrix_at(book, k + 7, 0),
    )  # fmt: skip


@jit
def bounces_at(book, k, wanted):
    """Rows of contacts, their tags, lists and the report of the impacts, or None."""
    if wanted is None:
        return None
    lists = Lists(
        vector_at(book, k + 2, 0), matrix_at(book, k + 3, 0), vector_at(book, k + 4, 0), vector_at(book, k + 5, 0),
        vector_at(book, k + 6, 0.0), vector_at(book, k + 7, 0), matrix_at(book, k + 8, 0.0),
        vector_at(book, k + 9, 0.0), matrix_at(book, k + 10, 0.0), matrix_at(book, k + 11, 0.0),
    )  # fmt: skip
    return matrix_at(book, k, 0.0), matrix_at(book, k + 1, 0), lists, matrix_at(book, k + 12, 0.0)
