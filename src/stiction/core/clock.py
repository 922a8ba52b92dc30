"""The time of the stages of a step: the processor's cycle counter, read from inside a kernel (some 10 ns a reading).

Cycles are turned into seconds by whoever reads the profile, who knows how long the whole call took.
"""

from __future__ import annotations

import time

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable

from stiction.core.jit import jit

STAGES = (
    "bodies: poses, bounds",
    "broad phase: pairs",
    "narrow phase: manifolds",
    "colours, blocks, islands",
    "prepare, warm start",
    "substeps: contacts",
    "substeps: bodies",
    "restitution, store",
    "finish: positions, sleep",
)
"""What a step does, in order; a profile has one sum of cycles for each, and the last reading behind them."""


def cycles():
    """The processor's cycle counter (in plain Python: nanoseconds)."""
    return time.perf_counter_ns()


@type_callable(cycles)
def _type_cycles(context):
    return lambda: types.int64


@lower_builtin(cycles)
def _lower_cycles(context, builder, sig, args):
    kind = ir.FunctionType(ir.IntType(64), [])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.readcyclecounter"), [])


@jit
def start_clock(profile):
    """Read the counter: what follows is the first stage."""
    profile[-1] = cycles()


@jit
def lap(profile, stage):
    """Enter what went by since the last reading under ``stage``."""
    now = cycles()
    profile[stage] += now - profile[-1]
    profile[-1] = now
