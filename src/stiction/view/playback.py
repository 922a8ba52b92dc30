"""Playback: a recording as a session, with a time that can be set."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError
from stiction.record.frames import Frames
from stiction.record.recorder import Frame
from stiction.view.recording import moment
from stiction.view.session import Sample, Session

Array = NDArray[np.float64]


class Playback(Session):
    """A recording that plays.

    Args:
        frames: the recording.
        energies: (f, 3) kinetic, potential and dissipated, J, for the chart; the kinetic one follows from the frames
            if left out, and the others are not shown.

    Raises:
        InvalidInputError: it holds no frame.
    """

    def __init__(self, frames: Frames, energies: Array | None = None) -> None:
        if not len(frames):
            raise InvalidInputError("frames must hold at least one frame, got 0.")
        super().__init__(frames.title, frames.bodies)
        self._frames, self._energies = frames, energies
        if frames.meta.get("contacts", True) is False:
            self.note = "recorded without contacts: what bodies do is not known (record with contacts to see it)"
        self._time = float(frames.times[0])
        self._mass = np.array([0.0 if body.fixed else body.mass for body in frames.bodies])

    @property
    def begin(self) -> float:
        """Time of the first frame, s."""
        return float(self._frames.times[0])

    @property
    def end(self) -> float:
        """Time of the last frame, s."""
        return float(self._frames.times[-1])

    @property
    def time(self) -> float:
        """Where the play is, s."""
        return self._time

    @property
    def index(self) -> int:
        """Number of the frame that is shown: the last one that is not later than the time."""
        # a thousandth of a step of slack, so that a frame's own time finds it in spite of rounding
        late = self._time + 1e-3 * self._frames.dt
        return max(0, int(np.searchsorted(self._frames.times, late, side="right")) - 1)

    def tick(self, elapsed: float, room: float | None = None) -> bool:
        """Go on in time; at the end the play stops. Nothing has to be worked out, so ``room`` does not matter."""
        if not self.playing:
            return False
        before = self.index
        self._time = min(self._time + elapsed * self.speed, self.end)
        if self._time >= self.end:
            self.playing = False
        return self.index != before or not self.playing

    def seek(self, time: float) -> None:
        """Go to a time, in s; what lies outside the recording is its nearest end."""
        time = min(max(checks.number("time", time), self.begin), self.end)
        if time < self._time:
            self.chart.clear()
        self._time = time

    def step(self) -> None:
        """Pause, and go to the next frame."""
        self.playing = False
        self._time = float(self._frames.times[min(self.index + 1, len(self._frames) - 1)])

    def reset(self) -> None:
        """Go back to the first frame."""
        self.seek(self.begin)

    def play(self) -> None:
        """Let time run, from the beginning if it has reached the end."""
        if self._time >= self.end:
            self.reset()
        self.playing = True

    def frame(self) -> Frame:
        """The frame of this time."""
        frame = moment(self._frames, self.index)
        if not self.chart or self.chart[-1].time < frame.time:
            speed = np.linalg.norm(frame.velocities, axis=1)
            kinetic = float(0.5 * self._mass @ speed**2)
            friction = self.friction_force(frame, self._frames.dt)
            potential = dissipated = np.nan
            if self._energies is not None:
                kinetic, potential, dissipated = self._energies[self.index].tolist()
            self.chart.append(Sample(frame.time, kinetic, potential, dissipated, friction))
        return frame

    def survey_frames(self) -> Frames:
        """The whole recording."""
        return self._frames
