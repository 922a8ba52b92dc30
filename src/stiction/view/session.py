"""Sessions: what a live view shows and what its buttons do, without any browser.

A session is used from one thread. Whoever shows it calls :meth:`Session.tick` with the wall time that has gone by, asks
for a frame, and hands on what the reader did.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.errors import InvalidInputError, SimulationError
from stiction.record.classify import fixed_bodies, lengths
from stiction.record.frames import BodyInfo, Frames
from stiction.record.recorder import Frame, Recorder, body_infos, capture
from stiction.view.grab import Grab
from stiction.world import MOST_STEPS, World

Array = NDArray[np.float64]

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
"""How fast time can run, as multiples of real time."""
MOST_BEHIND = 0.1
"""s of wall time that a world which is slower than real time catches up with at most; the rest is let go."""
CHART_SAMPLES = 300
"""Samples that the chart keeps."""


class Sample(NamedTuple):
    """A moment of the chart: time in s, energies in J (NaN where unknown), force in N."""

    time: float
    kinetic: float
    potential: float
    dissipated: float
    friction: float


class Session:
    """Something that plays. What is common to worlds and recordings.

    Attributes:
        title: of what is shown.
        bodies: what does not change about the n bodies.
        playing: whether time runs.
        chart: the newest samples.
        trouble: the sentence that stopped the play, or the empty text.
        picked: number of the body whose contacts are looked at, or None.
    """

    live = False
    note = ""
    """What the reader should know of what is shown, or the empty text."""

    def __init__(self, title: str, bodies: list[BodyInfo]) -> None:
        self.title = title
        self.bodies = bodies
        self.playing = False
        self.trouble = ""
        self.chart: deque[Sample] = deque(maxlen=CHART_SAMPLES)
        self.picked: int | None = None
        self._speed = 1.0
        self._near: Array | None = None

    @property
    def speed(self) -> float:
        """How fast time runs, as a multiple of real time."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        self._speed = checks.positive("speed", value)

    def tick(self, elapsed: float, room: float | None = None) -> bool:
        """Let ``elapsed`` seconds of wall time go by; whether anything is different now.

        Args:
            elapsed: s since the last call.
            room: s of wall time that the work for it may take; as long as it was if left out.
        """
        raise NotImplementedError

    def step(self) -> None:
        """Pause, and go one step further."""
        raise NotImplementedError

    def reset(self) -> None:
        """Go back to the beginning."""
        raise NotImplementedError

    def frame(self) -> Frame:
        """What there is to see now."""
        raise NotImplementedError

    def asleep(self) -> NDArray[np.bool_]:
        """(n,) which moving bodies sleep."""
        return np.zeros(len(self.bodies), np.bool_)

    def survey_frames(self) -> Frames:
        """The frames from which the place of the camera and the size of the grounds follow."""
        raise NotImplementedError

    def coefficients(self, a: int, b: int) -> tuple[float, float] | None:
        """Static and dynamic coefficient of bodies a and b, or None where they are not known."""
        return None

    def friction_force(self, frame: Frame, dt: float) -> float:
        """N: that on the picked body, or without one the magnitudes of all contacts added up."""
        rows = frame.contacts
        if self.picked is None:
            return float(lengths(rows["friction_impulse"]).sum()) / dt
        on_a, on_b = rows["body_a"] == self.picked, rows["body_b"] == self.picked
        force = rows["friction_impulse"][on_b].sum(axis=0) - rows["friction_impulse"][on_a].sum(axis=0)
        return float(np.linalg.norm(force)) / dt

    def pick(self, body: int | None, near: Array | None = None) -> None:
        """Look at the contacts of this body, at the one nearest to a point (3,) first; the chart then begins anew.

        Raises:
            InvalidInputError: there is no body of that number.
        """
        if body is not None and not 0 <= body < len(self.bodies):
            raise InvalidInputError(f"body must be the number of one of {len(self.bodies)} bodies, got {body!r}.")
        self._near = None if near is None else checks.vector("near", near)
        if body != self.picked:
            self.picked = body
            self.chart.clear()

    def picked_contact(self, rows: NDArray[Any]) -> Any | None:
        """Of contact rows the loaded one of the picked body that is nearest to where it was before, or None."""
        if self.picked is None:
            return None
        mine = rows[
            ((rows["body_a"] == self.picked) | (rows["body_b"] == self.picked)) & (rows["normal_impulse"] > 0.0)
        ]
        if not len(mine):
            return None
        if self._near is None:
            row = mine[np.argmax(mine["normal_impulse"])]
        else:
            row = mine[np.argmin(np.linalg.norm(mine["point"] - self._near, axis=1))]
        self._near = row["point"].copy()
        return row


