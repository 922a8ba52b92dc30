"""What is too deep: how much of it the solver is not told, and that bodies are moved out of it, and no faster."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.lanes import LANES
from stiction.core.solve.blocks import prepare_block
from stiction.core.solve.depth import FASTEST, GENTLE, RATE, bury_faces, bury_points, dig_faces_out, dig_points_out
from stiction.core.solve.points import prepare_points
from stiction.core.solve.soft import softness

from .support import Array
from .test_blocks import Pair
from .test_points import SUBSTEPS, H, Step


def dig_points(
    blocks: Any, index: Any, manifolds: Any, corners: Any, aux: Any, rows: Any, h: float, sweeps: int
) -> None:
    """A block of points, and so many sweeps."""
    beta, soft, stiff_beta, stiff_soft = softness(h)
    prepare_points(0, blocks, index, 1, manifolds, aux, h, SUBSTEPS * h, beta, soft, stiff_beta, stiff_soft)
    bury_points(0, blocks, index, 1)
    for _ in range(sweeps):
        dig_points_out(0, blocks, index, 1, rows, aux, h, 0.0)


def dig_faces(
    blocks: Any, index: Any, manifolds: Any, corners: Any, aux: Any, rows: Any, h: float, sweeps: int
) -> None:
    """The same of a block of faces."""
    beta, soft, stiff_beta, stiff_soft = softness(h)
    prepare_block(
        0, blocks, index, 1, manifolds, corners, aux, h, SUBSTEPS * h, beta, soft, stiff_beta, stiff_soft, None
    )
    bury_faces(0, blocks, index, 1, None)
    for _ in range(sweeps):
        dig_faces_out(0, blocks, index, 1, rows, aux, h, 0.0, None)


def test_points_are_dug_out_as_faces_without_extent_are(rng: np.random.Generator) -> None:
    step = Step(rng, False, s.STUCK, s.OLD)
    step.manifolds[1:, s.GAP] = rng.choice([0.01, -1e-4, -0.01, -0.1, -1.0], size=LANES)
    (rows, points), (wanted, faces) = step.take(dig_points, 4), step.take(dig_faces, 4)
    np.testing.assert_allclose(rows, wanted, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(points[s.B_BURIED], faces[s.B_BURIED], rtol=1e-9, atol=1e-15)


class Faces(Step):
    """Eight faces, some of them deep and tilted, some hardly or apart."""

    def __init__(self, rng: np.random.Generator, fixed: bool) -> None:
        super().__init__(rng, fixed, s.STUCK, s.OLD)
        self.pairs = [Pair(rng, points=4, fixed=fixed) for _ in range(LANES)]
        for k, pair in enumerate(self.pairs):
            pair.loads *= rng.choice([0.0, 1.0])
            pair.gaps = rng.choice([0.02, -1e-4, -0.05, -0.3]) + 0.01 * rng.normal(size=4)
            pair.write(self.manifolds, self.aux, k + 1, 2 * k + 1, 2 * k + 2)
        self.rows[:] = 0.0
        self.aux[:, s.AUX_START_V : s.AUX_ROTATION] = 0.0


@pytest.mark.parametrize("fixed", [False, True], ids=["two movable bodies", "one of them fixed"])
def test_a_face_is_moved_out_where_it_is_deepest(rng: np.random.Generator, fixed: bool) -> None:
    for _ in range(10):
        step = Faces(rng, fixed)
        rows, block = step.take(dig_faces, 1)
        assert not rows[:, s.ROW_V : s.ROW_D].any(), "nobody is faster"
        for k, pair in enumerate(step.pairs):
            gap, soft = block[s.B_GAP : s.B_GAP + 4, k], block[s.B_SOFT : s.B_SOFT + 4, k]
            buried, beta = block[s.B_BURIED, k], block[s.B_BETA, k]
            borne = soft * block[s.B_LOAD : s.B_LOAD + 4, k]
            told = -beta * gap - borne
            if buried == 0.0:
                assert told.max() <= GENTLE * (1 + 1e-9)
                assert not rows[2 * k + 1].any() and not rows[2 * k + 2].any()
                continue
            assert told.max() == pytest.approx(GENTLE), "the solver is told of no more than it may push"
            # how far a's point has gone along n against b's, in the mean of the points that are too deep
            n = pair.frame[:, 0]
            depth = -(gap - buried)
            weight = np.maximum(beta * depth - GENTLE - borne, 0.0)
            at = (weight / weight.sum()) @ pair.places @ pair.frame[:, 1:].T
            moved = []
            for row, arm in ((rows[2 * k + 1], pair.ra), (rows[2 * k + 2], pair.rb)):
                moved.append(n @ (row[s.ROW_D : s.ROW_D + 3] + np.cross(row[s.ROW_TURN : s.ROW_TURN + 3], arm + at)))
            wanted = min(weight.max() / beta * RATE, FASTEST * H)
            assert moved[1] - moved[0] == pytest.approx(wanted, rel=1e-3)
            # by opposite impulses: their centre of mass stays
            if not fixed:
                total = (
                    rows[2 * k + 1, s.ROW_D : s.ROW_D + 3] / pair.ma + rows[2 * k + 2, s.ROW_D : s.ROW_D + 3] / pair.mb
                )
                np.testing.assert_allclose(total, 0.0, atol=1e-9)


@pytest.mark.parametrize("kernel", [dig_points, dig_faces], ids=["points", "faces"])
def test_lanes_do_not_mind_each_other(rng: np.random.Generator, kernel: Any) -> None:
    """The same bits for one pair alone as beside seven that are deep."""
    step = Step(rng, False, s.STUCK, s.OLD)
    step.manifolds[1:, s.GAP] = -0.1 * rng.uniform(0.5, 2.0, size=LANES)
    all_rows, _ = step.take(kernel, 3)
    for k in range(LANES):
        alone: Array = step.index.copy()
        step.index[:3, np.arange(LANES) != k] = 0
        rows, _ = step.take(kernel, 3)
        step.index[:] = alone
        np.testing.assert_array_equal(rows[2 * k + 1 : 2 * k + 3], all_rows[2 * k + 1 : 2 * k + 3])
