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
SCENES = ("pile", "heap", "drum")
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


def cost(name: str, rounds: int, folder: Path, **options: object) -> tuple[np.ndarray, np.ndarray, float]:
    """Seconds a step of each turn, without and with recording, and processor seconds a step with it beyond those."""
    plain, recorded = scene_of(name, False).world, scene_of(name, False).world
    for world in (plain, recorded):
        world.step(SETTLE)
    times: list[list[float]] = [[], []]
    cpu = [0.0, 0.0]
    with recorded.record(folder / "cost.h5", **options):  # type: ignore[arg-type]  # options of record()
        for turn in range(2 * rounds):
            which = (turn + turn // 2) % 2  # A B B A, so that a trend falls on both alike
            world = (plain, recorded)[which]
            began, busy = time.perf_counter(), time.process_time()
            for _ in range(TURN):
                world.step()
            times[which].append((time.perf_counter() - began) / TURN)
            cpu[which] += time.process_time() - busy
    a, b = (np.array(rows) for rows in times)
    return a, b, (cpu[1] - cpu[0]) / (rounds * TURN)


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
        print("| scene of 1,000 bodies | recorded | step without, ms | step with, ms | more | quartiles of the turns |")
        print("| --- | --- | --- | --- | --- | --- |")
        for words, options in (("default", {}), ("with contacts", {"contacts": True}), ("full", {"precision": "full"})):
            a, b, more = cost("pile", given.rounds, folder, **options)
            ratio = np.median(b) / np.median(a) - 1.0
            low, high = np.percentile(b / np.median(a) - 1.0, (25, 75))
            spread = np.percentile(a / np.median(a) - 1.0, (25, 75))
            print(
                f"| pile, awake | {words} | {1e3 * np.median(a):.3f} | {1e3 * np.median(b):.3f} | {100 * ratio:+.1f} % | "
                f"{100 * low:+.1f} to {100 * high:+.1f} % (without: {100 * spread[0]:+.1f} to {100 * spread[1]:+.1f} %); "
                f"processor {1e3 * more:.3f} ms |",
                flush=True,
            )
        print("\n| scene of 1,000 bodies | steps | MB | bytes a body and step |\n| --- | --- | --- | --- |")
        for scene in given.scenes.split(","):
            for sleeping in (True, False) if scene == "pile" else (True,):
                megabytes, _ = size(scene, given.steps, sleeping, folder)
                words = f"{scene}{'' if sleeping else ', never asleep'}"
                print(
                    f"| {words} | {given.steps:,} | {megabytes:.1f} | {1e6 * megabytes / given.steps / SIZE:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
