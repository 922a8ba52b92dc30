"""Track: what figures are made of, whether it was watched just now or comes from a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.plot.points import Pairs
from stiction.record.frames import Frames
from stiction.record.recorder import Frame, Recorder
from stiction.reports import Energy
from stiction.scene import Scene, Simulation
from stiction.world import MOST_STEPS, World

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Track:
    """A run and what is known of it.

    Attributes:
        frames: bodies and contacts.
        pairs: gives for the names of two materials what has ``static`` and ``dynamic``, their coefficients.
        gravity: (3,) m/s^2.
        energies: (f, 9) J, the ledger at each frame in the order of :class:`stiction.reports.Energy`; None if it was
            not kept.
    """

    frames: Frames
    pairs: Pairs
    gravity: Array
    energies: Array | None = None


class Observer(Recorder):
    """Watches a world for figures: frames as :class:`~stiction.record.recorder.Recorder` keeps them, and energies.

    Args:
        world: the world to watch.
        title: of its figures.
        every: steps from one frame to the next.

    Raises:
        InvalidInputError: every is not a whole number, 1 or more.

    Example:
        >>> import stiction as st
        >>> from stiction.plot import Observer
        >>> world = st.World()
        >>> floor = world.add(st.Plane(), static=True)
        >>> crate = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5), velocity=(1, 0, 0))
        >>> observer = Observer(world, "a crate")
        >>> for _ in range(30):
        ...     world.step()
        ...     kept = observer.capture()
        >>> len(observer.track().frames)
        30
    """

    def __init__(self, world: World, title: str, every: int = 1) -> None:
        super().__init__(world, title, every)
        self._energies: list[Energy] = []

    def _keep(self, frame: Frame) -> None:
        super()._keep(frame)
        self._energies.append(self.world.energy())

    def track(self) -> Track:
        """Everything that was seen so far."""
        energies = np.array(self._energies, np.float64).reshape(-1, len(Energy._fields))
        return Track(self.frames(), self.world.materials.pair, self.world.gravity, energies)


def observe(
    watched: World | Simulation,
    seconds: float | None = None,
    *,
    title: str | None = None,
    every: int = 1,
    on_progress: Callable[[int, int], None] | None = None,
) -> Track:
    """Run a world or a simulation, and watch it.

    Args:
        watched: a world, or the simulation of a scene.
        seconds: how long, s; a simulation goes to its end at the latest, which is where it goes if this is left out.
        title: of the figures; that of the scene if left out.
        every: steps from one frame to the next.
        on_progress: called with the steps taken and the steps there are, after every frame.

    Raises:
        InvalidInputError: seconds is missing for a world, or a value is not allowed.
        SimulationError: a body's state is no longer finite.
    """
    advance: Callable[[int], None]
    if isinstance(watched, Simulation):
        world, advance, scene_title = watched.world, watched.advance, watched.scene.title
        total = watched.total_steps - watched.step_index
    elif isinstance(watched, World):
        world, advance, scene_title, total = watched, watched.step, "a world", MOST_STEPS
        if seconds is None:
            raise InvalidInputError("seconds must be given for a world, which has no end.")
    else:
        raise InvalidInputError(f"watched must be a World or a Simulation, got {type(watched).__name__}.")
    if seconds is not None:
        total = min(total, max(1, round(checks.positive("seconds", seconds, "s") / world.dt)))
    observer = Observer(world, scene_title if title is None else title, every)
    observer.capture()
    taken = 0
    while taken < total:
        steps = min(every - world.steps % every, total - taken)
        advance(steps)
        taken += steps
        observer.capture(force=taken == total)
        if on_progress is not None:
            on_progress(taken, total)
    return observer.track()


def from_recording(path: str | Path) -> Track:
    """The track that a recording holds: as many frames as it has, their energies (but for format 1, which has none),
    and contacts where they were recorded.

    Raises:
        InvalidInputError: there is no such file, or it is no recording.
    """
    from stiction.record.recording import Recording

    with Recording.open(path) as recording:
        frames = recording.frames()
        if "scene" in frames.meta:
            world = Scene.from_dict(frames.meta["scene"], str(frames.meta["scene_name"])).build()
        else:
            world = recording.world(recording.first_step)
        energies = None
        if recording.format_version > 1:
            rows = recording.energies
            energies = np.column_stack([rows[name] for name in Energy._fields])
    return Track(frames, world.materials.pair, world.gravity, energies)


def thinned(frames: Frames, every: int) -> Frames:
    """Every so many-th frame of a run, and its last one.

    Args:
        frames: the run.
        every: how many frames of it make one.
    """
    last = len(frames) - 1
    keep = sorted({*range(0, last + 1, every), last} - {-1})
    changed: dict[str, Any] = {
        name: getattr(frames, name)[keep]
        for name in ("times", "positions", "orientations", "velocities", "angular_velocities", "motion")
    }
    rows = [frames.contacts_of(k) for k in keep]
    changed["contacts"] = np.concatenate([frames.contacts[:0], *rows])
    changed["contact_offsets"] = np.concatenate([[0], np.cumsum([len(r) for r in rows])]).astype(np.int64)
    return replace(frames, **changed)
