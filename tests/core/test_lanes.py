"""Eight numbers that act as one: every operator of the lanes against numpy, and the functions of core on lanes.

Each kernel runs in three ways: compiled for eight float32 or eight float64, in plain Python with the same functions'
plain twins, and (in a process of its own) with numba switched off. A single operator is exact to the last bit; where
several meet, they may have been contracted to a fused multiply-add.
"""

from __future__ import annotations

import functools
import os
import platform
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import stiction
from stiction.core.contact_space import (
    collision_velocity,
    contact_basis,
    contact_matrix,
    planar_velocity,
    to_contact,
    world_inverse_inertia,
)
from stiction.core.lanes import (
    LANES,
    Lanes,
    all_of,
    any_of,
    gather,
    greatest,
    least,
    load,
    load_part,
    scatter,
    select,
    size_of,
    splat,
    sqrt,
    store,
    store_part,
)
from stiction.core.vec import Mat33, Quat, Vec3, cross, dot, inverse, rotation, transpose

from .support import Array, compiled, mat, matrix_of, random_inverse_inertia, random_unit, vec

NO_JIT = bool(numba.config.DISABLE_JIT)
PRECISIONS = [np.float32, np.float64]
WAYS = ["plain"] if NO_JIT else ["compiled", "plain"]

needs_compiler = pytest.mark.skipif(NO_JIT, reason="looks at what the compiler makes")


@pytest.fixture(params=WAYS)
def way(request: pytest.FixtureRequest) -> Callable[[Any], Any]:
    """How to run a kernel: compiled, or as it stands."""
    return compiled if request.param == "compiled" else lambda kernel: kernel


@pytest.fixture(params=PRECISIONS, ids=["single", "double"])
def precision(request: pytest.FixtureRequest) -> Any:
    """Of the lanes."""
    return request.param


# --- operators --------------------------------------------------------------------------------------------------------

OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "a + b": lambda a, b: a + b,
    "a - b": lambda a, b: a - b,
    "a * b": lambda a, b: a * b,
    "a / b": lambda a, b: a / b,
    "-a": lambda a, b: -a,
    "sqrt(a)": lambda a, b: np.sqrt(a),
    "size_of(a)": lambda a, b: np.abs(a),
    "least(a, b)": lambda a, b: np.where(a < b, a, b),
    "greatest(a, b)": lambda a, b: np.where(a > b, a, b),
    "a < b": lambda a, b: a < b,
    "a <= b": lambda a, b: a <= b,
    "a > b": lambda a, b: a > b,
    "a >= b": lambda a, b: a >= b,
    "~(a < b)": lambda a, b: ~(a < b),
    "(a < b) & (a > 0)": lambda a, b: (a < b) & (a > 0),
    "(a < b) | (a > 0)": lambda a, b: (a < b) | (a > 0),
    "select(a < b, a, b)": lambda a, b: np.where(a < b, a, b),
    "select of masks": lambda a, b: np.where(a < b, a > 0, b > 0),
}
"""What rows of ``operators`` hold, and the same of two arrays."""


def operators(x: Any, y: Any) -> None:
    """Every operator of two lanes; a mask is told as ones and zeros."""
    a, b = load(x, 0), load(x, 1)
    one, zero = splat(x, 1.0), splat(x, 0.0)
    store(y, 0, a + b)
    store(y, 1, a - b)
    store(y, 2, a * b)
    store(y, 3, a / b)
    store(y, 4, -a)
    store(y, 5, sqrt(a))
    store(y, 6, size_of(a))
    store(y, 7, least(a, b))
    store(y, 8, greatest(a, b))
    store(y, 9, select(a < b, one, zero))
    store(y, 10, select(a <= b, one, zero))
    store(y, 11, select(a > b, one, zero))
    store(y, 12, select(a >= b, one, zero))
    store(y, 13, select(~(a < b), one, zero))
    store(y, 14, select((a < b) & (a > zero), one, zero))
    store(y, 15, select((a < b) | (a > zero), one, zero))
    store(y, 16, select(a < b, a, b))
    store(y, 17, select(select(a < b, a > zero, b > zero), one, zero))


def same(found: Array, wanted: Array) -> bool:
    """Equal, NaN and the sign of zero included; which NaN does not matter."""
    return bool(
        found.dtype == wanted.dtype
        and np.array_equal(found, wanted, equal_nan=True)
        and np.array_equal(np.signbit(found[~np.isnan(found)]), np.signbit(wanted[~np.isnan(wanted)]))
    )