class LiveSession(Session):
    """A world that is stepped while it is looked at.

    Args:
        world: the world.
        title: of the view.
        advance: takes that many steps of it; ``world.step`` if left out.
        restart: builds the world anew, and gives it and its ``advance``; without it a reset puts the bodies back.
        preview: frames of the same world that was let run, so that the picture has room for what will happen.
        clock: seconds, for the time that steps cost.
    """

    live = True

    def __init__(
        self,
        world: World,
        title: str = "a world",
        *,
        advance: Callable[[int], None] | None = None,
        restart: Callable[[], tuple[World, Callable[[int], None]]] | None = None,
        preview: Frames | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        super().__init__(title, body_infos(world))
        self.world = world
        self.grab: Grab | None = None
        self._advance = advance if advance is not None else world.step
        self._restart = restart
        self._preview = preview
        self._clock = clock
        self._fixed = fixed_bodies(world)
        self._materials = sorted({body.material for body in self.bodies})
        self._material = np.array([self._materials.index(body.material) for body in self.bodies], np.int64)
        self._pairs: list[tuple[str, str]] = []
        self._due = 0.0
        self._cost = math.inf
        self._start = capture(world, contacts=False, fixed=self._fixed)
        self._changes: dict[str, Callable[[World], None]] = {}

    # --- time ---------------------------------------------------------------------------------------------------------

    def tick(self, elapsed: float, room: float | None = None) -> bool:
        """Take the steps that are due after ``elapsed`` seconds of wall time, but no more than there is ``room`` for.

        A world that is slower than real time falls behind instead of holding up whoever looks at it; one step at least
        is taken if one is due.
        """
        room = max(elapsed if room is None else room, 1e-3)
        if not self.playing:
            self._due = 0.0
            return False
        dt = self.world.dt
        self._due = min(self._due + elapsed * self.speed / dt, max(1.0, MOST_BEHIND * self.speed / dt))
        began = self._clock()
        taken = 0
        while self._due >= 1.0 and self.playing:
            called = self._clock()
            left = room - (called - began)
            if taken and left < self._cost:
                break
            # a hand pulls anew in every step
            steps = 1 if self.grab is not None else min(int(self._due), self._affordable(left))
            taken += self._take(steps)
            self._cost = (self._clock() - called) / steps
        return taken > 0

    def _affordable(self, seconds: float) -> int:
        """Steps that there is time for, at least one, by what the last ones took."""
        if math.isinf(self._cost):
            return 1
        return max(1, int(seconds / self._cost)) if self._cost > 0.0 else MOST_STEPS

    def _take(self, steps: int) -> int:
        try:
            if self.grab is not None:
                self.grab.pull(self.world)
            self._advance(steps)
        except SimulationError as error:
            self.playing = False
            self.trouble = str(error)
        self._due = max(0.0, self._due - steps)
        return steps

    def step(self) -> None:
        """Pause, and take one step."""
        self.playing = False
        self._take(1)

    def reset(self) -> None:
        """Back to the beginning; what was set by hand stays set."""
        self.grab = None
        self.trouble = ""
        self.chart.clear()
        self._due = 0.0
        if self._restart is not None:
            self.world, self._advance = self._restart()
            for change in self._changes.values():
                change(self.world)
        else:
            world, start = self.world, self._start
            if len(world) != len(start.positions):
                raise InvalidInputError(
                    f"a view of {len(start.positions)} bodies cannot be reset: the world has {len(world)} now."
                )
            for name in ("positions", "orientations", "velocities", "angular_velocities"):
                getattr(world, name)[:] = getattr(start, name)

    def frame(self) -> Frame:
        """The world as it is now."""
        if len(self.world) != len(self.bodies):
            raise InvalidInputError(
                f"a view of {len(self.bodies)} bodies must keep them, and the world has {len(self.world)} now; show it "
                f"again."
            )
        frame = capture(self.world, fixed=self._fixed)
        self._note_pairs(frame)
        self._sample(frame)
        return frame

    def survey_frames(self) -> Frames:
        """The preview, or one frame: where the bodies are now."""
        if self._preview is not None:
            return self._preview
        recorder = Recorder(self.world, self.title)
        recorder.capture(force=True)
        return recorder.frames()

    def asleep(self) -> NDArray[np.bool_]:
        """(n,) which moving bodies sleep."""
        result: NDArray[np.bool_] = ~self.world.awake & ~self._fixed
        return result

    def _sample(self, frame: Frame) -> None:
        if self.chart and self.chart[-1].time >= frame.time:
            return
        energy = self.world.energy()
        friction = self.friction_force(frame, self.world.dt)
        self.chart.append(Sample(frame.time, energy.kinetic, energy.potential, energy.dissipated, friction))

    # --- what holds for the world -------------------------------------------------------------------------------------

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Pairs of materials that have touched so far, in that order."""
        return list(self._pairs)

    def _note_pairs(self, frame: Frame) -> None:
        rows = frame.contacts
        count = len(self._materials)
        a, b = self._material.take(rows["body_a"]), self._material.take(rows["body_b"])
        touching = np.bincount(np.minimum(a, b) * count + np.maximum(a, b), minlength=count * count)
        for code in np.flatnonzero(touching).tolist():
            pair = self._materials[code // count], self._materials[code % count]
            if pair not in self._pairs:
                self._pairs.append(pair)

    def coefficients(self, a: int, b: int) -> tuple[float, float] | None:
        """Static and dynamic coefficient of bodies a and b."""
        pair = self.world.materials.pair(self.bodies[a].material, self.bodies[b].material)
        return pair.static, pair.dynamic

    def set_pair(self, a: str, b: str, *, static: float, dynamic: float) -> None:
        """New coefficients of two materials from the next step on; the dynamic one is at most the static one.

        Raises:
            InvalidInputError: a coefficient is negative or not finite, or a material is not known.
        """
        static = checks.non_negative("static", static)
        dynamic = min(checks.non_negative("dynamic", dynamic), static)
        self._change(f"pair {a} {b}", lambda world: world.materials.set_pair(a, b, static=static, dynamic=dynamic))

    @property
    def gravity(self) -> tuple[float, float, float]:
        """Magnitude in m/s^2, angle to the vertical and azimuth of the way down, in rad."""
        x, y, z = self.world.gravity.tolist()
        return math.sqrt(x * x + y * y + z * z), math.atan2(math.hypot(x, y), -z), math.atan2(y, x)

    def set_gravity(self, magnitude: float, tilt: float, azimuth: float) -> None:
        """Gravity of that magnitude in m/s^2, tilted from straight down by an angle towards an azimuth, both in rad.

        Raises:
            InvalidInputError: a number is not finite, or the magnitude is negative.
        """
        g = checks.non_negative("gravity", magnitude, "m/s^2")
        tilt, azimuth = checks.number("tilt", tilt), checks.number("azimuth", azimuth)
        across = math.sin(tilt)
        vector = g * np.array([across * math.cos(azimuth), across * math.sin(azimuth), -math.cos(tilt)])
        self._change("gravity", lambda world: setattr(world, "gravity", vector))

    def set_solver(self, solver: str, substeps: int | None = None) -> None:
        """Another solver or number of substeps from the next step on.

        Raises:
            InvalidInputError: a value is not allowed.
            NotYetError: the solver does not have what the world needs.
        """

        def change(world: World) -> None:
            if solver != world.solver:
                world.set_solver(solver, substeps=substeps)
            elif substeps is not None:
                world.substeps = substeps

        self._change("solver", change)

    def _change(self, what: str, change: Callable[[World], None]) -> None:
        change(self.world)
        self._changes[what] = change

    # --- pulling ------------------------------------------------------------------------------------------------------

    def seize(self, body: int, point: Array) -> None:
        """Take hold of a point (3,) of a body, in m; nothing happens to one that does not move by itself."""
        if not self._fixed[body]:
            self.grab = Grab(self.world, body, checks.vector("point", point))

    def drag(self, target: Array) -> None:
        """Pull the point that is held towards ``target`` (3,), in m."""
        if self.grab is not None:
            self.grab.target = checks.vector("target", target)

    def release(self) -> None:
        """Let go."""
        self.grab = None
