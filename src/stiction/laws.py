"""Friction laws of a pair of materials beyond two constants: coefficients that depend on the speed or slip of sliding.

A law belongs to a pair, ``materials.set_pair(a, b, static=..., dynamic=..., law=Stribeck(...))``, and says what the
*dynamic* coefficient is while the contact slides; what it takes to break away from rest stays ``static``.

========================  ===========================================================================================
:class:`Coulomb`          dynamic, whatever the speed; what a pair has that names no law
:class:`Stribeck`         from static down to dynamic as the speed rises, and up again with a viscous part
:class:`FrictionCurve`    coefficients at given speeds, straight lines in between
:class:`BrushTyre`        a tyre as a row of elastic bristles, by slip in any direction
:class:`MagicFormula`     a tyre by Pacejka's formula, by slip in any direction
========================  ===========================================================================================
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from stiction import checks
from stiction.errors import InvalidInputError

MOST_POINTS = 16
"""Of a curve."""
PARAMETERS = 2 * MOST_POINTS
"""Room for the numbers of a law."""


@dataclass(frozen=True)
class FrictionLaw(ABC):
    """How the dynamic coefficient of a pair depends on how it slides. Use one of the classes of this module."""

    kind: ClassVar[str]
    """Its name in files."""
    code: ClassVar[int]
    """Its number in the kernels."""

    @abstractmethod
    def parameters(self) -> tuple[float, ...]:
        """The numbers that the kernels read, at most :data:`PARAMETERS`."""

    def as_dict(self) -> dict[str, Any]:
        """The law as plain values for a file: its kind and its parameters."""
        return {"kind": self.kind} | {f.name: _plain(getattr(self, f.name)) for f in fields(self)}


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """The dynamic coefficient does not depend on the speed: Coulomb's law. Takes a law of a pair away again."""

    kind: ClassVar[str] = "coulomb"
    code: ClassVar[int] = 0

    def parameters(self) -> tuple[float, ...]:
        """None."""
        return ()


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    """mu(v) = dynamic + (static - dynamic) exp(-(v / speed)^exponent) + viscous v.

    Armstrong-Hélouvry, Dupont, Canudas de Wit, "A survey of models, analysis tools and compensation methods for the
    control of machines with friction", Automatica 30, 1994, section 2.

    Attributes:
        speed: the Stribeck speed, above 0 m/s.
        viscous: viscous part, 0 s/m or more: coefficient per speed.
        exponent: 2 for a Gaussian curve, 1 for an exponential one; 0.5 to 4.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    kind: ClassVar[str] = "stribeck"
    code: ClassVar[int] = 1
    speed: float
    viscous: float = 0.0
    exponent: float = 2.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", checks.positive("speed of a Stribeck law", self.speed, "m/s"))
        object.__setattr__(self, "viscous", checks.non_negative("viscous of a Stribeck law", self.viscous, "s/m"))
        exponent = checks.number("exponent of a Stribeck law", self.exponent)
        if not 0.5 <= exponent <= 4.0:
            raise InvalidInputError(f"exponent of a Stribeck law must be 0.5 to 4, got {self.exponent!r}.")
        object.__setattr__(self, "exponent", exponent)

    def parameters(self) -> tuple[float, ...]:
        """Speed, viscous part, exponent."""
        return self.speed, self.viscous, self.exponent


@dataclass(frozen=True)
class FrictionCurve(FrictionLaw):
    """The dynamic coefficient at given speeds; straight lines in between, constant beyond the first and the last.

    Attributes:
        points: two to sixteen pairs (speed in m/s, coefficient), speeds rising.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    kind: ClassVar[str] = "curve"
    code: ClassVar[int] = 2
    points: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        name = "points of a friction curve"
        try:
            rows = [tuple(row) for row in self.points]
        except TypeError:
            rows = []
        if not 2 <= len(rows) <= MOST_POINTS or any(len(row) != 2 for row in rows):
            raise InvalidInputError(
                f"{name} must be 2 to {MOST_POINTS} pairs (speed, coefficient), got {self.points!r}."
            )
        made = tuple(
            (
                checks.non_negative(f"speed {k} of a friction curve", v, "m/s"),
                checks.non_negative(f"coefficient {k} of a friction curve", mu),
            )
            for k, (v, mu) in enumerate(rows)
        )
        if any(b[0] <= a[0] for a, b in itertools.pairwise(made)):
            raise InvalidInputError(f"{name} must have speeds that rise, got {[v for v, _ in made]} m/s.")
        object.__setattr__(self, "points", made)

    def parameters(self) -> tuple[float, ...]:
        """Speed and coefficient of each point."""
        return tuple(x for point in self.points for x in point)


