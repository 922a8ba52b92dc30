"""Cutting a sweep into batches, each some seconds of work: long enough that handing it over costs nothing, short enough
that all workers end together and that little waits when somebody wants to stop."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from stiction.sweep.points import Point

SECONDS = 2.0
"""Work of a batch."""
MOST_RUNS = 2000
"""Runs of a batch at most, so that its text stays small."""
SHARE = 0.3
"""Of the newest batch in the estimate of how long a run takes."""


class Queue:
    """The runs that wait, and how many of them make a batch.

    Args:
        points: the runs to do, in order.
        count: how many they are.
        workers: how many take from it.
        seconds: that a run takes, as far as is known.
    """

    def __init__(self, points: Iterable[Point], count: int, workers: int, seconds: float) -> None:
        self._points = iter(points)
        self._back: deque[Point] = deque()
        self._left = count
        self._workers = workers
        self.seconds = max(seconds, 1e-6)

    def __len__(self) -> int:
        return self._left

    def take(self) -> list[Point] | None:
        """The next batch, or None when nothing waits."""
        size = max(1, min(int(SECONDS / self.seconds), MOST_RUNS, -(-self._left // (2 * self._workers))))
        batch: list[Point] = []
        while len(batch) < size:
            point = self._back.popleft() if self._back else next(self._points, None)
            if point is None:
                break
            batch.append(point)
        self._left -= len(batch)
        return batch or None

    def put_back(self, points: Sequence[Point]) -> None:
        """Runs of a batch whose worker died; they come next."""
        self._back.extend(points)
        self._left += len(points)

    def learn(self, runs: int, seconds: float) -> None:
        """Note how long a batch took."""
        if runs:
            self.seconds = (1.0 - SHARE) * self.seconds + SHARE * max(seconds / runs, 1e-6)
