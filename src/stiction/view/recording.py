"""A run as a recording of viser's scene: stage, grounds, bodies, contacts, frame after frame.

Bodies of the same shape share one batched mesh, whose positions, orientations and colours are updated together. That
keeps the page small (arrays instead of messages), lets a colour change at any frame, and draws a thousand boxes with
two calls.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stiction.record.frames import Frames
from stiction.record.recorder import Frame
from stiction.view.nodes import PALETTE, Batch, add_bodies, add_contacts, add_names
from stiction.view.stage import Update, add_grounds, changes, first_view, quiet, set_stage
from stiction.view.survey import Survey

Indices = NDArray[np.int64]

HOLD = 1.0
"""Seconds that the last picture stays before the player starts again."""


def record(frames: Frames, picked: Indices, seen: Survey, progress: Callable[[float], None]) -> str:
    """The page as viser makes it, without title and legend.

    Args:
        frames: the run.
        picked: numbers of the frames to show.
        seen: see :func:`stiction.view.survey.survey`.
        progress: called with the finished share, from 0 to 1.
    """
    import viser

    # viser can only record what a running server shows, so one runs here: for this machine alone, on a free port
    with quiet():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        first = moment(frames, int(picked[0]))
        view = first_view(frames, seen)
        set_stage(server, view)
        updates = add_grounds(server, frames, seen, view)
        batches = add_bodies(server, frames.bodies, first, ~changes(frames))
        updates += [_batch_update(batch) for batch in batches if not batch.rests]
        updates += [*add_names(server, frames.bodies, seen), add_contacts(server, frames, picked, seen.typical)]
        recording = server.get_scene_serializer()
        for n, k in enumerate(picked.tolist()):
            if n:
                recording.insert_sleep(float(frames.times[k] - frames.times[picked[n - 1]]))
            frame = moment(frames, k)
            for update in updates:
                update(frame)
            progress((n + 1) / len(picked))
        if len(picked) > 1:
            recording.insert_sleep(HOLD)
        return recording.as_html()
    finally:
        with quiet():
            server.stop()


def moment(frames: Frames, k: int) -> Frame:
    """Frame k of a run on its own."""
    return Frame(
        step=round(float(frames.times[k]) / frames.dt),
        time=float(frames.times[k]),
        positions=frames.positions[k],
        orientations=frames.orientations[k],
        velocities=frames.velocities[k],
        angular_velocities=frames.angular_velocities[k],
        motion=frames.motion[k],
        contacts=frames.contacts_of(k),
    )


def _batch_update(batch: Batch) -> Update:
    return lambda frame: batch.show(frame, PALETTE[frame.motion])
