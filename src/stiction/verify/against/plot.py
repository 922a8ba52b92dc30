"""A comparison as a picture: how far each engine is from each formula, and on which side."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.verify.against.columns import COLUMNS, OWN
from stiction.verify.against.comparison import Comparison
from stiction.verify.against.report import cell
from stiction.verify.against.trial import Score

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STOPS = (
    (0.0, "#0b6e75"),
    (0.3, "#58b0a7"),
    (0.495, "#e3f1ec"),
    (0.505, "#fdebd9"),
    (0.72, "#ec8a4f"),
    (1.0, "#a3200d"),
)
"""Colours from 10^-4 of the tolerance to 10^4 times it; they change sides where a trial is passed."""
INK, PALE, GRID = "#22303a", "#eef0f1", "#d5dadd"
INKS = dict(zip(COLUMNS, ("#0b6e75", "#7a3fb0", "#b487dd", "#d4622a", "#e8a33d", "#3a6fc4", "#8a8f94"), strict=True))
"""Of the engines."""


def colour(severity: float) -> str:
    """Of a cell: hexadecimal, from log10 of error over tolerance."""
    if math.isnan(severity):
        return PALE
    x = min(1.0, max(0.0, 0.5 + severity / 8.0))
    for (a, low), (b, high) in pairwise(STOPS):
        if x <= b:
            share = (x - a) / (b - a)
            mixed = [
                round((1.0 - share) * int(low[k : k + 2], 16) + share * int(high[k : k + 2], 16)) for k in (1, 3, 5)
            ]
            return "#{:02x}{:02x}{:02x}".format(*mixed)
    return STOPS[-1][1]


def ink_on(background: str) -> str:
    """Dark or white, whichever can be read on a colour."""
    r, g, b = (int(background[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return INK if 0.299 * r + 0.587 * g + 0.114 * b > 0.55 else "#ffffff"


def figure(comparison: Comparison) -> Figure:
    """Left a map of errors, right what was measured about what was expected; one row a trial."""
    from matplotlib.figure import Figure

    rows = len(comparison.trials)
    made = Figure(figsize=(16.5, 1.9 + 0.34 * rows), layout="constrained", facecolor="white")
    left, right = made.subplots(1, 2, sharey=True, width_ratios=(1.25, 1.0))
    _heat(left, comparison)
    _deviations(right, comparison)
    made.suptitle("Friction, engine by engine", x=0.008, ha="left", fontsize=17, fontweight="bold", color=INK)
    return made


def deviations(comparison: Comparison) -> Figure:
    """What was measured about what was expected alone, for a page that has the errors as a table."""
    from matplotlib.figure import Figure

    rows = len(comparison.trials)
    made = Figure(figsize=(11.8, 1.4 + 0.30 * rows), layout="constrained", facecolor="white")
    axes = made.subplots()
    axes.set_ylim(rows - 0.4, -0.6)
    axes.set_yticks(range(rows), [trial.name for trial in comparison.trials], fontsize=10, color=INK)
    _deviations(axes, comparison)
    return made


def save(comparison: Comparison, path: Path) -> None:
    """Write the picture; the ending of the name says the format."""
    figure(comparison).savefig(path, dpi=150)


def _heat(axes: Axes, comparison: Comparison) -> None:
    from matplotlib.patches import FancyBboxPatch

    engines, trials = comparison.engines, comparison.trials
    for i, trial in enumerate(trials):
        for j, engine in enumerate(engines):
            score = comparison.score(trial.name, engine)
            fill = colour(score.severity)
            axes.add_patch(
                FancyBboxPatch(
                    (j - 0.47, i - 0.43), 0.94, 0.86, boxstyle="round,pad=0,rounding_size=0.08", fc=fill, ec="none"
                )
            )
            weight = "bold" if score.passed else "normal"
            ink = "#9aa3a9" if score.passed is None else ink_on(fill)
            axes.text(j, i, cell(trial, score), ha="center", va="center", fontsize=8.6, color=ink, fontweight=weight)
    labels = []
    for engine in engines:
        passed, asked = comparison.passed(engine)
        labels.append(f"{engine}\n{passed} of {asked}")
    axes.set(xlim=(-0.55, len(engines) - 0.45), ylim=(len(trials) - 0.4, -0.6))
    axes.set_xticks(range(len(engines)), labels, fontsize=9.5, color=INK)
    axes.set_yticks(range(len(trials)), [trial.name for trial in trials], fontsize=10, color=INK)
    axes.xaxis.tick_top()
    axes.get_xticklabels()[engines.index(OWN)].set_fontweight("bold")
    _bare(axes)
    axes.set_xlabel(
        "error of the worst variant; green and bold is within the tolerance, – cannot be expressed",
        fontsize=9,
        color=INK,
    )


def _deviations(axes: Axes, comparison: Comparison) -> None:
    """What was measured less what was expected, over the tolerance: a dot for the median, a bar from end to end."""
    engines = comparison.engines
    axes.axvspan(-1.0, 1.0, color="#e3f1ec", zorder=0)
    axes.axvline(0.0, color=INK, lw=1.0, zorder=1)
    step = 0.78 / max(1, len(engines))
    for i, trial in enumerate(comparison.trials):
        if i % 2:
            axes.axhspan(i - 0.5, i + 0.5, color="#000000", alpha=0.025, lw=0, zorder=0)
        for j, engine in enumerate(engines):
            score = comparison.score(trial.name, engine)
            values = _in_tolerances(score, trial.relative)
            if not len(values):
                continue
            y = i + step * (j - 0.5 * (len(engines) - 1))
            own: dict[str, Any] = {"color": INKS.get(engine, INK), "zorder": 5 if engine == OWN else 3}
            axes.plot([values.min(), values.max()], [y, y], lw=2.2 if engine == OWN else 1.5, **own)
            middle = float(values[np.argsort(values)[len(values) // 2]])
            axes.plot([middle], [y], "o", ms=5.0 if engine == OWN else 3.4, **own)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.9)
    axes.set_xlim(-1.1e4, 1.1e4)
    ticks = (-1e4, -1e2, -1e1, -1, 0, 1, 1e1, 1e2, 1e4)
    axes.set_xticks(ticks, ["-10⁴", "-100", "-10", "-1", "0", "1", "10", "100", "10⁴"], fontsize=9, color=INK)
    axes.minorticks_off()
    axes.xaxis.tick_top()
    axes.grid(True, axis="x", color=GRID, lw=0.6)
    _bare(axes)
    axes.set_xlabel(
        "(measured - expected) / tolerance; bars: all variants, dots: their median; cut at 10⁴",
        fontsize=9,
        color=INK,
    )
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=INKS.get(engine, INK), marker="o", lw=2, ms=5, label=engine) for engine in engines]
    axes.figure.legend(  # below the axis' own text, however few rows there are
        handles=handles, loc="outside lower right", ncols=len(engines), frameon=False, fontsize=9, handlelength=1.4,
        columnspacing=1.2, labelcolor=INK,
    )  # fmt: skip


def _in_tolerances(score: Score, relative: bool) -> Any:
    """Deviations of the variants in units of the tolerance; what never came about is left out."""
    values = np.array(score.values or [], dtype=np.float64)
    values = values[np.isfinite(values)]
    scale = score.tolerance * (abs(score.expected) if relative else 1.0)
    return np.clip((values - score.expected) / scale, -1e4, 1e4)


def _bare(axes: Axes) -> None:
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
