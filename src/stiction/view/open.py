"""Opening what is to be viewed: a scene, a recording, or a world that somebody has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from stiction.errors import InvalidInputError
from stiction.scene import Simulation, load
from stiction.view.playback import Playback
from stiction.view.session import LiveSession
from stiction.world import World

ENDLESS = 1e6
"""s that a scene in a live view goes on for: nobody watches for longer."""
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
    from stiction.record.hdf5 import load_frames

    if overrides:
        raise InvalidInputError(f"--set must be left out for a recording, got {overrides[0]!r}.")
    return Playback(load_frames(path))


def open_scene(name_or_path: str, overrides: Sequence[str] = ()) -> LiveSession:
    """A scene as a session that goes on beyond the scene's end; a reset builds it anew.

    Raises:
        InvalidInputError: see :func:`stiction.scene.load`.
    """
    load(name_or_path, overrides)  # so that a duration that is not allowed is told before it is replaced
    scene = load(name_or_path, [*overrides, f"duration={ENDLESS:g}"])

    def build() -> tuple[World, Callable[[int], None]]:
        simulation = Simulation(scene)
        return simulation.world, simulation.advance

    world, advance = build()
    return LiveSession(world, scene.title, advance=advance, restart=build)
