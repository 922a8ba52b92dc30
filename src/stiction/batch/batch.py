"""Batch: copies of one world, stepped together."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks, snapshot
from stiction.batch.blocks import Blocks
from stiction.batch.draws import Draws
from stiction.batch.materials import PairTables
from stiction.batch.state import BatchState
from stiction.batch.workers import Failure, Workers
from stiction.body import Body
from stiction.contacts import contact_rows
from stiction.core import state
from stiction.core.pairs import PAIRS, SLOT
from stiction.core.soft_report import report_contacts
from stiction.core.tree import NONE
from stiction.errors import InvalidInputError, NotYetError
from stiction.hashing import state_hash
from stiction.world import World

Array = NDArray[np.float64]
Chosen = NDArray[np.int64]

MOST_WORLDS = 10**7


class Batch:
    """Many copies of one world, stepped by one compiled call over all cores.

    Every world ends in the same bits as it would alone, for any number of worlds, any order and any number of threads.
    A world whose state stops being finite is frozen at its last finite state and told by :attr:`failed`; the others go
    on. All arrays have the worlds along their first axis.

    Args:
        world: the world to copy, as it is now; later changes of it do not matter. Its solver must be ``"soft"``.
            Or a scene: a :class:`stiction.scene.Scene`, the name of a built-in one, or the path of a file.
        worlds: how many.
        threads: how many threads step them; as many as there are processors if left out.
        seed: of the draws (:meth:`uniform`); each world has its own stream, which depends on the seed and on its
            number only.

    Raises:
        InvalidInputError: a value is not allowed.
        NotYetError: the solver is another one, or a scene has pushes, springs, velocity changes or vehicles.
    """

    def __init__(self, world: Any, worlds: int, *, threads: int | None = None, seed: int = 0) -> None:
        source = world if isinstance(world, World) else _world_of(world)
        if source.solver != "soft":
            raise NotYetError(f"solver must be 'soft' in a batch, got {source.solver!r}.")
        if not len(source):
            raise InvalidInputError("world must have a body at least, got an empty one.")
        count = checks.integer("worlds", worlds, minimum=1)
        if count > MOST_WORLDS:
            raise InvalidInputError(f"worlds must be {MOST_WORLDS} or less, got {worlds!r}.")
        threads = os.cpu_count() or 1 if threads is None else checks.integer("threads", threads, minimum=1)
        self._world = snapshot.copy_of(source)
        store: Any = self._world._store
        store.watch()
        self._store = store
        self._blocks = Blocks(store, count)
        self._workers = Workers(min(threads, count), self._blocks)
        self._draws = Draws(checks.integer("seed", seed, minimum=0), count)
        self._table = PairTables(self._world.materials, self._world._material_names, count)
        self._settings: Array = np.array(self._world._settings, np.float64)
        self._begun = self._world.steps
        self._steps = np.full(count, self._begun, np.int64)
        self._failed = np.zeros(count, np.bool_)
        self._failures: list[Failure] = []

    # --- what it is ---------------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        """How many worlds."""
        return self._blocks.worlds

    def __repr__(self) -> str:
        return f"<Batch of {len(self)} worlds of {self._blocks.n} bodies>"

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies of the world that was copied: their order is that of the second axis of all arrays."""
        return self._world.bodies

    @property
    def dt(self) -> float:
        """Time step, s."""
        return self._world.dt

    @property
    def threads(self) -> int:
        """How many threads step the worlds."""
        return self._workers.threads

    @property
    def steps(self) -> NDArray[np.int64]:
        """(worlds,) steps that each world has taken."""
        return self._steps.copy()

    @property
    def time(self) -> Array:
        """(worlds,) simulated time of each world, s."""
        time: Array = self._steps.astype(np.float64) * self.dt
        return time

    @property
    def nbytes(self) -> int:
        """Memory of the worlds, bytes."""
        return self._blocks.nbytes

    # --- state --------------------------------------------------------------------------------------------------------

    @property
    def positions(self) -> Array:
        """(worlds, n, 3) m, origins of the shapes' frames; a view: writing moves bodies. No copy is made, by DLPack
        neither (``torch.from_dlpack(batch.positions)``). Ask for it and the arrays below again after :meth:`step`,
        which takes other memory when contacts need more room."""
        return self._blocks.columns(state.POSITION, 3)

    @property
    def orientations(self) -> Array:
        """(worlds, n, 4) unit quaternions (w, x, y, z), a view."""
        return self._blocks.columns(state.ORIENTATION, 4)

    @property
    def velocities(self) -> Array:
        """(worlds, n, 3) m/s of the centres of mass, a view."""
        return self._blocks.columns(state.V, 3)

    @property
    def angular_velocities(self) -> Array:
        """(worlds, n, 3) rad/s in world axes, a view."""
        return self._blocks.columns(state.W, 3)

    @property
    def forces(self) -> Array:
        """(worlds, n, 3) N at the centres of mass, for the next step, after which they are zero; a view to write or to
        add to. What is written for bodies that are not dynamic does nothing."""
        return self._blocks.columns(state.FORCE, 3)

    @property
    def torques(self) -> Array:
        """(worlds, n, 3) N m in world axes, for the next step, a view."""
        return self._blocks.columns(state.TORQUE, 3)

    @property
    def masses(self) -> Array:
        """(worlds, n) kg, a copy; infinite unless dynamic."""
        masses = self._blocks.columns(state.MASS, 1)[..., 0].copy()
        masses[:, [body.mobility != "dynamic" for body in self.bodies]] = np.inf
        return masses

    def set_mass(self, body: Body | str, mass: ArrayLike, worlds: ArrayLike | None = None) -> None:
        """Give a body another mass; its inertia tensor is scaled alike.

        Args:
            body: of :attr:`bodies`, or its name.
            mass: kg, one for all or one for each of ``worlds``.
            worlds: a mask or indices; all if left out.

        Raises:
            InvalidInputError: a value is not allowed; nothing has changed.
        """
        index, chosen = self._index(body), self._chosen(worlds)
        if self.bodies[index].mobility != "dynamic":
            raise InvalidInputError(f"mass must not be set of body {self.bodies[index].name!r}, which is not dynamic.")
        masses = _one_each("mass", mass, len(chosen))
        if not (masses > 0.0).all():
            raise InvalidInputError(f"mass must be more than 0 kg, got {masses[~(masses > 0.0)][0]!r}.")
        rows = self._blocks["bodies"]
        ratio = masses / rows[chosen, index, state.MASS]
        inertia = rows[chosen, index, state.INERTIA : state.INERTIA + 9] * ratio[:, None]
        rows[chosen, index, state.MASS] = masses
        rows[chosen, index, state.INVERSE_MASS] = 1.0 / masses
        rows[chosen, index, state.INERTIA : state.INERTIA + 9] = inertia
        inverse = np.linalg.inv(inertia.reshape(-1, 3, 3)).reshape(-1, 9)
        rows[chosen, index, state.INVERSE_INERTIA : state.INVERSE_INERTIA + 9] = inverse
        self._blocks.edited(chosen, index)

    @property
    def gravity(self) -> Array:
        """(worlds, 3) m/s^2, a copy. Setting takes (3,) for all or (worlds, 3), and wakes all bodies."""
        gravity: Array = np.broadcast_to(self._settings[..., :3], (len(self), 3)).copy()
        return gravity

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        wanted = checks.vectors("gravity", np.atleast_2d(np.asarray(value, np.float64)))
        if len(wanted) not in {1, len(self)}:
            raise InvalidInputError(f"gravity must be (3,) or ({len(self)}, 3), got {len(wanted)} vectors.")
        settings = np.repeat(np.atleast_2d(self._settings)[:1], len(wanted), axis=0)
        settings[:, :3] = wanted
        self._settings = np.ascontiguousarray(settings if len(wanted) > 1 else settings[0])
        self._wake(np.arange(len(self)))

    def set_pair(
        self,
        a: str,
        b: str,
        *,
        static: ArrayLike | None = None,
        dynamic: ArrayLike | None = None,
        restitution: ArrayLike | None = None,
        rolling: ArrayLike | None = None,
        torsional: ArrayLike | None = None,
        worlds: ArrayLike | None = None,
    ) -> None:
        """Give a pair of materials other numbers, each world its own if wanted (domain randomisation).

        Args:
            a: one material of the bodies. b: the other one, or the same.
            static: coefficient of static friction, one for all or one for each of ``worlds``; so are ``dynamic``,
                ``restitution``, ``rolling`` (m) and ``torsional`` (m). What is left out stays.
            worlds: a mask or indices; all if left out.

        Raises:
            InvalidInputError: no body is of the material, or a value is not allowed; nothing has changed.
        """
        given = {
            "static": static, "dynamic": dynamic, "restitution": restitution, "rolling": rolling, "torsional": torsional
        }  # fmt: skip
        chosen = self._chosen(worlds)
        self._table.set(a, b, {name: value for name, value in given.items() if value is not None}, chosen)
        self._wake(chosen)

    def pair(self, a: str, b: str) -> dict[str, Array]:
        """The numbers of a pair of materials, (worlds,) each, copies."""
        return self._table.pair(a, b)

    # --- time ---------------------------------------------------------------------------------------------------------

    def step(self, n: int = 1, *, forces: ArrayLike | None = None, torques: ArrayLike | None = None) -> None:
        """Take n steps in every world that is not frozen.

        Args:
            n: how many.
            forces: (worlds, n, 3) N, or what can be broadcast to it, which act in all of the steps; what was written
                into :attr:`forces` acts in the first one. ``torques``: N m, the same.

        Raises:
            InvalidInputError: a value is not allowed; no step was taken.
        """
        steps = checks.integer("n", n, minimum=1)
        given = {"forces": forces, "torques": torques}
        held = {name: self._held(name, value) for name, value in given.items() if value is not None}
        if not held:
            self._take(steps)
            return
        for _ in range(steps):
            for name, value in held.items():
                getattr(self, name)[...] += value
            self._take(1)

    def _held(self, name: str, value: ArrayLike) -> Array:
        shape = self.forces.shape
        try:
            array = np.broadcast_to(np.asarray(value, np.float64), shape)
        except (TypeError, ValueError):
            raise InvalidInputError(
                f"{name} must be an array of shape {shape} or one that can be broadcast to it, got one of shape "
                f"{np.shape(value)}."
            ) from None
        if not np.isfinite(array).all():
            raise InvalidInputError(f"{name} must be finite, got {float(array[~np.isfinite(array)][0])!r}.")
        return array

    def _take(self, steps: int) -> None:
        store, table = self._store, self._table.array
        self._failures += self._workers.step(
            steps,
            self._blocks,
            self._failed,
            table,
            self._settings,
            store.hulls.arrays,
            store.needs(table),
            self._steps,
        )

    # --- worlds that blew up ------------------------------------------------------------------------------------------

    @property
    def failed(self) -> NDArray[np.bool_]:
        """(worlds,) which worlds are frozen because a body's state stopped being finite; :meth:`reset` frees them."""
        return self._failed.copy()

    @property
    def failures(self) -> list[str]:
        """What happened in the worlds that are frozen, a sentence each."""
        return [
            f"world {f.world}, step {f.step + 1}: the state of body {self.bodies[f.body].name!r} is no longer finite."
            for f in self._failures
        ]

    # --- going back ---------------------------------------------------------------------------------------------------

    def reset(self, worlds: ArrayLike | None = None) -> Chosen:
        """Bring worlds back to where they began, contacts and time included; their masses, gravity and materials stay.

        Args:
            worlds: a mask or indices; all if left out.

        Returns:
            Their indices, to vary what they begin with: ``batch.positions[batch.reset(mask), 1] = ...``.
        """
        chosen = self._chosen(worlds)
        self._blocks.reset(chosen)
        self._steps[chosen] = self._begun
        self._free(chosen)
        return chosen

    def _free(self, chosen: Chosen) -> None:
        self._failed[chosen] = False
        self._failures = [f for f in self._failures if self._failed[f.world]]

    def state(self, worlds: ArrayLike | None = None) -> BatchState:
        """A copy of everything that the worlds go on from, for :meth:`set_state`."""
        chosen = self._chosen(worlds)
        arrays = {name: block[chosen] for name, block in self._blocks.items()}
        return BatchState(arrays, self._steps[chosen], self._failed[chosen], self._blocks.n)

    def set_state(self, value: BatchState, worlds: ArrayLike | None = None) -> None:
        """Bring worlds to states that :meth:`state` gave, to the last bit.

        Args:
            value: as many worlds as are chosen, or one for all of them.
            worlds: a mask or indices; all if left out.

        Raises:
            InvalidInputError: it does not fit; nothing has changed.
        """
        if not isinstance(value, BatchState):
            raise InvalidInputError(f"state must be a BatchState, got {type(value).__name__}.")
        chosen = self._chosen(worlds)
        if len(value) not in {1, len(chosen)}:
            raise InvalidInputError(f"state must be of {len(chosen)} worlds, or of one, got {len(value)}.")
        if value.n != self._blocks.n:
            raise InvalidInputError(f"state must be one of {self._blocks.n} bodies, got {value.n}.")
        room, pairs, slots = self._blocks.room, *(len(value.arrays[f"cache.{name}"][0]) for name in ("pairs", "free"))
        if pairs > room.pairs or slots > room.slots:
            self._blocks.grow(pairs, slots)
            self._workers.furnish(self._blocks)
        self._blocks.put(value.arrays, chosen)
        self._steps[chosen] = value.steps
        self._free(chosen)
        self._failed[chosen] = value.failed

    # --- looking at worlds --------------------------------------------------------------------------------------------

    def contacts(self, worlds: ArrayLike | None = None) -> tuple[Chosen, NDArray[Any]]:
        """Contact points of the last step.

        Args:
            worlds: a mask or indices; all if left out.

        Returns:
            (m,) the world of each point, and (m,) rows of :data:`stiction.contacts.CONTACT_DTYPE`.
        """
        numbers, tags = state.make_contacts(4 * self._blocks.room.slots)
        found, rows = [], []
        for world in self._chosen(worlds).tolist():
            p = self._blocks.of_world(world, self._workers.desk)
            cache, soft = p["cache"], p["soft"]
            pairs = cache.pairs[: cache.counts[PAIRS]]
            pairs = pairs[pairs[:, SLOT] != NONE]
            count = report_contacts(
                p["bodies"], pairs, len(pairs), soft.manifolds, soft.meta, soft.reports, numbers, tags
            )
            rows.append(contact_rows(numbers[:count], tags[:count]))
            found.append(np.full(len(rows[-1]), world, np.int64))
        return np.concatenate(found), np.concatenate(rows)

    def hashes(self, worlds: ArrayLike | None = None) -> list[str]:
        """A cryptographic hash of the state of each world, equal to :meth:`stiction.World.state_hash` of it alone."""
        chosen = self._chosen(worlds)
        rows = self._blocks.columns(state.POSITION, 13)
        return [state_hash(int(self._steps[world]), rows[world]) for world in chosen.tolist()]

    def world(self, index: int) -> World:
        """A world of its own that goes on from here to the last bit as this one of the batch does, to look at it."""
        (world,) = self._chosen([index]).tolist()
        other = snapshot.copy_of(self._world)
        store: Any = other._store
        for name, part in self._blocks.copy_of_world(world).items():
            setattr(store, name, part)
        store.steps = int(self._steps[world])
        store.replaced()
        self._table.put(other.materials, world)
        other._gravity = self.gravity[world]
        other._settings = other._make_settings()
        return other

    # --- draws --------------------------------------------------------------------------------------------------------

    def uniform(self, low: ArrayLike, high: ArrayLike, worlds: ArrayLike | None = None) -> Array:
        """Draws between low and high, each world from its own stream.

        Args:
            low, high: numbers or arrays of one shape.
            worlds: a mask or indices; all if left out.

        Returns:
            (chosen worlds, ...) of that shape.
        """
        low, high = np.broadcast_arrays(np.asarray(low, np.float64), np.asarray(high, np.float64))
        drawn: Array = low + (high - low) * self._draws.uniform(self._chosen(worlds), low.shape)
        return drawn

    def normal(self, mean: ArrayLike, deviation: ArrayLike, worlds: ArrayLike | None = None) -> Array:
        """Normal draws, each world from its own stream; arguments and result as those of :meth:`uniform`."""
        mean, deviation = np.broadcast_arrays(np.asarray(mean, np.float64), np.asarray(deviation, np.float64))
        drawn: Array = mean + deviation * self._draws.normal(self._chosen(worlds), mean.shape)
        return drawn

    # --- inside -------------------------------------------------------------------------------------------------------

    def _chosen(self, worlds: ArrayLike | None) -> Chosen:
        """Indices of the worlds that a mask or a list of indices names."""
        if worlds is None:
            return np.arange(len(self))
        given = np.asarray(worlds)
        if given.dtype == np.bool_ and given.shape == (len(self),):
            return np.flatnonzero(given)
        if given.ndim == 1 and (given.dtype.kind in "iu" or not given.size):
            indices = given.astype(np.int64)
            if ((0 <= indices) & (indices < len(self))).all() and len(np.unique(indices)) == len(indices):
                return indices
        raise InvalidInputError(
            f"worlds must be a mask of shape ({len(self)},) or different indices from 0 to {len(self) - 1}, "
            f"got {worlds!r}."
        )

    def _index(self, body: Body | str) -> int:
        own = self._world[body] if isinstance(body, str) else body
        name = own.name if isinstance(own, Body) else None
        if name is None:
            raise InvalidInputError(f"body must be a Body or its name, got {body!r}.")
        return self._world[name].index

    def _wake(self, chosen: Chosen) -> None:
        for index in range(self._blocks.n):
            self._blocks.edited(chosen, index)


def _one_each(name: str, value: ArrayLike, count: int) -> Array:
    """One number for each of ``count`` worlds."""
    try:
        numbers = np.broadcast_to(np.asarray(value, np.float64), (count,)).copy()
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} must be a number or ({count},) numbers, got {value!r}.") from None
    if not np.isfinite(numbers).all():
        raise InvalidInputError(f"{name} must be finite, got {float(numbers[~np.isfinite(numbers)][0])!r}.")
    return numbers


def _world_of(scene: Any) -> World:
    """The world of a scene that needs nobody to drive it."""
    from stiction.scene import Scene, load

    if isinstance(scene, (str, Path)):
        scene = load(scene)
    if not isinstance(scene, Scene):
        raise InvalidInputError(f"world must be a World or a scene, got {type(scene).__name__}.")
    driven: Sequence[str] = [
        name for name in ("pushes", "springs", "velocity_changes", "vehicles") if getattr(scene.table, name)
    ]
    if driven:
        raise NotYetError(
            f"a scene in a batch must not have {' or '.join(driven)} of its own; write Batch.forces instead."
        )
    return scene.build()
