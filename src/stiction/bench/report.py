"""What a benchmark found: a table, JSON, a plot of time against size, and the stages of a step."""

from __future__ import annotations

import math
import os
import platform
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.bench.engines import OWN, engine_class
from stiction.bench.measure import Plan, Row, Table
from stiction.bench.stability import Stability

if TYPE_CHECKING:
    from rich.table import Table as RichTable

COLUMNS = ("ms/step", "+- %", "x peer", "cpu/wall", "overlap mm", "sink mm", "drift mm", "out")
"""Columns with numbers; what they mean is in :data:`LEGEND`."""

LEGEND = (
    "ms/step: median over the runs of the mean wall time of a measured step; +- %: half of what lies between the "
    "fastest and the slowest run; x peer: over the fastest peer's; overlap: deepest of spheres and boxes, and in the "
    "ground; sink: mean below the place; drift: largest sideways; out: bodies out of their places, or lost."
)

NO_PROFILE = "this solver has no profile yet: World.profile is not there"


# --- table ------------------------------------------------------------------------------------------------------------


def fill(made: RichTable, table: Table) -> None:
    """Add the rows of a benchmark to a table whose columns are scene, bodies, engine, :data:`COLUMNS` and an end."""
    before = None
    for row in table:
        group = (row.scene, row.bodies)
        if before not in (None, group):
            made.add_section()
        first = ("", "") if before == group else (f"[bold]{row.scene}[/]", str(row.bodies))
        made.add_row(*first, row.engine, *cells(table, row))
        before = group


def cells(table: Table, row: Row) -> tuple[str, ...]:
    """The numbers of a row as text, and how it ended."""
    blank = ("",) * len(COLUMNS)
    if row.skipped is not None:
        return (*blank, "[dim]skipped[/]")
    if row.failed is not None:
        return (*blank, "[red]failed[/]")
    wall, ratio, (least, most) = row.median(), table.ratio(row), row.spread
    end = row.stability
    assert end is not None
    out = end.lost if end.out is None else end.out
    return (
        _number(wall),
        "" if len(row.good) < 2 else f"{50.0 * (most - least) / wall:.0f}",
        "" if math.isnan(ratio) else f"{ratio:.2f}",
        "" if math.isnan(row.median("cpu")) else f"{row.median('cpu') / wall:.2f}",
        _millimetres(_deepest(end)),
        _millimetres(end.sink),
        _millimetres(end.drift),
        str(out),
        _end(row),
    )


def remarks(table: Table) -> list[str]:
    """Why rows have no numbers, once for each reason."""
    found = []
    for row in table:
        if row.skipped is not None:
            found.append(f"{row.scene}: skipped, {row.skipped}")
        for failure in dict.fromkeys(outcome.failed for outcome in row.outcomes if outcome.failed is not None):
            found.append(f"{row.scene}: {row.engine} failed, {failure}")
    return list(dict.fromkeys(found))


def _end(row: Row) -> str:
    end, last = row.stability, row.good[-1]
    assert end is not None
    words = []
    if last.steps and end.stands is not None:
        words.append("[green]stands[/]" if end.stands else "[red]fell[/]")
    if not last.complete:
        done = f"{last.steps} steps" if last.steps else "while settling"
        words.append(f"[yellow]time limit: {done}[/]")
    failures = len(row.outcomes) - len(row.good)
    if failures:
        words.append(f"[red]{failures} failed[/]")
    return ", ".join(words)


def _deepest(end: Stability) -> float | None:
    """In each other or in the ground, m."""
    if end.overlap is None:
        return end.ground_depth or None
    return max(end.overlap, end.ground_depth)


def _number(value: float) -> str:
    """Three digits that matter."""
    if not math.isfinite(value):
        return ""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def _millimetres(value: float | None) -> str:
    if value is None:
        return ""
    return "inf" if math.isinf(value) else f"{1e3 * value:.1f}"


# --- JSON -------------------------------------------------------------------------------------------------------------


def as_dict(plan: Plan, table: Table, interrupted: bool = False) -> dict[str, Any]:
    """Everything: the machine, the settings, and each run of each row."""
    return {
        "machine": machine(),
        "settings": asdict(plan),
        "interrupted": interrupted,
        "rows": [_row_as_dict(table, row) for row in table],
    }


def machine() -> dict[str, Any]:
    """Where it was measured."""
    return {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cpu": _cpu(),
        "cores": os.cpu_count(),
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
    }


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")


def _row_as_dict(table: Table, row: Row) -> dict[str, Any]:
    end = row.stability
    return {
        "scene": row.scene,
        "bodies": row.bodies,
        "engine": row.engine,
        "version": row.outcomes[0].version if row.outcomes else None,
        "skipped": row.skipped,
        "failed": row.failed,
        "wall_ms_per_step": row.median(),
        "cpu_ms_per_step": row.median("cpu"),
        "settling_ms_per_step": row.median("settling"),
        "ratio_to_fastest_peer": table.ratio(row),
        "stability": None if end is None else end._asdict(),
        "runs": [outcome.as_dict() for outcome in row.outcomes],
    }


# --- plot -------------------------------------------------------------------------------------------------------------


def curves(table: Table, scene: str) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64], float]]:
    """Sizes, ms a step and the slope of their logarithms for each engine on a scene; NaN with fewer than two sizes."""
    found: dict[str, dict[int, float]] = {}
    for row in table:
        if row.scene == scene and row.settled:
            found.setdefault(row.engine, {})[row.bodies] = row.median()
    result = {}
    for engine, points in found.items():
        sizes = np.array(sorted(points), dtype=np.float64)
        times = np.array([points[int(n)] for n in sizes])
        slope = float(np.polyfit(np.log(sizes), np.log(times), 1)[0]) if len(sizes) > 1 else math.nan
        result[engine] = (sizes, times, slope)
    return result


def plot(table: Table, path: Path) -> None:
    """Draw time a step against the number of bodies, both logarithmic, one picture a scene."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row.scene for row in table))
    figure = Figure(figsize=(5.6 * max(1, len(names)), 4.6), layout="constrained")
    pictures = np.atleast_1d(figure.subplots(1, max(1, len(names)), squeeze=False)[0])
    for axes, name in zip(pictures, names, strict=False):
        for engine, (sizes, times, slope) in curves(table, name).items():
            label = engine if math.isnan(slope) else f"{engine}: $n^{{{slope:.2f}}}$"
            own = engine == OWN
            axes.loglog(sizes, times, "o-", lw=2.6 if own else 1.4, zorder=3 if own else 2, label=label)
        axes.set(title=name, xlabel="dynamic bodies", ylabel="ms a step")
        axes.grid(True, which="both", alpha=0.25)
        if axes.lines:
            axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


# --- stages -----------------------------------------------------------------------------------------------------------


def stages(table: Table) -> dict[tuple[str, int], dict[str, float] | None]:
    """ms a step of each stage for each scene that stiction ran; None where its world has no profile."""
    return {(row.scene, row.bodies): row.good[-1].stages for row in table if row.engine == OWN and row.good}


# --- lists ------------------------------------------------------------------------------------------------------------


def engine_state(name: str) -> str:
    """Version of an engine, or how to get it."""
    kind = engine_class(name)
    return kind.version() if kind.available() else f"not installed (pip install {kind.distribution})"
