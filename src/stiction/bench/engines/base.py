"""What an adapter of a physics engine is: one class a file, which builds a scene and steps it."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from stiction.bench.coefficients import Rule, of_bodies
from stiction.bench.scene import BenchBody, BenchScene, Vector

Array = NDArray[np.float64]


class Engine(ABC):
    """One world in one engine: one thread, no damping, no sleeping wherever the engine lets us.

    Attributes:
        name: on the command line and in tables.
        module: to import; distribution: to install.
        kinds: of shapes that it can express.
        drives: whether it moves kinematic bodies that drag others along.
        two_coefficients: whether static and dynamic friction may differ.
        rolls: whether it has rolling resistance.
        bounces: whether it has a coefficient of restitution.
        combines: how it makes the coefficient of a pair from those of two bodies (:data:`coefficients.RULES`).
        usual_dt: s, the largest step at which it is usually run: its own default.
        notes: settings that are not its defaults, and what could not be set.
    """

    name: ClassVar[str]
    module: ClassVar[str]
    distribution: ClassVar[str]
    kinds: ClassVar[frozenset[str]] = frozenset({"sphere", "box", "capsule", "cylinder", "hull"})
    drives: ClassVar[bool] = True
    two_coefficients: ClassVar[bool] = False
    rolls: ClassVar[bool] = False
    bounces: ClassVar[bool] = True
    combines: ClassVar[Rule] = "mean"
    usual_dt: ClassVar[float] = 1.0 / 60.0
    notes: ClassVar[str] = ""

    def __init__(self, solver: str | None = None) -> None:
        self.solver = solver
        self.scene: BenchScene
        self.dt = 0.0
        self.steps = 0

    @classmethod
    def available(cls) -> bool:
        """Whether it is installed; nothing is imported."""
        return importlib.util.find_spec(cls.module) is not None

    @classmethod
    def version(cls) -> str:
        """Of the installed distribution."""
        return importlib.metadata.version(cls.distribution)

    @classmethod
    def load(cls, module: str | None = None) -> Any:
        """The engine's module; imported here and not at the top, for most programs use none of them."""
        return importlib.import_module(module or cls.module)

    def coefficients(self, scene: BenchScene) -> list[float]:
        """A coefficient of friction for each body that makes this engine use those of the scene for pairs."""
        return of_bodies(scene, self.combines)

    def supports(self, scene: BenchScene) -> str | None:
        """Why it cannot run this scene, or None if it can."""
        missing = [kind for kind in scene.kinds if kind not in self.kinds]
        if missing:
            return f"{self.name} has no {' and no '.join(missing)}"
        if (scene.turning or scene.gliding) is not None and not self.drives:
            return f"{self.name} has no kinematic bodies that drag others along"
        if scene.restitution != 0.0 and not self.bounces:
            return f"{self.name} has no coefficient of restitution"
        if scene.rolling != 0.0 and not self.rolls:
            return f"{self.name} has no rolling resistance"
        if scene.dynamic_friction not in (None, scene.friction) and not self.two_coefficients:
            return f"{self.name} has one coefficient only"
        return None

    def build(self, scene: BenchScene, dt: float) -> None:
        """Make the world; dt in s."""
        self.scene, self.dt, self.steps = scene, dt, 0
        self._build(scene, dt)

    def before_step(self) -> None:
        """Push what the scene pushes, and drive its kinematic bodies towards where they must be after the next step."""
        self._push_all()
        targets = self.scene.driven_at((self.steps + 1) * self.dt)
        if not targets:
            return
        turning = self.scene.turning
        spin = np.zeros(3) if turning is None else turning.rate * np.array(turning.axis)
        now = self.positions()
        for index, position, orientation in targets:
            self._drive(index, position, orientation, (position - now[index]) / self.dt, spin)

    def _push_all(self) -> None:
        if self.scene.force is None:
            return
        velocities = self.velocities()
        middle = self.positions() + 0.5 * self.dt * velocities
        forces = self.scene.force(self.steps * self.dt, middle, velocities)
        for index in np.flatnonzero(self.scene.dynamic):
            self._push(int(index), forces[index])

    def step(self) -> None:
        """Take one step: what is timed."""
        self._step()
        self.steps += 1

    @abstractmethod
    def _build(self, scene: BenchScene, dt: float) -> None: ...

    @abstractmethod
    def _step(self) -> None: ...

    def _drive(self, index: int, position: Array, orientation: Array, velocity: Array, spin: Array) -> None:
        """Move a kinematic body to a pose with the next step, or give it the velocities (m/s, rad/s) that do so."""
        raise NotImplementedError(f"{self.name} drives no bodies")

    def _push(self, index: int, force: Array) -> None:
        """Let a force (3,) N act on a dynamic body at its centre of mass through the next step, and no longer."""
        raise NotImplementedError(f"{self.name} pushes no bodies")

    @abstractmethod
    def positions(self) -> Array:
        """(bodies, 3) m, in the order of the scene."""

    @abstractmethod
    def orientations(self) -> Array:
        """(bodies, 4) quaternions (w, x, y, z)."""

    @abstractmethod
    def velocities(self) -> Array:
        """(bodies, 3) m/s."""

    @abstractmethod
    def angular_velocities(self) -> Array:
        """(bodies, 3) rad/s, in world axes."""

    def profile(self, steps: int) -> dict[str, float] | None:
        """Milliseconds a step for each stage of a step, measured over ``steps`` more of them; None if unknown."""
        return None


def floats(values: Vector | Array) -> list[float]:
    """Plain floats, as bindings to other languages want them."""
    return [float(value) for value in values]


def xyzw(orientation: Array | tuple[float, ...]) -> list[float]:
    """A quaternion (w, x, y, z) with its scalar part last."""
    w, x, y, z = floats(np.asarray(orientation))
    return [x, y, z, w]


def wxyz(rows: Array) -> Array:
    """Quaternions (n, 4) whose scalar part is last, with it first."""
    return np.roll(np.asarray(rows, dtype=np.float64).reshape(-1, 4), 1, axis=1)


def density(body: BenchBody) -> float:
    """kg/m^3; bodies that are not dynamic get one too, for engines that insist."""
    return 1000.0 if body.density is None else body.density
