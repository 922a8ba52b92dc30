"""Questions about shapes and places: rays, boxes, balls, and what a sensor sees. Part of :class:`stiction.World`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.body import Body
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.store import Store

Array = NDArray[np.float64]


class RayHit(NamedTuple):
    """Where a ray enters a body.

    Attributes:
        body: whom it hits.
        point: where, (3,), m.
        normal: of the surface there, outwards, (3,).
        distance: from the ray's origin, m.
    """

    body: Body
    point: Array
    normal: Array
    distance: float


class RayHits(NamedTuple):
    """The first hits of k rays.

    Attributes:
        body: (k,) index of the body that is hit, -1 where there is none.
        point, normal: (k, 3) m, and outwards; nan where there is no hit.
        distance: (k,) m; inf where there is no hit.
    """

    body: NDArray[np.int64]
    point: Array
    normal: Array
    distance: Array


class Queries:
    """The questions of a world. They see bodies where they are now, static and sleeping ones too, but no sensors.

    Asking changes nothing of what comes. Surfaces belong to the shapes; a plane is all of its half space. ``mask`` is a
    whole number whose bits are the layers that count, -1 for all of them. The first question of a kind compiles for
    some seconds on a new machine. In a world of ``micro`` every question first looks at all bodies.
    """

    _store: Store
    _bodies: list[Body]
    _gravity: Array
    _dt: float

    @overload
    def ray_cast(
        self,
        origin: ArrayLike,
        direction: ArrayLike,
        max_distance: float = ...,
        *,
        all: Literal[False] = ...,
        mask: int = ...,
    ) -> RayHit | None: ...
    @overload
    def ray_cast(
        self, origin: ArrayLike, direction: ArrayLike, max_distance: float = ..., *, all: Literal[True], mask: int = ...
    ) -> list[RayHit]: ...
    def ray_cast(
        self,
        origin: ArrayLike,
        direction: ArrayLike,
        max_distance: float = math.inf,
        *,
        all: bool = False,
        mask: int = checks.ALL_LAYERS,
    ) -> RayHit | list[RayHit] | None:
        """The first body that a ray enters, or None; or all of them, nearest first.

        A ray that begins inside a body hits it at distance 0, with a normal against the ray.

        Args:
            origin: (3,), m.
            direction: (3,), of any length but 0.
            max_distance: m, may be inf.
            all: give every body that the ray enters.
            mask: layers that count.

        Raises:
            InvalidInputError: a value is not allowed.
        """
        if not isinstance(all, bool):
            raise InvalidInputError(f"all must be True or False, got {all!r}.")
        start, way = checks.vector("origin", origin), checks.unit_vector("direction", direction)
        reach, bits = _reach(max_distance), checks.layers("mask", mask)
        room = 32 if all else 1
        hits, bodies, counts = self._cast(start[None], way[None], reach, bits, room)
        while all and counts[0] == room:
            room *= 8
            hits, bodies, counts = self._cast(start[None], way[None], reach, bits, room)
        found = [
            RayHit(self._bodies[i], start + row[0] * way, row[1:4].copy(), float(row[0]))
            for i, row in zip(bodies[0, : counts[0]].tolist(), hits[0], strict=False)
        ]
        return found if all else found[0] if found else None

    def ray_cast_many(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        max_distance: float = math.inf,
        *,
        mask: int = checks.ALL_LAYERS,
    ) -> RayHits:
        """The first body that each of k rays enters, in one compiled call.

        Args:
            origins: (k, 3) m, or (3,) for all of them.
            directions: (k, 3), of any length but 0, or (3,) for all of them.
            max_distance: m, may be inf.
            mask: layers that count.

        Raises:
            InvalidInputError: a value is not allowed.
        """
        starts, ways = checks.vectors("origins", origins), checks.vectors("directions", directions)
        if starts.ndim == ways.ndim == 1:
            starts = starts[None]
        if starts.ndim == ways.ndim == 2 and len(starts) != len(ways):
            raise InvalidInputError(
                f"origins and directions must be as many, got {len(starts)} origins and {len(ways)} directions."
            )
        starts, ways = np.broadcast_arrays(starts, ways)
        largest = np.abs(ways).max(axis=1, keepdims=True, initial=0.0)
        if (largest < 1e-12).any():
            row = int(np.flatnonzero(largest < 1e-12)[0])
            raise InvalidInputError(f"directions must not hold the zero vector, got {ways[row].tolist()} in row {row}.")
        ways = ways / largest
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        starts = np.ascontiguousarray(starts)
        hits, bodies, counts = self._cast(starts, ways, _reach(max_distance), checks.layers("mask", mask), 1)
        hit = counts > 0
        distance = np.where(hit, hits[:, 0, 0], math.inf)
        normal = np.where(hit[:, None], hits[:, 0, 1:4], math.nan)
        point = np.full((len(hit), 3), math.nan)
        point[hit] = starts[hit] + distance[hit, None] * ways[hit]
        return RayHits(np.where(hit, bodies[:, 0], -1), point, normal, distance)

    def overlap_box(self, center: ArrayLike, size: ArrayLike, *, mask: int = checks.ALL_LAYERS) -> list[Body]:
        """Bodies that overlap a box along the world's axes, in order of creation.

        Args:
            center: (3,), m. size: full lengths, (3,), m.
            mask: layers that count.

        Raises:
            InvalidInputError: a value is not allowed.
        """
        middle, lengths = checks.vector("center", center), checks.vector("size", size)
        if (lengths <= 0.0).any():
            raise InvalidInputError(f"size must be three lengths above 0 m, got {size!r}.")
        return self._region(middle, 0.5 * lengths, 0.0, checks.layers("mask", mask))

    def overlap_sphere(self, center: ArrayLike, radius: float, *, mask: int = checks.ALL_LAYERS) -> list[Body]:
        """Bodies that overlap a ball, in order of creation.

        Args:
            center: (3,), m. radius: m.
            mask: layers that count.

        Raises:
            InvalidInputError: a value is not allowed.
        """
        middle, r = checks.vector("center", center), checks.positive("radius", radius, "m")
        return self._region(middle, np.zeros(3), r, checks.layers("mask", mask))

    def overlaps(self, sensor: Body) -> list[Body]:
        """Bodies whose shapes overlap a sensor now, in order of creation.

        Exact, by the distance of the shapes. Layers have to agree; sensors do not see each other, and only a dynamic
        sensor sees static bodies. What flies through a sensor within one step is not seen.

        Raises:
            InvalidInputError: it is not a sensor of this world.
        """
        self._own("sensor", sensor)
        if not sensor.sensor:
            raise InvalidInputError(f"sensor must be a body added with sensor=True, got {sensor!r}.")
        from stiction.core import questions

        store, out = self._store, self._room()
        found = questions.find_overlaps(*self._arguments(), sensor.index, store.points, out)
        return [self._bodies[i] for i in sorted(out[:found].tolist())]

    # --- inside -------------------------------------------------------------------------------------------------------

    def _own(self, name: str, body: Any) -> None:
        """A body of this world that has not been removed, or one sentence."""
        if not isinstance(body, Body) or body._world is not self:
            raise InvalidInputError(f"{name} must be a body of this world, got {body!r}.")
        body.index  # noqa: B018 -- raises where it was removed

    def _arguments(self) -> tuple[Any, ...]:
        """What every question takes first, up to date."""
        store = self._store
        tree, cache = store.fresh_tree(float(np.linalg.norm(self._gravity)), self._dt)
        return tree, cache, store.bodies, store.kinds, store.hulls.arrays

    def _room(self) -> NDArray[np.int64]:
        return np.zeros(len(self._bodies), np.int64)

    def _cast(
        self, origins: Array, ways: Array, reach: float, mask: int, room: int
    ) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        """Of each ray the hits (k, room, 4), distance and normal, the bodies (k, room), and how many there are (k,)."""
        from stiction.core import query, questions

        k = len(origins)
        hits, bodies = np.zeros((k, room, query.HIT_WIDTH)), np.zeros((k, room), np.int64)
        counts = np.zeros(k, np.int64)
        if self._bodies:
            questions.cast_rays(*self._arguments(), origins, ways, reach, mask, hits, bodies, counts)
        return hits, bodies, counts

    def _region(self, center: Array, half: Array, radius: float, mask: int) -> list[Body]:
        from stiction.core import questions

        out = self._room()
        if not self._bodies:
            return []
        found = questions.find_in_region(
            *self._arguments(), center[None], half[None], radius, mask, self._store.points, out
        )
        return [self._bodies[i] for i in sorted(out[:found].tolist())]


def _reach(max_distance: Any) -> float:
    """Above 0 m, and inf is allowed."""
    if isinstance(max_distance, float) and max_distance == math.inf:
        return math.inf
    return checks.positive("max_distance", max_distance, "m")
