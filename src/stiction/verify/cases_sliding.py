"""Blocks that slide on a level floor: how far, how long, which way, and how a spinning one stops."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    G,
    about,
    arrival,
    box_inertia,
    distance_error,
    lean,
    make_world,
    sink,
    speed_error,
    steps_for,
    stop_error,
    turned_by,
)

LAWS = "Newton's second law and Coulomb's law"


class StoppingDistance(Case):
    """A plank is a hard test of direction: its corners yield more easily one way than another."""

    name = "stopping-distance"
    title = "a plank stops after the same distance in 12 directions, whatever its yaw, on a straight line"
    formula = "d = v^2 / (2 mu_d g), t = v / (mu_d g)"
    source = LAWS
    tolerance = (
        "g dt^2 max(mu_d / 8, mu_s (mu_s - mu_d) / (2 mu_d)) + eps t sqrt(t / dt) (distance), eps sqrt(t / dt) / "
        "(mu_d g) (time)"
    )
    tolerance_reason = (
        "the plank stops within a step, not at its end, and mu_s may hold it a little before; and the solver's "
        "tolerance eps enters the speed in every step, with either sign"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "mu_d g h^2 / 8 + 7/4 (g / omega^2) H / b + e t (distance), e / (mu_d g) (time), e = eps sqrt(t / dt) + u "
            "v t / h",
            "the plank stops within a substep h, and straightens up, which had leant over (height H, width b) into "
            "springs of omega h = 1.3; and u v t / h is what single precision (u = 2^-24) makes of a speed v, rounded "
            "the same way in each substep",
        ),
    }
    SPEED: ClassVar = 5.0
    STATIC: ClassVar = 0.5
    DYNAMIC: ClassVar = 0.3
    YAWS_DEG: ClassVar = (0.0, 22.5, 45.0)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """36 planks in one world, far apart."""
        v, mu = self.SPEED, self.DYNAMIC
        world = make_world(solver, dt, static=self.STATIC, dynamic=mu)
        world.add(st.Plane(), static=True)
        directions, planks, starts = [], [], []
        for k in range(12):
            for j, yaw in enumerate(self.YAWS_DEG):
                angle = math.radians(30.0 * k)
                direction = np.array([math.cos(angle), math.sin(angle), 0.0])
                start = np.array([20.0 * k, 20.0 * j, 0.1])
                q = about((0, 0, 1), math.radians(yaw))
                plank = world.add(st.Box((2.0, 0.4, 0.2)), position=start, orientation=q, velocity=v * direction)
                directions.append(direction)
                planks.append(plank)
                starts.append(start)

        stop = v / (mu * G)
        speeds = [[v] for _ in planks]
        for _ in range(steps_for(1.2 * stop, dt)):
            world.step()
            for plank, seen in zip(planks, speeds, strict=True):
                seen.append(float(np.linalg.norm(plank.velocity)))

        d = v * v / (2.0 * mu * G)
        within_step = stop_error(solver, self.STATIC, mu, dt) + lean(solver, dt, 0.2, 0.4)
        slack = distance_error(solver, 1.2 * stop, dt, v)
        along, aside, turn = [], [], []
        for plank, start, direction in zip(planks, starts, directions, strict=True):
            path = plank.position - start
            along.append(float(path @ direction))
            aside.append(float(np.linalg.norm(path - (path @ direction) * direction)))
        for i, plank in enumerate(planks):
            turn.append(
                turned_by(about((0, 0, 1), math.radians(self.YAWS_DEG[i % len(self.YAWS_DEG)])), plank.orientation)
            )
        for k in range(12):
            worst = max(along[3 * k : 3 * k + 3], key=lambda x: abs(x - d))
            yield Measurement(f"distance towards {30 * k} deg, worst of 3 yaws", d, worst, within_step + slack, "m")
        yield Measurement("distance off the straight line, worst of 36", 0.0, max(aside), slack, "m")
        # half the plank's length is the longest arm, so an error of speed there turns it by no more than that
        yield Measurement("turn about the vertical, worst of 36", 0.0, max(turn), slack, "rad")
        times = [arrival(seen, dt) for seen in speeds]
        worst = max(times, key=lambda t: abs(t - stop))
        yield Measurement("time to stop, worst of 36", stop, worst, speed_error(solver, stop, dt, v) / (mu * G), "s")


class SpinDownOnCorners(Case):
    """An engine that keeps the corners of a face as contact points must be compared with corners, not with the face.

    Loads of m g in all at the distance r_c from the axis brake with mu_d m g r_c. A face under uniform pressure
    would brake less, and later: see the case ``spin-down-of-a-face``, which is the one for other engines.
    """

    name = "spin-down-on-corners"
    title = "a slab spinning on its four corners stops: compared with the corner radius r_c, not with the face"
    formula = "t = I w / (mu_d m g r_c), turned by w t / 2"
    source = LAWS + " for loads on a circle of radius r_c"
    tolerance = "that of 'stopping-distance', by m r_c / I (angle), eps sqrt(t / dt) I / (mu_d m g r_c^2) (time)"
    tolerance_reason = (
        "the slab stops within a step; all corners have the same arm, so it does not matter how they share the load"
    )
    solvers = ("micro",)
    SPIN: ClassVar = 6.0
    STATIC: ClassVar = 0.5
    DYNAMIC: ClassVar = 0.4
    SIZE: ClassVar = (1.2, 0.5, 0.1)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """An oblong slab, so that r_c is neither a half length nor a half width."""
        mu, w0 = self.DYNAMIC, self.SPIN
        world = make_world(solver, dt, static=self.STATIC, dynamic=mu)
        world.add(st.Plane(), static=True)
        start = about((0, 0, 1), 0.3)
        slab = world.add(
            st.Box(self.SIZE), position=(0, 0, 0.5 * self.SIZE[2]), orientation=start, angular_velocity=(0, 0, w0)
        )
        x, y, _ = self.SIZE
        r = 0.5 * math.hypot(x, y)
        brake = mu * slab.mass * G * r / float(box_inertia(slab.mass, self.SIZE)[2])
        stop = w0 / brake
        spins, angle = [w0], 0.0
        q = slab.orientation
        for _ in range(steps_for(1.2 * stop, dt)):
            world.step()
            spins.append(float(slab.angular_velocity[2]))
            angle += turned_by(q, slab.orientation)
            q = slab.orientation
        eps = speed_error(solver, stop, dt) / r
        slack = stop_error(solver, self.STATIC, mu, dt) * brake / (mu * G) + eps * stop
        yield Measurement("time to stop", stop, arrival(spins, dt), eps / brake, "s")
        yield Measurement("angle turned", 0.5 * w0 * stop, angle, slack, "rad")


class ThinSheet(Case):
    """Within one step a fast sheet moves by more than its thickness, and it still stands on its lower face."""

    name = "thin-sheet"
    title = "a sheet thinner than the way it makes in a step stops where a block does, without sinking or pitching"
    formula = "d = v^2 / (2 mu_d g)"
    source = LAWS
    tolerance = "mu_d g dt^2 / 8 + eps t sqrt(t / dt) (distance), 1e-5 m (height), 1e-4 rad (tilt)"
    tolerance_reason = "as for 'stopping-distance'; the solver leaves penetrations of at most 1e-6 m"
    other_tolerance: ClassVar = {
        "soft": (
            "mu_d g h^2 / 8 + t (eps sqrt(t / dt) + u v t / h) (distance), 7/4 g / omega^2 + 1e-6 m (height), 1e-4 "
            "rad (tilt)",
            "as for 'stopping-distance'; a corner carries m g / 4 and yields by 7 / (m omega^2), omega h = 1.3, so a "
            "face sinks by 7/4 g / omega^2",
        ),
    }
    SPEED: ClassVar = 5.0
    DYNAMIC: ClassVar = 0.3

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Sheets of a tenth and of half of the way in a step."""
        v, mu = self.SPEED, self.DYNAMIC
        d, stop = v * v / (2.0 * mu * G), v / (mu * G)
        deep = {"micro": 1e-5}.get(solver, sink(solver, dt, 7.0 / 4.0))
        for share in (0.1, 0.5):
            world = make_world(solver, dt, static=mu)
            world.add(st.Plane(), static=True)
            thickness = share * v * dt
            start = (0.0, 0.0, 0.5 * thickness)
            sheet = world.add(st.Box((1.0, 1.0, thickness)), position=start, velocity=(0.6 * v, 0.8 * v, 0.0))
            low, tilt = 0.0, 0.0
            for _ in range(steps_for(1.2 * stop, dt)):
                world.step()
                low = min(low, float(sheet.position[2]) - 0.5 * thickness)
                tilt = max(tilt, turned_by((1, 0, 0, 0), sheet.orientation))
            what = f"thickness {share:g} v dt"
            slack = stop_error(solver, mu, mu, dt) + distance_error(solver, stop, dt, v)
            yield Measurement(f"distance, {what}", d, float(sheet.position @ (0.6, 0.8, 0.0)), slack, "m")
            yield Measurement(f"lowest height of the centre, {what}", 0.0, low, deep, "m")
            yield Measurement(f"largest tilt, {what}", 0.0, tilt, 1e-4, "rad")
