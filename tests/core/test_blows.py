"""What is struck, what of it acts again, and which blocks are passed over once more."""

from __future__ import annotations

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.lanes import LANES, Lanes
from stiction.core.solve.blows import BLOW, any_struck, closing_of, mark_struck, note_struck, passing
from stiction.core.solve.normals import Four
from stiction.core.vec import Vec3


def lanes(*values: float) -> Lanes:
    return Lanes(np.array(values))


def test_nothing_passes_where_nothing_hits_and_everything_that_comes_again() -> None:
    closing = lanes(0.01, BLOW, 1.0, 10.0)
    hits = closing > BLOW
    first, later = (passing(closing, hits, again).values for again in (False, True))
    np.testing.assert_array_equal(later, [0.0, 0.0, 1.0, 1.0])
    assert (first[:2] == 0.0).all()
    # what acts again is worth no more than it was at the threshold, and less the harder the blow
    worth = (1.0 - first[2:]) * closing.values[2:]
    np.testing.assert_allclose(worth, BLOW**2 / closing.values[2:])
    assert passing(lanes(BLOW * (1 + 1e-9)), lanes(1.0) > 0.0, False).values[0] == pytest.approx(0.0, abs=1e-8)


def test_a_face_closes_as_its_fastest_point_does_beyond_what_closes_its_gap() -> None:
    v, w = Vec3(*(lanes(x, x) for x in (1.0, 0.0, 0.0))), Vec3(*(lanes(x, x) for x in (0.0, 2.0, 0.0)))
    x = Four(*(lanes(0.0, 0.0) for _ in range(4)))
    y = Four(*(lanes(k, k) for k in (-1.0, -0.5, 0.5, 1.0)))
    # one gap that lets pass all, and a penetration that would be pushed out, which is no blow
    aim = Four(lanes(0.0, -3.0), lanes(0.0, -3.0), lanes(0.0, -3.0), lanes(3.0, -3.0))
    np.testing.assert_allclose(closing_of(v, w, x, y, aim).values, [2.0, 3.0])


def test_blocks_of_bodies_that_the_last_pass_struck_come_once_more() -> None:
    """Three blocks of one manifold each, in a chain of four bodies; the first body is fixed."""
    index, count = np.zeros((5 * 3, LANES), np.int32), 3
    blocks, aux = np.zeros((3 * s.FIELDS, LANES)), np.zeros((5, s.AUX_WIDTH))
    for i in range(3):
        index[i, 0], index[i + count, 0], index[i + 2 * count, 0] = i + 1, i + 2, i + 1
        index[i + 4 * count, 1] = i * s.FIELDS
    aux[2:, s.AUX_MASS] = 1.0

    def struck(turn: int) -> list[bool]:
        copy = blocks.copy()
        return [mark_struck(i, copy, index, count, aux, turn) for i in range(count)]

    assert not any_struck(blocks, index, count)
    assert struck(2) == [False] * 3
    blocks[s.B_MISS, 0] = 1.0
    for i in range(count):
        note_struck(i, blocks, index, count, aux, 1)
    assert any_struck(blocks, index, count)
    assert aux[:, s.AUX_STRUCK].tolist() == [0.0, 0.0, 1.0, 0.0, 0.0]
    assert struck(2) == [True, True, False]
    assert struck(3) == [False] * 3
