"""The store of a world with the soft solver: its arrays, how they grow, and the calls of its kernels."""

from __future__ import annotations

import functools
import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.core import pairs as p
from stiction.core import (
    pieces,
    questions,
    removal,
    soft_book,
    soft_entry,
    soft_kernels,
    soft_rows,
    soft_scratch,
    soft_step,
    state,
    touching,
)
from stiction.core.clock import STAGES
from stiction.core.memory import refilled
from stiction.core.pairs import PAIR_A, PAIR_B, PAIRS, SLOT, make_pair_cache, resize_pair_cache
from stiction.core.soft_report import report_contacts
from stiction.core.solve import exact
from stiction.core.tree import NONE, RIGHT, grow_tree, make_tree
from stiction.crew import Crew
from stiction.store import CHUNK, Array, StepFailure, Store, announce_compilation, close_gaps

FEW_BLOCKS = 16
"""Room for blocks to begin with."""
MANY_PAIRS = 4096
"""Room for so many pairs is worth a look now and then whether it is still needed."""
PRECISIONS = {"single": np.float32, "double": np.float64}
_NO_COPY = np.zeros((0, state.BODY_WIDTH))
"""Room for a copy of the bodies in impacts: here they have all columns."""

THINNEST = 3e-5
"""Least principal moment of inertia that single precision can tell from nothing, a part of mass x reach^2: that of a
rod whose radius is 1/130 of its half length."""


BY_SLOT = ("manifolds", "meta", "reports", "corners")
"""Arrays of the solver with a row for each slot of a pair, after one for none. A slot is cleared when it is handed out,
so what is left in a free one means nothing."""


class Needs(NamedTuple):
    """What has to be compiled into the step, and what no body needs."""

    boxes_meet: bool = False
    hulls: bool = False
    bounces: bool = False
    rolls: bool = False
    laws: bool = False
    exact: bool = False

    def parts(self, dtype: Any, team: bool) -> Any:
        """Where the parts of such a step are, compiled now if need be."""
        on = tuple(name for name, wanted in zip(self._fields, self, strict=True) if wanted)
        return soft_kernels.parts_for(dtype is np.float64, team, on)


