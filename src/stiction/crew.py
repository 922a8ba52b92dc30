"""The threads of a world that steps with more than one: they wait beside the leader, and go home when its call ends."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from stiction.core import jit, state
from stiction.core.soft_book import book_of_worker
from stiction.core.soft_entry import assist, dismiss
from stiction.core.soft_scratch import PAIR_CONTACTS
from stiction.core.team import Team, make_team

Result = TypeVar("Result")


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
        self._scratch = [(*state.make_contacts(PAIR_CONTACTS), np.zeros((state.SCRATCH, 5))) for _ in range(1, threads)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Crew, (self.threads,)

    def lead(self, leader: Callable[[Team | None], Result], book: Any, one: Any) -> Result:
        """Call ``leader`` with a team whose other workers are there, with the same book; ``one`` is 1 in the precision
        of the solver. Their kernels have been prepared."""
        if self.threads == 1 or jit.config.DISABLE_JIT:
            return leader(None)
        team, pool = make_team(self.threads), self._helpers.pool()
        at_work = [
            pool.submit(assist, book_of_worker(book, *scratch), one, team, worker)
            for worker, scratch in enumerate(self._scratch, 1)
        ]
        try:
            return leader(team)
        finally:
            dismiss(team)
            for worker in at_work:
                worker.result()
