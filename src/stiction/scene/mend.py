"""Plain data without its faults, so that the next ones show.

What is wrong is renamed, replaced by something harmless or taken out, and nothing else changes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from stiction.scene.positions import Location

UNKNOWN, MISSING = "is not a known key", "must be given"
"""What sentences say of a key that is not known, and of one that is not there."""

BOX = {"type": "box", "size": [1.0, 1.0, 1.0]}
HARMLESS: dict[str, Any] = {
    "title": "a title", "expect": "A sentence.", "duration": 1.0, "shape": BOX, "stiffness": 1e-9, "time": 0.0,
    "force": [0.0, 0.0, 0.0], "anchor": [0.0, 0.0, 0.0], "a": "default", "b": "default",
}  # fmt: skip
"""What stands in for a value that must be there."""
KEPT = ("name", "static", "kinematic", "grid")
"""Of a body that cannot be built: what others may ask of it."""

_GONE = object()
"""Marks an entry of a list that is taken out when all faults of a reading are mended."""


def suggestion_in(words: str) -> str | None:
    """What a sentence supposes was meant: see :func:`stiction.checks.nearest`."""
    found = re.search(r"\(did you mean '(.*?)'\?\)", words)
    return found[1] if found else None


class Mender:
    """Mends data, and remembers where in them everything was at first.

    Args:
        data: plain data, changed in place.
    """

    def __init__(self, data: dict[str, Any]) -> None:
        self.data = data
        self._numbers: dict[Location, list[int]] = {}
        self._names: dict[Location, str] = {}
        self._removed: set[Location] = set()
        self._made = 0

    def original(self, location: Location) -> Location:
        """Where that was before anything was mended."""
        found: Location = ()
        for depth, part in enumerate(location):
            numbers = self._numbers.get(location[:depth], [])
            here = (*found, numbers[part] if isinstance(part, int) and part < len(numbers) else part)
            found = (*found, self._names.get(here, here[-1]))
        return found

    def is_fallout(self, location: Location, words: str) -> bool:
        """Whether this is only wrong because something was taken out here."""
        return words.startswith(MISSING) and self.original(location) in self._removed

    def mend(self, faults: Sequence[tuple[Location, str]]) -> bool:
        """Mend all of these, found in one reading of the data; False if there was nothing to be done."""
        done = [self._mend(location, words) for location, words in faults]
        self._drop(self.data, ())
        return any(done)

    def _mend(self, location: Location, words: str) -> bool:
        if not location:
            return False
        if words.startswith(UNKNOWN):
            return self._rename(location, suggestion_in(words))
        base = 1 if location[0] == "scene" and len(location) > 1 else 0  # of a sweep
        inner = location[base:]
        first = next((depth for depth, part in enumerate(inner) if isinstance(part, int)), None)
        depth = base + (first + 1 if first is not None else min(2 if inner[0] == "frames" else 1, len(inner) - 1))
        if first is None and len(inner) > 1 and inner[0] not in ("frames", "world", "materials"):
            depth = base
        table = self._at(location[:depth])
        if len(location) == depth:
            return self._replace(location)
        key = location[depth]
        if not isinstance(table, dict) or not isinstance(key, str):
            return self._replace(location[:depth])
        if inner[0] == "frames" and depth == base + 2 - 1:
            return self._forget_frame(table, key, location[:base])
        if key == "name":
            self._made += 1
            table[key] = f"{self._made} without a name"
        elif key in HARMLESS and table.get(key) != HARMLESS[key]:
            table[key] = HARMLESS[key]
        elif key in table:
            del table[key]
            self._removed.add(self.original(location[: depth + 1]))
        else:
            return self._replace(location[:depth])
        return True

    def _rename(self, location: Location, meant: str | None) -> bool:
        table, key = self._at(location[:-1]), location[-1]
        if not isinstance(table, dict) or key not in table:
            return False
        value = table.pop(key)
        if meant is not None and meant not in table:
            table[meant] = value
            self._names[(*self.original(location[:-1]), meant)] = str(key)
        return True

    def _replace(self, location: Location) -> bool:
        """Put something harmless there, or take it out of its list."""
        if not location:
            return False
        around, key = self._at(location[:-1]), location[-1]
        if not isinstance(around, (dict, list)):
            return False
        old = self._at(location)
        kind = location[-2] if len(location) > 1 else None
        if isinstance(around, dict):
            around.pop(key, None)
        elif isinstance(key, str):
            return False
        elif old is _GONE:
            return True
        elif kind == "bodies":
            kept = {name: old[name] for name in KEPT if name in old} if isinstance(old, dict) else {}
            self._made += 1
            around[key] = {"name": f"{self._made} without a name", "shape": BOX, **kept}
        elif kind == "pairs" and isinstance(old, dict) and {"a", "b"} <= set(old):
            around[key] = {"a": old["a"], "b": old["b"], "static": 0.5, "dynamic": 0.5}
        else:
            around[key] = _GONE
        return True

    def _forget_frame(self, frames: dict[str, Any], name: str, base: Location) -> bool:
        """Take out a frame, and what is placed in it becomes placed in the world."""
        if frames.pop(name, None) is None:
            return False
        scene = self._at(base)
        for entries in scene.values():
            for entry in entries if isinstance(entries, list) else ():
                if isinstance(entry, dict) and entry.get("frame") == name:
                    del entry["frame"]
        return True

    def _at(self, location: Location) -> Any:
        node: Any = self.data
        for part in location:
            try:
                node = node[part]
            except (KeyError, IndexError, TypeError):
                return None
        return node

    def _drop(self, node: Any, location: Location) -> None:
        """Take out the marked entries of all lists, and keep count of where the others were."""
        if isinstance(node, dict):
            for key, value in node.items():
                self._drop(value, (*location, key))
        elif isinstance(node, list) and any(entry is _GONE for entry in node):
            numbers = self._numbers.get(location) or list(range(len(node)))
            self._numbers[location] = [k for k, entry in zip(numbers, node, strict=True) if entry is not _GONE]
            node[:] = [entry for entry in node if entry is not _GONE]
        elif isinstance(node, list):
            for number, entry in enumerate(node):
                self._drop(entry, (*location, number))
