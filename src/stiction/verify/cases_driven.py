"""What drives do: belts, plates that accelerate, turntables, pushes, a block pulled from under another, stick-slip."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    GRAVITY,
    G,
    arrival,
    begin_error,
    delay,
    distance_error,
    lean,
    make_world,
    rounding,
    slip_speed,
    speed_error,
    steps_for,
    stop_error,
    substep,
    turned_by,
)

LAWS = "Newton's second law and Coulomb's law"
K = 0.4
"""I / (m r^2) of a solid sphere."""


class BeltDrop(Case):
    """A belt spends as much on heat as it gives to the parcel."""

    name = "belt-drop"
    title = "a parcel put on a running belt slips until it goes along: how long, how far, how much heat"
    formula = "t = V / (mu_d g), slip = V^2 / (2 mu_d g), heat = m V^2 / 2, work of the belt = m V^2"
    source = LAWS
    tolerance = (
        "mu_d g dt^2 / 8 + eps t sqrt(t / dt) (slip), eps sqrt(t / dt) / (mu_d g) (time), m V eps sqrt(t / dt) (energy)"
    )
    tolerance_reason = "slip ends within a step, not at its end; and the solver's tolerance enters in every step"
    other_tolerance: ClassVar = {
        "soft": (
            "mu_d g h^2 / 8 + 7/4 (g / omega^2) H / b + e t (slip), e / (mu_d g) (time), 2 m V e (energy); e = eps "
            "sqrt(t / dt) + u V t / h",
            "slip ends within a substep, and the parcel straightens up (see 'stopping-distance'); single precision (u "
            "= 2^-24) rounds the speed in each substep, the same way",
        ),
    }
    BELT: ClassVar = 2.0
    STATIC: ClassVar = 0.5
    MU: ClassVar = 0.35

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The belt is a static plane with a surface velocity."""
        v, mu, m = self.BELT, self.MU, 4.0
        world = make_world(solver, dt, static=self.STATIC, dynamic=mu)
        world.add(st.Plane(), static=True, surface_velocity=(v, 0, 0))
        parcel = world.add(st.Box((0.4, 0.3, 0.2)), mass=m, position=(0, 0, 0.1))
        slips = v / (mu * G)
        behind = [v]
        for _ in range(steps_for(1.5 * slips, dt)):
            world.step()
            behind.append(v - float(parcel.velocity[0]))
        eps = speed_error(solver, slips, dt, v)
        yield Measurement("time of slip", slips, arrival(behind, dt), eps / (mu * G), "s")
        slip = v * world.time - float(parcel.position[0])
        within_step = stop_error(solver, self.STATIC, mu, dt) + lean(solver, dt, 0.2, 0.3)
        yield Measurement("length of slip", 0.5 * v * slips, slip, within_step + eps * slips, "m")
        energy = world.energy()
        yield Measurement("heat", 0.5 * m * v * v, energy.friction, 2.0 * m * v * eps, "J")
        yield Measurement("work of the belt", m * v * v, energy.work, 2.0 * m * v * eps, "J")


