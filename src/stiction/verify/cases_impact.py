"""Impacts: heights of bounces, oblique hits with friction, two bodies and what they conserve, billiards, rods."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import (
    WEIGHTLESS,
    Array,
    G,
    about,
    box_inertia,
    make_world,
    matrix,
    product,
    rounding,
    soft_bounce,
    solver_tolerance,
    steps_for,
)

K = 0.4
"""I / (m r^2) of a solid sphere."""


class BouncingBall(Case):
    """Heights and speeds of the first bounces; and of a ball that loses nothing."""

    name = "bouncing-ball"
    title = "each bounce is e times as fast and e^2 times as high as the one before"
    formula = "v' = e v, h_n = e^(2 n) h0"
    source = "Newton's law of restitution"
    tolerance = "1e-9 (ratio of speeds), g dt^2 / 8 + 1e-9 h (height)"
    tolerance_reason = (
        "flight is a parabola to rounding, and a bounce is reckoned from where the surfaces meet, though it takes "
        "place in the step before; only the top of the flight may lie between two steps"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "1e-9 + 18 u (ratio of speeds), g dt^2 / 8 + 1e-9 h (height), u = 2^-24",
            "as for micro; and in a step with a contact single precision rounds the speed nine times, before the "
            "bounce and after",
        ),
    }
    RESTITUTION: ClassVar = 0.8
    HEIGHT: ClassVar = 1.0
    RADIUS: ClassVar = 0.1

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Three bounces with loss, ten without."""
        e, h = self.RESTITUTION, self.HEIGHT
        tops, ratios = self._drop(solver, dt, e, 3)
        sampling = G * dt * dt / 8.0
        for n, ratio in enumerate(ratios):
            slack = 1e-9 + 2.25 * rounding(solver, 1.0, dt, dt)
            yield Measurement(f"speed after bounce {n + 1} over speed before", e, ratio, slack)
        for n, top in enumerate(tops):
            yield Measurement(f"height of bounce {n + 1}", h * e ** (2 * n + 2), top, sampling + 1e-9, "m")
        tops, _ = self._drop(solver, dt, 1.0, 10)
        yield Measurement("height of bounce 10, e = 1", h, tops[-1], sampling + 1e-9, "m")

    def _drop(self, solver: str, dt: float, e: float, bounces: int) -> tuple[list[float], list[float]]:
        """Tops of the first bounces, m above the lowest position, and ratios of the speeds at the floor."""
        world = make_world(solver, dt, restitution=e)
        world.add(st.Plane(), static=True)
        ball = world.add(st.Sphere(self.RADIUS), position=(0, 0, self.RADIUS + self.HEIGHT))
        tops = [math.nan] * bounces
        ratios = [math.nan] * bounces
        n, before = -1, 0.0
        for _ in range(steps_for(20.0, dt)):
            gap = float(ball.position[2]) - self.RADIUS
            world.step()
            v, z = float(ball.velocity[2]), float(ball.position[2]) - self.RADIUS
            if before < 0.0 < v:
                n += 1
                if n == bounces:
                    break
                # both speeds as they are at the floor, from the height at which they were seen
                ratios[n] = math.sqrt((v * v + 2.0 * G * z) / (before * before + 2.0 * G * gap))
                tops[n] = 0.0
            if n >= 0:
                tops[n] = max(tops[n], z)
            before = v
        return tops, ratios


