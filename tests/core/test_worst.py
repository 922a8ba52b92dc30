"""The tournament tree: always the largest value, the first of equal ones, after any change."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from stiction.core.worst import build, leaves_for, update, worst

from .support import Array, compiled

values = some.lists(some.one_of(some.floats(0.0, 10.0), some.sampled_from([0.0, 1.0, 2.0])), min_size=1, max_size=40)
changes = some.lists(some.tuples(some.integers(0, 39), some.sampled_from([0.0, 0.5, 1.0, 2.0, 11.0])), max_size=30)


def tree_of(numbers: list[float]) -> tuple[Array, int]:
    """A tree with these leaves; unused leaves are 0, as in the solver."""
    leaves = leaves_for(len(numbers))
    tree = np.zeros(2 * leaves)
    tree[leaves : leaves + len(numbers)] = numbers
    build(tree, leaves)
    return tree, leaves


@pytest.mark.parametrize(("m", "leaves"), [(0, 1), (1, 1), (2, 2), (3, 4), (4, 4), (5, 8), (64, 64), (65, 128)])
def test_leaves_are_the_power_of_two_that_holds_them(m: int, leaves: int) -> None:
    assert leaves_for(m) == compiled(leaves_for)(m) == leaves


@given(values)
def test_the_worst_is_the_first_of_the_largest(numbers: list[float]) -> None:
    tree, leaves = tree_of(numbers)
    assert worst(tree, leaves) == int(np.argmax(numbers))
    assert compiled(worst)(tree, leaves) == worst(tree, leaves)
    assert tree[1] == max(numbers)


@given(values, changes)
def test_after_every_update_it_is_as_if_built_anew(numbers: list[float], edits: list[tuple[int, float]]) -> None:
    tree, leaves = tree_of(numbers)
    for index, value in edits:
        k = index % len(numbers)
        numbers[k] = value
        update(tree, leaves, k, value)
        fresh, _ = tree_of(numbers)
        np.testing.assert_array_equal(tree[1:], fresh[1:])
        assert worst(tree, leaves) == int(np.argmax(numbers))


@given(values, changes)
def test_plain_python_and_compiled_agree(numbers: list[float], edits: list[tuple[int, float]]) -> None:
    plain, leaves = tree_of(numbers)
    machine = np.zeros_like(plain)
    machine[leaves:] = plain[leaves:]
    compiled(build)(machine, leaves)
    for index, value in edits:
        update(plain, leaves, index % len(numbers), value)
        compiled(update)(machine, leaves, index % len(numbers), value)
    np.testing.assert_array_equal(machine[1:], plain[1:])
