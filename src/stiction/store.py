"""The store of a world: owns the arrays, lets them grow, and calls the kernels. Everything in it has been checked."""

from __future__ import annotations

import logging
import math
import sys
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.core import jit, state
from stiction.core import step as kernels
from stiction.hulls import HullTable

Array = NDArray[np.float64]

CHUNK = 2_000_000
"""Bodies times steps in one compiled call at most, so that Ctrl-C is heard within a second or two."""

log = logging.getLogger("stiction")


class StepFailure(NamedTuple):
    """A body whose state stopped being finite."""

    body: int
    step: int


class Store:
    """Rows of bodies and contacts. ``n`` bodies are in use; the rest of the rows is spare."""

    def __init__(self) -> None:
        self.n = 0
        self.m = 0
        self.steps = 0
        self.bodies, self.kinds = state.make_bodies(16)
        self.contacts, self.tags = state.make_contacts(32)
        self.lists = state.make_lists(16, 32, 32)
        self.ledger = np.zeros(state.LEDGER_WIDTH)
        self.ledger[state.INITIAL] = math.nan
        self.report = np.zeros((3, state.REPORT_WIDTH))
        self.boxes = 0
        self.dynamic_boxes = 0
        self.polytopes = 0
        self.hulls = HullTable()
        self.sensors = 0
        self.watched = False
        self.points = np.zeros((state.SCRATCH, 5))

    def add(self, row: dict[int, Any], shape: int, mobility: int, material: int) -> int:
        """Append a body; ``row`` maps a column to the numbers that start there. Returns its index."""
        if self.n == len(self.bodies):
            self._grow_bodies()
        i = self.n
        for column, value in row.items():
            numbers = np.ravel(value)
            self.bodies[i, column : column + len(numbers)] = numbers
        self.bodies[i, state.LAST : state.LAST + 7] = self.bodies[i, state.POSITION : state.POSITION + 7]
        self.bodies[i, state.LAST + 7 : state.LAST + 13] = self.bodies[i, state.V : state.V + 6]
        self.bodies[i, state.V_START : state.V_START + 6] = self.bodies[i, state.V : state.V + 6]
        self.kinds[i, :3] = shape, mobility, material
        self.kinds[i, state.LAYER], self.kinds[i, state.MASK] = 1, -1
        size = self.bodies[i, state.SIZE : state.SIZE + 3]
        reach = {state.SPHERE: size[0], state.ELLIPSOID: size.max(), state.PLANE: 0.0}.get(shape)
        reach = math.sqrt(float(size @ size)) if reach is None else reach
        self.bodies[i, state.REACH] = reach
        self.boxes += shape == state.BOX
        self.dynamic_boxes += shape == state.BOX and mobility == state.DYNAMIC
        self.polytopes += shape in {state.CAPSULE, state.CYLINDER, state.HULL, state.ELLIPSOID}
        self.n += 1
        return i

    def remove(self, keep: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Keep the bodies that ``keep`` (n,) marks, in their order. Returns the new number of each, (n,), -1 if gone.

        The numbers of boxes and so on stay: they only say what has to be compiled, and less would be compiled anew.
        """
        n, left = self.n, int(np.count_nonzero(keep))
        new = np.where(keep, np.cumsum(keep) - 1, -1)
        order = self.lists.order[self.lists.order < n]
        order = new[order]
        self.lists.order[:n] = np.concatenate([order[order >= 0], np.arange(left, n)])
        tags = new[self.tags[: self.m, state.BODY_A : state.BODY_B + 1]]
        stay = (tags >= 0).all(axis=1)
        rows = self.contacts[: self.m][stay], self.tags[: self.m][stay]
        rows[1][:, state.BODY_A : state.BODY_B + 1] = tags[stay]
        self.m = len(rows[0])
        self.contacts[: self.m], self.tags[: self.m] = rows
        self._close_gaps(keep)
        return new

    def _close_gaps(self, keep: NDArray[np.bool_]) -> None:
        """Move the rows of bodies up, and leave those behind them as they were made."""
        n, left = self.n, int(np.count_nonzero(keep))
        self.sensors -= int(np.count_nonzero(self.kinds[:n, state.SENSOR][~keep]))
        spare = state.make_bodies(n - left)
        for rows, unused in zip((self.bodies, self.kinds), spare, strict=True):
            close_gaps(rows[:n], keep)
            rows[left:n] = unused
        self.n = left

    def touching_pairs(self) -> tuple[NDArray[np.int64], Array]:
        """Names of the pairs that touched in the last step, sorted (a in the upper half, b), and impulses, N s."""
        loaded = self.contacts[: self.m, state.TOTAL] > 0.0
        tags = self.tags[: self.m][loaded]
        names, inverse = np.unique((tags[:, state.BODY_A] << 32) | tags[:, state.BODY_B], return_inverse=True)
        impulses = np.zeros(len(names))
        np.add.at(impulses, inverse, self.contacts[: self.m, state.TOTAL][loaded])
        return names.astype(np.int64), impulses

    def fresh_tree(self, gravity: float, dt: float) -> tuple[Any, Any]:
        """A tree of the bodies where they are now, and what goes with it, for queries. Here it is made for each."""
        from stiction.core.pairs import make_pair_cache
        from stiction.core.questions import refresh_tree
        from stiction.core.tree import make_tree

        tree, cache = make_tree(self.n), make_pair_cache(self.n, 1, 1)
        refresh_tree(tree, cache, self.bodies, self.kinds, self.n, 0, np.zeros(self.n, np.int64), gravity, dt)
        return tree, cache

    def miss(self, settings: state.Settings) -> float:
        """By how much the velocities and impulses of the last step miss the laws of contact, m/s."""
        raise NotImplementedError

    def miss_log(self) -> Array:
        """Misses of the last substep."""
        raise NotImplementedError

    def profile(self) -> dict[str, float]:
        """Seconds of each stage since :meth:`reset_profile`; none are counted here."""
        return {}

    def reset_profile(self) -> None:
        """Begin to count anew."""

    def column(self, start: int, width: int) -> Array:
        """A view of the same numbers of all bodies, (n, width), valid until a body is added."""
        return self.bodies[: self.n, start : start + width]

    def set_grain(self, index: int, direction: Array) -> None:
        """Direction of the surface of body ``index`` in the shape's axes."""
        raise NotImplementedError

    def edited(self, index: int) -> None:
        """Body ``index`` was changed from outside."""

    def replaced(self) -> None:
        """The arrays are those of another moment now."""

    def watch(self) -> None:
        """Views of the state have been handed out: bodies may change without a word."""
        self.watched = True

    def collect_contacts(self) -> None:
        """Make sure that the rows of contact points are those of the last step."""

    def step(self, steps: int, settings: state.Settings, table: Array) -> StepFailure | None:
        """Take steps; growing where room is short. Returns the failure that stopped them, or None."""
        if self.n == 0:
            self.steps += steps
            return None
        left = steps
        while left:
            chunk = min(left, max(1, CHUNK // self.n))
            reason, done, number, self.m = self._kernel(chunk, settings, table)
            self.steps += done
            left -= done
            if reason == kernels.MORE_PAIRS:
                self._grow_lists(pairs=number + number // 4 + 16)
            elif reason == kernels.MORE_CONTACTS:
                self._grow_contacts(number + number // 16 + 16)
            elif reason == kernels.BLOWN_UP:
                return StepFailure(number, self.steps)
        return None

    def _kernel(self, steps: int, settings: state.Settings, table: Array) -> tuple[int, int, int, int]:
        boxes_meet = 1 if self.boxes > 1 and self.dynamic_boxes else None
        hulls = self.hulls.arrays if self.polytopes else None
        extras = 1 if settings.literal or table[:, :, state.RESTITUTION].any() else None
        announce_compilation()
        result: tuple[int, int, int, int] = kernels.step(
            steps, self.bodies, self.kinds, self.n, self.contacts, self.tags, self.lists, table, settings,
            self.ledger, self.report, boxes_meet, extras, hulls,
        )  # fmt: skip
        return result

    def energy(self, gravity: Array) -> tuple[float, float]:
        """Kinetic and potential energy now, J."""
        kinetic, potential = kernels.energy(self.bodies, self.n, *gravity)
        return float(kinetic), float(potential)

    def _grow_bodies(self) -> None:
        room = len(self.bodies) + len(self.bodies) // 4 + 16
        bodies, kinds = state.make_bodies(room)
        bodies[: self.n], kinds[: self.n] = self.bodies[: self.n], self.kinds[: self.n]
        self.bodies, self.kinds = bodies, kinds
        order = self.lists.order
        self.lists = state.make_lists(room, len(self.contacts), len(self.lists.pairs))
        self.lists.order[: len(order)] = order

    def _grow_contacts(self, room: int) -> None:
        self.contacts, self.tags = state.make_contacts(room)
        self._grow_lists(pairs=len(self.lists.pairs))

    def _grow_lists(self, pairs: int) -> None:
        order = self.lists.order
        self.lists = state.make_lists(len(self.bodies), len(self.contacts), pairs)
        self.lists.order[:] = order


def close_gaps(rows: NDArray[Any], keep: NDArray[np.bool_]) -> None:
    """Move the rows that are kept up to the front, in their order; those before the first gap stay untouched."""
    first = int(np.argmin(keep))
    kept = rows[first:][keep[first:]]
    rows[first : first + len(kept)] = kept


_announced = False


def announce_compilation() -> None:
    """Say once, on a terminal, that kernels are about to be compiled, if none of them lies in the cache."""
    global _announced  # noqa: PLW0603 -- once a process
    if _announced:
        return
    _announced = True
    if jit.is_cold():
        text = (
            "stiction: compiling kernels for this machine, half a minute or so, once (`stiction warmup` does it ahead)."
        )
        if sys.stderr.isatty():
            print(text, file=sys.stderr)
        log.info(text)
