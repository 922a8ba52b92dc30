"""Kernels that are compiled by several processes at once: who does what, and what happens when one of them fails."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core import event

import stiction as st
from stiction.core import jit, side_by_side, soft_entry, soft_kernels, soft_parts
from stiction.core.parts import Variant, signature
from stiction.core.side_by_side import COMPILED_ELSEWHERE, START, Task, share_out

pytestmark = pytest.mark.skipif(jit.config.DISABLE_JIT, reason="nothing is compiled")

TEAM = Variant(double=False, team=True)
LONG = Task(soft_parts.pairs, TEAM, 100.0)
SHORT = Task(soft_entry.dismiss, TEAM, 100.0)


def costs(shares: list[list[Task]]) -> list[list[float]]:
    """What each process has to do."""
    return [sorted(task.cost for task in share) for share in shares]


def tasks_of(*given: float) -> list[Task]:
    """Tasks that cost so much."""
    return [Task(soft_entry.dismiss, TEAM, cost) for cost in given]


# --- who does what ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "processes", "shares"),
    [
        ((), 2, [[]]),
        ((8.0,), 2, [[8.0]]),
        ((9.0, 8.0), 2, [[9.0], [8.0]]),
        ((9.0, 8.0), 1, [[8.0, 9.0]]),
        ((START, 1.0), 2, [[1.0, START]]),  # a child would be ready no sooner
        ((16.0, 14.0, 11.0, 5.0), 2, [[11.0, 14.0], [5.0, 16.0]]),
        ((17.0, 14.0, 11.0, 4.0), 3, [[17.0], [4.0, 11.0], [14.0]]),
    ],
)
def test_all_are_done_as_soon_as_can_be(given: tuple[float, ...], processes: int, shares: list[list[float]]) -> None:
    mine, *others = costs(share_out(tasks_of(*given), processes))
    assert [mine, *sorted(others)] == [shares[0], *sorted(shares[1:])]


def test_nobody_can_hand_over_kernels_without_a_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 1 <= side_by_side.usable_cores() <= side_by_side.MOST_PROCESSES
    monkeypatch.setattr(jit, "kernel_folder", lambda: None)
    assert side_by_side.usable_cores() == 1


def test_a_task_is_the_same_in_another_process() -> None:
    task = Task(soft_parts.find, Variant(double=True, team=False, on=("hulls",)), 3.0)
    again = Task.from_text(task.text())
    assert again[:2] == task[:2]
    assert signature(*again[:2]) == signature(*task[:2])


def test_a_step_is_made_of_what_its_world_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[list[str]] = []
    monkeypatch.setattr(
        soft_kernels, "prepare", lambda tasks: told.append(sorted(t.kernel.py_func.__name__ for t in tasks))
    )
    alone = Variant(double=False, team=False)
    soft_kernels.prepare_steps(alone)
    soft_kernels.prepare_steps(alone._replace(on=("bounces",), team=True))
    soft_kernels.prepare_steps(alone, alone._replace(on=("boxes_meet",)), alone._replace(on=("boxes_meet", "rolls")))
    assert told == [
        ["find", "finish", "pairs", "soft_step", "solve"],
        ["assist", "dismiss", "find", "finish", "impacts", "pairs", "soft_step", "solve"],
        ["find", "find", "finish", "pairs", "soft_step", "solve", "solve"],
    ]


def test_what_python_hands_over_is_what_was_prepared() -> None:
    """With other types a kernel would be compiled a second time, by this process alone."""
    worlds = [st.World(threads=threads) for threads in (1, 2)]
    for world in worlds:
        world.add(st.Plane(), static=True)
        world.add(st.Box((1, 1, 1)), position=(0, 0, 0.6))
        world.add(st.Box((1, 1, 1)), position=(0, 0, 1.7))
        world.step()
    st.Batch(worlds[0], 3).step()
    every = [Variant(double, team) for double in (False, True) for team in (False, True)]
    for kernel in (soft_entry.soft_step, soft_entry.assist, soft_entry.dismiss):
        assert kernel.overloads
        assert set(kernel.overloads) <= {signature(kernel, variant) for variant in every}


# --- children ---------------------------------------------------------------------------------------------------------

PROGRAM = """
import json, sys
from numba.core import event
from stiction.core import jit, side_by_side, soft_entry
from stiction.core.parts import Variant
from stiction.core.side_by_side import COMPILED_ELSEWHERE, Task, prepare

class Elsewhere(event.Listener):
    def on_start(self, event): pass
    def on_end(self, event): told.append(event.data["kernel"])

