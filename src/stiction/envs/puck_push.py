"""Pushing a puck to a target, over a floor whose friction nobody knows."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from stiction import checks
from stiction.batch import Batch
from stiction.envs.task import Array, Chosen, Draw, Mark, Task, Verdict, View
from stiction.errors import InvalidInputError
from stiction.materials import MaterialTable
from stiction.shapes import Cylinder, Plane, Sphere
from stiction.world import World

FASTEST = 1.0
"""m/s of the pusher along each axis."""
PATCH = 0.4
"""Side of a patch, m."""
ACROSS, ALONG = 3, 4
"""Patches in y and x; the outermost ones go on for ever."""
LEAST, MOST = 0.08, 0.5
"""Range of the dynamic coefficient of a patch."""
STATIC = 1.25
"""Static coefficient over the dynamic one."""
PUCK, PUSHER = 1, 2
RADIUS, HEIGHT = 0.06, 0.04
NEAR, SLOW = 0.04, 0.05
"""m and m/s: there."""


class PuckPush(Task):
    """A ball on rails pushes a puck (0.5 kg, 12 cm across) to a target; what does not touch it slides on and stops.

    The floor has 4 x 3 patches of 0.4 m. Each has a dynamic coefficient drawn from 0.08 to 0.5 for every episode, and a
    static one that is 1.25 times as large. They are not seen. The patch under the puck's centre counts for all of it.

    Observation (8): from the puck to the target x, y (m); velocity of the puck x, y (m/s); from the puck to the pusher
    x, y (m); position of the puck x, y (m).

    Action (2): velocity of the pusher, 1 for 1 m/s, x and y; held for 1/15 s.

    Reward: by how many m the puck came nearer to the target, minus 0.002 a step, and 1 for arriving.

    Ends: the puck lies within 4 cm of the target, slower than 5 cm/s (success); after 120 steps (8 s) truncated.

    Args:
        friction: other limits from and to which the dynamic coefficients are drawn.

    Raises:
        InvalidInputError: they are no two numbers, 0 or more, in their order.
    """

    name: ClassVar[str] = "PuckPush"
    episode: ClassVar[int] = 120
    drives: ClassVar[int] = 4
    actions: ClassVar[int] = 2
    limits: ClassVar[tuple[float, ...]] = (5.0, 5.0, 5.0, 5.0, 10.0, 10.0, 5.0, 5.0)
    view: ClassVar[View] = View((0, 1), (-0.3, 1.4), (-0.6, 0.6))

    def __init__(self, friction: ArrayLike = (LEAST, MOST)) -> None:
        least, most = checks.vector("friction", friction, 2).tolist()
        if not 0.0 <= least <= most:
            raise InvalidInputError(f"friction must be two numbers, 0 or more, in their order, got {friction!r}.")
        self.friction = least, most

    def build(self) -> World:
        """A floor, the puck, the pusher."""
        table = MaterialTable()
        table.set_pair("puck", "floor", static=0.3, dynamic=0.3)
        table.set_pair("puck", "pusher", static=0.2, dynamic=0.2)
        table.set_pair("pusher", "floor", static=0.0, dynamic=0.0)
        world = World(materials=table, sleeping=False)
        world.add(Plane(), static=True, material="floor", name="floor")
        world.add(Cylinder(RADIUS, HEIGHT), mass=0.5, position=(0, 0, HEIGHT / 2), material="puck", name="puck")
        world.add(Sphere(0.03), kinematic=True, position=(-0.15, 0, HEIGHT / 2), material="pusher", name="pusher")
        return world

    def start(self, batch: Batch) -> None:
        """Coefficients, targets and distances."""
        worlds = len(batch)
        self.coefficients = np.zeros((worlds, ALONG * ACROSS))
        self.target = np.zeros((worlds, 2))
        self.distance = np.zeros(worlds)
        self._under = np.full(worlds, -1)

    def begin(self, batch: Batch, chosen: Chosen, draw: Draw) -> None:
        """Draw coefficients, target, and where the puck lies across."""
        self.coefficients[chosen] = draw(*(np.full(ALONG * ACROSS, limit) for limit in self.friction))
        self.target[chosen] = draw(np.array([0.7, -0.35]), np.array([1.2, 0.35]))
        batch.positions[chosen, PUCK, 1] = draw(-0.1, 0.1)
        self._under[chosen] = -1
        self.distance[chosen] = self._distance(batch)[chosen]

    def drive(self, batch: Batch, actions: Array) -> None:
        """Move the pusher, and give the puck the friction of the patch below it."""
        batch.velocities[:, PUSHER, :2] = FASTEST * actions
        at = batch.positions[:, PUCK, :2]
        column = np.clip(np.floor(at[:, 0] / PATCH), 0, ALONG - 1)
        row = np.clip(np.floor(at[:, 1] / PATCH + ACROSS / 2), 0, ACROSS - 1)
        under = (row * ALONG + column).astype(np.int64)
        changed = np.flatnonzero(under != self._under)
        if len(changed):
            dynamic = self.coefficients[changed, under[changed]]
            batch.set_pair("puck", "floor", static=STATIC * dynamic, dynamic=dynamic, worlds=changed)
            self._under = under

    def observe(self, batch: Batch) -> Array:
        """As the class tells."""
        puck = batch.positions[:, PUCK, :2]
        return np.concatenate(
            [self.target - puck, batch.velocities[:, PUCK, :2], batch.positions[:, PUSHER, :2] - puck, puck], axis=1
        )

    def judge(self, batch: Batch, actions: Array) -> Verdict:
        """As the class tells."""
        before, self.distance = self.distance, self._distance(batch)
        v = batch.velocities[:, PUCK]
        there = (self.distance < NEAR) & (v[:, 0] ** 2 + v[:, 1] ** 2 < SLOW**2)
        return Verdict(before - self.distance - 0.002 + 1.0 * there, there, there)

    def marks(self, world: int) -> list[Mark]:
        """Patches, the darker the rougher, and the target."""
        found = []
        for patch, coefficient in enumerate(self.coefficients[world].tolist()):
            row, column = divmod(patch, ALONG)
            center = (column + 0.5) * PATCH, (row + 0.5 - ACROSS / 2) * PATCH
            if column == 0:  # it begins where the picture does
                center = 0.05, center[1]
            size = (0.7 if column == 0 else PATCH), PATCH
            shade = 0.97 - 0.4 * min(max((coefficient - LEAST) / (MOST - LEAST), 0.0), 1.0)
            found.append(Mark(center, 0.0, f"{shade:.3f}", size))
        x, y = self.target[world].tolist()
        return [*found, Mark((x, y), NEAR + RADIUS, "#c2185b"), Mark((x, y), NEAR, "#ffffff")]

    def _distance(self, batch: Batch) -> Array:
        gap = self.target - batch.positions[:, PUCK, :2]
        distance: Array = np.sqrt(gap[:, 0] ** 2 + gap[:, 1] ** 2)
        return distance
