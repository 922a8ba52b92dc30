"""What the tests of core share: random rotations, and the contacts of two shapes through the narrow phase."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from stiction.core import state
from stiction.core.collide.narrow import find_contacts
from stiction.core.jit import ENTRY
from stiction.core.vec import Mat33, Vec3

Array = NDArray[np.float64]
Generator = np.random.Generator


@functools.cache
def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """A helper of core as a kernel of its own, made once a process; the options are those of the package's entries."""
    kernel: Callable[..., Any] = numba.njit(**ENTRY)(function)
    return kernel


def random_unit(rng: Generator, n: int = 3) -> Array:
    """A direction (n,), all directions alike; for n = 4 a random unit quaternion."""
    while True:
        v = rng.normal(size=n)
        length = np.linalg.norm(v)
        if length > 1e-3:
            return np.asarray(v / length)


def matrix_of(q: Array) -> Array:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z), by the textbook, not by the package."""
    w, x, y, z = q
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + 2.0 * w * S + 2.0 * S @ S)


def vec(v: Any) -> Vec3:
    """A Vec3 of three Python floats."""
    return Vec3(*(float(c) for c in v))


def mat(m: Any) -> Mat33:
    """A Mat33 of nine Python floats."""
    return Mat33(*(float(c) for c in np.ravel(m)))


def random_inverse_inertia(rng: Generator) -> Array:
    """Inverse inertia tensor (3, 3) of a random solid in random axes: the moments obey the triangle inequality."""
    a, b, c = np.exp(rng.uniform(-2.0, 2.0, size=3))
    R = matrix_of(random_unit(rng, 4))
    return np.asarray(R @ np.diag(1.0 / np.array([b + c, c + a, a + b])) @ R.T)


# --- contacts of two shapes -------------------------------------------------------------------------------------------

BEYOND = 3e-6
"""m, by which the shapes of these tests may be farther apart than the margin and yet touch: the narrow phase adds a
millionth of their sizes, so that rounding does not decide."""


@dataclass(frozen=True)
class Placed:
    """A shape somewhere: its code, its size as core keeps it (half lengths), position (3,) and orientation (4,)."""

    shape: int
    size: tuple[float, ...]
    position: Any = (0.0, 0.0, 0.0)
    orientation: Any = (1.0, 0.0, 0.0, 0.0)

    @property
    def axes(self) -> Array:
        """Axes of the shape in the world, one a column."""
        return matrix_of(np.asarray(self.orientation, float))

    def corners(self) -> Array:
        """(8, 3) corners of a box in the world, in the order of bits x, y, z."""
        signs = np.array([[1 if k & bit else -1 for bit in (1, 2, 4)] for k in range(8)])
        return np.asarray(np.asarray(self.position) + signs * np.array(self.size[:3]) @ self.axes.T)

    def moved(self, shift: Any, q: Array) -> Placed:
        """The same shape after the whole scene was turned by q about the origin and then shifted."""
        R = matrix_of(q)
        return Placed(self.shape, self.size, R @ np.asarray(self.position) + shift, product(q, self.orientation))


def sphere(radius: float, position: Any) -> Placed:
    """A sphere."""
    return Placed(state.SPHERE, (radius,), position)


def box(half: Any, position: Any = (0.0, 0.0, 0.0), orientation: Any = (1.0, 0.0, 0.0, 0.0)) -> Placed:
    """A box by its half lengths."""
    return Placed(state.BOX, tuple(half), position, orientation)


def plane(
    normal: Any, offset: float, position: Any = (0.0, 0.0, 0.0), orientation: Any = (1.0, 0.0, 0.0, 0.0)
) -> Placed:
    """A half space n . x <= offset of its own frame."""
    return Placed(state.PLANE, (*normal, offset), position, orientation)


def product(p: Any, q: Any) -> Array:
    """The quaternion product p q: first q, then p."""
    a, b = np.asarray(p, float), np.asarray(q, float)
    u, v = a[1:], b[1:]
    return np.array([a[0] * b[0] - u @ v, *(a[0] * v + b[0] * u + np.cross(u, v))])


@dataclass(frozen=True)
class Manifold:
    """Contact points of one pair: (k, 3) points, (k, 3) normals from the first body to the second, and so on."""

    points: Array
    normals: Array
    separations: Array
    features: NDArray[np.int64]
    bodies: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.points)


def rows_of(*placed: Placed) -> tuple[Array, NDArray[np.int64]]:
    """Rows of the bodies and their integers, all of them static."""
    bodies, kinds = state.make_bodies(len(placed))
    for i, one in enumerate(placed):
        bodies[i, state.POSITION : state.POSITION + 3] = one.position
        bodies[i, state.ORIENTATION : state.ORIENTATION + 4] = one.orientation
        bodies[i, state.SIZE : state.SIZE + len(one.size)] = one.size
        kinds[i, :3] = one.shape, state.STATIC, 0
    return bodies, kinds


def contacts_of(first: Placed, second: Placed, margin: float, room: int = 8, hulls: Any = None) -> Manifold:
    """Contact points of two shapes that come within ``margin`` of each other, as the narrow phase finds them.

    The first body is dynamic and at rest, so that its margin is all that gravity can make of it in a step of 1 s.
    ``hulls`` is the table of the hulls, needed for all but spheres, boxes and planes.
    """
    bodies, kinds = rows_of(first, second)
    bodies[0, state.INVERSE_MASS] = 1.0
    kinds[0, state.MOBILITY] = state.DYNAMIC
    contacts, tags = state.make_contacts(room)
    pairs, scratch = np.array([[0, 1]]), state.make_lists(2, room, 1).points
    found = compiled(find_contacts)(bodies, kinds, pairs, 1, contacts, tags, float(margin), 1.0, scratch, 1, hulls)
    assert found <= room
    rows = contacts[:found]
    return Manifold(
        rows[:, state.POINT : state.POINT + 3],
        rows[:, state.NORMAL : state.NORMAL + 3],
        rows[:, state.SEPARATION],
        tags[:found, state.FEATURE],
        tags[:found, state.BODY_A : state.BODY_B + 1],
    )
