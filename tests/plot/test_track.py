"""Tracks: the same whether a world is watched, a simulation, or a recording is read."""

from __future__ import annotations

import doctest
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError, plot
from stiction.plot import kinds, track
from stiction.plot.track import Observer, from_recording, observe, thinned
from stiction.record.hdf5 import RecordingWriter
from stiction.record.run import run
from stiction.scene import Simulation, load


def crate_world() -> st.World:
    world = st.World(dt=0.01, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete", name="floor")
    world.add(st.Box((1, 1, 1)), material="wood", mass=5.0, position=(0, 0, 0.5), velocity=(1, 0, 0), name="crate")
    return world


@pytest.mark.parametrize("module", [track, plot])
def test_the_examples_give_what_they_show(module: object) -> None:
    failed, tried = doctest.testmod(module)  # type: ignore[arg-type]  # a module
    assert failed == 0 and tried > 0


def test_a_watched_world_keeps_every_so_many_steps_and_the_last_one() -> None:
    world = crate_world()
    seen: list[tuple[int, int]] = []
    watched = observe(world, 0.11, title="a crate", every=3, on_progress=lambda *done: seen.append(done))
    np.testing.assert_allclose(watched.frames.times, [0.0, 0.03, 0.06, 0.09, 0.11])
    assert watched.frames.title == "a crate"
    assert seen == [(3, 11), (6, 11), (9, 11), (11, 11)]
    assert watched.energies is not None
    np.testing.assert_allclose(watched.energies[-1], world.energy())
    assert watched.energies[0, 0] == pytest.approx(2.5)
    assert watched.pairs("wood", "concrete").static == 0.5
    np.testing.assert_array_equal(watched.gravity, world.gravity)


def test_a_simulation_is_watched_to_its_end_or_for_some_time() -> None:
    whole = observe(Simulation(load("pull", ["duration=0.1"])))
    assert whole.frames.times[-1] == pytest.approx(0.1)
    assert whole.frames.title == "A crate is pulled harder and harder"
    part = observe(Simulation(load("pull")), 0.05)
    assert part.frames.times[-1] == pytest.approx(0.05)
    np.testing.assert_array_equal(part.frames.positions, whole.frames.positions[:11])


def test_what_cannot_be_watched_is_told() -> None:
    with pytest.raises(InvalidInputError, match="seconds must be given for a world"):
        observe(crate_world())
    with pytest.raises(InvalidInputError, match="watched must be a World or a Simulation, got str"):
        observe("ramp", 1.0)  # type: ignore[arg-type]  # the mistake under test
    with pytest.raises(InvalidInputError, match="seconds must be above 0 s"):
        observe(crate_world(), 0.0)


def test_a_recording_has_the_track_of_its_run(tmp_path: Path) -> None:
    simulation = Simulation(load("pull", ["duration=0.2", "world.gravity=[0,0,-5]"]))
    observer = Observer(simulation.world, simulation.scene.title, every=4)
    with RecordingWriter(tmp_path / "run.h5", simulation, 4, contacts=True, precision="full") as writer:
        run(simulation, recorder=observer, writer=writer)
    live, read = observer.track(), from_recording(tmp_path / "run.h5")
    np.testing.assert_array_equal(read.frames.positions, live.frames.positions)
    np.testing.assert_array_equal(read.frames.contacts, live.frames.contacts)
    np.testing.assert_array_equal(read.gravity, [0, 0, -5])
    assert read.pairs("wood", "concrete") == live.pairs("wood", "concrete")
    np.testing.assert_array_equal(read.energies, live.energies)
    with pytest.raises(InvalidInputError, match="must hold energies for a figure of kind 'energy'"):
        kinds.draw("energy", replace(read, energies=None))


def test_thinning_keeps_the_last_frame_and_each_frames_contacts() -> None:
    frames = observe(crate_world(), 0.1).frames
    thin = thinned(frames, 4)
    np.testing.assert_allclose(thin.times, [0.0, 0.04, 0.08, 0.1])
    for number, k in enumerate((0, 4, 8, 10)):
        np.testing.assert_array_equal(thin.contacts_of(number), frames.contacts_of(k))
        np.testing.assert_array_equal(thin.positions[number], frames.positions[k])
    np.testing.assert_array_equal(thinned(frames, 1).contacts, frames.contacts)