class SoftStore(Store):
    """Rows of bodies, the tree, the pairs and the manifolds."""

    def __init__(self, precision: str, threads: int = 1, rigid: bool = False) -> None:
        super().__init__()
        self.crew = Crew(threads)
        self.rigid = rigid  # contacts are those of the exact solver
        room, pairs, slots = len(self.bodies), 64, 32
        self.dtype = PRECISIONS[precision]
        self.tree = make_tree(room)
        self.cache = make_pair_cache(room, pairs, slots)
        self.soft = soft_rows.make_soft(room, slots, self.dtype, blocks=FEW_BLOCKS)
        self.scratch = soft_scratch.make_scratch(room)
        self.desk = soft_scratch.make_desk(room, pairs, slots)
        self.cycles = np.zeros(len(STAGES) + 1, np.int64)
        self.seconds = 0.0
        self._table: Array | None = None
        self._one = self.dtype(1.0)
        self._outcome = np.zeros((1, soft_step.OUTCOME_WIDTH), np.int64)
        self._written: tuple[tuple[int, ...], tuple[Any, ...], Any] = (), (), None
        self._needs: tuple[tuple[int, ...], Needs] = (), Needs()
        self._parts: Any = None
        self._edited: set[int] = set()
        self._tree_is_fresh = False

    def add(self, row: dict[int, Any], shape: int, mobility: int, material: int) -> int:
        """Append a body; one that is thinner than contacts can be solved for gets the inertia of one that is as
        thin."""
        self._tree_is_fresh = False
        i = super().add(row, shape, mobility, material)
        if mobility == state.DYNAMIC:
            body = self.bodies[i]
            inertia = body[state.INERTIA : state.INERTIA + 9].reshape(3, 3)
            least = THINNEST * body[state.MASS] * body[state.REACH] ** 2
            moments, axes = np.linalg.eigh(inertia)
            if moments[0] < least:
                inertia[:] = axes @ np.diag(np.maximum(moments, least)) @ axes.T
                body[state.INVERSE_INERTIA : state.INVERSE_INERTIA + 9] = np.linalg.inv(inertia).ravel()
        return i

    def step(self, steps: int, settings: state.Settings, table: Array) -> StepFailure | None:
        """Take steps; growing where room is short. Returns the failure that stopped them, or None."""
        if self.n == 0:
            self.steps += steps
            return None
        self._tree_is_fresh = False
        self._edited.clear()
        left = steps
        began = time.perf_counter()
        here = self.n, self.boxes, self.polytopes
        if table is not self._table or here != self._needs[0]:
            self._table, self._needs, self._parts = table, (here, self.needs(table)), None
        announce_compilation()
        if self._parts is None:
            self._parts = self._needs[1].parts(self.dtype, self.crew.threads > 1)
        while left:
            done, reason, number = self._take(min(left, max(1, CHUNK // self.n)), settings, table)
            self.steps += done
            left -= done
            if len(self.cache.pairs) > MANY_PAIRS:
                self._trim()
            if reason == soft_step.MORE_PAIRS:
                self._resize(len(self.bodies), _room_for(number), len(self.cache.free))
            elif reason == soft_step.MORE_SLOTS:
                self._resize(len(self.bodies), len(self.cache.pairs), _room_for(number))
            elif reason == soft_step.MORE_BLOCKS:
                self._resize_blocks(_room_for(number), _room_for(int(self.scratch.counts[soft_scratch.BLOCK_ROWS])))
            elif reason == soft_step.MORE_CONTACTS:
                self._grow_contacts(_room_for(number))
            elif reason == soft_step.BLOWN_UP:
                return StepFailure(number, self.steps)
        self.seconds += time.perf_counter() - began
        if self.rigid:
            self._note_tally()
        return None

    def needs(self, table: Array) -> Needs:
        """What the step of these bodies needs with this table of pairs, or with one for each of many worlds."""
        laws = table.shape[-1] > state.STATIC_ACROSS
        return Needs(
            boxes_meet=self.boxes > 1 and self.dynamic_boxes > 0,
            hulls=self.polytopes > 0,
            bounces=bool(table[..., state.RESTITUTION].any()),
            # who has laws or the exact solver compiles rolling resistance too: fewer variants of the solver
            rolls=self.rigid or laws or bool(table[..., state.ROLLING].any()),
            laws=laws,
            exact=self.rigid,
        )

    def _note_tally(self) -> None:
        """Enter into the report what the exact solver has tallied."""
        tally, row = self.scratch.tally, self.report[state.RESTING]
        row[state.VISITS], row[state.LIMITS], row[state.WORST] = (
            tally[k] for k in (exact.PASSES, exact.HITS, exact.WORST)
        )

    def miss_log(self) -> Array:
        """Misses of the last substep that the exact solver took, m/s, every fifth pass."""
        tally = self.scratch.tally
        return np.array(tally[exact.LOG : exact.LOG + int(tally[exact.LOGGED])])

    def miss(self, settings: state.Settings) -> float:
        """By how much the velocities and impulses of the last step miss the laws of contact, m/s."""
        blocks = int(self.scratch.counts[soft_scratch.BLOCKS])
        if blocks == 0 or self.n == 0:
            return 0.0
        laws = (self.kinds, self._table, self.soft.grain) if self._needs[1].laws else None
        substeps = settings.substeps * (2 if self.scratch.counts[soft_scratch.HARD] and not self.rigid else 1)
        h, soft, counts = settings.dt / substeps, self.soft, self.desk.pieces[:, pieces.BLOCKS]
        if counts[0] == blocks:
            return float(exact.measure_miss(soft.blocks, soft.members, blocks, soft.rows, h, substeps, laws))
        ends = counts.cumsum()
        misses: list[float] = []
        for end, count in zip(ends[ends <= blocks].tolist(), counts.tolist(), strict=False):
            own = soft_rows.members_from(soft, end - count)
            misses.append(
                exact.measure_miss_again(
                    own.blocks, own.members, count, own.manifolds, own.corners, own.rows, own.aux, h, substeps
                )
            )
        return max(misses)

    def _take(self, steps: int, settings: state.Settings, table: Array) -> Any:
        """Call the kernel: how many steps it took, its reason to return, and a number that goes with the reason."""
        needs = self._needs[1]
        bounces = (self.contacts, self.tags, self._impact_lists(), self.report, _NO_COPY) if needs.bounces else ()
        outcome = self._outcome
        outcome[0, soft_step.TAKEN] = 0
        book = self._book(table, settings, bounces)
        given = steps, self.n, book, 0, 1, 1, outcome, self._one, int(needs.bounces), int(needs.laws), int(needs.exact)
        if self.crew.threads == 1:
            soft_entry.soft_step(*given, None)
            return outcome.tolist()[0]
        self.crew.lead(functools.partial(soft_entry.soft_step, *given), book, self._one)
        return outcome.tolist()[0]

    def _book(self, table: Array, settings: state.Settings, bounces: tuple[Any, ...]) -> Any:
        """Where all arrays are that a step needs, written anew if one of them was replaced.

        The parts are kept beside it, so that none of them can go away, nor its place be taken by another.
        """
        parts = (
            self.bodies, self.kinds, table, settings, self.ledger, self.cycles, self._parts, self.tree, self.cache,
            self.soft, self.scratch, self.desk, self.hulls.arrays, *bounces,
        )  # fmt: skip
        names = tuple(map(id, parts))
        if names != self._written[0]:
            numbers = np.array(settings, np.float64)
            written = (*parts[:3], numbers, *parts[4:])
            self._written = names, (parts, numbers), soft_book.book_of(*written)
        return self._written[2]

    def __getstate__(self) -> dict[str, Any]:
        """Without addresses, which hold for this very store."""
        return self.__dict__ | {"_written": ((), (), None), "_parts": None}

    def _impact_lists(self) -> state.Lists:
        """Scratch of the impacts for as many bodies and contact rows as there is room for."""
        if len(self.lists.group) < len(self.bodies) or len(self.lists.touching) < 2 * len(self.contacts):
            self.lists = state.make_lists(len(self.bodies), len(self.contacts), 0)
        return self.lists

    def set_grain(self, index: int, direction: Array) -> None:
        """Direction of the surface of body ``index`` in the shape's axes."""
        self.soft.grain[index + 1] = direction

    def edited(self, index: int) -> None:
        """Body ``index`` was changed from outside: it wakes with all that touch it."""
        counts = self.scratch.counts
        self._tree_is_fresh = False
        if index < counts[soft_scratch.N_KNOWN] and index not in self._edited:
            self._edited.add(index)
            self.scratch.bodies[soft_scratch.EDITED, counts[soft_scratch.N_EDITED]] = index
            counts[soft_scratch.N_EDITED] += 1

    def replaced(self) -> None:
        """The arrays are those of another moment now: what follows from them is found anew."""
        self._note_edited()
        self._tree_is_fresh = False
        self._table = None
        self.desk.notes[:, soft_scratch.FILL] = soft_scratch.ONCE

    def _note_edited(self) -> None:
        """Who is on the list of those edited."""
        lists, counts = self.scratch.bodies, self.scratch.counts
        self._edited = set(lists[soft_scratch.EDITED, : counts[soft_scratch.N_EDITED]].tolist())

    def watch(self) -> None:
        """Views of the state have been handed out: bodies may change without a word."""
        super().watch()
        self.scratch.counts[soft_scratch.WATCHED] = 1

    def collect_contacts(self) -> None:
        """Fill the rows of contact points."""
        soft, pairs = self.soft, self.cache.pairs[: self.cache.counts[PAIRS]]
        # most pairs of a heap are near each other without touching; a column is denser than rows to pick from
        points = soft.meta[:, soft_rows.POINTS].take(pairs[:, SLOT] + 1)
        pairs = pairs.compress(points > 0.0, axis=0)
        while True:
            self.m = report_contacts(
                self.bodies, pairs, len(pairs), soft.manifolds, soft.meta, soft.reports, self.contacts, self.tags
            )
            if self.m <= len(self.contacts):
                return
            self.contacts, self.tags = state.make_contacts(self.m)

    def touching_pairs(self) -> tuple[NDArray[np.int64], Array]:
        """Names of the pairs that touch: those with load, and, where there are sensors, those that overlap one now."""
        count = int(self.cache.counts[PAIRS])
        names, loads = np.zeros(count, np.int64), np.zeros(count)
        found = touching.loaded_pairs(
            self.cache.pairs, count, self.soft.meta, self.soft.reports, names, loads
        )  # fmt: skip
        names, loads = names[:found], loads[:found]
        if self.sensors:
            sensed = np.zeros(count, np.int64)
            found = touching.sensed_pairs(
                self.bodies, self.kinds, self.hulls.arrays, self.cache.pairs, count, self.points, sensed
            )  # fmt: skip
            names = np.concatenate([names, sensed[:found]])
            order = np.argsort(names)
            names, loads = names[order], np.concatenate([loads, np.zeros(found)])[order]
        return names, loads

    def fresh_tree(self, gravity: float, dt: float) -> tuple[Any, Any]:
        """The tree of the step, with all bodies where they are now."""
        counts = self.scratch.counts
        if not self._tree_is_fresh or counts[soft_scratch.WATCHED]:
            questions.refresh_tree(
                self.tree, self.cache, self.bodies, self.kinds, self.n, counts[soft_scratch.N_KNOWN],
                self.desk.lists[soft_scratch.GROUP], gravity, dt,
            )  # fmt: skip
            self._tree_is_fresh = True
        return self.tree, self.cache

    def remove(self, keep: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Keep the bodies that ``keep`` (n,) marks, in their order, and wake what touched the others."""
        n, left = self.n, int(np.count_nonzero(keep))
        new = np.where(keep, np.cumsum(keep) - 1, NONE)
        self._wake_neighbours(keep)
        self._drop_pairs(keep, new)
        removal.drop_leaves(self.tree, np.flatnonzero(~keep))
        leaf = self.tree.leaf
        close_gaps(leaf[:n], keep)
        leaf[left:n] = NONE
        self.tree.links[leaf[:left][leaf[:left] != NONE], RIGHT] = np.flatnonzero(leaf[:left] != NONE)

        cache, counts, lists = self.cache, self.scratch.counts, self.scratch.bodies
        for count, row in ((p.TOUCHED, p.TOUCHED_LIST), (p.MOVED, p.MOVED_LIST), (p.PLANES, p.PLANES_LIST)):
            cache.counts[count] = _renumber(cache.lists[row], cache.counts[count], new)
        counts[soft_scratch.N_EDITED] = _renumber(lists[soft_scratch.EDITED], counts[soft_scratch.N_EDITED], new)
        self._note_edited()
        counts[soft_scratch.N_KNOWN] = np.count_nonzero(keep[: counts[soft_scratch.N_KNOWN]])
        counts[soft_scratch.STALE] = 1
        self.desk.lists[soft_scratch.MARK] = 0

        asleep = self.kinds[:n, state.ASLEEP] != 0
        self.kinds[:n, state.ISLAND][asleep] = new[self.kinds[:n, state.ISLAND][asleep]]
        close_gaps(cache.marks[:n], keep)
        cache.marks[left:n] = 0
        for rows in (self.soft.pose, self.soft.rows, self.soft.aux, self.soft.grain):
            close_gaps(rows[1 : n + 1], keep)
            rows[left + 1 : n + 1] = 0
        self._close_gaps(keep)
        return new

    def _wake_neighbours(self, keep: NDArray[np.bool_]) -> None:
        """Wake the islands of bodies that go, and of those that touch them."""
        n, kinds = self.n, self.kinds[: self.n]
        pairs = self.cache.pairs[: self.cache.counts[PAIRS]]
        a, b = pairs[:, PAIR_A], pairs[:, PAIR_B]
        touch = (keep[a] != keep[b]) & (self.soft.meta[pairs[:, SLOT] + 1, soft_rows.POINTS] > 0.0)
        roused = ~keep
        roused[a[touch]] = roused[b[touch]] = True
        asleep = kinds[:, state.ASLEEP] != 0
        wakes = asleep & np.isin(kinds[:, state.ISLAND], kinds[roused & asleep, state.ISLAND])
        kinds[wakes, state.ASLEEP] = 0
        self.bodies[:n][wakes, state.REST] = 0.0

    def _drop_pairs(self, keep: NDArray[np.bool_], new: NDArray[np.int64]) -> None:
        """End the pairs of the bodies that go, and renumber the others, whose order stays."""
        cache, counts = self.cache, self.cache.counts
        pairs = cache.pairs[: counts[PAIRS]]
        stay = keep[pairs[:, PAIR_A]] & keep[pairs[:, PAIR_B]]
        slots = pairs[~stay, SLOT]
        slots = slots[slots != NONE]
        cache.free[counts[p.FREE] : counts[p.FREE] + len(slots)] = slots
        counts[p.FREE] += len(slots)
        kept = pairs[stay]
        kept[:, PAIR_A], kept[:, PAIR_B] = new[kept[:, PAIR_A]], new[kept[:, PAIR_B]]
        counts[PAIRS] = len(kept)
        cache.pairs[: len(kept)] = kept
        counts[p.BEGUN] = counts[p.ENDED] = 0

    def profile(self) -> dict[str, float]:
        """Seconds of each stage since :meth:`reset_profile`."""
        total = float(self.cycles[:-1].sum())
        scale = self.seconds / total if total else 0.0
        return {name: float(c) * scale for name, c in zip(STAGES, self.cycles, strict=False)}

    def reset_profile(self) -> None:
        """Begin to count anew."""
        self.cycles[:] = 0
        self.seconds = 0.0

    def _grow_bodies(self) -> None:
        room = _room_for(len(self.bodies))
        bodies, kinds = state.make_bodies(room)
        bodies[: self.n], kinds[: self.n] = self.bodies[: self.n], self.kinds[: self.n]
        self.bodies, self.kinds = bodies, kinds
        self._resize(room, len(self.cache.pairs), len(self.cache.free))

    def _grow_contacts(self, room: int) -> None:
        self.contacts, self.tags = state.make_contacts(room)

    def _resize_blocks(self, room: int, rows: int) -> None:
        made = soft_rows.make_soft(0, 0, self.dtype, blocks=room, rows=rows)
        self.soft = self.soft._replace(blocks=made.blocks, members=made.members)

    def _trim(self) -> None:
        """Give back room that a busier time has needed: what is poured touches more than what has come to rest."""
        counts, blocks = self.cache.counts, int(self.scratch.counts[soft_scratch.BLOCKS])
        pairs, slots = int(counts[PAIRS]), int(counts[p.SLOTS] - counts[p.FREE])
        if _is_wasted(len(self.cache.free), slots) or _is_wasted(len(self.cache.pairs), pairs):
            self._gather_slots()
            self._resize(len(self.bodies), _least_room_for(pairs), _least_room_for(slots))
        rows = int(self.scratch.counts[soft_scratch.BLOCK_ROWS])
        if _is_wasted(len(self.soft.blocks), rows):
            self._resize_blocks(_least_room_for(blocks), _least_room_for(rows))

    def _gather_slots(self) -> None:
        """Number the slots anew, in the order of their pairs."""
        pairs, counts = self.cache.pairs[: self.cache.counts[PAIRS]], self.cache.counts
        touch = pairs[:, SLOT] != NONE
        rows = pairs[touch, SLOT] + 1
        for name in BY_SLOT:
            array = getattr(self.soft, name)
            array[1 : len(rows) + 1] = array[rows]
        pairs[touch, SLOT] = np.arange(len(rows))
        counts[p.SLOTS], counts[p.FREE] = len(rows), 0

    def _resize(self, bodies: int, pairs: int, slots: int) -> None:
        """The same state with other room."""
        self.tree = grow_tree(self.tree, bodies)
        self.cache = resize_pair_cache(self.cache, bodies, pairs, slots)
        # blocks are filled anew in each step, and stay as they are
        made = refilled(soft_rows.make_soft(bodies, slots, self.dtype, blocks=0), self.soft)
        self.soft = made._replace(blocks=self.soft.blocks, members=self.soft.members)
        self.scratch = refilled(soft_scratch.make_scratch(bodies), self.scratch)
        self.desk = soft_scratch.make_desk(bodies, pairs, slots, fill=int(self.desk.notes[0, soft_scratch.FILL]))


def _room_for(number: int) -> int:
    """How much room to make for so many."""
    return number + number // 8 + 16


def _least_room_for(number: int) -> int:
    """The same where there is no rush."""
    return number + number // 16 + 16


def _is_wasted(room: int, number: int) -> bool:
    """Whether that is far too much room for so many."""
    return room > number + number // 4 + 64


def _renumber(numbers: NDArray[np.int64], count: int, new: NDArray[np.int64]) -> int:
    """Bodies in the first rows get their new numbers, those that are gone are dropped; returns how many remain."""
    kept = new[numbers[:count]]
    kept = kept[kept != NONE]
    numbers[: len(kept)] = kept
    return len(kept)
