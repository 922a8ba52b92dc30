"""Vehicles against closed forms: how they stand, brake, corner and pull, and where their energy goes."""

from __future__ import annotations

import doctest
import math

import numpy as np
import pytest

import stiction as st
from stiction import vehicle

G = 9.81
MASS, BASE, TRACK, RADIUS = 1200.0, 2.6, 1.5, 0.3
MU = 0.9


def materials(front=15.0, rear=15.0, **properties):
    """Tyres of both axles on a road, by the brush model unless ``properties`` say otherwise."""
    made = st.MaterialTable()
    for name, stiffness in (("front", front), ("rear", rear)):
        given = {"static": MU, "dynamic": MU, "law": st.BrushTyre(stiffness)} | properties
        made.set_pair(name, "road", **given)
    return made


def car(speed=0.0, *, table=None, gravity=(0, 0, -G), dt=1 / 60, **options):
    """A car on a plane that drives along x."""
    world = st.World(gravity=gravity, dt=dt, materials=materials() if table is None else table)
    world.add(st.Plane(), static=True, material="road")
    return with_wheels(world, speed, **options)


def with_wheels(world, speed=0.0, position=(0, 0, 0.55), **options):
    """The car itself; its wheels are not shown unless asked for."""
    chassis = world.add(st.Box((4, 1.2, 0.5)), mass=MASS, position=position, velocity=(speed, 0, 0))
    wheels = [
        st.Wheel((x, y, -0.25), material="front" if x > 0 else "rear", steered=x > 0, drive=0.0 if x > 0 else 0.5)
        for x in (0.5 * BASE, -0.5 * BASE)
        for y in (0.5 * TRACK, -0.5 * TRACK)
    ]
    return st.Vehicle(world, chassis, wheels, **{"visible": False} | options)


def yaw(body):
    """rad to the left."""
    w, x, y, z = body.orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


# --- standing and straight on ----------------------------------------------------------------------------------------


def test_it_stands_where_it_was_put():
    made = car()
    made.step(30)
    assert made.chassis.position == pytest.approx((0, 0, 0.55), abs=1e-6)
    assert [state.load for state in made.states] == pytest.approx([MASS * G / 4] * 4)


def test_axles_carry_by_their_levers():
    world = st.World(materials=materials())
    world.add(st.Plane(), static=True, material="road")
    chassis = world.add(st.Box((4, 1.2, 0.5)), mass=MASS, position=(0, 0, 0.55))
    made = st.Vehicle(
        world, chassis, st.four_wheels(front=1.0, rear=-2.0, track=TRACK, hub_height=-0.25, tyre="rear"), visible=False
    )
    made.step(20)
    loads = [state.load for state in made.states]
    assert loads == pytest.approx([MASS * G / 3] * 2 + [MASS * G / 6] * 2, rel=1e-5)


def test_straight_on_it_keeps_speed_and_line():
    made = car(20.0)
    made.step(60)
    assert made.chassis.position == pytest.approx((20, 0, 0.55), abs=1e-4)
    assert made.chassis.velocity == pytest.approx((20, 0, 0), abs=1e-4)
    assert [state.spin for state in made.states] == pytest.approx([20 / RADIUS] * 4, rel=1e-5)


def test_a_dropped_car_comes_to_rest_on_its_springs():
    made = car()
    made.chassis.position = (0, 0, 0.75)
    made.step(5)
    assert made.states[0].ground is None and made.states[0].load == 0.0
    made.step(100)
    assert made.chassis.position[2] == pytest.approx(0.55, abs=1e-4)


# --- braking and pulling ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("speed", "dt"), [(20.0, 1 / 60), (6.0, 1 / 240)])
def test_locked_wheels_stop_after_v2_over_2_mu_g(speed, dt):
    made = car(speed, dt=dt, brake_torque=1e5)
    made.brake = 1.0
    made.step(round((speed / (MU * G) + 0.2) / dt))
    assert made.chassis.position[0] == pytest.approx(speed**2 / (2 * MU * G), rel=0.01)
    assert abs(made.chassis.position[1]) < 1e-6
    assert max(abs(state.spin) for state in made.states) == 0.0