@dataclass(frozen=True)
class BrushTyre(FrictionLaw):
    """A tyre as a row of elastic bristles that stick at the front of the contact and slide at its end.

    With the slip sigma = |velocity of the tread over the road| / |velocity of the wheel over the road| and theta =
    stiffness sigma / (3 dynamic), friction is against the slip, in any direction (combined slip), with

        mu(sigma) = dynamic (3 theta - 3 theta^2 + theta^3) up to theta = 1, dynamic beyond.

    Pacejka, "Tire and Vehicle Dynamics", 3rd ed. 2012, section 3.2.

    Attributes:
        stiffness: slope of mu(sigma) at no slip, above 0; about 10 to 30 for car tyres.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    kind: ClassVar[str] = "brush"
    code: ClassVar[int] = 3
    stiffness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", checks.positive("stiffness of a brush tyre", self.stiffness))

    def parameters(self) -> tuple[float, ...]:
        """The stiffness."""
        return (self.stiffness,)


@dataclass(frozen=True)
class MagicFormula(FrictionLaw):
    """A tyre by the magic formula: friction against the slip, in any direction (combined slip), with

        mu(sigma) = D sin(C atan(B sigma - E (B sigma - atan(B sigma)))),

    D the pair's dynamic coefficient, which here is the *peak*, and sigma as in :class:`BrushTyre`.

    Pacejka and Bakker, "The magic formula tyre model", Vehicle System Dynamics 21, 1992; similarity in combined slip
    as in Pacejka, "Tire and Vehicle Dynamics", 3rd ed. 2012, section 4.3.

    Attributes:
        B: stiffness factor, above 0; B C D is the slope at no slip.
        C: shape factor, above 0 up to 2; 1.3 to 1.7 usually.
        E: curvature factor, -10 to 1.

    Raises:
        InvalidInputError: a value is not allowed.
    """

    kind: ClassVar[str] = "magic"
    code: ClassVar[int] = 4
    B: float
    C: float
    E: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "B", checks.positive("B of a magic formula", self.B))
        shape, curvature = checks.positive("C of a magic formula", self.C), checks.number("E", self.E)
        if shape > 2.0:
            raise InvalidInputError(f"C of a magic formula must be 2 or less, got {self.C!r}.")
        if not -10.0 <= curvature <= 1.0:
            raise InvalidInputError(f"E of a magic formula must be -10 to 1, got {self.E!r}.")
        object.__setattr__(self, "C", shape)
        object.__setattr__(self, "E", curvature)

    def parameters(self) -> tuple[float, ...]:
        """B, C and E."""
        return self.B, self.C, self.E


LAWS: dict[str, type[FrictionLaw]] = {
    law.kind: law for law in (Coulomb, Stribeck, FrictionCurve, BrushTyre, MagicFormula)
}
"""All laws by the name that files have for them."""


def law_from(value: Any) -> FrictionLaw:
    """A law as it is, or from the plain values of a file.

    Raises:
        InvalidInputError: it is neither, or a value is not allowed.
    """
    if isinstance(value, FrictionLaw):
        return value
    if not isinstance(value, Mapping) or "kind" not in value:
        raise InvalidInputError(
            f'law must be a friction law such as Stribeck(speed=0.01) or {{kind = "stribeck", speed = 0.01}}, '
            f"got {value!r}."
        )
    law = LAWS[checks.one_of("kind of a friction law", value["kind"], LAWS)]
    given = {key: entry for key, entry in value.items() if key != "kind"}
    names = [f.name for f in fields(law)]
    for key in given:
        if key not in names:
            allowed = ", ".join(names) or "nothing"
            raise InvalidInputError(f"law {law.kind!r} takes {allowed}, got {key!r}{checks.nearest(key, names)}.")
    try:
        return law(**given)
    except TypeError:
        missing = [f.name for f in fields(law) if f.name not in given]
        raise InvalidInputError(f"law {law.kind!r} needs {missing[0]}.") from None


def _plain(value: Any) -> Any:
    return [list(row) for row in value] if isinstance(value, tuple) else value
