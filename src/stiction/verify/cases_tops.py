"""Tops that friction turns: a ball that is heavier on one side turns over, a rattleback turns back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import Array, G, about, make_world, matrix, solver_tolerance, steps_for


class TippeTop(Case):
    """With friction that grows with slip; by Coulomb's law alone the top would soon roll, lose nothing, and stay up."""

    name = "tippe-top"
    title = "a ball with its centre of mass below the middle, spun on a floor of greased felt, turns upside down"
    formula = (
        "m v' = F - m g u, I w' = a x F, F = N (u - mu(s) s / |s|), s the slip, N keeps it on the floor; J = L . a "
        "does not change (a from the centre of mass to the contact); at last w = -J / (I (r + e))"
    )
    source = (
        "Jellett, 'A treatise on the theory of friction' (1872), ch. 8; Bou-Rabee, Marsden and Romero, 'Tippe top "
        "inversion as a dissipation-induced instability', SIAM J. Appl. Dyn. Syst. 3 (2004); the motion is integrated "
        "here (DOP853)"
    )
    tolerance = "dt^2 5/12 int |(e e3'' x F) . a| dt / J (J), 2 dt (time), k = 0.01 (cosine), J's and k e / (r + e) (w)"
    tolerance_reason = (
        "the arm of a step is that of its middle if the contact goes on over the ball as in the last step, which is "
        "3/8 e e3'' dt^2 off, and 1/24 from the mean; coefficients are a substep late and arms a step, so the time is; "
        "the last of the tilt goes slowly, so k is a target; with w along e3 that changes w by k e / (r + e)"
    )
    solvers = ("soft", "exact")
    RADIUS: ClassVar = 20.0
    OFFSET: ClassVar = 3.0
    SPIN: ClassVar = 4.0
    TILT: ClassVar = 0.2
    MU: ClassVar = 0.3
    """Where it slips at FAST, m/s, or more."""
    FAST: ClassVar = 2.0
    SECONDS: ClassVar = 80.0
    TILT_LEFT: ClassVar = 0.01
    """1 + the cosine of the tilt."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Until it spins on its head."""
        r, e = self.RADIUS, self.OFFSET
        inertia = 0.4 * r * r  # of a kilogram, about each axis through the centre of mass
        world = make_world(solver, dt, static=0.0)
        world.materials.set_pair("default", "default", law=st.FrictionCurve(((0.0, 0.0), (self.FAST, self.MU))))
        world.add(st.Plane(), static=True)
        q = about((1, 2, 0), self.TILT)
        top = world.add(
            st.Sphere(r), mass=1.0, inertia=(inertia,) * 3, center_of_mass=(0, 0, -e), position=(0, 0, r),
            orientation=q, angular_velocity=self.SPIN * matrix(q)[:, 2],
        )  # fmt: skip

        def axis() -> Array:
            return matrix(top.orientation)[:, 2]

        def jellett() -> float:
            return inertia * float(top.angular_velocity @ (e * axis() - (0.0, 0.0, r)))

        first, worst, heights = jellett(), 0.0, [float(axis()[2])]
        often = steps_for(0.05, dt)  # a small part of a turn
        for _ in range(round(self.SECONDS / (often * dt))):
            world.step(often)
            heights.append(float(axis()[2]))
            worst = max(worst, abs(jellett() / first - 1.0))
        lies, off = self._reference(inertia, matrix(q)[:, 2])
        slack = off * dt * dt / abs(first) + solver_tolerance(solver) / (r * self.SPIN)
        yield Measurement("change of J, worst", 0.0, worst, slack)
        times = np.asarray(often * dt * np.arange(len(heights)), np.float64)
        seen = arrival_at_zero(times, np.array(heights))
        yield Measurement("time until it lies on its side", lies, seen, 2.0 * dt, "s")
        yield Measurement("cosine of its tilt at last", -1.0, heights[-1], self.TILT_LEFT)
        slack += self.TILT_LEFT * e / (r + e)
        final = -first / (inertia * (r + e))
        yield Measurement("spin at last", final, float(top.angular_velocity[2]), slack, "rad/s", "relative")

    def _reference(self, inertia: float, axis: Array) -> tuple[float, float]:
        """When it lies on its side, s, and what the arms of steps may do to J, per square of the step."""
        from scipy.integrate import solve_ivp

        r, e, up = self.RADIUS, self.OFFSET, np.array([0.0, 0.0, 1.0])

        def rates(_: float, y: Array) -> Array:
            v, w, axis = y[:3], y[3:6], y[6:9]
            turning = np.cross(w, axis)
            arm, way = e * axis - r * up, e * turning
            slip = v + np.cross(w, arm)
            slip[2] = 0.0
            speed = math.sqrt(slip @ slip)
            force = up - slip * (self.MU * min(speed / self.FAST, 1.0) / max(speed, 1e-300))
            spun = np.cross(arm, force) / inertia
            # the velocity of the contact along u stays zero: v' + w' x a + w x a'
            load = (G - np.cross(w, way)[2]) / (force[2] + np.cross(spun, arm)[2])
            force, spun = load * force, load * spun
            bent = np.cross(spun, axis) + np.cross(w, turning)
            off = 5.0 / 12.0 * abs(np.cross(e * bent, force) @ arm)
            return np.concatenate([force - G * up, spun, turning, [off]])

        start = np.concatenate([np.zeros(3), self.SPIN * axis, axis, [0.0]])
        times = np.linspace(0.0, self.SECONDS, round(20 * self.SECONDS) + 1)
        y = solve_ivp(rates, (0.0, self.SECONDS), start, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-10).y
        return arrival_at_zero(times, y[8]), float(y[9, -1])


