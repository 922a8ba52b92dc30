"""What recordings cost: ``python benchmarks/recordings.py [--steps N] [--rounds N]``, the tables of docs/recordings.md.

Time: two equal worlds in one process, one recorded and one not, take turns of some steps each, so that whatever else
the machine does falls on both; medians over the turns, and quartiles. Size: bytes of the file after so many steps.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

import stiction as st
from stiction.bench.engines.with_stiction import Adapter
from stiction.bench.scenes import make

TURN = 40
"""Steps of a turn."""
SETTLE = 120
SCENES = ("pile", "spheres", "drum")
SIZE = 1000
DT = 1.0 / 60.0


def scene_of(name: str, sleeping: bool) -> Adapter:
    """A bench scene of 1,000 bodies; one whose bodies sleep where ``sleeping``, as a user's world does."""
    adapter = Adapter()
    adapter.build(make(name, SIZE, 0), DT)
    world: st.World = adapter.world
    world._sleeping = sleeping
    world._settings = world._make_settings()
    return adapter


def cost(name: str, rounds: int, folder: Path, **options: object) -> dict[str, np.ndarray]:
    """Of each turn, without and with recording, rows of ms a step: by the clock; of the processor in the simulation's
    own thread; of the processor in all threads."""
    plain, recorded = scene_of(name, False).world, scene_of(name, False).world
    for world in (plain, recorded):
        world.step(SETTLE)
    clocks = (time.perf_counter, time.thread_time, time.process_time)
    rows: list[list[list[float]]] = [[], []]
    with recorded.record(folder / "cost.h5", **options):  # type: ignore[arg-type]  # options of record()
        for turn in range(2 * rounds):
            which = (turn + turn // 2) % 2  # A B B A, so that a trend falls on both alike
            world = (plain, recorded)[which]
            began = [clock() for clock in clocks]
            for _ in range(TURN):
                world.step()
            rows[which].append([1e3 * (clock() - start) / TURN for clock, start in zip(clocks, began, strict=True)])
    return {"without": np.array(rows[0]), "with": np.array(rows[1])}


def size(name: str, steps: int, sleeping: bool, folder: Path, **options: object) -> tuple[float, float]:
    """Megabytes of the file, and wall seconds it took."""
    scene = scene_of(name, sleeping)
    path = folder / "size.h5"
    began = time.perf_counter()
    with scene.world.record(path, **options):  # type: ignore[arg-type]  # options of record()
        for _ in range(steps):
            scene.before_step()
            scene.step()
    return os.path.getsize(path) / 1e6, time.perf_counter() - began


def spread(values: np.ndarray) -> str:
    """Median, and quartiles."""
    low, middle, high = np.percentile(values, (25, 50, 75))
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


def main() -> None:
    """Print both tables as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--scenes", default=",".join(SCENES))
    given = parser.parse_args()
    warnings.simplefilter("ignore", st.IterationLimitWarning)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}\n")
        print("| recorded | clock | without, ms | with, ms | more |\n| --- | --- | --- | --- | --- |")
        for words, options in (("default", {}), ("with contacts", {"contacts": True}), ("full", {"precision": "full"})):
            found = cost("pile", given.rounds, folder, **options)
            for k, clock in enumerate(("wall", "simulation thread", "all threads")):
                a, b = found["without"][:, k], found["with"][:, k]
                more = 100.0 * (np.median(b) / np.median(a) - 1.0)
                print(f"| {words} | {clock} | {spread(a)} | {spread(b)} | {more:+.1f} % |", flush=True)
        print("\n| scene of 1,000 bodies | steps | MB | bytes a body and step |\n| --- | --- | --- | --- |")
        for scene in filter(None, given.scenes.split(",")):
            for sleeping in (True, False) if scene == "pile" else (True,):
                megabytes, _ = size(scene, given.steps, sleeping, folder)
                words = f"{scene}{'' if sleeping else ', never asleep'}"
                print(
                    f"| {words} | {given.steps:,} | {megabytes:.1f} | {1e6 * megabytes / given.steps / SIZE:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