class ObliqueImpact(Case):
    """The contact point moves with u = v + w x r; friction stops it, if mu allows, and otherwise takes all it can."""

    name = "oblique-impact"
    title = "a sphere that hits a wall at an angle sticks or slides throughout, and leaves as Coulomb's law says"
    formula = (
        "sticks iff |u| < 7/2 mu (1 + e) v_n: v_t' = v_t - 2/7 u; else v_t' = v_t - mu (1 + e) v_n u / |u|; v_n' = e"
        " v_n"
    )
    source = "Coulomb's law for impulses; Brach, 'Mechanical Impact Dynamics' (1991), ch. 3"
    tolerance = "2 eps"
    tolerance_reason = "the impact is one contact, resolved at once; nothing depends on dt"
    RESTITUTION: ClassVar = 0.5
    MU: ClassVar = 0.25
    SPEED: ClassVar = 3.0
    RADIUS: ClassVar = 0.2

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Without gravity, against a wall that lies askew; at four multiples of the limit, with and without spin."""
        e, mu, vn, r = self.RESTITUTION, self.MU, self.SPEED, self.RADIUS
        t1, t2, n = _askew()
        limit = mu * (1.0 + e) * vn * (1.0 + K) / K
        for share, spin in ((0.5, 0.0), (0.99, 4.0), (1.01, -4.0), (2.0, 4.0)):
            world = make_world(solver, dt, static=mu, restitution=e, gravity=WEIGHTLESS)
            w = spin * (0.6 * t1 + 0.8 * t2)
            u = share * limit * (0.8 * t1 - 0.6 * t2)
            ball, vt = _hit_the_wall(world, r, u, vn, w)
            if share < 1.0:
                change = -u * K / (1.0 + K)
            else:
                change = -mu * (1.0 + e) * vn * u / np.linalg.norm(u)
            what = f"|u| = {share:g} of the limit, spin {spin:g} rad/s"
            slack = 2.0 * solver_tolerance(solver)
            v = ball.velocity
            expected = vt + change
            yield Measurement(f"normal speed, {what}", e * vn, float(v @ n), slack, "m/s")
            yield Measurement(f"speed along the wall, {what}", *_along(v - (v @ n) * n, expected), slack, "m/s")
            # the tangential impulse m * change acts at -r n: I (w' - w) = -r n x m change
            spun = w + np.cross(-n, change) / (K * r)
            yield Measurement(f"surface speed r w, {what}", *_along(r * ball.angular_velocity, r * spun), slack, "m/s")


def _askew() -> Array:
    """Two directions along a wall that lies askew, and its normal."""
    return matrix(product(about((1, 2, 0), 0.7), about((0, 0, 1), 0.3))).T


def _hit_the_wall(world: st.World, r: float, u: Array, vn: float, w: Array) -> tuple[st.Body, Array]:
    """A ball hits that wall with the slip ``u`` and the spin ``w``: the ball, and how fast it went along the wall."""
    n = _askew()[2]
    world.add(st.Plane(n), static=True)
    vt = u - np.cross(w, -r * n)
    ball = world.add(st.Sphere(r), position=r * n, velocity=vt - vn * n, angular_velocity=w)
    world.step()
    return ball, vt


def _along(measured: Array, expected: Array) -> tuple[float, float]:
    """Two vectors as two numbers: lengths along the expected one, off by the length of their difference."""
    size = float(np.linalg.norm(expected))
    return size, size + math.copysign(
        float(np.linalg.norm(measured - expected)), float((measured - expected) @ expected)
    )


class Superball(Case):
    """Its slip comes back: thrown under a table it returns to the hand, which sliding and rolling never do."""

    name = "superball"
    title = "a rough elastic ball reverses its slip where it hits, and comes back from under a table"
    formula = (
        "u = v + s, s = r w: v' = v - 2/7 (1 + e_t) u, s' = s - 5/7 (1 + e_t) u while 2/7 (1 + e_t) |u| < mu (1 + e) "
        "v_n, else friction is all of mu; floor, table, floor: v_3 = -333/343 v"
    )
    source = "Garwin, 'Kinematics of an Ultraelastic Rough Ball', Am. J. Phys. 37, 88 (1969)"
    tolerance = "2 eps an impact (speeds), 2 eps 3 m v more (energy)"
    tolerance_reason = "each impact is one contact, resolved at once; nothing depends on dt"
    other_tolerance: ClassVar = {
        "soft": (
            "2 eps + u v t / h (speeds), that times 3 m v (energy)",
            "as for micro; and single precision (u = 2^-24) rounds a speed in each substep",
        ),
    }
    RADIUS: ClassVar = 0.03
    SPEED: ClassVar = 4.0
    MU: ClassVar = 0.9

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Against a wall that lies askew, on both sides of friction's limit; then between floor and table."""
        mu, vn, r, eps = self.MU, self.SPEED, self.RADIUS, 2.0 * solver_tolerance(solver)
        t1, t2, n = _askew()
        for e, back in ((1.0, 1.0), (0.8, 0.5)):
            limit = mu * (1.0 + e) * vn * (1.0 + K) / (K * (1.0 + back))
            for share in (0.5, 0.99, 1.01, 2.0):
                world = make_world(
                    solver, dt, static=mu, restitution=e, tangential_restitution=back, gravity=WEIGHTLESS
                )
                w = 40.0 * (0.6 * t1 + 0.8 * t2)
                u = share * limit * (0.8 * t1 - 0.6 * t2)
                ball, vt = _hit_the_wall(world, r, u, vn, w)
                change = -min(1.0, 1.0 / share) * (1.0 + back) * K / (1.0 + K) * u
                what = f"e_t {back:g}, |u| = {share:g} of the limit"
                v, spun = ball.velocity, r * (w + np.cross(-n, change) / (K * r))
                along, surface = _along(v - (v @ n) * n, vt + change), _along(r * ball.angular_velocity, spun)
                slack = eps + rounding(solver, max(along[0], surface[0]), dt, dt)
                yield Measurement(f"speed along the wall, {what}", *along, slack, "m/s")
                yield Measurement(f"surface speed r w, {what}", *surface, slack, "m/s")

        world = make_world(solver, dt, static=mu, restitution=1.0, tangential_restitution=1.0, gravity=WEIGHTLESS)
        world.add(st.Plane((0, 0, 1)), static=True)
        world.add(st.Plane((0, 0, -1)), static=True, position=(0, 0, 0.7))
        ball = world.add(st.Sphere(r), mass=0.1, position=(0, 0, 0.3), velocity=(3.0, 0, -vn))
        before = ball.kinetic_energy
        # 0.27 m down, 0.64 m up, 0.64 m down, and some way up
        steps = steps_for(1.75 / vn, dt)
        world.step(steps)
        slack = 3.0 * eps + rounding(solver, 3.0 + vn, steps * dt, dt)
        yield Measurement("back from under the table", -3.0 * 333.0 / 343.0, float(ball.velocity[0]), slack, "m/s")
        slack *= 3.0 * ball.mass * (3.0 + vn)
        yield Measurement("energy after three impacts", before, ball.kinetic_energy, slack, "J")


