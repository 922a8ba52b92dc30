"""What ``micro`` costs: ``python benchmarks/micro.py``, on an idle machine; nothing here is asserted.

Prints medians over repeated runs: a hundred boxes on a plane, one body stepped from Python and in one compiled call,
a pyramid, memory and time to add ten thousand bodies, the start of a process from a warm and a cold kernel cache.
"""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable

import stiction as st
from stiction.scene import Simulation, load

FIRST_STEP = """
import time; began = time.perf_counter()
from stiction.scene import Simulation, load
Simulation(load("ramp")).advance(1)
print(time.perf_counter() - began)
"""
"""Import and first step of the scene ``ramp`` in a fresh process."""


def boxes_on_plane(count: int) -> st.World:
    """Boxes side by side."""
    world = st.World()
    world.add(st.Plane(), static=True)
    side = max(1, round(count**0.5))
    for i in range(count):
        world.add(st.Box((1, 1, 1)), position=(1.5 * (i % side), 1.5 * (i // side), 0.5))
    return world


def one(shape: st.Shape | None, height: float = 0.5, velocity: float = 0.0) -> st.World:
    """One body on a plane, or, without a shape, one that flies."""
    world = st.World()
    if shape is None:
        world.add(st.Box((1, 1, 1)))
    else:
        world.add(st.Plane(), static=True)
        world.add(shape, position=(0, 0, height), velocity=(velocity, 0, 0))
    return world


def median_of(call: Callable[[], None], repeats: int) -> float:
    """Median wall time, s."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def resident() -> int:
    """Resident memory of this process, bytes (Linux)."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def first_step(cache: str | None) -> float:
    """Wall time of ``FIRST_STEP``, s; from a kernel cache in that folder."""
    environment = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}
    done = subprocess.run(
        [sys.executable, "-c", FIRST_STEP], env=environment, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def main() -> None:
    """Measure and print."""
    warnings.simplefilter("ignore", st.IterationLimitWarning)
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    print(f"{cpu or platform.processor()}, Python {platform.python_version()}, medians")

    world = boxes_on_plane(100)
    world.step(10)
    print(f"100 boxes on a plane         {median_of(world.step, 300) * 1e3:8.3f} ms a step")
    pyramid = Simulation(load("pyramid"))
    pyramid.advance(1)
    print(f"pyramid of 55                {median_of(pyramid.advance, 20) * 1e3:8.1f} ms a step")
    for name, world in (
        ("one body that flies", one(None)),
        ("one ball at rest", one(st.Sphere(0.5))),
        ("one crate at rest", one(st.Box((1, 1, 1)))),
    ):
        world.step(10)
        in_one = median_of(lambda world=world: world.step(1000), 30) * 1e3
        alone = median_of(world.step, 3000) * 1e6
        print(f"{name:28} {alone:8.2f} us by world.step(), {in_one:.2f} us a step in world.step(1000)")

    before = resident()
    began = time.perf_counter()
    world = boxes_on_plane(10_000)
    print(f"10,000 boxes                 {time.perf_counter() - began:8.2f} s to add")
    print(f"                             {(resident() - before) / 10_000:8.0f} bytes a body when added")
    world.step()
    print(f"                             {(resident() - before) / 10_000:8.0f} bytes a body with four contacts each")

    first_step(None)
    warm = statistics.median(first_step(None) for _ in range(5))
    print(f"import and first step, warm  {warm:8.2f} s")
    with tempfile.TemporaryDirectory() as cache:
        print(f"import and first step, cold  {first_step(cache):8.2f} s")


if __name__ == "__main__":
    main()
