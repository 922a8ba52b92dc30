"""Vec3, Quat and Mat33: NamedTuples with operators, one source for three ways to run.

The same functions run in plain Python, compiled for one float64, and compiled for a SIMD value type whose fields are
eight numbers at once: nothing here branches on a value or calls a scalar-only function, except where it says so.
Convention: column vectors, ``M @ v``; rotations are active; a quaternion is (w, x, y, z).
"""

from __future__ import annotations

import math
import operator
from typing import Any, NamedTuple

from numba import types
from numba.extending import overload

from stiction.core.jit import HELPER, inlined, jit


class Vec3(NamedTuple):
    """Three numbers."""

    x: Any
    y: Any
    z: Any

    def __add__(a, b):
        return Vec3(a.x + b.x, a.y + b.y, a.z + b.z)

    def __sub__(a, b):
        return Vec3(a.x - b.x, a.y - b.y, a.z - b.z)

    def __neg__(a):
        return Vec3(-a.x, -a.y, -a.z)

    def __mul__(a, b):
        return Vec3(a.x * b, a.y * b, a.z * b)

    def __rmul__(a, b):
        return a * b


class Quat(NamedTuple):
    """A quaternion w + xi + yj + zk."""

    w: Any
    x: Any
    y: Any
    z: Any

    def __mul__(a, b):
        return Quat(
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        )


class Mat33(NamedTuple):
    """A 3x3 matrix by rows: ``xy`` is row x, column y."""

    xx: Any
    xy: Any
    xz: Any
    yx: Any
    yy: Any
    yz: Any
    zx: Any
    zy: Any
    zz: Any

    def __add__(a, b):
        return Mat33(
            a.xx + b.xx, a.xy + b.xy, a.xz + b.xz,
            a.yx + b.yx, a.yy + b.yy, a.yz + b.yz,
            a.zx + b.zx, a.zy + b.zy, a.zz + b.zz,
        )  # fmt: skip

    def __neg__(a):
        return Mat33(-a.xx, -a.xy, -a.xz, -a.yx, -a.yy, -a.yz, -a.zx, -a.zy, -a.zz)

    def __matmul__(a, b):
        return _matrix_times_vector(a, b) if isinstance(b, Vec3) else _matrix_times_matrix(a, b)


# --- the operators, compiled: the methods above are their one source (hence arguments called a and b) ----------------


def _is(kind: type, t: types.Type) -> bool:
    return isinstance(t, (types.NamedUniTuple, types.NamedTuple)) and t.instance_class is kind


def _is_ours(t: types.Type) -> bool:
    return _is(Vec3, t) or _is(Quat, t) or _is(Mat33, t)


def _method_of_both(name):
    """An overload for two values of the same kind, by the method of that name."""

    def choose(a, b):
        for kind in (Vec3, Quat, Mat33):
            if _is(kind, a) and _is(kind, b) and name in vars(kind):
                return vars(kind)[name]
        return None

    return choose


overload(operator.add, jit_options=HELPER)(_method_of_both("__add__"))
overload(operator.sub, jit_options=HELPER)(_method_of_both("__sub__"))


@overload(operator.neg, jit_options=HELPER)
def _neg(a):
    return next((kind.__neg__ for kind in (Vec3, Mat33) if _is(kind, a)), None)


@overload(operator.mul, jit_options=HELPER)
def _mul(a, b):
    if _is(Quat, a) and _is(Quat, b):
        return Quat.__mul__
    if _is(Vec3, a) and not _is_ours(b):
        return Vec3.__mul__
    if _is(Vec3, b) and not _is_ours(a):
        return lambda a, b: b * a
    return None


@overload(operator.matmul, jit_options=HELPER)
def _matmul(a, b):
    if _is(Mat33, a) and _is(Vec3, b):
        return lambda a, b: _matrix_times_vector(a, b)
    if _is(Mat33, a) and _is(Mat33, b):
        return lambda a, b: _matrix_times_matrix(a, b)
    return None


@inlined
def _matrix_times_vector(m, v):
    return Vec3(
        m.xx * v.x + m.xy * v.y + m.xz * v.z,
        m.yx * v.x + m.yy * v.y + m.yz * v.z,
        m.zx * v.x + m.zy * v.y + m.zz * v.z,
    )


@jit
def _matrix_times_matrix(a, b):
    return Mat33(
        a.xx * b.xx + a.xy * b.yx + a.xz * b.zx,
        a.xx * b.xy + a.xy * b.yy + a.xz * b.zy,
        a.xx * b.xz + a.xy * b.yz + a.xz * b.zz,
        a.yx * b.xx + a.yy * b.yx + a.yz * b.zx,
        a.yx * b.xy + a.yy * b.yy + a.yz * b.zy,
        a.yx * b.xz + a.yy * b.yz + a.yz * b.zz,
        a.zx * b.xx + a.zy * b.yx + a.zz * b.zx,
        a.zx * b.xy + a.zy * b.yy + a.zz * b.zy,
        a.zx * b.xz + a.zy * b.yz + a.zz * b.zz,
    )


# --- vectors ---------------------------------------------------------------------------------------------------------


