"""Kernels in parts: one calls the other by an address, so that each is compiled and cached by itself.

A step that is compiled as a whole has a variant for every combination of what its parts can leave out, and only one
process can work at it. The parts of a step know no more of each other than the types of their arguments, which are
annotations here: ``int``, ``float``, and

Table   an array (rows, columns) of int64: the book, and what goes with it
Number  1.0 in the precision of the solver
Crew    None or a :class:`stiction.core.team.Team`
Switch  None or 1, for a branch that is left out or compiled. It is no argument of the machine code: whoever has the
        address has chosen, and whoever calls it need not know

A part returns an int. An exception in it goes on to its caller, as from any function.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple, TypeAlias

import numba
from numba import extending
from numba.core import types

from stiction.core.jit import config
from stiction.core.team import Team, make_team

intrinsic: Any = extending.intrinsic  # called with one argument less than it is written with

Table: TypeAlias = Any
Number: TypeAlias = Any
Crew: TypeAlias = Any
Switch: TypeAlias = Any
PAGES = types.Array(types.int64, 2, "C")


class Variant(NamedTuple):
    """What a kernel is compiled for; a kernel leaves out of account what it has no argument for."""

    double: bool
    team: bool
    on: tuple[str, ...] = ()  # switches that are 1


def signature(kernel: Any, variant: Variant) -> tuple[Any, ...]:
    """Types of the arguments of a kernel."""
    kinds = {
        "int": types.int64,
        "float": types.float64,
        "Table": PAGES,
        "Number": types.float64 if variant.double else types.float32,
        "Crew": numba.typeof(make_team(1)) if variant.team else types.none,
    }
    # an argument that is left out has a value, by which branches are pruned, and no place in machine code
    return tuple(
        types.Omitted(1 if name in variant.on else None) if kind == "Switch" else kinds[kind]
        for name, kind in kernel.py_func.__annotations__.items()
        if name != "return"
    )


def address_of(kernel: Any, variant: Variant) -> Any:
    """Where the machine code of a variant begins, compiled or loaded first if need be; in plain Python the function."""
    if config.DISABLE_JIT:
        switches = [name for name, kind in kernel.__annotations__.items() if kind == "Switch"]
        return functools.partial(kernel, **{name: 1 if name in variant.on else None for name in switches})
    types_of = signature(kernel, variant)
    kernel.compile(types_of)
    overload = kernel.overloads[types_of]
    if types.unliteral(overload.signature.return_type) != types.int64:
        raise TypeError(f"{kernel.py_func.__name__} must return an int, not {overload.signature.return_type}")
    return overload.library.get_pointer_to_function(overload.fndesc.llvm_func_name)


def caller(kernel: Any) -> Any:
    """What calls a variant of a kernel: a function of its address and of the tuple of all arguments but switches.

    Types that the kernel was not declared with are refused when the call is compiled; precision and team must be those
    of the variant.
    """
    if config.DISABLE_JIT:
        return lambda function, arguments: function(*arguments)
    declared = {name: kind for name, kind in kernel.py_func.__annotations__.items() if kind != "Switch"}
    declared.pop("return")

    @intrinsic
    def call(typing, address, arguments):
        given = [types.unliteral(one) for one in arguments]
        if len(given) != len(declared):
            raise numba.TypingError(f"{len(declared)} arguments are wanted, not {len(given)}: {', '.join(declared)}")
        for (name, kind), one in zip(declared.items(), given, strict=True):
            if not _fits(kind, one):
                raise numba.TypingError(f"{name} must be {kind}, not {one}")

        def make(context, builder, signature, args):
            convention = context.call_conv
            kind = convention.get_function_type(types.int64, given)
            function = builder.inttoptr(args[0], kind.as_pointer())
            values = [
                context.cast(builder, builder.extract_value(args[1], k), one, to)
                for k, (one, to) in enumerate(zip(arguments, given, strict=True))
            ]
            status, result = convention.call_function(builder, function, types.int64, given, values)
            with builder.if_then(status.is_error, likely=False):
                convention.return_status_propagate(builder, status)
            return result

        return types.int64(types.int64, arguments), make

    return call


def _fits(kind: str, one: Any) -> bool:
    """Whether an argument of this type may be what it is declared to be."""
    if kind == "Crew":
        return one == types.none or getattr(one, "instance_class", None) is Team
    wanted = {
        "int": (types.int64,), "float": (types.float64,), "Table": (PAGES,), "Number": (types.float32, types.float64),
    }  # fmt: skip
    return one in wanted[kind]