def results(way: Any, kernel: Any, x: Array, rows: int) -> Array:
    """The rows that a kernel writes; one that it does not write stays infinite."""
    y = np.full((rows, LANES), np.inf, x.dtype)
    way(kernel)(x, y)
    return y


def pairs(rng: np.random.Generator, precision: Any) -> list[Array]:
    """Pairs of eight numbers: of all sizes, equal ones, zeros, infinities, NaN on either side."""
    sizes = np.exp(rng.uniform(-20, 20, size=(2, LANES))) * rng.choice([-1, 1], size=(2, LANES))
    special = np.array([[np.nan, 1, np.nan, 0.0, -0.0, np.inf, 1, 3], [1, np.nan, np.nan, -0.0, 0, np.inf, 0, 3]])
    return [p.astype(precision) for p in (sizes, rng.normal(size=(2, LANES)), special, special[::-1].copy())]


def test_operators_are_those_of_numpy_to_the_last_bit(rng: np.random.Generator, way: Any, precision: Any) -> None:
    for x in pairs(rng, precision):
        found = results(way, operators, x, len(OPERATORS))
        for row, (name, function) in zip(found, OPERATORS.items(), strict=True):
            with np.errstate(all="ignore"):
                wanted = function(*x).astype(precision)
            assert same(row, wanted), f"{name} of {x}: {row}, not {wanted}"


SCALARS: dict[str, Callable[[Any, Any], Any]] = {
    "a + s": lambda a, s: a + s,
    "s + a": lambda a, s: s + a,
    "a - s": lambda a, s: a - s,
    "s - a": lambda a, s: s - a,
    "a * s": lambda a, s: a * s,
    "s * a": lambda a, s: s * a,
    "a / s": lambda a, s: a / s,
    "s / a": lambda a, s: s / a,
    "least(a, s)": lambda a, s: np.where(a < s, a, s),
    "greatest(s, a)": lambda a, s: np.where(s > a, s, a),
    "a < s": lambda a, s: a < s,
    "a <= s": lambda a, s: a <= s,
    "s > a": lambda a, s: s > a,
    "s >= a": lambda a, s: s >= a,
    "select(a < s, a, s)": lambda a, s: np.where(a < s, a, s),
    "select(a < s, s, a)": lambda a, s: np.where(a < s, s, a),
    "splat(s)": np.full_like,
}


def scalars(s: Any, x: Any, y: Any) -> None:
    """Every operator of lanes and a number."""
    a, one, zero = load(x, 0), splat(x, 1.0), splat(x, 0.0)
    store(y, 0, a + s)
    store(y, 1, s + a)
    store(y, 2, a - s)
    store(y, 3, s - a)
    store(y, 4, a * s)
    store(y, 5, s * a)
    store(y, 6, a / s)
    store(y, 7, s / a)
    store(y, 8, least(a, s))
    store(y, 9, greatest(s, a))
    store(y, 10, select(a < s, one, zero))
    store(y, 11, select(a <= s, one, zero))
    store(y, 12, select(s > a, one, zero))
    store(y, 13, select(s >= a, one, zero))
    store(y, 14, select(a < s, a, s))
    store(y, 15, select(a < s, s, a))
    store(y, 16, splat(x, s))


@pytest.mark.parametrize("s", [0.1, 3, -2, 0.0], ids=repr)
def test_a_number_is_the_same_in_all_lanes_and_takes_their_precision(way: Any, precision: Any, s: Any) -> None:
    """0.1 is not a float32: it is rounded before it acts."""
    x = np.array([[-2, 0.1, 3, 0.0, 1e30, -1e-30, np.nan, 1 / 3]], precision)
    y = np.full((len(SCALARS), LANES), np.inf, precision)
    way(scalars)(s, x, y)
    for row, (name, function) in zip(y, SCALARS.items(), strict=True):
        with np.errstate(all="ignore"):
            wanted = function(x[0], precision(s)).astype(precision)
        assert same(row, wanted), f"{name}: {row}, not {wanted}"


def of_numbers(x: Any, y: Any) -> None:
    """The named functions of plain numbers, too."""
    for k in range(LANES):
        a, b = x[0, k], x[1, k]
        y[0, k] = least(a, b)
        y[1, k] = greatest(a, b)
        y[2, k] = select(a < b, a, b)
        y[3, k] = size_of(a)
        y[4, k] = sqrt(size_of(a))
        y[5, k] = 1.0 if any_of(a < b) else 0.0
        y[6, k] = 1.0 if all_of(a < b) else 0.0


