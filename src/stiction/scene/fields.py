"""Values of a scene file, checked one by one: each type says in one sentence what it allows.

The sentences are those of :mod:`stiction.checks`, without the name in front: whoever reports an error puts the path of
the key there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from stiction import checks

RESERVED = ".[]="
"""Characters that have a meaning in the path of an override, so no name may contain them."""


def fault(sentence: str, key: str | None = None) -> PydanticCustomError:
    """An error for pydantic whose path ends in ``key``, if one is given."""
    return PydanticCustomError("scene", "{sentence}", {"sentence": sentence, "key": key})


def _bare(check: Callable[..., Any], *args: Any, **kwargs: Any) -> Callable[[Any], Any]:
    """A check that leaves the parameter's name to whoever reports the error."""

    def run(value: Any) -> Any:
        return check("", value, *args, **kwargs)

    return run


def _numbers(length: int) -> Callable[[Any], tuple[float, ...]]:
    def run(value: Any) -> tuple[float, ...]:
        if isinstance(value, (list, tuple)) and len(value) == length:
            try:
                return tuple(checks.number("", item) for item in value)
            except ValueError:
                pass
        raise fault(f"must be {length} finite numbers, got {value!r}.")

    return run


def _lengths(value: tuple[float, float, float]) -> tuple[float, float, float]:
    if min(value) <= 0.0:
        raise fault(f"must be three lengths above 0 m, got {list(value)!r}.")
    return value


def _direction(value: tuple[float, ...]) -> tuple[float, ...]:
    if sum(x * x for x in value) < 1e-24:
        raise fault(f"must not be zero, got {list(value)!r}.")
    return value


def _counts(value: Any) -> tuple[int, ...]:
    if isinstance(value, (list, tuple)) and len(value) == 3:
        try:
            return tuple(checks.integer("", item, minimum=1) for item in value)
        except ValueError:
            pass
    raise fault(f"must be three whole numbers, 1 or more, got {value!r}.")


def _points(value: Any) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, (list, tuple)) or len(value) < 4:
        raise fault("must be four or more points of three numbers each.")
    return tuple(_numbers(3)(item) for item in value)


def _inertia(value: Any) -> tuple[Any, ...]:
    try:
        return _numbers(3)(value)
    except PydanticCustomError:
        pass
    if isinstance(value, (list, tuple)) and len(value) == 3:
        try:
            return tuple(_numbers(3)(row) for row in value)
        except PydanticCustomError:
            pass
    raise fault(f"must be three moments or a tensor of three rows of three numbers, got {value!r}.")


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise fault(f"must be true or false, got {value!r}.")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise fault(f"must be a text that is not empty, got {value!r}.")
    return value


def _name(value: str) -> str:
    if any(character in RESERVED for character in value) or value != value.strip():
        raise fault(f"must be a name without any of {' '.join(RESERVED)} and without blanks around it, got {value!r}.")
    return value


def between(low: float, high: float) -> BeforeValidator:
    """A finite number from ``low`` to ``high``."""

    def run(value: Any) -> float:
        result = checks.number("", value)
        if not low <= result <= high:
            raise fault(f"must be between {low:g} and {high:g}, got {value!r}.")
        return result

    return BeforeValidator(run)


def word(*allowed: str) -> BeforeValidator:
    """One of a closed set of words; the sentence names the nearest one."""
    return BeforeValidator(_bare(checks.one_of, allowed))


def whole(minimum: int) -> BeforeValidator:
    """A whole number, ``minimum`` or more."""
    return BeforeValidator(_bare(checks.integer, minimum=minimum))


def above_zero(unit: str) -> BeforeValidator:
    """A finite number above 0."""
    return BeforeValidator(_bare(checks.positive, unit))


def zero_or_more(unit: str) -> BeforeValidator:
    """A finite number, 0 or more."""
    return BeforeValidator(_bare(checks.non_negative, unit))


Number = Annotated[float, BeforeValidator(_bare(checks.number))]
Vector = Annotated[tuple[float, float, float], BeforeValidator(_numbers(3))]
Direction = Annotated[Vector, AfterValidator(_direction)]
Lengths = Annotated[Vector, AfterValidator(_lengths)]
Quaternion = Annotated[tuple[float, float, float, float], BeforeValidator(_numbers(4)), AfterValidator(_direction)]
Points = Annotated[tuple[tuple[float, float, float], ...], BeforeValidator(_points)]
Inertia = Annotated[
    tuple[float, float, float]
    | tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]],
    BeforeValidator(_inertia),
]
Counts = Annotated[tuple[int, int, int], BeforeValidator(_counts)]
Flag = Annotated[bool, BeforeValidator(_flag)]
Text = Annotated[str, BeforeValidator(_text)]
Name = Annotated[Text, AfterValidator(_name)]

Length = Annotated[float, Field(gt=0.0), above_zero("m")]
Kilograms = Annotated[float, Field(gt=0.0), above_zero("kg")]
Density = Annotated[float, Field(gt=0.0), above_zero("kg/m^3")]
Duration = Annotated[float, Field(gt=0.0), above_zero("s")]
Time = Annotated[float, Field(ge=0.0), zero_or_more("s")]
Speed = Annotated[float, Field(ge=0.0), zero_or_more("m/s")]
Coefficient = Annotated[float, Field(ge=0.0), zero_or_more("")]
Force = Annotated[float, Field(ge=0.0), zero_or_more("N")]
Stiffness = Annotated[float, Field(gt=0.0), above_zero("N/m")]
Pressure = Annotated[float, Field(ge=0.0), zero_or_more("Pa")]
Arm = Annotated[float, Field(ge=0.0), zero_or_more("m")]
Fraction = Annotated[float, Field(ge=0.0, le=1.0), between(0.0, 1.0)]
Frequency = Annotated[float, Field(gt=0.0), above_zero("Hz")]
Ratio = Annotated[float, Field(ge=0.0), zero_or_more("")]
Torque = Annotated[float, Field(ge=0.0), zero_or_more("N m")]


class Table(BaseModel):
    """A table of a scene file: its keys are known, everything else is refused with the nearest known key."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    OTHER_WORDS: ClassVar[dict[str, str]] = {}
    """Words that others use for keys, and that look too different to be near."""

    @classmethod
    def keys(cls) -> list[str]:
        """The keys that a file may use."""
        return [field.alias or name for name, field in cls.model_fields.items()]

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, data: Any) -> Any:
        # Before anything else: a misspelt key is a better thing to hear of than the key that is missing because of it.
        if isinstance(data, dict):
            known = cls.keys()
            for key in data:
                if key not in known:
                    near = checks.nearest_word(key, [*known, *cls.OTHER_WORDS])
                    meant = cls.OTHER_WORDS.get(near, near) if near is not None else None
                    hint = f" (did you mean {meant!r}?)" if meant else f"; known are {', '.join(known)}"
                    raise fault(f"is not a known key{hint}.", key=str(key))
        return data
