"""F32x8 and F64x8: eight numbers that act as one, so that the functions of ``vec.py`` and of the solver run on eight
contacts at once.

A value is an LLVM vector ``<8 x float>`` or ``<8 x double>``; an operator is one vector instruction (two, where the
machine's registers are half as wide). Scalars mix with lanes and are the same in all of them. A comparison gives a
mask, ``select`` chooses by it lane by lane; nothing branches on a value but ``any_of`` and ``all_of``, which say
whether a branch is worth taking for some of the eight.

Every function here also has a body in plain Python, which is what runs under ``NUMBA_DISABLE_JIT=1``: there a value
is a :class:`Lanes`, eight numbers in an array. The compiled twin is attached to the same name below.

Operators may be contracted to a fused multiply-add, which rounds once instead of twice; nothing else is relaxed: not
the order of sums, and NaN stays NaN.
"""

from __future__ import annotations

import operator

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model, type_callable

LANES = 8

# --- plain Python ----------------------------------------------------------------------------------------------------


class Lanes:
    """Eight numbers, or eight truth values, in plain Python."""

    __slots__ = ("values",)

    def __init__(self, values):
        self.values = values

    def __repr__(self):
        return f"Lanes({self.values})"

    def _with(self, function, other):
        other = other.values if isinstance(other, Lanes) else other
        if isinstance(other, float | int) and self.values.dtype != np.bool_:
            other = self.values.dtype.type(other)
        with np.errstate(all="ignore"):
            return Lanes(function(self.values, other))

    def __add__(self, other):
        return self._with(np.add, other)

    def __sub__(self, other):
        return self._with(np.subtract, other)

    def __mul__(self, other):
        return NotImplemented if isinstance(other, tuple) else self._with(np.multiply, other)  # lanes * Vec3 is Vec3's

    def __truediv__(self, other):
        return self._with(np.divide, other)

    def __radd__(self, other):
        return self._with(np.add, other)

    def __rsub__(self, other):
        return self._with(lambda a, b: b - a, other)

    def __rmul__(self, other):
        return self._with(np.multiply, other)

    def __rtruediv__(self, other):
        return self._with(lambda a, b: b / a, other)

    def __neg__(self):
        return Lanes(-self.values)

    def __lt__(self, other):
        return self._with(np.less, other)

    def __le__(self, other):
        return self._with(np.less_equal, other)

    def __gt__(self, other):
        return self._with(np.greater, other)

    def __ge__(self, other):
        return self._with(np.greater_equal, other)

    def __and__(self, other):
        return self._with(np.logical_and, other)

    def __or__(self, other):
        return self._with(np.logical_or, other)

    def __invert__(self):
        return Lanes(~self.values)


def load(rows, i):
    """Row i of an (n, 8) array: eight neighbours in memory, one a lane."""
    return Lanes(rows[i].copy())


def store(rows, i, value):
    """Write row i of an (n, 8) array."""
    rows[i] = value.values


def load_part(rows, i, k):
    """Columns k to k + 7 of row i of a wider array, one a lane."""
    return Lanes(rows[i, k : k + LANES].copy())


def store_part(rows, i, k, value):
    """Write columns k to k + 7 of row i."""
    rows[i, k : k + LANES] = value.values


def splat(rows, x):
    """The scalar x in all lanes, in the precision of the array ``rows``."""
    return Lanes(np.full(LANES, x, rows.dtype))


def gather(rows, index, i, k):
    """Columns k to k + 7 of the eight rows that row i of ``index`` names, as eight values: value j is column k + j.

    Eight loads and an 8 x 8 transposition (24 shuffles), about a quarter of what 64 single loads cost.
    """
    block = rows[index[i], k : k + LANES]
    return tuple(Lanes(block[:, j].copy()) for j in range(LANES))


def scatter(rows, index, i, k, values):
    """The inverse of ``gather``. Where two lanes name the same row, the later one is what remains."""
    for lane in range(LANES):
        for j in range(LANES):
            rows[index[i, lane], k + j] = values[j].values[lane]


def sqrt(x):
    """Square root, of lanes or of a number."""
    with np.errstate(all="ignore"):
        return Lanes(np.sqrt(x.values)) if isinstance(x, Lanes) else np.sqrt(x)


def least(a, b):
    """The smaller of two, lane by lane; b where one of them is NaN."""
    return select(a < b, a, b)


def greatest(a, b):
    """The larger of two, lane by lane; b where one of them is NaN."""
    return select(a > b, a, b)


def size_of(x):
    """|x| lane by lane."""
    return Lanes(np.abs(x.values)) if isinstance(x, Lanes) else abs(x)


