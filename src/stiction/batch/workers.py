"""Stepping a batch: workers take worlds in turn, each at a desk of its own, until all have taken their steps."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.batch.blocks import Blocks, Desk
from stiction.core import soft_entry, soft_step
from stiction.crew import Helpers
from stiction.soft_store import Needs
from stiction.store import announce_compilation

AnyArray = NDArray[Any]

TURNS = 4
"""Ranges of worlds for each worker: small ones share the work better, but each costs a call of 5 us."""
AT_ONCE = 2_000_000
"""Bodies times steps times worlds in one go at most, so that Ctrl-C is heard within a second or two."""


class Failure(NamedTuple):
    """A world that was frozen because a body's state stopped being finite."""

    world: int
    body: int
    step: int


class Workers:
    """The desks of a batch, and the threads that sit at them."""

    def __init__(self, threads: int, blocks: Blocks) -> None:
        self.threads = threads
        self._one = blocks.dtype(1.0)
        self._outcomes = np.zeros((blocks.worlds, soft_step.OUTCOME_WIDTH), np.int64)
        self._contacts, self._blocks = 32, 0
        self._desks: list[Desk] = []
        self._helpers = Helpers(threads - 1)
        self._written: tuple[tuple[int, int, bool, int], list[Any]] | None = None
        self.furnish(blocks)

    def furnish(self, blocks: Blocks) -> None:
        """New desks, for as many bodies, pairs, blocks and contacts as there now is room for."""
        self._written = None
        self._desks = [Desk(blocks.room, self._blocks, self._contacts, blocks.dtype) for _ in range(self.threads)]

    @property
    def desk(self) -> Desk:
        """One of the desks, for who looks at a world between two steps."""
        return self._desks[0]

    def step(
        self, steps: int, blocks: Blocks, frozen: NDArray[np.bool_], table: AnyArray, settings: AnyArray, hulls: Any,
        needs: Needs, taken: NDArray[np.int64],
    ) -> list[Failure]:  # fmt: skip
        """Take steps in all worlds that are not frozen; ``taken`` (worlds,) counts them. Returns who failed."""
        announce_compilation()
        parts = needs.parts(blocks.dtype, team=False)
        failures: list[Failure] = []
        at_once = max(1, AT_ONCE // (blocks.n * blocks.worlds))
        stopped = frozen.copy()
        while steps:
            now = min(steps, at_once)
            outcomes = self._outcomes
            outcomes[:, soft_step.TAKEN] = np.where(stopped, now, 0)
            outcomes[:, soft_step.REASON] = soft_step.DONE
            while True:
                self._go_round(now, blocks, table, settings, hulls, needs, parts)
                reasons = outcomes[:, soft_step.REASON]
                for world in np.flatnonzero(reasons == soft_step.BLOWN_UP).tolist():
                    done = int(outcomes[world, soft_step.TAKEN])
                    failures.append(Failure(world, int(outcomes[world, soft_step.NUMBER]), int(taken[world]) + done))
                    stopped[world] = True
                    taken[world] += done - now
                    outcomes[world] = now, soft_step.DONE, 0
                if not (reasons != soft_step.DONE).any():
                    break
                self._make_room(blocks, reasons, outcomes[:, soft_step.NUMBER])
            taken += np.where(frozen, 0, now)
            frozen |= stopped
            steps -= now
        return failures

    def _make_room(self, blocks: Blocks, reasons: AnyArray, numbers: AnyArray) -> None:
        """Grow what was too small for a step of some world."""
        pairs, slots = (
            int(numbers[reasons == reason].max(initial=0)) for reason in (soft_step.MORE_PAIRS, soft_step.MORE_SLOTS)
        )
        if pairs or slots:
            blocks.grow(pairs + pairs // 8, slots + slots // 8)
        wanted = numbers[reasons == soft_step.MORE_BLOCKS]
        if len(wanted):
            self._blocks = int(wanted.max()) + int(wanted.max()) // 4 + 1
        contacts = numbers[reasons == soft_step.MORE_CONTACTS]
        if len(contacts):
            self._contacts = int(contacts.max()) + int(contacts.max()) // 4 + 16
        self.furnish(blocks)

    def _go_round(
        self, steps: int, blocks: Blocks, table: AnyArray, settings: AnyArray, hulls: Any, needs: Needs, parts: Any
    ) -> None:
        """Every worker takes ranges of worlds, one after the other, until none is left."""
        worlds = blocks.worlds
        width = -(-worlds // (self.threads * TURNS)) if self.threads > 1 else worlds
        starts = iter(range(0, worlds, width))
        books = self._books(blocks, table, settings, hulls, needs.bounces, parts)

        def work(book: Any) -> None:
            for first in starts:
                soft_entry.soft_step(
                    steps, blocks.n, book, first, min(first + width, worlds), self.desk.together, self._outcomes,
                    self._one, int(needs.bounces), int(needs.laws), int(needs.exact), None,
                )  # fmt: skip

        helpers = [self._helpers.pool().submit(work, book) for book, _ in books[1:]] if width < worlds else []
        try:
            work(books[0][0])
        finally:
            for helper in helpers:
                helper.result()

    def _books(
        self, blocks: Blocks, table: AnyArray, settings: AnyArray, hulls: Any, bounces: bool, parts: Any
    ) -> list[Any]:
        """A book for each desk with what it must keep alive, written anew if an array in it was replaced: blocks are
        when they grow, and then there are new desks."""
        names = id(table), id(settings), bounces, id(parts)
        if self._written is None or self._written[0] != names:
            self._written = names, [blocks.book(desk, table, settings, hulls, bounces, parts) for desk in self._desks]
        return self._written[1]
