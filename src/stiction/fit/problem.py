"""A fit as a function: values of the parameters in, weighted differences between simulated and measured motion out.

Times of the data count from the start of the scene. Between two steps the simulated position is a cubic through both
ends with their velocities, which is exact for constant forces; the orientation goes the short way at even speed.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.body import Body
from stiction.errors import InvalidInputError, SimulationError, StictionWarning
from stiction.fit.data import Track
from stiction.fit.parameters import Array, Parameter, as_values
from stiction.scene import Scene, Simulation
from stiction.scene.overrides import apply_values
from stiction.scene.placing import turned

FAR = 1e4
"""Residual of every number of a run that blew up: worse than any run that did not."""


class Motion(NamedTuple):
    """Simulated motion of one body at the times of its track: positions (n, 3) m, orientations (n, 4)."""

    positions: Array
    orientations: Array


class Problem:
    """Measured tracks beside a scene with some numbers open.

    Args:
        scene: what was measured, as a scene; all that is not a parameter is taken from it.
        tracks: what was measured.
        parameters: what is to be found.
        sigma: of a measured coordinate, m. sigma_angle: of a measured turn about each axis, rad. Only their ratio
            matters to the result, and none where no orientation was measured: the size of the noise is taken from the
            residuals.

    Attributes:
        names: of the body of each track.
        simulations: how many there have been.
        labels: (m,) number of the track that each residual belongs to.
        moments: (m,) time of each residual, s. angular: (m,) whether it is an angle.

    Raises:
        InvalidInputError: a track names no body of the scene or one that never moves; samples lie after the scene's
            end; fewer numbers were measured than there are parameters; the parameters' first values are not allowed.
    """

    def __init__(
        self,
        scene: Scene,
        tracks: Sequence[Track],
        parameters: Sequence[Parameter],
        *,
        sigma: float = 1e-3,
        sigma_angle: float = math.radians(1.0),
    ) -> None:
        self.scene, self.tracks, self.parameters = scene, tuple(tracks), tuple(parameters)
        self.sigma = checks.positive("sigma", sigma, "m")
        self.sigma_angle = checks.positive("sigma_angle", sigma_angle, "rad")
        self.simulations = 0
        with warnings.catch_warnings():
            # a search tries what no table would hold, such as dynamic above static friction
            warnings.simplefilter("ignore", StictionWarning)
            simulation = self._simulation([p.first for p in self.parameters])
        self.names = [_body(track, simulation).name for track in self.tracks]
        twice = next((name for k, name in enumerate(self.names) if name in self.names[:k]), None)
        if twice is not None:
            raise InvalidInputError(f"data must hold one track a body, got two of {twice!r}.")
        self._dt = simulation.world.dt
        last = max(float(track.times[-1]) for track in self.tracks)
        end = simulation.total_steps * self._dt
        if last > end * (1.0 + 1e-9):
            raise InvalidInputError(
                f"data must end with the scene, at {end:g} s, got a sample at {last:g} s "
                f"(a longer scene: --set duration={math.ceil(last * 100) / 100:g})."
            )
        self._steps = min(simulation.total_steps, max(1, math.ceil(last / self._dt - 1e-9)))
        self._label_rows()
        if len(self.labels) <= len(self.parameters):
            raise InvalidInputError(
                f"data must hold more numbers than there are parameters ({len(self.parameters)}), got "
                f"{len(self.labels)}."
            )

    @property
    def count(self) -> int:
        """Numbers that were measured."""
        return len(self.labels)

    def simulate(self, x: Sequence[float] | Array) -> list[Motion]:
        """Motion of each track's body at the times of the track.

        Args:
            x: values of the parameters.

        Raises:
            SimulationError: the run blew up.
            InvalidInputError: a value is not allowed.
        """
        self.simulations += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StictionWarning)
            simulation = self._simulation(x)
            world = simulation.world
            bodies = [world[name] for name in self.names]
            rows = np.array([body.index for body in bodies])
            n = self._steps + 1
            positions, velocities = np.empty((n, len(bodies), 3)), np.empty((n, len(bodies), 3))
            orientations, spins = np.empty((n, len(bodies), 4)), np.empty((n, len(bodies), 3))
            for step in range(n):
                if step:
                    simulation.advance(1)
                positions[step], velocities[step] = world.positions[rows], world.velocities[rows]
                orientations[step], spins[step] = world.orientations[rows], world.angular_velocities[rows]
        motions = []
        for k, (body, track) in enumerate(zip(bodies, self.tracks, strict=True)):
            turns = orientations[:, k]
            arm = turned(turns, _centre(body))
            origin_velocities = velocities[:, k] - np.cross(spins[:, k], arm)
            motions.append(_at(track.times, self._dt, positions[:, k], origin_velocities, turns))
        return motions

    def residuals(self, x: Sequence[float] | Array) -> Array:
        """(m,) simulated minus measured, in units of ``sigma`` and ``sigma_angle``; turns in the measured axes."""
        try:
            motions = self.simulate(x)
        except SimulationError:
            return np.full(self.count, FAR)
        parts = []
        for motion, track in zip(motions, self.tracks, strict=True):
            off = (motion.positions - track.positions) / self.sigma
            parts.append(off[np.isfinite(off)])
            if track.orientations is not None:
                there = np.isfinite(track.orientations[:, 0])
                turn = rotation_between(track.orientations[there], motion.orientations[there])
                parts.append((turn / self.sigma_angle).ravel())
        return np.concatenate(parts)

    def values(self, x: Sequence[float] | Array) -> Mapping[str, float]:
        """Path of each key to its value."""
        return as_values(self.parameters, x)

    def _simulation(self, x: Sequence[float] | Array) -> Simulation:
        return Simulation(Scene(apply_values(self.scene.table, self.values(x)), self.scene.name))

    def _label_rows(self) -> None:
        labels, moments, angular = [], [], []
        for k, track in enumerate(self.tracks):
            there = np.isfinite(track.positions)
            times = [np.broadcast_to(track.times[:, None], there.shape)[there]]
            if track.orientations is not None:
                times.append(np.repeat(track.times[np.isfinite(track.orientations[:, 0])], 3))
            for number, part in enumerate(times):
                labels.append(np.full(len(part), k))
                moments.append(part)
                angular.append(np.full(len(part), number == 1))
        self.labels: NDArray[np.int64] = np.concatenate(labels)
        self.moments: Array = np.concatenate(moments)
        self.angular: NDArray[np.bool_] = np.concatenate(angular)


def _body(track: Track, simulation: Simulation) -> Body:
    """The body that a track means; a track without a name means the only one that can move."""
    movers = {body.name: body for body in simulation.world if body.mobility == "dynamic"}
    if not track.body:
        if len(movers) != 1:
            raise InvalidInputError(
                f"data must name bodies in a column body, for the scene has {len(movers)} that move: "
                f"{', '.join(list(movers)[:5])}."
            )
        return next(iter(movers.values()))
    if track.body not in movers:
        raise InvalidInputError(
            f"body of the data must be one of the scene that moves, got {track.body!r}"
            f"{checks.nearest(track.body, movers)}."
        )
    return movers[track.body]


def _centre(body: Body) -> Array:
    """(3,) m, centre of mass from the origin of the shape's frame, in its axes."""
    return np.array(body.shape.mass_properties.center_of_mass, dtype=np.float64)


