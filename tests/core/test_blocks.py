"""Blocks: what eight manifolds need in a pass, against numpy, for random bodies."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from stiction.core import soft_rows as s
from stiction.core.faces import measure_face
from stiction.core.lanes import LANES
from stiction.core.solve.blocks import CARRIED, prepare_block
from stiction.core.state import CONTACT_WIDTH, POINT, SCRATCH, TAGS_WIDTH
from stiction.core.vec import Vec3

from .support import Array, compiled, matrix_of, random_inverse_inertia, random_unit

H, BETA, SOFT, BETA_STIFF, SOFT_STIFF = 1 / 480, 12.0, 0.038, 24.0, 0.019
UPPER3, UPPER4 = np.triu_indices(3), np.triu_indices(4)


def skew(v: Array) -> Array:
    """S with S x = v x x."""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turned(angle: Array) -> Array:
    """Rotation matrix of a small rotation vector."""
    size = np.linalg.norm(angle)
    return matrix_of(np.array([np.cos(size / 2), *(np.sin(size / 2) * angle / max(size, 1e-300))]))


class Pair:
    """A random manifold of two random bodies, and where its numbers come from."""

    def __init__(self, rng: np.random.Generator, points: int = 4, fixed: bool = False, tilt: float = 0.0) -> None:
        self.frame = matrix_of(random_unit(rng, 4))  # columns n, u, v
        self.Ra, self.Rb = matrix_of(random_unit(rng, 4)), matrix_of(random_unit(rng, 4))
        self.ma, self.mb = (0.0 if fixed else np.exp(rng.uniform(-2, 2))), np.exp(rng.uniform(-2, 2))
        self.Ia = random_inverse_inertia(rng) * (0.0 if fixed else 1.0)
        self.Ib = random_inverse_inertia(rng)
        self.ra, self.rb = 0.5 * rng.normal(size=3), 0.5 * rng.normal(size=3)
        self.size = np.exp(rng.uniform(-1, 1, size=2))
        self.places = 0.5 * self.size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        # what stands for the missing ones is the affair of faces.py
        corners = self.places.copy()
        self.places[points:] = {
            3: corners[[0, 2]].mean(axis=0),
            2: corners[2:] * [1, 0] + [0, 0.01],
            1: corners[:1],
        }.get(points, 0.0)
        if points == 2:
            self.places[:2, 1] = 0.0
            self.places[2:] = corners[2:] * [1.0, 0.0] + [0.0, 0.01]
        self.roll = 0.1 * rng.normal(size=2)
        self.points, self.here = points, (np.arange(4) < points).astype(float)
        self.gaps = 0.01 * rng.normal(size=4) * self.here
        self.loads = rng.uniform(0.5, 2.0, size=4) * self.here
        self.pull, self.spin = self.frame[:, 1:] @ rng.normal(size=2), rng.normal()
        self.shift, self.tilt = 1e-3 * rng.normal(size=3), tilt * rng.normal(size=3)
        self.scale = 1.0 / (self.ma + self.mb)

    def write(self, manifolds: Array, aux: Array, slot: int, a: int, b: int) -> None:
        """Into the arrays of the solver: the rows of a manifold and of two bodies."""
        n, u = self.frame[:, 0], self.frame[:, 1]
        # b's copy of the frame has turned with it by the tilt
        turn = self.Rb.T @ turned(self.tilt)
        row = {
            s.NORMAL_A: self.Ra.T @ n, s.TANGENT_A: self.Ra.T @ u, s.NORMAL_B: turn @ n, s.TANGENT_B: turn @ u,
            s.MU_S: 0.6, s.MU_D: 0.5, s.GAP: self.gaps, s.LOAD: self.loads, s.PLACE_U: self.places[:, 0],
            s.PLACE_V: self.places[:, 1], s.PULL: self.pull, s.SPIN: self.spin, s.COUNT: self.points,
            s.SHIFT: self.shift, s.ARM_A: self.ra, s.ARM_B: self.rb, s.ROLL: self.roll,
        }  # fmt: skip
        for column, value in row.items():
            numbers = np.ravel(value)
            manifolds[slot, column : column + len(numbers)] = numbers
        for body, R, m, inertia in ((a, self.Ra, self.ma, self.Ia), (b, self.Rb, self.mb, self.Ib)):
            aux[body, s.AUX_ROTATION : s.AUX_ROTATION + 9] = R.ravel()
            aux[body, s.AUX_MASS] = m
            aux[body, s.AUX_INERTIA : s.AUX_INERTIA + 6] = inertia[UPPER3]

    def turned_by(self, c: float, sine: float) -> Pair:
        """The same manifold described in a frame that is turned in its plane."""
        other = copy.copy(self)
        turn = np.array([[c, -sine], [sine, c]])
        other.frame = self.frame.copy()
        other.frame[:, 1:] = self.frame[:, 1:] @ turn
        other.places, other.roll = self.places @ turn, self.roll @ turn
        return other

    def response(self) -> Array:
        """(6, 6): velocity at the anchor and spin, of a against b, by force and torque there; in the frame."""
        K = np.zeros((6, 6))
        for m, inertia, r in ((self.ma, self.Ia, self.ra), (self.mb, self.Ib, self.rb)):
            S = skew(r)
            K[:3, :3] += m * np.eye(3) - S @ inertia @ S
            K[3:, :3] += inertia @ S
            K[:3, 3:] -= S @ inertia
            K[3:, 3:] += inertia
        C = np.kron(np.eye(2), self.frame.T)
        return np.asarray(C @ K @ C.T) * self.scale

    def center(self) -> Array:
        """Centre of pressure, (2,)."""
        return np.asarray(self.loads @ self.places / self.loads.sum())

    def normals(self) -> Array:
        """(4, 6): what a unit impulse at each point is as force and torque at the anchor; zero for missing points."""
        rows = np.zeros((4, 6))
        rows[:, 0], rows[:, 4], rows[:, 5] = 1.0, self.places[:, 1], -self.places[:, 0]
        return rows * self.here[:, None]

    def friction(self, Tm: float) -> Array:
        """(3, 6): the same of friction along u and v at the centre of pressure, and of a torque T_m about n."""
        x, y = self.center()
        return np.array([[0, 1, 0, -y, 0, 0], [0, 0, 1, x, 0, 0], [0, 0, 0, Tm, 0, 0]])


class Block:
    """The block that the kernel makes of eight pairs; fewer are padded."""

    def __init__(self, pairs: list[Pair], precision: Any = np.float64) -> None:
        n = len(pairs)
        manifolds, aux = np.zeros((n + 1, s.MANIFOLD_WIDTH), precision), np.zeros((2 * n + 1, s.AUX_WIDTH), precision)
        index = np.zeros((s.MEMBERS, LANES), np.int32)
        for k, pair in enumerate(pairs):
            pair.write(manifolds, aux, k + 1, 2 * k + 1, 2 * k + 2)
            index[:3, k] = 2 * k + 1, 2 * k + 2, k + 1
        self.rows = np.full((s.FIELDS, LANES), np.inf, precision)
        compiled(prepare_block)(
            0, self.rows, index, 1, manifolds, np.zeros((n + 1, s.CORNERS_WIDTH), precision), aux, H, 4 * H, BETA, SOFT,
            BETA_STIFF, SOFT_STIFF, None,
        )  # fmt: skip
        # as they are in the axes of their pressure
        self.pairs = [pair.turned_by(*self.get(s.B_TURN, lane, 2)) for lane, pair in enumerate(pairs)]

    def get(self, field: int, lane: int, width: int = 1) -> Any:
        """Numbers of one lane."""
        found = self.rows[field : field + width, lane]
        return float(found[0]) if width == 1 else found.astype(float)

    def symmetric(self, field: int, lane: int, size: int) -> Array:
        """A symmetric matrix of one lane, kept as its upper triangle."""
        upper = np.triu_indices(size)
        full = np.zeros((size, size))
        full[upper] = self.get(field, lane, len(upper[0]))
        return full + full.T - np.diag(np.diag(full))


@pytest.fixture(params=["two movable bodies", "one of them fixed"])
def fixed(request: pytest.FixtureRequest) -> bool:
    """Whether the first body cannot move."""
    return bool(request.param == "one of them fixed")


def eight(rng: np.random.Generator, fixed: bool = False, **given: Any) -> list[Pair]:
    return [Pair(rng, fixed=fixed, **given) for _ in range(LANES)]


def close(found: Any, wanted: Any, digits: float = 1e-11) -> None:
    """Within some digits of the largest number."""
    np.testing.assert_allclose(found, wanted, rtol=0, atol=digits * max(np.abs(wanted).max(), 1e-12))


@pytest.mark.parametrize(("precision", "digits"), [(np.float32, 2e-5), (np.float64, 1e-11)], ids=["single", "double"])
def test_the_manifolds_matrix_is_that_of_both_bodies(
    rng: np.random.Generator, fixed: bool, precision: Any, digits: float
) -> None:
    """K_vv, K_wv and K_ww: change of velocity and spin by a force and a torque at the anchor, in the frame."""
    pairs = eight(rng, fixed)
    block = Block(pairs, precision)
    for lane, pair in enumerate(block.pairs):
        K = pair.response()
        close(block.symmetric(s.B_KVV, lane, 3), K[:3, :3], digits)
        close(block.get(s.B_KWV, lane, 9).reshape(3, 3), K[3:, :3], digits)
        close(block.symmetric(s.B_KWW, lane, 3), K[3:, 3:], digits)
        close(K, K.T, 1e-12)
        assert block.get(s.B_SCALE, lane) == pytest.approx(pair.scale, rel=1e-6)


def test_what_an_impulse_does_to_a_body_is_in_the_frame(rng: np.random.Generator, fixed: bool) -> None:
    pairs = eight(rng, fixed)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        B = pair.frame
        close(block.get(s.B_NORMAL, lane, 3), B[:, 0])
        close(block.get(s.B_TANGENT, lane, 3), B[:, 1])
        close(block.get(s.B_ARM_A, lane, 3), B.T @ pair.ra)
        close(block.get(s.B_ARM_B, lane, 3), B.T @ pair.rb)
        close(block.get(s.B_MASS_A, lane), pair.ma * pair.scale)
        close(block.get(s.B_MASS_B, lane), pair.mb * pair.scale)
        close(block.symmetric(s.B_INERTIA_A, lane, 3), B.T @ pair.Ia @ B * pair.scale)
        close(block.symmetric(s.B_INERTIA_B, lane, 3), B.T @ pair.Ib @ B * pair.scale)


@pytest.mark.parametrize("points", [1, 2, 3, 4])
def test_the_matrix_of_friction_is_that_at_the_centre_of_pressure(
    rng: np.random.Generator, fixed: bool, points: int
) -> None:
    """D K_P D, and its inverse; a patch without extent has no torque, and a one in its place."""
    pairs = eight(rng, fixed, points=points)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        Tm = block.get(s.B_TORQUE, lane)
        assert (Tm == 0.0) == (points == 1)
        close(block.get(s.B_CENTER, lane, 2), pair.center())
        J = pair.friction(Tm)
        wanted = J @ pair.response() @ J.T + np.diag([0.0, 0.0, float(Tm == 0.0)])
        close(block.symmetric(s.B_FRICTION, lane, 3), wanted)
        close(block.symmetric(s.B_FRICTION_INVERSE, lane, 3) @ wanted, np.eye(3), 1e-8)


@pytest.mark.parametrize("points", [1, 2, 3, 4])
def test_the_inverse_of_the_normals_is_that_of_the_softened_matrix(
    rng: np.random.Generator, fixed: bool, points: int
) -> None:
    pairs = eight(rng, fixed, points=points)
    block = Block(pairs)
    ratio = SOFT_STIFF if fixed else SOFT
    for lane, pair in enumerate(block.pairs):
        G = pair.normals()[:points]
        A = G @ pair.response() @ G.T
        gamma = ratio * np.diag(A)
        close(block.get(s.B_SOFT, lane, 4)[:points], gamma)
        wanted = np.zeros((4, 4))
        wanted[:points, :points] = np.linalg.inv(A + np.diag(gamma))
        close(block.symmetric(s.B_INVERSE, lane, 4), wanted, 1e-8)
        assert block.get(s.B_BETA, lane) == (BETA_STIFF if fixed else BETA)


def test_where_friction_sticks_the_normals_meet_what_friction_leaves(rng: np.random.Generator, fixed: bool) -> None:
    """The Schur complement of friction in the matrix of normals and friction together, with the same compliance."""
    pairs = eight(rng, fixed)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        K, G, J = pair.response(), pair.normals(), pair.friction(block.get(s.B_TORQUE, lane))
        A = G @ K @ G.T
        gamma = (SOFT_STIFF if fixed else SOFT) * np.diag(A)
        stuck = A - G @ K @ J.T @ np.linalg.inv(J @ K @ J.T) @ J @ K @ G.T
        close(block.symmetric(s.B_INVERSE_STUCK, lane, 4) @ (stuck + np.diag(gamma)), np.eye(4), 1e-7)


def test_the_load_at_the_centre_of_pressure_meets_one_over_k(rng: np.random.Generator, fixed: bool) -> None:
    pairs = eight(rng, fixed)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        x, y = pair.center()
        j = np.array([1, 0, 0, 0, y, -x])
        close(block.get(s.B_RIGID, lane), 1.0 / (j @ pair.response() @ j))


def test_impulses_are_forces_times_the_substep_in_units_of_the_pairs_mass(rng: np.random.Generator) -> None:
    pairs = eight(rng)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        unit = H / pair.scale
        close(block.get(s.B_LOAD, lane, 4), pair.loads * unit)
        along = pair.frame[:, 1:].T @ pair.pull
        x, y = pair.center()
        # no more torque than twice what the face can hold
        most = CARRIED * 0.6 * pair.loads.sum()
        twist = np.clip((pair.spin - (x * along[1] - y * along[0])) / block.get(s.B_TORQUE, lane), -most, most)
        close(block.get(s.B_PULL, lane, 3), np.array([*along, twist]) * unit)


@pytest.mark.parametrize("tilt", [0.0, 1e-3])
def test_separations_follow_the_bodies_to_second_order(rng: np.random.Generator, tilt: float) -> None:
    """What b has moved against a along n, and turned: at a point of b's face d the gap grows by n . (tilt x d)."""
    pairs = eight(rng, tilt=tilt)
    block = Block(pairs)
    for lane, pair in enumerate(block.pairs):
        n = pair.frame[:, 0]
        arms = pair.places @ pair.frame[:, 1:].T
        wanted = pair.gaps + n @ pair.shift + (arms @ (turned(pair.tilt) - np.eye(3)).T) @ n
        np.testing.assert_allclose(block.get(s.B_GAP, lane, 4), wanted, rtol=0, atol=1e-12 + 5 * tilt**2)


