"""Nothing in vec.py and contact_space.py stands in the way of lanes: their functions run on eight numbers at once.

One kernel computes everything a solver needs of a contact, on whatever kind of number its loads give it. It is compiled
twice, once for a float64 at a time and once for :mod:`tests.core.lane_type`, and both must agree bit for bit.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest

from stiction.core.contact_space import (
    collision_velocity,
    contact_basis,
    contact_matrix,
    planar_velocity,
    to_contact,
    world_inverse_inertia,
)
from stiction.core.vec import Mat33, Quat, Vec3, cross, dot, inverse, rotation, transpose

from .lane_type import LANES, f64x8, load, store
from .support import Array, compiled, mat, matrix_of, random_inverse_inertia, random_unit, vec

INPUTS, OUTPUTS = 60, 75


@numba.extending.register_jitable
def load_one(row: Any, i: Any) -> Any:
    """The scalar counterpart of ``load``: number i of one contact."""
    return row[i]


@numba.extending.register_jitable
def store_one(row: Any, i: Any, value: Any) -> Any:
    """The scalar counterpart of ``store``."""
    row[i] = value


def make_kernel(get: Callable[..., Any], put: Callable[..., Any]) -> Any:
    """The kernel for one kind of number; ``get`` and ``put`` decide which."""

    @numba.extending.register_jitable
    def get3(x: Any, k: Any) -> Any:
        return Vec3(get(x, k), get(x, k + 1), get(x, k + 2))

    @numba.extending.register_jitable
    def get9(x: Any, k: Any) -> Any:
        a, b, c = get3(x, k), get3(x, k + 3), get3(x, k + 6)
        return Mat33(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)

    @numba.extending.register_jitable
    def put3(y: Any, k: Any, v: Any) -> Any:
        put(y, k, v.x)
        put(y, k + 1, v.y)
        put(y, k + 2, v.z)

    @numba.extending.register_jitable
    def put9(y: Any, k: Any, m: Any) -> Any:
        put3(y, k, Vec3(m.xx, m.xy, m.xz))
        put3(y, k + 3, Vec3(m.yx, m.yy, m.yz))
        put3(y, k + 6, Vec3(m.zx, m.zy, m.zz))

    def kernel(x: Any, y: Any) -> None:
        va, wa, ra = get3(x, 0), get3(x, 3), get3(x, 6)
        vb, wb, rb = get3(x, 9), get3(x, 12), get3(x, 15)
        ia, ib = get9(x, 18), get9(x, 27)
        B = get9(x, 36)
        ma, mb = get(x, 45), get(x, 46)
        qa = Quat(get(x, 47), get(x, 48), get(x, 49), get(x, 50))
        qb = Quat(get(x, 51), get(x, 52), get(x, 53), get(x, 54))
        p = get3(x, 55)

        ia, ib = world_inverse_inertia(rotation(qa), ia), world_inverse_inertia(rotation(qb), ib)
        K = contact_matrix(ma, ia, ra, mb, ib, rb, B)
        n = Vec3(B.xx, B.yx, B.zx)
        u = collision_velocity(va, wa, ra, vb, wb, rb)
        g = inverse(K) @ to_contact(B, u)

        put(y, 0, dot(va, wb))
        put3(y, 1, cross(va, rb))
        put3(y, 4, B @ vb)
        put9(y, 7, rotation(qa) @ transpose(B))
        put9(y, 16, K)
        put9(y, 25, inverse(K))
        put3(y, 34, planar_velocity(u, n))
        put3(y, 37, g)
        q = qa * qb
        put9(y, 40, rotation(q) + -ia)
        put3(y, 49, va * ma + ma * vb - -p)
        put9(y, 52, inverse(B))
        put3(y, 61, B @ g)
        put9(y, 64, ib)
        put(y, 73, q.w)
        put(y, 74, q.z)

    return kernel


def random_contacts(rng: np.random.Generator) -> Array:
    """(INPUTS, 8): eight contacts of two bodies each, a column a contact, in the order in which the kernel reads."""
    x = np.empty((INPUTS, LANES))
    for lane in range(LANES):
        B = contact_basis(vec(random_unit(rng)))
        x[:, lane] = np.concatenate(
            [
                rng.normal(size=18),
                random_inverse_inertia(rng).ravel(),
                random_inverse_inertia(rng).ravel(),
                np.array(B),
                rng.uniform(0.1, 10.0, size=2),
                random_unit(rng, 4),
                random_unit(rng, 4),
                rng.normal(size=5),
            ]
        )
    return x


@pytest.fixture(scope="module")
def lanes() -> Any:
    """The kernel on eight lanes."""
    return numba.njit(error_model="numpy")(make_kernel(load, store))


@pytest.fixture(scope="module")
def scalar() -> Any:
    """The kernel on one float64."""
    return numba.njit(error_model="numpy")(make_kernel(load_one, store_one))


def test_eight_contacts_at_once_are_eight_contacts_one_by_one(
    rng: np.random.Generator, lanes: Any, scalar: Any
) -> None:
    for _ in range(20):
        x = random_contacts(rng)
        at_once = np.full((OUTPUTS, LANES), np.nan)
        lanes(x, at_once)
        for lane in range(LANES):
            alone = np.full(OUTPUTS, np.nan)
            scalar(np.ascontiguousarray(x[:, lane]), alone)
            assert np.isfinite(alone).all()
            assert at_once[:, lane].tobytes() == alone.tobytes()


def test_the_kernel_computes_what_it_says(rng: np.random.Generator, lanes: Any) -> None:
    """Against numpy, so that the comparison above does not compare two empty results."""
    x = random_contacts(rng)
    y = np.empty((OUTPUTS, LANES))
    lanes(x, y)
    for lane in range(LANES):
        va, wa, ra, vb, wb, rb = (x[k : k + 3, lane] for k in range(0, 18, 3))
        B = x[36:45, lane].reshape(3, 3)
        Ra, Rb = matrix_of(x[47:51, lane]), matrix_of(x[51:55, lane])
        ia = Ra @ x[18:27, lane].reshape(3, 3) @ Ra.T
        ib = Rb @ x[27:36, lane].reshape(3, 3) @ Rb.T

        def share(m: float, inertia: Array, r: Array, B: Array = B) -> Array:
            S = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
            return np.asarray(B.T @ (m * np.eye(3) - S @ inertia @ S) @ B)

        K = share(x[45, lane], ia, ra) + share(x[46, lane], ib, rb)
        u = va + np.cross(wa, ra) - vb - np.cross(wb, rb)
        np.testing.assert_allclose(y[16:25, lane].reshape(3, 3), K, rtol=1e-12, atol=1e-12 * np.abs(K).max())
        np.testing.assert_allclose(K @ y[37:40, lane], B.T @ u, atol=1e-9 * np.abs(u).max())
        np.testing.assert_allclose(y[1:4, lane], np.cross(va, rb), atol=1e-12)
        np.testing.assert_allclose(y[64:73, lane].reshape(3, 3), ib, atol=1e-12 * np.abs(ib).max())


def test_lanes_are_vectors_in_the_machine_code(rng: np.random.Generator, lanes: Any) -> None:
    lanes(random_contacts(rng), np.empty((OUTPUTS, LANES)))
    (signature,) = lanes.signatures
    code = lanes.inspect_llvm(signature)
    assert len(re.findall(r"= fmul <8 x double>", code)) > 100
    assert not re.findall(r"= f(?:add|sub|mul|div) (?:fast |reassoc |contract )*double ", code)
    assert not re.findall(r"= f\w+ (?:fast|reassoc|contract|nsz|arcp|nnan|ninf|afn)\b", code)

    machine = platform.machine().lower()
    assembly = lanes.inspect_asm(signature)
    if machine in {"x86_64", "amd64"}:
        assert len(re.findall(r"\bv?mulpd\b", assembly)) > 100
        assert not re.findall(r"\bv?(?:add|sub|mul|div)sd\b", assembly)
    elif machine in {"arm64", "aarch64"}:
        assert re.findall(r"\bfmul\.2d|\bfmul\s+v\d+\.2d", assembly)


def test_the_scalar_kernel_has_no_vectors_of_eight(rng: np.random.Generator, scalar: Any) -> None:
    """So the check above can fail."""
    scalar(random_contacts(rng)[:, 0].copy(), np.empty(OUTPUTS))
    (signature,) = scalar.signatures
    assert "fmul <8 x double>" not in scalar.inspect_llvm(signature)


def test_what_branches_does_not_run_in_lanes() -> None:
    """The basis takes the sign of a number: not yet for lanes, and the type refuses instead of guessing."""

    def kernel(x: Any, y: Any) -> None:
        B = contact_basis(Vec3(load(x, 0), load(x, 1), load(x, 2)))
        store(y, 0, B.xx)

    with pytest.raises(numba.core.errors.TypingError, match="copysign"):
        numba.njit(kernel)(np.zeros((3, LANES)), np.zeros((1, LANES)))


def test_plain_python_runs_the_same_functions() -> None:
    """The third way to run them."""
    one = mat(np.eye(3))
    o = vec((0, 0, 0))
    assert contact_matrix(0.5, one, o, 0.25, one, o, one) == mat(0.75 * np.eye(3))
    assert compiled(inverse)(mat(2.0 * np.eye(3))) == mat(0.5 * np.eye(3))
    assert repr(f64x8) == "F64x8"