def _at(times: Array, dt: float, positions: Array, velocities: Array, orientations: Array) -> Motion:
    """Motion at any times, from its state after every step."""
    place = times / dt
    left = np.minimum(place.astype(np.int64), len(positions) - 2)
    s = (place - left)[:, None]
    a, b = positions[left], positions[left + 1]
    u, v = velocities[left] * dt, velocities[left + 1] * dt
    # Hermite's cubic: ends a and b, slopes u and v
    x = a + s * (u + s * (3.0 * (b - a) - 2.0 * u - v + s * (2.0 * (a - b) + u + v)))
    p, q = orientations[left], orientations[left + 1]
    q = np.where((p * q).sum(axis=1, keepdims=True) < 0.0, -q, q)
    # within a step a body turns little: the chord, made a unit again, is the arc to third order
    turn = (1.0 - s) * p + s * q
    return Motion(x, turn / np.linalg.norm(turn, axis=1, keepdims=True))


def rotation_between(first: Array, second: Array) -> Array:
    """(n, 3) rotation vectors in rad that turn ``first`` (n, 4) into ``second``, in the axes of ``first``."""
    w1, v1 = first[:, :1], first[:, 1:]
    w2, v2 = second[:, :1], second[:, 1:]
    w = w1 * w2 + (v1 * v2).sum(axis=1, keepdims=True)
    v = w1 * v2 - w2 * v1 - np.cross(v1, v2)
    v = np.where(w < 0.0, -v, v)
    length = np.linalg.norm(v, axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(length, np.abs(w))
    return np.asarray(v * np.divide(angle, length, out=np.full_like(length, 2.0), where=length > 1e-12))
