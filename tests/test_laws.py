"""Friction laws in a world: speed, slip, grain and adhesion, against closed forms and small integrations."""

from __future__ import annotations

import math

import numpy as np
import pytest

import stiction as st

G = 9.81
H = 1e-5
"""s, step of the reference integrations."""


def table(**properties):
    """A table with one pair, a body on a floor."""
    made = st.MaterialTable()
    made.set_pair("body", "floor", **properties)
    return made


def world_on(materials, **options):
    """A world with a floor of material ``floor``."""
    world = st.World(materials=materials, **options)
    world.add(st.Plane(), static=True, material="floor")
    return world


def slab(world, **options):
    """A flat crate on the floor."""
    return world.add(st.Box((1.0, 1.0, 0.2)), position=(0, 0, 0.1), material="body", **options)


def stopping_distance(mu, v):
    """Of a point that slides with mu(v), by the mid-point rule."""
    x = 0.0
    while v > 0.0:
        new = max(v - mu(v - 0.5 * mu(v) * G * H) * G * H, 0.0)
        x, v = x + 0.5 * (v + new) * H, new
    return x


# --- speed -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("exponent", "viscous"), [(2.0, 0.0), (1.0, 0.05)])
def test_stribeck_stops_where_its_integral_says(exponent, viscous):
    law = st.Stribeck(speed=0.5, viscous=viscous, exponent=exponent)
    world = world_on(table(static=0.6, dynamic=0.3, law=law))
    crate = slab(world, velocity=(3, 0, 0))
    world.run(3.0)
    expected = stopping_distance(lambda v: 0.3 + 0.3 * math.exp(-((max(v, 0.0) / 0.5) ** exponent)) + viscous * v, 3.0)
    assert crate.position[0] == pytest.approx(expected, rel=1e-3)
    assert not crate.velocity.any() or np.abs(crate.velocity).max() < 1e-9


def test_curve_is_followed_between_and_beyond_its_points():
    points = [(0.5, 0.2), (1.0, 0.4), (2.0, 0.1)]
    world = world_on(table(static=0.6, dynamic=0.3, law=st.FrictionCurve(points)))
    crate = slab(world, velocity=(3, 0, 0))
    world.run(5.0)
    expected = stopping_distance(lambda v: float(np.interp(v, *zip(*points, strict=True))), 3.0)
    assert crate.position[0] == pytest.approx(expected, rel=1e-3)


def test_law_changes_nothing_at_rest():
    materials = table(static=0.5, dynamic=0.3, law=st.Stribeck(speed=0.01))
    angle = math.atan(0.499)
    world = world_on(materials, gravity=(G * math.sin(angle), 0, -G * math.cos(angle)))
    crate = slab(world)
    world.run(5.0)
    assert abs(crate.position[0]) < 1e-6


# --- grain -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.2, math.pi / 2])
def test_grain_goes_with_the_body(yaw):
    """dv/dt = -mu g E E v / |E v|, E = diag(1, 2) in the axes of the grain: an ellipse, friction most dissipative."""
    world = world_on(table(static=0.5, dynamic=0.2, static_across=0.6, dynamic_across=0.4))
    turned = (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))
    crate = slab(world, velocity=(3, 0, 0), orientation=turned, grain=(1, 0, 0))
    world.run(3.0)
    R = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    E = R @ np.diag([1.0, 2.0]) @ R.T
    v, x, h = np.array([3.0, 0.0]), np.zeros(2), 1e-4
    while v @ v > 1e-4:
        e = E @ v
        new = v - 0.2 * G * h * (E @ e) / math.sqrt(e @ e)
        x, v = x + 0.5 * (v + new) * h, new
    assert crate.position[:2] == pytest.approx(x, abs=0.003 * np.linalg.norm(x))


@pytest.mark.parametrize("heading", [0.0, 0.7, math.pi / 2])
def test_grain_makes_an_ellipse_of_the_static_limit(heading):
    """A pull in a direction holds up to the length of the ellipse there."""
    materials = table(static=0.4, dynamic=0.2, static_across=0.8, dynamic_across=0.6)
    limit = 1.0 / math.hypot(math.cos(heading) / 0.4, math.sin(heading) / 0.8)
    for share, holds in ((0.99, True), (1.01, False)):
        push = share * limit * G
        world = world_on(materials, gravity=(push * math.cos(heading), push * math.sin(heading), -G))
        crate = slab(world, grain=(2, 0, 0))
        world.run(2.0)
        moved = float(np.linalg.norm(crate.position[:2]))
        assert (moved < 1e-5) if holds else (moved > 0.05)


