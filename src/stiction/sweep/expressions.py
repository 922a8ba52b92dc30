"""Expressions of a sweep: a small language with numbers, names and calls, walked over a syntax tree of its own.

What a spec file says is never handed to Python's ``eval``: the text is parsed, every node of the tree must be one of
a short list, and the tree is evaluated here over numpy arrays. There are no attributes, no lambdas, no loops, and calls
go to known functions only, so that a file from somebody else can do nothing but arithmetic.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

import numpy as np

from stiction.checks import nearest
from stiction.errors import InvalidInputError

LONGEST = 2000
"""Characters of an expression at most."""

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: np.logical_not,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_NODES = (
    *(ast.Expression, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.Name, ast.Constant),
    *(ast.keyword, ast.Subscript, ast.Slice, ast.Tuple, ast.Load, ast.And, ast.Or, *_BINARY, *_UNARY, *_COMPARE),
)
_WORDS = {
    ast.Attribute: "a dot with a name after it",
    ast.Lambda: "a lambda",
    ast.NamedExpr: "an assignment",
    ast.List: "a list",
    ast.Dict: "a dict",
    ast.Set: "a set",
    ast.JoinedStr: "an f-string",
    ast.Starred: "a star",
    ast.Await: "await",
    ast.BitAnd: "the operator & (write: and)",
    ast.BitOr: "the operator | (write: or)",
    ast.BitXor: "the operator ^ (a power is written **)",
    ast.Invert: "the operator ~ (write: not)",
}


def _least(values: Any, *others: Any) -> Any:
    return np.min(values) if not others else _fold(np.minimum, values, others)


def _largest(values: Any, *others: Any) -> Any:
    return np.max(values) if not others else _fold(np.maximum, values, others)


def _fold(pick: Callable[[Any, Any], Any], first: Any, others: tuple[Any, ...]) -> Any:
    for other in others:
        first = pick(first, other)
    return first


def _norm(vectors: Any) -> Any:
    return np.linalg.norm(vectors, axis=-1)


MATH: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "all": np.all,
    "any": np.any,
    "arccos": np.arccos,
    "arcsin": np.arcsin,
    "arctan": np.arctan,
    "arctan2": np.arctan2,
    "cos": np.cos,
    "degrees": np.degrees,
    "exp": np.exp,
    "first": lambda values: values[0],
    "hypot": np.hypot,
    "last": lambda values: values[-1],
    "log": np.log,
    "log10": np.log10,
    "max": _largest,
    "mean": np.mean,
    "median": np.median,
    "min": _least,
    "norm": _norm,
    "radians": np.radians,
    "sign": np.sign,
    "sin": np.sin,
    "sqrt": np.sqrt,
    "std": np.std,
    "sum": np.sum,
    "tan": np.tan,
    "where": np.where,
}
"""Functions that every expression may call; angles in radians, ``norm`` is along the last axis."""

CONSTANTS: dict[str, float] = {"pi": np.pi, "inf": np.inf, "nan": np.nan}
"""Names that every expression may use."""


class Expression:
    """A parsed expression.

    Args:
        text: such as ``max(speed('crate')) > 0.1 and tipped('crate')``.
        where: what a sentence calls it, such as ``metrics[0].value``.

    Attributes:
        text: as given.
        names: names that it uses. calls: functions that it calls. texts: every text in quotation marks in it.

    Raises:
        InvalidInputError: it is no expression, or has something in it that the language does not know.

    Example:
        >>> Expression("2 * x + 1", "value").evaluate({"x": 3.0})
        np.float64(7.0)
    """

    def __init__(self, text: str, where: str) -> None:
        self.text = text
        self.where = where
        if not isinstance(text, str) or not text.strip() or len(text) > LONGEST:
            raise InvalidInputError(f"{where} must be an expression of 1 to {LONGEST} characters, got {text!r:.80}.")
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
            nodes = list(ast.walk(self._tree))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            reason = error.msg if isinstance(error, SyntaxError) else "it cannot be parsed"
            raise InvalidInputError(f"{where} must be an expression, got {text!r} ({reason}).") from None
        _check(nodes, text, where)
        called = [node.func for node in nodes if isinstance(node, ast.Call)]
        self.calls = {node.id for node in called if isinstance(node, ast.Name)}
        self.names = {n.id for n in nodes if isinstance(n, ast.Name) and n not in called}
        self.texts = {n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)}

    def __repr__(self) -> str:
        return f"<Expression {self.text!r}>"

    def require(self, names: Collection[str], calls: Collection[str] = ()) -> None:
        """Check that it uses these names and calls these functions only, besides those that are always there.

        Raises:
            InvalidInputError: the first one that is not known, with the nearest that is.
        """
        for used, known, what in (
            (self.calls, {*MATH, *calls}, "function"),
            (self.names, {*CONSTANTS, *names}, "name"),
        ):
            for name in sorted(used - known):
                hint = nearest(name, sorted(known)) or f"; known are {', '.join(sorted(known))}"
                raise InvalidInputError(f"{self.where}: {name!r} is not a known {what} in {self.text!r}{hint}.")

    def arguments_of(self, calls: Collection[str]) -> Iterator[tuple[str, Any]]:
        """Function and first argument, if that is a constant, of each call of one of these functions."""
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in calls:
                first = node.args[0] if node.args else None
                yield node.func.id, first.value if isinstance(first, ast.Constant) else None

    def evaluate(self, names: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]] | None = None) -> Any:
        """Its value.

        Args:
            names: value of each name.
            functions: those it may call besides :data:`MATH`.

        Returns:
            A number, a flag, a text or an array. What has no finite value is inf or NaN, without a warning.

        Raises:
            InvalidInputError: a name or function is missing, or its parts do not fit together.
        """
        known = {**MATH, **(functions or {})}
        try:
            with np.errstate(all="ignore"):
                return _value(self._tree, {**CONSTANTS, **names}, known)
        except InvalidInputError:
            raise
        except KeyError as error:
            raise InvalidInputError(f"{self.where}: {error.args[0]!r} has no value in {self.text!r}.") from None
        except (TypeError, ValueError, IndexError, ArithmeticError, RecursionError) as error:
            raise InvalidInputError(f"{self.where} cannot be computed: {self.text!r} ({error}).") from None


def _check(nodes: list[ast.AST], text: str, where: str) -> None:
    for node in nodes:
        if not isinstance(node, _NODES):
            what = _WORDS.get(type(node), f"{type(node).__name__.lower()}")
            raise InvalidInputError(f"{where} must be made of numbers, names and calls, not {what}, got {text!r}.")
        if isinstance(node, ast.Call) and not isinstance(node.func, ast.Name):
            raise InvalidInputError(f"{where} must call functions by their plain name, got {text!r}.")
        if isinstance(node, ast.Call) and any(keyword.arg is None for keyword in node.keywords):
            raise InvalidInputError(f"{where} must give arguments one by one, got {text!r}.")
        if isinstance(node, ast.Constant) and not isinstance(node.value, (bool, int, float, str)):
            raise InvalidInputError(f"{where} must be made of numbers, names and calls, got {text!r}.")


def _value(node: Any, names: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Any:
    def value(of: ast.AST) -> Any:
        return _value(of, names, functions)

    match node:
        case ast.Constant(value=bool() | str()):
            return node.value
        case ast.Constant(value=int() | float() as number):
            return np.float64(number)  # also a whole number: powers of those could fill the memory
        case ast.Name():
            return names[node.id]
        case ast.BinOp():
            left, right = value(node.left), value(node.right)
            if isinstance(left, str) or isinstance(right, str):
                raise TypeError("texts can only be compared")  # a text times a number could fill the memory
            return _BINARY[type(node.op)](left, right)
        case ast.UnaryOp():
            return _UNARY[type(node.op)](value(node.operand))
        case ast.BoolOp():
            join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
            return _fold(join, value(node.values[0]), tuple(value(part) for part in node.values[1:]))
        case ast.Compare():
            terms = [value(part) for part in (node.left, *node.comparators)]
            pairs = zip(node.ops, terms, terms[1:], strict=False)
            found = [_COMPARE[type(op)](left, right) for op, left, right in pairs]
            return _fold(np.logical_and, found[0], tuple(found[1:]))
        case ast.IfExp():
            return value(node.body) if bool(value(node.test)) else value(node.orelse)
        case ast.Call(func=ast.Name(id=function)):
            given = {keyword.arg: value(keyword.value) for keyword in node.keywords if keyword.arg}
            return functions[function](*(value(argument) for argument in node.args), **given)
        case ast.Subscript():
            return np.asarray(value(node.value))[_index(node.slice)]
    raise TypeError("a slice or a tuple stands where a value should")


def _index(node: ast.AST) -> Any:
    """A whole number, a slice, or several of them with commas between; nothing computed."""
    match node:
        case ast.Tuple():
            return tuple(_index(part) for part in node.elts)
        case ast.Slice():
            return slice(*(None if part is None else _index(part) for part in (node.lower, node.upper, node.step)))
        case ast.UnaryOp(op=ast.USub()):
            return -_index(node.operand)
        case ast.Constant(value=int()) if not isinstance(node.value, bool):
            return node.value
    raise TypeError("an index must be a whole number")
