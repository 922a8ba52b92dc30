"""Small worlds that recordings are made of."""

from __future__ import annotations

import stiction as st


def tower(boxes: int = 4, solver: str = "soft") -> st.World:
    """Boxes that lie on a plane and on each other, each a little aside, and topple."""
    world = st.World(solver=solver)
    world.add(st.Plane(), static=True)
    for k in range(boxes):
        world.add(st.Box((1, 1, 1)), position=(0.3 * k, 0.02 * k, 0.5 + 1.001 * k))
    return world
