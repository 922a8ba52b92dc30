"""What sweeps cost: ``python benchmarks/scaling.py [--write]`` (about a minute); nothing here is asserted.

Measures the rates from which docs/scaling.md computes what large sweeps take, prints the page's tables, and with
``--write`` puts them into the page. Ray's rate is measured where Ray is installed. On a busy machine wall times say
little, so whatever one process does alone is told as the time that a processor was at work for it.
"""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import queue
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stiction.scene import Scene, Simulation, load
from stiction.scene.overrides import apply_overrides
from stiction.sweep import Sweep, from_dict, make_backend, run_sweep, table
from stiction.sweep import load as load_sweep
from stiction.sweep.backends import Work
from stiction.sweep.backends.local import _Worker, cores
from stiction.sweep.batches import SECONDS
from stiction.sweep.journal import Folder, JournalWriter
from stiction.sweep.runner import Runner, run_batch

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "scaling.md"
CORES = 16
"""Cores of the machine that the page speaks of."""
MACHINES = (1, 10, 1000)
RUNS, STEPS = 10**6, 10**9
ROWS = 100_000
"""Rows of the table that is made to measure how long it takes."""
GRID = 21
"""The example is run on a grid of this many by this many points."""
COLD = "from stiction.sweep import load; from stiction.sweep.runner import Runner; s = load('slip-tip-hold'); " + (
    "Runner(s.job).run(s.points[0].values)"
)


@dataclass
class Rates:
    """What was measured, s unless a name says otherwise."""

    step: dict[str, tuple[int, float]] = field(default_factory=dict)
    run: dict[str, float] = field(default_factory=dict)
    per_second: dict[str, float] = field(default_factory=dict)
    core: float = 0.0
    journal: float = 0.0
    point: float = 0.0
    read: float = 0.0
    collect: float = 0.0
    row_memory: float = 0.0
    row_disk: float = 0.0
    journal_disk: float = 0.0
    start: float = 0.0
    batch: float = 0.0
    start_core: float = 0.0
    cold: float = 0.0
    hand_over: dict[str, float] = field(default_factory=dict)


def median_of(call: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.process_time) -> float:
    """Median time of a call, s: of the processor, or by another clock."""
    times = []
    for _ in range(repeats):
        began = clock()
        call()
        times.append(clock() - began)
    return statistics.median(times)


def say(text: str) -> None:
    """What is going on."""
    print(text, file=sys.stderr, flush=True)


def example(points: int = GRID) -> Sweep:
    """The built-in sweep on a finer grid."""
    data = load_sweep("slip-tip-hold").table.model_dump(mode="json", exclude_none=True)
    for parameter in data["parameters"]:
        parameter["linspace"][2] = points
    return from_dict(data, "slip-tip-hold")


def measure_steps(rates: Rates) -> None:
    """Time of a step of three scenes, many steps in one call."""
    say("steps")
    sliding = ["materials.pairs.crate-ramp.static=0.1", "materials.pairs.crate-ramp.dynamic=0.1"]
    crate = Scene(apply_overrides(example().scene, sliding))
    for name, scene, count in (
        ("one crate that slides", crate, 500),
        ("ramp", load("ramp"), 60),
        ("pyramid", load("pyramid"), 20),
    ):
        table_ = scene.table.model_copy(update={"duration": 1e6})

        def once(table_: Any = table_, count: int = count, name: str = name) -> float:
            simulation = Simulation(Scene(table_))
            simulation.advance(2)
            began = time.process_time()
            simulation.advance(count)
            spent = (time.process_time() - began) / count
            if not any(body.awake for body in simulation.world if body.mobility == "dynamic"):
                raise SystemExit(f"{name} must be awake while it is measured, and fell asleep.")
            return spent

        once()
        bodies = sum(body.mobility == "dynamic" for body in scene.build())
        rates.step[name] = bodies, statistics.median(once() for _ in range(7))