def select(mask, a, b):
    """a where the mask is true, else b; a number is the same in all lanes."""
    if not isinstance(mask, Lanes):
        return a if mask else b
    kind = a.values.dtype if isinstance(a, Lanes) else b.values.dtype
    a, b = (x.values if isinstance(x, Lanes) else x for x in (a, b))
    return Lanes(np.where(mask.values, a, b).astype(kind))


def any_of(mask):
    """Whether the mask is true in some lane."""
    return bool(mask.values.any()) if isinstance(mask, Lanes) else bool(mask)


def all_of(mask):
    """Whether the mask is true in all lanes."""
    return bool(mask.values.all()) if isinstance(mask, Lanes) else bool(mask)


# --- compiled: the types ---------------------------------------------------------------------------------------------

I32 = ir.IntType(32)
FLAGS = ("contract",)


class LaneType(types.Type):
    """Type of eight numbers of one precision."""

    def __init__(self, name, scalar, llvm_scalar):
        self.scalar = scalar
        self.llvm_scalar = llvm_scalar
        self.vector = ir.VectorType(llvm_scalar, LANES)
        super().__init__(name=name)


class MaskType(types.Type):
    """Type of eight truth values."""

    def __init__(self):
        super().__init__(name="Mask8")


F32x8 = LaneType("F32x8", types.float32, ir.FloatType())
F64x8 = LaneType("F64x8", types.float64, ir.DoubleType())
MASK = MaskType()
MASK_VECTOR = ir.VectorType(ir.IntType(1), LANES)
LANE_TYPES = {types.float32: F32x8, types.float64: F64x8}


@register_model(LaneType)
class LaneModel(models.PrimitiveModel):
    """In a register it is an LLVM vector."""

    def __init__(self, manager, frontend_type):
        super().__init__(manager, frontend_type, frontend_type.vector)


@register_model(MaskType)
class MaskModel(models.PrimitiveModel):
    """A bit a lane."""

    def __init__(self, manager, frontend_type):
        super().__init__(manager, frontend_type, MASK_VECTOR)


def _spread(builder, vector, scalar):
    first = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar, ir.Constant(I32, 0))
    zeros = ir.Constant(ir.VectorType(I32, LANES), [0] * LANES)
    return builder.shuffle_vector(first, ir.Constant(vector, ir.Undefined), zeros)


def _as_lanes(context, builder, value, kind, lanes):
    """An operand as lanes: itself, or a scalar in all of them."""
    if isinstance(kind, LaneType):
        return value
    return _spread(builder, lanes.vector, context.cast(builder, value, kind, lanes.scalar))


def _common(args):
    """The lane type of two operands of which one may be a scalar, or None."""
    lanes = {t for t in args if isinstance(t, LaneType)}
    others = [t for t in args if not isinstance(t, LaneType)]
    if len(lanes) == 1 and all(isinstance(t, types.Float | types.Integer) for t in others):
        return lanes.pop()
    return None


# --- compiled: operators. As templates, so that one costs no function of its own: compiling them takes a tenth --------


def _binary(function, result, emit):
    """Make ``function`` of two lanes, or of lanes and a scalar, the instruction that ``emit`` writes."""

    class Template(AbstractTemplate):
        def generic(self, args, kws):
            lanes = _common(args) if len(args) == 2 else None
            return None if lanes is None else signature(result or lanes, *args)

    infer_global(function)(Template)

    def lower(context, builder, sig, args):
        lanes = _common(sig.args)
        a, b = (_as_lanes(context, builder, v, t, lanes) for v, t in zip(args, sig.args))
        return emit(builder, a, b)

    for left, right in (
        (LaneType, LaneType), (LaneType, types.Float), (LaneType, types.Integer), (types.Float, LaneType),
        (types.Integer, LaneType),
    ):  # fmt: skip
        lower_builtin(function, left, right)(lower)