def test_the_same_functions_take_plain_numbers(rng: np.random.Generator, way: Any, precision: Any) -> None:
    for x in pairs(rng, precision):
        a, b = x
        y = results(way, of_numbers, x, 7)
        wanted = [np.where(a < b, a, b), np.where(a > b, a, b), np.where(a < b, a, b), np.abs(a), np.sqrt(np.abs(a))]
        for row, want in zip(y, [*wanted, (a < b).astype(precision), (a < b).astype(precision)], strict=True):
            assert same(row, want.astype(precision))


def asked(x: Any, limit: Any) -> Any:
    """What branches ask of a mask."""
    a = load(x, 0)
    return any_of(a < limit), all_of(a < limit), any_of(~(a < limit)), all_of(~(a < limit))


@pytest.mark.parametrize(
    ("limit", "answers"),
    [(0.5, (False, False, True, True)), (1.5, (True, False, True, False)), (7.5, (True, False, True, False)),
     (8.5, (True, True, False, False)), (np.nan, (False, False, True, True))],
)  # fmt: skip
def test_a_branch_asks_whether_some_or_all_are_true(way: Any, precision: Any, limit: float, answers: Any) -> None:
    x = np.arange(1.0, 9.0, dtype=precision)[None]
    assert tuple(bool(answer) for answer in way(asked)(x, limit)) == answers


def chained(x: Any, y: Any) -> None:
    """Sums of products, which may be contracted."""
    a, b, c = load(x, 0), load(x, 1), load(x, 2)
    store(y, 0, a * b + c)
    store(y, 1, a * b - c * a)
    store(y, 2, (a + b) * c + 2.0 * a)


def test_a_sum_of_products_is_right_to_a_few_digits(rng: np.random.Generator, way: Any, precision: Any) -> None:
    x = rng.normal(size=(3, LANES)).astype(precision)
    a, b, c = x.astype(np.float64)
    y = results(way, chained, x, 3)
    largest = np.abs(a * b) + np.abs(c * a) + np.abs(b * c) + np.abs(c) + 2 * np.abs(a)
    for row, want in zip(y, [a * b + c, a * b - c * a, (a + b) * c + 2 * a], strict=True):
        assert (np.abs(row - want) <= 4 * np.finfo(precision).eps * largest).all()


# --- memory -----------------------------------------------------------------------------------------------------------


def copy_rows(x: Any, y: Any) -> None:
    """Row by row, in the other order."""
    for i in range(x.shape[0]):
        store(y, x.shape[0] - 1 - i, load(x, i))


def copy_part(x: Any, y: Any, i: Any, k: Any) -> None:
    """Columns k to k + 7 of row i, to row 0 from column 1 on."""
    store_part(y, 0, 1, load_part(x, i, k))


def test_rows_are_loaded_and_stored(rng: np.random.Generator, way: Any, precision: Any) -> None:
    x = rng.normal(size=(5, LANES)).astype(precision)
    np.testing.assert_array_equal(results(way, copy_rows, x, 5), x[::-1])


def test_a_part_of_a_row_is_loaded_and_stored_and_nothing_else(
    rng: np.random.Generator, way: Any, precision: Any
) -> None:
    x = rng.normal(size=(3, 13)).astype(precision)
    for i, k in ((0, 0), (1, 5), (2, 3)):
        y = np.full((2, 11), 7.0, precision)
        way(copy_part)(x, y, i, k)
        np.testing.assert_array_equal(y[0, 1:9], x[i, k : k + LANES])
        assert (np.delete(y[0], range(1, 9)) == 7.0).all()
        assert (y[1] == 7.0).all()


def take(rows: Any, index: Any, i: Any, k: Any, y: Any) -> None:
    """What ``gather`` gives, value j in row j."""
    values = gather(rows, index, i, k)
    store(y, 0, values[0])
    store(y, 1, values[1])
    store(y, 2, values[2])
    store(y, 3, values[3])
    store(y, 4, values[4])
    store(y, 5, values[5])
    store(y, 6, values[6])
    store(y, 7, values[7])


def give(rows: Any, index: Any, i: Any, k: Any, x: Any) -> None:
    """Scatter the rows of x."""
    values = (load(x, 0), load(x, 1), load(x, 2), load(x, 3), load(x, 4), load(x, 5), load(x, 6), load(x, 7))
    scatter(rows, index, i, k, values)