def test_lanes_that_nobody_uses_hold_finite_numbers(rng: np.random.Generator) -> None:
    """And a lane does not depend on what lies beside it."""
    pairs = eight(rng)
    for count in range(LANES):
        block = Block(pairs[:count])
        # what is too deep is looked for afterwards, the slip written by the warm start, misses by passes, and the last
        # ones by laws alone
        later = [s.B_BURIED, *range(s.B_SLIP, s.B_SLIP + 3), s.B_MISS, *range(s.B_SCALED, s.FIELDS)]
        assert np.isfinite(np.delete(block.rows, later, axis=0)).all()
        np.testing.assert_array_equal(block.rows[:, :count], Block(pairs).rows[:, :count])


# --- the patch --------------------------------------------------------------------------------------------------------


def patch_of(corners: Any, loads: Any, precision: Any = np.float64) -> tuple[float, Array, Array]:
    """T_m, the surface's coefficients and the turn of a face, corners (n, 2) counterclockwise with these loads."""
    corners = np.asarray(corners, float)
    contacts, tags = np.zeros((4, CONTACT_WIDTH)), np.zeros((4, TAGS_WIDTH), np.int64)
    contacts[: len(corners), POINT : POINT + 2] = corners
    center = Vec3(*corners.mean(axis=0), 0.0)
    row = np.zeros((1, s.MANIFOLD_WIDTH))
    u, _ = measure_face(
        contacts,
        tags,
        len(corners),
        center,
        Vec3(0.0, 0.0, 1.0),
        np.zeros((SCRATCH, 5)),
        row,
        np.zeros((1, s.CORNERS_WIDTH)),
        0,
    )

    class Face(Pair):
        def write(self, manifolds: Array, aux: Array, slot: int, a: int, b: int) -> None:
            super().write(manifolds, aux, slot, a, b)
            for first, width in ((s.PLACE_U, 8), (s.EVEN, 7)):
                manifolds[slot, first : first + width] = row[0, first : first + width]
            manifolds[slot, s.LOAD : s.LOAD + 4] = 0.0
            manifolds[slot, s.LOAD : s.LOAD + len(corners)] = loads

    block = Block([Face(np.random.default_rng(1))], precision)
    turn = np.arctan2(u.y, u.x) + np.arctan2(block.get(s.B_TURN + 1, 0), block.get(s.B_TURN, 0))
    return block.get(s.B_TORQUE, 0), block.get(s.B_SURFACE, 0, 8), np.array([np.cos(turn), np.sin(turn)])


