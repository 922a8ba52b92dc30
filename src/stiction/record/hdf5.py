"""Recordings in HDF5, the short way: all frames of one in memory, and the simulation that made it."""

from __future__ import annotations

from pathlib import Path

from stiction.errors import InvalidInputError
from stiction.record import layout
from stiction.record.frames import Frames
from stiction.record.recorder import WIDTHS
from stiction.record.recording import UNREADABLE, Recording
from stiction.record.writer import RecordingWriter, outcome_of
from stiction.scene import Scene, Simulation
from stiction.snapshot import put

__all__ = ["RecordingWriter", "load_frames", "outcome_of", "restore"]


def load_frames(path: str | Path) -> Frames:
    """The frames of a recording; ``meta`` holds its scene, versions and outcome.

    Raises:
        InvalidInputError: there is no such file, or it is no recording.
    """
    with Recording.open(path) as recording:
        return recording.frames()


def restore(path: str | Path) -> Simulation:
    """The simulation of a recording of a scene, back at its beginning: the same scene, and the same state to the last
    bit.

    With the version of stiction that made the recording, on the same kind of machine, it runs as it ran then.

    Raises:
        InvalidInputError: there is no such file, it is no recording of a scene, or the scene's bodies are not those
            recorded.
    """
    with Recording.open(path) as recording:
        if recording.scene is None:
            raise InvalidInputError(
                f"recording {str(path)!r} has no scene, for it is of a world made in Python; Recording.world() gives it."
            )
        simulation = Simulation(Scene.from_dict(recording.scene, str(recording.metadata["scene_name"])))
        world = simulation.world
        if [body.name for body in world] != [body.name for body in recording.bodies[: len(world)]]:
            raise _other_bodies(path)
        if recording.format_version > 1:
            put(world, recording.snapshot(0))
            return simulation
        try:
            initial = {key: recording._file[f"initial/{key}"][:] for key in WIDTHS}
        except UNREADABLE as error:
            raise layout.damaged(path, error) from None
        if any(initial[key].shape != (len(world), width) for key, width in WIDTHS.items()):
            raise _other_bodies(path)
        for key, values in initial.items():
            getattr(world, key)[:] = values
    return simulation


def _other_bodies(path: str | Path) -> InvalidInputError:
    return InvalidInputError(f"recording {str(path)!r} holds other bodies than its scene, so it cannot be restored.")
