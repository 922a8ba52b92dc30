"""Vec3, Quat, Mat33: plain Python and compiled code agree bit for bit, and both agree with numpy and with algebra."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as some

from stiction.core import vec as v
from stiction.core.vec import Mat33, Quat, Vec3

from .support import Array, compiled, mat, matrix_of, product

# what is almost zero is zero, so that squares do not underflow and relative tolerances mean something
numbers = some.floats(-1e3, 1e3).map(lambda x: x if abs(x) > 1e-30 else 0.0)
any_numbers = some.floats(allow_nan=False, allow_infinity=False, width=64).filter(lambda x: abs(x) < 1e100)


def vectors(of: Any = numbers) -> Any:
    """Any Vec3."""
    return some.builds(Vec3, of, of, of)


def matrices(of: Any = numbers) -> Any:
    """Any Mat33."""
    return some.builds(Mat33, *[of] * 9)


def quaternions(of: Any = numbers) -> Any:
    """Any Quat, not normalised."""
    return some.builds(Quat, of, of, of, of)


def unit(q: Quat) -> Quat:
    """q of length 1."""
    size = math.sqrt(sum(c * c for c in q))
    assume(size > 1e-3)
    return Quat(*(c / size for c in q))


unit_quaternions = quaternions(some.floats(-1.0, 1.0)).map(unit)
angles = vectors(some.floats(-4.0, 4.0))


def bits(value: Any) -> list[bytes]:
    """Every number of a result as its eight bytes; one NaN is like another."""
    parts = value if isinstance(value, tuple) else (value,)
    return [b"nan" if math.isnan(x) else struct.pack("<d", x) for x in parts]


def array(value: Any) -> Array:
    """A Vec3, Quat or Mat33 as an array."""
    return np.array(value).reshape(3, 3) if isinstance(value, Mat33) else np.array(value)


# --- plain Python is the compiled code --------------------------------------------------------------------------------

KINDS: dict[str, Any] = {
    "v": vectors(any_numbers),
    "q": quaternions(any_numbers),
    "m": matrices(any_numbers),
    "s": any_numbers,
    "k": some.integers(0, 2),
}

CASES: dict[str, tuple[str, Callable[..., Any]]] = {
    "v + v": ("vv", lambda a, b: a + b),
    "v - v": ("vv", lambda a, b: a - b),
    "-v": ("v", lambda a: -a),
    "v * s": ("vs", lambda a, b: a * b),
    "s * v": ("sv", lambda a, b: a * b),
    "q * q": ("qq", lambda a, b: a * b),
    "m + m": ("mm", lambda a, b: a + b),
    "-m": ("m", lambda a: -a),
    "m @ v": ("mv", lambda a, b: a @ b),
    "m @ m": ("mm", lambda a, b: a @ b),
    "dot": ("vv", v.dot),
    "cross": ("vv", v.cross),
    "length": ("v", v.length),
    "columns": ("vvv", v.columns),
    "column": ("mk", v.column),
    "transpose": ("m", v.transpose),
    "rotation": ("q", v.rotation),
    "congruent": ("mm", v.congruent),
}


@pytest.mark.parametrize("name", CASES)
@given(data=some.data())
def test_plain_python_and_compiled_agree_bit_for_bit(name: str, data: Any) -> None:
    kinds, function = CASES[name]
    arguments = [data.draw(KINDS[kind]) for kind in kinds]
    plain = function(*arguments)
    machine = compiled(function)(*arguments)
    assert type(machine) is type(plain)
    assert bits(machine) == bits(plain)


@given(matrices())
def test_inverse_agrees_bit_for_bit(m: Mat33) -> None:
    a = m.yy * m.zz - m.yz * m.zy
    b = m.yz * m.zx - m.yx * m.zz
    c = m.yx * m.zy - m.yy * m.zx
    assume(m.xx * a + m.xy * b + m.xz * c != 0.0)  # Python refuses to divide by zero, a machine does not
    assert bits(compiled(v.inverse)(m)) == bits(v.inverse(m))


@given(unit_quaternions, angles)
def test_turn_agrees_to_the_last_digit(q: Quat, angle: Vec3) -> None:
    """Not bit for bit: sine and cosine are those of two libraries."""
    np.testing.assert_allclose(compiled(v.turn)(q, angle), v.turn(q, angle), rtol=0, atol=4e-16)


def test_rows_of_arrays_are_read_and_written_in_plain_python_and_compiled() -> None:
    def copy(source: Any, target: Any) -> None:
        v.put_vec3(target, 1, 2, v.vec3(source, 1, 2))
        v.put_quat(target, 1, 5, v.quat(source, 1, 5))
        v.put_mat33(target, 0, 1, v.mat33(source, 0, 1))

    source = np.arange(20.0).reshape(2, 10) + 0.5
    wanted = np.zeros_like(source)
    wanted[1, 2:9] = source[1, 2:9]
    wanted[0, 1:10] = source[0, 1:10]
    for run in (copy, compiled(copy)):
        target = np.zeros_like(source)
        run(source, target)
        np.testing.assert_array_equal(target, wanted)


def test_kinds_do_not_mix() -> None:
    """A quaternion is no vector, and nothing falls back to the operators of tuples."""
    a, q, m = Vec3(1.0, 2.0, 3.0), Quat(1.0, 0.0, 0.0, 0.0), mat(np.eye(3))
    for wrong, x, y in ((lambda a, b: a + b, a, q), (lambda a, b: a @ b, a, m)):
        with pytest.raises(numba.TypingError, match="No implementation of function"):
            compiled(wrong)(x, y)
    assert type(a + a) is Vec3
    assert type(a * 2.0) is type(2.0 * a) is Vec3
    assert type(m @ m) is type(m + m) is Mat33


# --- and both are right -----------------------------------------------------------------------------------------------


@given(vectors(), vectors(), numbers)
def test_vector_operators_against_numpy(a: Vec3, b: Vec3, s: float) -> None:
    x, y = array(a), array(b)
    np.testing.assert_array_equal(a + b, x + y)
    np.testing.assert_array_equal(a - b, x - y)
    np.testing.assert_array_equal(-a, -x)
    np.testing.assert_array_equal(a * s, x * s)
    np.testing.assert_array_equal(s * a, x * s)
    scale = float(np.linalg.norm(x) * np.linalg.norm(y))
    np.testing.assert_allclose(v.dot(a, b), x @ y, atol=1e-15 * scale, rtol=0)
    np.testing.assert_allclose(v.cross(a, b), np.cross(x, y), atol=1e-15 * scale, rtol=0)
    np.testing.assert_allclose(v.length(a), np.linalg.norm(x), rtol=1e-15)


@given(matrices(), matrices(), vectors())
def test_matrix_operators_against_numpy(a: Mat33, b: Mat33, x: Vec3) -> None:
    A, B = array(a), array(b)
    size = float(np.linalg.norm(A)) + 1.0
    np.testing.assert_array_equal(array(a + b), A + B)
    np.testing.assert_array_equal(array(-a), -A)
    np.testing.assert_allclose(array(a @ b), A @ B, rtol=0, atol=1e-15 * size * (float(np.linalg.norm(B)) + 1.0))
    np.testing.assert_allclose(a @ x, A @ array(x), rtol=0, atol=1e-15 * size * (v.length(x) + 1.0))
    np.testing.assert_array_equal(array(v.transpose(a)), A.T)
    np.testing.assert_array_equal(array(v.columns(*(v.column(a, k) for k in range(3)))), A)
    triple = array(v.congruent(a, b))
    np.testing.assert_allclose(triple, A @ B @ A.T, rtol=0, atol=1e-14 * size**2 * (float(np.linalg.norm(B)) + 1.0))


@given(matrices(some.floats(-2.0, 2.0)))
def test_inverse(m: Mat33) -> None:
    M = array(m)
    condition = float(np.linalg.cond(M))
    assume(condition < 1e4)
    np.testing.assert_allclose(array(v.inverse(m)) @ M, np.eye(3), rtol=0, atol=1e-14 * condition**2)


@given(vectors(), vectors(), vectors())
def test_cross_product(a: Vec3, b: Vec3, c: Vec3) -> None:
    la, lb, lc = (v.length(x) for x in (a, b, c))
    assert v.cross(a, b) == -v.cross(b, a)
    assert abs(v.dot(a, v.cross(a, b))) <= 4e-15 * la * la * lb
    # Jacobi's identity
    turned = v.cross(a, v.cross(b, c)) + v.cross(b, v.cross(c, a)) + v.cross(c, v.cross(a, b))
    assert v.length(turned) <= 2e-14 * la * lb * lc


@given(unit_quaternions, unit_quaternions, vectors())
def test_rotations(p: Quat, q: Quat, x: Vec3) -> None:
    R = array(v.rotation(q))
    np.testing.assert_allclose(R, matrix_of(np.array(q)), rtol=0, atol=4e-15)
    np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=4e-15)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=4e-15)
    np.testing.assert_allclose(p * q, product(p, q), rtol=0, atol=1e-15)
    # first q, then p
    np.testing.assert_allclose(
        v.rotation(p * q) @ x, v.rotation(p) @ (v.rotation(q) @ x), rtol=0, atol=1e-14 * (v.length(x) + 1.0)
    )
    # q x q* turns x as R does
    conjugate = Quat(q.w, -q.x, -q.y, -q.z)
    turned = q * Quat(0.0, *x) * conjugate
    np.testing.assert_allclose(turned[1:], v.rotation(q) @ x, rtol=0, atol=1e-14 * (v.length(x) + 1.0))


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    """Active rotations, column vectors."""
    half = math.sqrt(0.5)
    q = Quat(half, 0.0, 0.0, half)
    np.testing.assert_allclose(v.rotation(q) @ Vec3(1.0, 0.0, 0.0), (0, 1, 0), atol=1e-15)
    start = Quat(1.0, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(v.turn(start, Vec3(0.0, 0.0, math.pi / 2)), q, atol=1e-15)


@given(unit_quaternions, angles)
def test_turn_is_rodrigues_formula_in_world_axes(q: Quat, angle: Vec3) -> None:
    size = v.length(angle)
    assume(size > 1e-9)
    k = array(angle) / size
    S = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    rodrigues = np.eye(3) + math.sin(size) * S + (1 - math.cos(size)) * S @ S
    turned = v.turn(q, angle)
    assert math.fsum(c * c for c in turned) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(array(v.rotation(turned)), rodrigues @ matrix_of(np.array(q)), rtol=0, atol=1e-14)


@given(unit_quaternions, vectors(some.floats(-1.0, 1.0)), some.sampled_from([0.0, 1e-300, 1e-20, 1e-11, 1e-10, 1e-9]))
def test_turn_by_almost_nothing_is_smooth(q: Quat, direction: Vec3, size: float) -> None:
    """To first order q + (0, angle) q / 2, on both sides of the branch for small angles, but for the rounding of two
    norms."""
    angle = direction * size
    nearly = np.array(q) + 0.5 * product((0.0, *angle), q)
    np.testing.assert_allclose(v.turn(q, angle), nearly, rtol=0, atol=1e-15 + size * size)


@given(unit_quaternions, angles)
def test_turning_there_and_back(q: Quat, angle: Vec3) -> None:
    np.testing.assert_allclose(v.turn(v.turn(q, angle), -angle), q, rtol=0, atol=1e-15)
