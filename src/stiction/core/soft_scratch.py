"""What a step of the soft solver keeps beside the rows: lists of a world, and the desk at which a worker takes steps.

What a world remembers is its :class:`Scratch`. What a step fills before it reads it is on the :class:`Desk`: many
worlds are stepped at one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction.core.colouring import GROUPS, WAYS
from stiction.core.memory import zeros
from stiction.core.pieces import PIECE_WIDTH, room_for_pieces
from stiction.core.slots import LOOKED_WIDTH
from stiction.core.solve.exact import TALLY
from stiction.core.state import CONTACT_WIDTH, SCRATCH, TAGS_WIDTH

AWAKE, EDITED, BODY_LISTS = range(3)
"""Rows of the lists of bodies that a world keeps: those awake, and those that were changed from outside."""

N_AWAKE, N_EDITED, N_KNOWN, STALE, STEP, WATCHED, HARD, BLOCKS, N_LAST, UNCUT, BLOCK_ROWS, COUNTS = range(12)
"""Entries of the counts: bodies awake, bodies changed from outside, bodies seen before; whether the list of those awake
is out of date; steps so far; whether bodies that sleep may have been changed without a word; whether a light body
carries a heavy one; blocks of the last step; bodies at the end of the last call; steps until islands are looked for
again; rows of these blocks, or of those for which there was no room."""

TOUCHING, MOVING, MARK, GLIDE, USED, GROUP, RESTLESS, LISTS = range(8)
"""Rows of the lists on a desk: the bodies in contact, by world; the rows of those of them that move; a mark for each
body in contact, by world; how each row moves; scratch of colouring, of islands and of sleep."""

ROLE, FROM, ACTIVE, TAKING_PART, TOUCH, SUBSTEPS, FRESH, BOUNCING, PLACE, FILL, NOTES = range(11)
"""What is noted of a world in the middle of a step: whether it waits (NOBODY: it does not); where its active manifolds
begin in the list and how many they are; how many bodies are awake, and how many in contact; substeps; which manifolds
are new; points that bounce; where its bodies begin in the rows on the desk, and when those of bodies that are
not awake have to be filled."""

NEVER, ONCE, ALWAYS = range(3)
"""When the rows of bodies that are not awake are filled: they stay on the desk; in the next step, for they come from
elsewhere; in each step, because other worlds use them in between."""

PAIR_CONTACTS = 8
"""Room for the contact points of one pair."""


class Scratch(NamedTuple):
    """What the soft step remembers of a world of n bodies."""

    bodies: np.ndarray  # (BODY_LISTS, n) int64
    counts: np.ndarray  # (COUNTS,) int64
    tally: np.ndarray  # (TALLY,) of the exact solver
    pull: np.ndarray  # (3,) gravity at the end of the last call, m/s^2


class Desk(NamedTuple):
    """Lists of a step of some worlds, of n bodies and p pairs each, of which m touch."""

    looked: np.ndarray  # (p, LOOKED_WIDTH) int32: what was found of each pair of a world; those to be looked at
    active: np.ndarray  # (worlds x m, 4) int32: a, b, slot, place (colouring) of the manifolds with points
    lists: np.ndarray  # (LISTS, worlds x (n + 1)) int64
    normals: np.ndarray  # (worlds x (n + 1), 6): n of the plane in which a row glides, and r x n of where it touches,
    # r from its centre of mass; or, first, the acceleration with which it falls
    ordered: np.ndarray  # (m, 4) int32, scratch: active manifolds in the order of their pieces
    pieces: np.ndarray  # (pieces, PIECE_WIDTH) int64 (pieces.py)
    sizes: np.ndarray  # (pieces, (1 + WAYS) GROUPS) int64: manifolds of each group; where those begin that did alike
    notes: np.ndarray  # (worlds, NOTES) int64
    failed: np.ndarray  # (worlds,) int64: whether a body's state would not be finite
    contacts: np.ndarray  # scratch of one pair
    tags: np.ndarray
    points: np.ndarray


def make_scratch(n: int) -> Scratch:
    """Room for n bodies."""
    scratch = Scratch(np.zeros((BODY_LISTS, n), np.int64), np.zeros(COUNTS, np.int64), np.zeros(TALLY), np.zeros(3))
    scratch.counts[STALE] = 1
    return scratch


def make_desk(n: int, p: int, m: int, worlds: int = 1, fill: int = NEVER) -> Desk:
    """Room for so many worlds of n bodies and p pairs, of which m touch; only one that is alone is cut into pieces."""
    pieces = room_for_pieces(m) if worlds == 1 else 1
    desk = Desk(
        looked=zeros((p, LOOKED_WIDTH), np.int32),
        active=zeros((worlds * m, 4), np.int32),
        lists=zeros((LISTS, worlds * (n + 1)), np.int64),
        normals=zeros((worlds * (n + 1), 6)),
        ordered=zeros((m if pieces > 1 else 1, 4), np.int32),
        pieces=np.zeros((pieces, PIECE_WIDTH), np.int64),
        sizes=np.zeros((pieces, (1 + WAYS) * GROUPS), np.int64),
        notes=np.zeros((worlds, NOTES), np.int64),
        failed=np.zeros(worlds, np.int64),
        contacts=np.zeros((PAIR_CONTACTS, CONTACT_WIDTH)),
        tags=np.zeros((PAIR_CONTACTS, TAGS_WIDTH), np.int64),
        points=np.zeros((SCRATCH, 5)),
    )
    desk.notes[:, FILL] = fill
    return desk
