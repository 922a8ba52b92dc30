"""The lecture's functions against numpy, against the law they stand for, and against the engine that uses them."""

from __future__ import annotations

import doctest
import inspect
import math
import re
import subprocess
import sys
from collections.abc import Callable
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.random import Generator
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import stiction as st
from stiction import lecture
from stiction.core.vec import Quat, rotation

Array = NDArray[np.float64]
CLOSE = {"rtol": 1e-12, "atol": 1e-12}
UP = (0.0, 0.0, 1.0)
PAGE = Path(__file__).resolve().parent.parent / "docs" / "lecture.md"


def random_rotation(rng: Generator) -> Array:
    q = rng.normal(size=4)
    return np.array(rotation(Quat(*(q / np.linalg.norm(q))))).reshape(3, 3)


def random_tensor(rng: Generator) -> Array:
    """A symmetric, positive definite (3, 3)."""
    R = random_rotation(rng)
    return np.asarray(R @ np.diag(rng.uniform(0.2, 3.0, 3)) @ R.T)


def random_contact(rng: Generator) -> dict[str, Any]:
    """Arguments of contact_matrix for two free bodies."""
    return {
        "B": lecture.contact_basis(rng.normal(size=3)),
        "m_a": rng.uniform(0.5, 5.0),
        "I_inv_a": random_tensor(rng),
        "r_a": rng.normal(size=3),
        "m_b": rng.uniform(0.5, 5.0),
        "I_inv_b": random_tensor(rng),
        "r_b": rng.normal(size=3),
    }


# --- the table of slides ----------------------------------------------------------------------------------------------

NAMES = sorted({name for names in lecture.SLIDES.values() for name in names})
FUNCTIONS = [name for name in vars(lecture) if inspect.isfunction(vars(lecture)[name]) and not name.startswith("_")]


def find(name: str) -> Any:
    """The object with that dotted name below ``stiction``, importing modules on the way."""

    def child(parent: Any, part: str) -> Any:
        if inspect.ismodule(parent) and not hasattr(parent, part):
            __import__(f"{parent.__name__}.{part}")
        return getattr(parent, part)

    return reduce(child, name.split("."), st)


@pytest.mark.parametrize("name", NAMES)
def test_a_slide_names_a_function_that_exists_and_says_what_it_does(name: str) -> None:
    function = find(name)

    assert callable(function)
    assert inspect.getdoc(function)


def test_every_function_of_the_lecture_stands_in_the_table() -> None:
    defined = {f"lecture.{name}" for name in FUNCTIONS} - {"lecture.slide_table"}

    assert {name for name in NAMES if name.startswith("lecture.")} == defined


def test_a_docstring_names_the_slides_of_its_function() -> None:
    missing = [
        (slide, name)
        for (slide, _), names in lecture.SLIDES.items()
        for name in names
        if name.startswith("lecture.") and slide not in " ".join((inspect.getdoc(find(name)) or "").split())
    ]

    assert missing == []


def test_the_table_has_a_row_a_formula() -> None:
    rows = lecture.slide_table()

    assert len(rows) == len(lecture.SLIDES)
    assert ("The skew-symmetric matrix", "S_v x = v x x", "lecture.skew") in rows


def test_the_page_shows_every_row_of_the_table() -> None:
    shown = [
        tuple(cell.strip().replace("`", "") for cell in re.split(r"(?<!\\)\|", line)[1:-1])
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if line.startswith("| ")
    ]
    rows = [(slide, formula.replace("|", "\\|"), names) for slide, formula, names in lecture.slide_table()]

    assert [row for row in rows if row not in shown] == []


def test_the_session_on_the_page_is_what_happens() -> None:
    result = doctest.testfile(str(PAGE), module_relative=False)

    assert result.attempted >= 5
    assert result.failed == 0


