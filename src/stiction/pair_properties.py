"""What two materials do to each other where they touch: the numbers of a pair, and what they may be."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.laws import PARAMETERS, Coulomb, FrictionLaw

PROPERTIES = ("static", "dynamic", "restitution", "rolling", "torsional")
"""The numbers that every pair has, in the order of the last axis of :meth:`MaterialTable.to_array`."""

EXTRAS = ("tangential_restitution", "static_across", "dynamic_across", "adhesion", "adhesion_pressure")
"""Numbers of some pairs; with ``law`` what :meth:`MaterialTable.to_array` adds if any pair has one of them."""

LABELS = {
    "static": "static friction",
    "dynamic": "dynamic friction",
    "restitution": "restitution",
    "rolling": "rolling resistance",
    "torsional": "torsional resistance",
    "tangential_restitution": "tangential restitution",
    "static_across": "static friction across the grain",
    "dynamic_across": "dynamic friction across the grain",
    "adhesion": "adhesion",
    "adhesion_pressure": "adhesion pressure",
}
_UNITS = {"rolling": "m", "torsional": "m", "adhesion": "N", "adhesion_pressure": "Pa"}


@dataclass(frozen=True, slots=True, repr=False)
class PairProperties:
    """What two materials do to each other where they touch.

    Attributes:
        static: coefficient of static friction, dimensionless: a contact sticks while |f_t| <= static * f_n.
        dynamic: coefficient of dynamic friction, dimensionless: a sliding contact has |f_t| = dynamic * f_n.
        restitution: ratio of the normal speeds after and before an impact, 0 to 1.
        rolling: lever arm of rolling resistance in m: the moment against rolling is at most rolling * f_n.
        torsional: lever arm of torsional resistance in m: the moment against spinning is at most torsional * f_n.
        source: where the numbers come from.
        law: how the dynamic coefficient depends on speed or slip.
        static_across, dynamic_across: coefficients across the grain of a body that has one, as ``static`` and
            ``dynamic`` are along it; None where they are the same.
        adhesion: force with which a contact holds on, N. adhesion_pressure: the same per area of a face, Pa.
        tangential_restitution: ratio of the slip after an impact that bounces and sticks, and the slip before it, with
            the opposite sign: 0 for one that just sticks, 1 for a superball.

    What works at once, in this order: the law makes the dynamic coefficient; the grain makes an ellipse of it, in which
    friction is most dissipative; the load that the coefficient is taken of is that of the surfaces on each other,
    adhesion included; faces and torsional resistance make the limit surface of force and torque from that.
    """

    static: float
    dynamic: float
    restitution: float
    rolling: float
    torsional: float
    source: str
    law: FrictionLaw = field(default_factory=Coulomb)
    static_across: float | None = None
    dynamic_across: float | None = None
    adhesion: float = 0.0
    adhesion_pressure: float = 0.0
    tangential_restitution: float = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether it is described by the five numbers that every pair has."""
        return self.width == len(PROPERTIES)

    @property
    def width(self) -> int:
        """How many of :meth:`numbers` and :meth:`extras`, one behind the other, it needs; the rest are as usual."""
        laws = self.law, self.static_across, self.dynamic_across, self.adhesion, self.adhesion_pressure
        if laws != (Coulomb(), None, None, 0.0, 0.0):
            return len(PROPERTIES) + len(EXTRAS) + 1 + PARAMETERS
        return len(PROPERTIES) + (self.tangential_restitution > 0.0)

    def __repr__(self) -> str:
        """The five numbers, what else it has, and the source."""
        shown = [*PROPERTIES, *(name for name in EXTRAS if getattr(self, name))]
        words = [f"{name}={getattr(self, name)!r}" for name in shown]
        if self.law != Coulomb():
            words.append(f"law={self.law!r}")
        return f"PairProperties({', '.join(words)}, source={self.source!r})"

    def numbers(self) -> tuple[float, ...]:
        """The five numbers that every pair has, in the order of :data:`PROPERTIES`."""
        return tuple(getattr(self, name) for name in PROPERTIES)

    def extras(self) -> tuple[float, ...]:
        """Tangential restitution, ratios across / along of static and dynamic friction, adhesion (N, Pa), code and
        parameters of the law."""
        law = self.law
        static, dynamic = _ratio(self.static_across, self.static), _ratio(self.dynamic_across, self.dynamic)
        others = self.adhesion, self.adhesion_pressure, float(law.code), *law.parameters()
        return (self.tangential_restitution, static, dynamic, *others)


def _ratio(across: float | None, along: float) -> float:
    return 1.0 if across is None or along == 0.0 else across / along


def check_value(name: str, words: str, value: Any) -> float:
    """One of the numbers of a pair, that ``words`` name, within its range."""
    label = f"{LABELS[name]} of {words}"
    if name in ("restitution", "tangential_restitution"):
        result = checks.number(label, value)
        if not 0.0 <= result <= 1.0:
            raise InvalidInputError(f"{label} must be between 0 and 1, got {value!r}.")
        return result
    return checks.non_negative(label, value, _UNITS.get(name, ""))
