"""Materials come in pairs: the table of friction, restitution and rolling resistance of every two materials that touch.

A coefficient of friction belongs to two surfaces, never to one, so the table is keyed by unordered pairs. A pair that
nobody has set is guessed from what is known about each of its materials; the rule is written at
:meth:`MaterialTable.pair`, and the ``source`` of such a guess says what it was made of.

The rows that ship with the package are in ``data/materials.toml``; they are read when they are first asked for.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError, MaterialWarning
from stiction.laws import Coulomb, FrictionLaw, law_from
from stiction.pair_properties import EXTRAS, LABELS, PROPERTIES, PairProperties, check_value

DEFAULT_MATERIAL = "default"
"""The material of a body that names none. It exists in every table, and so does its pair with itself."""

Pair = tuple[str, str]
Row = dict[str, Any]


# A world works before anything is set up: the lecture's first row, a wooden crate on concrete, without any bounce.
_DEFAULT_PAIR = PairProperties(0.5, 0.4, 0.0, 0.0, 0.0, "built-in default: as wood - concrete in the lecture's table")


class _Own(NamedTuple):
    """One material's own values, for the fallback rule, and the words that say where they come from."""

    values: tuple[float, ...]
    origin: str


class MaterialTable:
    """The table of material pairs; ``MaterialTable()`` knows nothing but the material ``default``.

    Pairs are unordered. Materials come into being by being named in :meth:`set_pair` or :meth:`add_material`; their
    names are case-sensitive. ``len(table)`` is the number of pairs that are set, ``default`` with itself among them,
    and ``name in table`` says whether a material is known.

    Example:
        >>> from stiction import MaterialTable
        >>> table = MaterialTable.lecture()
        >>> table.pair("ice", "wood").static
        0.2
        >>> table.set_pair("wood", "felt", static=0.4, dynamic=0.3)
        >>> table.pair("felt", "ice").source
        'fallback: geometric mean of felt (felt - wood) and ice (mean of 2 pairs)'
    """

    def __init__(self) -> None:
        self._materials: set[str] = {DEFAULT_MATERIAL}
        self._pairs: dict[Pair, PairProperties] = {(DEFAULT_MATERIAL, DEFAULT_MATERIAL): _DEFAULT_PAIR}
        self._own_values: dict[str, _Own] = {}
        self._version = 0

    @classmethod
    def lecture(cls) -> Self:
        """The nine rows of the lecture's slide "Some coefficients", value for value; all but friction is 0."""
        return cls.from_rows(row for kind, row in _shipped_rows() if kind == "lecture")

    @classmethod
    def default(cls) -> Self:
        """The lecture's rows and all others that ship with the package, each with its source."""
        return cls.from_rows(row for _, row in _shipped_rows())

    @classmethod
    def from_rows(cls, rows: Iterable[Mapping[str, Any]]) -> Self:
        """A table from rows as :meth:`to_toml_rows` gives them and as scene files hold them.

        Args:
            rows: each either ``{"material": name}`` or ``a`` and ``b`` with what :meth:`set_pair` takes; what is left
                out has the same meaning as there.

        Raises:
            InvalidInputError: a row lacks a material, has an unknown key, a value that :meth:`set_pair` refuses, or
                repeats the pair of an earlier row.
        """
        table = cls()
        seen: set[Pair] = set()
        for number, row in enumerate(rows, start=1):
            if not isinstance(row, Mapping):
                raise InvalidInputError(f"materials row {number} must be a table of keys and values, got {row!r}.")
            if "material" in row:
                for key in row:
                    checks.one_of(f"key of materials row {number}", key, ["material"])
                table.add_material(row["material"])
                continue
            for key in row:
                checks.one_of(f"key of materials row {number}", key, ["a", "b", *PROPERTIES, *EXTRAS, "law", "source"])
            for key in ("a", "b"):
                if key not in row:
                    raise InvalidInputError(
                        f"materials row {number} must name two materials a and b, got {dict(row)!r}."
                    )
            values = {key: value for key, value in row.items() if key not in ("a", "b")}
            a, b = _check_name(row["a"]), _check_name(row["b"])
            if _key(a, b) in seen:
                raise InvalidInputError(f"materials row {number} must not set {a} - {b} again, got it a second time.")
            table.set_pair(a, b, **values)
            seen.add(_key(a, b))
        return table

    def to_toml_rows(self) -> list[Row]:
        """The table as plain rows for a TOML or JSON file: first materials without a pair, then every set pair."""
        paired = {name for key in self._pairs for name in key}
        rows: list[Row] = [{"material": name} for name in sorted(self._materials - paired)]
        for a, b, properties in self.pairs():
            numbers = {name: getattr(properties, name) for name in PROPERTIES}
            extras = {name: value for name in EXTRAS if (value := getattr(properties, name))}
            if properties.law != Coulomb():
                extras["law"] = properties.law.as_dict()
            rows.append({"a": a, "b": b, **numbers, **extras, "source": properties.source})
        return rows

    # -- change -------------------------------------------------------------------------------------------------------

    def add_material(self, name: str) -> None:
        """Makes a material known without setting any pair; nothing happens where it is known already.

        Raises:
            InvalidInputError: ``name`` is not a non-empty text.
        """
        _check_name(name)
        if name not in self._materials:
            self._materials.add(name)
            self._changed()

    def set_pair(
        self,
        a: str,
        b: str,
        *,
        static: float | None = None,
        dynamic: float | None = None,
        restitution: float | None = None,
        rolling: float | None = None,
        torsional: float | None = None,
        law: FrictionLaw | Mapping[str, Any] | None = None,
        static_across: float | None = None,
        dynamic_across: float | None = None,
        adhesion: float | None = None,
        adhesion_pressure: float | None = None,
        tangential_restitution: float | None = None,
        source: str = "set by user",
    ) -> None:
        """Sets the properties of two materials, which need not be known before.

        What is None keeps its value where the pair is set already. On a new pair ``static`` must be given, ``dynamic``
        is as ``static`` and the others are 0. All values are checked before anything changes.

        Args:
            a: one material.
            b: the other one, or the same.
            static: coefficient of static friction, 0 or more.
            dynamic: coefficient of dynamic friction, 0 or more, normally at most ``static``.
            restitution: coefficient of restitution, 0 to 1.
            rolling: lever arm of rolling resistance in m, 0 or more.
            torsional: lever arm of torsional resistance in m, 0 or more.
            law: how the dynamic coefficient depends on speed or slip; :class:`stiction.laws.Coulomb` for not at all.
            static_across: coefficient of static friction across the grain of a body that has one (see
                :meth:`World.add`), 0 or more; ``static`` is the one along it.
            dynamic_across: the same for dynamic friction.
            adhesion: force with which a contact holds on when it is pulled, 0 N or more.
            adhesion_pressure: the same per area of a face, 0 Pa or more.
            tangential_restitution: of impacts that bounce, how much of the slip comes back reversed where friction can
                hold, 0 to 1.
            source: where the numbers come from.

        Raises:
            InvalidInputError: a name is not a non-empty text, a value is out of its range, or ``static`` is missing
                on a new pair.

        Warns:
            MaterialWarning: dynamic friction of the pair is now above its static friction.
        """
        words = f"{_check_name(a)} - {_check_name(b)}"
        key = _key(a, b)
        before = self._pairs.get(key)
        given = {
            "static": static,
            "dynamic": dynamic,
            "restitution": restitution,
            "rolling": rolling,
            "torsional": torsional,
            "static_across": static_across,
            "dynamic_across": dynamic_across,
            "adhesion": adhesion,
            "adhesion_pressure": adhesion_pressure,
            "tangential_restitution": tangential_restitution,
        }
        checked: dict[str, Any] = {
            name: check_value(name, words, value) for name, value in given.items() if value is not None
        }
        if law is not None:
            checked["law"] = law_from(law)
        if not isinstance(source, str) or not source.strip():
            raise InvalidInputError(f"source of {words} must be a non-empty text, got {source!r}.")
        if before is None and "static" not in checked:
            raise InvalidInputError(f"static friction of {words} must be given for a new pair, got None.")

        if before is None:
            values = {"dynamic": checked["static"], "restitution": 0.0, "rolling": 0.0, "torsional": 0.0, **checked}
        else:
            values = {name: checked.get(name, getattr(before, name)) for name in (*PROPERTIES, *EXTRAS, "law")}
        for name, along in (("static_across", "static"), ("dynamic_across", "dynamic")):
            if values.get(name) is not None and (values[name] == 0.0) != (values[along] == 0.0):
                raise InvalidInputError(
                    f"{LABELS[name]} of {words} must be above 0 where the one along it is, and 0 where that is 0, "
                    f"got {values[name]:g} across and {values[along]:g} along."
                )
        after = PairProperties(**values, source=source)
        if after != before:
            self._pairs[key] = after
            self._materials.update(key)
            self._changed()
        if after.dynamic > after.static:
            warnings.warn(
                f"dynamic friction of {words} should be at most its static friction {after.static:g}, "
                f"got {after.dynamic:g}.",
                MaterialWarning,
                stacklevel=2,
            )

    def _changed(self) -> None:
        self._version += 1
        self._own_values.clear()

    # -- look up ------------------------------------------------------------------------------------------------------

    def pair(self, a: str, b: str) -> PairProperties:
        """The properties of two materials: those set for the pair, or else a guess by the fallback rule.

        The fallback rule, in two steps:

        1. Each material's *own* values are those of its pair with itself if that is set, else the arithmetic mean over
           all set pairs in which it appears, else those of the material ``default``.
        2. Static and dynamic friction are the geometric mean of the two own values: one slippery surface makes a
           slippery contact, and a frictionless one a frictionless contact. Restitution, rolling and torsional
           resistance are the larger of the two: they belong to whichever body gives way, and a 0 mostly means that
           the source gave no number, which must not wipe out one that is known.

        The result never has dynamic above static friction. It is a guess all the same: no rule can know that glass on
        glass grips better than either on anything else. Its ``source`` begins with "fallback" and names what went in.

        Args:
            a: one material.
            b: the other one; the order does not matter.

        Raises:
            InvalidInputError: a material is not known; the sentence names the nearest one that is.
        """
        key = _key(self._known(a), self._known(b))
        properties = self._pairs.get(key)
        return self._fallback(*key) if properties is None else properties

    def is_set(self, a: str, b: str) -> bool:
        """Whether the pair is set, so that :meth:`pair` need not fall back.

        Raises:
            InvalidInputError: a material is not known.
        """
        return _key(self._known(a), self._known(b)) in self._pairs

    def pairs(self) -> Iterator[tuple[str, str, PairProperties]]:
        """All set pairs as (a, b, properties) with a <= b, in alphabetical order, ``default`` with itself included."""
        for (a, b), properties in sorted(self._pairs.items(), key=lambda item: item[0]):
            yield a, b, properties

    def to_array(self, names: Sequence[str]) -> NDArray[np.float64]:
        """The numbers of every two of the k materials named, fallbacks included: what a solver reads.

        Args:
            names: k known materials; their positions become the indices.

        Returns:
            (k, k, 5) array, symmetric in its first two axes: static, dynamic, restitution (dimensionless), rolling,
            torsional (m). If any of the pairs has one, also tangential restitution, (k, k, 6). If any has more, (k, k,
            11 + PARAMETERS): then also the ratios across / along of static and dynamic friction, adhesion (N) and
            adhesion pressure (Pa), and the code and the parameters of the law.

        Raises:
            InvalidInputError: a material is not known.
        """
        pairs = {(i, j): self.pair(a, b) for i, a in enumerate(names) for j, b in enumerate(names[: i + 1])}
        width = max((pair.width for pair in pairs.values()), default=len(PROPERTIES))
        result = np.zeros((len(names), len(names), width))
        for (i, j), pair in pairs.items():
            row = (*pair.numbers(), *pair.extras())[:width]
            result[i, j, : len(row)] = result[j, i, : len(row)] = row
        return result

    @property
    def materials(self) -> list[str]:
        """Names of all known materials in alphabetical order."""
        return sorted(self._materials)

    @property
    def version(self) -> int:
        """A counter that rises with every change, so that whoever derived something knows when it is out of date."""
        return self._version

    def _known(self, name: str) -> str:
        _check_name(name)
        if name not in self._materials:
            hint = checks.nearest(name, self.materials)
            raise InvalidInputError(
                f"material must be one of the {len(self._materials)} in the table, got {name!r}{hint}."
            )
        return name

    # -- fallback -----------------------------------------------------------------------------------------------------

    def _fallback(self, a: str, b: str) -> PairProperties:
        if a == b:
            values, origin = self._own(a)
            source = f"fallback: {origin}"
        else:
            own_a, own_b = self._own(a), self._own(b)
            friction = [_geometric_mean(x, y) for x, y in zip(own_a.values[:2], own_b.values[:2], strict=True)]
            rest = [max(x, y) for x, y in zip(own_a.values[2:], own_b.values[2:], strict=True)]
            values = (*friction, *rest)
            source = f"fallback: geometric mean of {own_a.origin} and {own_b.origin}"
        static, dynamic, restitution, rolling, torsional = values
        # Own values can only have dynamic above static where a pair was set that way (with a warning), or by rounding.
        return PairProperties(static, min(dynamic, static), restitution, rolling, torsional, source)

    def _own(self, name: str) -> _Own:
        """One material's own values: its self pair, else the mean over its pairs, else those of ``default``."""
        if name not in self._own_values:
            self._own_values[name] = self._find_own(name)
        return self._own_values[name]

    def _find_own(self, name: str) -> _Own:
        if (name, name) in self._pairs:
            return _Own(self._pairs[name, name].numbers(), f"{name} ({name} - {name})")
        keys = sorted(key for key in self._pairs if name in key)
        if not keys:
            return _Own(self._pairs[DEFAULT_MATERIAL, DEFAULT_MATERIAL].numbers(), f"{name} (as {DEFAULT_MATERIAL})")
        columns = zip(*(self._pairs[key].numbers() for key in keys), strict=True)
        mean = tuple(_mean(column) for column in columns)
        words = " - ".join(keys[0]) if len(keys) == 1 else f"mean of {len(keys)} pairs"
        return _Own(mean, f"{name} ({words})")

    # -- as a value ---------------------------------------------------------------------------------------------------

    def copy(self) -> Self:
        """An independent table with the same materials, pairs and version."""
        result = type(self)()
        result._materials = set(self._materials)
        result._pairs = dict(self._pairs)
        result._version = self._version
        return result

    def __contains__(self, name: object) -> bool:
        return name in self._materials

    def __len__(self) -> int:
        return len(self._pairs)

    def __eq__(self, other: object) -> bool:
        """Same materials and same pairs, sources included; the version does not matter."""
        if not isinstance(other, MaterialTable):
            return NotImplemented
        return self._materials == other._materials and self._pairs == other._pairs

    __hash__ = None  # type: ignore[assignment]  # it can change, so it must not be a key

    def __repr__(self) -> str:
        return f"<MaterialTable: {len(self._materials)} materials, {len(self._pairs)} pairs>"


