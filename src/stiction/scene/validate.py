"""From plain data to a checked scene table; what is wrong first becomes one sentence that begins with its path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from stiction.errors import InvalidInputError
from stiction.scene.model import SHAPES, SceneTable

# What pydantic says itself, where none of the fields' own checks comes first.
_SENTENCES = {
    "missing": "must be given.",
    "model_type": "must be a table of keys and values, got {input!r}.",
    "model_attributes_type": "must be a table of keys and values, got {input!r}.",
    "dict_type": "must be a table of keys and values, got {input!r}.",
    "tuple_type": "must be a list of tables, got {input!r}.",
}


Model = TypeVar("Model", bound=BaseModel)


def validate(data: Mapping[str, Any]) -> SceneTable:
    """The scene table that ``data`` holds.

    Raises:
        InvalidInputError: ``bodies[3].shape.size: must be …``.
    """
    return validate_as(SceneTable, data, "the scene")


def validate_as(model: type[Model], data: Mapping[str, Any], whole: str) -> Model:
    """The table that ``data`` holds, by this model.

    Args:
        model: what it must be.
        data: plain data.
        whole: what a sentence calls the whole of it, where no key is at fault.

    Raises:
        InvalidInputError: one sentence that begins with the path of the key.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
    raise InvalidInputError(_sentence(first, whole)) from None


def sentences_of(model: type[BaseModel], data: Mapping[str, Any], whole: str) -> list[str]:
    """All that is wrong with ``data`` by this model, as far as one reading shows it: see :func:`validate_as`."""
    try:
        model.model_validate(data)
    except ValidationError as error:
        return [_sentence(one, whole) for one in error.errors(include_url=False)]
    return []


def _sentence(error: Mapping[str, Any], whole: str) -> str:
    context = error.get("ctx", {})
    location = list(error["loc"])
    if error["type"] == "scene":
        text = context["sentence"]
        if context["key"] is not None:
            location.append(context["key"])
    elif error["type"] == "value_error":
        text = str(context["error"]).strip()
    else:
        text = _SENTENCES.get(error["type"], "{message}.").format(input=error["input"], message=error["msg"])
    path = path_text(location)
    return f"{path}: {text}" if path else f"{whole} {text}"


def path_text(location: Sequence[str | int]) -> str:
    """``bodies[3].shape.size`` for ``("bodies", 3, "shape", "box", "size")``: pydantic names the kind of shape, too."""
    text = ""
    for before, part in zip((None, *location), location, strict=False):
        if (before == "shape" and part in SHAPES) or part == "[key]":
            continue
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text
