"""The exact solver in a world: what it solves, what it tells, and what it refuses."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import stiction as st

G = 9.81


def slope(tangent, static, dynamic, **options):
    """A crate on a slope of that tangent, as tilted gravity."""
    angle = math.atan(tangent)
    world = st.World(solver="exact", gravity=(G * math.sin(angle), 0, -G * math.cos(angle)), **options)
    world.materials.set_pair("default", "default", static=static, dynamic=dynamic)
    world.add(st.Plane(), static=True)
    return world, world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5)), angle


def test_holds_to_a_thousandth_of_the_limit_and_slides_beyond():
    world, crate, _ = slope(0.599, 0.6, 0.4)
    world.run(2.0)
    assert abs(crate.position[0]) < 1e-9
    world, crate, angle = slope(0.601, 0.6, 0.4)
    world.run(2.0)
    expected = 0.5 * G * (math.sin(angle) - 0.4 * math.cos(angle)) * 4.0
    assert crate.position[0] == pytest.approx(expected, rel=2.0 * world.dt / 2.0)


def test_contacts_do_not_give_way():
    world = st.World(solver="exact", sleeping=False)
    world.add(st.Plane(), static=True)
    tower = [world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5)) for k in range(6)]
    world.run(3.0)
    assert max(abs(body.position[2] - k - 0.5) for k, body in enumerate(tower)) < 1e-7
    assert world.residual() < 5e-8
    assert world.report().limit_hits[2] <= 2


def test_crooked_tower_comes_to_rest():
    rng = np.random.default_rng(3)
    world = st.World(solver="exact", sleeping=False)
    world.add(st.Plane(), static=True)
    tower = []
    for k in range(8):
        (x, y), a = rng.normal(0, 0.005, 2), rng.normal(0, 0.05)
        turned = (math.cos(a / 2), 0, 0, math.sin(a / 2))
        tower.append(world.add(st.Box((1, 1, 1)), position=(x, y, k + 0.5), orientation=turned))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", st.IterationLimitWarning)
        world.run(5.0)
    assert max(np.abs(body.velocity).max() for body in tower) < 1e-5


def test_residuals_fall_and_are_told():
    world, _, _ = slope(0.3, 0.5, 0.4, sleeping=False)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 1.5))
    world.step(3)
    log = world.residual_log()
    assert log.size >= 1
    assert log[-1] <= 1e-8
    assert world.residual() < 1e-7


def test_soft_tells_its_residual():
    world = st.World(sleeping=False)
    world.add(st.Plane(), static=True)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    world.run(1.0)
    assert 0.0 <= world.residual() < 1e-4


def test_warns_where_passes_run_out():
    world = st.World(solver="exact", iterations=1)
    world.add(st.Plane(), static=True)
    for k in range(5):
        world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5), density=100.0 if k < 4 else 10_000.0)
    with pytest.warns(st.IterationLimitWarning, match="limit of 1 passes a substep was hit"):
        world.step()
    assert world.report().limit_hits[2] == world.substeps
    assert world.report().worst[2] > 1e-8


def test_same_input_same_bits():
    hashes = set()
    for _ in range(2):
        world, _, _ = slope(0.7, 0.6, 0.4)
        world.add(st.Sphere(0.3), position=(3, 0, 0.3), velocity=(1, 1, 0))
        world.step(100)
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def test_laws_hold_here_too():
    materials = st.MaterialTable()
    materials.set_pair("body", "floor", static=0.5, dynamic=0.2, static_across=0.6, dynamic_across=0.4, adhesion=50.0)
    world = st.World(solver="exact", materials=materials, dt=1 / 240)
    world.add(st.Plane(), static=True, material="floor")
    crate = world.add(
        st.Box((1, 1, 0.2)), mass=10.0, position=(0, 0, 0.1), velocity=(0, 3, 0), material="body", grain=(1, 0, 0)
    )  # fmt: skip
    world.run(2.0)
    assert crate.position[1] == pytest.approx(9.0 / (2.0 * 0.4 * (G + 5.0)), rel=3e-3)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tolerance": 0.0, "solver": "exact"}, "tolerance must be above 0 m/s"),
        ({"tolerance": 1e-6}, "tolerance must be left out unless solver is 'exact'"),
        ({"precision": "single", "solver": "exact"}, "precision 'single' is not there yet with solver 'exact'"),
        ({"threads": 2, "solver": "exact"}, "threads must be 1 with solver 'exact'"),
        ({"micro_literal": True, "solver": "exact"}, "micro_literal must be left out unless solver is 'micro'"),
    ],
)
def test_bad_options(options, words):
    with pytest.raises((st.InvalidInputError, st.NotYetError)) as error:
        st.World(**options)
    assert words in str(error.value)


def test_other_solvers_have_no_log():
    with pytest.raises(st.NotYetError, match="residual_log"):
        st.World().residual_log()
    with pytest.raises(st.NotYetError, match="residual"):
        st.World(solver="micro").residual()