class Rattleback(Case):
    """An ellipsoid whose axes of inertia are turned against its own. As large as the tippe top; rounder than a toy."""

    name = "rattleback"
    title = "an ellipsoid with its inertia askew, spun the wrong way, rattles and turns back; the right way it goes on"
    formula = "(I + m (p^2 - p p^T)) w' = -w x I w + p x (m (p' x w + w x (p x w)) + m g u), u' = u x w, of rolling"
    source = (
        "Kane and Levinson, 'Realistic mathematical modeling of the rattleback', Int. J. Non-Linear Mech. 17 (1982); "
        "Garcia and Hubbard, 'Spin reversal of the rattleback', Proc. R. Soc. Lond. A 418 (1988), without its "
        "losses; the motion is integrated here (DOP853), in the body's axes, p from the centre of mass to the contact"
    )
    tolerance = (
        "dt + int E dt / (I3 n^2 / 2) (time), n' dt + E / (I3 n) (spin n), n' dt + (E + A) / (I3 n) (the right way); "
        "E = dt int q . W^-1 q dt / 4, A = dt int |F . q| dt / 2, q = w x p'"
    )
    tolerance_reason = (
        "were the contact held at one place of the body during a step, the body would come to where it goes to next "
        "with the speed q dt and lose that as in an impact, q . W^-1 q dt^2 / 2 of its energy (W: of the contact, "
        "1/kg); how the place wanders is taken from the step before, which is to leave less than half of that, a "
        "target; a spin is up to a step old; and the right way it rattles, too, but so slowly that it counts how well "
        "the arm of the load F, p' dt long in a step, is that of its middle: no worse than that of its start"
    )
    solvers = ("soft", "exact")
    HALF_EXTENTS: ClassVar = (20.0, 10.0, 10.0)
    LOW: ClassVar = 4.0
    """m, the centre of mass below the middle."""
    MOMENTS: ClassVar = (20.0, 100.0, 110.0)
    """Of a kilogram."""
    SKEW: ClassVar = math.radians(-30.0)
    TILT: ClassVar = math.radians(3.0)
    SPIN: ClassVar = 0.316
    SECONDS: ClassVar = 60.0
    MU: ClassVar = 1.0
    """Rolling asks for 0.41 at most."""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Both ways, until long after the one has turned back and long before the other would."""
        for spin, what in ((self.SPIN, "the wrong way"), (-self.SPIN, "the right way")):
            motion = self._reference(spin)
            spins = self._spins(solver, dt, spin)
            held = float(np.abs(np.gradient(motion.spin, motion.times)).max()) * dt
            energy, own = 0.5 * motion.impacts * dt, self.MOMENTS[2]
            if spin < 0.0:
                energy = energy + motion.lag * dt
            if spin > 0.0:
                turned, seen = arrival_at_zero(motion.times, motion.spin), arrival_at_zero(*spins)
                # what rattles less takes less spin
                late = float(energy[motion.times < turned].sum()) * motion.times[1] / (0.5 * own * spin**2)
                yield Measurement(f"time to turn back, spun {what}", turned, seen, dt + late, "s")
            extreme = float(motion.spin.min() if spin > 0.0 else motion.spin.max())
            measured = float(spins[1].min() if spin > 0.0 else spins[1].max())
            slack = held + float(energy[-1]) / (own * abs(extreme))
            text = "most spin back" if spin > 0.0 else "least spin"
            yield Measurement(f"{text}, spun {what}", extreme, measured, slack, "rad/s")

    def _start(self) -> tuple[Array, Array, Array]:
        """Turned out of rest: rotation matrix, tensor of inertia (kg m^2) and centre of mass (m) in its axes."""
        c, s = math.cos(self.SKEW), math.sin(self.SKEW)
        askew = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        inertia = askew @ np.diag(self.MOMENTS) @ askew.T
        return matrix(about((1, 1, 0), self.TILT)), inertia, np.array([0.0, 0.0, -self.LOW])

    def _spins(self, solver: str, dt: float, spin: float) -> tuple[Array, Array]:
        """Times, and the spin about the vertical at each; it begins to roll at once."""
        R, inertia, center = self._start()
        lowest = _lowest(np.square(self.HALF_EXTENTS), R.T @ (0.0, 0.0, 1.0))
        w = np.array([0.0, 0.0, spin])
        world = make_world(solver, dt, static=self.MU)
        world.add(st.Plane(), static=True)
        stone = world.add(
            st.Ellipsoid(self.HALF_EXTENTS), mass=1.0, inertia=inertia, center_of_mass=center,
            position=(0, 0, -(R @ lowest)[2]), orientation=about((1, 1, 0), self.TILT), angular_velocity=w,
            velocity=np.cross(R @ (lowest - center), w),
        )  # fmt: skip
        often = steps_for(0.1, dt)
        spins = [spin]
        for _ in range(round(self.SECONDS / (often * dt))):
            world.step(often)
            spins.append(float(stone.angular_velocity[2]))
        return np.asarray(often * dt * np.arange(len(spins)), np.float64), np.array(spins)

    def _reference(self, spin: float) -> RollingMotion:
        R, inertia, center = self._start()
        return roll(np.square(self.HALF_EXTENTS), inertia, center, R, spin * R[2], self.SECONDS)


class RollingMotion(NamedTuple):
    """Of an ellipsoid of 1 kg that rolls on a plane, at ``times`` (n,): its spin about the vertical, rad/s, and what
    steps will have taken from its energy in impacts, or may have made of it by a lag, J per second of step."""

    times: Array
    spin: Array
    impacts: Array
    lag: Array


def roll(squares: Array, inertia: Array, center: Array, R: Array, w: Array, seconds: float) -> RollingMotion:
    """Integrate the rolling of an ellipsoid of 1 kg with these squares of its semi-axes (3,); w is in its axes."""
    from scipy.integrate import solve_ivp

    def rates(_: float, y: Array) -> Array:
        w, u = y[:3], y[3:6]
        up = np.cross(u, w)
        h = math.sqrt(u @ (squares * u))
        p = _lowest(squares, u) - center
        way = -squares * up / h + squares * u * (u @ (squares * up)) / h**3  # p' in the axes of the body
        force = np.cross(way, w) + np.cross(w, np.cross(p, w)) + G * u
        arm = np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])
        turning = np.linalg.solve(inertia - arm @ arm, np.cross(p, force) - np.cross(w, inertia @ w))
        q = np.cross(w, way + np.cross(w, p))
        response = np.eye(3) - arm @ np.linalg.solve(inertia, arm)
        impacts, lag = q @ np.linalg.solve(response, q), abs((force + np.cross(p, turning)) @ q)
        return np.concatenate([turning, up, [0.5 * impacts, 0.5 * lag]])

    times = np.linspace(0.0, seconds, round(20 * seconds) + 1)
    y = np.concatenate([w, R[2], [0.0, 0.0]])
    y = solve_ivp(rates, (0.0, seconds), y, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-12).y
    return RollingMotion(times, np.sum(y[:3] * y[3:6], axis=0), y[6], y[7])


def _lowest(squares: Array, u: Array) -> Array:
    """Where an ellipsoid reaches farthest against the unit vector u, both in its axes."""
    return np.asarray(-squares * u / math.sqrt(u @ (squares * u)))


def arrival_at_zero(times: Array, values: Array) -> float:
    """When what begins above zero first comes down to it, between two of the times; NaN if it never does."""
    below = np.flatnonzero(values <= 0.0)
    if not len(below):
        return math.nan
    k = below[0]
    share = values[k - 1] / (values[k - 1] - values[k])
    return float(times[k - 1] + share * (times[k] - times[k - 1]))