def test_importing_stiction_imports_neither_the_lecture_nor_numba() -> None:
    code = "import sys, stiction; print([name for name in ('stiction.lecture', 'numba') if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert result.stdout.strip() == "[]"


# --- friction as a force ----------------------------------------------------------------------------------------------


def test_the_surface_pushes_back_and_never_pulls() -> None:
    assert_allclose(lecture.reaction_force((3, 4, -10), UP), (0, 0, 10), **CLOSE)
    assert_allclose(lecture.reaction_force((3, 4, 10), UP), (0, 0, 0), **CLOSE)


def test_the_length_of_a_normal_does_not_matter() -> None:
    assert_allclose(lecture.reaction_force((3, 4, -10), (0, 0, 5)), (0, 0, 10), **CLOSE)
    assert_allclose(lecture.planar_force((3, 4, -10), (0, 0, 5)), (3, 4, 0), **CLOSE)


def test_planar_force_is_force_plus_reaction(rng: Generator) -> None:
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    f = rng.normal(size=3)
    f -= n * (f @ n + 1.0)  # it presses with 1 N

    assert_allclose(lecture.planar_force(f, n), f + lecture.reaction_force(f, n), **CLOSE)
    assert abs(lecture.planar_force(f, n) @ n) < 1e-12


@pytest.mark.parametrize(
    ("push", "expected"), [((3, 0), (-3, 0)), ((3, 4), (-3, -4)), ((6, 8), (-3, -4)), ((0, 0), (0, 0))]
)
def test_static_friction_takes_the_smaller_case(push: tuple[int, int], expected: tuple[int, int]) -> None:
    assert_allclose(lecture.static_friction((*push, -10), UP, 0.5), (*expected, 0), **CLOSE)


def test_dynamic_friction_depends_on_the_direction_of_sliding_alone() -> None:
    slow = lecture.dynamic_friction((0, 0, -10), UP, (0.003, 0.004, 7.0), 0.4)
    fast = lecture.dynamic_friction((0, 0, -10), UP, (30, 40, 0), 0.4)

    assert_allclose(slow, (-2.4, -3.2, 0), **CLOSE)
    assert_allclose(fast, slow, **CLOSE)
    assert_allclose(lecture.dynamic_friction((0, 0, -10), UP, (0, 0, 1), 0.4), (0, 0, 0), **CLOSE)


def test_the_slides_dynamic_friction_grows_with_the_speed() -> None:
    assert_allclose(lecture.dynamic_friction((0, 0, -10), UP, (3, 4, 7), 0.4, literal=True), (-12, -16, 0), **CLOSE)


def test_mixed_friction_is_static_at_rest_and_dynamic_in_motion() -> None:
    force = (1.0, 0.0, -10.0)

    assert_allclose(lecture.mixed_friction(force, UP, (0, 0, 2), 0.4), (-1, 0, 0), **CLOSE)
    assert_allclose(lecture.mixed_friction(force, UP, (0, 2, 0), 0.4), (0, -4, 0), **CLOSE)


# --- contact space ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("normal", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1e-9, 0, -1), (0.3, -0.8, 0.2)])
def test_the_basis_is_orthonormal_and_starts_with_the_normal(normal: tuple[float, float, float]) -> None:
    B = lecture.contact_basis(normal)

    assert_allclose(B.T @ B, np.eye(3), **CLOSE)
    assert np.linalg.det(B) == pytest.approx(1.0)
    assert_allclose(B[:, 0], np.array(normal) / np.linalg.norm(normal), **CLOSE)


def test_velocities_at_the_contact(rng: Generator) -> None:
    va, wa, ra, vb, wb, rb, n = rng.normal(size=(7, 3))
    v = lecture.collision_velocity(va, wa, ra, vb, wb, rb)
    n /= np.linalg.norm(n)

    assert_allclose(v, va + np.cross(wa, ra) - vb - np.cross(wb, rb), **CLOSE)
    assert_allclose(lecture.collision_velocity(va, wa, ra), va + np.cross(wa, ra), **CLOSE)
    assert_allclose(lecture.planar_velocity(v, n), v - n * (n @ v), **CLOSE)


