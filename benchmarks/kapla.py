"""How long a building of 102 blocks stands: ``python benchmarks/kapla.py [dt ...]``, up to 600 s each.

The test "kapla" of SimBenchmark (Hwangbo, Kang and Hutter, ETH Zurich, 2018), whose own step is 0.01 s. The friction
coefficient is not told there; it is 0.8 here.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import stiction as st
from stiction.verify.cases_dynamics import kapla_blocks

SECONDS = 600.0
FALLEN = 0.1
"""m: a block that is lower than its place by its own height."""


def main(steps: list[float]) -> None:
    """Print when each building fell, or how far its blocks have gone."""
    for dt in steps:
        table = st.MaterialTable()
        table.set_pair("default", "default", static=0.8, dynamic=0.8)
        world = st.World(dt=dt, materials=table)
        world.add(st.Plane(), static=True)
        for size, position in kapla_blocks():
            world.add(st.Box(size), mass=10.0, position=position)
        starts, began = world.positions.copy(), time.perf_counter()
        end = "stands"
        while world.time < SECONDS:
            world.run(1.0)
            moved = (world.positions - starts)[1:]
            if float(np.min(moved[:, 2])) < -FALLEN:
                end = f"fell after {world.time:.0f} s"
                break
        drift = 1e3 * float(np.max(np.hypot(moved[:, 0], moved[:, 1])))
        print(
            f"dt {dt:.5f} s: {end}, drift {drift:.3f} mm, {time.perf_counter() - began:.1f} s of wall time", flush=True
        )


if __name__ == "__main__":
    main([float(text) for text in sys.argv[1:]] or [1.0 / 60.0, 0.01, 1.0 / 120.0, 1.0 / 240.0])
