"""The lecture's heart, formula by formula: the basis, the skew matrix, the four steps to K, and what K means."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from stiction.core import contact_space as space
from stiction.core.vec import Vec3

from .support import Array, compiled, mat, matrix_of, random_inverse_inertia, random_unit, vec

POLES = [
    (0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0),
    (0, 0, 1.0), (0.0, -0.0, -0.0), (1e-9, 0, -1), (0, 1e-12, -1), (1e-300, 0, -1), (1, 0, -1e-17), (1, 0, -0.0),
    (0.6, 0.8, -1e-16), (1, 1, 1), (-1, -1, -1),
]  # fmt: skip
"""Normals where a basis is prone to break: axes, both sides of z = 0, almost straight down."""


def array(value: Any) -> Array:
    """A Vec3 or Mat33 as an array."""
    numbers = np.array(value)
    return numbers.reshape(3, 3) if numbers.size == 9 else numbers


def skew_of(r: Array) -> Array:
    """S with S x = r x x, by columns r x e_k."""
    return np.cross(r, np.eye(3)).T


# --- slide "Friction as impulses" -------------------------------------------------------------------------------------


def normals() -> list[Array]:
    """Poles and many random directions."""
    rng = np.random.default_rng(7)
    given = [np.array(n, float) for n in POLES if np.any(n)]
    return [n / np.linalg.norm(n) for n in given] + [random_unit(rng) for _ in range(2000)]


@pytest.mark.parametrize("run", [space.contact_basis, compiled(space.contact_basis)], ids=["plain", "compiled"])
def test_the_basis_is_orthonormal_and_right_handed_for_every_normal(run: Any) -> None:
    for n in normals():
        B = array(run(vec(n)))
        np.testing.assert_array_equal(B[:, 0], n)
        np.testing.assert_allclose(B.T @ B, np.eye(3), rtol=0, atol=2e-15)
        np.testing.assert_allclose(np.cross(B[:, 0], B[:, 1]), B[:, 2], rtol=0, atol=2e-15)


def test_the_basis_turns_smoothly_with_the_normal(rng: np.random.Generator) -> None:
    """But where n_z changes its sign, so that the sign of friction's components means something from step to step."""
    for _ in range(500):
        n = random_unit(rng)
        if abs(n[2]) < 1e-3:
            continue
        near = n + 1e-6 * random_unit(rng)
        near /= np.linalg.norm(near)
        change = array(space.contact_basis(vec(near))) - array(space.contact_basis(vec(n)))
        assert np.abs(change).max() < 1e-5


@given(*[some.builds(Vec3, *[some.floats(-10, 10)] * 3)] * 6, some.builds(Vec3, *[some.floats(-1, 1)] * 3))
def test_collision_and_planar_velocity(va: Vec3, wa: Vec3, ra: Vec3, vb: Vec3, wb: Vec3, rb: Vec3, x: Vec3) -> None:
    """v_collision = v_A - v_B at the point; v_planar = v_collision - n v_C has no component along n."""
    u = array(space.collision_velocity(va, wa, ra, vb, wb, rb))
    wanted = array(va) + np.cross(wa, ra) - array(vb) - np.cross(wb, rb)
    np.testing.assert_allclose(u, wanted, rtol=0, atol=1e-12)
    n = array(x) / np.linalg.norm(x) if np.linalg.norm(x) > 1e-3 else np.array([0.0, 0.0, 1.0])
    planar = array(space.planar_velocity(vec(u), vec(n)))
    assert abs(planar @ n) < 1e-12
    np.testing.assert_allclose(planar + n * (n @ u), u, rtol=0, atol=1e-12)


# --- slides "The skew-symmetric matrix" and "The algorithm for angular motion" ----------------------------------------


