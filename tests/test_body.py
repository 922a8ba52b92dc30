"""A body: what its properties say and set, and what forces and impulses do to it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import stiction as st

Array = NDArray[np.float64]

QUARTER_TURN = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""90 degrees about z."""


@pytest.fixture
def space() -> st.World:
    """A world without gravity."""
    return st.World(gravity=(0, 0, 0), dt=0.01)


@pytest.fixture
def crate(space: st.World) -> st.Body:
    """1 x 2 x 3 m, 12 kg, turned by 90 degrees about z."""
    return space.add(st.Box((1, 2, 3)), mass=12.0, position=(1, 2, 3), orientation=QUARTER_TURN, name="crate")


# --- reading and setting ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("position", (4.0, 5.0, 6.0)),
        ("orientation", (0.0, 1.0, 0.0, 0.0)),
        ("velocity", (1.0, -2.0, 0.5)),
        ("angular_velocity", (0.1, 0.2, 0.3)),
        ("surface_velocity", (0.0, 0.0, 2.0)),
    ],
)
def test_what_is_set_is_read_back_as_a_copy(crate: st.Body, name: str, value: tuple[float, ...]) -> None:
    setattr(crate, name, value)
    read = getattr(crate, name)
    np.testing.assert_array_equal(read, value)
    read[:] = 99.0
    np.testing.assert_array_equal(getattr(crate, name), value)


def test_setting_an_orientation_normalises_it(crate: st.Body) -> None:
    crate.orientation = (2, 0, 0, 2)
    np.testing.assert_allclose(crate.orientation, QUARTER_TURN)


def test_setting_takes_effect_at_once_and_in_the_next_step(space: st.World, crate: st.Body) -> None:
    crate.velocity = (1, 0, 0)
    space.step(10)
    np.testing.assert_allclose(crate.position, (1.1, 2, 3))
    crate.position = (0, 0, 0)
    assert not space.positions[crate.index].any()
    space.step(10)
    np.testing.assert_allclose(crate.position, (0.1, 0, 0), atol=1e-15)


def test_what_a_body_says_about_itself(space: st.World, crate: st.Body) -> None:
    floor = space.add(st.Plane(), static=True, material="concrete")
    belt = space.add(st.Box((1, 1, 1)), kinematic=True, position=(9, 0, 9))
    assert repr(crate) == "<Body 'crate' (dynamic box, default)>"
    assert [body.mobility for body in (crate, floor, belt)] == ["dynamic", "static", "kinematic"]
    assert [body.awake for body in (crate, floor, belt)] == [True, False, True]
    assert [body.mass for body in (crate, floor, belt)] == [12.0, math.inf, math.inf]
    assert (crate.index, crate.name, crate.material) == (0, "crate", "default")
    assert (floor.index, floor.name, floor.material) == (1, "plane 1", "concrete")
    assert crate.shape == st.Box((1, 2, 3))
    assert floor.kinetic_energy == belt.kinetic_energy == 0.0


def test_kinetic_energy_is_that_of_translation_and_rotation(crate: st.Body) -> None:
    """1/2 m v^2 + 1/2 w . I w with w in body axes: world x is the body's -y after a quarter turn."""
    crate.velocity = (3, 4, 0)
    crate.angular_velocity = (2, 0, 0)
    about_y = 12 / 12 * (1 + 9)
    assert crate.kinetic_energy == pytest.approx(0.5 * 12 * 25 + 0.5 * about_y * 4)


# --- mass -------------------------------------------------------------------------------------------------------------


def test_mass_scales_the_tensor_and_the_tensor_leaves_the_mass(crate: st.Body) -> None:
    np.testing.assert_allclose(crate.inertia, np.diag([13, 10, 5]))
    crate.mass = 24.0
    np.testing.assert_allclose(crate.inertia, np.diag([26, 20, 10]))
    crate.inertia = (3, 4, 5)
    assert crate.mass == 24.0
    np.testing.assert_array_equal(crate.inertia, np.diag([3, 4, 5]))
    tensor = np.array([[3, 0.1, 0], [0.1, 4, 0.2], [0, 0.2, 5]])
    crate.inertia = tensor
    np.testing.assert_array_equal(crate.inertia, tensor)


