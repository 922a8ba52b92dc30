"""Threads that do a step together: the words they share, the barrier at which they meet, and who does what.

One of them, the leader, runs the step; the others wait at the barrier until it has written down a job, do their share
of it, and meet it again. A share depends on nothing but the number of the worker, or does not matter: what is done at
the same time touches different rows. So the bits are the same for any number of threads.

In plain Python (``NUMBA_DISABLE_JIT=1``) there are no teams. Where ``team`` is None, all of this is compiled away.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import extending
from numba.core import cgutils, types

from stiction.core.jit import jit

intrinsic: Any = extending.intrinsic  # called with one argument less than it is written with

LINE = 8
"""Words of a cache line: what threads write at the same time lies in lines of its own."""
ARRIVED, TURN, NEXT = 0, LINE, 2 * LINE
JOB, WORKERS, COUNT, MANY, SUBSTEPS = (3 * LINE + k for k in range(5))
WORDS = 4 * LINE
"""Words: workers that wait at the barrier; how often it has opened; the next piece of the job that nobody has taken;
what to do; number of workers; of pieces of the job, or which piece of the world; of manifolds; of substeps."""

HOME, SOLVE, FIND = range(3)
"""Jobs: go home, take part in the passes of the solver, take part in finding manifolds."""

PIECE = 32
"""Manifolds that a worker takes at a time; few enough that none waits for long, and many enough to share no line."""
PATIENCE = 2000
"""Looks at the barrier before a worker lets other threads of the machine run."""


class Team(NamedTuple):
    """What the workers share."""

    words: np.ndarray  # (WORDS,) int64
    numbers: np.ndarray  # (2,) of a job: the length of a substep, s, and 1 if a manifold is new; or the slow speed, m/s


def make_team(workers: int) -> Team:
    """The words of a team of so many workers, the leader among them."""
    team = Team(np.zeros(WORDS, np.int64), np.zeros(2))
    team.words[WORKERS] = workers
    return team


def _word(context, builder, signature, args):
    """Pointer to the word that the first two arguments of an intrinsic name."""
    array = context.make_array(signature.args[0])(context, builder, args[0])
    return builder.gep(array.data, [args[1]])


@intrinsic
def add_to(typing, words, k, x):
    """Add x to word k at once, whoever else does; returns what it was before."""

    def make(context, builder, signature, args):
        return builder.atomic_rmw("add", _word(context, builder, signature, args), args[2], "seq_cst")

    return types.int64(words, types.int64, types.int64), make


@intrinsic
def read(typing, words, k):
    """Word k as others have left it, and all they had written before that."""

    def make(context, builder, signature, args):
        return builder.load_atomic(_word(context, builder, signature, args), "seq_cst", 8)

    return types.int64(words, types.int64), make


@intrinsic
def write(typing, words, k, x):
    """Set word k, after all that was written before."""

    def make(context, builder, signature, args):
        builder.store_atomic(args[2], _word(context, builder, signature, args), "seq_cst", 8)
        return context.get_dummy_value()

    return types.void(words, types.int64, types.int64), make


@intrinsic
def give_way(typing):
    """Let another thread run, where the system has a call for it."""

    def make(context, builder, signature, args):
        if os.name == "posix":
            kind = ir.FunctionType(ir.IntType(32), [])
            builder.call(cgutils.get_or_insert_function(builder.module, kind, "sched_yield"), [])
        return context.get_dummy_value()

    return types.void(), make


@jit
def meet(team):
    """Wait until all workers are here."""
    if team is not None:
        words = team.words
        turn = read(words, TURN)
        if add_to(words, ARRIVED, 1) + 1 == words[WORKERS]:
            write(words, ARRIVED, 0)
            add_to(words, TURN, 1)
        else:
            looks = 0
            while read(words, TURN) == turn:
                looks += 1
                if looks > PATIENCE:
                    give_way()


@jit
def call(team, job, count, many, substeps, one, other):
    """Write down a job with its numbers, and begin it together with the others."""
    if team is not None:
        words = team.words
        words[JOB], words[COUNT], words[MANY], words[SUBSTEPS] = job, count, many, substeps
        team.numbers[0], team.numbers[1] = one, other
        words[NEXT] = 0
        meet(team)


@jit
def share(team, worker, first, count):
    """The worker's part of ``count`` neighbours from ``first`` on: its first, and the one behind its last."""
    if team is None:
        return first, first + count
    workers = team.words[WORKERS]
    return first + count * worker // workers, first + count * (worker + 1) // workers


@jit
def take_piece(team, piece, count):
    """The next piece of ``count`` things: its first, and the one behind its last, no more than the first if all are
    taken. ``piece`` counts the pieces of a leader that is alone."""
    if team is None:
        return (0, count) if piece == 0 else (0, 0)
    first = PIECE * add_to(team.words, NEXT, 1)
    return first, min(first + PIECE, count)