@inlined
def dot(a, b):
    """a . b"""
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a, b):
    """a x b"""
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def length(a):
    """|a|, of one vector only (scalar square root)."""
    return math.sqrt(a.x * a.x + a.y * a.y + a.z * a.z)


# --- matrices --------------------------------------------------------------------------------------------------------


@jit
def columns(a, b, c):
    """The matrix whose columns are a, b, c."""
    return Mat33(a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z)


@inlined
def column(m, k):
    """Column k (0, 1, 2) of m, for one matrix only (branches)."""
    if k == 0:
        return Vec3(m.xx, m.yx, m.zx)
    if k == 1:
        return Vec3(m.xy, m.yy, m.zy)
    return Vec3(m.xz, m.yz, m.zz)


@inlined
def transpose(m):
    """m^T"""
    return Mat33(m.xx, m.yx, m.zx, m.xy, m.yy, m.zy, m.xz, m.yz, m.zz)


@jit
def inverse(m):
    """m^-1 by cofactors; meant for well conditioned matrices such as K and inertia tensors."""
    a = m.yy * m.zz - m.yz * m.zy
    b = m.yz * m.zx - m.yx * m.zz
    c = m.yx * m.zy - m.yy * m.zx
    d = m.xx * a + m.xy * b + m.xz * c
    return Mat33(
        a / d, (m.xz * m.zy - m.xy * m.zz) / d, (m.xy * m.yz - m.xz * m.yy) / d,
        b / d, (m.xx * m.zz - m.xz * m.zx) / d, (m.xz * m.yx - m.xx * m.yz) / d,
        c / d, (m.xy * m.zx - m.xx * m.zy) / d, (m.xx * m.yy - m.xy * m.yx) / d,
    )  # fmt: skip


# --- rotations -------------------------------------------------------------------------------------------------------


@jit
def rotation(q):
    """The matrix R of a unit quaternion: R @ v turns v from the body's axes into the world's."""
    xx, yy, zz = q.x * q.x, q.y * q.y, q.z * q.z
    xy, yz, zx = q.x * q.y, q.y * q.z, q.z * q.x
    wx, wy, wz = q.w * q.x, q.w * q.y, q.w * q.z
    one = q.w * q.w + xx + yy + zz
    return Mat33(
        one - (yy + yy) - (zz + zz), (xy + xy) - (wz + wz), (zx + zx) + (wy + wy),
        (xy + xy) + (wz + wz), one - (zz + zz) - (xx + xx), (yz + yz) - (wx + wx),
        (zx + zx) - (wy + wy), (yz + yz) + (wx + wx), one - (xx + xx) - (yy + yy),
    )  # fmt: skip


@jit
def turn(q, angle):
    """q after the rotation vector ``angle`` (rad, world axes): the exponential map, for one body only."""
    a = math.sqrt(angle.x * angle.x + angle.y * angle.y + angle.z * angle.z)
    s = 0.5 if a < 1e-10 else math.sin(0.5 * a) / a
    return unit(Quat(math.cos(0.5 * a), s * angle.x, s * angle.y, s * angle.z) * q)


@jit
def unit(p):
    """The unit quaternion of the same rotation, for one body only."""
    n = 1.0 / math.sqrt(p.w * p.w + p.x * p.x + p.y * p.y + p.z * p.z)
    return Quat(n * p.w, n * p.x, n * p.y, n * p.z)


@jit
def congruent(r, m):
    """R M R^T: a tensor from body axes to world axes."""
    return r @ m @ transpose(r)


# --- pieces of a row: quantity that starts in column k of row i of an (n, width) matrix ------------------------------


@inlined
def vec3(a, i, k):
    """The vector in columns k to k + 2 of row i."""
    return Vec3(a[i, k], a[i, k + 1], a[i, k + 2])


@inlined
def wide(v):
    """A vector in float64, whatever the precision of the rows it is from."""
    return v * 1.0


@inlined
def quat(a, i, k):
    """The quaternion in columns k to k + 3 of row i."""
    return Quat(a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3])


@inlined
def mat33(a, i, k):
    """The matrix in columns k to k + 8 of row i."""
    return Mat33(
        a[i, k], a[i, k + 1], a[i, k + 2],
        a[i, k + 3], a[i, k + 4], a[i, k + 5],
        a[i, k + 6], a[i, k + 7], a[i, k + 8],
    )  # fmt: skip


@inlined
def put_vec3(a, i, k, v):
    """Store a vector in columns k to k + 2 of row i."""
    a[i, k], a[i, k + 1], a[i, k + 2] = v.x, v.y, v.z


@jit
def put_quat(a, i, k, q):
    """Store a quaternion in columns k to k + 3 of row i."""
    a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3] = q.w, q.x, q.y, q.z


@jit
def put_mat33(a, i, k, m):
    """Store a matrix in columns k to k + 8 of row i."""
    a[i, k], a[i, k + 1], a[i, k + 2] = m.xx, m.xy, m.xz
    a[i, k + 3], a[i, k + 4], a[i, k + 5] = m.yx, m.yy, m.yz
    a[i, k + 6], a[i, k + 7], a[i, k + 8] = m.zx, m.zy, m.zz