def test_the_skew_matrix_is_the_cross_product(rng: Generator) -> None:
    a, b, c = 2.0, 3.0, 5.0
    v, x = rng.normal(size=(2, 3))

    assert_allclose(lecture.skew((a, b, c)), [[0, -c, b], [c, 0, -a], [-b, a, 0]], **CLOSE)
    assert_allclose(lecture.skew(v) @ x, np.cross(v, x), **CLOSE)


def test_the_angular_chain_for_a_basis_is_the_chain_for_each_direction(rng: Generator) -> None:
    r, I_inv, B = rng.normal(size=3), random_tensor(rng), lecture.contact_basis(rng.normal(size=3))

    u = lecture.impulsive_torque(r, B)
    dr = lecture.rotation_change(I_inv, u)
    dv = lecture.rotation_to_velocity(r, dr)

    for k in range(3):
        direction = B[:, k]
        torque = lecture.impulsive_torque(r, direction)
        turned = lecture.rotation_change(I_inv, torque)
        moved = lecture.rotation_to_velocity(r, turned)
        assert_allclose(torque, np.cross(r, direction), **CLOSE)
        assert_allclose(turned, I_inv @ np.cross(r, direction), **CLOSE)
        assert_allclose(moved, np.cross(turned, r), **CLOSE)
        assert_allclose(
            np.column_stack([u[:, k], dr[:, k], dv[:, k]]), np.column_stack([torque, turned, moved]), **CLOSE
        )
    assert_allclose(lecture.to_contact(B, dv), np.linalg.inv(B) @ dv, **CLOSE)
    assert_allclose(lecture.to_contact(B, dv[:, 1]), np.linalg.inv(B) @ dv[:, 1], **CLOSE)


def test_the_slides_inertia_formula_means_the_rotation_from_body_to_world() -> None:
    R, I_inv = np.array(rotation(Quat(0.5, 0.1, -0.7, 0.5))).reshape(3, 3), np.diag([0.2, 1.0, 3.0])

    def slide(M: Array) -> Array:
        return np.asarray(np.linalg.inv(M).T @ I_inv @ M.T)

    assert_allclose(lecture.world_inverse_inertia(R, I_inv), slide(R), **CLOSE)
    assert np.abs(lecture.world_inverse_inertia(R, I_inv) - slide(R.T)).max() > 1e-3


def test_the_matrix_of_the_linear_part() -> None:
    assert_allclose(lecture.inverse_mass_matrix(4.0), np.eye(3) / 4.0, **CLOSE)
    assert_allclose(lecture.inverse_mass_matrix(math.inf), np.zeros((3, 3)), **CLOSE)


def test_the_contact_matrix_says_what_a_unit_impulse_does(rng: Generator) -> None:
    c = random_contact(rng)
    K = lecture.contact_matrix(**c)

    for k in range(3):
        p = c["B"][:, k]
        va, wa = -p / c["m_a"], c["I_inv_a"] @ np.cross(c["r_a"], -p)
        vb, wb = p / c["m_b"], c["I_inv_b"] @ np.cross(c["r_b"], p)
        change = va + np.cross(wa, c["r_a"]) - vb - np.cross(wb, c["r_b"])
        assert_allclose(-K[:, k], c["B"].T @ change, **CLOSE)
    assert_allclose(K, K.T, **CLOSE)
    assert np.linalg.eigvalsh(K)[0] > 0.0


def test_a_body_that_cannot_move_adds_nothing(rng: Generator) -> None:
    c = random_contact(rng)
    alone = lecture.contact_matrix(c["B"], c["m_a"], c["I_inv_a"], c["r_a"])

    assert_allclose(alone, lecture.velocity_per_impulse(c["m_a"], c["I_inv_a"], c["r_a"], c["B"]), **CLOSE)