INDEX = np.array([[7, 6, 5, 4, 3, 2, 1, 0], [3, 9, 3, 0, 9, 9, 1, 0], [4, 4, 4, 4, 4, 4, 4, 4]])
"""Each row names eight rows; some more than once."""


@pytest.mark.parametrize("kind", [np.int32, np.int64])
@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("k", [0, 3, 8])
def test_gather_transposes_the_rows_that_are_named(
    rng: np.random.Generator, way: Any, precision: Any, kind: Any, i: int, k: int
) -> None:
    rows, y = rng.normal(size=(10, 16)).astype(precision), np.full((LANES, LANES), np.inf, precision)
    way(take)(rows, INDEX.astype(kind), i, k, y)
    np.testing.assert_array_equal(y, rows[INDEX[i], k : k + LANES].T)


@pytest.mark.parametrize("kind", [np.int32, np.int64])
@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("k", [0, 3, 8])
def test_scatter_writes_what_gather_reads_and_the_later_lane_remains(
    rng: np.random.Generator, way: Any, precision: Any, kind: Any, i: int, k: int
) -> None:
    rows, x = rng.normal(size=(10, 16)).astype(precision), rng.normal(size=(LANES, LANES)).astype(precision)
    wanted = rows.copy()
    for lane in range(LANES):
        wanted[INDEX[i, lane], k : k + LANES] = x[:, lane]
    way(give)(rows, INDEX.astype(kind), i, k, x)
    np.testing.assert_array_equal(rows, wanted)


def test_gathering_eight_neighbours_transposes_them(way: Any, precision: Any) -> None:
    """Each place of the 8 x 8 goes to its own: no two shuffles cancel."""
    rows = np.arange(64, dtype=precision).reshape(8, 8)
    y = np.full((LANES, LANES), np.inf, precision)
    way(take)(rows, np.arange(8)[None], 0, 0, y)
    np.testing.assert_array_equal(y, rows.T)


@needs_compiler
def test_what_is_not_an_array_of_rows_is_refused() -> None:
    """Lanes of another precision, and arrays whose rows do not lie side by side, do not compile."""

    def mixed(x: Any, y: Any) -> None:
        store(y, 0, load(x, 0))

    def added(x: Any, y: Any) -> None:
        store(x, 0, load(x, 0) + load(y, 0))

    single, double = np.zeros((1, LANES), np.float32), np.zeros((1, LANES))
    for kernel in (mixed, added):
        with pytest.raises(numba.core.errors.TypingError):
            numba.njit(kernel)(single, double)
    with pytest.raises(numba.core.errors.TypingError):
        numba.njit(copy_rows)(np.zeros((LANES, 2)).T, double)


# --- functions of core on lanes ---------------------------------------------------------------------------------------

INPUTS, OUTPUTS = 60, 75


@numba.extending.register_jitable
def load_one(row: Any, i: Any) -> Any:
    """The scalar counterpart of ``load``: number i of one contact."""
    return float(row[i])


@numba.extending.register_jitable
def store_one(row: Any, i: Any, value: Any) -> Any:
    """The scalar counterpart of ``store``."""
    row[i] = value


@functools.cache
def make_kernel(get: Callable[..., Any], put: Callable[..., Any]) -> Any:
    """A kernel that computes all that a solver needs of a contact; ``get`` and ``put`` decide on what numbers."""

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


PIECES = [(0, 1), (1, 4), (4, 7), (7, 16), (16, 25), (25, 34), (34, 37), (37, 40), (40, 49), (49, 52), (52, 61),
          (61, 64), (64, 73), (73, 75)]  # fmt: skip
"""Rows of the outputs that belong together, so that an error is compared with the largest of them."""


def condition(rng_row: Array) -> float:
    """Condition number of the contact matrix in a column of outputs."""
    return float(np.linalg.cond(rng_row[16:25].reshape(3, 3)))


