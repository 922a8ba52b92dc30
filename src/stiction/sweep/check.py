"""Every mistake of a sweep's file at once."""

from __future__ import annotations

import tomllib
from pathlib import Path

from stiction.scene.check import Data, Finding, check, faults_of
from stiction.scene.load import find_syntax_fault
from stiction.sweep.load import from_dict
from stiction.sweep.spec import SweepTable


def is_sweep(text: str) -> bool:
    """Whether a text is meant as a sweep: it has parameters, or names a scene."""
    if find_syntax_fault(text) is not None:
        return "[[parameters]]" in text
    return bool({"parameters", "scene", "metrics"} & set(tomllib.loads(text)))


def check_sweep(text: str, file: str) -> list[Finding]:
    """All mistakes of the text of a sweep's file, in the order of the file.

    Args:
        text: TOML.
        file: its name; the path of a scene counts from its folder.
    """

    def read(data: Data) -> list[str]:
        return faults_of(SweepTable, "the sweep", data, lambda: from_dict(data, Path(file).stem, Path(file).parent))

    return check(text, file, read).findings
