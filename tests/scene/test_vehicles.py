"""Vehicles in scene files: what is refused, and that the driver does what the controls say."""

from __future__ import annotations

import math
from typing import Any

import pytest

from stiction.errors import InvalidInputError
from stiction.scene import Scene, Simulation, json_schema, load

CAR: dict[str, Any] = {
    "name": "car",
    "chassis": "body",
    "front": 1.3,
    "rear": -1.3,
    "track": 1.5,
    "hub_height": -0.25,
}


def scene(**changes: Any) -> dict[str, Any]:
    """A car on a floor, with changes of its table; None takes a key away."""
    car = {key: value for key, value in (CAR | changes).items() if value is not None}
    floor = {"name": "floor", "shape": {"type": "box", "size": [90, 90, 1]}, "static": True, "position": [0, 0, -0.5]}
    body = {"name": "body", "shape": {"type": "box", "size": [4, 1.2, 0.5]}, "mass": 1200.0, "position": [0, 0, 0.55]}
    return {"title": "a", "expect": "b", "duration": 0.5, "bodies": [floor, body], "vehicles": [car]}


def test_controls_are_followed_in_straight_lines() -> None:
    rows = [{"time": 0.1, "steer_deg": 10}, {"time": 0.3, "throttle": 1, "brake": 0.5, "steer_deg": -10}]
    simulation = Simulation(Scene.from_dict(scene(controls=rows)))
    car = simulation.vehicles["car"]
    simulation.advance(3)
    assert (car.throttle, car.brake, car.steer) == (0.0, 0.0, pytest.approx(math.radians(10)))
    simulation.advance(9)
    part = (11.5 / 60 - 0.1) / 0.2
    assert car.throttle == pytest.approx(part)
    assert car.brake == pytest.approx(0.5 * part)
    assert car.steer == pytest.approx(math.radians(10 - 20 * part))
    simulation.advance(10)
    assert (car.throttle, car.brake) == (1.0, 0.5)


def test_however_the_steps_are_cut() -> None:
    data = scene(controls=[{"time": 0.0, "throttle": 1.0, "steer_deg": 5}])
    one, other = (Simulation(Scene.from_dict(data)) for _ in range(2))
    one.advance(30)
    for count in (1, 2, 27):
        other.advance(count)
    assert one.done and one.world.state_hash() == other.world.state_hash()


def test_a_scene_with_a_vehicle_comes_back_from_its_own_data() -> None:
    made = load("vehicle")
    assert Scene.from_dict(made.to_dict()) == made
    assert load("vehicle", ["vehicles.first.brake_torque=100"]).table.vehicles[0].brake_torque == 100.0


def test_the_schema_has_vehicles() -> None:
    schema = json_schema()
    assert "vehicles" in schema["properties"]
    assert set(CAR) <= set(schema["$defs"]["VehicleTable"]["required"])
    assert schema["$defs"]["ControlTable"]["properties"]["brake"]["maximum"] == 1.0


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"wheelbase": 2}, "vehicles[0].wheelbase: is not a known key"),
        ({"trakc": 2}, "(did you mean 'track'?)"),
        ({"track": None}, "vehicles[0].track: must be given."),
        ({"track": 0}, "vehicles[0].track: "),
        ({"drive": "frnt"}, "(did you mean 'front'?)"),
        ({"front": -2.0}, "vehicles[0].front: must be ahead of rear (-1.3 m), got -2."),
        ({"brake_front": 2}, "vehicles[0].brake_front: must be between 0 and 1, got 2."),
        ({"chassis": "bdy"}, "vehicles[0].chassis: must be a body of the scene, got 'bdy' (did you mean 'body'?)."),
        ({"chassis": "floor"}, "vehicles[0].chassis: must be a dynamic body, and 'floor' is not."),
        ({"tyre": "rubbr"}, "vehicles[0].tyre: must be a material of the scene, got 'rubbr'"),
        ({"controls": [{"time": 0, "brak": 1}]}, "vehicles[0].controls[0].brak: is not a known key"),
        ({"controls": [{"time": 0, "brake": 2}]}, "vehicles[0].controls[0].brake: must be between 0 and 1, got 2."),
        (
            {"controls": [{"time": 1}, {"time": 1}]},
            "vehicles[0].controls: must have times that rise, got [1.0, 1.0] s.",
        ),
    ],
)
def test_what_is_wrong_is_named(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InvalidInputError) as error:
        Scene.from_dict(scene(**changes))
    assert sentence in str(error.value)


def test_two_vehicles_of_one_name_are_refused() -> None:
    data = scene()
    data["vehicles"] *= 2
    with pytest.raises(InvalidInputError, match="must be unique in a scene, got 'car' twice"):
        Scene.from_dict(data)


def test_wheels_that_carry_nothing_are_named_with_their_vehicle() -> None:
    with pytest.raises(InvalidInputError, match=r"vehicles\[0\]: wheels must stand around the centre of mass"):
        Simulation(Scene.from_dict(scene(front=3.0, rear=2.0)))
