"""F64x8: eight doubles that act as one number, as a Numba value type on the LLVM vector <8 x double>.

Only what the proof in ``test_lanes.py`` needs: + - * /, the sign, and rows of an (n, 8) array in and out. No fast-math
flag, so every lane computes what a scalar computes, bit for bit. There is no mixing with scalars and no comparison:
code that needs either does not run in lanes, and that is what the test is to find out.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, overload, register_model

LANES = 8
VECTOR = ir.VectorType(ir.DoubleType(), LANES)


class F64x8Type(types.Type):
    """Type of eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="F64x8")


f64x8: Any = F64x8Type()


@register_model(F64x8Type)
class F64x8Model(models.PrimitiveModel):
    """In a register it is an LLVM vector."""

    def __init__(self, manager: Any, frontend_type: Any) -> None:
        super().__init__(manager, frontend_type, VECTOR)  # type: ignore[no-untyped-call]


def _operator(function: Callable[..., Any], instruction: str) -> None:
    """Make an operator of two F64x8 one LLVM instruction."""

    def typed(typing_context: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return getattr(builder, instruction)(*arguments)

        return f64x8(f64x8, f64x8), generate

    lanewise: Any = intrinsic(typed)

    # numba compares the arguments of an overload and of what it returns, annotations included
    def choose(a, b):  # type: ignore[no-untyped-def]
        if a is f64x8 and b is f64x8:
            return lambda a, b: lanewise(a, b)  # noqa: PLW0108 -- an overload returns a function, not an intrinsic
        return None

    overload(function)(choose)


_operator(operator.add, "fadd")
_operator(operator.sub, "fsub")
_operator(operator.mul, "fmul")
_operator(operator.truediv, "fdiv")


def _typed_negative(typing_context: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fneg(arguments[0])

    return f64x8(f64x8), generate


_negative: Any = intrinsic(_typed_negative)


@overload(operator.neg)
def _neg(a):  # type: ignore[no-untyped-def]
    return (lambda a: _negative(a)) if a is f64x8 else None  # noqa: PLW0108 -- as above


def _address(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Pointer to row i of a C-contiguous (n, 8) array as a vector."""
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    start = builder.mul(arguments[1], arguments[1].type(LANES))
    return builder.bitcast(builder.gep(array.data, [start]), VECTOR.as_pointer())


def _is_rows(array: Any) -> bool:
    return isinstance(array, types.Array) and (array.ndim, array.layout, array.dtype) == (2, "C", types.float64)


def _typed_load(typing_context: Any, rows: Any, i: Any) -> Any:
    if not _is_rows(rows):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = builder.load(_address(context, builder, signature, arguments))
        value.align = 8
        return value

    return f64x8(rows, types.intp), generate


def _typed_store(typing_context: Any, rows: Any, i: Any, value: Any) -> Any:
    if not _is_rows(rows) or value is not f64x8:
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _address(context, builder, signature, arguments)).align = 8
        return context.get_dummy_value()

    return types.void(rows, types.intp, f64x8), generate


load: Any = intrinsic(_typed_load)
"""load(rows, i): row i of an (n, 8) array of doubles. NumPy aligns its rows to 8 bytes, not to 64."""

store: Any = intrinsic(_typed_store)
"""store(rows, i, value): write row i of an (n, 8) array of doubles."""