class BeltCrossing(Case):
    """Seen from the belt the parcel slides straight; seen from the floor its path is bent."""

    name = "belt-crossing"
    title = "a parcel pushed across a belt gets as far as its speed relative to the belt allows"
    formula = "across = v u / (2 mu_d g), along = V u / (2 mu_d g) behind the belt, u = sqrt(v^2 + V^2)"
    source = LAWS
    tolerance = "mu_d g dt^2 / 8 + eps t sqrt(t / dt)"
    tolerance_reason = (
        "the parcel comes to rest on the belt within a step; and the solver's tolerance enters in every step"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "mu_d g h^2 / 8 + 7/4 (g / omega^2) H / b + t (eps sqrt(t / dt) + u u_0 t / h), u_0 the speed relative to "
            "the belt",
            "the parcel comes to rest within a substep, and straightens up (see 'stopping-distance'); single "
            "precision (u = 2^-24) rounds its speed in each substep, the same way",
        ),
    }
    BELT: ClassVar = 1.5
    ACROSS: ClassVar = 2.0
    MU: ClassVar = 0.4

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The parcel is oblong and askew, and must not turn."""
        v, belt, mu = self.ACROSS, self.BELT, self.MU
        world = make_world(solver, dt, static=mu)
        world.add(st.Plane(), static=True, surface_velocity=(belt, 0, 0))
        parcel = world.add(
            st.Box((0.5, 0.2, 0.2)), position=(0, 0, 0.1), orientation=(math.cos(0.2), 0, 0, math.sin(0.2)),
            velocity=(0, v, 0),
        )  # fmt: skip
        start = parcel.orientation
        u = math.hypot(v, belt)
        stop = u / (mu * G)
        world.run(1.2 * stop)
        slack = stop_error(solver, mu, mu, dt) + lean(solver, dt, 0.2, 0.2) + distance_error(solver, stop, dt, u)
        yield Measurement("distance across the belt", v * u / (2.0 * mu * G), float(parcel.position[1]), slack, "m")
        behind = belt * world.time - float(parcel.position[0])
        yield Measurement("distance behind the belt", belt * u / (2.0 * mu * G), behind, slack, "m")
        turn = turned_by(start, parcel.orientation)
        yield Measurement("turn", 0.0, turn, 10.0 * distance_error(solver, stop, dt, u), "rad")


class AcceleratingPlate(Case):
    """Contrary to first thought a ball on a plate that speeds up rolls backwards on it but forwards in the room."""

    name = "accelerating-plate"
    title = "a ball on an accelerating plate follows with 2/7 of its acceleration, or with mu g when it slips"
    formula = "a = 2/7 A if 2/7 A < mu_s g, else a = mu_d g"
    source = LAWS
    tolerance = "eps sqrt(t / dt)"
    tolerance_reason = "the plate's velocity is set once a step, and the ball has followed it when the step ends"
    other_tolerance: ClassVar = {
        "soft": (
            "eps sqrt(t / dt) + u v t / h + 4 h |2/7 A - mu_d g| (the last where it slips)",
            "single precision (u = 2^-24) rounds the speed in each substep; and it takes up to 4 h until slip is seen",
        ),
    }
    MU: ClassVar = 0.3

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Three accelerations: well below, 1 % below and 1 % above the one at which the ball slips."""
        limit = self.MU * G * (1.0 + K) / K
        for share in (0.2, 0.99, 1.01):
            world = make_world(solver, dt, static=self.MU)
            plate = world.add(st.Plane(), kinematic=True)
            ball = world.add(st.Sphere(0.2), position=(0, 0, 0.2))
            a = share * limit
            steps = steps_for(1.5, dt)
            for k in range(1, steps + 1):
                plate.velocity = (0.6 * a * k * dt, 0.8 * a * k * dt, 0.0)
                world.step()
            t = steps * dt
            speed = a * t * K / (1.0 + K) if share < 1.0 else self.MU * G * t
            seen = float(ball.velocity @ (0.6, 0.8, 0.0))
            slack = speed_error(solver, t, dt, speed)
            if share >= 1.0:
                slack += delay(solver, dt) * abs(a * K / (1.0 + K) - self.MU * G)
            yield Measurement(f"speed after {t:g} s, A = {a:.4g} m/s^2", speed, seen, slack, "m/s")


