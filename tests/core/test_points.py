"""Single points in blocks of their own do what they do as faces without extent."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.colouring import POINT, WAYS, way_of
from stiction.core.jit import jit
from stiction.core.lanes import LANES, store
from stiction.core.manifolds import NOWHERE
from stiction.core.solve.blocks import prepare_block
from stiction.core.solve.depth import lift_block, lift_points
from stiction.core.solve.exact import miss_of_block
from stiction.core.solve.points import miss_of_points, prepare_points, solve_points, warm_points
from stiction.core.solve.results import store_blocks
from stiction.core.solve.soft import softness, solve_block, warm_block
from stiction.core.state import LEDGER_WIDTH

from .support import Array, compiled
from .test_blocks import Pair

H, SUBSTEPS = 1 / 240, 4


@jit
def go(rows: Any, h: float) -> None:
    """Where the bodies are at the end of a substep."""
    for r in range(rows.shape[0]):
        for k in range(8):
            rows[r, s.ROW_D + k] += rows[r, s.ROW_V + k] * h


def as_points(blocks: Any, index: Any, manifolds: Any, corners: Any, aux: Any, rows: Any, h: float, cold: int) -> None:
    """A step of one block of points."""
    beta, soft, stiff_beta, stiff_soft = softness(h)
    prepare_points(0, blocks, index, 1, manifolds, aux, h, SUBSTEPS * h, beta, soft, stiff_beta, stiff_soft)
    warm_points(0, blocks, index, 1, rows)
    for _ in range(cold):
        solve_points(0, blocks, index, 1, rows, aux, h, 0.0, True, False)
    if cold > 0:
        lift_points(0, blocks, index, 1)
    for k in range(SUBSTEPS):
        solve_points(0, blocks, index, 1, rows, aux, h, k * h, False, True)
        go(rows, h)


def as_faces(blocks: Any, index: Any, manifolds: Any, corners: Any, aux: Any, rows: Any, h: float, cold: int) -> None:
    """The same of one block of faces."""
    beta, soft, stiff_beta, stiff_soft = softness(h)
    prepare_block(
        0, blocks, index, 1, manifolds, corners, aux, h, SUBSTEPS * h, beta, soft, stiff_beta, stiff_soft, None
    )
    warm_block(0, blocks, index, 1, rows, aux, None)
    for _ in range(cold):
        solve_block(0, blocks, index, 1, rows, aux, h, 0.0, True, False, None, None, None)
    if cold > 0:
        lift_block(0, blocks, index, 1)
    for k in range(SUBSTEPS):
        solve_block(0, blocks, index, 1, rows, aux, h, k * h, False, True, None, None, None)
        go(rows, h)


class Step:
    """A step of eight pairs, which touch in one point each, in blocks of either sort."""

    def __init__(self, rng: np.random.Generator, fixed: bool, state: float, fresh: float) -> None:
        self.pairs = [Pair(rng, points=1, fixed=fixed) for _ in range(LANES)]
        self.manifolds, self.aux = np.zeros((LANES + 1, s.MANIFOLD_WIDTH)), np.zeros((2 * LANES + 1, s.AUX_WIDTH))
        self.index = np.zeros((5, LANES), np.int32)
        for k, pair in enumerate(self.pairs):
            pair.places[:] = 0.0
            pair.spin, pair.roll[:] = 0.0, 0.0
            pair.write(self.manifolds, self.aux, k + 1, 2 * k + 1, 2 * k + 2)
            self.index[:4, k] = 2 * k + 1, 2 * k + 2, k + 1, 0
        lanes = self.manifolds[1:]
        lanes[:, s.GAP] = 1e-3 * rng.normal(size=LANES)
        lanes[:, s.GAP + 1 : s.GAP + 4] = NOWHERE
        lanes[:, s.LOAD] *= rng.choice([0.0, 1.0, 30.0], size=LANES)
        lanes[:, s.STATE], lanes[:, s.FRESH] = state, fresh
        lanes[:, s.OVER] = rng.choice([0.0, 1.0, 2.0], size=LANES) if state == s.STUCK else 0.0
        lanes[:, s.BELT : s.BELT + 3] = 0.1 * rng.normal(size=(LANES, 3))
        self.rows = np.zeros((2 * LANES + 1, s.ROW_WIDTH))
        speeds = rng.choice([0.03, 1.0], size=(2 * LANES, 1)) * rng.normal(size=(2 * LANES, 6))
        if fixed:
            speeds[::2] = 0.0
        self.rows[1:, s.ROW_V : s.ROW_V + 3], self.rows[1:, s.ROW_W : s.ROW_W + 3] = speeds[:, :3], speeds[:, 3:]
        start = rng.choice([0.03, 1.0]) * rng.normal(size=(2 * LANES, 6))
        if fixed:
            start[::2] = 0.0
        self.aux[1:, s.AUX_START_V : s.AUX_START_V + 3] = start[:, :3]
        self.aux[1:, s.AUX_START_W : s.AUX_START_W + 3] = start[:, 3:]

    def take(self, kernel: Any, cold: int) -> tuple[Array, Array]:
        """The rows of bodies and the block after a step."""
        blocks, rows = np.full((s.FIELDS, LANES), np.nan), self.rows.copy()
        corners = np.zeros((LANES + 1, s.CORNERS_WIDTH))
        compiled(kernel)(blocks, self.index, self.manifolds.copy(), corners, self.aux.copy(), rows, H, cold)
        return rows, blocks

    def stored(self, blocks: Array, sort: int) -> tuple[Array, Array, Array]:
        """Manifolds, reports and ledgers after the step."""
        manifolds, reports = self.manifolds.copy(), np.zeros((LANES + 1, s.REPORT_WIDTH))
        index, ledger, aux = self.index.copy(), np.zeros(LEDGER_WIDTH), self.aux.copy()
        index[4, 0] = sort
        compiled(store_blocks)(
            blocks, index, 1, manifolds, reports, aux, H, 1 / 60, ledger, np.zeros(1, np.int64), False, False, LANES
        )
        return manifolds, reports, np.append(ledger, aux[:, s.AUX_WORK])


SAME = [
    s.B_GAP, s.B_LOAD, *range(s.B_PULL, s.B_PULL + 2), s.B_STATE, s.B_OVER, s.B_LEFT, s.B_TOTAL_LOAD,
    *range(s.B_TOTAL_PULL, s.B_TOTAL_PULL + 2), *range(s.B_SLIP, s.B_SLIP + 2), s.B_WORK,
]  # fmt: skip


@pytest.mark.parametrize("fixed", [False, True], ids=["two movable bodies", "one of them fixed"])
@pytest.mark.parametrize("state", [s.STUCK, s.SLIDING], ids=["stuck", "sliding"])
@pytest.mark.parametrize("fresh", [s.OLD, s.NEW, s.QUIET], ids=["old", "new", "quiet"])
def test_a_point_does_what_a_face_without_extent_does(
    rng: np.random.Generator, fixed: bool, state: float, fresh: float
) -> None:
    """In a whole step, cold passes included. The face's friction is iterated until its steps are short: 1e-4."""
    for _ in range(40):
        step = Step(rng, fixed, state, fresh)
        cold = 0 if fresh == s.OLD else 3
        (rows, points), (wanted_rows, faces) = step.take(as_points, cold), step.take(as_faces, cold)
        size = np.abs(step.rows).max()
        np.testing.assert_allclose(rows, wanted_rows, rtol=1e-4, atol=1e-4 * size)
        np.testing.assert_allclose(points[SAME], faces[SAME], rtol=1e-4, atol=1e-4 * size)
        for mine, other in zip(step.stored(points, POINT), step.stored(faces, 1 - POINT), strict=True):
            np.testing.assert_allclose(mine, other, rtol=2e-4, atol=1e-4 * max(np.abs(other).max(), 1e-9))


