"""A pacer: says when frames are due, so that they come at an even rate whatever each of them takes."""

from __future__ import annotations

import time
from collections.abc import Callable

SHORTEST = 2.0 / 3.0
"""Share of the period that lies between two frames at least, while late ones are made up for. Viser sends at most 60
times a second: of two frames that are nearer to each other a client would see only the newer one."""
MOST_LATE = 0.1
"""s by which frames are late at most before they are no longer made up for."""
LEAST_REST = 1e-3
"""s of rest after each frame at least: other threads want to work, too."""


class Pacer:
    """Even times for frames.

    They are a period apart and do not follow from one another: who wakes from its rest a millisecond late in every
    frame, as operating systems and Python's lock have it, would otherwise lose a frame in thirty. A frame that took
    too long shortens the rest, or else the time for the frames after it, until the rate is made up for.

    Args:
        period: s from one frame to the next.
        clock: seconds.

    Example:
        >>> now = 0.0
        >>> pacer = Pacer(0.1, clock=lambda: now)
        >>> now = 0.1 + 0.02  # this one is late,
        >>> pacer.begin(), round(pacer.left(), 6)  # and the next one is due at 0.2 s all the same
        (0.1, 0.08)
    """

    def __init__(self, period: float, clock: Callable[[], float] = time.perf_counter) -> None:
        self._period = period
        self._clock = clock
        self._due = clock() + period
        """When the next frame should begin."""
        self._earliest = self._due
        """When it may, since it must not come too soon after the one before."""

    def begin(self) -> float:
        """A frame begins; how many seconds go by with it.

        This is the period, not what a clock says, which would be a little more and a little less by turns: bodies
        would jerk. Where frames are no longer made up for it is ``MOST_LATE`` more.
        """
        now = self._clock()
        elapsed = self._period
        late = now - self._due
        if late > MOST_LATE:
            elapsed += MOST_LATE
            self._due = now
        self._due += self._period
        self._earliest = max(self._due, now + SHORTEST * self._period)
        return elapsed

    def left(self) -> float:
        """Seconds until the next frame, negative if it is late."""
        return self._earliest - self._clock()

    def rest(self) -> float:
        """Seconds to rest for before the next frame begins."""
        return max(LEAST_REST, self.left())
