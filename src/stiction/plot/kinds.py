"""The kinds of figures there are, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.plot import cone, energy, hodograph, load, network, phase, pull, raster, run
from stiction.plot.track import Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Kind:
    """A kind of figure.

    Attributes:
        name: the word for ``--plot``.
        text: what it shows, in a line.
        draw: makes it of a track and the names of bodies, or None for its own choice.
        most: how many bodies may be named, if not as many as there are.
        fine: it wants every step, for it looks at the moment when something lets go.
        energies: it needs the ledger of energy.
        contacts: it needs contact points, or what bodies are doing, which is known from them.
    """

    name: str
    text: str
    draw: Callable[[Track, list[str] | None], Figure]
    most: int | None = None
    fine: bool = False
    energies: bool = False
    contacts: bool = True

    def check_bodies(self, bodies: list[str] | None, known: list[str]) -> None:
        """Whether bodies of these names can be shown.

        Raises:
            InvalidInputError: there are too many names, or one is not known.
        """
        if bodies is None:
            return
        if self.most == 0:
            raise InvalidInputError(f"bodies must be left out for a figure of kind {self.name!r}, got {bodies!r}.")
        most = len(known) if self.most is None else self.most
        if not 1 <= len(bodies) <= most:
            raise InvalidInputError(
                f"bodies must be 1 to {most} names for a figure of kind {self.name!r}, got {len(bodies)}."
            )
        for name in bodies:
            checks.one_of("bodies", name, known)


KINDS = {
    kind.name: kind
    for kind in (
        Kind("run", "speed and friction force over time, with the Coulomb limits", run.draw, run.MOST_BODIES),
        Kind(
            "pull", "friction against the force that pulls: it rises, lets go and drops", pull.draw, pull.MOST_BODIES,
            fine=True,
        ),
        Kind("load", "friction against load at every contact: the cone seen from the side", load.draw),
        Kind("cone", "the friction cone with the impulses of every contact in it", cone.draw),
        Kind(
            "hodograph", "speed of sliding against speed of turning, and where their ratio goes", hodograph.draw,
            hodograph.MOST_BODIES, fine=True, contacts=False,
        ),
        Kind("raster", "which contacts stick and which slip, over time", raster.draw),
        Kind("energy", "the ledger of energy over time", energy.draw, most=0, energies=True, contacts=False),
        Kind("phase", "speed against place: the phase portrait of each body", phase.draw, phase.MOST_BODIES, fine=True),
        Kind("network", "the contacts of a heap and the loads in them, at the end", network.draw),
    )
}  # fmt: skip
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
        raise InvalidInputError(f"track must hold energies for a figure of kind {kind!r}, and this one has none.")
    chosen.check_bodies(bodies, [body.name for body in track.frames.bodies])
    return chosen.draw(track, bodies)