for _op, _name in ((operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv")):
    _binary(_op, None, lambda builder, a, b, name=_name: getattr(builder, name)(a, b, flags=FLAGS))
for _op, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _binary(_op, MASK, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


def _pick(sign):
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(sign, a, b), a, b)


def _typed(function, kind):
    """Give a function that has a template for scalars elsewhere, or none, the typing of ``kind(args)``."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, args, kws):
            result = kind(args)
            return None if result is None else signature(result, *args)

    infer_global(function)(Template)


def _binary_named(function, sign):
    def kind(args):
        if len(args) != 2:
            return None
        if all(isinstance(t, types.Float) for t in args):
            return max(args, key=lambda t: t.bitwidth)
        return _common(args)

    _typed(function, kind)
    emit = _pick(sign)

    def lower(context, builder, sig, args):
        lanes = _common(sig.args)
        if lanes is None:
            return emit(builder, *(context.cast(builder, v, t, sig.return_type) for v, t in zip(args, sig.args)))
        return emit(builder, *(_as_lanes(context, builder, v, t, lanes) for v, t in zip(args, sig.args)))

    for left, right in (
        (LaneType, LaneType), (LaneType, types.Float), (types.Float, LaneType), (types.Float, types.Float),
        (LaneType, types.Integer), (types.Integer, LaneType),
    ):  # fmt: skip
        lower_builtin(function, left, right)(lower)


_binary_named(least, "<")
_binary_named(greatest, ">")


def _unary(function, intrinsic):
    _typed(function, lambda args: args[0] if len(args) == 1 and isinstance(args[0], LaneType | types.Float) else None)

    def lower(context, builder, sig, args):
        kind = args[0].type
        scalar = kind.element if isinstance(kind, ir.VectorType) else kind
        bits = "f32" if isinstance(scalar, ir.FloatType) else "f64"
        name = f"llvm.{intrinsic}.v8{bits}" if isinstance(kind, ir.VectorType) else f"llvm.{intrinsic}.{bits}"
        return builder.call(cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), name), args)

    lower_builtin(function, LaneType)(lower)
    lower_builtin(function, types.Float)(lower)


_unary(sqrt, "sqrt")
_unary(size_of, "fabs")

_typed(operator.neg, lambda args: args[0] if isinstance(args[0], LaneType) else None)


@lower_builtin(operator.neg, LaneType)
def _lower_neg(context, builder, sig, args):
    return builder.fneg(args[0])


for _op, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _typed(_op, lambda args: MASK if all(t is MASK for t in args) else None)
    lower_builtin(_op, MaskType, MaskType)(
        lambda context, builder, sig, args, name=_name: getattr(builder, name)(*args)
    )
_typed(operator.invert, lambda args: MASK if args[0] is MASK else None)


@lower_builtin(operator.invert, MaskType)
def _lower_invert(context, builder, sig, args):
    return builder.not_(args[0])


# --- compiled: choosing ----------------------------------------------------------------------------------------------


@type_callable(select)
def _type_select(context):
    def typer(mask, a, b):
        if mask is MASK:
            return MASK if a is MASK and b is MASK else _common((a, b))
        if isinstance(mask, types.Boolean) and isinstance(a, types.Float) and isinstance(b, types.Float):
            return max((a, b), key=lambda t: t.bitwidth)
        return None

    return typer


@lower_builtin(select, types.Any, types.Any, types.Any)
def _lower_select(context, builder, sig, args):
    kind = sig.return_type
    if isinstance(kind, LaneType):
        values = (_as_lanes(context, builder, v, t, kind) for v, t in zip(args[1:], sig.args[1:]))
    else:
        values = (context.cast(builder, v, t, kind) for v, t in zip(args[1:], sig.args[1:]))
    return builder.select(args[0], *values)


def _reduce(function, sign, bits):
    """A truth value that compares the mask, read as a number of eight bits, with ``bits``."""
    type_callable(function)(
        lambda context: lambda mask: types.boolean if mask is MASK or isinstance(mask, types.Boolean) else None
    )

    def lower(context, builder, sig, args):
        number = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned(sign, number, ir.Constant(number.type, bits))

    lower_builtin(function, MaskType)(lower)
    lower_builtin(function, types.Boolean)(lambda context, builder, sig, args: args[0])


_reduce(any_of, "!=", 0)
_reduce(all_of, "==", 2**LANES - 1)


# --- compiled: memory ------------------------------------------------------------------------------------------------


def _lane_of(array):
    return LANE_TYPES.get(array.dtype) if isinstance(array, types.Array) and array.layout == "C" else None


def _vector_pointer(context, builder, kind, array, offset, lanes):
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [offset]), lanes.vector.as_pointer())


def _size(lanes):
    return lanes.scalar.bitwidth // 8


@type_callable(splat)
def _type_splat(context):
    return lambda rows, x: _lane_of(rows)


@lower_builtin(splat, types.Array, types.Any)
def _lower_splat(context, builder, sig, args):
    return _as_lanes(context, builder, args[1], sig.args[1], sig.return_type)


def _part_pointer(context, builder, kinds, args, lanes):
    """Pointer to columns k to k + 7 of row i, for arguments (rows, i, k, ...)."""
    array = context.make_array(kinds[0])(context, builder, args[0])
    row = context.cast(builder, args[1], kinds[1], types.intp)
    k = context.cast(builder, args[2], kinds[2], types.intp)
    offset = builder.add(builder.mul(row, builder.extract_value(array.shape, 1)), k)
    return builder.bitcast(builder.gep(array.data, [offset]), lanes.vector.as_pointer())


def _row_pointer(context, builder, kinds, args, lanes):
    """Pointer to row i of an (n, 8) array, for arguments (rows, i, ...)."""
    row = context.cast(builder, args[1], kinds[1], types.intp)
    return _vector_pointer(context, builder, kinds[0], args[0], builder.mul(row, row.type(LANES)), lanes)


def _load_with(function, pointer, typer, *integers):
    type_callable(function)(lambda context: typer)

    def lower(context, builder, sig, args):
        value = builder.load(pointer(context, builder, sig.args, args, sig.return_type))
        value.align = _size(sig.return_type)
        return value

    lower_builtin(function, types.Array, *integers)(lower)


def _store_with(function, pointer, typer, *integers):
    type_callable(function)(lambda context: typer)

    def lower(context, builder, sig, args):
        lanes = sig.args[-1]
        builder.store(args[-1], pointer(context, builder, sig.args, args, lanes)).align = _size(lanes)
        return context.get_dummy_value()

    lower_builtin(function, types.Array, *integers, LaneType)(lower)


def _stored(rows, value):
    return types.void if value is _lane_of(rows) else None


_load_with(load, _row_pointer, lambda rows, i: _lane_of(rows), types.Integer)
_store_with(store, _row_pointer, lambda rows, i, value: _stored(rows, value), types.Integer)
_load_with(load_part, _part_pointer, lambda rows, i, k: _lane_of(rows), types.Integer, types.Integer)
_store_with(store_part, _part_pointer, lambda rows, i, k, value: _stored(rows, value), types.Integer, types.Integer)


def _transpose(builder, rows):
    """Columns of eight vectors of eight: three rounds of shuffles of pairs that are 1, 2 and 4 rows apart."""

    def shuffle(a, b, mask):
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(I32, LANES), mask))

    low, high = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
    pairs = [None] * 8
    for i in range(0, 8, 2):
        pairs[i], pairs[i + 1] = shuffle(rows[i], rows[i + 1], low), shuffle(rows[i], rows[i + 1], high)
    low, high = [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]
    fours = [None] * 8
    for i in (0, 1, 4, 5):
        fours[i], fours[i + 2] = shuffle(pairs[i], pairs[i + 2], low), shuffle(pairs[i], pairs[i + 2], high)
    low, high = [0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]
    eights = [None] * 8
    for i in range(4):
        eights[i], eights[i + 4] = shuffle(fours[i], fours[i + 4], low), shuffle(fours[i], fours[i + 4], high)
    return eights


def _row_pointers(context, builder, kinds, args, lanes):
    """Pointers to columns k to k + 7 of the eight rows that are named."""
    rows = context.make_array(kinds[0])(context, builder, args[0])
    index = context.make_array(kinds[1])(context, builder, args[1])
    width = builder.extract_value(rows.shape, 1)
    first = context.cast(builder, args[2], kinds[2], types.intp)
    k = context.cast(builder, args[3], kinds[3], types.intp)
    base = builder.mul(first, first.type(LANES))
    for lane in range(LANES):
        row = builder.load(builder.gep(index.data, [builder.add(base, base.type(lane))]))
        row = context.cast(builder, row, kinds[1].dtype, types.intp)
        offset = builder.add(builder.mul(row, width), k)
        yield builder.bitcast(builder.gep(rows.data, [offset]), lanes.vector.as_pointer())


@type_callable(gather)
def _type_gather(context):
    def typer(rows, index, i, k):
        lanes = _lane_of(rows)
        return None if lanes is None else types.UniTuple(lanes, LANES)

    return typer


@lower_builtin(gather, types.Array, types.Array, types.Integer, types.Integer)
def _lower_gather(context, builder, sig, args):
    lanes = sig.return_type.dtype
    rows = []
    for pointer in _row_pointers(context, builder, sig.args, args, lanes):
        value = builder.load(pointer)
        value.align = _size(lanes)
        rows.append(value)
    return context.make_tuple(builder, sig.return_type, _transpose(builder, rows))


@type_callable(scatter)
def _type_scatter(context):
    def typer(rows, index, i, k, values):
        lanes = _lane_of(rows)
        return types.void if values == types.UniTuple(lanes, LANES) else None

    return typer


@lower_builtin(scatter, types.Array, types.Array, types.Integer, types.Integer, types.UniTuple)
def _lower_scatter(context, builder, sig, args):
    lanes = sig.args[4].dtype
    columns = [builder.extract_value(args[4], j) for j in range(LANES)]
    pointers = _row_pointers(context, builder, sig.args, args, lanes)
    for value, pointer in zip(_transpose(builder, columns), pointers):
        builder.store(value, pointer).align = _size(lanes)
    return context.get_dummy_value()
