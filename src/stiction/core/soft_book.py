"""The book of a world of the soft solver, or of many that are alike: on which page each of its arrays is.

What reads a part is inlined where it is called: of the arrays of a part only those that are used there cost anything.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stiction.core.book import cube_at, matrix_at, rows_at, vector_at, write_book
from stiction.core.collide.hulls import Hulls
from stiction.core.jit import inlined
from stiction.core.pairs import PairCache
from stiction.core.soft_rows import Soft
from stiction.core.soft_scratch import Desk, Scratch
from stiction.core.state import Lists, Settings
from stiction.core.tree import Tree
from stiction.core.vec import Vec3

BODIES, KINDS, TABLE, SETTINGS, LEDGER, CYCLES, PARTS, TREE = range(8)
CACHE = TREE + len(Tree._fields)
SOFT = CACHE + len(PairCache._fields)
SCRATCH = SOFT + len(Soft._fields)
DESK = SCRATCH + len(Scratch._fields)
HULLS = DESK + len(Desk._fields)
BOUNCES = HULLS + len(Hulls._fields)
WIDE = BOUNCES + 3 + len(Lists._fields)
"""Pages at which the parts of a book begin."""

CONTACTS, TAGS, POINTS = (DESK + Desk._fields.index(name) for name in ("contacts", "tags", "points"))
"""Pages of the scratch of one pair."""


def book_of(
    bodies: Any, kinds: Any, table: Any, numbers: Any, ledger: Any, cycles: Any, parts: Any, tree: Any, cache: Any,
    soft: Any, scratch: Any, desk: Any, hulls: Any, *bounces: Any,
) -> Any:  # fmt: skip
    """The book that the step reads; each array may be a block of many worlds.

    ``numbers``: the settings, (10,) float64; ``parts``: addresses of the parts of the step, in their order in
    :mod:`stiction.core.soft_parts`; ``bounces``: contacts, tags, lists and report of the impacts, and room for bodies
    with all columns, or nothing.
    """
    return write_book(
        bodies, kinds, table, numbers, ledger, cycles, parts, tree, cache, soft, scratch, desk, hulls, bounces
    )


def book_of_worker(book: Any, contacts: Any, tags: Any, points: Any) -> Any:
    """The same book with a scratch of one pair of the worker's own."""
    own = book.copy()
    for page, array in ((CONTACTS, contacts), (TAGS, tags), (POINTS, points)):
        own[page] = write_book(array)[0]
    return own


class Rows(NamedTuple):
    """A world's bodies and what belongs to them all."""

    bodies: np.ndarray
    kinds: np.ndarray
    table: np.ndarray
    ledger: np.ndarray
    profile: np.ndarray  # cycles of the stages of a step
    settings: Settings


@inlined
def rows_of(book, w):
    """The rows of world w."""
    x = vector_at(book, SETTINGS, w, 0.0)
    settings = Settings(x[0], x[1], x[2], x[3], int(x[4]), x[5], x[6] != 0.0, int(x[7]), x[8] != 0.0, x[9])
    return Rows(
        matrix_at(book, BODIES, w, 0.0), matrix_at(book, KINDS, w, 0), cube_at(book, TABLE, w, 0.0),
        vector_at(book, LEDGER, w, 0.0), vector_at(book, CYCLES, w, 0), settings,
    )  # fmt: skip


@inlined
def part_at(book, k):
    """Where part k of the step is."""
    return vector_at(book, PARTS, 0, 0)[k]


@inlined
def gravity_of(settings):
    """The acceleration of gravity as a vector."""
    return Vec3(settings.gravity_x, settings.gravity_y, settings.gravity_z)


@inlined
def tree_at(book, w):
    """The tree."""
    k = TREE
    return Tree(
        matrix_at(book, k, w, 0.0),
        matrix_at(book, k + 1, w, 0),
        vector_at(book, k + 2, w, 0),
        vector_at(book, k + 3, w, 0),
    )


