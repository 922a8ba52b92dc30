"""From plain data to a checked scene table; what is wrong first becomes one sentence that begins with its path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

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


def validate(data: Mapping[str, Any]) -> SceneTable:
    """The scene table that ``data`` holds.

    Raises:
        InvalidInputError: ``bodies[3].shape.size: must be …``.
    """
    try:
        return SceneTable.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
    raise InvalidInputError(_sentence(first)) from None


def _sentence(error: Mapping[str, Any]) -> str:
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
    return f"{path}: {text}" if path else f"the scene {text}"


def path_text(location: Sequence[str | int]) -> str:
    """``bodies[3].shape.size`` for ``("bodies", 3, "shape", "box", "size")``: pydantic names the kind of shape, too."""
    text = ""
    for before, part in zip((None, *location), location, strict=False):
        if (before == "shape" and part in SHAPES) or part == "[key]":
            continue
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text
