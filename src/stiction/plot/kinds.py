"""The kinds of figures there are, by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.plot.track import Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[[Track, list[str] | None], "Figure"]


@dataclass(frozen=True)
class Kind:
    """A kind of figure; the function ``draw`` of the module of its name in this package draws it.

    Attributes:
        name: the word for ``--plot``.
        text: what it shows, in a line.
        fine: it wants every step, for it looks at the moment when something lets go.
        energies: it needs the ledger of energy.
    """

    name: str
    text: str
    fine: bool = False
    energies: bool = False


KINDS = {
    kind.name: kind
    for kind in (
        Kind("run", "speed and friction force over time, with the Coulomb limits"),
        Kind("pull", "friction against the force that pulls: it rises, lets go and drops", fine=True),
        Kind("load", "friction against load at every contact: the cone seen from the side"),
        Kind("cone", "the friction cone with the impulses of every contact in it"),
        Kind("hodograph", "speed of sliding against speed of turning, and where their ratio goes", fine=True),
        Kind("raster", "which contacts stick and which slide, over time"),
        Kind("energy", "the ledger of energy over time", energies=True),
        Kind("phase", "speed against place: the phase portrait of each body", fine=True),
        Kind("network", "the contacts of a heap and the loads in them, at the end"),
    )
}
DEFAULT = "run"


def draw(kind: str, track: Track, *, bodies: list[str] | None = None) -> Figure:
    """A figure of a run.

    Args:
        kind: one of ``KINDS``.
        track: the run, from :func:`~stiction.plot.observe` or :func:`~stiction.plot.from_recording`.
        bodies: names of the bodies to show, or whose contacts to show; each kind has its own default.

    Raises:
        InvalidInputError: there is no such kind, a body is not there, or the track lacks what the figure shows.
    """
    chosen = KINDS[checks.one_of("kind", kind, KINDS)]
    if not len(track.frames):
        raise InvalidInputError("track must hold at least one frame, got 0.")
    if chosen.energies and track.energies is None:
        raise InvalidInputError(f"track must hold energies for a figure of kind {kind!r}, and recordings have none.")
    made = cast("Draw", importlib.import_module(f"stiction.plot.{chosen.name}").draw)
    return made(track, bodies)
