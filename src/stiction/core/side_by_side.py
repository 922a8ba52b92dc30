"""Kernels that are compiled at the same time, by this process and by children of it.

Numba compiles under one lock, most of it in Python: one process keeps one core busy. So what a world needs and the
cache does not hold is shared out among as many processes as there are cores. A child compiles its share into the
cache, and ends; then this process, which compiled its own meanwhile, loads what the children have made. Whatever a
child has not made, because it could not start, or failed, is compiled here: children save time, and decide nothing.

A child ends when its parent does, however that comes about: it reads from a pipe that its parent holds open.
"""

from __future__ import annotations

import importlib
import itertools
import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

from numba.core.event import Event, EventStatus, broadcast

from stiction.core import jit
from stiction.core.kernel_cache import KernelCache
from stiction.core.parts import Variant, signature

START = 3.0
"""What it costs to start a child, in the unit of the costs of tasks: as if it had a task more."""
MOST_PROCESSES = 3
"""More would wait for the longest task."""
PATIENCE = 600.0
"""s, for how long a child is waited for at most, once there is nothing else to do."""
COMPILED_ELSEWHERE = "stiction:compiled-elsewhere"
"""Kind of Numba's events that tell of a kernel compiled by a child: its name and the seconds that it took."""

_one_at_a_time = threading.Lock()


class Task(NamedTuple):
    """A variant of a kernel to be compiled, and how long that takes beside others."""

    kernel: Any
    variant: Variant
    cost: float

    def is_done(self) -> bool:
        """Whether it need not be compiled any more."""
        types, cache = signature(self.kernel, self.variant), self.kernel._cache
        if types in self.kernel.overloads:
            return True
        return isinstance(cache, KernelCache) and cache.holds(types, self.kernel.targetctx)

    def do(self) -> None:
        """Load the kernel from the cache, or compile it."""
        self.kernel.compile(signature(self.kernel, self.variant))

    def text(self) -> str:
        """The task for another process; its cost is of no use there."""
        function = self.kernel.py_func
        return json.dumps([function.__module__, function.__name__, *self.variant])

    @classmethod
    def from_text(cls, text: str) -> Task:
        """The task of a text, here."""
        module, name, double, team, on = json.loads(text)
        return cls(getattr(importlib.import_module(module), name), Variant(double, team, tuple(on)), 0.0)


def prepare(tasks: list[Task]) -> None:
    """Have all kernels ready: loaded from the cache, or compiled."""
    with _one_at_a_time:
        shares = share_out([task for task in tasks if not task.is_done()], usable_cores())
        children: list[subprocess.Popen[bytes]] = []
        try:
            children += [child for share in shares[1:] if (child := start_child(share)) is not None]
            for task in shares[0]:
                task.do()
            for child in children:
                hear(child)
        finally:
            for child in children:
                end(child)
        for task in tasks:
            task.do()


def share_out(tasks: list[Task], processes: int) -> list[list[Task]]:
    """The tasks of each process, this one's first, so that all are done as soon as can be, with as few children."""

    def cost(chosen: tuple[int, ...]) -> tuple[float, float]:
        busy = [START * (k > 0 and k in chosen) for k in range(processes)]
        for task, k in zip(tasks, chosen, strict=True):
            busy[k] += task.cost
        return max(busy), sum(busy)

    # a handful of tasks: all ways to share them out are soon tried
    best = min(itertools.product(range(processes), repeat=len(tasks)), key=cost)
    shares = [[task for task, k in zip(tasks, best, strict=True) if k == process] for process in range(processes)]
    return shares[:1] + [share for share in shares[1:] if share]


def usable_cores() -> int:
    """How many processes may compile at the same time; one where they could not hand over what they have made."""
    if jit.kernel_folder() is None:
        return 1
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, MOST_PROCESSES)


def start_child(tasks: list[Task]) -> subprocess.Popen[bytes] | None:
    """A process that compiles these tasks, or None where there is no Python to start one with."""
    # a program that Python is embedded or frozen in is no interpreter: to start it again would run the program again
    if getattr(sys, "frozen", False) or not Path(sys.executable or "").name.lower().startswith("python"):
        return None
    paths = [str(jit.CORE.parents[1]), *filter(None, sys.path)]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, str(jit.kernel_folder()), *(task.text() for task in tasks)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
    except OSError:
        return None


def hear(child: subprocess.Popen[bytes]) -> None:
    """Wait until a child is done, and tell what it has compiled."""
    try:
        child.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        return
    assert child.stdout is not None
    for line in child.stdout:
        broadcast(Event(COMPILED_ELSEWHERE, EventStatus.END, data=json.loads(line)))


def end(child: subprocess.Popen[bytes]) -> None:
    """Make sure that a child is gone."""
    child.kill()
    child.communicate()


def leave_with_parent() -> None:
    """End this process when its parent closes the pipe, or is no more."""
    # not sys.stdin.read(): its buffer would be locked when this process ends by itself
    while os.read(0, 1):
        pass
    os._exit(1)


def main(folder: str, *texts: str) -> int:
    """What a child does: compile into a folder, and say for each kernel how long that took."""
    threading.Thread(target=leave_with_parent, daemon=True).start()
    if str(jit.kernel_folder()) != folder:
        return 1
    for text in texts:
        began = time.perf_counter()
        task = Task.from_text(text)
        task.do()
        took = {"kernel": task.kernel.py_func.__name__, "module": task.kernel.py_func.__module__}
        print(json.dumps(took | {"seconds": time.perf_counter() - began}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
