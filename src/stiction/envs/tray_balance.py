"""Carrying cups on a tray, quickly, without losing any."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stiction.batch import Batch
from stiction.envs.task import Array, Chosen, Draw, Mark, Task, Verdict, View
from stiction.materials import MaterialTable
from stiction.shapes import Box, Cylinder
from stiction.world import World

STRONGEST, TURN = 4.0, 1.5
"""m/s^2 and rad/s of the tray."""
STEEPEST = 0.35
"""rad."""
HEAVY = 1e5
"""kg of the tray. It is pushed by forces and is too heavy for the cups to matter. A kinematic one would keep its
velocity through each step: it would accelerate in jerks, and cups would slip a little in each of them."""
LEAST, MOST = 0.12, 0.4
"""Range of the dynamic coefficient between tray and cup."""
STATIC = 1.2
TRAY, CUPS = 0, slice(1, 4)
PLACES = (-0.14, 0.0, 0.14)
RADII, HEIGHTS = (0.035, 0.03, 0.04), (0.1, 0.14, 0.07)
LENGTH, THICK, UP = 0.5, 0.02, 1.0
NEAR, SLOW, LEVEL = 0.05, 0.1, 0.05
"""m, m/s, rad: there."""
UPRIGHT = 0.8
"""Cosine of the angle between cup and tray at which a cup counts as tipped: 37 degrees."""


class TrayBalance(Task):
    """A tray with three cups goes from rest to a goal. It may lean into the curve of its speed, as waiters do.

    Between the tray and each cup the dynamic coefficient is drawn from 0.12 to 0.4 for every episode, the static one is
    1.2 times as large. They are not seen. The tall cup tips where the coefficient is above its width over its height.

    Observation (9): from the tray to the goal (m), velocity of the tray (m/s), its tilt (rad, positive if its front is
    down), how far each cup has slid along the tray (3, m), how fast it slides (3, m/s).

    Action (2): acceleration of the tray along x, 1 for 4 m/s^2; rate of its tilt, 1 for 1.5 rad/s, up to 0.35 rad. Held
    for 1/15 s.

    Reward: by how many m the tray came nearer to the goal, minus 0.005 a step, 1 for arriving, minus 1 for a loss.

    Ends: the tray is within 5 cm of the goal, slower than 0.1 m/s and level to 0.05 rad, with all cups standing
    (success); a cup falls off or tips; after 75 steps (5 s) truncated.
    """

    name: ClassVar[str] = "TrayBalance"
    episode: ClassVar[int] = 75
    drives: ClassVar[int] = 4
    actions: ClassVar[int] = 2
    limits: ClassVar[tuple[float, ...]] = (20.0, 20.0, 1.0, *(3 * (2.0,)), *(3 * (20.0,)))
    view: ClassVar[View] = View((0, 2), (-0.5, 2.3), (0.6, 1.5), 700)

    def build(self) -> World:
        """The tray and its cups; nothing below."""
        table = MaterialTable()
        names = [f"cup {k}" for k in range(len(PLACES))]
        for name in names:
            table.set_pair("tray", name, static=0.3, dynamic=0.3)
            for other in names:
                table.set_pair(name, other, static=0.3, dynamic=0.3)
        world = World(materials=table, sleeping=False)
        world.add(Box((LENGTH, 0.3, THICK)), mass=HEAVY, position=(0, 0, UP), material="tray", name="tray")
        for name, x, radius, height in zip(names, PLACES, RADII, HEIGHTS, strict=True):
            place = (x, 0, UP + (THICK + height) / 2)
            world.add(Cylinder(radius, height), mass=0.2, position=place, material=name, name=name)
        return world

    def start(self, batch: Batch) -> None:
        """Goals, tilts and distances."""
        self.goal = np.zeros(len(batch))
        self.tilt = np.zeros(len(batch))
        self.speed = np.zeros(len(batch))
        self.distance = np.zeros(len(batch))

    def begin(self, batch: Batch, chosen: Chosen, draw: Draw) -> None:
        """Draw coefficients and the goal."""
        drawn = draw(np.full(len(PLACES), LEAST), np.full(len(PLACES), MOST))
        for k in range(len(PLACES)):
            batch.set_pair("tray", f"cup {k}", static=STATIC * drawn[:, k], dynamic=drawn[:, k], worlds=chosen)
        self.goal[chosen] = draw(0.8, 1.8)
        self.tilt[chosen] = 0.0
        self.speed[chosen] = 0.0
        self.distance[chosen] = np.abs(self.goal - batch.positions[:, TRAY, 0])[chosen]

    def drive(self, batch: Batch, actions: Array) -> None:
        """Accelerate and turn the tray for one step of the world."""
        dt = batch.dt
        a = STRONGEST * actions[:, 0]
        wanted = np.clip(self.tilt + TURN * dt * actions[:, 1], -STEEPEST, STEEPEST)
        # what it should do is written anew each time, so that the little that the cups push does not add up
        batch.velocities[:, TRAY] = 0.0
        batch.velocities[:, TRAY, 0] = self.speed
        batch.angular_velocities[:, TRAY] = 0.0
        batch.angular_velocities[:, TRAY, 1] = (wanted - self.tilt) / dt
        batch.forces[:, TRAY] = -HEAVY * batch.gravity
        batch.forces[:, TRAY, 0] += HEAVY * a
        self.speed = self.speed + a * dt
        self.tilt = wanted

    def _on_tray(self, batch: Batch) -> tuple[Array, Array, Array]:
        """Of each cup (worlds, 3): its place along the tray and above it, m, and its speed along it, m/s."""
        along, up = self._axes(batch)
        arm = batch.positions[:, CUPS] - batch.positions[:, TRAY, None]
        turn = batch.angular_velocities[:, TRAY, 1]
        v = batch.velocities[:, CUPS] - batch.velocities[:, TRAY, None]
        # velocity of the tray's point below the cup: turn about y gives (turn z, 0, -turn x)
        vx, vz = v[..., 0] - turn[:, None] * arm[..., 2], v[..., 2] + turn[:, None] * arm[..., 0]
        place = arm[..., 0] * along[:, None, 0] + arm[..., 2] * along[:, None, 2]
        height = arm[..., 0] * up[:, None, 0] + arm[..., 2] * up[:, None, 2]
        return place, height, vx * along[:, None, 0] + vz * along[:, None, 2]

    @staticmethod
    def _axes(batch: Batch) -> tuple[Array, Array]:
        """(worlds, 3) of the tray, which only turns about y: along it, and up."""
        w, y = batch.orientations[:, TRAY, 0], batch.orientations[:, TRAY, 2]
        cosine, sine, none = w * w - y * y, 2.0 * w * y, np.zeros(len(batch))
        return np.stack([cosine, none, -sine], axis=1), np.stack([sine, none, cosine], axis=1)

    def observe(self, batch: Batch) -> Array:
        """As the class tells."""
        place, _, speed = self._on_tray(batch)
        own = [self.goal - batch.positions[:, TRAY, 0], batch.velocities[:, TRAY, 0], self.tilt]
        return np.concatenate([np.stack(own, axis=1), place - PLACES, speed], axis=1)

    def judge(self, batch: Batch, actions: Array) -> Verdict:
        """As the class tells."""
        place, height, _ = self._on_tray(batch)
        _, up = self._axes(batch)
        w, x, y, z = np.moveaxis(batch.orientations[:, CUPS], -1, 0)
        own = np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z], axis=-1)
        upright = own[..., 0] * up[:, None, 0] + own[..., 2] * up[:, None, 2]
        beside = np.abs(batch.positions[:, CUPS, 1]) > 0.15
        lost = ((upright < UPRIGHT) | (height < 0.0) | (np.abs(place) > LENGTH / 2) | beside).any(axis=1)
        before, self.distance = self.distance, np.abs(self.goal - batch.positions[:, TRAY, 0])
        still = np.abs(batch.velocities[:, TRAY, 0]) < SLOW
        there = (self.distance < NEAR) & still & (np.abs(self.tilt) < LEVEL) & ~lost
        return Verdict(before - self.distance - 0.005 + 1.0 * there - 1.0 * lost, there | lost, there)

    def marks(self, world: int) -> list[Mark]:
        """A post at the goal."""
        return [Mark((float(self.goal[world]), 0.78), 0.0, "#c2185b", (2 * NEAR, 0.36))]
