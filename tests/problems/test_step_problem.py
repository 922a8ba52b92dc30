"""The contact problem of a world's next step: what is in it, and that solvers agree about it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import stiction as st
from stiction.problems import ContactProblem, natural_map, solve
from stiction.problems.sweeps import LOCAL_SOLVERS

from .support import assert_solved

G = 9.81
Vector = NDArray[np.float64]


def world_of(solver: str, tangent: float = 0.0) -> st.World:
    """A floor, tilted by its gravity, with static friction 0.6 and dynamic 0.4."""
    a = math.atan(tangent)
    world = st.World(solver=solver, gravity=(G * math.sin(a), 0, -G * math.cos(a)))
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.4)
    world.add(st.Plane(), static=True)
    return world


def crate_on_a_ramp(solver: str) -> st.World:
    world = world_of(solver, 0.5)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    world.step(20)
    return world


def two_boxes(solver: str) -> st.World:
    world = world_of(solver)
    for k in range(2):
        world.add(st.Box((1, 1, 1)), position=(0.1 * k, 0, 0.5 + k))
    world.step(20)
    return world


def sliding_box(solver: str) -> st.World:
    world = world_of(solver)
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5), velocity=(3, 1, 0))
    world.step(5)
    return world


def ball(solver: str) -> st.World:
    world = world_of(solver)
    world.add(st.Sphere(0.5), position=(0, 0, 0.5), velocity=(3, 1, 0))
    world.step(5)
    return world


SCENES = {make.__name__: make for make in (crate_on_a_ramp, two_boxes, sliding_box, ball)}


def sums(problem: ContactProblem, r: Vector) -> dict[tuple[int, int], Vector]:
    """Impulse on b of each pair of bodies, world axes, N s: it is determined where loads of single points are not."""
    assert problem.places is not None
    made: dict[tuple[int, int], Vector] = {}
    for (a, b), frame, impulse in zip(problem.places.bodies.tolist(), problem.places.frames, r, strict=True):
        made[a, b] = made.get((a, b), np.zeros(3)) + frame @ impulse
    return made


@pytest.mark.parametrize("local", [name for name in LOCAL_SOLVERS if name != "clamp"])
@pytest.mark.parametrize("scene", SCENES)
def test_point_wise_solvers_agree_with_the_exact_one(scene: str, local: str) -> None:
    world = SCENES[scene]("exact")
    problem = world.contact_problem()
    found = solve(problem, local=local, tolerance=1e-11)
    assert found.converged
    assert_solved(problem, found.r, 1e-8)
    assert problem.places is not None
    assert natural_map(problem, problem.places.impulses) < 1e-7
    own, theirs = sums(problem, problem.places.impulses), sums(problem, found.r)
    scale = max(np.linalg.norm(p) for p in own.values())
    for pair, impulse in own.items():
        # 1e-8 m/s of tolerance times a thousand kilograms
        assert theirs[pair] == pytest.approx(impulse, abs=2e-7 * scale)


@pytest.mark.parametrize("scene", SCENES)
def test_the_step_that_follows_has_the_impulses_that_were_told(scene: str) -> None:
    world = SCENES[scene]("exact")
    problem = world.contact_problem()
    world.step()
    rows = world.contacts()
    for (a, b), impulse in sums(problem, problem.places.impulses).items():  # type: ignore[union-attr]  # it is there
        here = rows[(rows["body_a"] == a) & (rows["body_b"] == b)]
        told = (here["normal"] * here["normal_impulse"][:, None] + here["friction_impulse"]).sum(axis=0)
        assert told == pytest.approx(impulse, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(("scene", "error"), [("crate_on_a_ramp", 1e-6), ("two_boxes", 1e-6), ("ball", 2e-3)])
def test_soft_is_near_the_solution(scene: str, error: float) -> None:
    problem = SCENES[scene]("soft").contact_problem()
    assert problem.places is not None
    assert natural_map(problem, problem.places.impulses) < error


def test_what_slides_has_its_dynamic_coefficient() -> None:
    assert set(sliding_box("soft").contact_problem().mu) == {0.4}
    assert set(crate_on_a_ramp("soft").contact_problem().mu) == {0.6}


def test_masses_and_velocities_are_those_of_the_bodies() -> None:
    world = world_of("soft")
    crate = world.add(
        st.Box((1, 2, 3)), position=(0, 0, 1.5), orientation=(0.8, 0, 0, 0.6), velocity=(1, 2, 0), density=100
    )
    crate.apply_force((7.0, 0, 0))
    problem = world.contact_problem()
    form = problem.global_form
    assert form is not None and problem.places is not None
    M = form.M.toarray()
    v = np.linalg.solve(M, form.f)
    assert np.diag(M)[:3] == pytest.approx(600.0)
    moments = np.sort(np.linalg.eigvalsh(M[3:, 3:]))
    assert moments == pytest.approx(np.sort([50 * 13.0, 50 * 10.0, 50 * 5.0]))
    assert v[:3] == pytest.approx([1 + 7.0 / 600 * world.dt, 2, -G * world.dt])
    u = (form.H.T @ v + form.w).reshape(-1, 3)
    slip = np.einsum("nij,nj->ni", problem.places.frames, u)
    assert slip == pytest.approx(np.broadcast_to(v[:3], (4, 3)))
    assert problem.W.dense() == pytest.approx(form.H.T.toarray() @ np.linalg.inv(M) @ form.H.toarray())


def test_belts_and_kinematic_bodies_move_without_a_mass() -> None:
    world = st.World()
    world.materials.set_pair("default", "default", static=0.6, dynamic=0.4)
    world.add(
        st.Box((9, 9, 1)), kinematic=True, position=(0, 0, -0.5), velocity=(0.5, 0, 0), surface_velocity=(0, 2, 0)
    )
    world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
    problem = world.contact_problem()
    assert problem.global_form is not None and problem.places is not None
    assert problem.global_form.M.shape == (6, 6)
    w = problem.global_form.w.reshape(-1, 3) * [0, 1, 1]
    assert np.einsum("nij,nj->ni", problem.places.frames, w) == pytest.approx(
        np.broadcast_to((-0.5, -2.0, 0.0), (len(w), 3)), abs=1e-9
    )


def test_the_world_is_as_before() -> None:
    one, other = two_boxes("soft"), two_boxes("soft")
    one.contact_problem()
    one.step(10)
    other.step(10)
    assert one.state_hash() == other.state_hash()
    assert one.energy() == other.energy()


def test_a_file_keeps_masses_and_places(tmp_path: Path) -> None:
    problem = two_boxes("soft").contact_problem()
    problem.write(tmp_path / "a.hdf5")
    back = ContactProblem.read(tmp_path / "a.hdf5")
    assert problem.places is not None and back.places is not None
    for name, values in vars(problem.places).items():
        np.testing.assert_array_equal(getattr(back.places, name), values)
    np.testing.assert_array_equal(back.W.dense(), problem.W.dense())
    problem.write(tmp_path / "a.dat")
    np.testing.assert_array_equal(ContactProblem.read(tmp_path / "a.dat").W.dense(), problem.W.dense())


def refused(make: Callable[[], st.World], kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        make().contact_problem()


def test_what_has_no_contact_problem_says_so() -> None:
    refused(st.World, st.InvalidInputError, "nothing touches")
    refused(lambda: st.World(solver="micro"), st.NotYetError, "micro")

    def tyre() -> st.World:
        world = world_of("soft")
        world.materials.set_pair("default", "default", law=st.BrushTyre(15.0))
        return world

    refused(tyre, st.NotYetError, "pairs with laws")
