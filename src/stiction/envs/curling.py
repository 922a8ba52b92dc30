"""A curling stone: how fast, where to, with how much spin, and when to sweep."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stiction.batch import Batch
from stiction.envs.task import Array, Chosen, Draw, Mark, Task, Verdict, View
from stiction.materials import MaterialTable
from stiction.shapes import Cylinder, Plane
from stiction.world import World

STONE = 1
RADIUS, HEIGHT, MASS = 0.145, 0.114, 19.1
"""m, m, kg. The World Curling Federation allows 0.914 m around, 0.114 m of height at least, 19.96 kg."""
SPEED, SPEED_RANGE = 2.2, 0.4
ANGLE, SPIN = 0.08, 6.0
LEAST, MOST = 0.008, 0.0105
"""Range of the dynamic coefficient of the ice."""
STATIC = 1.1
SWEEP = 0.25
"""Share of friction that full sweeping takes away: just enough to make up for what the ice may differ."""
BUTTON = 28.35
"""From the hog line where the stone is let go to the middle of the house, m: 93 feet."""
NEAR = 0.3
"""m from the target that count as there."""
REST = 0.01
"""m/s."""
FAR, WIDE = 34.0, 2.4
"""Beyond which the stone is out of play, m."""


class Curling(Task):
    """A stone (19.1 kg) let go at the hog line slides and turns, and is to stop on a target in the house, 28 m away.

    The dynamic coefficient of the ice is drawn from 0.008 to 0.0105 for every episode and not seen, the static one is
    1.1 times as large; sweeping takes up to a quarter away. Friction is Coulomb's: spin uses up a part of it, so that a
    stone that turns goes farther, and curls only a little.

    Observation (6): from the stone to the target x, y (m), velocity x, y (m/s), spin (rad/s), 1 before the stone is let
    go and 0 after.

    Action (4): in the first step the speed, 2.2 m/s plus 0.4 m/s times the first number; the direction, 0.08 rad to the
    left times the second one; the spin, 6 rad/s times the third one. In every step: sweeping, the fourth one, nothing
    below 0. Held for 1/4 s.

    Reward: by how many m the stone came nearer to the target, minus 0.005 for a step of full sweeping.

    Ends: the stone rests (success within 0.3 m of the target) or is out of play; after 160 steps (40 s) truncated.
    """

    name: ClassVar[str] = "Curling"
    episode: ClassVar[int] = 160
    hold: ClassVar[int] = 15
    actions: ClassVar[int] = 4
    limits: ClassVar[tuple[float, ...]] = (40.0, 5.0, 5.0, 5.0, 10.0, 1.0)
    view: ClassVar[View] = View((0, 1), (-1.0, 33.0), (-2.4, 2.4), 1200)

    def build(self) -> World:
        """The ice and the stone."""
        table = MaterialTable()
        table.set_pair("ice", "granite", static=STATIC * MOST, dynamic=MOST)
        world = World(materials=table, sleeping=False)
        world.add(Plane(), static=True, material="ice", name="ice")
        stone = Cylinder(RADIUS, HEIGHT)
        world.add(stone, mass=MASS, position=(0, 0, HEIGHT / 2), material="granite", name="stone")
        return world

    def start(self, batch: Batch) -> None:
        """Coefficients, targets, and what has been thrown."""
        worlds = len(batch)
        self.coefficient = np.full(worlds, MOST)
        self.target = np.zeros((worlds, 2))
        self.distance = np.zeros(worlds)
        self.held = np.ones(worlds, np.bool_)
        self._ice = np.full(worlds, MOST)

    def begin(self, batch: Batch, chosen: Chosen, draw: Draw) -> None:
        """Draw the ice and the target."""
        self.coefficient[chosen] = draw(LEAST, MOST)
        self.target[chosen] = draw(np.array([BUTTON - 1.0, -1.0]), np.array([BUTTON + 1.0, 1.0]))
        self.held[chosen] = True
        self.distance[chosen] = self._distance(batch)[chosen]

    def drive(self, batch: Batch, actions: Array) -> None:
        """Let go what is held; sweep."""
        thrown = np.flatnonzero(self.held)
        if len(thrown):
            speed = SPEED + SPEED_RANGE * actions[thrown, 0]
            angle = ANGLE * actions[thrown, 1]
            batch.velocities[thrown, STONE, 0] = speed * np.cos(angle)
            batch.velocities[thrown, STONE, 1] = speed * np.sin(angle)
            batch.angular_velocities[thrown, STONE, 2] = SPIN * actions[thrown, 2]
            self.held[thrown] = False
        ice = self.coefficient * (1.0 - SWEEP * np.maximum(actions[:, 3], 0.0))
        changed = np.flatnonzero(ice != self._ice)
        if len(changed):
            batch.set_pair("ice", "granite", static=STATIC * ice[changed], dynamic=ice[changed], worlds=changed)
            self._ice = ice

    def observe(self, batch: Batch) -> Array:
        """As the class tells."""
        spin = batch.angular_velocities[:, STONE, 2]
        parts = [self._gap(batch), batch.velocities[:, STONE, :2], spin[:, None], 1.0 * self.held[:, None]]
        return np.concatenate(parts, axis=1)

    def judge(self, batch: Batch, actions: Array) -> Verdict:
        """As the class tells."""
        before, self.distance = self.distance, self._distance(batch)
        at, v = batch.positions[:, STONE], batch.velocities[:, STONE]
        rests = v[:, 0] ** 2 + v[:, 1] ** 2 < REST**2
        out = (at[:, 0] > FAR) | (np.abs(at[:, 1]) > WIDE)
        reward = before - self.distance - 0.005 * np.maximum(actions[:, 3], 0.0)
        return Verdict(reward, rests | out, rests & ~out & (self.distance < NEAR))

    def marks(self, world: int) -> list[Mark]:
        """The ice, the house around its button, the target."""
        rings = ((1.829, "#9cc4e4"), (1.219, "#ffffff"), (0.61, "#f2a7a0"), (0.152, "#ffffff"))
        house = [Mark((BUTTON, 0.0), radius, color) for radius, color in rings]
        x, y = self.target[world].tolist()
        lines = [Mark((place, 0.0), 0.0, "#d08a85", (0.06, 4.8)) for place in (0.0, BUTTON)]
        return [*house, *lines, Mark((x, y), 0.2, "#c2185b")]

    def _gap(self, batch: Batch) -> Array:
        gap: Array = self.target - batch.positions[:, STONE, :2]
        return gap

    def _distance(self, batch: Batch) -> Array:
        gap = self._gap(batch)
        distance: Array = np.sqrt(gap[:, 0] ** 2 + gap[:, 1] ** 2)
        return distance
