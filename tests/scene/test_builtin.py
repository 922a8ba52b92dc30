"""Every built-in scene does what its sentence says, twice alike, and once more from its recording."""

from __future__ import annotations

import functools
import math
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from stiction import IterationLimitWarning, Motion
from stiction.core.solve.micro import TOLERANCE
from stiction.record.frames import Frames
from stiction.record.hdf5 import RecordingWriter, load_frames, restore
from stiction.record.recorder import Recorder
from stiction.record.run import run
from stiction.scene import Simulation, builtin_names, builtin_text, load
from stiction.scene.placing import turned
from stiction.verify.setups import delay, rounding

G = 9.81
NAMES = [
    "ball", "billiards", "conveyor", "disc", "dominoes", "heap", "pull", "push-and-release", "pyramid", "ramp",
    "stick-slip", "tippe-top", "vehicle",
]  # fmt: skip

_folder = tempfile.TemporaryDirectory(prefix="stiction-scenes-")


class Run(NamedTuple):
    simulation: Simulation
    frames: Frames
    path: Path
    state_hash: str


@contextmanager
def _limits_are_told_not_raised() -> Iterator[None]:
    """How often a solver hits its limit is the solver's affair: pyramid and dominoes do by intention."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", IterationLimitWarning)
        yield


@functools.cache
def recorded(name: str) -> Run:
    """The scene, run once, with every step in memory and every twentieth in a file."""
    simulation = Simulation(load(name))
    recorder = Recorder(simulation.world, name)
    path = Path(_folder.name) / f"{name}.h5"
    with _limits_are_told_not_raised(), RecordingWriter(path, simulation, 20, True, precision="full") as writer:
        run(simulation, recorder=recorder, writer=writer)
    return Run(simulation, recorder.frames(), path, simulation.world.state_hash())


def column(name: str) -> dict[str, int]:
    return {body.name: number for number, body in enumerate(recorded(name).frames.bodies)}


def traveled(name: str, body: str) -> NDArray[np.float64]:
    """(f,) distance of a body from where it began, m."""
    x = recorded(name).frames.positions[:, column(name)[body]]
    return np.linalg.norm(x - x[0], axis=1)


def movers(name: str) -> NDArray[np.int64]:
    return np.array([number for number, body in enumerate(recorded(name).frames.bodies) if not body.fixed])


# --- all of them ------------------------------------------------------------------------------------------------------


def test_the_built_in_scenes_are_these() -> None:
    assert builtin_names() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_says_in_one_sentence_what_must_happen(name: str) -> None:
    scene = load(name)
    assert scene.title
    assert scene.expect.endswith(".") and "\n" not in scene.expect
    assert builtin_text(name).startswith("#"), "a built-in scene begins by saying what it is about"


@pytest.mark.parametrize("name", NAMES)
def test_two_runs_end_in_the_same_state_to_the_last_bit(name: str) -> None:
    again = Simulation(load(name))
    with _limits_are_told_not_raised():
        while not again.done:  # cut into other pieces than the first run, which went step by step
            again.advance(97)
    assert again.world.state_hash() == recorded(name).state_hash


@pytest.mark.parametrize("name", NAMES)
def test_a_recording_restores_the_beginning_to_the_last_bit(name: str) -> None:
    restored = restore(recorded(name).path)
    assert restored.step_index == 0
    assert restored.world.state_hash() == Simulation(load(name)).world.state_hash()
    with _limits_are_told_not_raised():
        restored.advance(restored.total_steps)
    assert restored.done
    assert restored.world.state_hash() == recorded(name).state_hash


@pytest.mark.parametrize("name", NAMES)
def test_the_file_holds_the_frames_that_memory_holds(name: str) -> None:
    memory, file = recorded(name).frames, load_frames(recorded(name).path)
    last = len(memory) - 1
    kept = [*range(0, last, 20), last]
    np.testing.assert_array_equal(file.times, memory.times[kept])
    np.testing.assert_array_equal(file.positions, memory.positions[kept])
    np.testing.assert_array_equal(file.motion, memory.motion[kept])
    for number, step in enumerate(kept):
        np.testing.assert_array_equal(file.contacts_of(number), memory.contacts_of(step))


@pytest.mark.parametrize("name", NAMES)
def test_the_ledger_of_energy_closes(name: str) -> None:
    energy = recorded(name).simulation.world.energy()
    scale = energy.initial + abs(energy.work) + energy.dissipated
    # to rounding where every step converges; a step that is cut off at its limit leaves a little more
    cut_off = any(recorded(name).simulation.world.report().limit_hits)
    assert abs(energy.residual) < (1e-7 if cut_off else 1e-10) * scale


# --- what must happen -------------------------------------------------------------------------------------------------


def test_on_the_ramp_five_crates_hold_and_four_slide_as_the_formula_says() -> None:
    world, frames = recorded("ramp").simulation.world, recorded("ramp").frames
    angle = math.radians(30)
    rows = {(a, b): pair for a, b, pair in world.materials.pairs() if a != "default"}
    assert len(rows) == 9
    holding = []
    for body in world:
        if body.mobility == "static":
            continue
        a, _, b = body.name.partition(" on ")
        assert body.material == a and world[f"lane of {body.name}"].material == b
        pair = rows.pop((a, b) if (a, b) in rows else (b, a))
        if pair.static > math.tan(angle):
            holding.append(body.name)
            assert traveled("ramp", body.name).max() < 1e-5
            assert frames.motion[-1, body.index] == Motion.STICKING
        else:
            acceleration = G * (math.sin(angle) - pair.dynamic * math.cos(angle))
            expected = 0.5 * acceleration * frames.times**2
            np.testing.assert_allclose(traveled("ramp", body.name), expected, rtol=1e-4, atol=1e-4)
            np.testing.assert_allclose(np.linalg.norm(body.velocity), acceleration * frames.times[-1], rtol=1e-4)
            assert frames.motion[-1, body.index] == Motion.SLIDING
    assert rows == {}, "each row of the table has its crate"
    assert len(holding) == 5


def test_push_and_release_keeps_static_and_dynamic_friction_apart() -> None:
    frames = recorded("push-and-release").frames
    of = column("push-and-release")
    mass, end = 100.0, 1.5
    dynamic = 0.4 * mass * G

    resting = of["resting, 440 N"]
    assert traveled("push-and-release", "resting, 440 N").max() < TOLERANCE * frames.times[-1]
    assert set(frames.motion[1:, resting]) == {Motion.STICKING}

    for name, v0, force in (("moving, 440 N", 2.0, 440.0), ("resting, 540 N", 0.0, 540.0)):
        acceleration = (force - dynamic) / mass
        v1 = v0 + acceleration * end
        x1 = v0 * end + 0.5 * acceleration * end**2
        stopping = v1**2 / (2 * 0.4 * G)
        pushed = frames.times <= end
        t = frames.times[pushed]
        x = frames.positions[:, of[name], 0]
        # a crate that has to let go first does so a few substeps late
        late = acceleration * delay("soft", frames.dt) if v0 == 0.0 else 0.0
        behind = v0 * t + 0.5 * acceleration * t**2 - x[pushed]
        assert behind.min() > -4e-4 and (behind < late * t + 4e-4).all()
        assert abs(x[-1] - (x1 + stopping)) < 2e-4 * x[-1] + late * (end + v1 / (0.4 * G))
        at_rest = frames.times > end + v1 / (0.4 * G) + 4 * frames.dt
        assert np.abs(frames.velocities[at_rest, of[name]]).max() < 1e-5
        assert set(frames.motion[at_rest, of[name]]) == {Motion.STICKING}
    assert frames.velocities[np.argmin(np.abs(frames.times - end)), of["moving, 440 N"], 0] > 2.0, "it has sped up"


def test_the_ball_rolls_on_with_five_sevenths_of_its_speed() -> None:
    frames = recorded("ball").frames
    ball = column("ball")["ball"]
    speed, motion = frames.velocities[:, ball, 0], frames.motion[:, ball]
    slide = 2 * 3.5 / (7 * 0.1 * G)
    dt = frames.dt
    assert set(motion[(frames.times > 0) & (frames.times < slide - dt)]) == {Motion.SLIDING}
    rolling = frames.times > slide + dt
    assert set(motion[rolling]) == {Motion.ROLLING}
    # what single precision makes of a speed of 3.5 m/s while it slides
    rounded = rounding("soft", 3.5, slide, dt) / 2.5
    np.testing.assert_allclose(speed[rolling], 2.5, rtol=rounded)
    np.testing.assert_allclose(frames.angular_velocities[rolling, ball, 1], 2.5 / 0.25, rtol=rounded)
    where = slide * (3.5 + 2.5) / 2 + 2.5 * (frames.times[-1] - slide)
    np.testing.assert_allclose(traveled("ball", "ball")[-1], where, rtol=1e-4)


def test_the_break_scatters_the_rack_and_rolling_resistance_slows_the_balls() -> None:
    frames = recorded("billiards").frames
    balls = movers("billiards")
    assert len(balls) == 16
    x = frames.positions[:, balls]
    radius = 0.028575
    assert np.abs(x[..., 0]).max() <= 1.27 - radius + 1e-3
    assert np.abs(x[..., 1]).max() <= 0.635 - radius + 1e-3
    assert x[..., 2].min() > radius - 1e-3 and x[..., 2].max() < 0.1

    rack = x[:, 1:]
    spread = np.linalg.norm(rack - rack.mean(axis=1, keepdims=True), axis=2).mean(axis=1)
    assert spread[-1] > 4 * spread[0]
    assert traveled("billiards", "cue ball").max() > 1.0

    # a ball that touched the cloth alone, and rolled, before and after a step
    frame_of_row = np.repeat(np.arange(len(frames)), np.diff(frames.contact_offsets))
    slowed = []
    for ball in balls:
        mine = (frames.contacts["body_a"] == ball) | (frames.contacts["body_b"] == ball)
        alone = np.bincount(frame_of_row[mine], minlength=len(frames)) == 1
        rolls = alone & (frames.motion[:, ball] == Motion.ROLLING)
        speed = np.linalg.norm(frames.velocities[:, ball], axis=1)
        both = np.flatnonzero(rolls[1:] & rolls[:-1])
        slowed.extend((speed[both] - speed[both + 1]) / frames.dt)
    assert len(slowed) > 10_000
    expected = 5 / 7 * 0.00028575 / radius * G
    # single precision rounds a speed of 1 m/s by 6e-8 m/s in each substep
    np.testing.assert_allclose(np.percentile(slowed, [1, 99]), expected, rtol=5e-3)
    np.testing.assert_allclose(np.median(slowed), expected, rtol=5e-4)


def test_the_pyramid_stands() -> None:
    frames = recorded("pyramid").frames
    boxes = movers("pyramid")
    assert len(boxes) == 55
    moved = np.linalg.norm(frames.positions - frames.positions[0], axis=2)[:, boxes]
    turned = 2 * np.degrees(np.arccos(np.clip(np.abs(frames.orientations[:, boxes, 0]), 0, 1)))
    assert moved.max() < 0.003, "the boxes below give way a little under those above"
    assert turned.max() < 0.1
    # each box still stands on two others or on the floor
    last = frames.contacts_of(len(frames) - 1)
    for box in boxes:
        below = last["body_a"][(last["body_b"] == box) & (last["normal"][:, 2] > 0.9)]
        assert len(set(below)) == (1 if frames.positions[0, box, 2] < 0.3 else 2)


def test_the_dominoes_fall_one_after_the_other() -> None:
    frames = recorded("dominoes").frames
    dominoes = movers("dominoes")
    assert len(dominoes) == 20
    q = frames.orientations[:, dominoes]
    tilt = np.degrees(np.arccos(1 - 2 * (q[..., 1] ** 2 + q[..., 2] ** 2)))
    falls = frames.times[np.argmax(tilt > 30, axis=0)]
    gaps = np.diff(falls)
    assert (gaps > 0).all()
    # once the wave has formed it travels at a constant speed; single gaps scatter by up to 15 % at any time step, 1 ms
    # too, for dominoes that lean on the next one rattle
    np.testing.assert_allclose(gaps[6:-3], 0.0775, atol=0.15 * 0.0775 + frames.dt)
    np.testing.assert_allclose(gaps[6:-3].mean(), 0.0775, atol=0.002)
    assert tilt[-1, -1] > 89.0
    assert (tilt[-1, :-1] > 60).all() and (tilt[-1, :-1] < 75).all()
    assert np.abs(frames.velocities[-1]).max() < 0.01, "and then all is quiet"


def test_on_the_conveyor_each_crate_reaches_the_belts_speed_after_v_over_mu_g() -> None:
    world, frames = recorded("conveyor").simulation.world, recorded("conveyor").frames
    belt = 1.5
    for crate in movers("conveyor"):
        name = frames.bodies[crate].name
        mu = world.materials.pair("steel", frames.bodies[crate].material).dynamic
        speed, motion = frames.velocities[:, crate, 0], frames.motion[:, crate]
        reached = belt / (mu * G)
        before, after = frames.times < reached - frames.dt, frames.times > reached + frames.dt
        np.testing.assert_allclose(speed[before], mu * G * frames.times[before], rtol=2e-4, atol=1e-5)
        np.testing.assert_allclose(speed[after], belt, rtol=1e-5)
        assert set(motion[before][1:]) == {Motion.SLIDING}
        assert set(motion[after]) == {Motion.STICKING}
        slipped_back = belt**2 / (2 * mu * G)
        np.testing.assert_allclose(traveled("conveyor", name)[-1], belt * frames.times[-1] - slipped_back, atol=1e-3)


def test_the_pulled_crate_stays_to_the_static_limit_and_slides_with_dynamic_friction() -> None:
    frames = recorded("pull").frames
    crate = column("pull")["crate"]
    lets_go, end, mass, growth = 490.5 / 140.0, frames.times[-1], 100.0, 140.0
    before = frames.times <= lets_go
    assert traveled("pull", "crate")[before].max() < 1e-5
    assert set(frames.motion[before, crate][1:]) == {Motion.STICKING}
    late = delay("soft", frames.dt) + frames.dt
    assert set(frames.motion[frames.times > lets_go + late, crate]) == {Motion.SLIDING}
    # m v = integral of growth t - mu_d m g since then; begun late, it misses the first of it
    slid = end - lets_go
    speed = (0.5 * growth * (end**2 - lets_go**2) - 0.4 * mass * G * slid) / mass
    assert 0.0 < speed - frames.velocities[-1, crate, 0] < (490.5 - 392.4) / mass * late + 1e-4


def test_blocks_on_the_belt_creak_with_the_periods_of_their_springs() -> None:
    frames = recorded("stick-slip").frames
    of, late = column("stick-slip"), frames.dt + delay("soft", frames.dt)
    for name, stiffness in (("soft spring", 25.0), ("medium spring", 50.0), ("stiff spring", 100.0)):
        w, gap, belt = math.sqrt(stiffness), 0.3 * G / stiffness, 0.1
        period = 2 * gap / belt + (2 * math.pi - 2 * math.atan(gap * w / belt)) / w
        slides = frames.motion[:, of[name]] == Motion.SLIDING
        begins = frames.times[1:][slides[1:] & ~slides[:-1]]
        assert len(begins) == math.floor((frames.times[-1] - 0.6 * G / stiffness / belt) / period) + 1
        np.testing.assert_allclose(np.diff(begins), period, atol=2 * late)
        assert f"{period:.2f} s ({stiffness:g} N/m)" in recorded("stick-slip").simulation.scene.expect
    # with one coefficient nothing jumps: it swings about mu m g / k by V / w
    x = frames.positions[frames.times > 3.0, of["one coefficient"], 0]
    np.testing.assert_allclose([x.max(), x.min()], 0.3 * G / 25.0 + np.array([1, -1]) * 0.1 / 5.0, atol=0.1 * late)


def test_the_discs_end_sliding_and_spinning_at_once() -> None:
    frames = recorded("disc").frames
    for name, first in (("slow", 4 / 3), ("middling", 2 / 3), ("fast", 1 / 3)):
        body = column("disc")[name]
        v = np.linalg.norm(frames.velocities[:, body], axis=1)
        turning = 0.5 * np.linalg.norm(frames.angular_velocities[:, body], axis=1)
        assert v[0] / turning[0] == pytest.approx(first)
        ends = [int(np.argmax(speed < 1e-4 * speed[0])) for speed in (v, turning)]
        assert min(ends) > 0 and abs(ends[0] - ends[1]) <= 1
        last = int(np.argmax(v + turning < 0.01 * (v[0] + turning[0])))
        assert abs(v[last] / turning[last] - 0.653) < 0.2 * abs(first - 0.653) + 0.005


def test_the_heap_comes_to_rest_and_floor_walls_and_panes_carry_it() -> None:
    simulation, frames = recorded("heap").simulation, recorded("heap").frames
    bodies = movers("heap")
    assert len(bodies) == 60
    assert np.linalg.norm(frames.velocities[-1, bodies], axis=1).max() < 0.02
    x = frames.positions[-1, bodies]
    assert np.abs(x[:, 0]).max() < 1.0 and np.abs(x[:, 1]).max() < 0.15 and x[:, 2].min() > 0.0
    rows = simulation.world.contacts()
    fixed = [body.index for body in simulation.world if body.mobility == "static"]
    held = rows[np.isin(rows["body_a"], fixed)]
    force = np.sum(held["normal"] * held["normal_impulse"][:, None] + held["friction_impulse"], axis=0) / frames.dt
    weight = sum(simulation.world.bodies[body].mass for body in bodies) * G
    np.testing.assert_allclose(force, [0.0, 0.0, weight], atol=0.01 * weight)
    assert set(bodies) <= set(rows["body_a"]) | set(rows["body_b"])


def test_the_tippe_top_turns_over_and_keeps_jelletts_number() -> None:
    frames = recorded("tippe-top").frames
    top = column("tippe-top")["top"]
    r, e, spin = 0.02, 0.003, 126.5
    w, q = frames.angular_velocities[:, top], frames.orientations[:, top]
    axis = turned(q, np.broadcast_to((0.0, 0.0, 1.0), (len(q), 3)))
    np.testing.assert_allclose(w[0], spin * axis[0], rtol=1e-3)
    assert axis[0, 2] == pytest.approx(math.cos(math.radians(11.5)), abs=1e-6)
    assert axis[frames.times >= 2.0, 2].max() < -0.95
    # from the centre of mass to the contact: e axis - r z; its inertia is that of a ball
    jellett = np.sum(w * (e * axis - (0.0, 0.0, r)), axis=1)
    np.testing.assert_allclose(jellett, jellett[0], rtol=2e-3)
    assert w[-1, 2] == pytest.approx(spin * (r * axis[0, 2] - e) / (r + e), rel=0.005)


def test_with_the_left_wheels_on_ice_a_car_turns_to_the_right_as_it_brakes() -> None:
    frames = recorded("vehicle").frames
    first, second = (column("vehicle")[name] for name in ("on asphalt", "half on ice"))
    # the brakes come on between 0.5 s and 0.6 s, as straight as the controls say, so as if at 0.55 s
    deceleration = 2800.0 / (0.3 * (1200.0 + 4 * 0.5 * 20.0))
    x, v, q = frames.positions, frames.velocities, frames.orientations
    assert abs(x[-1, first, 0] - 20.0 * 0.55 - 20.0**2 / (2 * deceleration)) < 0.01 * x[-1, first, 0]
    assert np.abs(x[:, first, 1] + 6.0).max() < 1e-3 and np.abs(q[:, first, 3]).max() < 1e-4
    stands = np.argmax(v[:, first, 0] < 0.01)
    assert 0 < stands < len(frames) - 1 and v[stands, second, 0] > 3.0
    yaw = np.unwrap(2.0 * np.arctan2(q[:, second, 3], q[:, second, 0]))
    braking = frames.times > 0.7
    assert yaw[-1] < -1.0 and (np.diff(yaw[braking]) < 0.0).all()
    wheel = column("vehicle")["on asphalt wheel 0"]
    assert np.abs(x[:, wheel, :2] - x[:, first, :2] - (1.3, 0.75)).max() < 0.02
