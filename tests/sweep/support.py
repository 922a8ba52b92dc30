"""Small sweeps for tests, and what their journals say."""

from __future__ import annotations

import json
import os
from collections import Counter
from pathlib import Path
from typing import Any

CRATE: dict[str, Any] = {
    "duration": 0.5,
    "materials": {"base": "empty", "pairs": [{"a": "crate", "b": "floor", "static": 0.4, "dynamic": 0.4}]},
    "bodies": [
        {"name": "floor", "shape": {"type": "plane"}, "static": True, "material": "floor"},
        {
            "name": "crate",
            "shape": {"type": "box", "size": [1.0, 1.0, 0.5]},
            "mass": 10.0,
            "material": "crate",
            "position": [0.0, 0.0, 0.25],
        },
    ],
}
"""A crate on a floor."""


def spec(**changes: Any) -> dict[str, Any]:
    """A sweep of the crate's speed, with some keys changed; those that are None are left out."""
    data: dict[str, Any] = {
        "title": "A crate on a floor",
        "scene": CRATE,
        "parameters": [{"key": "bodies.crate.velocity[0]", "name": "v", "linspace": [0.5, 1.5, 5]}],
        "metrics": [{"name": "way", "value": "slip_distance('crate')"}],
    }
    data.update(changes)
    return {key: value for key, value in data.items() if value is not None}


SLOW = """
title = "Runs that take a while"
duration = 10

[scene]
duration = 1
bodies = [{ name = "stone", shape = { type = "sphere", radius = 0.5 } }]

[[parameters]]
key = "bodies.stone.velocity[0]"
name = "v"
linspace = [1, 5, 24]

[[metrics]]
name = "way"
value = "position('stone')[-1, 0]"
"""
"""Stones that fly: 600 steps a run, each of them looked at."""


def entries(folder: Path) -> list[dict[str, Any]]:
    """All whole lines of all journals of a sweep's folder."""
    found = []
    for journal in (folder / "runs").glob("*.jsonl"):
        for line in journal.read_text(encoding="utf-8").splitlines():
            try:
                found.append(json.loads(line))
            except ValueError:
                continue
    return found


def finished(folder: Path) -> Counter[str]:
    """How often each run is in the journals with a row."""
    return Counter(entry["run"] for entry in entries(folder) if "row" in entry)


def worker_pids(folder: Path) -> Counter[int]:
    """How many runs each process has finished."""
    rows = (entry["row"] for entry in entries(folder) if "row" in entry)
    return Counter(int(row["worker"].rpartition(":")[2]) for row in rows)


def busiest_to_come(folder: Path) -> int | None:
    """Of two workers that have finished runs, the one with fewer: it is in the middle of its batch. None before."""
    pids = worker_pids(folder)
    pids.pop(os.getpid(), None)
    return min(pids, key=pids.__getitem__) if len(pids) == 2 else None