def test_read_word_for_word_the_angular_chain_is_not_symmetric() -> None:
    """Why the functions do not follow the order of the slides' factors."""
    B, I_inv, S = lecture.contact_basis((0.2, -0.3, 0.8)), np.diag([0.2, 1.0, 3.0]), lecture.skew((0.5, 0.4, -0.5))
    right = B.T @ -S @ I_inv @ S @ B
    as_printed = B.T @ I_inv @ (S @ B) @ S * -1.0
    applied_twice = B.T @ (-S @ I_inv @ (S @ B)) @ B

    assert np.abs(right - right.T).max() < 1e-12
    assert np.abs(as_printed - as_printed.T).max() > 1e-3
    assert np.abs(applied_twice - applied_twice.T).max() > 1e-3


def test_the_maximal_impulse_takes_the_velocity_away(rng: Generator) -> None:
    K, v = random_tensor(rng), rng.normal(size=3)

    assert_allclose(lecture.impulse_per_velocity(K) @ K, np.eye(3), **CLOSE)
    assert_allclose(K @ lecture.maximal_impulse(K, v), v, rtol=1e-11, atol=1e-11)


# --- the case distinction ---------------------------------------------------------------------------------------------

SPHERE = np.diag([1.0, 3.5, 3.5])
"""K of a solid sphere of 1 kg on a floor: 1/m along the normal, 1/m + r^2/I = 7/(2m) in the plane."""


def test_coulombs_law_holds_for_any_contact(rng: Generator) -> None:
    cases = {True: 0, False: 0}
    for _ in range(200):
        K = lecture.contact_matrix(**random_contact(rng))
        v = np.array([rng.uniform(0.1, 2.0), *rng.normal(size=2) * rng.choice([0.1, 3.0])])
        mu_static, mu_dynamic = 0.6, 0.4
        g, sticks = lecture.coulomb_impulse(K, v, mu_static, mu_dynamic)
        left, friction = v - K @ g, float(np.linalg.norm(g[1:]))
        cases[sticks] += 1

        assert abs(left[0]) < 1e-10
        if sticks:
            assert np.abs(left).max() < 1e-10
            assert friction <= mu_static * g[0]
        else:
            stuck = lecture.maximal_impulse(K, v)
            assert np.linalg.norm(stuck[1:]) > mu_static * stuck[0]
            assert friction == pytest.approx(mu_dynamic * g[0], rel=1e-9)
            assert left[1:] @ g[1:] == pytest.approx(np.linalg.norm(left[1:]) * friction, rel=1e-9)
    assert min(cases.values()) > 20


def test_between_the_coefficients_a_contact_sticks() -> None:
    v = (1.0, 3.5 * 0.55, 0.0)

    assert lecture.coulomb_impulse(SPHERE, v, 0.6, 0.4)[1]
    g, sticks = lecture.coulomb_impulse(SPHERE, v, 0.54, 0.4)
    assert not sticks
    assert_allclose(g, (1.0, 0.4, 0.0), **CLOSE)


def test_a_contact_that_opens_gets_no_impulse() -> None:
    for g, sticks in (
        lecture.coulomb_impulse(SPHERE, (-1, 2, 0), 0.5, 0.4),
        lecture.clipped_impulse(SPHERE, (-1, 2, 0), 0.5),
    ):
        assert not sticks
        assert_allclose(g, (0, 0, 0), **CLOSE)


