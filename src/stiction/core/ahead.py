"""Asking memory for what a loop will need a few turns later.

Rows of manifolds belong to the slots of their pairs, and a loop over pairs meets them in no order: with more manifolds
than the nearest caches hold, each turn would wait for its row some hundred times as long as it takes to compute with
it. The processor foresees what follows in memory, but not this. A question changes nothing but the time.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable

from stiction.core.jit import jit
from stiction.core.lanes import LANES

SINGLE, DOUBLE = 16, 8
"""Numbers that come at once, by their precision. Manifolds in double precision are asked for by halves."""
SOON = 10
"""Turns of a loop over pairs."""
MANY = 2048
"""Rows of so many manifolds do not fit into the nearest caches; with fewer, questions take longer than the answers."""


def ask_for(rows, i, k):
    """Ask for the line of memory in which column k of row i is. No row beyond the last one may be asked for."""


@type_callable(ask_for)
def _type_ask_for(context):
    return lambda rows, i, k: types.void if isinstance(rows, types.Array) else None


@lower_builtin(ask_for, types.Array, types.Integer, types.Integer)
def _lower_ask_for(context, builder, sig, args):
    array = context.make_array(sig.args[0])(context, builder, args[0])
    row, k = (context.cast(builder, x, t, types.intp) for x, t in zip(args[1:], sig.args[1:]))
    place = builder.add(builder.mul(row, builder.extract_value(array.shape, 1)), k)
    byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
    kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
    function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
    # to be written too or not, to be kept, data
    builder.call(function, [builder.bitcast(builder.gep(array.data, [place]), byte), number(0), number(3), number(1)])
    return context.get_dummy_value()


@jit
def ask_for_row(rows, i, width, line):
    """The first ``width`` columns of row i; ``line`` numbers come at once."""
    for k in range(0, width, line):
        ask_for(rows, i, k)
    ask_for(rows, i, width - 1)


@jit
def ask_for_block(index, i, count, rows, width, many):
    """The rows of the manifolds of block i, if there is one, of ``count``, where these rows are ``many``."""
    if i < count and many > MANY:
        for lane in range(LANES):
            ask_for_row(rows, index[i + 2 * count, lane], width, SINGLE)


@jit
def ask_for_bodies(index, i, count, rows, k, many):
    """Column k of the rows of both bodies of the manifolds of block i, if there is one, of ``count``, where the
    manifolds in question are ``many``."""
    if i < count and many > MANY:
        for lane in range(LANES):
            ask_for(rows, index[i, lane], k)
            ask_for(rows, index[i + count, lane], k)


def row_number(i):
    """i, of which the compiler may assume that it is not negative, nor huge: so it leaves out what would have rows
    count from the end, for this index and for the next one."""
    return i


@type_callable(row_number)
def _type_row_number(context):
    return lambda i: i if isinstance(i, types.Integer) else None


@lower_builtin(row_number, types.Integer)
def _lower_row_number(context, builder, sig, args):
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(ir.VoidType(), [ir.IntType(1)]), "llvm.assume"
    )
    builder.call(function, [builder.icmp_unsigned("<", args[0], args[0].type(1 << (args[0].type.width - 2)))])
    return args[0]
