"""Sessions: time, buttons, sliders and pulling, without any browser."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import stiction as st
from stiction.errors import InvalidInputError, NotYetError, SimulationError
from stiction.motion import Motion
from stiction.record.recorder import Recorder
from stiction.view.grab import MOST_WEIGHTS, Grab
from stiction.view.open import is_recording, open_recording
from stiction.view.overlays import patch_outlines
from stiction.view.playback import Playback
from stiction.view.session import MOST_BEHIND, LiveSession


class Clock:
    """Wall time that goes by only where a test says so."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def crate_world(**settings: object) -> st.World:
    world = st.World(**settings)  # type: ignore[arg-type]  # whatever the test wants
    world.materials.set_pair("wood", "concrete", static=0.5, dynamic=0.3)
    world.add(st.Plane(), static=True, material="concrete", name="floor")
    world.add(st.Box((1, 1, 1)), material="wood", mass=10.0, position=(0, 0, 0.5), name="crate")
    return world


@pytest.fixture
def session() -> LiveSession:
    return LiveSession(crate_world(), clock=Clock())


# --- time -------------------------------------------------------------------------------------------------------------


def test_nothing_moves_until_it_plays(session: LiveSession) -> None:
    assert not session.tick(1.0)
    assert session.world.steps == 0


@pytest.mark.parametrize("speed", [0.25, 1.0, 2.0])
def test_time_runs_as_fast_as_asked_for(session: LiveSession, speed: float) -> None:
    session.playing = True
    session.speed = speed
    for _ in range(60):
        session.tick(1 / 30)
    assert session.world.time == pytest.approx(2.0 * speed, abs=session.world.dt)


def test_step_pauses_and_takes_one(session: LiveSession) -> None:
    session.playing = True
    session.step()
    session.step()
    assert session.world.steps == 2
    assert not session.playing


def test_a_slow_world_falls_behind_and_never_catches_up_in_one_go() -> None:
    clock, taken = Clock(), []

    def slow(steps: int) -> None:
        taken.append(steps)
        world.step(steps)
        clock.now += 0.05 * steps

    world = crate_world()
    session = LiveSession(world, advance=slow, clock=clock)
    session.playing = True
    for _ in range(100):
        session.tick(1 / 30)
    # 100 ticks of 1/30 s would be 200 steps; at 0.05 s each there is time for one a tick
    assert sum(taken) == 100
    assert session._due <= max(1.0, MOST_BEHIND / world.dt)


def test_many_small_steps_are_taken_in_few_calls() -> None:
    calls = []

    def advance(steps: int) -> None:
        calls.append(steps)
        world.step(steps)

    world = crate_world(dt=1e-4)
    session = LiveSession(world, advance=advance, clock=Clock())
    session.playing = True
    for _ in range(30):
        session.tick(1 / 30)
    assert world.steps == pytest.approx(10_000, abs=1)
    assert len(calls) < 1500


def test_reset_puts_bodies_back_and_keeps_what_was_set(session: LiveSession) -> None:
    session.set_gravity(9.81, math.radians(40.0), 0.0)
    session.playing = True
    for _ in range(30):
        session.tick(1 / 30)
    assert session.world["crate"].position[0] > 0.1
    session.reset()
    assert session.world["crate"].position == pytest.approx([0, 0, 0.5])
    assert session.world["crate"].velocity == pytest.approx([0, 0, 0])
    assert session.gravity[1] == pytest.approx(math.radians(40.0))
    assert not session.chart


def test_reset_of_a_scene_builds_a_new_world_with_what_was_set() -> None:
    def build() -> tuple[st.World, object]:
        world = crate_world()
        return world, world.step

    world, advance = build()
    session = LiveSession(world, advance=advance, restart=build)  # type: ignore[arg-type]  # a step is an advance
    session.set_pair("wood", "concrete", static=0.2, dynamic=0.1)
    session.step()
    session.reset()
    assert session.world is not world
    assert session.world.steps == 0
    assert session.world.materials.pair("wood", "concrete").static == 0.2


def test_a_world_that_blows_up_pauses_and_says_why(session: LiveSession) -> None:
    def fails(steps: int) -> None:
        raise SimulationError("the state is no longer finite.", step=1, body="crate", state={})

    session._advance = fails
    session.playing = True
    session.tick(1 / 30)
    assert not session.playing
    assert session.trouble == "the state is no longer finite."


def test_speed_must_be_positive(session: LiveSession) -> None:
    with pytest.raises(InvalidInputError, match="speed must be"):
        session.speed = 0.0
    assert session.speed == 1.0


