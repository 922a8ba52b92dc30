"""The engines of a comparison as columns: which adapter, which settings, how many steps it takes in a frame.

Every engine runs as it usually does, but without damping and without sleeping. A frame is ``dt`` long, 1/60 s if
nothing else is said; an engine whose own default step is shorter takes several in it (MuJoCo 9 of 1.85 ms, PyBullet 4
of 4.17 ms, SAPIEN 2 of 8.3 ms), and one that splits its step by itself (stiction 8 times, Box3D and Rapier 4) takes
one.
"""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass

from stiction import checks
from stiction.bench.engines import Engine, engine_class


@dataclass(frozen=True)
class Column:
    """An engine with settings.

    Attributes:
        name: on the command line and in tables.
        adapter: name of the engine's adapter, and of the class in its file.
    """

    name: str
    adapter: tuple[str, str]

    @property
    def kind(self) -> type[Engine]:
        """The adapter; the engine itself is not imported."""
        engine, cls = self.adapter
        if cls == "Adapter":
            return engine_class(engine)
        made: type[Engine] = getattr(importlib.import_module(f"stiction.bench.engines.with_{engine}"), cls)
        return made

    def substeps(self, dt: float) -> int:
        """Steps that it takes in a frame of ``dt`` s, so that none is longer than its own default."""
        return max(1, math.ceil(dt / self.kind.usual_dt - 1e-3))

    def settings(self, dt: float) -> str:
        """In words."""
        n = self.substeps(dt)
        step = f"{n} steps of {1e3 * dt / n:.3g} ms a frame" if n > 1 else f"one step of {1e3 * dt:.3g} ms a frame"
        return f"{step}; {self.kind.notes}"


OWN = "stiction"
COLUMNS: dict[str, Column] = {
    column.name: column
    for column in (
        Column(OWN, ("stiction", "Adapter")),
        Column("mujoco", ("mujoco", "Pyramidal")),
        Column("mujoco-elliptic", ("mujoco", "Adapter")),
        Column("rapier3d", ("rapier3d", "Adapter")),
        Column("robox3d", ("robox3d", "Adapter")),
        Column("pybullet", ("pybullet", "Adapter")),
        Column("sapien", ("sapien", "Adapter")),
    )
}
PEERS = tuple(name for name in COLUMNS if name != OWN)


def column(name: str) -> Column:
    """The column of that name.

    Raises:
        InvalidInputError: there is none.
    """
    return COLUMNS[checks.one_of("engine", name, COLUMNS)]