@given(some.builds(Vec3, *[some.floats(-10, 10)] * 3), some.builds(Vec3, *[some.floats(-10, 10)] * 3))
def test_the_skew_matrix_is_the_cross_product(a: Vec3, x: Vec3) -> None:
    S = array(space.skew(a))
    np.testing.assert_array_equal(S, -S.T)
    np.testing.assert_allclose(S @ array(x), np.cross(a, x), rtol=0, atol=1e-13)
    np.testing.assert_array_equal(S, skew_of(array(a)))


def test_each_of_the_four_steps(rng: np.random.Generator) -> None:
    """u = S_p B, dr = I^-1 u, dv = -S_p dr, B^-1 dv: each step is what its slide says, column by column."""
    for _ in range(100):
        r, I = rng.normal(size=3), random_inverse_inertia(rng)
        B = space.contact_basis(vec(random_unit(rng)))
        u = space.impulsive_torque(vec(r), B)
        dr = space.rotation_change(mat(I), u)
        dv = space.rotation_to_velocity(vec(r), dr)
        for k in range(3):
            torque = np.cross(r, array(B)[:, k])
            np.testing.assert_allclose(array(u)[:, k], torque, atol=1e-14)
            np.testing.assert_allclose(array(dr)[:, k], I @ torque, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(array(dv)[:, k], np.cross(I @ torque, r), rtol=1e-12, atol=1e-11)
        contact = array(space.to_contact(B, dv))
        np.testing.assert_allclose(array(B) @ contact, array(dv), rtol=1e-12, atol=1e-11)
        np.testing.assert_array_equal(array(space.inverse_mass_matrix(0.3)), 0.3 * np.eye(3))


def test_world_inverse_inertia_is_that_of_the_turned_body(rng: np.random.Generator) -> None:
    """R I^-1 R^T: point masses fixed to a body have, once turned by R, the tensor whose inverse this is."""
    for _ in range(50):
        points, masses = rng.normal(size=(6, 3)), rng.uniform(0.5, 2.0, size=6)
        R = matrix_of(random_unit(rng, 4))

        def inertia(x: Array, masses: Array = masses) -> Array:
            return np.asarray(sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, x, strict=True)))

        body = np.linalg.inv(inertia(points))
        world = np.linalg.inv(inertia(points @ R.T))
        np.testing.assert_allclose(array(space.world_inverse_inertia(mat(R), mat(body))), world, rtol=1e-10, atol=1e-12)


# --- K ----------------------------------------------------------------------------------------------------------------


class Pair:
    """Two random bodies that touch at a point. The second can be immovable."""

    def __init__(self, rng: np.random.Generator, fixed: bool) -> None:
        self.n = random_unit(rng)
        self.B = space.contact_basis(vec(self.n))
        self.ma, self.mb = rng.uniform(0.1, 10.0, size=2) * (1, not fixed)
        self.ia, self.ib = random_inverse_inertia(rng), random_inverse_inertia(rng) * (not fixed)
        self.ra, self.rb = rng.normal(size=(2, 3))

    def matrix(self, run: Any = space.contact_matrix) -> Array:
        """K as the package has it."""
        return array(run(self.ma, mat(self.ia), vec(self.ra), self.mb, mat(self.ib), vec(self.rb), self.B))

    def velocity_after(self, impulse: Array) -> Array:
        """v_A - v_B at the point, from rest, after a world impulse on B and its reaction on A: plain mechanics."""
        va, wa = -impulse * self.ma, self.ia @ np.cross(self.ra, -impulse)
        vb, wb = impulse * self.mb, self.ib @ np.cross(self.rb, impulse)
        return np.asarray(va + np.cross(wa, self.ra) - vb - np.cross(wb, self.rb))