# --- what holds for the world -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("tilt_deg", "slides"), [(20.0, False), (35.0, True)])
def test_a_crate_slips_where_the_tilt_passes_the_angle_of_friction(
    session: LiveSession, tilt_deg: float, slides: bool
) -> None:
    # mu_s = 0.5: the angle of friction is 26.6 degrees
    session.world.run(2.0)  # asleep by now, so that the tilt has to wake it
    session.set_gravity(9.81, math.radians(tilt_deg), math.radians(90.0))
    session.world.run(1.0)
    assert (session.world["crate"].position[1] > 0.05) == slides
    assert session.frame().motion[1] == (Motion.SLIDING if slides else Motion.STICKING)


def test_less_friction_wakes_a_crate_that_sleeps_on_a_slope(session: LiveSession) -> None:
    session.set_gravity(9.81, math.radians(20.0), 0.0)
    session.world.run(3.0)
    assert session.asleep().tolist() == [False, True]
    session.set_pair("wood", "concrete", static=0.1, dynamic=0.1)
    session.world.run(1.0)
    # a = g (sin 20 - 0.1 cos 20)
    assert session.world["crate"].position[0] == pytest.approx(0.5 * 9.81 * (0.342 - 0.1 * 0.9397), rel=0.02)


def test_dynamic_friction_never_passes_static(session: LiveSession) -> None:
    session.set_pair("wood", "concrete", static=0.2, dynamic=0.4)
    pair = session.world.materials.pair("wood", "concrete")
    assert (pair.static, pair.dynamic) == (0.2, 0.2)


def test_pairs_are_those_that_have_touched(session: LiveSession) -> None:
    assert session.pairs == []
    session.step()
    session.frame()
    assert session.pairs == [("concrete", "wood")]


def test_bad_numbers_are_refused_and_change_nothing(session: LiveSession) -> None:
    before = session.world.gravity
    for act in (
        lambda: session.set_gravity(-1.0, 0.0, 0.0),
        lambda: session.set_gravity(math.nan, 0.0, 0.0),
        lambda: session.set_pair("wood", "concrete", static=-0.1, dynamic=0.0),
        lambda: session.set_solver("sofd"),
        lambda: session.pick(7),
    ):
        with pytest.raises(InvalidInputError):
            act()
    assert (session.world.gravity == before).all()
    assert session.world.solver == "soft"
    assert session.picked is None


def test_substeps_change_on_the_way(session: LiveSession) -> None:
    session.set_solver("soft", 3)
    assert session.world.substeps == 3
    session.world.step(5)
    assert abs(session.world.energy().residual) < 1e-9


def test_solver_changes_on_the_way_with_time_and_energy() -> None:
    world = crate_world()
    crate = world["crate"]
    crate.velocity = (3.0, 0.0, 0.0)
    world.step(12)
    before, energy, time = crate.position, world.energy(), world.time
    world.set_solver("micro")
    assert (world.solver, world.substeps, world.time) == ("micro", 1, time)
    assert (crate.position == before).all()
    assert world.energy().friction == energy.friction
    world.set_solver("soft")
    world.run(2.0)
    # v^2 / (2 mu_d g), whoever solved which part of it
    assert crate.position[0] == pytest.approx(9.0 / (2 * 0.3 * 9.81), rel=0.01)
    assert abs(world.energy().residual) < 1e-9


def test_a_solver_that_lacks_something_is_refused_and_the_world_goes_on() -> None:
    world = crate_world()
    world.add(st.Sphere(0.5), static=True, sensor=True, position=(0, 0, 5))
    with pytest.raises(NotYetError, match="sensors"):
        world.set_solver("micro")
    with pytest.raises(NotYetError, match="substeps"):
        world.set_solver("micro", substeps=2)
    assert world.solver == "soft"
    world.step()


# --- pulling ----------------------------------------------------------------------------------------------------------


def test_a_hand_takes_the_crate_to_where_the_pointer_is(session: LiveSession) -> None:
    # by its centre of mass, so that it does not swing
    session.seize(1, np.array([0.0, 0.0, 0.5]))
    session.drag(np.array([2.0, 0.0, 3.0]))
    session.playing = True
    for _ in range(150):
        session.tick(1 / 30)
    assert session.grab is not None
    # it hangs m g / k lower, with k = m (2 pi 2 Hz)^2, and the hand carries its weight
    assert session.grab.point(session.world) == pytest.approx([2.0, 0.0, 3.0 - 9.81 / (4.0 * math.pi) ** 2], abs=1e-3)
    assert session.grab.force == pytest.approx([0.0, 0.0, 10.0 * 9.81], abs=0.1)
    session.release()
    assert session.grab is None


