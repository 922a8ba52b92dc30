"""stiction itself, through its public face."""

from __future__ import annotations

import warnings
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from stiction.bench.engines.base import Array, Engine
from stiction.bench.scene import BenchScene
from stiction.errors import IterationLimitWarning, NotYetError


class Adapter(Engine):
    """A ``World`` with a table of one pair."""

    name = "stiction"
    module = "stiction"
    distribution = "stiction"
    two_coefficients = True
    rolls = True
    notes = "solver and settings of World() unless --solver says otherwise"

    @classmethod
    def version(cls) -> str:
        """Of these sources, which need not be what is installed."""
        return str(cls.load().__version__)

    def supports(self, scene: BenchScene) -> str | None:
        """Tried on a throw-away world: shapes arrive with versions."""
        st = self.load()
        world = self._world(scene, 1.0 / 60.0)
        shapes = {body.shape.kind: body.shape for body in scene.bodies}
        for shape in shapes.values():
            try:
                world.add(shape, material=st.materials.DEFAULT_MATERIAL)
            except NotYetError as error:
                return str(error).rstrip(".")
        return None

    def _world(self, scene: BenchScene, dt: float) -> Any:
        st = self.load()
        table = st.MaterialTable()
        ratio = 1.0 if scene.dynamic_friction is None else scene.dynamic_friction / scene.friction
        names = sorted({"default", *(body.surface for body in scene.bodies)})
        own = {frozenset((a, b)): mu for a, b, mu in scene.pairs}
        for a, b in combinations_with_replacement(names, 2):
            mu = own.get(frozenset((a, b)), scene.friction)
            pair = {"static": mu, "dynamic": ratio * mu, "restitution": scene.restitution, "rolling": scene.rolling}
            table.set_pair(a, b, **pair)
        return st.World(gravity=scene.gravity, dt=dt, solver=self.solver, materials=table, sleeping=False)

    def _build(self, scene: BenchScene, dt: float) -> None:
        world = self._world(scene, dt)
        for body in scene.bodies:
            pose = {"position": body.position, "orientation": body.orientation, "material": body.surface}
            if body.kinematic:
                moves = {"velocity": body.velocity, "angular_velocity": body.angular_velocity}
                world.add(body.shape, kinematic=True, **pose, **moves)
            elif body.density is None:
                world.add(body.shape, static=True, **pose)
            else:
                moves = {"velocity": body.velocity, "angular_velocity": body.angular_velocity}
                world.add(body.shape, density=body.density, **pose, **moves)
        self.world = world
        warnings.simplefilter("ignore", IterationLimitWarning)  # the numbers beside the time say it better

    def _step(self) -> None:
        self.world.step()

    def _drive(self, index: int, position: Array, orientation: Array, velocity: Array, spin: Array) -> None:
        self.world.velocities[index] = velocity
        self.world.angular_velocities[index] = spin

    def _push(self, index: int, force: Array) -> None:
        self.world.bodies[index].apply_force(force)

    def positions(self) -> Array:
        return np.array(self.world.positions)

    def orientations(self) -> Array:
        return np.array(self.world.orientations)

    def velocities(self) -> Array:
        return np.array(self.world.velocities)

    def angular_velocities(self) -> Array:
        return np.array(self.world.angular_velocities)

    def profile(self, steps: int) -> dict[str, float] | None:
        """``World.profile(steps)``, if this version's world has it, as milliseconds a step."""
        measure = getattr(self.world, "profile", None)
        if not callable(measure):
            return None
        try:
            found = measure(steps)
        except NotYetError:
            return None
        stages = found if isinstance(found, dict) else found._asdict() if hasattr(found, "_asdict") else vars(found)
        return {str(stage): float(value) for stage, value in stages.items() if isinstance(value, (int, float))}