def test_locked_wheels_of_a_pair_with_two_constants_slide_by_the_dynamic_one():
    table = materials(static=0.8, dynamic=0.5, law=st.Coulomb())
    made = car(6.0, table=table, brake_torque=1e5)
    made.brake = 1.0
    made.step(90)
    assert made.chassis.position[0] == pytest.approx(36 / (2 * 0.5 * G), rel=0.01)


@pytest.mark.parametrize(("tangent", "holds"), [(0.78, True), (0.82, False)])
def test_brakes_hold_up_to_the_static_coefficient(tangent, holds):
    """Tilted in a second and a half: at once it would rock on its springs, and pull harder than it weighs."""
    made = car(table=materials(static=0.8, dynamic=0.5, law=st.Coulomb()), brake_torque=1e5)
    made.brake = 1.0
    for k in range(90):
        a = math.atan(tangent * (k + 1) / 90)
        made.world.gravity = (G * math.sin(a), 0, -G * math.cos(a))
        made.step()
    made.step(20)
    start = made.chassis.position[0]
    made.step(40)
    moved = abs(made.chassis.position[0] - start)
    assert (moved < 2e-3) if holds else (moved > 0.2)


def test_half_the_brakes_slow_down_by_their_torque():
    """Rolling wheels turn slower, too: torque / r = (m + 4 I / r^2) a, but for the slip."""
    made = car(20.0, brake_torque=2000.0)
    made.brake = 0.5
    made.step(60)
    before = made.chassis.velocity[0]
    made.step(60)
    inertia = 4 * made.wheels[0].inertia / RADIUS**2
    assert before - made.chassis.velocity[0] == pytest.approx(1000.0 / RADIUS / (MASS + inertia), rel=5e-3)


def test_throttle_pulls_forwards_and_back():
    for throttle in (1.0, -0.5):
        made = car(drive_torque=800.0)
        made.throttle = throttle
        made.step(60)
        inertia = 4 * made.wheels[0].inertia / RADIUS**2
        assert made.speed == pytest.approx(throttle * 800.0 / RADIUS / (MASS + inertia), rel=0.02)


def test_energy_goes_into_tyres_and_brakes():
    made = car(20.0, brake_torque=3000.0)
    inertia = made.wheels[0].inertia

    def kinetic():
        return made.chassis.kinetic_energy + sum(0.5 * inertia * state.spin**2 for state in made.states)

    before = kinetic()
    made.brake, made.steer = 1.0, 0.05
    made.step(90)
    work = made.work
    assert min(work.tyres, work.brakes) > 0.0
    lost = work.tyres + work.brakes + work.dampers
    assert before - kinetic() == pytest.approx(lost, rel=0.01)
    ledger = made.world.energy()
    assert ledger.friction == pytest.approx(work.tyres)
    assert made.chassis.friction_work == pytest.approx(work.tyres)
    assert abs(ledger.residual) < 1e-6


# --- cornering -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.1, -0.3])
def test_slowly_it_goes_round_on_ackermanns_circle(angle):
    made = car(2.0)
    made.steer = angle
    made.step(120)
    speed, rate = np.hypot(*made.chassis.velocity[:2]), made.chassis.angular_velocity[2]
    expected = math.copysign(math.hypot(BASE / math.tan(angle), 0.5 * BASE), angle)
    assert speed / rate == pytest.approx(expected, rel=0.01)


def test_axles_point_to_one_centre():
    made = car()
    made.steer = 0.4
    left, right, *rear = made.steering_angles()
    centre = BASE / math.tan(0.4)
    assert BASE / math.tan(left) == pytest.approx(centre - 0.5 * TRACK)
    assert BASE / math.tan(right) == pytest.approx(centre + 0.5 * TRACK)
    assert rear == [0.0, 0.0]


