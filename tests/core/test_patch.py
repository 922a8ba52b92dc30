"""Friction of a patch: the form of the limit surface, and the friction on it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stiction.core.friction.coulomb import secular_friction
from stiction.core.friction.patch import (
    FAR,
    Surface,
    Sym3,
    arm_of_pressure,
    gradient,
    hessian,
    inverse_sym,
    level,
    onto_surface,
    phi,
    slide,
    terms,
    times,
)
from stiction.core.friction.pressure import ELLIPSE, lopsided_surface
from stiction.core.lanes import LANES, load, store
from stiction.core.vec import Vec3
from stiction.verify.limit_surface import directions

from .support import Array, compiled, random_inverse_inertia, random_unit


def on_surface(k: Surface, rays: Array) -> Array:
    """Where rays from the origin meet the surface, (n, 3): s + C s^2 + B s^3 = 1 for the square of the length, by
    bisection."""
    C, B = terms(Vec3(*rays.T), k)
    low, high = np.zeros(len(rays)), np.full(len(rays), FAR)
    for _ in range(60):
        middle = 0.5 * (low + high)
        outside = middle + C * middle**2 + B * middle**3 > 1.0
        low, high = np.where(outside, low, middle), np.where(outside, middle, high)
    return np.asarray(rays * np.sqrt(low)[:, None])


LOPSIDED = [
    (0.0, 0.0, 0.0, 0.0),
    (9.0, 0.0, 0.0, 0.0),
    (0.0, 9.0, 0.0, 0.0),
    (-1.0, 1.0, 0.5, -0.5),
    (0.05, 0.05, 0.3, 0.0),
    (0.0, 0.0, 9.0, 0.0),
    (0.0, 0.0, 0.0, 9.0),
    (0.29, 0.0, 0.0, 0.0),
    (0.15, 0.2, 0.9, 0.0),
    (-0.15, -0.2, 0.9, 0.1),
]
"""Of the pressure along u and v, and of an even load; 9 is beyond all limits."""
SHAPES = [
    (q, t, j, *lop)
    for q in np.linspace(0.0, 1.0, 6)
    for t in (0.0, 0.4, 1.0)
    for j in (-1.0, 0.0, ELLIPSE)
    for lop in LOPSIDED
]
"""Arguments of lopsided_surface."""


@pytest.mark.parametrize("shape", SHAPES)
def test_the_surface_is_convex(shape: tuple[float, ...]) -> None:
    """The second fundamental form has no negative curvature anywhere; with an associated slip, friction is unique."""
    k = lopsided_surface(*shape)
    points = on_surface(k, directions(1500))
    d, H = gradient(Vec3(*points.T), k), hessian(Vec3(*points.T), k)
    normal = np.stack(d, axis=1) / np.linalg.norm(np.stack(d, axis=1), axis=1)[:, None]
    matrices = np.stack([[H.xx, H.xy, H.xz], [H.xy, H.yy, H.yz], [H.xz, H.yz, H.zz]]).transpose(2, 0, 1)
    across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    lowest = np.linalg.eigvalsh(across @ matrices @ across + 10.0 * (np.eye(3) - across))[:, 0]
    assert lowest.min() >= -1e-12


@pytest.mark.parametrize("shape", SHAPES)
def test_every_ray_meets_the_surface_once_and_inside_the_ball_that_is_said(
    rng: np.random.Generator, shape: tuple[float, ...]
) -> None:
    k = lopsided_surface(*shape)
    rays = directions(300)
    at = on_surface(k, rays)
    assert (at**2).sum(axis=1).max() < FAR
    inside = [level(Vec3(*(f * row)), k) for f in (0.2, 0.7, 0.999) for row in at]
    outside = [level(Vec3(*(f * row)), k) for f in (1.001, 1.1, 1.2, 2.0, 1e3, 1e12) for row in at]
    assert max(inside) < 1.0 < min(outside)


def test_gradient_and_hessian_are_the_derivatives_of_phi(rng: np.random.Generator) -> None:
    """By complex steps, which are exact."""
    for _ in range(50):
        k, g = Surface(*rng.uniform(-0.4, 2.0, size=8)), rng.normal(size=3)
        steps = 1e-30j * np.eye(3)
        found = [phi(Vec3(*(g + step)), k).imag / 1e-30 for step in steps]
        np.testing.assert_allclose(gradient(Vec3(*g), k), found, rtol=1e-12, atol=1e-12)
        rows = np.array([gradient(Vec3(*(g + step)), k) for step in steps]).imag / 1e-30
        H = hessian(Vec3(*g), k)
        wanted = [[H.xx, H.xy, H.xz], [H.xy, H.yy, H.yz], [H.xz, H.yz, H.zz]]
        np.testing.assert_allclose(rows, wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max())


def test_a_symmetric_matrix_times_and_inverse(rng: np.random.Generator) -> None:
    for _ in range(20):
        A = random_inverse_inertia(rng)
        packed, v = Sym3(*A[np.triu_indices(3)]), rng.normal(size=3)
        np.testing.assert_allclose(times(packed, Vec3(*v)), A @ v, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(inverse_sym(packed), np.linalg.inv(A)[np.triu_indices(3)], rtol=1e-9, atol=1e-9)


# --- sliding ----------------------------------------------------------------------------------------------------------

ROWS = 20
"""Of a problem: A (6), b (3), last (3), surface (8)."""


def solve_blocks(x: Any, y: Any) -> None:
    """Eight problems side by side: block i is rows 20 i to 20 i + 19 of x, its answers rows 3 i to 3 i + 2 of y."""
    for i in range(y.shape[0] // 3):
        o = ROWS * i
        A = Sym3(load(x, o), load(x, o + 1), load(x, o + 2), load(x, o + 3), load(x, o + 4), load(x, o + 5))
        b = Vec3(load(x, o + 6), load(x, o + 7), load(x, o + 8))
        last = Vec3(load(x, o + 9), load(x, o + 10), load(x, o + 11))
        k = Surface(
            load(x, o + 12), load(x, o + 13), load(x, o + 14), load(x, o + 15), load(x, o + 16), load(x, o + 17),
            load(x, o + 18), load(x, o + 19),
        )  # fmt: skip
        g = slide(A, b, last, k, b.x < np.inf)
        store(y, 3 * i, g.x)
        store(y, 3 * i + 1, g.y)
        store(y, 3 * i + 2, g.z)


class Problems:
    """n random patches that slide: columns of A, b and the surface, (n, ...), and the last answer."""

    def __init__(self, rng: np.random.Generator, n: int, *, point: bool = False) -> None:
        A, b, k = [], [], []
        while len(A) < n:
            size = np.sort(np.exp(rng.uniform(-1.6, 1.6, size=2)))[::-1]
            Mu, Mv = size**2 / 12
            q, kappa = arm_of_pressure(Mu, Mv)
            Tm = 0.0 if point else float(kappa * np.sqrt(Mu + Mv))
            # a box that stands on the face, pressed anywhere within it
            height, mass = np.exp(rng.uniform(-1, 1)), np.exp(rng.uniform(-3, 3))
            inertia = mass / 12 * np.array([size[1] ** 2 + height**2, size[0] ** 2 + height**2, (size**2).sum()])
            arm = np.array([*(rng.uniform(-0.5, 0.5, size=2) * size), -0.5 * height])
            S = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
            J = np.vstack([np.hstack([np.eye(3), -S])[:2], [[0, 0, 0, 0, 0, 1]]])
            K = J @ np.diag([*[1 / mass] * 3, *(1 / inertia)]) @ J.T
            D = np.diag([1.0, 1.0, Tm])
            F = D @ K @ D + (np.diag([0.0, 0.0, 1.0]) if point else 0.0)
            surface = lopsided_surface(float(q), rng.uniform(0.0, 1.0), rng.uniform(-1.0, ELLIPSE), *rng.normal(size=4))
            # the problem divided by the limit; the slip that friction meets is one to a thousand times what it can take
            stick = np.exp(rng.uniform(0.0, 6.9)) * random_unit(rng) * [1.0, 1.0, not point]
            if level(Vec3(*stick), surface) <= 1.0:
                continue
            A.append(F[np.triu_indices(3)])
            b.append(F @ stick)
            k.append(surface)
        self.A, self.b, self.k = np.array(A), np.array(b), np.array(k)
        self.g = np.zeros((n, 3))

    def matrix(self, i: int) -> Array:
        """A of one problem, (3, 3)."""
        full = np.zeros((3, 3))
        full[np.triu_indices(3)] = self.A[i]
        return full + full.T - np.diag(np.diag(full))

    def solve(self, precision: Any) -> None:
        """One pass over all of them, in blocks of eight, from the last answer."""
        x = np.hstack([self.A, self.b, self.g, self.k]).reshape(-1, LANES, ROWS).transpose(0, 2, 1)
        x = np.ascontiguousarray(x.reshape(-1, LANES), precision)
        y = np.full((x.shape[0] // ROWS * 3, LANES), np.nan, precision)
        compiled(solve_blocks)(x, y)
        self.g = y.reshape(-1, 3, LANES).transpose(0, 2, 1).reshape(-1, 3).astype(np.float64)

    def residuals(self) -> tuple[Array, Array, Array]:
        """Slip off the normal of the surface relative to the slip; |Phi - 1|; dissipation. All (n,)."""
        off, level_error, power = [], [], []
        for i in range(len(self.g)):
            k, g = Surface(*self.k[i]), self.g[i]
            slip = self.b[i] - self.matrix(i) @ g
            d = np.array(gradient(Vec3(*g), k))
            along = max(slip @ d / (d @ d), 0.0)
            off.append(np.linalg.norm(slip - along * d) / np.linalg.norm(self.b[i]))
            level_error.append(abs(phi(Vec3(*g), k) - 1.0))
            power.append(slip @ g / np.linalg.norm(slip))
        return np.array(off), np.array(level_error), np.array(power)


@pytest.mark.parametrize(("precision", "rounding"), [(np.float32, 1e-6), (np.float64, 1e-13)], ids=["single", "double"])
def test_sliding_friction_is_on_the_surface_and_the_slip_along_its_normal(
    rng: np.random.Generator, precision: Any, rounding: float
) -> None:
    """From nothing by Newton's squares, the last of which is at most that of a thousandth, times 20; from that the next
    pass gets 20 (2e-5)^2; then it is at rounding."""
    problems = Problems(rng, 1600)
    for most in (2e-5, max(8e-9, rounding), rounding):
        problems.solve(precision)
        off, level_error, power = problems.residuals()
        assert off.max() < most
        assert level_error.max() < 1e-5
        # slip against an outward normal of a convex set: at least as much as the nearest point of the surface gives
        assert power.min() > 0.8


def test_what_one_lane_computes_does_not_depend_on_the_others(rng: np.random.Generator) -> None:
    problems = Problems(rng, 64)
    problems.solve(np.float32)
    before = problems.g.copy()
    order = rng.permutation(64)
    shuffled = Problems(rng, 8)
    shuffled.A, shuffled.b, shuffled.k = problems.A[order], problems.b[order], problems.k[order]
    shuffled.g = np.zeros((64, 3))
    shuffled.solve(np.float32)
    np.testing.assert_array_equal(shuffled.g, before[order])


def test_a_patch_without_extent_is_a_point_with_coulombs_cone(rng: np.random.Generator) -> None:
    """T_m = 0: the secular equation in the plane."""
    problems = Problems(rng, 400, point=True)
    for _ in range(4):
        problems.solve(np.float64)
    for i in range(400):
        xx, xy, _, yy, *_ = problems.A[i]
        g1, g2, sticks = secular_friction(xx, xy, yy, problems.b[i, 0], problems.b[i, 1], 1.0)
        assert not sticks
        np.testing.assert_allclose(problems.g[i], (g1, g2, 0.0), atol=1e-9)


def test_friction_dissipates_as_much_as_it_can(rng: np.random.Generator) -> None:
    """Of all friction that the limit allows, what is found takes most from the slip that remains."""
    problems = Problems(rng, 80)
    for _ in range(4):
        problems.solve(np.float64)
    rays = np.vstack([directions(1500), -directions(1500)])
    for i in range(80):
        slip = problems.b[i] - problems.matrix(i) @ problems.g[i]
        others = on_surface(Surface(*problems.k[i]), rays) @ slip
        assert others.max() <= problems.g[i] @ slip * (1 + 1e-9)


def test_a_ray_is_put_onto_the_surface_in_two_steps(rng: np.random.Generator) -> None:
    for shape in SHAPES[::3]:
        k = lopsided_surface(*shape)
        for ray, at in zip(directions(50), on_surface(k, directions(50)), strict=True):
            found = np.array(onto_surface(Vec3(*(float(np.exp(rng.uniform(-5, 5))) * ray)), k))
            np.testing.assert_allclose(found, at, atol=5e-6)
