"""Benchmarks: the same scenes in stiction and in other engines, with what became of them beside the time they took.

>>> from stiction.bench import Plan, Table, run_plan
>>> table = Table()
>>> run_plan(Plan(scenes=("pyramid",), engines=("stiction",), sizes=(6,), runs=1, steps=5, isolated=False), table)
>>> table[0].bodies
6
"""

from __future__ import annotations

from stiction.bench.measure import Plan, Row, Table, installed, run_plan
from stiction.bench.scene import BenchBody, BenchScene
from stiction.bench.scenes import SCENES, make
from stiction.bench.single import Outcome, Task

__all__ = [
    "SCENES",
    "BenchBody",
    "BenchScene",
    "Outcome",
    "Plan",
    "Row",
    "Table",
    "Task",
    "installed",
    "make",
    "run_plan",
]
