"""Many small worlds: ``python benchmarks/batch.py [--worlds N] [--docs]`` (some minutes); nothing here is asserted.

Four boxes on the ground, each world a little different, at dt = 1/60 s: world-steps of ``stiction.Batch``, of a
Python loop over ``World.step()``, and of other engines, world by world from Python, each step a call; and of MuJoCo's
own ``rollout`` over threads. Engines take turns, so that other work on the machine meets all of them; medians are told,
and beside wall time that of the processors. What one process can measure is: each engine has N worlds in memory.
``--docs`` writes the tables into docs/batch.md.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import statistics
import time
from collections.abc import Callable

import numpy as np
from docs_table import write_between

import stiction as st
from stiction.bench.engines import engine_class
from stiction.bench.scene import BenchBody, BenchScene

PAGE = "batch.md"
DT = 1.0 / 60.0
STEPS = 10
"""Steps in a turn."""
TURNS = 7
PEERS = ("mujoco", "rapier3d", "robox3d")
SIZES = (256, 1024, 4096, 16384)
BOXES = 4
LOOPED = 100
"""Worlds of the loop over ``World.step()`` and of other engines, whose time is told for one world-step: Box3D has 128
in a process at most, and fewer worlds stay in the cache, which is to their advantage."""


def starts(world: int) -> list[tuple[float, float, float]]:
    """Where the boxes of a world begin, m: apart, and just above the ground."""
    draw = np.random.default_rng(world)
    return [(1.5 * k + draw.uniform(-0.2, 0.2), draw.uniform(-0.2, 0.2), 0.502) for k in range(BOXES)]


def bench_scene(world: int) -> BenchScene:
    """The scene that other engines are given."""
    ground = BenchBody(st.Box((40.0, 40.0, 1.0)), (0.0, 0.0, -0.5), density=None)
    boxes = [BenchBody(st.Box((1.0, 1.0, 1.0)), place, density=1000.0) for place in starts(world)]
    return BenchScene("four boxes", (ground, *boxes), 0.5)


def own_world() -> st.World:
    """The same in stiction."""
    world = st.World(dt=DT, sleeping=False)
    world.materials.set_pair("default", "default", static=0.5)
    world.add(st.Box((40.0, 40.0, 1.0)), static=True, position=(0, 0, -0.5))
    for place in starts(0):
        world.add(st.Box((1.0, 1.0, 1.0)), density=1000.0, position=place)
    return world


def batch_of(worlds: int, threads: int) -> st.Batch:
    """The same for many worlds."""
    batch = st.Batch(own_world(), worlds, threads=threads)
    for k in range(worlds):
        batch.positions[k, 1:] = starts(k)
    return batch


def loop_of_worlds(worlds: int) -> Callable[[], None]:
    """A turn of a Python loop over worlds."""
    own = []
    for k in range(worlds):
        own.append(own_world())
        own[-1].positions[1:] = starts(k)

    def turn() -> None:
        for _ in range(STEPS):
            for world in own:
                world.step()

    return turn


def loop_of(name: str, worlds: int) -> Callable[[], None]:
    """The same of another engine."""
    made = []
    for k in range(worlds):
        engine = engine_class(name)()
        engine.build(bench_scene(k), DT)
        made.append(engine)
    steps = [engine._step for engine in made]

    def turn() -> None:
        for _ in range(STEPS):
            for step in steps:
                step()

    return turn


def rollout_of(worlds: int, threads: int) -> Callable[[], None]:
    """MuJoCo's rollout over threads."""
    import mujoco
    from mujoco import rollout

    adapters = []
    for k in range(worlds):
        adapters.append(engine_class("mujoco")())
        adapters[-1].build(bench_scene(k), DT)
    model = adapters[0].model
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros((worlds, mujoco.mj_stateSize(model, kind)))
    for k, adapter in enumerate(adapters):
        mujoco.mj_getState(adapter.model, adapter.data, state[k], kind)
    datas = [mujoco.MjData(model) for _ in range(threads)]
    pool = rollout.Rollout(nthread=threads)

    def turn() -> None:
        states, _ = pool.rollout(model, datas, state, nstep=STEPS)
        state[:] = states[:, -1]

    return turn