def test_a_new_mass_is_the_mass_that_forces_move(space: st.World, crate: st.Body) -> None:
    crate.mass = 6.0
    crate.apply_impulse((6, 0, 0))
    np.testing.assert_allclose(crate.velocity, (1, 0, 0))
    crate.apply_force((600, 0, 0))
    space.step()
    np.testing.assert_allclose(crate.velocity, (2, 0, 0))


@pytest.mark.parametrize(
    ("given", "mass"),
    [({"mass": 5.0}, 5.0), ({"density": 2.0}, 12.0), ({}, 6000.0), ({"mass": 5.0, "inertia": (1, 1, 1)}, 5)],
)
def test_mass_comes_from_mass_density_or_the_default_density(given: dict[str, Any], mass: float) -> None:
    body = st.World().add(st.Box((1, 2, 3)), **given)
    assert body.mass == pytest.approx(mass)
    wanted = np.eye(3) if "inertia" in given else np.diag([13, 10, 5]) * mass / 12
    np.testing.assert_allclose(body.inertia, wanted)


def test_the_centre_of_mass_of_a_box_is_its_middle(crate: st.Body) -> None:
    np.testing.assert_allclose(crate.center_of_mass, (1, 2, 3))
    crate.center_of_mass[:] = 0.0
    np.testing.assert_allclose(crate.center_of_mass, (1, 2, 3))


# --- forces and impulses ----------------------------------------------------------------------------------------------


def test_an_impulse_changes_the_velocity_at_once(space: st.World, crate: st.Body) -> None:
    crate.apply_impulse((12, 0, -24))
    np.testing.assert_allclose(crate.velocity, (1, 0, -2))
    assert not crate.angular_velocity.any()
    np.testing.assert_allclose(crate.position, (1, 2, 3))
    space.step()
    np.testing.assert_allclose(crate.velocity, (1, 0, -2))


def test_an_impulse_beside_the_centre_spins_by_the_inertia_in_world_axes(crate: st.Body) -> None:
    """At 0.5 m along y with 10 N s along z: 5 N m s about world x, which is the body's y axis: I = 10."""
    crate.apply_impulse((0, 0, 10), at=(1, 2.5, 3))
    np.testing.assert_allclose(crate.velocity, (0, 0, 10 / 12))
    np.testing.assert_allclose(crate.angular_velocity, (0.5, 0, 0), atol=1e-15)


def test_a_force_acts_for_one_step_and_forces_add_up(space: st.World, crate: st.Body) -> None:
    crate.apply_force((1200, 0, 0))
    crate.apply_force((0, 1200, 0))
    np.testing.assert_array_equal(crate.velocity, 0.0)
    space.step()
    np.testing.assert_allclose(crate.velocity, (1, 1, 0))
    space.step(5)
    np.testing.assert_allclose(crate.velocity, (1, 1, 0))


def test_a_force_acts_in_the_first_of_many_steps(space: st.World, crate: st.Body) -> None:
    crate.apply_force((1200, 0, 0))
    space.step(7)
    np.testing.assert_allclose(crate.velocity, (1, 0, 0))


def test_force_beside_the_centre_and_torque_spin(space: st.World, crate: st.Body) -> None:
    crate.apply_force((0, 0, 100), at=(1, 2.5, 3))
    crate.apply_torque((0, 0, 100))
    space.step()
    np.testing.assert_allclose(crate.velocity, (0, 0, 100 / 12 * 0.01))
    np.testing.assert_allclose(crate.angular_velocity, (50 / 10 * 0.01, 0, 100 / 5 * 0.01), atol=1e-15)


def test_a_couple_turns_and_does_not_move(space: st.World, crate: st.Body) -> None:
    crate.apply_force((0, 50, 0), at=(2, 2, 3))
    crate.apply_force((0, -50, 0), at=(0, 2, 3))
    space.step()
    np.testing.assert_allclose(crate.velocity, 0.0, atol=1e-15)
    np.testing.assert_allclose(crate.angular_velocity, (0, 0, 100 / 5 * 0.01), atol=1e-15)


