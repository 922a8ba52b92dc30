"""How bodies in contact turn: the spin that they would have by themselves, and where a spin ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st
from stiction.core.integrate import spin_in_contact
from stiction.core.vec import Mat33, Quat

from .support import Array, compiled, matrix_of, random_unit, vec


def spun(R: Array, inertia: Array, w: Array, seconds: float, parts: int) -> tuple[Array, Array]:
    """Axes and spin of a free body, in world axes, by Runge and Kutta: R' = w x R, and R I R^T w does not change."""
    momentum = R @ inertia @ R.T @ w
    inverse, h = np.linalg.inv(inertia), seconds / parts

    def rate(A: Array) -> Array:
        x, y, z = A @ inverse @ A.T @ momentum
        return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ A

    for _ in range(parts):
        a = rate(R)
        b = rate(R + 0.5 * h * a)
        c = rate(R + 0.5 * h * b)
        R = R + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(R + h * c))
    return R, R @ inverse @ R.T @ momentum


def test_contact_finds_the_spin_of_a_free_body(rng: np.random.Generator) -> None:
    """To the third order in a step; and the axes of its middle to the second, for its spin of then is not known."""
    errors = []
    for _ in range(20):
        q, w = random_unit(rng, 4), 3.0 * rng.normal(size=3)
        A = rng.normal(size=(3, 3))
        inertia = A @ A.T + 0.3 * np.eye(3)
        R = matrix_of(q)
        for dt in (0.02, 0.01):
            free, middle, _ = compiled(spin_in_contact)(
                Quat(*map(float, q)),
                Mat33(*R.ravel()),
                Mat33(*inertia.ravel()),
                Mat33(*np.linalg.inv(inertia).ravel()),
                vec(w),
                dt,
            )
            half, _ = spun(R, inertia, w, 0.5 * dt, 100)
            _, last = spun(R, inertia, w, dt, 100)
            errors.append((np.linalg.norm(w + free - last), np.linalg.norm(np.reshape(middle, (3, 3)) - half)))
    wide, fine = np.array(errors).reshape(20, 2, 2).swapaxes(0, 1)
    orders = np.log2(wide / fine)
    assert np.median(orders[:, 0]) == pytest.approx(3.0, abs=0.2)
    assert np.median(orders[:, 1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("dt", [0.004166666, 1.0 / 60.0, 0.01])
def test_a_spin_may_end_at_nothing(dt: float) -> None:
    """A ball that torsional resistance stops within a step has no energy left, and what it may have is about zero."""
    world = st.World(dt=dt)
    world.materials.set_pair("default", "default", static=0.5, dynamic=0.5, torsional=0.004)
    world.add(st.Plane(), static=True)
    ball = world.add(st.Sphere(0.1), position=(0, 0, 0.1), angular_velocity=(0, 0, 20.0))
    world.step(math.ceil(2.5 / dt))
    assert np.linalg.norm(ball.angular_velocity) < 1e-6
