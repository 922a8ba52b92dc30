"""Mailbox: what readers did, on its way from the threads of the browser's connections to the one that steps."""

from __future__ import annotations

import threading
from collections.abc import Callable

MOST = 256
"""Letters that wait at most. More come only from someone who floods the box, and are dropped."""


class Mailbox:
    """Actions under keys, carried out later.

    A new action takes the place of an older one with its key: of a slider that is
    dragged only where it is now counts, so that a box that is emptied slowly stays small.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._letters: dict[str, Callable[[], None]] = {}

    def put(self, key: str, action: Callable[[], None]) -> bool:
        """Leave an action; whether it was taken."""
        with self._lock:
            if key not in self._letters and len(self._letters) >= MOST:
                return False
            self._letters.pop(key, None)
            self._letters[key] = action
            return True

    def take(self) -> list[Callable[[], None]]:
        """All actions that wait, in the order in which they came."""
        with self._lock:
            letters, self._letters = self._letters, {}
        return list(letters.values())

    def __len__(self) -> int:
        return len(self._letters)