def test_the_clipped_rule_is_right_only_where_the_plane_is_isotropic() -> None:
    v = np.array([0.2, 2.0, -3.0])
    right, clipped = lecture.coulomb_impulse(SPHERE, v, 0.4, 0.4)[0], lecture.clipped_impulse(SPHERE, v, 0.4)[0]
    assert_allclose(clipped, right, **CLOSE)

    corner = lecture.contact_matrix(
        np.column_stack([(0, 0, -1), (0, 1, 0), (1, 0, 0)]), 1.0, np.eye(3) * 6.0, (0.5, 0.5, -0.5)
    )
    angles = []
    for direction in np.radians(np.arange(360)):
        v = np.array([0.16, 5 * np.sin(direction), 5 * np.cos(direction)])
        g, sticks = lecture.clipped_impulse(corner, v, 0.4)
        left, stuck = v - corner @ g, lecture.maximal_impulse(corner, v)
        assert not sticks
        assert abs(left[0]) < 1e-12
        assert_allclose(g[1:] / np.linalg.norm(g[1:]), stuck[1:] / np.linalg.norm(stuck[1:]), **CLOSE)
        angles.append(math.acos(left[1:] @ g[1:] / np.linalg.norm(left[1:]) / np.linalg.norm(g[1:])))
    # with the normal eliminated the planar block has the eigenvalues 11/8 and 11/2; tan = (k - 1) / (2 sqrt k) of their
    # ratio k is how far its inverse turns a vector at most
    low, high = np.linalg.eigvalsh(corner[1:, 1:] - np.outer(corner[1:, 0], corner[0, 1:]) / corner[0, 0])
    ratio = high / low
    assert math.tan(max(angles)) == pytest.approx((ratio - 1) / (2 * math.sqrt(ratio)), rel=1e-3)


def test_the_slides_case_distinction_word_for_word() -> None:
    change, sticks = lecture.literal_change((2.0, 0.6, 0.8), 0.5, 0.4)
    assert sticks
    assert_allclose(change, (2.0, 0.6, 0.8), **CLOSE)

    change, sticks = lecture.literal_change((2.0, 0.6, 0.8), 0.4, 0.3, restitution=0.5)
    assert not sticks
    assert_allclose(change, (3.0, 0.18, 0.24), **CLOSE)


def test_a_sphere_sticks_farther_than_the_slides_cone_in_velocity_space() -> None:
    mu, closing = 0.4, 2.0
    for factor, right, literal in ((0.99, True, True), (1.01, True, False), (3.49, True, False), (3.51, False, False)):
        v = (closing, factor * mu * closing, 0.0)
        assert lecture.coulomb_impulse(SPHERE, v, mu, mu)[1] is right
        assert lecture.literal_change(v, mu, mu)[1] is literal


def test_rolling_resistance_works_against_the_spin_up_to_its_limit() -> None:
    B, I_inv = lecture.contact_basis((0, 0, -1)), np.eye(3) * 2.0

    limited = lecture.resisting_torque(I_inv, B, (3.0, 4.0, 6.0), 10.0, 0.01, 0.02)
    assert np.linalg.norm(limited[1:]) == pytest.approx(0.01 * 10.0)
    assert abs(limited[0]) == pytest.approx(0.02 * 10.0)
    assert_allclose(B @ limited, (0.06, 0.08, 0.2), **CLOSE)

    enough = lecture.resisting_torque(I_inv, B, (3e-4, 4e-4, 0.0), 10.0, 0.01)
    assert_allclose(I_inv @ B @ enough, (3e-4, 4e-4, 0.0), **CLOSE)


# --- the engine uses the same law -------------------------------------------------------------------------------------


def hit(velocity: tuple[float, float, float], literal: bool) -> Array:
    """The impulse on a plane that a sphere of 2 kg hits without gravity: normal part and friction, world axes."""
    table = st.MaterialTable()
    table.set_pair("ball", "floor", static=0.5, dynamic=0.3)
    world = st.World(gravity=(0, 0, 0), solver="micro", materials=table, micro_literal=literal)
    world.add(st.Plane(), static=True, material="floor")
    ball = world.add(st.Sphere(0.5), mass=2.0, material="ball", position=(0, 0, 0.5), velocity=velocity)
    world.step()
    contact = world.contacts(ball)[0]
    sign = 1.0 if contact["body_b"] == ball.index else -1.0
    return np.asarray(sign * (contact["normal"] * contact["normal_impulse"] + contact["friction_impulse"]))