class TwoBodies(Case):
    """A light sphere hits a heavy one, and a box a box, head on."""

    name = "two-bodies"
    title = "two bodies that collide head on exchange momentum as their masses and e say"
    formula = "v1' = (m1 - e m2) v1 / (m1 + m2), v2' = (1 + e) m1 v1 / (m1 + m2) for m2 at rest"
    source = "conservation of momentum and Newton's law of restitution"
    tolerance = "2 eps"
    tolerance_reason = "the impact is resolved within the solver's tolerance; nothing depends on dt"
    other_tolerance: ClassVar = {
        "soft": (
            "2 eps, and for e = 0 v beta h gamma / (1 + gamma), 0.22 % of v, more",
            "impacts with restitution are those of micro; without it a soft contact lets a share gamma / (1 + gamma) "
            "of the speed through for a substep (gamma = 1 / (w (20 + w)), w = 0.65), and pushes out what has sunk in "
            "at the rate beta = w / (20 + w) / h",
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Spheres for three restitutions, boxes face to face."""
        m1, m2, v = 1.0, 3.0, 4.0
        hard = 2.0 * solver_tolerance(solver)
        direction = np.array([0.6, 0.48, 0.64])
        for e in (0.0, 0.4, 1.0):
            slack = hard + (v * soft_bounce(solver) if e == 0.0 else 0.0)
            world = make_world(solver, dt, static=0.3, restitution=e, gravity=WEIGHTLESS)
            one = world.add(st.Sphere(0.2), mass=m1, velocity=v * direction)
            two = world.add(st.Sphere(0.3), mass=m2, position=direction)
            world.run(0.3)
            yield Measurement(
                f"spheres, e = {e:g}: v1'", (m1 - e * m2) * v / (m1 + m2), float(one.velocity @ direction), slack, "m/s"
            )
            yield Measurement(
                f"spheres, e = {e:g}: v2'", (1 + e) * m1 * v / (m1 + m2), float(two.velocity @ direction), slack, "m/s"
            )
        e, slack = 0.6, hard
        world = make_world(solver, dt, static=0.3, restitution=e, gravity=WEIGHTLESS)
        left = world.add(st.Box((0.4, 0.6, 0.5)), mass=m1, velocity=(v, 0, 0))
        right = world.add(st.Box((0.4, 0.8, 0.7)), mass=m2, position=(1, 0, 0))
        world.run(0.5)
        yield Measurement(
            f"boxes, e = {e:g}: v1'", (m1 - e * m2) * v / (m1 + m2), float(left.velocity[0]), slack, "m/s"
        )
        yield Measurement(
            f"boxes, e = {e:g}: v2'", (1 + e) * m1 * v / (m1 + m2), float(right.velocity[0]), slack, "m/s"
        )
        spin = max(float(np.linalg.norm(body.angular_velocity)) for body in (left, right))
        yield Measurement("boxes: spin that a hit face to face makes", 0.0, spin, slack, "rad/s")


class Momentum(Case):
    """An askew hit between boxes, with friction: everything changes but the two sums."""

    name = "momentum"
    title = "two boxes that hit each other askew, with friction, keep their momentum and angular momentum"
    formula = "sum m v and sum (x x m v + I w) do not change"
    source = "Newton's third law"
    tolerance = "1e-12 (momentum); s (w dt)^2 (angular momentum; s is the share of spin in it)"
    tolerance_reason = (
        "impulses come in pairs at one point, to rounding; the angular velocity of a step is held while the body "
        "turns by w dt, which leaves an error of second order in the direction of its spin"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "u (t / h) sum m |v| / |sum m v| (momentum); s (w dt)^2, and such a rounding, (angular momentum; s is the "
            "share of spin in it)",
            "single precision (u = 2^-24) rounds the velocities of two bodies near each other in each substep, and "
            "not in pairs; as for micro",
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Before the hit, just after it and half a second later."""
        world = make_world(solver, dt, static=0.4, dynamic=0.3, restitution=0.5, gravity=WEIGHTLESS)
        one = world.add(
            st.Box((1.0, 0.5, 0.4)), mass=3.0, position=(-1.2, 0.15, 0.1), velocity=(3.0, 0.4, -0.2),
            orientation=about((1, 1, 0), 0.4),
        )  # fmt: skip
        two = world.add(st.Box((0.6, 0.6, 0.6)), mass=5.0, velocity=(-1.0, 0.0, 0.3), orientation=about((0, 1, 1), 0.3))
        bodies = (one, two)

        def spin_of(b: st.Body) -> Array:
            turn = matrix(b.orientation)
            return np.asarray(turn @ b.inertia @ turn.T @ b.angular_velocity)

        def sums() -> tuple[Array, Array]:
            p, spin = np.zeros(3), np.zeros(3)
            for b in bodies:
                p = p + b.mass * b.velocity
                spin = spin + np.cross(b.position, b.mass * b.velocity) + spin_of(b)
            return p, spin

        before, lever = sums()
        hit = math.nan
        for _ in range(steps_for(1.0, dt)):
            world.step()
            if np.linalg.norm(one.angular_velocity) > 0.1:
                hit = 1.0
                break
        size, arm = float(np.linalg.norm(before)), float(np.linalg.norm(lever))
        share = sum(float(np.linalg.norm(spin_of(b))) for b in bodies) / arm
        w = max(float(np.linalg.norm(b.angular_velocity)) for b in bodies)
        p, spin = sums()
        moving = sum(b.mass * float(np.linalg.norm(b.velocity)) for b in bodies) / size
        single = rounding(solver, moving, world.time + 0.5, dt)
        exact, slack = 1e-12 + single, share * (w * dt) ** 2 + single
        yield Measurement("change of momentum by the hit", 0.0, hit * float(np.linalg.norm(p - before)) / size, exact)
        change = hit * float(np.linalg.norm(spin - lever)) / arm
        yield Measurement("change of angular momentum by the hit", 0.0, change, slack)
        world.run(0.5)
        p, spin = sums()
        yield Measurement("change of momentum 0.5 s later", 0.0, float(np.linalg.norm(p - before)) / size, exact)
        change = float(np.linalg.norm(spin - lever)) / arm
        yield Measurement("change of angular momentum 0.5 s later", 0.0, change, slack)


class BilliardThrow(Case):
    """The cue ball drags the object ball off the line of centres, as far as friction between them allows."""

    name = "billiard-throw"
    title = "the object ball leaves at an angle to the line of centres, and both balls get the same spin"
    formula = "tan(throw) = min(mu, tan(phi) / 7), r w = 5/2 v_t"
    source = (
        "Coulomb's law for impulses between equal spheres, e = 1; Alciatore, 'The Illustrated Principles of Pool and"
        " Billiards'"
    )
    tolerance = "10 eps / v_n (tan), 10 eps (speed)"
    tolerance_reason = "the impact is one contact, resolved at once; nothing depends on dt"
    MU: ClassVar = 0.06
    SPEED: ClassVar = 2.0
    RADIUS: ClassVar = 0.0286

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Cut angles at which the balls stick to each other, and at which they slide."""
        r, v = self.RADIUS, self.SPEED
        eps = 10.0 * solver_tolerance(solver)
        n, t, up = matrix(about((1, 2, 3), 0.8)).T
        for degrees in (10.0, 20.0, 30.0, 60.0):
            phi = math.radians(degrees)
            world = make_world(solver, dt, static=self.MU, restitution=1.0, gravity=WEIGHTLESS)
            speed = v * (math.cos(phi) * n + math.sin(phi) * t)
            cue = world.add(st.Sphere(r), position=-2.0 * r * n, velocity=speed)
            ball = world.add(st.Sphere(r))
            world.step()
            throw = min(self.MU, math.tan(phi) / 7.0)
            vn, vt = float(ball.velocity @ n), float(ball.velocity @ t)
            yield Measurement(f"tan(throw), cut {degrees:g} deg", throw, vt / vn, eps / vn)
            spin = 2.5 * throw * v * math.cos(phi)
            for name, body in (("object ball", ball), ("cue ball", cue)):
                # both are dragged at the side that faces the other one, so both turn the same way
                w = float(body.angular_velocity @ -up) * r
                yield Measurement(f"r w of the {name}, cut {degrees:g} deg", spin, w, eps, "m/s")


class NewtonsCradle(Case):
    """Gaps of 1 mm, so that the balls hit one after the other and the textbook's answer is the only one."""

    name = "newtons-cradle"
    title = "k balls hit a row of resting ones and k balls leave on the other side"
    formula = "equal masses, e = 1: each pair swaps its velocities"
    source = "conservation of momentum and energy"
    tolerance = "10 eps"
    tolerance_reason = "every impact is resolved within the solver's tolerance; nothing depends on dt"

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """One ball and two balls on five."""
        r, gap, v = 0.05, 1e-3, 1.0
        slack = 10.0 * solver_tolerance(solver)
        for k in (1, 2):
            world = make_world(solver, dt, static=0.1, restitution=1.0, gravity=WEIGHTLESS)
            row = [world.add(st.Sphere(r), position=((2 * r + gap) * i, 0, 0)) for i in range(5)]
            for ball in row[:k]:
                ball.position = ball.position - (0.1, 0, 0)
                ball.velocity = (v, 0, 0)
            world.run(0.5)
            gone = [float(ball.velocity[0]) for ball in row]
            yield Measurement(f"{k} in: slowest of the {k} that leave", v, min(gone[-k:]), slack, "m/s")
            rest = max(abs(x) for x in gone[:-k])
            yield Measurement(f"{k} in: fastest of the {5 - k} that stay", 0.0, rest, slack, "m/s")


class RodImpact(Case):
    """Seen from the side a board is a rod: the edge that hits turns back with e, the centre with less."""

    name = "rod-impact"
    title = "a tilted board that hits the floor with one edge leaves as its moment of inertia says"
    formula = "K g = (1 + e) u with K = [[1/m + x^2/I, -x z/I], [-x z/I, 1/m + z^2/I]]; without friction g_t = 0"
    source = (
        "impulse and angular impulse; Stronge, 'Impact Mechanics' (2000), ch. 3; Newton's restitution, Coulomb's law"
    )
    tolerance = "10 eps (speeds)"
    tolerance_reason = "the impact is resolved within the solver's tolerance; nothing depends on dt"
    LENGTH: ClassVar = 1.0
    WIDTH: ClassVar = 0.04
    EDGE: ClassVar = 0.1

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Frictionless at three angles; with so much friction that the end sticks at two."""
        speed, e = 2.0, 0.7
        slack = 10.0 * solver_tolerance(solver)
        for degrees, mu in ((20.0, 0.0), (45.0, 0.0), (70.0, 0.0), (60.0, 3.0), (75.0, 3.0)):
            angle = math.radians(degrees)
            world = make_world(solver, dt, static=mu, restitution=e, gravity=WEIGHTLESS)
            world.add(st.Plane(), static=True)
            q = about((0, 1, 0), -angle)
            corner = matrix(q) @ np.array([-0.5 * self.LENGTH, 0.0, -0.5 * self.WIDTH])
            rod = world.add(
                st.Box((self.LENGTH, self.EDGE, self.WIDTH)), mass=2.0, position=(0, 0, -corner[2]), orientation=q,
                velocity=(0, 0, -speed),
            )  # fmt: skip
            m, inertia = rod.mass, float(box_inertia(rod.mass, (self.LENGTH, self.EDGE, self.WIDTH))[1])
            x, z = float(corner[0]), float(corner[2])
            world.step()
            normal = 1.0 / m + x * x / inertia
            mixed, planar = -x * z / inertia, 1.0 / m + z * z / inertia
            if mu == 0.0:
                gn, gt = (1.0 + e) * speed / normal, 0.0
            else:  # the end aims at e times its normal speed and at no planar speed
                gn = (1.0 + e) * speed / (normal - mixed * mixed / planar)
                gt = -mixed / planar * gn
            what = f"{degrees:g} deg, mu = {mu:g}"
            yield Measurement(f"speed upwards, {what}", gn / m - speed, float(rod.velocity[2]), slack, "m/s")
            yield Measurement(f"speed sideways, {what}", gt / m, float(rod.velocity[0]), slack, "m/s")
            yield Measurement(f"speed along the edge, {what}", 0.0, float(rod.velocity[1]), slack, "m/s")
            spin = (z * gt - x * gn) / inertia
            yield Measurement(
                f"L w, {what}", spin * self.LENGTH, float(rod.angular_velocity[1]) * self.LENGTH, slack, "m/s"
            )


class ImpactEnergy(Case):
    """Newton's restitution with friction can create energy (Kane and Levinson, 1985); an engine must not let it."""

    name = "impact-energy"
    title = "no impact of a tumbling rod creates energy, whatever friction and restitution are"
    formula = "E' <= E"
    source = "second law; Stronge, 'Rigid body collisions with friction', Proc. R. Soc. A 431 (1990)"
    tolerance = "1e-9 of E"
    tolerance_reason = "an inequality, which leaves room for rounding only"
    other_tolerance: ClassVar = {
        "soft": (
            "1e-9 + 18 u of E, u = 2^-24",
            "as for micro; after the impact single precision rounds each velocity nine times in that step, and E has "
            "their squares",
        ),
    }

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """400 rods that differ in angle, speed and spin, for three pairs of e and mu."""
        for e, mu in ((1.0, 0.3), (1.0, 0.9), (0.8, 0.5)):
            world = make_world(solver, dt, static=mu, restitution=e, gravity=WEIGHTLESS)
            world.add(st.Plane(), static=True)
            rods = []
            for k in range(400):
                # a low-discrepancy sequence (golden ratios): the same rods on every run, and no two alike
                a, b, c = ((k + 0.5) * g % 1.0 for g in (0.8191725134, 0.6710436067, 0.5497004779))
                angle = 0.1 + 1.3 * a
                q = about((0, 1, 0), -angle)
                corner = matrix(q) @ np.array([-0.5, 0.0, -0.03])
                rod = world.add(
                    st.Box((1.0, 0.08, 0.06)),
                    position=(3.0 * (k % 20), 3.0 * (k // 20), -corner[2]),
                    orientation=q,
                    velocity=(6.0 * b - 3.0, 0.5, -1.0 - 2.0 * c),
                    angular_velocity=(0.3, 8.0 * c * b - 4.0 * a, 0.2),
                )
                rods.append(rod)
            before = np.array([rod.kinetic_energy for rod in rods])
            world.step()
            after = np.array([rod.kinetic_energy for rod in rods])
            gain = float(np.max(after / before - 1.0))
            slack = 1e-9 + 2.25 * rounding(solver, 1.0, dt, dt)
            yield Measurement(f"largest gain of 400, e = {e:g}, mu = {mu:g}", 0.0, max(gain, 0.0), slack)
            hit = float(np.mean(after != before))
            yield Measurement(f"share of rods that were hit, e = {e:g}, mu = {mu:g}", 1.0, hit, 0.01)