@pytest.mark.parametrize("kernel", [as_points, as_faces], ids=["points", "faces"])
@pytest.mark.parametrize("fresh", [s.OLD, s.NEW], ids=["old", "new"])
def test_it_does_not_matter_from_where_velocities_are_counted(
    rng: np.random.Generator, kernel: Any, fresh: float
) -> None:
    """In rows since the step began, or all of them in the rows: impulses and separations are the same."""
    for state in (s.STUCK, s.SLIDING):
        for _ in range(20):
            since, whole = (
                Step(np.random.default_rng(seed), False, state, fresh) for seed in 2 * [rng.integers(2**32)]
            )
            for row, start in ((s.ROW_V, s.AUX_START_V), (s.ROW_W, s.AUX_START_W)):
                whole.rows[:, row : row + 3] += whole.aux[:, start : start + 3]
                whole.aux[:, start : start + 3] = 0.0
            cold = 0 if fresh == s.OLD else 3
            (rows, blocks), (wanted_rows, wanted) = since.take(kernel, cold), whole.take(kernel, cold)
            time = SUBSTEPS * H
            for row, start in ((s.ROW_V, s.AUX_START_V), (s.ROW_W, s.AUX_START_W)):
                rows[:, row : row + 3] += since.aux[:, start : start + 3]
                rows[:, row + 8 : row + 11] += since.aux[:, start : start + 3] * time
            np.testing.assert_allclose(rows, wanted_rows, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(blocks[SAME], wanted[SAME], rtol=1e-9, atol=1e-9)


def of_one_point(torsional: float, rolling: float, points: float = 1.0) -> int:
    row = np.zeros((1, s.MANIFOLD_WIDTH))
    row[0, s.COUNT], row[0, s.TORSIONAL], row[0, s.ROLLING] = points, torsional, rolling
    return int(compiled(way_of)(row, 0)) // WAYS


def test_what_resists_turning_is_no_point() -> None:
    assert of_one_point(0.0, 0.0) == POINT
    assert of_one_point(0.01, 0.0) != POINT
    assert of_one_point(0.0, 0.01) != POINT
    assert of_one_point(0.0, 0.0, points=2.0) != POINT


def misses_as_points(blocks: Any, index: Any, rows: Any) -> None:
    """Into the block: how far its points are from their laws."""
    store(blocks, s.B_MISS, miss_of_points(0, blocks, index, 1, rows, H, SUBSTEPS * H))


def misses_as_faces(blocks: Any, index: Any, rows: Any) -> None:
    """The same of faces."""
    store(blocks, s.B_MISS, miss_of_block(0, blocks, index, 1, rows, H, SUBSTEPS * H, None, True))


@pytest.mark.parametrize("state", [s.STUCK, s.SLIDING], ids=["stuck", "sliding"])
def test_points_miss_their_laws_by_as_much_as_faces_without_extent(rng: np.random.Generator, state: float) -> None:
    largest = 0.0
    for _ in range(40):
        step, found = Step(rng, False, state, s.OLD), []
        for kernel, misses in ((as_points, misses_as_points), (as_faces, misses_as_faces)):
            rows, blocks = step.take(kernel, 0)
            rows[:, s.ROW_V : s.ROW_V + 3] += 0.01 * np.sin(np.arange(len(rows)))[:, None]
            compiled(misses)(blocks, step.index, rows)
            found.append(blocks[s.B_MISS].copy())
        np.testing.assert_allclose(*found, rtol=1e-3, atol=1e-4)
        largest = max(largest, found[0].max())
    assert largest > 1e-3
