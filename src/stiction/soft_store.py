"""The store of a world with the soft solver: its arrays, how they grow, and the calls of its kernels."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from stiction.core import soft_rows, soft_step, state
from stiction.core.clock import STAGES
from stiction.core.colouring import COLOURS
from stiction.core.pairs import PAIRS, grow_pair_cache, make_pair_cache
from stiction.core.soft_report import report_contacts
from stiction.core.tree import grow_tree, make_tree
from stiction.store import CHUNK, Array, Store, StepFailure, announce_compilation

PRECISIONS = {"single": np.float32, "double": np.float64}


class SoftStore(Store):
    """Rows of bodies, the tree, the pairs and the manifolds."""

    def __init__(self, precision: str) -> None:
        super().__init__()
        room, pairs = len(self.bodies), 64
        self.dtype = PRECISIONS[precision]
        self.tree = make_tree(room)
        self.cache = make_pair_cache(room, pairs)
        self.soft = soft_rows.make_soft(room, pairs, self.dtype)
        self.scratch = soft_step.make_scratch(room, pairs, COLOURS)
        self.cycles = np.zeros(len(STAGES) + 1, np.int64)
        self.seconds = 0.0
        self._reported = -1

    def step(self, steps: int, settings: state.Settings, table: Array) -> StepFailure | None:
        """Take steps; growing where room is short. Returns the failure that stopped them, or None."""
        if self.n == 0:
            self.steps += steps
            return None
        left = steps
        began = time.perf_counter()
        while left:
            chunk = min(left, max(1, CHUNK // self.n))
            boxes_meet = 1 if self.boxes > 1 and self.dynamic_boxes else None
            hulls = self.hulls.arrays if self.polytopes else None
            bounces = None
            if table[:, :, state.RESTITUTION].any():
                bounces = (self.contacts, self.tags, self._impact_lists(), self.report)
            rolls = 1 if table[:, :, state.ROLLING].any() else None
            announce_compilation()
            reason, done, number = soft_step.soft_step(
                chunk, self.bodies, self.kinds, self.n, self.tree, self.cache, self.soft, self.scratch, table,
                settings, self.ledger, self.cycles, boxes_meet, hulls, bounces, rolls,
            )  # fmt: skip
            self.steps += done
            left -= done
            if reason == soft_step.MORE_PAIRS:
                self._grow(len(self.bodies), number + number // 4 + 16)
            elif reason == soft_step.MORE_BLOCKS:
                self._grow(len(self.bodies), 2 * len(self.cache.pairs))
            elif reason == soft_step.MORE_CONTACTS:
                self._grow_contacts(number + number // 4 + 16)
            elif reason == soft_step.BLOWN_UP:
                return StepFailure(number, self.steps)
        self.seconds += time.perf_counter() - began
        return None

    def _impact_lists(self) -> state.Lists:
        """Scratch of the impacts for as many bodies and contact rows as there is room for."""
        if len(self.lists.group) < len(self.bodies) or len(self.lists.touching) < 2 * len(self.contacts):
            self.lists = state.make_lists(len(self.bodies), len(self.contacts), 0)
        return self.lists

    def edited(self, index: int) -> None:
        """Body ``index`` was changed from outside: it wakes with all that touch it."""
        counts = self.scratch.counts
        if index < counts[soft_step.N_KNOWN] and counts[soft_step.N_EDITED] < len(self.bodies):
            self.scratch.bodies[soft_step.EDITED, counts[soft_step.N_EDITED]] = index
            counts[soft_step.N_EDITED] += 1

    def watch(self) -> None:
        """Views of the state have been handed out: bodies may change without a word."""
        self.scratch.counts[soft_step.WATCHED] = 1

    def collect_contacts(self) -> None:
        """Fill the rows of contact points."""
        soft, pairs = self.soft, int(self.cache.counts[PAIRS])
        while True:
            self.m = report_contacts(
                self.bodies, self.cache.pairs, pairs, soft.manifolds, soft.meta, soft.reports, self.contacts,
                self.tags,
            )  # fmt: skip
            if self.m <= len(self.contacts):
                return
            self.contacts, self.tags = state.make_contacts(self.m)

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
        room = len(self.bodies) + len(self.bodies) // 4 + 16
        bodies, kinds = state.make_bodies(room)
        bodies[: self.n], kinds[: self.n] = self.bodies[: self.n], self.kinds[: self.n]
        self.bodies, self.kinds = bodies, kinds
        self._grow(room, len(self.cache.pairs))

    def _grow_contacts(self, room: int) -> None:
        self.contacts, self.tags = state.make_contacts(room)

    def _grow(self, bodies: int, pairs: int) -> None:
        """The same state with room for more."""
        self.tree = grow_tree(self.tree, bodies)
        self.cache = grow_pair_cache(self.cache, bodies, pairs)
        self.soft = _grown(self.soft, soft_rows.make_soft(bodies, pairs, self.dtype))
        self.scratch = _grown(self.scratch, soft_step.make_scratch(bodies, pairs, COLOURS))


def _grown(old: Any, new: Any) -> Any:
    """Copy arrays into larger ones."""
    for source, target in zip(old, new, strict=True):
        target[tuple(slice(k) for k in source.shape)] = source
    return new
