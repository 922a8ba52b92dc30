"""Opening what is to be viewed: a scene, a recording, or a world that somebody has."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from stiction.errors import InvalidInputError, SimulationError
from stiction.record.frames import Frames
from stiction.record.recorder import Recorder
from stiction.scene import Scene, Simulation, load
from stiction.view.playback import Playback
from stiction.view.session import LiveSession
from stiction.world import World

ENDLESS = 1e6
"""s that a scene in a live view goes on for: nobody watches for longer."""
PREVIEW_FRAMES = 24
PREVIEW_SECONDS = 1.5
"""s of wall time that looking ahead may take, kernels that have to be loaded aside."""
RECORDINGS = (".h5", ".hdf5")


def is_recording(what: str) -> bool:
    """Whether a text means a recording: a file that is no scene, or a name that ends like one."""
    path = Path(what)
    return path.suffix.lower() in RECORDINGS or (path.is_file() and path.suffix.lower() != ".toml")


def open_recording(path: Path, overrides: Sequence[str] | None = None) -> Playback:
    """A recording as a session.

    Raises:
        InvalidInputError: there is no such file, it is no recording, or values of a scene are to be changed in it.
    """
    from stiction.record.recording import Recording
    from stiction.view.show import playback_of

    if overrides:
        raise InvalidInputError(f"--set must be left out for a recording, got {overrides[0]!r}.")
    with Recording.open(path) as recording:
        return playback_of(recording)


def open_scene(name_or_path: str, overrides: Sequence[str] = ()) -> LiveSession:
    """A scene as a session that goes on beyond the scene's end; a reset builds it anew.

    Raises:
        InvalidInputError: see :func:`stiction.scene.load`.
    """
    preview = _preview(load(name_or_path, overrides))
    scene = load(name_or_path, [*overrides, f"duration={ENDLESS:g}"])

    def build() -> tuple[World, Callable[[int], None]]:
        simulation = Simulation(scene)
        return simulation.world, simulation.advance

    world, advance = build()
    return LiveSession(world, scene.title, advance=advance, restart=build, preview=preview)


def _preview(scene: Scene) -> Frames:
    """Some frames of a scene from its beginning to its end, or as far as it comes in a short time."""
    simulation = Simulation(scene)
    recorder = Recorder(simulation.world, scene.title)
    recorder.capture()
    stride = max(1, simulation.total_steps // PREVIEW_FRAMES)
    try:
        simulation.advance(1)  # loads the kernels, too
        recorder.capture(force=True)
        began = time.perf_counter()
        while not simulation.done and time.perf_counter() - began < PREVIEW_SECONDS:
            simulation.advance(stride)
            recorder.capture(force=True)
    except SimulationError:
        pass  # it will be told when the world that is shown comes to it
    return recorder.frames()
