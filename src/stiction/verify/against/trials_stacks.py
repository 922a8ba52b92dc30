"""Trials of what only stands because friction and contacts hold it: towers, a house of cards, an arch."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from stiction.bench import masonry, stacks
from stiction.bench.scene import BenchScene
from stiction.verify.against.trial import Reading, Track, Trial


class Stands(Trial):
    """Nothing acts on it but its weight."""

    formula = "nothing moves"
    source = "statics"
    unit = "mm"
    relative = False
    tolerance = 10.0
    tolerance_reason = "a hundredth of a cube of 1 m: what eyes do not see"
    seconds = 10.0

    @abstractmethod
    def scene(self) -> BenchScene:
        """What stands."""

    def scenes(self) -> list[BenchScene]:
        """One."""
        return [self.scene()]

    def read(self, tracks: Sequence[Track]) -> Reading:
        """How far the body is from its place that is farthest from it, at the end."""
        moved = tracks[0].positions[-1] - tracks[0].positions[0]
        return Reading(0.0, (1e3 * float(np.max(np.linalg.norm(moved, axis=1))),))


class Tower(Stands):
    """Contacts that give way add up."""

    name = "tower-of-ten"
    title = "a tower of ten cubes is after ten seconds where it was"

    def scene(self) -> BenchScene:
        """Exactly touching."""
        return stacks.tower(10)


class HeavyOnLight(Stands):
    """A ratio of masses."""

    name = "heavy-on-light"
    title = "a cube stands on one of a hundredth of its mass"

    def scene(self) -> BenchScene:
        """1000 kg and 100,000 kg."""
        return stacks.tower(2, heavy=100.0)


class HeavyOnTop(Stands):
    """The same over a height."""

    name = "heavy-on-top"
    title = "five cubes stand, the top one a hundred times as heavy as the others"

    def scene(self) -> BenchScene:
        """1000 kg/m^3, and the top 100,000."""
        return stacks.tower(5, heavy=100.0)


class Cards(Stands):
    """Struts that friction holds at foot and tip."""

    name = "card-house"
    title = "a house of cards of five storeys stands"
    formula = "a card that leans by a from the vertical holds while mu > tan(a): 0.6 > 0.36"
    tolerance = 100.0
    tolerance_reason = "what the scene calls standing: gaps of 2 mm between its cards close, and what falls goes far"

    def scene(self) -> BenchScene:
        """40 cards."""
        return masonry.card_house()


class Arch(Stands):
    """No mortar."""

    name = "arch"
    title = "a half circle of 21 wedge stones stands, a fifth of its radius thick"
    formula = "stands if t / R > 0.1075 and nothing slides"
    source = "Milankovitch (1907); Heyman, 'The Stone Skeleton' (1966)"
    tolerance_reason = "a hundredth of a stone's thickness"

    def scene(self) -> BenchScene:
        """5 m of radius."""
        return masonry.arch()


TRIALS: tuple[type[Trial], ...] = (Tower, HeavyOnLight, HeavyOnTop, Cards, Arch)
