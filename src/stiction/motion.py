"""What a body is doing, in one word: the classes that tables, colours and recordings share."""

from __future__ import annotations

from enum import IntEnum


class Motion(IntEnum):
    """State of motion of a body, judged from its contacts."""

    FIXED = 0
    """Static or kinematic."""
    FREE = 1
    """Touches nothing."""
    STICKING = 2
    """Touches, and no contact point of it slides or rolls."""
    SLIDING = 3
    """At least one contact point slides."""
    ROLLING = 4
    """No contact point slides, and the body turns over a contact that holds."""

    @property
    def word(self) -> str:
        """Lower-case name for tables."""
        return self.name.lower()