def test_grain_in_a_spin():
    """A crate that spins on a surface with grain: the torque is mu N times the mean of |E J x| over the face."""
    world = st.World(materials=table(static=0.3, dynamic=0.3, static_across=0.9, dynamic_across=0.9))
    # the floor has the grain, and the crate turns over it
    world.add(st.Plane(), static=True, material="floor", grain=(1, 0, 0))
    crate = slab(world, angular_velocity=(0, 0, 10))
    dt, seen = world.dt, []
    for _ in range(40):
        before = crate.angular_velocity[2]
        world.step()
        seen.append((before - crate.angular_velocity[2]) / dt)
    # the mean over a turn of the crate: |E J x| of a square face, averaged over its orientation
    n = 200
    s = (np.arange(n) + 0.5) / n - 0.5
    X, Y = np.meshgrid(s, s)
    torques = []
    for yaw in np.linspace(0.0, math.pi / 2, 21)[:-1]:
        x, y = X * math.cos(yaw) - Y * math.sin(yaw), X * math.sin(yaw) + Y * math.cos(yaw)
        torques.append(np.hypot(y, 3.0 * x).mean())
    expected = 0.3 * G * np.mean(torques) / ((1 + 1) / 12)
    assert np.mean(seen[2:]) == pytest.approx(expected, rel=0.02)


# --- tyres -----------------------------------------------------------------------------------------------------------


def brush(slip, mu=0.9, stiffness=15.0):
    theta = min(stiffness * slip / (3.0 * mu), 1.0)
    return mu * theta * (3.0 - 3.0 * theta + theta * theta)


def magic(slip, mu=0.9, B=10.0, C=1.6, E=0.5):
    x = B * slip
    return mu * math.sin(C * math.atan(x - E * (x - math.atan(x))))


@pytest.mark.parametrize("law", ["brush", "magic"])
@pytest.mark.parametrize("slip", [(0.02, 0.0), (0.0, 0.05), (0.06, -0.08), (0.5, 0.0)])
def test_tyre_in_combined_slip(law, slip):
    """A wheel whose spin cannot change: braking and cornering force are mu(|slip|) N against the slip, as it decays."""
    made = st.BrushTyre(15.0) if law == "brush" else st.MagicFormula(10.0, 1.6, 0.5)
    world = world_on(table(static=0.9, dynamic=0.9, law=made))
    v, r = 20.0, 0.3
    velocity = np.array([math.sqrt(1 - slip[1] ** 2), slip[1], 0.0]) * v
    spin = (0, (velocity[0] - slip[0] * v) / r, 0)
    wheel = world.add(
        st.Sphere(r), position=(0, 0, r), velocity=velocity, angular_velocity=spin, material="body", mass=10.0,
        inertia=(1e6, 1e6, 1e6),
    )  # fmt: skip
    world.step(8)
    tread, u, h = np.array([spin[1] * r, 0.0]), velocity[:2].copy(), 1e-5
    curve = brush if law == "brush" else magic
    for _ in range(round(8 * world.dt / h)):
        sliding = u - tread
        speed = math.hypot(*sliding)
        u = u - sliding / speed * curve(speed / math.hypot(*u)) * G * h
    change = u - velocity[:2]
    assert (wheel.velocity - velocity)[:2] == pytest.approx(change, abs=0.01 * np.linalg.norm(change))


def test_locked_wheel_slides_and_a_standing_one_holds():
    materials = table(static=0.9, dynamic=0.9, law=st.BrushTyre(15.0))
    angle = math.atan(0.5)
    world = world_on(materials, gravity=(G * math.sin(angle), 0, -G * math.cos(angle)))
    crate = slab(world)
    world.run(10.0)
    assert np.linalg.norm(crate.position[:2]) < 1e-4
    world = world_on(materials)
    crate = slab(world, velocity=(5, 0, 0))
    world.run(2.0)
    assert crate.position[0] == pytest.approx(25 / (2 * 0.9 * G), rel=0.01)


# --- adhesion --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["adhesion", "adhesion_pressure"])
def test_adhesion_holds_up_to_its_force(kind):
    """A crate of 200 kg on 1 m^2 that is held with 500 N."""
    for pull, holds in ((0.98, True), (1.02, False)):
        world = world_on(table(static=0.5, dynamic=0.5, **{kind: 500.0}))
        crate = slab(world, mass=200.0)
        world.step()
        for _ in range(60):
            crate.apply_force((0, 0, 200.0 * G + pull * 500.0))
            world.step()
        height = crate.position[2] - 0.1
        assert (abs(height) < 1e-3) if holds else (height > 0.01)


