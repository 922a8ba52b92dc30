"""The ledger of energy over time: what is there and what friction has taken add up to what was put in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction.plot import canvas
from stiction.plot.track import Track
from stiction.reports import Energy
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LAYERS = {
    "kinetic": "#0072b2",
    "potential": "#8fc9ec",
    "friction": "#e8590c",
    "rolling": "#f2b277",
    "impacts": "#5c6873",
}
"""Parts of the ledger from the bottom up, and their colours."""
SMALL = 1e-3
"""Parts below that share of the top are left out."""
KILO_FROM = 5000.0


def parts(energies: Array) -> tuple[dict[str, Array], Array]:
    """Parts of the ledger (f,) in J by name, and what was put in (f,), which is their sum.

    Potential energy is counted from its lowest value; the same is taken off what was put in. What the integrator has
    made, ``numerical``, counts as put in. Impacts may be below zero, see :attr:`stiction.Energy.given_back`.

    Args:
        energies: (f, 9) J, rows of :class:`stiction.reports.Energy`.
    """
    ledger = Energy(*energies.T)  # columns instead of numbers: the same sums hold
    lowest = np.min(ledger.potential)
    layers = {name: np.asarray(getattr(ledger, name)) for name in LAYERS}
    layers["potential"] = layers["potential"] - lowest
    put_in = np.asarray(ledger.initial + ledger.work + ledger.edits + ledger.numerical - lowest)
    return layers, put_in


def draw(track: Track, bodies: list[str] | None) -> Figure:
    """The figure: the parts of the ledger stacked, and a line of what was put in, on which they must end. Where impacts
    are below zero, the stack begins there.

    Args:
        track: the run, with energies.
        bodies: None: the ledger is that of the whole world.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    assert track.energies is not None  # the registry asks before
    times = track.frames.times
    layers, put_in = parts(track.energies)
    top = max(1e-12, float(put_in.max()), *(float(layer.max()) for layer in layers.values()))
    unit, name = (1000.0, "kJ") if top >= KILO_FROM else (1.0, "J")
    shown = {key: layer for key, layer in layers.items() if float(np.abs(layer).max()) > SMALL * top}

    figure = canvas.sheet(track.frames.title)
    axes = canvas.dress(figure.add_subplot())
    lowest = 0.0
    if shown:
        colors = ["none", *(LAYERS[key] for key in shown)]
        base = np.sum([np.minimum(layer, 0.0) for layer in shown.values()], axis=0)
        axes.stackplot(
            times, base / unit, *(np.maximum(layer, 0.0) / unit for layer in shown.values()), colors=colors, lw=0
        )
        lowest = min(0.0, 1.08 * float(base.min()) / unit)
    axes.plot(times, put_in / unit, color=style.INK, lw=1.6, ls=(0, (5, 2)))
    axes.set_xlim(times[0], times[-1] if times[-1] > times[0] else times[0] + 1.0)
    axes.set_ylim(lowest, 1.08 * top / unit)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(f"energy ({name})")
    ledgers = [Energy(*row) for row in track.energies.tolist()]
    words = f"the ledger closes to {max(abs(ledger.residual) for ledger in ledgers):.1g} J"
    if given_back := max(ledger.given_back for ledger in ledgers):
        words += f"; soft contacts have given back up to {given_back:.2g} J more than impacts took"
    axes.set_title(words, loc="left", fontsize=10.5, color=style.MUTED_INK)
    handles = [Patch(color=LAYERS[key], lw=0, label=key) for key in reversed(shown)]
    canvas.legend(figure, [*handles, Line2D([], [], color=style.INK, lw=1.6, ls=(0, (5, 2)), label="put in")])
    return figure