def test_angular_momentum_of_an_impulse_is_what_was_given(space: st.World) -> None:
    """About the origin: r x p, for a body in any pose."""
    body = space.add(st.Box((0.3, 0.5, 0.9)), mass=2.0, position=(1, -1, 2), orientation=(0.1, -0.7, 0.3, 0.6))
    p, at = np.array([1.0, 2.0, -3.0]), np.array([1.2, -0.7, 2.4])
    body.apply_impulse(p, at=at)
    w, x, y, z = body.orientation
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R = np.eye(3) + 2 * w * S + 2 * S @ S
    spin = R @ body.inertia @ R.T @ body.angular_velocity
    np.testing.assert_allclose(np.cross(body.position, 2.0 * body.velocity) + spin, np.cross(at, p), atol=1e-12)


# --- friction work ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_friction_work_is_the_energy_that_a_sliding_crate_has_lost(solver: str) -> None:
    world = st.World(solver=solver, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete")
    body = world.add(st.Box((1, 1, 1)), mass=2.0, position=(0, 0, 0.5), velocity=(3, 0, 0), material="wood")
    world.step(10)
    assert body.friction_work == pytest.approx(9.0 - body.kinetic_energy, rel=1e-4 if solver == "soft" else 1e-6)
    world.run(2.0)
    assert body.friction_work == pytest.approx(9.0, rel=1e-4 if solver == "soft" else 1e-6)
    assert world.energy().friction == pytest.approx(body.friction_work)


@pytest.mark.parametrize("solver", ["soft", "micro"])
def test_what_two_bodies_lose_to_each_other_is_shared(solver: str) -> None:
    world = st.World(gravity=(0, 0, 0), solver=solver, materials=st.MaterialTable.lecture())
    a = world.add(st.Sphere(0.5), mass=1.0, position=(-0.5, 0, 0), velocity=(1, 0, 2), material="rubber")
    b = world.add(st.Sphere(0.5), mass=1.0, position=(0.5, 0, 0), material="concrete")
    world.step()
    assert a.friction_work == b.friction_work > 0.0
    assert world.energy().friction == pytest.approx(2.0 * a.friction_work)


# --- a centre of mass of its own --------------------------------------------------------------------------------------


def test_a_loaded_ball_turns_about_its_centre_of_mass(space: st.World) -> None:
    ball = space.add(
        st.Sphere(1.0), mass=2.0, inertia=(1, 1, 1), center_of_mass=(0.5, 0, 0), orientation=QUARTER_TURN,
        angular_velocity=(0, 0, 3),
    )  # fmt: skip
    np.testing.assert_allclose(ball.center_of_mass, (0, 0.5, 0), atol=1e-12)
    space.step(100)
    np.testing.assert_allclose(ball.center_of_mass, (0, 0.5, 0), atol=1e-9)
    angle = math.pi / 2 + 3.0
    np.testing.assert_allclose(ball.position, (-0.5 * math.cos(angle), 0.5 - 0.5 * math.sin(angle), 0), atol=1e-6)


def test_a_loaded_ball_rocks_with_the_period_of_a_rolling_pendulum() -> None:
    """T = 2 pi sqrt((I + m (r - e)^2) / (m g e)) for a small swing; one of 0.05 rad makes it 2e-4 longer."""
    r, e, m, inertia = 0.5, 0.2, 3.0, 0.2
    world = st.World()
    world.materials.set_pair("default", "default", static=0.8, dynamic=0.8)
    world.add(st.Plane(), static=True)
    ball = world.add(
        st.Sphere(r), mass=m, inertia=(inertia,) * 3, center_of_mass=(0, 0, -e), position=(0, 0, r),
        orientation=(math.cos(0.025), 0, math.sin(0.025), 0),
    )  # fmt: skip
    crossings, before = [], 0.05
    for k in range(1, 301):
        world.step()
        tilt = 2.0 * float(ball.orientation[2])
        if before > 0.0 >= tilt:
            crossings.append((k - tilt / (tilt - before)) * world.dt)
        before = tilt
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    assert period == pytest.approx(2 * math.pi * math.sqrt((inertia + m * (r - e) ** 2) / (m * 9.81 * e)), rel=2e-3)