@pytest.mark.parametrize(("front", "rear"), [(15.0, 15.0), (10.0, 15.0), (15.0, 12.0)])
def test_yaw_rate_is_that_of_the_bicycle_model(front, rear):
    """r = v delta / (L + K v^2), K = (W_f / C_f - W_r / C_r) / g; cornering stiffness is load times that of the law."""
    made = car(20.0, table=materials(front, rear))
    made.steer = 0.0005
    made.step(120)
    speed = made.speed
    K = (1 / front - 1 / rear) / G
    assert made.chassis.angular_velocity[2] == pytest.approx(speed * 0.0005 / (BASE + K * speed**2), rel=0.01)


def test_no_more_than_mu_g_across():
    made = car(20.0)
    most = 0.0
    for k in range(100):
        made.steer = min(0.15, 0.15 * k / 60)
        before = made.chassis.velocity
        made.step()
        change = (made.chassis.velocity - before) * 60
        most = max(most, float(np.linalg.norm(np.cross(change, before)) / np.linalg.norm(before)))
    assert 0.95 * MU * G < most < 1.005 * MU * G


def test_braking_takes_from_cornering():
    """Combined slip: all friction together is never more than mu N, wheel by wheel."""
    made = car(20.0, table=materials(law=st.MagicFormula(10.0, 1.6, 0.5)), brake_torque=4000.0)
    made.steer = 0.1
    made.step(40)
    alone = sum(state.sideways for state in made.states[:2])
    made.brake = 1.0
    made.step(20)
    for state in made.states:
        assert math.hypot(state.forward, state.sideways) <= 1.0001 * MU * state.load
    assert sum(state.sideways for state in made.states[:2]) < alone
    assert all(state.forward < 0.0 for state in made.states)


@pytest.mark.parametrize("icy", [1.0, -1.0])
def test_on_split_friction_it_turns_to_where_tyres_hold(icy):
    table = materials()
    for tyre in ("front", "rear"):
        table.set_pair(tyre, "ice", static=0.1, dynamic=0.1, law=st.BrushTyre(5.0))
    world = st.World(materials=table)
    for side, material in ((icy, "ice"), (-icy, "road")):
        world.add(st.Box((200, 20, 1)), static=True, material=material, position=(0, 10 * side, -0.5))
    made = with_wheels(world, 20.0, brake_torque=2800.0)
    made.brake = 1.0
    made.step(45)
    assert icy * yaw(made.chassis) < -0.05
    assert made.speed > 20.0 - 0.9 * MU * G * 0.75


# --- grounds ---------------------------------------------------------------------------------------------------------


def test_a_ground_that_can_move_is_pushed_back():
    table = materials()
    table.set_pair("default", "default", static=0.0, dynamic=0.0)
    world = st.World(materials=table)
    world.add(st.Plane(), static=True)
    raft = world.add(st.Box((12, 6, 1)), mass=3000.0, position=(0, 0, 0.5), material="road")
    table.set_pair("road", "default", static=0.0, dynamic=0.0)
    made = with_wheels(world, position=(0, 0, 1.55), drive_torque=800.0)
    made.throttle = 1.0
    made.step(60)
    assert made.speed > 0.5
    assert raft.velocity[0] * 3000.0 == pytest.approx(-made.chassis.velocity[0] * MASS, rel=1e-3)


def test_a_belt_carries_a_car_with_its_brakes_on():
    world = st.World(materials=materials())
    world.add(st.Plane(), static=True, material="road", surface_velocity=(1.5, 0, 0))
    made = with_wheels(world, brake_torque=1e5)
    made.brake = 1.0
    made.step(90)
    assert made.chassis.velocity[0] == pytest.approx(1.5, abs=5e-3)


# --- what is shown and said ------------------------------------------------------------------------------------------