def measure_run(rates: Rates) -> None:
    """Where the time of one run goes, in one process."""
    say("one run")
    sweep = example()
    runner = Runner(sweep.job)
    point = sweep.points[len(sweep.points) // 3]
    runner.run(point.values)
    whole = median_of(lambda: runner.run(point.values), 60)
    build = median_of(lambda: Simulation(Scene.from_dict(sweep.job.scene)), 60)
    simulations = [Simulation(Scene.from_dict(sweep.job.scene)) for _ in range(60)]
    step = median_of(lambda: simulations.pop().advance(10**6), 60)
    rates.run = {"whole": whole, "build": build, "step": step, "look": max(0.0, whole - build - step)}
    with tempfile.TemporaryDirectory() as home:
        folder = Folder(home)
        folder.make()
        row = runner.run(point.values)
        with JournalWriter(folder, "0", "benchmark") as journal:
            rates.journal = median_of(lambda: (journal.started(point.run), journal.finished(point.run, row)), 2000)
        rates.journal_disk = journal.path.stat().st_size / 2000
    rates.point = median_of(lambda: list(sweep.points), 5) / len(sweep.points)


def measure_sweeps(rates: Rates) -> None:
    """Runs a second of whole sweeps, as the workers did them."""
    sweep = example()
    for name, workers in (("local", 1), ("local", cores())):
        say(f"sweep of {len(sweep.points)} runs, {name}, {workers} workers")
        before = children()
        with tempfile.TemporaryDirectory() as folder:
            outcome = run_sweep(sweep, folder, lambda name=name, workers=workers: make_backend(name, workers))
        rates.per_second[f"{name}, {workers}"] = outcome.rate
        # of the last one, all cores busy; what a worker takes to start is not the runs'
        rates.core = (children() - before - workers * rates.start_core) / len(sweep.points)


def measure_driver(rates: Rates) -> None:
    """What the driver does alone: handing over, reading journals, making the table."""
    say("handing over")
    sweep = example(3)
    with tempfile.TemporaryDirectory() as home:
        folder = Folder(home)
        folder.make()
        work = Work(sweep.job.to_json(), home, folder.begin_session())
        heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
        began, before = time.perf_counter(), children()
        worker = _Worker(work, heard)

        def there_and_back() -> None:
            worker.give([])
            heard.get()

        worker.give([sweep.points[0]])
        heard.get()
        rates.start = time.perf_counter() - began
        rates.batch = median_of(there_and_back, 200, time.perf_counter)
        began = time.process_time()
        for _ in range(500):
            there_and_back()
        rates.hand_over["local"] = (time.process_time() - began) / 500
        worker.let_go()
        worker.end(time.monotonic() + 10.0)
        rates.start_core = children() - before
        if importlib.util.find_spec("ray") is not None:
            rates.hand_over["ray"] = ray_tasks(work)
    say(f"table of {ROWS} rows")
    large = example(int(ROWS**0.5) + 1)
    row = Runner(large.job).run(large.points[0].values)
    with tempfile.TemporaryDirectory() as home:
        folder = Folder(home)
        folder.make()
        with JournalWriter(folder, "0", "benchmark") as journal:
            for number, point in zip(range(ROWS), large.points, strict=False):
                row["metrics"]["slip"] = number / 7.0
                row["metrics"]["largest_tilt_deg"] = number / 11.0
                row["state_hash"] = f"{hash(number / 3.0) % 2**127:032x}"
                journal.finished(point.run, row)
        before, began = resident(), time.process_time()
        rows = folder.read().rows
        rates.read = (time.process_time() - began) / ROWS
        began = time.process_time()
        path = table.write(large, table.collect(large, rows), Path(home) / "table.parquet")
        rates.collect = (time.process_time() - began) / ROWS
        rates.row_memory = (resident() - before) / ROWS
        rates.row_disk = path.stat().st_size / ROWS


def ray_tasks(work: Work) -> float:
    """Time of the driver for each of many empty batches in flight on a local Ray, s."""
    import ray

    from stiction.sweep.backends.ray import RayBackend

    backend = RayBackend(cores())
    task = ray.remote(run_batch).options(num_cpus=1, max_retries=0)
    job = ray.put(work.job)
    ray.get([task.remote(job, [], work.folder, work.session) for _ in range(50)])
    began = time.process_time()
    ray.get([task.remote(job, [], work.folder, work.session) for _ in range(500)])
    spent = (time.process_time() - began) / 500
    for _ in backend.run(work, lambda: None):
        pass
    return spent


def children() -> float:
    """Processor time of all children of this process that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def resident() -> float:
    """Most memory that this process has had, bytes."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure_cold() -> float:
    """Processor time of a process that makes the first run with an empty kernel cache, s."""
    say("compiling")
    before = children()
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        subprocess.run([sys.executable, "-c", COLD], env=environment, stdout=subprocess.DEVNULL, check=True)
    return children() - before


# --- the page ---------------------------------------------------------------------------------------------------------


def machine_lines(rates: Rates) -> Iterable[str]:
    """On what it was measured."""
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "")
    load_average = os.getloadavg()[0]
    busy = ", so the machine had other work, and its wall times are too long" if load_average > cores() + 1 else ""
    yield (
        f"Measured on {cores()} cores of {cpu or platform.processor()}, Python {platform.python_version()}. The load "
        f"was {load_average:.1f} at the end{busy}. Times marked with * are wall times, the others those of a processor."
    )


