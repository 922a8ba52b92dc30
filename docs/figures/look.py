"""The look of the documentation's figures: one size of type, few colours, small files that come out bit for bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import stiction as st
from stiction.view import style

FOLDER = Path(__file__).resolve().parent.parent / "_static"
DPI = 150

INK, MUTED = style.INK, style.MUTED_INK
EXACT = "#c9d1d8"
"""Closed forms: a broad pale line, on which the measured points must lie."""
RIGHT = "#0072b2"
LITERAL = "#e8590c"
LITERAL_FINE = "#6a3d9a"


def panels(shares: tuple[float, ...], height: float = 3.4, stacked: bool = False) -> tuple[Figure, list[Axes]]:
    """A figure, 9 inches wide, with axes side by side or stacked, their widths or heights in these proportions."""
    figure = Figure(figsize=(9.0, height), layout="constrained", facecolor=style.PAPER)
    FigureCanvasAgg(figure)
    if stacked:
        grid = figure.add_gridspec(len(shares), 1, height_ratios=shares)
    else:
        grid = figure.add_gridspec(1, len(shares), width_ratios=shares)
    return figure, [dress(figure.add_subplot(cell)) for cell in grid]


def dress(axes: Axes) -> Axes:
    """Quiet axes: two spines, a pale grid."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(MUTED)
    axes.tick_params(colors=MUTED, labelsize=10)
    axes.grid(color="#e8ecf0", lw=0.8)
    axes.set_axisbelow(True)
    axes.xaxis.label.set(color=INK, size=11)
    axes.yaxis.label.set(color=INK, size=11)
    return axes


def title(axes: Axes, text: str) -> None:
    """A title that says what is to be seen, at the left edge."""
    axes.set_title(text, loc="left", fontsize=11.5, color=INK, pad=8)


def note(axes: Axes, text: str, xy: tuple[float, float], color: str = INK, **options: Any) -> None:
    """A label inside the axes, beside what it names."""
    axes.annotate(text, xy, color=color, fontsize=10, **options)


def save(figure: Figure, name: str) -> Path:
    """Write ``_static/name``, without anything in it that changes from run to run."""
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / name
    figure.savefig(path, dpi=DPI, metadata={"Software": None})
    return path


def crate_on_floor(
    size: tuple[float, float, float], static: float, dynamic: float, *, dt: float, literal: bool = False, **world: Any
) -> tuple[st.World, st.Body]:
    """A crate of 600 kg at rest on a plane, with these two coefficients."""
    table = st.MaterialTable()
    table.set_pair("wood", "concrete", static=static, dynamic=dynamic)
    scene = st.World(dt=dt, materials=table, micro_literal=literal, **world)
    scene.add(st.Plane(), static=True, material="concrete")
    crate = scene.add(st.Box(size), mass=600, material="wood", position=(0, 0, size[2] / 2))
    return scene, crate


def tilted_gravity(tan: float, g: float = 9.81) -> np.ndarray:
    """Gravity as seen by a plane whose slope is ``tan``, downhill along x: (3,), m/s^2."""
    angle = np.arctan(tan)
    return g * np.array([np.sin(angle), 0.0, -np.cos(angle)])
