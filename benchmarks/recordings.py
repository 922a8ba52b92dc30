"""What recordings cost: ``python benchmarks/recordings.py [--docs]``, the tables of docs/recordings.md.

Time: a world takes turns of some steps with and without a recording, so that whatever else the machine does falls on
both; processor time, for the clock tells more of the other programs than of this one; medians over the turns, and
quartiles. Size: bytes of the file after so many steps.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from docs_table import write_between

import stiction as st
from stiction.bench.engines.with_stiction import Adapter
from stiction.bench.scenes import make

TURN = 200
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
    """Of each turn, without and with recording, rows of ms of processor time a step: in the simulation's own thread,
    and in all threads, what is left to write included."""
    world = scene_of(name, False).world
    world.step(SETTLE)
    rows: dict[str, list[tuple[float, float]]] = {"without": [], "with": []}
    for turn in range(2 * rounds):
        recorded = (turn + turn // 2) % 2  # A B B A, so that a trend falls on both alike
        # the same world in both: two equal ones differ by two percent, for their memory lies elsewhere
        writer = world.record(folder / "cost.h5", **options) if recorded else None  # type: ignore[arg-type]  # of record()
        for _ in range(TURN // 5):
            world.step()
        if writer is not None:
            writer.flush()
        own, all_of_them = time.thread_time(), time.process_time()
        for _ in range(TURN):
            world.step()
        own = time.thread_time() - own
        if writer is not None:
            writer.flush()
        all_of_them = time.process_time() - all_of_them
        rows["with" if recorded else "without"].append((1e3 * own / TURN, 1e3 * all_of_them / TURN))
        if writer is not None:
            writer.close()
    return {key: np.array(found) for key, found in rows.items()}


def more(without: np.ndarray, recorded: np.ndarray) -> str:
    """Percent by which turns with recording take longer than the ones beside them: median, and quartiles."""
    low, middle, high = 100.0 * (np.percentile(recorded / without, (25, 50, 75)) - 1.0)
    return f"{middle:+.1f} % ({low:+.1f} to {high:+.1f})"


def size(name: str, steps: int, sleeping: bool, folder: Path) -> float:
    """Megabytes of the file."""
    scene = scene_of(name, sleeping)
    path = folder / "size.h5"
    with scene.world.record(path):
        for _ in range(steps):
            scene.before_step()
            scene.step()
    return os.path.getsize(path) / 1e6


def spread(values: np.ndarray) -> str:
    """Median, and quartiles."""
    low, middle, high = np.percentile(values, (25, 50, 75))
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


def cost_table(rounds: int, folder: Path) -> Iterator[str]:
    """The table of time, line by line."""
    yield "| recorded | processor time of | without, ms | with, ms | more |"
    yield "| --- | --- | --- | --- | --- |"
    for words, options in (("default", {}), ("with contacts", {"contacts": True}), ("full", {"precision": "full"})):
        found = cost("pile", rounds, folder, **options)
        for k, clock in enumerate(("simulation thread", "all threads")):
            a, b = found["without"][:, k], found["with"][:, k]
            yield f"| {words} | {clock} | {spread(a)} | {spread(b)} | {more(a, b)} |"
    yield ""
    yield f"{machine()}."


def size_table(scenes: list[str], steps: int, folder: Path) -> Iterator[str]:
    """The table of sizes, line by line."""
    yield "| scene of 1,000 bodies | steps | MB | bytes a body and step |"
    yield "| --- | --- | --- | --- |"
    for scene in scenes:
        for sleeping in (True, False) if scene == "pile" else (True,):
            megabytes = size(scene, steps, sleeping, folder)
            words = f"{scene}{'' if sleeping else ', never asleep'}"
            yield f"| {words} | {steps:,} | {megabytes:.1f} | {1e6 * megabytes / steps / SIZE:.2f} |"


def machine() -> str:
    """Where it was measured."""
    return f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}"


def shown(lines: Iterator[str]) -> list[str]:
    """Prints lines as they come."""
    kept = []
    for line in lines:
        print(line, flush=True)
        kept.append(line)
    return kept


def main() -> None:
    """Print both tables as Markdown, and put them into the page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--scenes", default=",".join(SCENES), help="whose sizes are measured; none if empty")
    parser.add_argument("--docs", action="store_true", help="write the tables into docs/recordings.md")
    given = parser.parse_args()
    warnings.simplefilter("ignore", st.IterationLimitWarning)
    scenes = [scene for scene in given.scenes.split(",") if scene]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tables = {}
        if given.rounds:
            tables["cost"] = shown(cost_table(given.rounds, folder))
        if scenes:
            tables["size"] = shown(size_table(scenes, given.steps, folder))
    for key, lines in tables.items():
        if given.docs:
            write_between("recordings.md", key, "\n".join(lines))


if __name__ == "__main__":
    main()
