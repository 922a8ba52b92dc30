"""The threads of a world that steps with more than one: they wait beside the leader, and go home when its call ends."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeVar

import numpy as np

from stiction.core import jit, state
from stiction.core.soft_scratch import PAIR_CONTACTS
from stiction.core.soft_step import assist, dismiss
from stiction.core.team import Team, make_team

Result = TypeVar("Result")


class Arrays(NamedTuple):
    """What leader and workers have in common, as :func:`stiction.core.soft_step.assist` takes it."""

    bodies: Any
    kinds: Any
    pairs: Any
    soft: Any
    desk: Any
    table: Any
    boxes_meet: Any
    hulls: Any
    rolls: Any
    laws: Any


class Helpers:
    """Threads besides the calling one, started when they are first asked for."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: ThreadPoolExecutor | None = None
        self._process = -1

    def pool(self) -> ThreadPoolExecutor:
        """The threads; new ones in a process that was forked off, in which the old ones do not live on."""
        if self._pool is None or self._process != os.getpid():
            self._pool = ThreadPoolExecutor(self._count, thread_name_prefix="stiction")
            self._process = os.getpid()
        return self._pool


class Crew:
    """Workers besides the calling thread. They are started with the first call, and end with the crew.

    A crew serves one call at a time: each world has its own.
    """

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self._helpers = Helpers(threads - 1)
        self._ready: set[Any] = set()
        self._scratch = [(*state.make_contacts(PAIR_CONTACTS), np.zeros((state.SCRATCH, 5))) for _ in range(1, threads)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Crew, (self.threads,)

    def lead(self, leader: Callable[[Team | None], Result], arrays: Arrays) -> Result:
        """Call ``leader`` with a team whose other workers are there, working on the same arrays."""
        if self.threads == 1 or jit.config.DISABLE_JIT:
            return leader(None)
        self._compile(arrays)
        team, pool = make_team(self.threads), self._helpers.pool()
        at_work = [
            pool.submit(_assist, arrays, scratch, team, worker) for worker, scratch in enumerate(self._scratch, 1)
        ]
        try:
            return leader(team)
        finally:
            dismiss(team)
            for worker in at_work:
                worker.result()

    def _compile(self, arrays: Arrays) -> None:
        """Have the workers' kernel ready before any of them waits for another: alone, it goes home at once."""
        kind = (arrays.boxes_meet is None, arrays.hulls is None, arrays.rolls is None, arrays.laws is None)
        if kind not in self._ready:
            _assist(arrays, self._scratch[0], make_team(1), 0)
            self._ready.add(kind)


def _assist(arrays: Arrays, scratch: tuple[Any, ...], team: Team, worker: int) -> None:
    bodies, kinds, pairs, soft, desk, table, boxes_meet, hulls, rolls, laws = arrays
    assist(bodies, kinds, pairs, soft, desk, *scratch, table, boxes_meet, hulls, rolls, laws, team, worker)