class CrateOnLorry(Case):
    """The crate on a lorry."""

    name = "crate-on-lorry"
    title = "a crate goes along with a lorry up to A = mu_s g, and beyond that with mu_d g"
    formula = "a = A if A < mu_s g, else a = mu_d g"
    source = LAWS + " with two coefficients"
    tolerance = "20 eps (held), eps sqrt(t / dt) (slipping), A t dt / 2 + 20 eps t (moved over the lorry)"
    tolerance_reason = (
        "the lorry's velocity is set once a step, and the crate has followed it when the step ends; but the lorry has "
        "gone with its new velocity all the step, the crate with the mean of its old and new one"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "20 eps + u v t / h (held), 4 h (A - mu_d g) + eps sqrt(t / dt) + u v t / h (slipping), A t dt / 2 + 20 "
            "eps t (moved over the lorry)",
            "beyond the limit by 2 % it lets go up to 4 h late, and has kept up with the lorry until then; single "
            "precision (u = 2^-24) rounds the speed in each substep; and as for micro",
        ),
    }
    STATIC: ClassVar = 0.5
    DYNAMIC: ClassVar = 0.3

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """2 % below and above, along and askew."""
        for share, heading in ((0.98, 0.0), (0.98, 0.6), (1.02, 0.0), (1.02, 0.6)):
            world = make_world(solver, dt, static=self.STATIC, dynamic=self.DYNAMIC)
            lorry = world.add(st.Plane(), kinematic=True)
            crate = world.add(st.Box((1.0, 0.8, 0.5)), position=(0, 0, 0.25))
            direction = np.array([math.cos(heading), math.sin(heading), 0.0])
            a = share * self.STATIC * G
            steps = steps_for(2.0, dt)
            for k in range(1, steps + 1):
                lorry.velocity = a * k * dt * direction
                world.step()
            t = steps * dt
            held = share < 1.0
            speed = a * t if held else self.DYNAMIC * G * t
            slack = 20.0 * speed_error(solver, dt, dt) + rounding(solver, speed, t, dt)
            if not held:
                slack = speed_error(solver, t, dt, speed) + delay(solver, dt) * (a - self.DYNAMIC * G)
            what = f"speed after {t:g} s, A = {share:g} mu_s g, heading {heading:g} rad"
            yield Measurement(what, speed, float(crate.velocity @ direction), slack, "m/s")
            if held:
                moved = float((crate.position - lorry.position) @ direction)
                what = f"moved over the lorry in {t:g} s, heading {heading:g} rad"
                yield Measurement(what, 0.0, moved, 0.5 * a * t * dt + slack * t, "m")