def _key(a: str, b: str) -> Pair:
    return (a, b) if a <= b else (b, a)


def _geometric_mean(x: float, y: float) -> float:
    # Equal values come back exactly; the product of the roots cannot overflow.
    return x if x == y else math.sqrt(x) * math.sqrt(y)


def _mean(values: tuple[float, ...]) -> float:
    # Divided before they are added, and capped: the mean of finite values is finite and at most the largest of them.
    return min(max(values), 2.0 * math.fsum(value / (2 * len(values)) for value in values))


def _check_name(name: Any) -> str:
    if not isinstance(name, str) or not name or name != name.strip():
        raise InvalidInputError(f"material name must be a non-empty text without blanks around it, got {name!r}.")
    return name


@functools.cache
def _shipped_rows() -> tuple[tuple[str, Row], ...]:
    """The rows of ``data/materials.toml`` as (set, row), with the sources written out."""
    # Imported here because only these two lines need them: `import stiction` stays light.
    import tomllib
    from importlib import resources

    data = tomllib.loads(resources.files("stiction.data").joinpath("materials.toml").read_text(encoding="utf-8"))
    rows = []
    for entry in data["pair"]:
        source = f"{data['sources'][entry['source']]}: {entry['note']}"
        row = {key: value for key, value in entry.items() if key not in ("set", "note")} | {"source": source}
        rows.append((entry["set"], row))
    return tuple(rows)
