"""The arrays of many worlds: a block for each array that a world keeps from step to step, worlds along its first axis.

What a step fills before it reads it is no state, and belongs to the worker that takes the step (:class:`Desk`): blocks
of contacts, lists, the scratch of the narrow phase. So a world of five bodies takes some 10 kB instead of 90.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.core import soft_book, soft_rows, soft_scratch, state
from stiction.core.book import Each
from stiction.core.clock import STAGES
from stiction.core.lanes import LANES
from stiction.core.pairs import PAIRS, SLOTS, PairCache, make_pair_cache
from stiction.core.soft_rows import Soft
from stiction.core.soft_scratch import Scratch
from stiction.core.tree import USED, Tree, make_tree
from stiction.soft_store import SoftStore

AnyArray = NDArray[Any]
GROUPS: dict[str, Any] = {"tree": Tree, "cache": PairCache, "soft": Soft, "scratch": Scratch}
"""The tuples of arrays in a store."""
ROWS = {"soft.rows", "soft.aux", "soft.pose"}
DESKS = {"cache.begun", "cache.ended", "soft.blocks", "soft.members", "scratch.tally"} | ROWS
"""Arrays that a step fills before it reads them; of :data:`ROWS` each world has some that are stepped together."""
LANES_FULL, MOST_TOGETHER = 40, 8
"""So many bodies fill some blocks: worlds of that many together are stepped side by side, and this many at most."""
SHARED = {"soft.grain"}
"""Arrays that are the same in all worlds, and that a step only reads."""
KEPT_BY_RESET = (
    (state.CENTER, 3), (state.SIZE, 4), (state.INVERSE_MASS, 1), (state.REACH, 1), (state.INERTIA, 9),
    (state.INVERSE_INERTIA, 9), (state.MASS, 1),
)  # fmt: skip
"""Columns of bodies that say what a body is, not what it does."""


class Room(NamedTuple):
    """For how many bodies, pairs, pairs that touch and nodes of the tree a world has rows, and how many columns of a
    body are kept."""

    bodies: int
    pairs: int
    slots: int
    nodes: int
    columns: int


def arrays_with(room: Room, dtype: Any) -> dict[str, AnyArray]:
    """Empty arrays of one world, by name."""
    bodies, kinds = state.make_bodies(room.bodies)
    return _by_name(
        bodies[:, : room.columns],
        kinds,
        np.zeros(state.LEDGER_WIDTH),
        tree=make_tree(room.bodies, room.nodes),
        cache=make_pair_cache(room.bodies, room.pairs, room.slots),
        soft=soft_rows.make_soft(room.bodies, room.slots, dtype),
        scratch=soft_scratch.make_scratch(room.bodies),
    )


def arrays_of(store: SoftStore) -> dict[str, AnyArray]:
    """The arrays of a store, by the same names."""
    return _by_name(store.bodies, store.kinds, store.ledger, **{name: getattr(store, name) for name in GROUPS})


def _by_name(bodies: AnyArray, kinds: AnyArray, ledger: AnyArray, **groups: Any) -> dict[str, AnyArray]:
    made = {"bodies": bodies, "kinds": kinds, "ledger": ledger}
    for name, part in groups.items():
        made |= {f"{name}.{field}": array for field, array in zip(part._fields, part, strict=True)}
    return made


def _grouped(part: Callable[[str], Any]) -> dict[str, Any]:
    """Bodies, kinds, ledger and the tuples of arrays, of what ``part`` gives for a name."""
    groups = {name: kind(*(part(f"{name}.{field}") for field in kind._fields)) for name, kind in GROUPS.items()}
    return {name: part(name) for name in ("bodies", "kinds", "ledger")} | groups


def fit(array: AnyArray, like: AnyArray, axis: int = 0) -> AnyArray:
    """``like`` with as much of ``array`` in it as both have room for; axes before ``axis`` are those of worlds."""
    result = np.empty(array.shape[:axis] + like.shape, like.dtype)
    result[...] = like
    both = tuple(slice(min(a, b)) for a, b in zip(array.shape[axis:], like.shape, strict=True))
    place: Any = (..., *both)
    result[place] = array[place]
    return result


class Desk:
    """What a worker needs besides the worlds: the arrays of :data:`DESKS`, lists for as many worlds as are stepped
    ``together``, and room for impacts."""

    def __init__(self, room: Room, blocks: int, contacts: int, dtype: Any) -> None:
        made = arrays_with(room, dtype)
        if blocks * soft_rows.FIELDS > len(made["soft.blocks"]):
            made["soft.blocks"] = np.zeros((blocks * soft_rows.FIELDS, LANES), dtype)
            made["soft.members"] = np.zeros((soft_rows.MEMBERS * blocks, LANES), np.int32)
        self.together = max(1, min(LANES_FULL // room.bodies, MOST_TOGETHER))
        self.lists = soft_scratch.make_desk(room.bodies, room.pairs, room.slots, self.together, soft_scratch.ALWAYS)
        self.arrays = {name: made[name] for name in DESKS} | {
            name: np.zeros((self.together * len(made[name]), made[name].shape[1]), made[name].dtype) for name in ROWS
        }
        self.cycles = np.zeros(len(STAGES) + 1, np.int64)
        self.contacts, self.tags = state.make_contacts(contacts)
        self.impact_lists = state.make_lists(room.bodies, contacts, 0)
        self.report = np.zeros((3, state.REPORT_WIDTH))
        self.wide = np.zeros((room.bodies, state.BODY_WIDTH))

    @property
    def bounces(self) -> tuple[Any, ...]:
        """What impacts need."""
        return self.contacts, self.tags, self.impact_lists, self.report, self.wide


class Blocks:
    """The state of ``worlds`` copies of one world, with room for more pairs when they need it."""

    def __init__(self, store: SoftStore, worlds: int) -> None:
        self.n, self.worlds, self.dtype = store.n, worlds, store.dtype
        cache = store.cache.counts
        mobility, shapes = (store.kinds[: store.n, column] for column in (state.MOBILITY, state.SHAPE))
        leaves = max(1, int(np.count_nonzero(shapes != state.PLANE)))
        self.room = Room(
            bodies=store.n,
            pairs=max(1, store.n - 1, int(cache[PAIRS])),
            slots=max(1, store.n - 1, int(cache[SLOTS])),
            nodes=max(2 * leaves - 1, int(store.tree.head[USED])),
            columns=state.BODY_WIDTH if (mobility == state.KINEMATIC).any() else state.SHORT_WIDTH,
        )
        empty = arrays_with(self.room, self.dtype)
        source = arrays_of(store)
        self.source = {name: fit(source[name], empty[name]) for name in empty if name not in DESKS}
        self.each = {
            name: np.repeat(array[None], worlds, axis=0) for name, array in self.source.items() if name not in SHARED
        }

    def __getitem__(self, name: str) -> AnyArray:
        """The block of that name, (worlds, ...)."""
        return self.each[name]

    @property
    def nbytes(self) -> int:
        """Memory of all blocks, bytes."""
        return sum(block.nbytes for block in self.each.values())

    def columns(self, start: int, width: int) -> NDArray[np.float64]:
        """A view of the same numbers of all bodies, (worlds, n, width)."""
        return self.each["bodies"][:, : self.n, start : start + width]

    def grow(self, pairs: int, slots: int) -> None:
        """Make room for at least so many pairs in every world, and so many that touch."""
        self.room = self.room._replace(pairs=max(pairs, self.room.pairs), slots=max(slots, self.room.slots))
        for name, like in arrays_with(self.room, self.dtype).items():
            if name not in DESKS and like.shape != self.source[name].shape:
                self.source[name] = fit(self.source[name], like)
                if name in self.each:
                    self.each[name] = fit(self.each[name], like, axis=1)

    def reset(self, chosen: AnyArray) -> None:
        """Bring worlds, a mask or indices, back to where they began; what bodies are stays as it is."""
        bodies = self.each["bodies"]
        kept = [bodies[chosen, :, start : start + width] for start, width in KEPT_BY_RESET]
        for name, block in self.each.items():
            block[chosen] = self.source[name]
        for (start, width), numbers in zip(KEPT_BY_RESET, kept, strict=True):
            bodies[chosen, :, start : start + width] = numbers

    def put(self, arrays: dict[str, AnyArray], chosen: AnyArray) -> None:
        """Write state of the same kind into worlds; it may have less room, and one row may be for all."""
        empty = arrays_with(self.room, self.dtype)
        for name, block in self.each.items():
            block[chosen] = fit(arrays[name], empty[name], axis=1)

    def edited(self, chosen: NDArray[np.int64], body: int) -> None:
        """A body was changed from outside in these worlds: it wakes there with all that touch it."""
        counts, lists = self.each["scratch.counts"], self.each["scratch.bodies"]
        chosen = chosen[body < counts[chosen, soft_scratch.N_KNOWN]]
        listed = counts[chosen, soft_scratch.N_EDITED]
        before = np.arange(self.room.bodies) < listed[:, None]
        chosen = chosen[~((lists[chosen, soft_scratch.EDITED] == body) & before).any(axis=1)]
        lists[chosen, soft_scratch.EDITED, counts[chosen, soft_scratch.N_EDITED]] = body
        counts[chosen, soft_scratch.N_EDITED] += 1

    def parts(self, pick: Callable[[AnyArray], Any], desk: Desk) -> dict[str, Any]:
        """Bodies, kinds, ledger and the tuples of arrays; ``pick`` makes of a block what stands for it."""
        return _grouped(lambda name: self._part(name, pick, desk))

    def _part(self, name: str, pick: Callable[[AnyArray], Any], desk: Desk) -> Any:
        if name in DESKS:
            return desk.arrays[name]
        return pick(self.each[name]) if name in self.each else self.source[name]

    def copy_of_world(self, world: int) -> dict[str, Any]:
        """The arrays of one world for a store of its own, with all columns of bodies and a desk."""
        rows = max(self.room.bodies, (self.room.nodes + 1) // 2)
        room = self.room._replace(bodies=rows, nodes=2 * rows, columns=state.BODY_WIDTH)
        made = arrays_with(room, self.dtype)
        for name, like in made.items():
            if name not in DESKS:
                made[name] = fit(self.each[name][world] if name in self.each else self.source[name], like)
        return _grouped(made.__getitem__) | {"desk": soft_scratch.make_desk(room.bodies, room.pairs, room.slots)}

    def of_world(self, world: int, desk: Desk) -> dict[str, Any]:
        """The arrays of one world, views."""
        return self.parts(lambda block: block[world], desk)

    def book(
        self, desk: Desk, table: AnyArray, settings: AnyArray, hulls: Any, bounces: bool, addresses: Any
    ) -> tuple[Any, Any]:
        """The book that the kernel reads at this desk, and what must be kept as long as the book is."""
        parts = self.parts(Each, desk)
        every = Each if table.ndim > 3 else _same
        numbers = Each if settings.ndim > 1 else _same
        kept = (
            parts["bodies"], parts["kinds"], every(table), numbers(settings), parts["ledger"], desk.cycles,
            addresses, parts["tree"], parts["cache"], parts["soft"], parts["scratch"], desk.lists, hulls,
            *(desk.bounces if bounces else ()),
        )  # fmt: skip
        return soft_book.book_of(*kept), kept

    def items(self) -> Iterator[tuple[str, AnyArray]]:
        """Names and blocks."""
        yield from self.each.items()


def _same(array: AnyArray) -> AnyArray:
    return array