def corners_of(length: float, width: float) -> Array:
    """Of a rectangle, from the lower left."""
    return 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])


@pytest.mark.parametrize(
    ("sides", "loads", "wanted", "within"),
    [
        ((1, 1), (1, 1, 1, 1), 0.38260, 4e-4),  # the mean arm of a square, by its integral
        ((1, 1), (0, 0, 0, 0), 0.38260, 4e-4),  # no load yet: an even one
        ((2, 1), (1, 1, 1, 1), 0.9190 * np.sqrt(5 / 12), 4e-4),
        ((1, 1), (1, 1, 0, 0), 0.25, 5e-3),  # an edge: a quarter of its length
        ((1, 1), (0, 3, 3, 0), 0.25, 5e-3),
        ((1, 1), (1, 1, 1, 0), 0.301, 0.05),  # three corners: the integral of linear pressure without tension
        ((1, 1), (3, 3, 2, 2), 0.36873, 0.02),  # a load off the middle: the integral of linear pressure
        ((1, 1), (1, 0, 0, 0), 0.0, 0.0),  # a single corner is a point
    ],
)
@pytest.mark.parametrize("precision", [np.float32, np.float64], ids=["single", "double"])
def test_the_torque_of_pure_spinning_follows_the_loads(
    sides: tuple[float, float], loads: Any, wanted: float, within: float, precision: Any
) -> None:
    assert patch_of(corners_of(*sides), loads, precision)[0] == pytest.approx(wanted, rel=within, abs=1e-12)