def test_friction_is_that_of_load_and_adhesion():
    for share, holds in ((0.99, True), (1.01, False)):
        world = world_on(table(static=0.5, dynamic=0.4, adhesion=1000.0))
        crate = slab(world, mass=100.0)
        for _ in range(120):
            crate.apply_force((share * 0.5 * (100.0 * G + 1000.0), 0, 0))
            world.step()
        assert (crate.position[0] < 1e-4) if holds else (crate.position[0] > 0.1)
    world = world_on(table(static=0.5, dynamic=0.4, adhesion=1000.0))
    crate = slab(world, mass=100.0, velocity=(4, 0, 0))
    world.run(3.0)
    assert crate.position[0] == pytest.approx(16 / (2 * 0.4 * (G + 10.0)), rel=5e-3)


# --- the table -------------------------------------------------------------------------------------------------------


def test_rows_keep_laws():
    made = table(
        static=0.5, dynamic=0.3, law=st.FrictionCurve([(0, 0.3), (1, 0.2)]), static_across=0.6, dynamic_across=0.4,
        adhesion=3.0, adhesion_pressure=7.0, tangential_restitution=0.25,
    )  # fmt: skip
    again = st.MaterialTable.from_rows(made.to_toml_rows())
    assert again == made
    again.set_pair("body", "floor", law=st.Coulomb(), adhesion=0.0)
    assert again.pair("body", "floor").law == st.Coulomb()
    assert again.pair("body", "floor").static_across == 0.6


def test_plain_tables_stay_narrow():
    assert table(static=0.5).to_array(["body", "floor"]).shape == (2, 2, 5)
    assert table(static=0.5, adhesion=1.0).to_array(["body", "floor"]).shape[2] > 10
    rebounds = table(static=0.5, tangential_restitution=0.5).to_array(["body", "floor"])
    assert rebounds.shape[2] == 6
    assert rebounds[0, 1].tolist() == [0.5, 0.5, 0.0, 0.0, 0.0, 0.5]


@pytest.mark.parametrize(
    ("properties", "words"),
    [
        ({"law": "stribeck"}, "law must be a friction law such as"),
        ({"law": {"kind": "stribek", "speed": 1}}, "did you mean 'stribeck'"),
        ({"law": {"kind": "stribeck"}}, "law 'stribeck' needs speed"),
        ({"law": {"kind": "stribeck", "sped": 1}}, "did you mean 'speed'"),
        ({"law": {"kind": "stribeck", "speed": 0}}, "speed of a Stribeck law must be above 0 m/s, got 0"),
        ({"law": {"kind": "curve", "points": [(0, 1)]}}, "must be 2 to 16 pairs"),
        ({"law": {"kind": "curve", "points": [(1, 0.2), (1, 0.3)]}}, "must have speeds that rise"),
        ({"law": {"kind": "curve", "points": [(0, 0.2), (1, -0.3)]}}, "coefficient 1 of a friction curve must be 0"),
        ({"law": {"kind": "brush", "stiffness": -1}}, "stiffness of a brush tyre must be above 0"),
        ({"law": {"kind": "magic", "B": 1, "C": 3}}, "C of a magic formula must be 2 or less"),
        ({"law": {"kind": "magic", "B": 1, "C": 1, "E": 2}}, "E of a magic formula must be -10 to 1"),
        ({"law": {"kind": "stribeck", "speed": 1, "exponent": 9}}, "exponent of a Stribeck law must be 0.5 to 4"),
        ({"tangential_restitution": 1.5}, "tangential restitution of body - floor must be between 0 and 1, got 1.5"),
        ({"adhesion": -1}, "adhesion of body - floor must be 0 N or more, got -1"),
        ({"adhesion_pressure": math.nan}, "adhesion pressure of body - floor must be a finite number"),
        ({"static_across": -0.1}, "static friction across the grain of body - floor must be 0 or more"),
        ({"static_across": 0.0}, "must be above 0 where the one along it is"),
    ],
)  # fmt: skip
def test_bad_properties_get_one_sentence(properties, words):
    made = st.MaterialTable()
    with pytest.raises(st.InvalidInputError) as error:
        made.set_pair("body", "floor", static=0.5, **properties)
    assert words in str(error.value)
    assert len(made) == 1


def test_micro_says_that_it_has_no_laws():
    world = st.World(solver="micro", materials=table(static=0.5, adhesion=1.0))
    world.add(st.Plane(), static=True, material="floor")
    world.add(st.Sphere(0.5), position=(0, 0, 0.5), material="body")
    with pytest.raises(st.NotYetError, match="micro"):
        world.step()
    with pytest.raises(st.NotYetError, match="grain"):
        world.add(st.Sphere(0.5), grain=(1, 0, 0))


def test_bad_grain():
    world = st.World()
    with pytest.raises(st.InvalidInputError, match="grain must not be the zero vector"):
        world.add(st.Sphere(1.0), grain=(0, 0, 0))
    assert len(world) == 0