class BallOnTurntable(Case):
    """A ball that rolls on a turntable goes in circles, two for every seven of the table, wherever it is."""

    name = "ball-on-turntable"
    title = "a ball rolling on a turntable runs in a circle at 2/7 of the table's rate"
    formula = "v' = 2/7 W x v"
    source = (
        LAWS + "; Weltner, 'Stable circular orbits of freely moving balls on rotating discs', Am. J. Phys. 47 (1979)"
    )
    tolerance = "exp(w^2 t h) - 1 with w = 2/7 W, of the speed, and in rad; h = dt, or dt / 8 in soft"
    tolerance_reason = (
        "the table's velocity under the ball is that of the start of a step, or of a substep in soft, so that v gains a"
        " part (w h)^2 in each; the circle opens by that much"
    )
    RATE: ClassVar = 3.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Two seconds, in which the ball runs through a quarter of its circle."""
        rate, r = self.RATE, 0.1
        world = make_world(solver, dt, static=0.8)
        world.add(st.Plane(), kinematic=True, angular_velocity=(0, 0, rate))
        x, v = np.array([0.5, 0.0, r]), np.array([0.0, 0.9, 0.0])
        # rolling from the start: v - r w x z = W x x
        slip = v - np.cross((0.0, 0.0, rate), (0.5, 0.0, 0.0))
        ball = world.add(st.Sphere(r), position=x, velocity=v, angular_velocity=np.cross((0, 0, 1), slip) / r)
        steps = steps_for(2.0, dt)
        t = steps * dt
        world.step(steps)
        w = rate * K / (1.0 + K)
        now = ball.velocity
        # from the y axis, where it began, over less than half a circle
        speed, turned = float(np.linalg.norm(now)), math.atan2(-now[0], now[1])
        slack = math.expm1(w * substep(solver, dt) * w * t)
        yield Measurement("turn of the velocity", w * t, turned, slack, "rad")
        yield Measurement("speed", 0.9, speed, 0.9 * slack, "m/s")


class CrateOnTurntable(Case):
    """Friction must supply the centripetal acceleration."""

    name = "crate-on-turntable"
    title = "a crate on a turntable goes round with it up to W^2 R = mu_s g, and is flung off beyond"
    formula = "W^2 R = mu_s g"
    source = LAWS
    tolerance = "mu_s g dt t (held); a step of 2 % (threshold)"
    tolerance_reason = (
        "the table's velocity under the crate is that of the start of a step, so that a crate that sticks still "
        "leaves its circle by W^2 R dt a second"
    )
    STATIC: ClassVar = 0.5
    DYNAMIC: ClassVar = 0.3
    RATE: ClassVar = 0.8
    SECONDS: ClassVar = 0.5

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Radii in steps of 2 % of the largest one that should hold."""
        limit = self.STATIC * G / self.RATE**2
        moved = {}
        for percent in (96, 98, 102, 104):
            world = make_world(solver, dt, static=self.STATIC, dynamic=self.DYNAMIC)
            world.add(st.Plane(), kinematic=True, angular_velocity=(0, 0, self.RATE))
            radius = limit * percent / 100.0
            crate = world.add(
                st.Box((0.6, 0.6, 0.2)), position=(radius, 0, 0.1), velocity=(0, self.RATE * radius, 0),
                angular_velocity=(0, 0, self.RATE),
            )  # fmt: skip
            world.run(self.SECONDS)
            t = self.RATE * world.time
            moved[percent] = float(np.linalg.norm(crate.position - (radius * math.cos(t), radius * math.sin(t), 0.1)))
        slack = self.STATIC * G * dt * self.SECONDS
        yield Measurement("moved over the table at 96 % of the limit", 0.0, moved[96], slack, "m")
        yield Measurement("moved over the table at 98 % of the limit", 0.0, moved[98], slack, "m")
        slides = min((percent for percent, d in moved.items() if d > slack + 0.1), default=math.nan)
        yield Measurement("smallest radius at which it slides, of the limit", 102.0, slides, 1.0, "%")