def test_eight_contacts_at_once_are_eight_contacts_one_by_one(
    rng: np.random.Generator, way: Any, precision: Any
) -> None:
    """Up to what contraction rounds differently; the inverse of K enlarges that by the condition of K."""
    for _ in range(10):
        x = random_contacts(rng)
        at_once = results(way, make_kernel(load, store), x.astype(precision), OUTPUTS)
        for lane in range(LANES):
            alone = np.full(OUTPUTS, np.nan)
            way(make_kernel(load_one, store_one))(np.ascontiguousarray(x[:, lane]), alone)
            assert np.isfinite(alone).all()
            digits = 200 * np.finfo(precision).eps
            for first, last in PIECES:
                found, wanted = at_once[first:last, lane], alone[first:last]
                worse = condition(alone) if first in {25, 37, 61} else 1.0
                # sums of products of numbers of about one to ten
                assert np.abs(found - wanted).max() <= digits * worse * max(np.abs(wanted).max(), 10.0)


def test_the_kernel_computes_what_it_says(rng: np.random.Generator, way: Any) -> None:
    """Against numpy, so that the comparison above does not compare two empty results."""
    x = random_contacts(rng)
    y = results(way, make_kernel(load, store), x, OUTPUTS)
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


@needs_compiler
def test_lanes_are_vectors_in_the_machine_code(rng: np.random.Generator, precision: Any) -> None:
    kernel = numba.njit(error_model="numpy")(make_kernel(load, store))
    kernel(random_contacts(rng).astype(precision), np.empty((OUTPUTS, LANES), precision))
    (signature,) = kernel.signatures
    kind, letter = ("double", "d") if precision is np.float64 else ("float", "s")
    code = kernel.inspect_llvm(signature)
    assert len(re.findall(rf"= fmul contract <8 x {kind}>", code)) > 100
    assert not re.findall(r"= f(?:add|sub|mul|div) (?:\w+ )*(?:double|float) ", code)
    # contracted, and nothing else: sums keep their order and NaN stays NaN
    assert not re.findall(r"= f\w+ (?:contract )?(?:fast|reassoc|nsz|arcp|nnan|ninf|afn)\b", code)

    machine = platform.machine().lower()
    assembly = kernel.inspect_asm(signature)
    if machine in {"x86_64", "amd64"}:
        assert len(re.findall(rf"\bv?f?n?m(?:ul|add\d+|sub\d+)p{letter}\b", assembly)) > 100
        assert not re.findall(rf"\bv?(?:add|sub|mul|div)s{letter}\b", assembly)
    elif machine in {"arm64", "aarch64"}:
        assert re.findall(r"\bf(?:mul|mla|mls)(?:\.[24][ds]|\s+v\d+\.[24][ds])", assembly)


@needs_compiler
def test_the_scalar_kernel_has_no_vectors_of_eight(rng: np.random.Generator) -> None:
    """So the check above can fail."""
    kernel = numba.njit(error_model="numpy")(make_kernel(load_one, store_one))
    kernel(random_contacts(rng)[:, 0].copy(), np.empty(OUTPUTS))
    (signature,) = kernel.signatures
    assert "<8 x double>" not in kernel.inspect_llvm(signature)


@needs_compiler
def test_what_branches_does_not_run_in_lanes() -> None:
    """The basis takes the sign of a number: not for lanes, and the type refuses instead of guessing."""

    def kernel(x: Any, y: Any) -> None:
        B = contact_basis(Vec3(load(x, 0), load(x, 1), load(x, 2)))
        store(y, 0, B.xx)

    with pytest.raises(numba.core.errors.TypingError, match="copysign"):
        numba.njit(kernel)(np.zeros((3, LANES)), np.zeros((1, LANES)))


# --- plain Python -----------------------------------------------------------------------------------------------------


def test_plain_lanes_show_what_they_hold_and_do_not_share_memory() -> None:
    rows = np.arange(16.0).reshape(2, LANES)
    value = load(rows, 1)
    assert isinstance(value, Lanes)
    assert repr(value) == f"Lanes({rows[1]})"
    rows[1] = 0.0
    np.testing.assert_array_equal(value.values, np.arange(8.0, 16.0))
    with pytest.raises(AttributeError):
        value.other = 1  # type: ignore[attr-defined]  # there is none, on purpose


def test_plain_python_runs_the_same_functions_on_numbers() -> None:
    one = mat(np.eye(3))
    o = vec((0, 0, 0))
    assert contact_matrix(0.5, one, o, 0.25, one, o, one) == mat(0.75 * np.eye(3))
    assert compiled(inverse)(mat(2.0 * np.eye(3))) == mat(0.5 * np.eye(3))


@needs_compiler
def test_everything_above_holds_with_the_compiler_switched_off() -> None:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(stiction.__file__).parents[1])}
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", __file__]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert " passed" in result.stdout