@inlined
def cache_at(book, w):
    """The pairs."""
    k = CACHE
    return PairCache(
        matrix_at(book, k, w, 0), matrix_at(book, k + 1, w, np.int32(0)),
        vector_at(book, k + 2, w, np.int32(0)), vector_at(book, k + 3, w, 0),
        vector_at(book, k + 4, w, np.uint8(0)), matrix_at(book, k + 5, w, 0), vector_at(book, k + 6, w, 0),
    )  # fmt: skip


@inlined
def soft_at(book, w, place, one):
    """The rows of the solver; those of bodies are on the desk from row ``place`` on. ``one`` is 1 in its precision."""
    return soft_of_all(book, w, 1, place, one)


@inlined
def soft_of_all(book, w, worlds, place, one):
    """Those of so many worlds from w on, as if they were of one."""
    k = SOFT
    return Soft(
        rows_at(book, k, w, worlds, one), rows_at(book, k + 1, w, worlds, 0.0),
        rows_at(book, k + 2, w, worlds, one), matrix_at(book, k + 3, w, one),
        matrix_at(book, k + 4, w, np.int32(0)), matrix_at(book, k + 5, w, one)[place:],
        matrix_at(book, k + 6, w, one)[place:], matrix_at(book, k + 7, w, 0.0)[place:],
        rows_at(book, k + 8, w, worlds, one), matrix_at(book, k + 9, w, 0.0),
    )  # fmt: skip


@inlined
def scratch_at(book, w):
    """What a world remembers."""
    k = SCRATCH
    return Scratch(
        matrix_at(book, k, w, 0), vector_at(book, k + 1, w, 0), vector_at(book, k + 2, w, 0.0),
        vector_at(book, k + 3, w, 0.0),
    )  # fmt: skip


@inlined
def desk_at(book):
    """The lists of the steps taken at this desk."""
    k, small = DESK, np.int32(0)
    return Desk(
        matrix_at(book, k, 0, small), matrix_at(book, k + 1, 0, small), matrix_at(book, k + 2, 0, 0),
        matrix_at(book, k + 3, 0, 0.0), matrix_at(book, k + 4, 0, small), matrix_at(book, k + 5, 0, 0),
        matrix_at(book, k + 6, 0, 0), matrix_at(book, k + 7, 0, 0), vector_at(book, k + 8, 0, 0),
        matrix_at(book, k + 9, 0, 0.0), matrix_at(book, k + 10, 0, 0), matrix_at(book, k + 11, 0, 0.0),
    )  # fmt: skip


@inlined
def hulls_at(book, w, wanted):
    """The table of polytopes, or None."""
    if wanted is None:
        return None
    k = HULLS
    return Hulls(
        matrix_at(book, k, w, 0), vector_at(book, k + 1, w, 0.0),
        matrix_at(book, k + 2, w, 0.0), matrix_at(book, k + 3, w, 0.0),
        matrix_at(book, k + 4, w, 0.0), matrix_at(book, k + 5, w, 0),
        vector_at(book, k + 6, w, 0), matrix_at(book, k + 7, w, 0),
    )  # fmt: skip


@inlined
def bounces_at(book, w):
    """Rows of contacts, their tags, lists and the report of the impacts, and room for bodies."""
    k = BOUNCES
    lists = Lists(
        vector_at(book, k + 2, w, 0), matrix_at(book, k + 3, w, 0),
        vector_at(book, k + 4, w, 0), vector_at(book, k + 5, w, 0),
        vector_at(book, k + 6, w, 0.0), vector_at(book, k + 7, w, 0), matrix_at(book, k + 8, w, 0.0),
        vector_at(book, k + 9, w, 0.0), matrix_at(book, k + 10, w, 0.0), matrix_at(book, k + 11, w, 0.0),
    )  # fmt: skip
    report, wide = matrix_at(book, WIDE - 1, w, 0.0), matrix_at(book, WIDE, w, 0.0)
    return matrix_at(book, k, w, 0.0), matrix_at(book, k + 1, w, 0), lists, report, wide