def rate_lines(rates: Rates) -> Iterable[str]:
    """The measured rates."""
    yield "| what | measured |"
    yield "| --- | --- |"
    for name, (bodies, seconds) in rates.step.items():
        yield f"| a step, `{name}` ({bodies} that move), many in one call | {time_text(seconds)} |"
    whole = rates.run["whole"]
    for key, what in (
        ("whole", "a run of the example: 90 steps, each looked at, four metrics"),
        ("build", "… of it, building scene and world"),
        ("step", "… of it, the steps themselves"),
        ("look", "… of it, recording frames and computing metrics"),
    ):
        share = "" if key == "whole" else f" ({rates.run[key] / whole:.0%})"
        yield f"| {what} | {time_text(rates.run[key])}{share} |"
    yield f"| … and its two lines in the journal | {time_text(rates.journal)}, {rates.journal_disk:.0f} B |"
    for name, rate in rates.per_second.items():
        kind, workers = name.split(", ")
        yield f"| the sweep, `{kind}`, {workers} worker{'s' if workers != '1' else ''} | {rate:.1f} runs/s* |"
    yield f"| … time of a core for one of these runs, all {cores()} busy | {time_text(rates.core)} |"
    yield f"| a worker until its first answer, kernels in the cache | {time_text(rates.start)}* |"
    yield f"| the first run of a machine, kernels not in the cache | {time_text(rates.cold)} |"
    for kind, seconds in rates.hand_over.items():
        yield f"| the driver: handing over a batch and hearing its end, `{kind}` | {time_text(seconds)} |"
    yield f"| a batch besides its runs: pipe, locks, journal on disk | {time_text(rates.batch)}* |"
    yield f"| the driver: a point with its id | {time_text(rates.point)} |"
    yield f"| the driver: reading a row from a journal | {time_text(rates.read)} |"
    on_disk = f"{rates.row_disk:.0f} B in the file"
    yield f"| the driver: putting a row into the table | {time_text(rates.collect)}, {on_disk} |"
    yield f"| the driver: memory a row while the table is made | {size_text(rates.row_memory)} |"


def seconds_of_run(rates: Rates) -> float:
    """Time of a core for a run, s, journal included."""
    return rates.core


def run_lines(rates: Rates) -> Iterable[str]:
    """10^6 runs on machines."""
    each = seconds_of_run(rates)
    yield f"| machines of {CORES} cores | start | {RUNS:,} runs | table | together | of it at work |"
    yield "| --- | --- | --- | --- | --- | --- |"
    batches = RUNS * each / SECONDS
    hand = max(rates.hand_over.values())
    end = RUNS * (rates.read + rates.collect)
    for machines in MACHINES:
        start = rates.cold + rates.start
        work = max(RUNS * each / (machines * CORES), batches * hand)
        whole = start + work + end
        share = RUNS * each / (machines * CORES) / whole
        yield (
            f"| {machines} | {time_text(start)} | {time_text(work)} | {time_text(end)} | **{time_text(whole)}** "
            f"| {share:.0%} |"
        )