def test_wheels_are_shown_where_they_are():
    world = st.World(materials=materials())
    world.add(st.Box((50, 50, 1)), static=True, position=(0, 0, -0.5), material="road")
    made = with_wheels(world, 2.0, visible=True)
    made.steer = 0.3
    made.step(30)
    wheel = world["box 1 wheel 0"]
    w, x, y, z = wheel.orientation
    axle = np.array((2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
    heading = yaw(made.chassis) + made.steering_angles()[0]
    assert axle == pytest.approx((-math.sin(heading), math.cos(heading), 0.0), abs=0.02)
    assert wheel.position[2] == pytest.approx(RADIUS, abs=0.02)
    c, s = math.cos(yaw(made.chassis)), math.sin(yaw(made.chassis))
    at = np.array((c * 1.3 - s * 0.75, s * 1.3 + c * 0.75))
    assert wheel.position[:2] == pytest.approx(made.chassis.position[:2] + at, abs=0.01)


def test_the_same_drive_gives_the_same_bits():
    hashes = []
    for _ in range(2):
        made = car(15.0)
        made.steer, made.throttle = 0.05, 0.5
        made.step(20)
        hashes.append(made.world.state_hash())
    assert hashes[0] == hashes[1]


def test_the_example_gives_what_is_shown():
    failed, tried = doctest.testmod(vehicle)
    assert failed == 0 and tried > 0


def test_apply_is_for_one_step():
    made = car()
    made.apply()
    with pytest.raises(st.InvalidInputError, match="once a step"):
        made.apply()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: car(frequency=0.0), "frequency must be above 0 Hz, got 0.0"),
        (lambda: car(damping=-1), "damping must be 0 or more, got -1"),
        (lambda: car(drive_torque=math.nan), "drive_torque must be a finite number"),
        (lambda: setattr(car(), "throttle", 2), "throttle must be -1 to 1, got 2"),
        (lambda: setattr(car(), "brake", -0.1), "brake must be 0 to 1, got -0.1"),
        (lambda: setattr(car(), "steer", 2.0), "steer must be -1.22173 to 1.22173, got 2.0"),
        (lambda: car().step(0), "n must be a whole number, 1 or more"),
        (lambda: st.Wheel((0, 0)), "position of a wheel must have shape (3,)"),
        (lambda: st.Wheel((0, 0, 0), radius=0), "radius of a wheel must be above 0 m, got 0"),
        (lambda: st.four_wheels(front=-1, rear=1, track=1, hub_height=0), "front must be ahead of rear (1 m), got -1"),
        (lambda: st.four_wheels(front=1, rear=0, track=1, hub_height=0, drive="four"), "drive must be one of front"),
        (lambda: st.four_wheels(front=1, rear=0, track=1, hub_height=0, brake_front=2), "brake_front must be 0 to 1"),
    ],
)
def test_bad_input_gets_one_sentence(call, words):
    with pytest.raises(st.InvalidInputError) as error:
        call()
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("places", "words"),
    [
        ([(1, 1, 0), (1, -1, 0)], "wheels must be three or more, got 2"),
        ([(1, 0, 0), (0, 0, 0), (-1, 0, 0)], "must not stand in one line"),
        ([(2, 1, 0), (2, -1, 0), (1, 0, 0)], "must stand around the centre of mass"),
    ],
)
def test_wheels_that_carry_nothing_are_refused(places, words):
    world = st.World()
    chassis = world.add(st.Box((4, 1, 1)), position=(0, 0, 1))
    with pytest.raises(st.InvalidInputError) as error:
        st.Vehicle(world, chassis, [st.Wheel(place) for place in places])
    assert words in str(error.value)
    assert len(world) == 1


def test_the_chassis_must_be_a_dynamic_body_and_the_tyre_a_material():
    world = st.World()
    floor = world.add(st.Plane(), static=True)
    wheels = st.four_wheels(front=1, rear=-1, track=1, hub_height=0)
    with pytest.raises(st.InvalidInputError, match="chassis must be dynamic"):
        st.Vehicle(world, floor, wheels)
    body = world.add(st.Box((4, 1, 1)), position=(0, 0, 1))
    wheels = st.four_wheels(front=1, rear=-1, track=1, hub_height=0, tyre="rubbr")
    with pytest.raises(st.InvalidInputError, match="rubber"):
        st.Vehicle(world, body, wheels)
    with pytest.raises(st.InvalidInputError, match="must be a body of this world"):
        st.Vehicle(st.World(), body, wheels)
