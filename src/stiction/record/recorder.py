"""Recorder: keeps frames of a running world in memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction._version import __version__
from stiction.errors import InvalidInputError
from stiction.hashing import PARTS, STATE_WIDTH
from stiction.motion import Motion
from stiction.record.bodies import info_of
from stiction.record.classify import fixed_bodies, judge
from stiction.record.frames import CONTACT_DTYPE, BodyInfo, Frames
from stiction.world import World

Array = NDArray[np.float64]

WIDTHS = {name: part.stop - part.start for name, part in PARTS.items()}
"""Numbers a body of the arrays of a frame; the names are those of the world's arrays as well."""


class Frame(NamedTuple):
    """One moment of a world of n bodies.

    Attributes:
        step: steps taken so far. time: s.
        positions, velocities, angular_velocities: (n, 3) in m, m/s, rad/s. orientations: (n, 4).
        motion: (n,) uint8 values of :class:`stiction.motion.Motion`; all of them free if nobody asked for it.
        contacts: rows of ``CONTACT_DTYPE``, those of the last step.
    """

    step: int
    time: float
    positions: Array
    orientations: Array
    velocities: Array
    angular_velocities: Array
    motion: NDArray[np.uint8]
    contacts: NDArray[Any]


def capture(
    world: World, *, contacts: bool = True, motion: bool = True, fixed: NDArray[np.bool_] | None = None
) -> Frame:
    """What a world looks like now, as copies.

    Args:
        world: the world.
        contacts: keep its contact points, too.
        motion: judge what each body is doing, which takes longer than a step of a small world.
        fixed: (n,) which bodies are fixed, for callers that ask often.
    """
    rows = world.contacts() if contacts or motion else np.zeros(0, CONTACT_DTYPE)
    # one copy of all numbers, not by the world's own arrays: whoever asks for those may change them, and every step
    # that follows would look for changes
    state = world._store.column(world._state.POSITION, STATE_WIDTH).copy()
    doing = np.full(len(world), Motion.FREE, np.uint8)
    if motion:
        doing = judge(state, fixed_bodies(world) if fixed is None else fixed, rows)
    return Frame(
        step=world.steps,
        time=world.time,
        motion=doing,
        contacts=rows if contacts else np.zeros(0, CONTACT_DTYPE),
        **{name: state[:, part] for name, part in PARTS.items()},
    )


def body_infos(world: World) -> list[BodyInfo]:
    """What does not change about the bodies of a world."""
    return [info_of(body) for body in world]


def gather(frames: Sequence[Frame], n: int) -> dict[str, NDArray[Any]]:
    """Frames of n bodies as arrays under the names of :class:`stiction.record.frames.Frames`, a row a frame.

    ``counts`` (f,) says how many rows of ``contacts`` belong to each of them.
    """
    f = len(frames)
    stacked: dict[str, NDArray[Any]] = {
        name: np.array([getattr(frame, name) for frame in frames], np.float64).reshape(f, n, width)
        for name, width in WIDTHS.items()
    }
    stacked["times"] = np.array([frame.time for frame in frames], np.float64)
    stacked["motion"] = np.array([frame.motion for frame in frames], np.uint8).reshape(f, n)
    stacked["contacts"] = np.concatenate(
        [np.zeros(0, CONTACT_DTYPE), *(frame.contacts for frame in frames)],
        dtype=CONTACT_DTYPE,  # else each of them is compared with the one before it, field by field
    )
    stacked["counts"] = np.array([len(frame.contacts) for frame in frames], np.int64)
    return stacked


class Capturer:
    """Decides which moments of a world become frames: every so many steps, each step once.

    Args:
        world: the world to watch.
        every: steps from one frame to the next.
        contacts: keep contact points, too.
        motion: judge what each body is doing, too.

    Raises:
        InvalidInputError: every is not a whole number, 1 or more.
    """

    def __init__(self, world: World, every: int = 1, contacts: bool = True, motion: bool = True) -> None:
        self.world = world
        self.every = checks.integer("every", every, minimum=1)
        self.contacts = contacts
        self.motion = motion
        self._fixed = fixed_bodies(world)
        self._last: int | None = None

    def capture(self, *, force: bool = False) -> bool:
        """Keep a frame of this moment if it is due; returns whether it was.

        Args:
            force: keep it although it is not due, such as the last one of a run. A step never gives two frames.

        Raises:
            InvalidInputError: bodies were added or removed after the recording began.
        """
        step = self.world.steps
        if step == self._last or not (force or step % self.every == 0):
            return False
        if len(self.world) != len(self._fixed):
            raise InvalidInputError(
                f"a recording of {len(self._fixed)} bodies must keep them, and the world has {len(self.world)} now."
            )
        self._keep(capture(self.world, contacts=self.contacts, motion=self.motion, fixed=self._fixed))
        self._last = step
        return True

    def _keep(self, frame: Frame) -> None:
        raise NotImplementedError


class Recorder(Capturer):
    """Frames of a world in memory.

    Args:
        world: the world to watch.
        title: of the recording.
        every: steps from one frame to the next.
        contacts: keep contact points, too.
        motion: judge what each body is doing, too.

    Raises:
        InvalidInputError: every is not a whole number, 1 or more.

    Example:
        >>> import stiction as st
        >>> world = st.World(gravity=(0, 0, 0), dt=0.1)
        >>> ball = world.add(st.Sphere(0.5), velocity=(1, 0, 0))
        >>> recorder = Recorder(world, "a ball")
        >>> for _ in range(3):
        ...     world.step()
        ...     kept = recorder.capture()
        >>> recorder.frames().positions[:, 0, 0].round(3).tolist()
        [0.1, 0.2, 0.3]
    """

    def __init__(self, world: World, title: str, every: int = 1, contacts: bool = True, motion: bool = True) -> None:
        super().__init__(world, every, contacts, motion)
        self.title = title
        self._frames: list[Frame] = []

    def __len__(self) -> int:
        return len(self._frames)

    def _keep(self, frame: Frame) -> None:
        self._frames.append(frame)

    def frames(self) -> Frames:
        """Everything that was kept so far, as arrays."""
        arrays = gather(self._frames, len(self._fixed))
        counts = arrays.pop("counts")
        meta = {"stiction_version": __version__, "solver": self.world.solver, "every": self.every}
        return Frames(
            title=self.title,
            dt=self.world.dt,
            bodies=body_infos(self.world),
            contact_offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            meta=meta,
            **arrays,
        )
