"""The map of a sweep: what each run did, over two parameters, on the ground of what the closed form says.

Points are runs, coloured by outcome; the ground and the dark line between its regions are the closed form, where the
sweep gives one. A run that did something else than the closed form says has a ring around it.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction import outputs
from stiction.errors import InvalidInputError
from stiction.sweep.expressions import Expression
from stiction.sweep.spec import ClassTable, MapTable, ParameterTable
from stiction.sweep.table import Columns
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiction.sweep.load import Sweep

Array = NDArray[np.float64]
Classes = NDArray[np.int64]

COLORS = ("#6a3d9a", "#e8590c", "#008f68", "#0072b2", "#b8860b", "#c2185b")
"""Of the classes, in order: those of rolling, sliding and sticking first."""
FAILED, NO_CLASS = -2, -1
"""What stands for a class where a run failed, and where no class holds."""
FINE = 1001
"""Points along each axis at which the closed form is evaluated."""
IN_A_ROW = 5
"""Entries of the legend in one row at most."""
SIZE = (9.0, 6.2)
DPI = 150


@dataclass(frozen=True)
class Verdict:
    """How a map agrees with the closed form.

    Attributes:
        runs: with an outcome. agree: those that did what the closed form says.
        beside: of the others, those that lie at its boundary: for a neighbour on the map it says something else.
    """

    runs: int
    agree: int
    beside: int


def classify(sweep: Sweep, columns: Columns) -> Classes:
    """(runs,) class of each row: its number, ``NO_CLASS`` or ``FAILED``.

    Args:
        sweep: a sweep with a map.
        columns: its table.

    Raises:
        InvalidInputError: the sweep has no map, or a condition cannot be computed.
    """
    chart = _map_of(sweep)
    names = [*sweep.points.names, *sweep.job.metrics]
    fine = np.array([error is None for error in columns["error"]], np.bool_)
    values = {name: np.array([v for v, ok in zip(columns[name], fine, strict=True) if ok]) for name in names}
    known = np.full(int(fine.sum()), NO_CLASS, np.int64)
    for number in reversed(range(len(chart.classes))):
        condition = Expression(chart.classes[number].when, f"map.classes[{number}].when")
        known[np.broadcast_to(np.asarray(condition.evaluate(values), np.bool_), known.shape)] = number
    found = np.full(len(fine), FAILED, np.int64)
    found[fine] = known
    return found


def expect(sweep: Sweep, x: Array, y: Array) -> Classes | None:
    """Class by the closed form at each of the places (x, y), any shape; None if the sweep gives none."""
    chart = _map_of(sweep)
    if any(entry.expected is None for entry in chart.classes):
        return None
    found = np.full(np.shape(x), NO_CLASS, np.int64)
    for number in reversed(range(len(chart.classes))):
        text = chart.classes[number].expected or ""
        holds = Expression(text, f"map.classes[{number}].expected").evaluate({chart.x: x, chart.y: y})
        found[np.broadcast_to(np.asarray(holds, np.bool_), found.shape)] = number
    return found


def compare(sweep: Sweep, columns: Columns) -> Verdict | None:
    """How the outcomes agree with the closed form; None if the sweep gives none."""
    x, y = _axes_of(sweep, columns)
    expected = expect(sweep, x, y)
    if expected is None:
        return None
    found = classify(sweep, columns)
    counts = found != FAILED
    off = counts & (found != expected)
    beside = np.zeros(int(off.sum()), np.bool_)
    tables = {p.column: p for p in sweep.table.parameters}
    chart = _map_of(sweep)
    around = [_around(values, tables[name]) for values, name in ((x, chart.x), (y, chart.y))]
    for near_x, near_y in itertools.product(*around):
        near = expect(sweep, near_x[off], near_y[off])
        beside |= near != expected[off]
    return Verdict(int(counts.sum()), int((counts & ~off).sum()), int(beside.sum()))


def draw(sweep: Sweep, columns: Columns, path: str | Path) -> Path:
    """Draw the map.

    Args:
        sweep: a sweep with a map.
        columns: its table, complete or not.
        path: of the picture (PNG, SVG or PDF).

    Raises:
        InvalidInputError: the sweep has no map.
        OutputError: the picture cannot be written.
    """
    target = Path(path)
    made = figure(sweep, columns)
    try:
        made.savefig(target, dpi=DPI)
    except OSError as error:
        raise outputs.not_writable("--map", target, error) from error
    return target


def figure(sweep: Sweep, columns: Columns) -> Figure:
    """The figure of :func:`draw`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    chart = _map_of(sweep)
    x, y = _axes_of(sweep, columns)
    found = classify(sweep, columns)
    made = Figure(figsize=SIZE, layout="constrained", facecolor=style.PAPER)
    FigureCanvasAgg(made)
    axes = made.add_subplot()
    made.suptitle(sweep.title, x=0.012, ha="left", fontsize=15, fontweight="bold", color=style.INK)
    _dress(axes, chart)
    tables = {p.column: p for p in sweep.table.parameters}
    limits = [_limits(values, tables[name]) for values, name in ((x, chart.x), (y, chart.y))]
    for name, axis, scale in ((chart.x, axes.xaxis, axes.set_xscale), (chart.y, axes.yaxis, axes.set_yscale)):
        if "log" in tables[name].axis:
            scale("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_locator(NullLocator())
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])

    ground = _draw_closed_form(axes, sweep, limits)
    size = float(np.clip(12000.0 / max(len(x), 1), 5.0, 60.0))
    for number in [FAILED, NO_CLASS, *range(len(chart.classes))]:
        mine = found == number
        if not mine.any() and number < 0:
            continue
        label, color, marker = _look(chart.classes, number)
        axes.scatter(x[mine], y[mine], s=size, c=color, marker=marker, lw=0 if marker == "o" else 1.4, label=label)
    agreement = _draw_rings(axes, sweep, found, x, y, size)
    handles, labels = axes.get_legend_handles_labels()
    made.legend(
        *(handles, labels),
        loc="outside lower left",
        ncols=len(handles) if len(handles) <= IN_A_ROW else -(-len(handles) // 2),
        frameon=False,
        fontsize=10.5,
        labelcolor=style.INK,
        handletextpad=0.3,
        columnspacing=1.4,
    )
    caption = [chart.closed_form] if ground and chart.closed_form else []
    if agreement:
        caption.append(agreement)
    if caption:
        axes.set_title("\n".join(caption), loc="left", fontsize=10, color=style.MUTED_INK, pad=8)
    return made


def _map_of(sweep: Sweep) -> MapTable:
    if sweep.table.map is None:
        raise InvalidInputError(f"a sweep must have a [map] to be drawn, and {sweep.name!r} has none.")
    return sweep.table.map


def _axes_of(sweep: Sweep, columns: Columns) -> tuple[Array, Array]:
    chart = _map_of(sweep)
    return np.asarray(columns[chart.x], np.float64), np.asarray(columns[chart.y], np.float64)


def _limits(values: Array, parameter: ParameterTable) -> tuple[float, float]:
    """Of an axis: a little beyond the outermost values."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if "log" in parameter.axis:
        factor = (high / low) ** 0.04 if high > low else 1.5
        return low / factor, high * factor
    margin = 0.04 * (high - low) or 0.5
    return low - margin, high + margin


def _around(values: Array, parameter: ParameterTable) -> tuple[Array, Array, Array]:
    """The values of an axis one step lower, as they are, and one step higher.

    On a grid a step is the distance of neighbours; elsewhere it is that of as many points on a square grid.
    """
    log = "log" in parameter.axis
    places = np.log(values) if log else values
    different = np.unique(places)
    across = float(np.ptp(different))
    side = np.sqrt(len(values))
    step = float(np.median(np.diff(different))) if 1 < len(different) <= 2.0 * side else across / side
    lower, higher = places - step, places + step
    return (np.exp(lower), values, np.exp(higher)) if log else (lower, values, higher)


def _look(classes: tuple[ClassTable, ...], number: int) -> tuple[str, str, str]:
    if number == FAILED:
        return "failed", "#000000", "x"
    if number == NO_CLASS:
        return "none of these", style.MUTED_INK, "+"
    return classes[number].label, COLORS[number % len(COLORS)], "o"


def _dress(axes: Axes, chart: MapTable) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(style.GRID_SECTION)
    axes.tick_params(colors=style.MUTED_INK, labelsize=10)
    axes.set_xlabel(chart.x_label or chart.x, color=style.INK, fontsize=11)
    axes.set_ylabel(chart.y_label or chart.y, color=style.INK, fontsize=11)


def _draw_closed_form(axes: Axes, sweep: Sweep, limits: list[tuple[float, float]]) -> bool:
    """Pale regions of the closed form, and the line between them."""
    spaces = [
        np.geomspace(*ends, FINE) if scale == "log" else np.linspace(*ends, FINE)
        for ends, scale in zip(limits, (axes.get_xscale(), axes.get_yscale()), strict=True)
    ]
    x, y = np.meshgrid(*spaces)
    regions = expect(sweep, x, y)
    if regions is None:
        return False
    classes = _map_of(sweep).classes
    for number in range(len(classes)):
        inside = (regions == number).astype(np.float64)
        if not inside.any():
            continue
        axes.contourf(x, y, inside, levels=[0.5, 1.5], colors=[_look(classes, number)[1]], alpha=0.13, zorder=0)
        if not inside.all():
            axes.contour(x, y, inside, levels=[0.5], colors=[style.INK], linewidths=1.3, zorder=1)
    axes.plot([], [], color=style.INK, lw=1.3, label="closed form")
    return True


def _draw_rings(axes: Axes, sweep: Sweep, found: Classes, x: Array, y: Array, size: float) -> str:
    """Rings around runs that did something else than the closed form says; returns how many did not."""
    expected = expect(sweep, x, y)
    if expected is None:
        return ""
    known = found != FAILED
    off = known & (found != expected)
    if off.any():
        ring: dict[str, Any] = {"facecolors": "none", "edgecolors": style.INK, "linewidths": 1.2}
        axes.scatter(x[off], y[off], s=3.0 * size + 20.0, label="not as the closed form says", **ring)
    return f"{int((known & ~off).sum())} of {int(known.sum())} runs do what the closed form says"
