"""The language of sweeps: arithmetic over arrays, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stiction.errors import InvalidInputError
from stiction.sweep.expressions import Expression


def value(text: str, **names: object) -> object:
    return Expression(text, "value").evaluate(names)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3 ** 2", 19.0),
        ("-7 // 2 + 7 % 4", -1.0),
        ("max(1, x, 2)", 3.0),
        ("min(series)", 1.0),
        ("series[-1] - series[0]", 3.0),
        ("sum(series[1:3])", 5.0),
        ("last(table[:, 1])", 1.0),
        ("mean(where(series > 2, 1, 0))", 0.5),
        ("any(series > 3) and not all(series > 3)", True),
        ("1 < x <= 3", True),
        ("x if x > 5 else -x", -3.0),
        ("norm(table)[1]", math.sqrt(2.0)),
        ("degrees(pi)", 180.0),
        ("1 / 0", math.inf),
        ("word == 'sliding'", True),
    ],
)
def test_arithmetic_is_that_of_numpy(text: str, expected: object) -> None:
    names = {"x": 3.0, "series": np.array([1.0, 2.0, 3.0, 4.0]), "table": np.array([[3.0, 4.0], [1.0, 1.0]])}
    assert value(text, word="sliding", **names) == pytest.approx(expected)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.1, 1e3))
def test_it_agrees_with_python(a: float, b: float, c: float) -> None:
    text = "abs(a - b) / c + sqrt(c) * sin(a) if a > b else hypot(a, b) - c ** 0.5"
    expected = abs(a - b) / c + math.sqrt(c) * math.sin(a) if a > b else math.hypot(a, b) - c**0.5
    assert value(text, a=a, b=b, c=c) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "x.__class__",
        "(lambda: 1)()",
        "[y for y in (1, 2)]",
        "f'{x}'",
        "{1: 2}",
        "(y := 2)",
        "max(*x)",
        "max(**x)",
        "x[0](1)",
        "x & 1",
        "x ^ 2",
        "~x",
        "None",
        "b'a'",
        "1j",
        "yield",
        "import os",
        "1 +",
        "",
        "x" * 5000,
        "-" * 1900 + "1",
    ],
)
def test_what_is_not_arithmetic_is_refused(text: str) -> None:
    with pytest.raises(InvalidInputError, match=r"^metrics\[0\]\.value ") as caught:
        Expression(text, "metrics[0].value").evaluate({"x": 1.0})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("zzz(1)", r"v: 'zzz' is not a known function in 'zzz\(1\)'; known are abs, all, any, "),
        ("sqr(2)", r"v: 'sqr' is not a known function in 'sqr\(2\)' \(did you mean 'sqrt'\?\)\."),
        ("speeed + 1", r"v: 'speeed' is not a known name in 'speeed \+ 1' \(did you mean 'speed'\?\)\."),
    ],
)
def test_unknown_names_and_calls_are_told_with_the_nearest_known(text: str, sentence: str) -> None:
    with pytest.raises(InvalidInputError, match=sentence):
        Expression(text, "v").require(["speed"])


@pytest.mark.parametrize("text", ["'%9999999999d' % 1", "'a' * 10", "9 ** 9 ** 9 ** 9", "x[x]", "x[0, :, 1]", "sqrt()"])
def test_nothing_fills_the_memory_or_breaks_out(text: str) -> None:
    try:
        result = value(text, x=np.arange(3.0))
    except InvalidInputError as error:
        assert str(error).startswith("value cannot be computed: ")
    else:
        assert np.isinf(result)  # type: ignore[call-overload]  # a number, as only the power has a value
