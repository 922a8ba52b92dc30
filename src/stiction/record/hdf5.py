"""Recordings in HDF5, the short way: all frames of one in memory, and the simulation that made it."""

from __future__ import annotations

from pathlib import Path

from stiction.record.frames import Frames
from stiction.record.recording import Recording
from stiction.record.replay import simulation_of
from stiction.record.writer import RecordingWriter, outcome_of
from stiction.scene import Simulation

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
        return simulation_of(recording)
