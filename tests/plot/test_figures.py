"""What figures show is what the laws say: limits, ratios, loops, ledgers and weights."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex

import stiction as st
from stiction import Motion
from stiction.plot import Track, cone, dots, draw, energy, hodograph, network, observe, phase, raster
from stiction.plot.points import contact_points, faces
from stiction.plot.pull import contact_forces, pulling_force
from stiction.plot.run import body_forces
from stiction.plot.track import thinned
from stiction.scene import Simulation
from stiction.scene import load as load_scene
from stiction.verify.setups import delay

G = 9.81


@functools.cache
def track(scene: str, *overrides: str, every: int = 1) -> Track:
    return observe(Simulation(load_scene(scene, overrides)), every=every)


def crate_of(frames: Any) -> int:
    return [body.name for body in frames.bodies].index("crate")


# --- friction against pull --------------------------------------------------------------------------------------------


def test_the_pull_of_newtons_law_is_the_force_that_the_scene_says() -> None:
    run = track("pull")
    pull = pulling_force(run, crate_of(run.frames))
    said = 140.0 * (run.frames.times - 0.5 * run.frames.dt)
    assert pull[0] == 0.0
    np.testing.assert_allclose(pull[1:], said[1:], atol=0.1)


def test_friction_follows_the_pull_to_the_static_limit_and_drops_to_the_dynamic_one() -> None:
    run = track("pull")
    crate = crate_of(run.frames)
    pull, friction = pulling_force(run, crate), body_forces(run.frames, run.pairs, crate).friction
    static, dynamic = 0.5 * 100.0 * G, 0.4 * 100.0 * G
    held = run.frames.motion[:, crate] == Motion.STICKING
    held[0] = False
    np.testing.assert_allclose(friction[held], pull[held], atol=0.1)
    # the last step that holds comes within a step and the time that letting go takes of the limit
    assert static - 140.0 * 2 * run.frames.dt < friction.max() < static * (1 + 1e-4)
    late = run.frames.times > static / 140.0 + delay("soft", run.frames.dt) + 2 * run.frames.dt
    np.testing.assert_allclose(friction[late], dynamic, rtol=1e-4)


def test_the_figure_draws_both_limits_where_they_are() -> None:
    (axes,) = draw("pull", track("pull")).axes
    levels = [np.asarray(line.get_ydata()) for line in axes.get_lines() if len(line.get_xdata()) == 2]
    flat = sorted(float(y[0]) for y in levels if y[0] == y[1])
    assert flat == pytest.approx([0.4 * 100 * G, 0.5 * 100 * G], rel=1e-3)
    notes = " ".join(text.get_text() for text in axes.texts)
    assert "490.5" in notes and "392.4" in notes


def test_gravity_on_a_slope_pulls_too() -> None:
    run = track("ramp", "duration=0.1")
    number = [body.name for body in run.frames.bodies].index("rubber on concrete")
    body = run.frames.bodies[number]
    expected = body.mass * G * math.sin(math.radians(30))
    np.testing.assert_allclose(pulling_force(run, number)[2:], expected, rtol=1e-3)


def test_a_frame_of_several_steps_in_which_the_crate_lets_go_tells_no_pull() -> None:
    run = track("pull", every=3)
    crate = crate_of(run.frames)
    pull, motion = pulling_force(run, crate), run.frames.motion[:, crate]
    begins = int(np.argmax(motion == Motion.SLIDING))
    assert np.isnan(pull[begins])
    said = 140.0 * (run.frames.times - 1.5 * run.frames.dt)
    np.testing.assert_allclose(pull[begins + 1 : -1], said[begins + 1 : -1], atol=0.2)


def test_contact_forces_carry_the_weight() -> None:
    run = track("pull")
    force, normal = contact_forces(run.frames, crate_of(run.frames))
    np.testing.assert_allclose(normal[5:, 2], 100.0 * G, rtol=1e-3)
    np.testing.assert_allclose(force[5:, 2], 100.0 * G, rtol=1e-3)


# --- cone and load ----------------------------------------------------------------------------------------------------


def test_what_slides_lies_on_the_dynamic_circle_and_nothing_lies_outside() -> None:
    run = track("push-and-release")
    points = dots.chosen_points(run, None)
    share = np.linalg.norm(cone.shares(points), axis=1)
    assert share.max() < cone.RIM
    slides = ~points.rows["sticking"]
    assert slides.sum() > 300
    assert np.median(share[slides]) == pytest.approx(0.8, rel=1e-3)
    figure = draw("cone", run)
    assert "none outside" in figure.axes[1].get_title(loc="left")


def test_an_impulse_outside_the_cone_is_counted() -> None:
    run = track("push-and-release")
    frames = run.frames
    before = frames.contacts["friction_impulse"].copy()
    try:
        k = int(frames.contact_offsets[50])
        frames.contacts["friction_impulse"][k] = 10.0 * frames.contacts["normal_impulse"][k] * np.array([1.0, 0, 0])
        assert " 1 outside" in draw("cone", run).axes[1].get_title(loc="left")
    finally:
        frames.contacts["friction_impulse"] = before


def test_limits_of_load_have_the_slopes_of_the_pair() -> None:
    (axes,) = draw("load", track("push-and-release")).axes
    slopes = sorted(float(y[1] / x[1]) for x, y in (line.get_data() for line in axes.get_lines()))
    assert slopes == pytest.approx([0.4, 0.5])


# --- hodograph --------------------------------------------------------------------------------------------------------


def test_a_disc_ends_at_the_ratio_of_farkas() -> None:
    assert hodograph.common_ratio() == pytest.approx(0.653, abs=5e-4)


def test_the_discs_of_the_scene_tend_to_it_from_both_sides() -> None:
    run = track("disc")
    names = [body.name for body in run.frames.bodies]
    for name, side in (("slow", 1.0), ("fast", -1.0)):
        v, turning = hodograph.speeds(run.frames, names.index(name))
        size = np.hypot(v, turning)
        alive = size > 0.01 * size[0]
        off = side * (v[alive] / turning[alive] - hodograph.common_ratio())
        assert (np.diff(off) < 1e-4).all(), "ever nearer"
        assert 0.0 < off[-1] < 0.1 * off[0] + 0.05
    notes = [text.get_text() for text in draw("hodograph", run).axes[1].texts]
    assert any("0.653" in note for note in notes)


def test_speeds_of_turning_are_those_of_the_rim_or_of_a_disc_of_that_inertia() -> None:
    world = st.World(gravity=(0, 0, 0))
    world.add(st.Sphere(0.5), angular_velocity=(0, 3, 4), velocity=(0, 2, 0))
    # turned by 45 degrees about x, so that it spins about its own z: I = m (x^2 + y^2) / 12
    turned = (math.cos(math.pi / 8), math.sin(math.pi / 8), 0, 0)
    spin = (0, -2 * math.sin(math.pi / 4), 2 * math.cos(math.pi / 4))
    world.add(st.Box((1.2, 0.4, 0.9)), position=(9, 0, 0), angular_velocity=spin, orientation=turned)
    frames = observe(world, 0.1).frames
    v, turning = hodograph.speeds(frames, 0)
    np.testing.assert_allclose([v[0], turning[0]], [2.0, 2.5])
    np.testing.assert_allclose(hodograph.speeds(frames, 1)[1], 2 * math.sqrt((1.2**2 + 0.4**2) / 6), rtol=1e-6)


# --- stick-slip -------------------------------------------------------------------------------------------------------


def test_the_raster_has_a_row_a_pair_in_the_order_of_first_touch() -> None:
    run = track("stick-slip", "duration=4")
    pairs, states = raster.states(run)
    names = [body.name for body in run.frames.bodies]
    assert [(names[a], names[b]) for a, b in pairs] == [("belt", name) for name in names[1:]]
    assert states.shape == (4, len(run.frames))
    for row, (_, block) in zip(states, pairs, strict=True):
        said = np.where(run.frames.motion[:, block] == Motion.SLIDING, raster.SLIPS, raster.HELD)
        np.testing.assert_array_equal(row[1:], said[1:])
    only, _ = raster.states(run, [2])
    assert only == [(0, 2)]


def test_the_phase_portrait_of_stick_slip_is_a_loop_of_the_amplitude_of_the_law() -> None:
    run = track("stick-slip", "duration=4")
    # D = (mu_s - mu_d) m g / k; the block swings back about the place where the spring pulls with mu_d m g
    for body, stiffness in ((1, 25.0), (2, 50.0), (3, 100.0)):
        place, speed = phase.along(run.frames, body)
        w, gap, v = math.sqrt(stiffness), 0.3 * G / stiffness, 0.1
        late = run.frames.dt + delay("soft", run.frames.dt)
        amplitude = math.hypot(gap, v / w)
        assert place.max() - 0.3 * G / stiffness == pytest.approx(amplitude, abs=v * late)
        assert -speed.min() == pytest.approx(amplitude * w, abs=2 * v * w * late + 1e-3)
        assert speed.max() == pytest.approx(v, abs=2e-3)


# --- energy -----------------------------------------------------------------------------------------------------------


def test_the_parts_of_the_ledger_add_up_to_what_was_put_in() -> None:
    run = track("conveyor", every=8)
    assert run.energies is not None
    layers, put_in = energy.parts(run.energies)
    np.testing.assert_allclose(np.sum(list(layers.values()), axis=0), put_in, atol=1e-9)
    # half of what a belt spends goes into motion, half into heat: 4 crates of 20 kg at 1.5 m/s
    assert put_in[-1] == pytest.approx(4 * 20.0 * 1.5**2, rel=2e-3)
    assert layers["friction"][-1] == pytest.approx(0.5 * put_in[-1], rel=2e-3)
    assert layers["potential"].min() == 0.0


def test_what_soft_contacts_give_back_is_shown_below_zero_and_said() -> None:
    run = track("pull", "duration=0.1")
    assert run.energies is not None
    # a body of 10 J whose contacts have given back 2 J, and took 1 J in the end
    ledgers = [st.Energy(10.0 - impacts, 0.0, 0.0, 0.0, impacts, 0.0, 0.0, 0.0, 10.0) for impacts in (0.0, -2.0, 1.0)]
    assert [ledger.given_back for ledger in ledgers] == [0.0, 2.0, 0.0]
    assert st.Energy(10.0, 0.0, 0.0, 0.0, -1e-12, 0.0, 0.0, 0.0, 10.0).given_back == 0.0, "that is rounding"
    times = np.array([0.0, 1.0, 2.0])
    frames = thinned(run.frames, len(run.frames))
    frames = replace(frames, times=times)
    (axes,) = draw("energy", replace(run, frames=frames, energies=np.array(ledgers))).axes
    assert "given back up to 2 J more than impacts took" in axes.get_title(loc="left")
    kinetic = next(area for area in axes.collections if to_hex(area.get_facecolor()[0]) == energy.LAYERS["kinetic"])
    (outline,) = kinetic.get_paths()
    at_one = outline.vertices[outline.vertices[:, 0] == 1.0, 1]
    assert (at_one.min(), at_one.max()) == (-2.0, 10.0)
    assert axes.get_ylim()[0] < -2.0


# --- contact network --------------------------------------------------------------------------------------------------


def test_links_carry_the_weight_from_body_to_body() -> None:
    world = st.World(dt=0.02, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete")
    for k in range(3):
        world.add(st.Box((0.5, 0.5, 0.2)), mass=10.0, material="wood", position=(0.01 * k, 0, 0.1 + 0.2 * k))
    run = observe(world, 1.0, every=10)
    found = {(a, b): (centre, force, share) for a, b, centre, force, share in network.links(run)}
    assert list(found) == [(0, 1), (1, 2), (2, 3)]
    for number, (centre, force, share) in enumerate(found.values()):
        assert force == pytest.approx((3 - number) * 10.0 * G, rel=1e-2)
        assert centre[2] == pytest.approx(0.2 * number, abs=1e-3)
        assert share < 0.05
    assert [pair[:2] for pair in network.links(run, ["box 3"])] == [(2, 3)]


def test_the_side_view_looks_across_the_longest_extent_and_has_gravity_down() -> None:
    world = st.World(gravity=(0, -5.0, 0))
    for z in (0.0, 3.0, 7.0):
        world.add(st.Sphere(0.1), position=(0, 0, z))
    (right, up), name = network.best_view(observe(world, 0.02).frames, world.gravity)
    np.testing.assert_allclose(up, [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(right, [0, 0, 1], atol=1e-6)
    assert name == "height"


def test_what_lies_flat_is_seen_from_above() -> None:
    world = st.World()
    world.add(st.Plane(), static=True)
    for x, y in ((0.0, 0.0), (0.0, 1.0), (3.0, 0.0), (3.0, 1.0)):
        world.add(st.Sphere(0.1), position=(x, y, 0.1))
    (right, other), name = network.best_view(observe(world, 0.02).frames, world.gravity)
    np.testing.assert_allclose([right, other], [[1, 0, 0], [0, 1, 0]], atol=1e-6)
    assert name == "depth"


def test_faces_of_a_run_keep_its_sums() -> None:
    run = track("pull")
    points = contact_points(run.frames, run.pairs)
    made = faces(points)
    for name in ("normal_impulse", "friction_impulse"):
        np.testing.assert_allclose(made.rows[name].sum(axis=0), points.rows[name].sum(axis=0), rtol=1e-12, atol=1e-12)