class PushAndRelease(Case):
    """The lecture's question: what happens to a static and to a moving object if we stop exerting a force?"""

    name = "push-and-release"
    title = "a crate pushed with less than mu_s N stays; pushed with more it goes; released it slows down at mu_d g"
    formula = "F < mu_s m g: at rest; else a = F / m - mu_d g, then after release d = v^2 / (2 mu_d g)"
    source = LAWS + " with two coefficients; the lecture's slide 'Dynamic friction - Part 2'"
    tolerance = (
        "20 eps t (held), eps t sqrt(t / dt) (pushed), g dt^2 max(mu_d / 8, mu_s (mu_s - mu_d) / (2 mu_d)) more "
        "(released)"
    )
    tolerance_reason = (
        "a crate that holds may creep with the solver's tolerance; one that stops does so within a step, and mu_s "
        "may hold it a little before"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "20 eps t (held); for the speed v = a t: e = eps sqrt(t / dt) + u v t / h + 4 h a (the last for 1.05 mu_s "
            "m g); e t + a h dt / 2 (pushed), 2 e v / (mu_d g) + mu_d g h^2 / 8 + 7/4 (g / omega^2) H / b (released)",
            "beyond the limit by less than an eighth it lets go up to 4 h late; single precision (u = 2^-24) rounds "
            "the speed in each substep; in the step in which it begins to slide it moves with new velocities instead "
            "of the mean; and it leans over (see 'stopping-distance')",
        ),
    }
    STATIC: ClassVar = 0.5
    DYNAMIC: ClassVar = 0.3
    SECONDS: ClassVar = 1.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Pushed for 1 s, then left alone for 2 s."""
        m, mu_s, mu_d = 20.0, self.STATIC, self.DYNAMIC
        steps = steps_for(self.SECONDS, dt)
        t = steps * dt
        for share in (0.5, 0.98, 1.05, 1.5):
            world = make_world(solver, dt, static=mu_s, dynamic=mu_d)
            world.add(st.Plane(), static=True)
            crate = world.add(st.Box((0.8, 0.6, 0.4)), mass=m, position=(0, 0, 0.2))
            force = share * mu_s * m * G
            for _ in range(steps):
                crate.apply_force((0.8 * force, 0.6 * force, 0.0))
                world.step()
            pushed = float(crate.position @ (0.8, 0.6, 0.0))
            speed = float(crate.velocity @ (0.8, 0.6, 0.0))
            world.run(2.0)
            after = float(crate.position @ (0.8, 0.6, 0.0)) - pushed
            what = f"pushed with {share:g} mu_s m g"
            if share < 1.0:
                slack = 20.0 * speed_error(solver, dt, dt)
                yield Measurement(f"distance while {what}", 0.0, pushed, slack * t, "m")
                yield Measurement(f"distance after release, {what}", 0.0, after, slack * 2.0, "m")
                continue
            a = force / m - mu_d * G
            v = a * t
            eps = speed_error(solver, t, dt, v) + (delay(solver, dt) * a if share < 1.125 else 0.0)
            slack = eps * t + begin_error(solver, a, dt) + lean(solver, dt, 0.4, 0.6)
            yield Measurement(f"distance while {what}", 0.5 * a * t * t, pushed, slack, "m")
            yield Measurement(f"speed when released, {what}", v, speed, eps, "m/s")
            stop = v / (mu_d * G)
            slack = stop_error(solver, mu_s, mu_d, dt) + lean(solver, dt, 0.4, 0.6) + 2.0 * eps * stop
            yield Measurement(f"distance after release, {what}", 0.5 * v * stop, after, slack, "m")


class PushToTip(Case):
    """Width b, pushed at the height y: a cupboard that is pushed high tips, and slides when it is pushed low."""

    name = "push-to-tip"
    title = "a box pushed at the height y tips once F y > m g b / 2, if it does not slide before"
    formula = "tips at F = m g b / (2 y) if mu_s > b / (2 y), else slides at F = mu_s m g"
    source = "balance of moments about the far edge, and Coulomb's law"
    tolerance = "a step of 1 % (force); 1e-3 rad, 20 eps t (at rest)"
    tolerance_reason = (
        "1 s after the force set in, a box that is 0.5 % beyond the threshold has tipped by more than 1e-2 rad, one "
        "that is 0.5 % below it by what the solver leaves of penetrations"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "a step of 1 % (force); 1e-3 rad (tilt), 20 eps t + 7/4 (g / omega^2) H / b (at rest), 4 h a t + a h dt / "
            "2 + t (eps sqrt(t / dt) + u v t / h) (sliding)",
            "as for micro; an edge that carries all sinks by 7/2 g / omega^2, omega h = 1.3, at most, and the box "
            "leans over by H / (2 b) of that; beyond the limit by less than an eighth it lets go up to 4 h late",
        ),
    }
    SECONDS: ClassVar = 1.0
    WIDTH: ClassVar = 0.5
    HEIGHT: ClassVar = 1.2
    AT: ClassVar = 1.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Forces in steps of 1 % from both sides; then a slippery floor."""
        lever = self.WIDTH / (2.0 * self.AT)

        def run(mu: float, force: float) -> tuple[float, float]:
            world = make_world(solver, dt, static=mu)
            world.add(st.Plane(), static=True)
            box = world.add(st.Box((self.WIDTH, 0.6, self.HEIGHT)), mass=10.0, position=(0, 0, 0.5 * self.HEIGHT))
            upright = box.orientation
            above = np.array([0.0, 0.0, self.AT - 0.5 * self.HEIGHT])
            for _ in range(steps_for(self.SECONDS, dt)):
                box.apply_force((force * 10.0 * G, 0, 0), at=box.position + above)
                world.step()
            return turned_by(upright, box.orientation), float(box.position[0])

        tilts = {k + 0.5: run(0.6, lever * (k + 0.5) / 100.0)[0] for k in range(97, 103)}
        stands = max((p for p, tilt in tilts.items() if tilt < 1e-3), default=math.nan)
        tips = min((p for p, tilt in tilts.items() if tilt > 5e-3), default=math.nan)
        yield Measurement("largest force that it stands, of the threshold", 99.5, stands, 0.5, "%")
        yield Measurement("smallest force that tips it, of the threshold", 100.5, tips, 0.5, "%")
        mu = 0.8 * lever
        tilt, moved = run(mu, 0.9 * mu)
        slack = 20.0 * speed_error(solver, dt, dt) + lean(solver, dt, self.HEIGHT, self.WIDTH)
        yield Measurement("slippery floor, F = 0.9 mu_s m g: distance", 0.0, moved, slack, "m")
        tilt, moved = run(mu, 1.1 * mu)
        t = steps_for(self.SECONDS, dt) * dt
        yield Measurement("slippery floor, F = 1.1 mu_s m g: tilt", 0.0, tilt, 1e-3, "rad")
        d = 0.05 * mu * G * t * t
        a = 0.1 * mu * G
        slack = distance_error(solver, t, dt, a * t) + begin_error(solver, a, dt) + delay(solver, dt) * a * t
        yield Measurement("slippery floor, F = 1.1 mu_s m g: distance", d, moved, slack, "m")