told, mode = [], sys.argv[1]
event.register(COMPILED_ELSEWHERE, Elsewhere())
side_by_side.usable_cores = lambda: 1 if mode == "one core" else 2
if mode == "cannot start":
    sys.executable = "/nowhere/python3"
if mode == "other sources":
    # the child is told of another folder than the one that it finds
    start = side_by_side.start_child
    def start_child(tasks):
        folder = jit.kernel_folder
        jit.kernel_folder = lambda: folder().with_name("other")
        try:
            return start(tasks)
        finally:
            jit.kernel_folder = folder
    side_by_side.start_child = start_child
kernels = soft_entry.assist, soft_entry.dismiss
prepare([Task(kernel, Variant(False, True), 100.0) for kernel in kernels])
print(json.dumps({
    "told": told,
    "ready": [len(kernel.overloads) for kernel in kernels],
    "compiled here": sum(sum(kernel.stats.cache_misses.values()) for kernel in kernels),
    "loaded": sum(sum(kernel.stats.cache_hits.values()) for kernel in kernels),
}))
"""
"""Have two small kernels ready, in a cache that is empty."""


def run(cache: Path, mode: str) -> Any:
    """What PROGRAM tells."""
    source = str(Path(jit.CORE).parents[1])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": source}
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM, mode], env=environment, cwd=cache, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def test_a_child_compiles_one_and_this_process_the_other(tmp_path: Path) -> None:
    first = run(tmp_path, "two cores")
    assert first["ready"] == [1, 1]
    assert first["compiled here"] == first["loaded"] == len(first["told"]) == 1
    # then both lie in the cache, and nobody compiles
    assert run(tmp_path, "two cores") == {"told": [], "ready": [1, 1], "compiled here": 0, "loaded": 2}


@pytest.mark.parametrize("mode", ["one core", "cannot start", "other sources"])
def test_without_a_child_this_process_compiles_all(tmp_path: Path, mode: str) -> None:
    assert run(tmp_path, mode) == {"told": [], "ready": [1, 1], "compiled here": 2, "loaded": 0}


@pytest.mark.parametrize(("name", "value"), [("frozen", True), ("executable", "/opt/game/game"), ("executable", "")])
def test_a_program_that_is_no_interpreter_is_not_started_again(
    monkeypatch: pytest.MonkeyPatch, name: str, value: Any
) -> None:
    monkeypatch.setattr(sys, name, value, raising=False)
    assert side_by_side.start_child([SHORT]) is None


def test_a_child_whose_parent_is_gone_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path / "stiction" / jit.cache_key())
    child = side_by_side.start_child([LONG])
    assert child is not None
    assert child.stdin is not None
    child.stdin.close()  # as the system does when the parent ends
    child.stdin = None
    assert child.wait(60) == 1
    side_by_side.end(child)
    assert not list(tmp_path.rglob("*.nbc"))


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_a_child_is_not_left_behind(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: type[BaseException]
) -> None:
    children: list[Any] = []
    start = side_by_side.start_child

    def note(tasks: list[Task]) -> Any:
        children.append(start(tasks))
        return children[0]

    def fail(task: Task) -> None:
        assert children[0].poll() is None  # it is at work
        raise error

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(jit, "kernel_folder", lambda: tmp_path / "stiction" / jit.cache_key())
    monkeypatch.setattr(side_by_side, "start_child", note)
    monkeypatch.setattr(side_by_side, "usable_cores", lambda: 2)
    monkeypatch.setattr(Task, "is_done", lambda task: False)
    monkeypatch.setattr(Task, "do", fail)
    with pytest.raises(error):
        side_by_side.prepare([LONG, SHORT])
    assert children[0].poll() is not None
    assert not side_by_side._one_at_a_time.locked()


def test_a_child_that_hangs_is_not_waited_for_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    hangs = subprocess.Popen(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    monkeypatch.setattr(side_by_side, "PATIENCE", 0.01)
    side_by_side.hear(hangs)
    assert hangs.poll() is None
    side_by_side.end(hangs)
    assert hangs.poll() is not None


def test_what_a_child_says_is_heard() -> None:
    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            """Never: it is told when all is over."""

        def on_end(self, event: Any) -> None:
            told.append(event.data)

    told: list[Any] = []
    said = {"kernel": "find", "module": "soft_parts", "seconds": 2.5}
    child = subprocess.Popen(
        [sys.executable, "-c", f"print('{json.dumps(said)}')"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with event.install_listener(COMPILED_ELSEWHERE, Listener()):
        side_by_side.hear(child)
    side_by_side.end(child)
    assert told == [said]