def test_the_hand_has_a_limit(session: LiveSession) -> None:
    hand = Grab(session.world, 1, np.array([0.5, 0.0, 0.5]))
    hand.target = np.array([1e6, 0.0, 0.0])
    hand.pull(session.world)
    assert np.linalg.norm(hand.force) == pytest.approx(MOST_WEIGHTS * 10.0 * 9.81)


def test_fixed_bodies_cannot_be_pulled(session: LiveSession) -> None:
    session.seize(0, np.zeros(3))
    assert session.grab is None
    session.drag(np.ones(3))


# --- what there is to see ---------------------------------------------------------------------------------------------


def test_chart_shows_what_friction_does(session: LiveSession) -> None:
    session.world["crate"].velocity = (4.0, 0.0, 0.0)
    for _ in range(20):
        session.step()
        session.frame()
    newest = session.chart[-1]
    assert len(session.chart) == 20
    assert newest.friction == pytest.approx(0.3 * 10.0 * 9.81, rel=0.02)
    session.pick(1)
    assert not session.chart
    assert session.friction_force(session.frame(), session.world.dt) == pytest.approx(newest.friction, rel=1e-6)


def test_the_picked_contact_stays_with_its_corner(session: LiveSession) -> None:
    session.world["crate"].velocity = (2.0, 0.0, 0.0)
    session.step()
    session.pick(1, np.array([0.5, 0.5, 0.0]))
    for _ in range(10):
        session.step()
        row = session.picked_contact(session.frame().contacts)
        assert row is not None
        corner = session.world["crate"].position + np.array([0.5, 0.5, -0.5])
        assert row["point"] == pytest.approx(corner, abs=0.05)
    assert session.coefficients(0, 1) == (0.5, 0.3)


def test_patch_goes_around_the_face(session: LiveSession) -> None:
    session.step()
    outline = patch_outlines(session.frame().contacts)
    assert outline.shape == (4, 2, 3)
    assert np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1) == pytest.approx([1.0] * 4, abs=0.01)


def test_a_world_that_has_lost_bodies_says_so(session: LiveSession) -> None:
    session.world.remove(session.world["crate"])
    with pytest.raises(InvalidInputError, match="a view of 2 bodies"):
        session.frame()


# --- recordings -------------------------------------------------------------------------------------------------------


@pytest.fixture
def playback() -> Playback:
    world = crate_world()
    world["crate"].velocity = (2.0, 0.0, 0.0)
    recorder = Recorder(world, "a crate", every=2)
    recorder.capture()
    for _ in range(60):
        world.step()
        recorder.capture()
    return Playback(recorder.frames())


def test_a_recording_plays_in_real_time_and_stops(playback: Playback) -> None:
    assert (playback.begin, playback.end) == (0.0, pytest.approx(1.0))
    playback.play()
    playback.tick(0.5)
    assert playback.frame().time == pytest.approx(0.5)
    playback.tick(5.0)
    assert playback.time == playback.end
    assert not playback.playing
    playback.play()
    assert playback.time == playback.begin


def test_seek_finds_the_frame_of_a_time(playback: Playback) -> None:
    for time, expected in ((0.51, 0.5), (0.5, 0.5), (-3.0, 0.0), (9.0, 1.0)):
        playback.seek(time)
        assert playback.frame().time == pytest.approx(expected)
    with pytest.raises(InvalidInputError, match="time must be"):
        playback.seek(math.nan)


def test_steps_go_from_frame_to_frame(playback: Playback) -> None:
    playback.step()
    playback.step()
    assert playback.index == 2
    for _ in range(50):
        playback.step()
    assert playback.index == 30
    playback.reset()
    assert playback.index == 0


@pytest.mark.parametrize(
    ("what", "expected"), [("ramp", False), ("a/b.toml", False), ("run.h5", True), ("RUN.HDF5", True)]
)
def test_what_is_a_recording(what: str, expected: bool) -> None:
    assert is_recording(what) == expected


def test_the_chart_of_a_recording_shows_what_it_recorded_and_says_what_it_did_not(tmp_path: Path) -> None:
    world = crate_world()
    world["crate"].velocity = (3, 0, 0)
    with world.record(tmp_path / "run.h5"):
        world.run(0.5)
    playback = open_recording(tmp_path / "run.h5")
    playback.seek(playback.end)
    playback.frame()
    assert playback.chart[-1].kinetic == world.energy().kinetic
    assert playback.chart[-1].dissipated == world.energy().dissipated > 1.0
    assert "without contacts" in playback.note