class PulledBlock(Case):
    """The trick with the tablecloth."""

    name = "pulled-block"
    title = "a board is pulled from under a block once the force is above (mu_12 + mu_floor) (m1 + m2) g"
    formula = "together a = (F - mu_f M g) / M up to F = (mu_s,12 + mu_f) M g; then the block follows with mu_d,12 g"
    source = LAWS + " for both bodies"
    tolerance = "20 eps sqrt(t / dt) (speeds)"
    tolerance_reason = (
        "constant forces are integrated exactly, which leaves the solver's tolerance, in eight contacts that share a"
        " body"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "20 eps sqrt(t / dt) + u v t / h (speeds), and at 1.02 of the threshold 4 h times the change of "
            "acceleration",
            "as for micro; single precision (u = 2^-24) rounds speeds in each substep; and beyond the limit by less "
            "than an eighth the block keeps up with the board for up to 4 h",
        ),
    }
    BETWEEN: ClassVar = (0.5, 0.3)
    FLOOR: ClassVar = 0.2
    SECONDS: ClassVar = 0.35

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """2 % below and 2 % above the force, and twice as much."""
        m1, m2 = 4.0, 2.0
        total = m1 + m2
        static, dynamic = self.BETWEEN
        for share in (0.98, 1.02, 2.0):
            table = st.MaterialTable()
            table.set_pair("board", "floor", static=self.FLOOR, dynamic=self.FLOOR)
            table.set_pair("board", "block", static=static, dynamic=dynamic)
            world = st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)
            world.add(st.Plane(), static=True, material="floor")
            board = world.add(st.Box((3.0, 1.0, 0.1)), mass=m1, position=(0, 0, 0.05), material="board")
            block = world.add(st.Box((0.4, 0.4, 0.2)), mass=m2, position=(0, 0, 0.2), material="block")
            force = share * (static + self.FLOOR) * total * G
            steps = steps_for(self.SECONDS, dt)
            for _ in range(steps):
                board.apply_force((force, 0, 0))
                world.step()
            t = steps * dt
            if share < 1.0:
                a1 = a2 = force / total - self.FLOOR * G
            else:
                a1, a2 = (force - self.FLOOR * total * G - dynamic * m2 * G) / m1, dynamic * G
            what = f"F = {share:g} of the threshold"
            for name, body, a in (("block", block, a2), ("board", board, a1)):
                slack = 20.0 * speed_error(solver, t, dt) + rounding(solver, a * t, t, dt)
                if share == 1.02:
                    slack += delay(solver, dt) * abs(force / total - self.FLOOR * G - a)
                yield Measurement(f"speed of the {name}, {what}", a * t, float(body.velocity[0]), slack, "m/s")


