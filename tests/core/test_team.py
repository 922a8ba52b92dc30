"""The barrier, shares and pieces of threads that do a step together."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from stiction.core import jit
from stiction.core.jit import entry
from stiction.core.team import FIND, HOME, JOB, PIECE, add_to, call, make_team, meet, share, take_piece

from .support import compiled

needs_threads = pytest.mark.skipif(bool(jit.config.DISABLE_JIT), reason="plain Python has no teams")


@entry
def lead(team, rounds, seen):
    """Call everybody ``rounds`` times, and count what has been done when each is over."""
    for r in range(rounds):
        call(team, FIND, r, 0, 0, 0.0, 0.0)
        meet(team)
        seen[r] = team.words[-1]
    call(team, HOME, 0, 0, 0, 0.0, 0.0)


@entry
def follow(team):
    """Do one thing a round, until there are no more; returns how many."""
    done = 0
    while True:
        meet(team)
        if team.words[JOB] == HOME:
            return done
        add_to(team.words, -1 + len(team.words), 1)
        done += 1
        meet(team)


@needs_threads
@pytest.mark.parametrize("workers", [2, 3, 4])
def test_nobody_goes_on_before_all_are_there(workers: int) -> None:
    rounds = 200
    seen = np.zeros(rounds, np.int64)
    follow(make_team(1))  # alone it goes home at once: compiled before anybody waits
    team, done = make_team(workers), []
    others = [threading.Thread(target=lambda: done.append(follow(team))) for _ in range(workers - 1)]
    for other in others:
        other.start()
    lead(team, rounds, seen)
    for other in others:
        other.join(60)
    assert done == [rounds] * (workers - 1)
    np.testing.assert_array_equal(seen, (workers - 1) * np.arange(1, rounds + 1))


@pytest.mark.parametrize("workers", [1, 2, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 1000])
def test_shares_are_neighbours_that_leave_nothing_out(workers: int, count: int) -> None:
    team, end = make_team(workers), 5
    for worker in range(workers):
        first, last = compiled(share)(team, worker, 5, count)
        assert first == end <= last
        assert last - first in {count // workers, count // workers + 1}
        end = last
    assert end == 5 + count
    assert compiled(share)(None, 0, 5, count) == (5, 5 + count)


@needs_threads
@pytest.mark.parametrize("count", [0, 1, PIECE, PIECE + 1, 1000])
def test_pieces_are_taken_once(count: int) -> None:
    team, taken = make_team(2), []
    first, last = compiled(take_piece)(team, 0, count)
    while first < last:
        taken += range(first, last)
        first, last = compiled(take_piece)(team, 0, count)
    assert taken == list(range(count))
    assert compiled(take_piece)(None, 0, count) == (0, count)
    assert compiled(take_piece)(None, 1, count) == (0, 0)