@pytest.mark.parametrize("velocity", [(0.4, 0.3, -1.0), (4.0, 3.0, -1.0)])
@pytest.mark.parametrize("literal", [False, True])
def test_the_engine_gives_one_contact_the_lectures_impulse(velocity: tuple[float, float, float], literal: bool) -> None:
    B, r = lecture.contact_basis((0, 0, -1)), (0, 0, -0.5)  # from the ball, which is A, down into the floor
    K = lecture.contact_matrix(B, 2.0, np.eye(3) / (0.4 * 2.0 * 0.5**2), r)
    v = lecture.to_contact(B, lecture.collision_velocity(velocity, (0, 0, 0), r))
    if literal:
        g = lecture.maximal_impulse(K, lecture.literal_change(v, 0.5, 0.3)[0])
    else:
        g = lecture.coulomb_impulse(K, v, 0.5, 0.3)[0]

    assert_allclose(hit(velocity, literal), -B @ g, rtol=1e-9, atol=1e-9)


# --- bad input --------------------------------------------------------------------------------------------------------

EYE = np.eye(3)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: lecture.skew((1, 2)), r"v must have shape \(3,\)"),
        (lambda: lecture.skew((1, 2, math.nan)), "v must be 3 finite numbers"),
        (lambda: lecture.contact_basis((0, 0, 0)), "normal must not be the zero vector"),
        (lambda: lecture.planar_velocity((1, 0, 0), (0, 0, 0)), "n must not be the zero vector"),
        (lambda: lecture.static_friction((0, 0, -1), UP, -0.1), "mu_static must be 0 or more"),
        (lambda: lecture.dynamic_friction((0, 0, -1), UP, (1, 0, 0), math.inf), "mu_dynamic must be a finite number"),
        (lambda: lecture.dynamic_friction((0, 0, -1), UP, (1, 0, 0), 0.1, literal=1), "literal must be True or False"),
        (lambda: lecture.impulsive_torque((1, 0, 0), [[1, 2], [3]]), r"B must be finite numbers of shape \(3,\) or"),
        (lambda: lecture.impulsive_torque((1, 0, 0), [[1, 2]]), r"B must have shape \(3,\) or \(3, 3\)"),
        (lambda: lecture.rotation_change(np.full((3, 3), math.inf), EYE), "I_inv must be finite"),
        (lambda: lecture.rotation_change(np.triu(np.ones((3, 3))), EYE), "I_inv must be symmetric"),
        (lambda: lecture.to_contact(2 * EYE, EYE), "B must be orthonormal"),
        (lambda: lecture.to_contact(-EYE, EYE), "B must be orthonormal and right-handed"),
        (lambda: lecture.inverse_mass_matrix(0.0), "m must be above 0 kg"),
        (lambda: lecture.inverse_mass_matrix(math.nan), "m must be a finite number"),
        (lambda: lecture.contact_matrix(EYE, "heavy", EYE, UP), "m_a must be a finite number"),
        (lambda: lecture.maximal_impulse(np.zeros((3, 3)), UP), "K must be positive definite"),
        (lambda: lecture.maximal_impulse(np.diag([1, 1, -1]), UP), "K must be positive definite"),
        (lambda: lecture.coulomb_impulse(EYE, UP, 0.3, 0.4), "mu_dynamic must not be above mu_static"),
        (lambda: lecture.literal_change(UP, 0.3, 0.2, restitution=1.5), "restitution must be 0 to 1"),
        (lambda: lecture.resisting_torque(EYE, EYE, UP, -1.0, 0.1), "normal_impulse must be 0 N s or more"),
    ],
)
def test_bad_input_is_named(call: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(st.InvalidInputError, match=sentence):
        call()