def step_lines(rates: Rates) -> Iterable[str]:
    """10^9 steps on machines."""
    yield "| scene | core hours | " + " | ".join(f"{m} machine{'s' if m > 1 else ''}" for m in MACHINES) + " |"
    yield "| --- | --- |" + " --- |" * len(MACHINES)
    rows = {f"`{name}`, many steps in one call": seconds for name, (_, seconds) in rates.step.items()}
    rows["the example, each step looked at, as in a sweep"] = seconds_of_run(rates) / 90.0
    for name, seconds in rows.items():
        total = STEPS * seconds
        walls = " | ".join(time_text(total / (machines * CORES)) for machines in MACHINES)
        yield f"| {name} | {total / 3600.0:.3g} | {walls} |"


def limit_lines(rates: Rates) -> Iterable[str]:
    """What breaks first: each limit, and the size at which it is reached."""
    each = seconds_of_run(rates)
    yield "| limit | measured | reached at |"
    yield "| --- | --- | --- |"
    found = []
    for kind, seconds in rates.hand_over.items():
        workers = SECONDS / seconds
        found.append(
            (
                workers,
                f"one driver hands over batches of {SECONDS:g} s, `{kind}`",
                f"{1.0 / seconds:.0f} a second",
                f"{workers:,.0f} workers = {workers / CORES:,.0f} machines",
            )
        )
    end = rates.read + rates.collect
    alone = each / end
    found.append(
        (
            alone,
            "one process reads all journals and makes the table",
            f"{1.0 / end:,.0f} rows a second",
            f"{alone:,.0f} workers = {alone / CORES:,.0f} machines: then the end takes as long as the runs",
        )
    )
    start = rates.cold + rates.start
    idle = RUNS * each / start
    found.append(
        (
            idle,
            "every new machine compiles its kernels",
            time_text(start),
            f"{idle:,.0f} workers = {idle / CORES:,.0f} machines: then {RUNS:,} runs take as long as the start",
        )
    )
    for _, *cells in sorted(found):
        yield f"| {' | '.join(cells)} |"
    memory = 64e9 / rates.row_memory
    yield (
        f"| the table is made in memory | {size_text(rates.row_memory)} a row | {memory:,.0f} rows in 64 GB; "
        f"{RUNS:,} rows take {size_text(RUNS * rates.row_memory)} |"
    )
    yield (
        f"| journals on disk | {rates.journal_disk:.0f} B a run | {RUNS:,} runs take "
        f"{size_text(RUNS * rates.journal_disk)}, and {size_text(RUNS * rates.row_disk)} in the table |"
    )


def time_text(seconds: float) -> str:
    """Three digits and a unit."""
    for size, unit in ((1e-6, "µs"), (1e-3, "ms"), (1.0, "s"), (60.0, "min"), (3600.0, "h")):
        if seconds < 120.0 * size or (size < 1.0 and seconds < 1000.0 * size):
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 86400.0:.3g} days"


def size_text(size: float) -> str:
    """Three digits and a unit."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000.0:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"


def main() -> None:
    """Measure, print, write."""
    sys.path.insert(0, str(DOCS))
    from markers import replace  # it lies beside the pages

    rates = Rates()
    measure_driver(rates)
    measure_steps(rates)
    measure_run(rates)
    measure_sweeps(rates)
    rates.cold = measure_cold()
    sections = {
        "machine": machine_lines,
        "rates": rate_lines,
        "runs": run_lines,
        "steps": step_lines,
        "limits": limit_lines,
    }
    say(json.dumps(vars(rates)))
    for name, lines in sections.items():
        made = list(lines(rates))
        print(f"\n{name}\n" + "\n".join(made))
        if "--write" in sys.argv[1:]:
            replace(PAGE, name, made)


if __name__ == "__main__":
    main()