class StickSlip(Case):
    """A block on a belt, held by a spring, creaks like a door: it needs both coefficients, and both switches."""

    name = "stick-slip"
    title = "a block on a slow belt, held by a spring, sticks and slips in turn with a known period"
    formula = (
        "T = 2 D / V + (2 pi - 2 atan(D w / V)) / w, amplitude sqrt(D^2 + (V / w)^2); D = (mu_s - mu_d) m g / k, w ="
        " sqrt(k / m)"
    )
    source = LAWS + " with two coefficients; Rabinowicz, 'Friction and Wear of Materials', ch. 4"
    tolerance = "2 (dt + sqrt(2 s m / (k V))) (period), V (dt + sqrt(2 s m / (k V))) (amplitude)"
    tolerance_reason = (
        "the block lets go at the end of a step, and when its slip under a force that grows by k V has reached the s "
        "(m/s) below which a solver takes it for none; the belt stretches the spring with V all the while, and has to "
        "make up for it twice"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "2 (dt + 4 h) (period), V (dt + 4 h) (amplitude)",
            "the spring's force is set once a step, and the block lets go when three substeps running have seen it "
            "beyond the limit; the belt stretches the spring with V all the while, and has to make up for it twice",
        ),
    }
    STATIC: ClassVar = 0.6
    DYNAMIC: ClassVar = 0.3
    BELT: ClassVar = 0.1
    STIFFNESS: ClassVar = 25.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The spring's force is set once a step, from where the block will be in the middle of it."""
        m, k, v = 1.0, self.STIFFNESS, self.BELT
        world = make_world(solver, dt, static=self.STATIC, dynamic=self.DYNAMIC)
        world.add(st.Plane(), static=True, surface_velocity=(v, 0, 0))
        block = world.add(st.Box((0.3, 0.3, 0.1)), mass=m, position=(0, 0, 0.05))
        w = math.sqrt(k / m)
        gap = (self.STATIC - self.DYNAMIC) * m * G / k
        period = 2.0 * gap / v + (2.0 * math.pi - 2.0 * math.atan(gap * w / v)) / w
        centre = self.DYNAMIC * m * G / k
        places = [0.0]
        for _ in range(steps_for(5.0 * period + self.STATIC * m * G / (k * v), dt)):
            x = float(block.position[0]) + 0.5 * dt * float(block.velocity[0])
            block.apply_force((-k * x, 0, 0))
            world.step()
            places.append(float(block.position[0]))
        # it passes the centre once a period on its way up, stuck to the belt and so at constant speed
        passes = [
            i + (centre - places[i]) / (places[i + 1] - places[i])
            for i in range(len(places) - 1)
            if places[i] < centre <= places[i + 1]
        ]
        turns = len(passes) - 2
        measured = (passes[-1] - passes[1]) / turns * dt if turns > 0 else math.nan
        late = dt + (math.sqrt(2.0 * slip_speed() * m / (k * v)) if solver == "micro" else delay(solver, dt))
        yield Measurement("period", period, measured, 2.0 * late, "s")
        slack = v * late
        steady = places[int(passes[1]) :] if turns > 0 else [math.nan]
        amplitude = math.hypot(gap, v / w)
        yield Measurement("amplitude, forwards", amplitude, max(steady) - centre, slack, "m")
        yield Measurement("amplitude, backwards", amplitude, centre - min(steady), slack, "m")
