"""Another solver for a world on its way: the same bodies, in the state that they have, in a store of the other kind."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction.core import state
from stiction.errors import NotYetError
from stiction.store import Store


def move(old: Store, solver: str, precision: str) -> Store:
    """A store for ``solver`` with everything that ``old`` knows, but for its memory of contacts, and all bodies awake.

    Raises:
        NotYetError: there is a sensor or a body with grain, which ``micro`` does not have; ``old`` is as before.
    """
    new = _empty(old, solver, precision)
    new.hulls = old.hulls
    for i in range(old.n):
        shape, mobility, material = (int(k) for k in old.kinds[i, :3])
        new.add({0: old.bodies[i]}, shape, mobility, material)
        new.kinds[i, state.LAYER : state.SENSOR + 1] = old.kinds[i, state.LAYER : state.SENSOR + 1]
    new.sensors, new.steps = old.sensors, old.steps
    new.ledger[:] = old.ledger
    return new


def _empty(old: Store, solver: str, precision: str) -> Store:
    soft: Any = getattr(old, "soft", None)
    grains = np.zeros((0, 3)) if soft is None else soft.grain[1 : old.n + 1]
    if solver == "micro":
        if old.sensors:
            raise NotYetError("sensors are not there yet with solver 'micro'; solver 'soft' has them.")
        if grains.any():
            raise NotYetError("grain is not there yet with solver 'micro'; solver 'soft' has it.")
        return Store()
    from stiction.soft_store import SoftStore

    threads = old.crew.threads if isinstance(old, SoftStore) and solver == "soft" else 1
    new = SoftStore(precision, threads, solver == "exact")
    while len(new.bodies) < old.n:
        new._grow_bodies()
    for i, grain in enumerate(grains):
        new.soft.grain[i + 1] = grain
    return new
