"""Ellipsoids: contacts in closed form and to the last digits, bounds, spheres among them, and how they roll."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.core import state
from stiction.core.broadphase import update_bounds
from stiction.hulls import HullTable

from .support import Array, Manifold, Placed, box, compiled, contacts_of, matrix_of, plane, random_unit, sphere

TABLE = HullTable()
UP = (1.0, 0.0, 0.0, 0.0)
WEDGE = TABLE.add(st.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)]))


def ellipsoid(half: Any, position: Any = (0.0, 0.0, 0.0), orientation: Any = UP) -> Placed:
    """By its semi-axes."""
    return Placed(state.ELLIPSOID, (*(float(h) for h in half), 0.0), position, orientation)


def touching(a: Placed, b: Placed, margin: float = 0.0) -> Manifold:
    """What the narrow phase finds."""
    return contacts_of(a, b, margin, hulls=TABLE.arrays)


def matrix(one: Placed) -> Array:
    """M of the surface (x - p) . M^-1 (x - p) = 1."""
    return np.asarray(one.axes @ np.diag(np.square(one.size[:3])) @ one.axes.T)


def outward(one: Placed, point: Array) -> Array:
    """The unit normal of an ellipsoid at a point of its surface."""
    n = np.linalg.solve(matrix(one), point - np.asarray(one.position))
    return np.asarray(n / np.linalg.norm(n))


def random_one(rng: np.random.Generator, position: Any = (0.0, 0.0, 0.0)) -> Placed:
    """Of about half a metre."""
    return ellipsoid(rng.uniform(0.2, 1.0, size=3), position, random_unit(rng, 4))


def test_a_plane_is_touched_with_the_lowest_point(rng: np.random.Generator) -> None:
    """It is h = sqrt(n . M n) below the middle, at the place M n / h."""
    for _ in range(50):
        n, one = random_unit(rng), random_one(rng, 10.0 * rng.normal(size=3))
        h = math.sqrt(n @ matrix(one) @ n)
        gap = float(rng.uniform(-0.01, 0.01))
        m = touching(plane(n, float(n @ one.position) - h - gap), one, 0.02)
        assert len(m) == 1
        lowest = np.asarray(one.position) - matrix(one) @ n / h
        np.testing.assert_allclose(m.points[0], lowest - 0.5 * gap * n, atol=1e-12)
        np.testing.assert_allclose(m.separations, gap, atol=1e-12)
        np.testing.assert_allclose(m.normals[0], n, atol=1e-12)
        assert len(touching(plane(n, float(n @ one.position) - h - 0.03), one, 0.02)) == 0


@pytest.mark.parametrize("ball", [True, False], ids=["ball", "ellipsoid"])
def test_smooth_shapes_share_their_normal_to_the_last_digits(rng: np.random.Generator, ball: bool) -> None:
    """Where they are nearest the normals of both surfaces lie on one line: so nothing jumps as they roll."""
    for _ in range(60):
        a, n = random_one(rng), random_unit(rng)
        ha = math.sqrt(n @ matrix(a) @ n)
        gap = float(rng.choice([-0.02, -1e-4, -1e-6, 1e-6, 1e-2]))
        x = matrix(a) @ n / ha
        if ball:
            r = float(rng.uniform(0.1, 1.0))
            b, y = sphere(r, x + (gap + r) * n), x + gap * n
        else:
            b = random_one(rng)
            hb = math.sqrt(n @ matrix(b) @ n)
            b = Placed(b.shape, b.size, x + gap * n + matrix(b) @ n / hb, b.orientation)
            y = x + gap * n
        m = touching(a, b, 0.1)
        assert len(m) == 1
        np.testing.assert_allclose(m.normals[0], n, atol=1e-9)
        np.testing.assert_allclose(m.separations, gap, atol=1e-12)
        np.testing.assert_allclose(m.points[0], 0.5 * (x + y), atol=1e-9)
        np.testing.assert_allclose(outward(a, m.points[0] - 0.5 * gap * n), n, atol=1e-8)


@pytest.mark.parametrize(
    "other",
    [
        plane((0.0, 0.0, 1.0), 0.0), box((3.0, 2.0, 0.5), (0, 0, -0.5)), sphere(0.7, (0.1, 0.2, -0.7)),
        Placed(state.CAPSULE, (0.3, 0.3, 1.3, 0.0), (0.1, 0.0, -0.3), (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)),
        Placed(state.CYLINDER, (2.0, 2.0, 0.5, 0.0), (0, 0, -0.5)),
        Placed(state.HULL, (1.0, 1.0, 1.0, float(WEDGE)), (-0.2, -0.2, -0.01)),
        ellipsoid((0.6, 0.4, 0.5), (0.1, -0.1, -0.5)),
    ],
    ids=["plane", "box", "sphere", "capsule", "cylinder", "hull", "ellipsoid"],
)  # fmt: skip
def test_with_three_equal_semi_axes_it_is_a_sphere(rng: np.random.Generator, other: Placed) -> None:
    for _ in range(20):
        at = np.array([0.0, 0.0, 0.49]) + rng.uniform(-0.1, 0.1, size=3) * (1, 1, 0.1)
        one = touching(other, ellipsoid((0.5,) * 3, at, random_unit(rng, 4)), 0.3)
        two = touching(other, sphere(0.5, at), 0.3)
        assert len(one) == len(two) == 1
        np.testing.assert_allclose(one.normals, two.normals, atol=1e-4)
        np.testing.assert_allclose(one.points, two.points, atol=1e-4)
        np.testing.assert_allclose(one.separations, two.separations, atol=1e-6)


def test_its_bounds_are_those_of_its_surface(rng: np.random.Generator) -> None:
    """Along axis i of the world it reaches sqrt(M_ii)."""
    bodies, kinds = state.make_bodies(20)
    kinds[:, state.SHAPE] = state.ELLIPSOID
    for i in range(20):
        one = random_one(rng, rng.normal(size=3))
        bodies[i, state.POSITION : state.POSITION + 7] = *one.position, *one.orientation
        bodies[i, state.SIZE : state.SIZE + 3] = one.size[:3]
        kinds[i, state.MOBILITY] = state.STATIC
        compiled(update_bounds)(bodies, kinds, i + 1, 9.81, 1 / 60)
        reach = np.sqrt(np.diag(matrix(one)))
        low, high = bodies[i, state.BOUNDS : state.BOUNDS + 6].reshape(2, 3)
        np.testing.assert_allclose(low, np.asarray(one.position) - reach, atol=5e-6)
        np.testing.assert_allclose(high, np.asarray(one.position) + reach, atol=5e-6)
        assert (low < np.asarray(one.position) - reach).all() and (high > np.asarray(one.position) + reach).all()


# --- rolling ----------------------------------------------------------------------------------------------------------


def rolling_world(solver: str, floor: str) -> st.World:
    world = st.World(solver=solver, dt=1 / 240 if solver == "exact" else 1 / 60)
    world.materials.set_pair("default", "default", static=0.9, dynamic=0.9)
    ground = (st.Plane(), (0, 0, 0)) if floor == "plane" else (st.Box((60, 60, 1)), (0, 0, -0.5))
    world.add(ground[0], static=True, position=ground[1])
    return world


@pytest.mark.parametrize("solver", ["soft", "exact", "micro"])
@pytest.mark.parametrize("floor", ["plane", "box"])
def test_a_spheroid_on_its_rim_rolls_on_like_a_ball(solver: str, floor: str) -> None:
    """About its axis, y, with the radius of its equator."""
    world = rolling_world(solver, floor)
    body = world.add(
        st.Ellipsoid((0.4, 0.5, 0.4)), position=(0, 0, 0.4), velocity=(1, 0, 0), angular_velocity=(0, 2.5, 0)
    )
    world.run(3.0)
    np.testing.assert_allclose(body.velocity, (1, 0, 0), atol=1e-6)
    np.testing.assert_allclose(body.position[:2], (3, 0), atol=1e-4)
    assert abs(world.energy().friction) < 1e-6


def height(angle: float, a: float, c: float) -> float:
    """Of the middle, where the longer axis is turned by the angle from the floor."""
    return math.hypot(a * math.sin(angle), c * math.cos(angle))


@pytest.mark.parametrize("floor", ["plane", "box"])
def test_end_over_end_it_turns_at_the_rate_that_its_energy_gives(floor: str) -> None:
    """(I + m p^2) w^2 / 2 + m g h is constant, p^2 = h^2 + h'^2 the distance of the contact: so t = int da / w.

    In a step the contact is held at one place, p' dt before the next one, and where it goes to the body arrives with
    the speed q dt, q = w x p', which is taken from it: m (q dt)^2 / 2 of its energy at most. The end is seen to a step.
    """
    a, c, spin, turns = 0.55, 0.5, 3.0, 3
    world = rolling_world("soft", floor)
    body = world.add(st.Ellipsoid((a, 0.3, c)), position=(-4, 0, c), velocity=(spin * c, 0, 0), mass=1.0)
    body.angular_velocity = (0, spin, 0)
    inertia = body.inertia[1, 1]
    start = 0.5 * (inertia + c * c) * spin**2 + 9.81 * c
    angles = np.linspace(0.0, 2.0 * math.pi * turns, 20_001)
    h = np.array([height(x, a, c) for x in angles])
    slope = (a * a - c * c) * np.sin(angles) * np.cos(angles) / h
    rate = np.sqrt(2.0 * (start - 9.81 * h) / (inertia + h * h + slope * slope))
    wanted = np.trapezoid(1.0 / rate, angles)
    q = rate**2 * np.hypot(np.gradient(slope, angles), slope)
    lost = 0.5 * world.dt * float(np.trapezoid(q**2 / rate, angles))
    seen, turned = 0.0, 0.0
    while turned < angles[-1]:
        before = turned
        world.step()
        turned += float(body.angular_velocity[1]) * world.dt  # it goes as the new velocity says, up to half a step
        seen += world.dt * min(1.0, (angles[-1] - before) / (turned - before))
    assert seen == pytest.approx(wanted, abs=world.dt + 0.5 * wanted * lost / (start - 9.81 * a))
    energy = world.energy()
    assert energy.kinetic + energy.potential == pytest.approx(start, abs=lost)
    assert abs(energy.friction) < 1e-9
    assert abs(body.position[1]) < 1e-6


@pytest.mark.parametrize("floor", ["plane", "box"])
def test_small_rocking_has_the_period_of_its_curvature(floor: str) -> None:
    """w^2 = m g (a^2 / c - c) / (I + m c^2), and the energy stays."""
    a, c, tilt = 0.6, 0.4, 0.02
    world = rolling_world("soft", floor)
    turn = (math.cos(tilt / 2), 0, math.sin(tilt / 2), 0)
    body = world.add(st.Ellipsoid((a, 0.5, c)), position=(0, 0, height(tilt, a, c)), orientation=turn, mass=1.0)
    first = float(body.position[2]) - c
    crossings, before = [], 1.0
    for _ in range(1200):
        world.step()
        lean = float(matrix_of(body.orientation)[0, 2])
        if before < 0.0 <= lean:
            crossings.append(world.time - world.dt * lean / (lean - before))
        before = lean
    omega = math.sqrt(9.81 * (a * a / c - c) / (body.inertia[1, 1] + c * c))
    period = float(np.diff(crossings).mean())
    # the frequency of steps of this length is off by a part (omega dt)^2 / 8 at most
    assert period == pytest.approx(2.0 * math.pi / omega, rel=(omega / 60) ** 2 / 8 + tilt**2)
    energy = world.energy()
    assert (energy.kinetic + energy.potential) / 9.81 - c == pytest.approx(first, rel=0.03)


def test_one_ball_on_another_is_the_same_as_ellipsoids() -> None:
    """It rolls down from the top of a large one, where the radii of both count."""
    ends = []
    for large, small in ((st.Sphere(2.0), st.Sphere(0.5)), (st.Ellipsoid((2.0,) * 3), st.Ellipsoid((0.5,) * 3))):
        world = st.World()
        world.materials.set_pair("default", "default", static=0.9, dynamic=0.9)
        world.add(large, static=True)
        ball = world.add(small, position=(2.5 * math.sin(0.1), 0, 2.5 * math.cos(0.1)))
        world.run(1.2)
        ends.append(np.concatenate([ball.position, ball.velocity, ball.angular_velocity]))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)