def median_times(turns: dict[str, Callable[[], None]]) -> dict[str, tuple[float, float]]:
    """Median wall and processor time of each one's turns, s; they take turns, after one that is not counted."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in turns}
    for k in range(TURNS + 1):
        for name, turn in turns.items():
            wall, processor = time.perf_counter(), time.process_time()
            turn()
            if k:
                found[name].append((time.perf_counter() - wall, time.process_time() - processor))
    return {name: tuple(map(statistics.median, zip(*times, strict=True))) for name, times in found.items()}


def main() -> None:
    """Measure, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worlds", type=int, default=4096)
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--sizes", type=int, nargs="*", default=SIZES)
    given = parser.parse_args()
    threads = os.cpu_count() or 1

    turns: dict[str, Callable[[], None]] = {}
    worlds: dict[str, int] = {}
    for n in (1, threads):
        name = f"stiction.Batch, {given.worlds:,} worlds, {n} thread{'s' * (n > 1)}"
        batch = batch_of(given.worlds, n)
        batch.step(60)
        turns[name], worlds[name] = (lambda batch=batch: batch.step(STEPS)), given.worlds
    turns["stiction, a loop over World.step()"], worlds["stiction, a loop over World.step()"] = (
        loop_of_worlds(LOOPED),
        LOOPED,
    )
    for name in PEERS:
        if engine_class(name).available():
            row = f"{name} {engine_class(name).version()}, world by world"
            turns[row], worlds[row] = loop_of(name, LOOPED), LOOPED
        else:
            print(f"{name} is not installed: left out")
    if importlib.util.find_spec("mujoco"):
        row = f"mujoco.rollout, {threads} threads"
        turns[row], worlds[row] = rollout_of(min(given.worlds, 1024), threads), min(given.worlds, 1024)
    for name, turn in turns.items():
        if "Batch" not in name:
            for _ in range(60 // STEPS):
                turn()

    times = median_times(turns)
    each = {name: [1e6 * t / STEPS / worlds[name] for t in pair] for name, pair in times.items()}
    best = each[next(name for name in reversed(list(each)) if "Batch" in name)]
    lines = ["| | wall, µs a world-step | processors, µs | wall over that of the batch |", "| --- | --- | --- | --- |"]
    for name, (wall, processor) in each.items():
        lines.append(f"| {name} | {wall:.2f} | {processor:.2f} | {wall / best[0]:.2f} |")

    grown = {f"{n}": batch_of(n, threads) for n in given.sizes}
    for batch in grown.values():
        batch.step(60)
    # turns of equal length: a short one is mostly what a call and waking the threads cost
    steps = {n: max(STEPS, STEPS * given.worlds // int(n)) for n in grown}
    sizes = median_times({n: (lambda n=n, batch=batch: batch.step(steps[n])) for n, batch in grown.items()})
    flat = ["| worlds | wall, µs a world-step | processors, µs | memory a world |", "| --- | --- | --- | --- |"]
    for n, (wall, processor) in sizes.items():
        micro = 1e6 / steps[n] / int(n)
        memory = grown[n].nbytes / int(n)
        flat.append(f"| {int(n):,} | {wall * micro:.2f} | {processor * micro:.2f} | {memory / 1000:.1f} kB |")

    load = os.getloadavg()[0]
    machine = [
        f"Measured on {threads} cores of {platform.processor() or platform.machine()}, "
        f"Python {platform.python_version()}, medians of {TURNS} alternating turns of {STEPS} steps. "
        f"The load was {load:.1f} at the end; without other work on the machine it is {threads} at most."
    ]
    for name, rows in (("machine", machine), ("batch", lines), ("sizes", flat)):
        print("\n".join(rows), "\n")
        if given.docs:
            write_between(PAGE, name, "\n" + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