def test_loads_in_the_mode_that_solvers_leave_change_nothing() -> None:
    """(1 + h, 1 - h, 1 + h, 1 - h): an unconverged solver may spread the load so."""
    even, surface, _ = patch_of(corners_of(1, 0.7), (1, 1, 1, 1))
    other, other_surface, _ = patch_of(corners_of(1, 0.7), (1.3, 0.7, 1.3, 0.7))
    assert other == pytest.approx(even, rel=1e-12)
    np.testing.assert_allclose(other_surface, surface, rtol=0, atol=1e-9)


def test_two_points_are_a_line() -> None:
    """A quarter of its length, along it; and nothing at its end."""
    line = np.array([[-0.6, -0.8], [0.6, 0.8]])
    torque, _, axis = patch_of(line, (1, 1))
    assert torque == pytest.approx(0.5, rel=1e-6)
    np.testing.assert_allclose(np.abs(axis), [0.6, 0.8], atol=1e-6)
    assert patch_of(line, (1, 0))[0] == 0.0


def test_axes_are_those_of_the_pressure() -> None:
    """A square that is loaded towards a corner is narrow along that diagonal."""
    _, _, axis = patch_of(corners_of(1, 1), (1, 2, 4, 2))
    np.testing.assert_allclose(np.abs(axis), np.sqrt(0.5), atol=1e-6)
    assert axis[0] * axis[1] < 0.0


def test_single_precision_is_enough(rng: np.random.Generator) -> None:
    """Triangles and quadrilaterals of all sizes, and P anywhere, on the border too."""
    for trial in range(60):
        angle = np.sort(rng.uniform(0, 2 * np.pi, size=3 + trial % 2))
        if np.diff([*angle, angle[0] + 2 * np.pi]).max() > 0.9 * np.pi:
            continue
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=1) * [1.0, rng.uniform(0.2, 1.0)]
        corners *= np.exp(rng.uniform(-5.0, 5.0))
        loads = rng.dirichlet(np.ones(len(angle)))
        loads[rng.integers(0, len(angle))] *= rng.choice([1.0, 1.0, 1e-4, 0.0])
        wanted, surface, axis = patch_of(corners, loads)
        found, single, other = patch_of(corners, loads, np.float32)
        assert found == pytest.approx(wanted, rel=1e-3)
        # nearly as wide as long, a patch may take other axes
        if surface[0] < 0.6:
            np.testing.assert_allclose(np.abs(single), np.abs(surface), rtol=0, atol=0.02)
            assert abs(axis @ other) == pytest.approx(1.0, abs=1e-3)
