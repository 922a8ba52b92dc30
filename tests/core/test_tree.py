"""The tree of boxes against a list of boxes, through random insertions, moves and removals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiction.core.tree import (
    FREE,
    HEIGHT,
    LEAVES,
    NONE,
    ROOT,
    USED,
    Tree,
    check,
    grow_tree,
    insert,
    make_tree,
    move,
    query,
    remove,
)

from .support import Array, compiled


def random_box(rng: np.random.Generator, spread: float = 5.0) -> Array:
    """(6,) lower and upper corner; some are flat, and many have equal coordinates."""
    low = np.round(rng.uniform(-spread, spread, size=3), 1)
    return np.concatenate([low, low + np.round(rng.uniform(0.0, 2.0, size=3), 1)])


def overlap(a: Array, b: Array) -> bool:
    """Whether two boxes have a point in common."""
    return bool((a[:3] <= b[3:]).all() and (b[:3] <= a[3:]).all())


def found_in(tree: Tree, box: Array, room: int = 500) -> list[int]:
    """Bodies that a query finds, sorted."""
    out, stack = np.full(room, -7), np.full(max(int(tree.head[LEAVES]), 1), -7)
    count = compiled(query)(tree, *box, stack, out)
    assert (out[count:] == -7).all()
    return sorted(out[:count].tolist())


def put(tree: Tree, body: int, box: Array) -> None:
    compiled(insert)(tree, body, *box)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40), steps=st.integers(1, 150))
def test_the_tree_holds_what_was_put_in(seed: int, n: int, steps: int) -> None:
    """After every change the invariants hold, and a query finds exactly the boxes that overlap."""
    rng = np.random.default_rng(seed)
    tree, boxes = make_tree(n), {}
    for _ in range(steps):
        body = int(rng.integers(n))
        box = random_box(rng)
        if body not in boxes and rng.random() < 0.8:
            put(tree, body, box)
            boxes[body] = box
        elif rng.random() < 0.6:
            if body in boxes and rng.random() < 0.7:  # not far, so that the leaf may keep its place
                box = boxes[body] + 0.1 * np.tile(rng.normal(size=3), 2)
            compiled(move)(tree, body, *box)
            boxes[body] = box
        else:
            compiled(remove)(tree, body)
            boxes.pop(body, None)
        assert check(tree)
        wanted = random_box(rng)
        assert found_in(tree, wanted) == sorted(i for i, b in boxes.items() if overlap(b, wanted))
    for body, box in boxes.items():
        np.testing.assert_array_equal(tree.boxes[tree.leaf[body]], box)


def test_an_empty_tree_finds_nothing_and_forgets_nobody() -> None:
    tree = make_tree(3)
    everything = np.array([-np.inf] * 3 + [np.inf] * 3)
    assert check(tree)
    assert found_in(tree, everything) == []
    compiled(remove)(tree, 1)
    assert check(tree)
    put(tree, 1, random_box(np.random.default_rng(0)))
    assert found_in(tree, everything) == [1]
    compiled(remove)(tree, 1)
    assert check(tree)
    assert tree.head[ROOT] == NONE
    assert tree.head[FREE] != NONE


@pytest.mark.parametrize("order", ["sorted", "random", "all in one place"])
def test_the_tree_stays_low(rng: np.random.Generator, order: str) -> None:
    """Its height is a few times the least possible, even where bodies come in the order in which they lie."""
    n = 1000
    tree = make_tree(n)
    places = {"sorted": np.arange(n), "random": rng.permutation(n), "all in one place": np.zeros(n)}[order]
    for i, x in enumerate(places):
        put(tree, i, np.array([x, 0.0, 0.0, x + 1.2, 1.0, 1.0]))
    assert check(tree)
    limit = 40 if order != "all in one place" else n
    assert tree.links[tree.head[ROOT], HEIGHT] <= limit
    everything = np.array([-1e3] * 3 + [2e3] * 3)
    assert found_in(tree, everything, room=n) == list(range(n))


def test_nodes_are_used_again(rng: np.random.Generator) -> None:
    tree = make_tree(20)
    for _ in range(5):
        for i in range(20):
            put(tree, i, random_box(rng))
        for i in rng.permutation(20):
            compiled(remove)(tree, int(i))
    assert tree.head[USED] == 2 * 20 - 1
    assert check(tree)


def test_too_little_room_is_counted_and_not_written_over(rng: np.random.Generator) -> None:
    tree = make_tree(30)
    for i in range(30):
        put(tree, i, random_box(rng))
    backing, stack = np.full(12, -7), np.zeros(30, np.int64)
    assert compiled(query)(tree, -9.0, -9.0, -9.0, 9.0, 9.0, 9.0, stack, backing[:10]) == 30
    assert (backing[10:] == -7).all()
    assert (backing[:10] >= 0).all()


def test_a_grown_tree_is_the_same_tree(rng: np.random.Generator) -> None:
    tree = make_tree(5)
    boxes = [random_box(rng) for _ in range(9)]
    for i in range(5):
        put(tree, i, boxes[i])
    compiled(remove)(tree, 2)
    tree = grow_tree(tree, 9)
    assert check(tree)
    for i in (2, 5, 6, 7, 8):
        put(tree, i, boxes[i])
    assert check(tree)
    for wanted in boxes:
        assert found_in(tree, wanted) == [i for i in range(9) if overlap(boxes[i], wanted)]


@pytest.mark.parametrize(
    ("column", "place"),
    [("head", LEAVES), ("head", USED), ("leaf", 3), ("boxes", ("root", 3)), ("links", ("root", HEIGHT))],
)
def test_check_sees_what_is_wrong(rng: np.random.Generator, column: str, place: Any) -> None:
    """A count, a leaf, a box, a height that is one too large."""
    tree = make_tree(10)
    for i in range(10):
        put(tree, i, random_box(rng))
    assert check(tree)
    where = (int(tree.head[ROOT]), place[1]) if isinstance(place, tuple) else place
    getattr(tree, column)[where] += 1
    assert not check(tree)