@pytest.mark.parametrize("fixed", [False, True], ids=["two free bodies", "one against the ground"])
def test_k_is_what_unit_impulses_do_to_the_contact_velocity(rng: np.random.Generator, fixed: bool) -> None:
    for _ in range(200):
        pair = Pair(rng, fixed)
        B = array(pair.B)
        measured = -np.column_stack([B.T @ pair.velocity_after(B[:, k]) for k in range(3)])
        K = pair.matrix()
        np.testing.assert_allclose(K, measured, rtol=0, atol=1e-12 * np.abs(K).max())
        np.testing.assert_array_equal(pair.matrix(compiled(space.contact_matrix)), K)


@pytest.mark.parametrize("fixed", [False, True], ids=["two free bodies", "one against the ground"])
def test_k_is_symmetric_and_positive_definite(rng: np.random.Generator, fixed: bool) -> None:
    for _ in range(500):
        pair = Pair(rng, fixed)
        K = pair.matrix()
        np.testing.assert_allclose(K, K.T, rtol=0, atol=1e-13 * np.abs(K).max())
        # linear motion alone gives inverse masses; rotation only adds to them
        assert np.linalg.eigvalsh(0.5 * (K + K.T)).min() >= (pair.ma + pair.mb) * (1 - 1e-12)


def test_k_nn_is_the_formula_without_friction(rng: np.random.Generator) -> None:
    """1/m + n . ((I^-1 (r x n)) x r) of both bodies: slide "Angular motion to velocity", "Without friction"."""
    for _ in range(200):
        pair = Pair(rng, fixed=False)
        wanted = sum(
            m + pair.n @ np.cross(I @ np.cross(r, pair.n), r)
            for m, I, r in ((pair.ma, pair.ia, pair.ra), (pair.mb, pair.ib, pair.rb))
        )
        assert pair.matrix()[0, 0] == pytest.approx(wanted, rel=1e-12)


def test_a_sphere_on_the_ground_has_seven_halves_of_its_inverse_mass_in_the_plane() -> None:
    """m = 2, r = 3, I = 2/5 m r^2: normal 1/m, planar 1/m + r^2/I = 7/2 1/m, nothing off the diagonal."""
    inverse_inertia = mat(np.eye(3) / (0.4 * 2 * 9))
    B = space.contact_basis(Vec3(0.0, 0.0, -1.0))
    o = mat(np.zeros((3, 3)))
    K = space.contact_matrix(0.5, inverse_inertia, Vec3(0.0, 0.0, -3.0), 0.0, o, Vec3(0.0, 0.0, 0.0), B)
    np.testing.assert_allclose(array(K), np.diag([0.5, 1.75, 1.75]), atol=1e-15)


def test_g_max_makes_the_whole_change_of_velocity(rng: np.random.Generator) -> None:
    """Delta g = K^-1, g_max = Delta g v_mu, and applied to both bodies it does exactly that."""
    for _ in range(200):
        pair = Pair(rng, fixed=False)
        K, B = mat(pair.matrix()), array(pair.B)
        change = rng.normal(size=3)
        g = array(space.maximal_impulse(K, vec(change)))
        np.testing.assert_allclose(B.T @ pair.velocity_after(B @ g), -change, rtol=0, atol=1e-11)
        np.testing.assert_allclose(array(space.impulse_per_velocity(K)) @ array(K), np.eye(3), atol=1e-9)


def test_k_does_not_depend_on_the_axes_of_the_world(rng: np.random.Generator) -> None:
    """Turn the scene: K in the turned basis is the same matrix."""
    pair = Pair(rng, fixed=False)
    R = matrix_of(random_unit(rng, 4))
    turned = array(
        space.contact_matrix(
            pair.ma, mat(R @ pair.ia @ R.T), vec(R @ pair.ra), pair.mb, mat(R @ pair.ib @ R.T), vec(R @ pair.rb),
            mat(R @ array(pair.B)),
        )
    )  # fmt: skip
    np.testing.assert_allclose(turned, pair.matrix(), rtol=0, atol=1e-12 * np.abs(turned).max())
    assert math.isclose(np.trace(turned), np.trace(pair.matrix()), rel_tol=1e-12)
