"""Statics that friction decides: a wedge, two cards, three logs, an arch; each has a threshold with two sides."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import ClassVar

import numpy as np

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.cases_slopes import threshold_rows
from stiction.verify.setups import GRAVITY, Array, G, about, make_world, sink, steps_for


class Wedge(Case):
    """What holds a door open, and what splits a log."""

    name = "wedge"
    title = "a loaded wedge stays under its load up to twice the angle of friction, and is driven in beyond a force"
    formula = (
        "stays iff Q tan(alpha - phi) < mu (Q + W), tan(phi) = mu; goes in iff P > Q tan(alpha + phi) + mu (Q + W)"
    )
    source = (
        "balance of forces on wedge and load, friction at both faces of the wedge, none at the wall; for W = 0 "
        "it stays "
        "iff alpha < 2 phi"
    )
    tolerance = "0.05 deg: the neighbours of the threshold among the multiples of 0.1 deg, exactly; 1 % (force)"
    tolerance_reason = (
        "a tenth of a degree beyond the threshold a wedge accelerates with 0.01 m/s^2, which is centimetres after two "
        "seconds; forces are tried at 1 % on either side, and where they hold the wedge may have moved by what the "
        "penetration of 1e-6 m lets it"
    )
    other_tolerance: ClassVar = {
        "soft": (
            "0.05 deg: as for micro; 1 % (force), (5 Q / W + 1) g / omega^2 / tan(alpha) (moved)",
            "as for micro; but springs carry the load: that of the floor, and one four times as soft between "
            "wedge and load, "
            "in proportion to the lighter of both ('sink-of-soft-contacts'); what the load sinks by the wedge "
            "goes over "
            "tan(alpha)",
        ),
    }
    MU: ClassVar = 0.2
    LOAD: ClassVar = 20.0
    OWN: ClassVar = 5.0
    """kg"""

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The angle at which it is pressed out; at 10 degrees the force that drives it in."""
        phi = math.atan(self.MU)
        limit = math.degrees(phi + math.atan(self.MU * (1.0 + self.OWN / self.LOAD)))

        def leaves(degrees: float) -> bool:
            return abs(self._run(solver, dt, math.radians(degrees), 0.0)) > 1e-3

        yield from threshold_rows("pressed out", leaves, limit)
        alpha = math.radians(10.0)
        force = G * (self.LOAD * math.tan(alpha + phi) + self.MU * (self.LOAD + self.OWN))
        moved = {share: self._run(solver, dt, alpha, share * force) for share in (0.99, 1.01)}
        slack = sink(solver, dt, 5.0 * self.LOAD / self.OWN + 1.0) / math.tan(alpha)
        yield Measurement("moved in 2 s by 99 % of the force", 0.0, moved[0.99], slack, "m")
        goes = 1.01 if moved[1.01] < -0.05 else math.nan
        yield Measurement("share of the force that drives it in", 1.01, goes, 0.005)

    def _run(self, solver: str, dt: float, alpha: float, force: float) -> float:
        """How far the wedge has gone outwards in 2 s, m. It rises along +x, and is pushed along -x."""
        table = st.MaterialTable()
        table.set_pair("default", "default", static=self.MU, dynamic=self.MU)
        table.set_pair("default", "wall", static=0.0, dynamic=0.0)
        world = st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)
        world.add(st.Plane(), static=True)
        # above the wedge, which reaches under it
        world.add(st.Box((1.0, 1.0, 1.0)), static=True, material="wall", position=(-0.5, 0.0, 1.05))
        slope = math.tan(alpha)
        under = prism([(-0.5, 0.0), (1.0, 0.0), (1.0, 0.3 + 1.0 * slope), (-0.5, 0.3 - 0.5 * slope)], 0.4)
        above = prism([(0.0, 0.3), (0.4, 0.3 + 0.4 * slope), (0.4, 1.1), (0.0, 1.1)], 0.4)
        wedge = world.add(under, mass=self.OWN)
        world.add(above, mass=self.LOAD)
        start = wedge.position
        for _ in range(steps_for(2.0, dt)):
            wedge.apply_force((-force, 0.0, 0.0))
            world.step()
        return float(wedge.position[0] - start[0])


def prism(outline: Sequence[tuple[float, float]], width: float) -> st.ConvexHull:
    """A hull with an outline in the plane of x and z, ``width`` m along y."""
    return st.ConvexHull([(x, y, z) for x, z in outline for y in (-0.5 * width, 0.5 * width)])


class TwoCards(Case):
    """The first storey of a house of cards."""

    name = "two-cards"
    title = "two cards that lean against each other hold up to an angle that the floor's friction allows"
    formula = "mu = (tan(a) - t / L) / 2, a from the vertical"
    source = (
        "balance of moments of one card, thickness t, length L, about its foot: the tips press each other at the "
        "height "
        "L cos(a) with no more than mu times a card's weight"
    )
    tolerance = "0.05 deg: the neighbours of the threshold among the multiples of 0.1 deg, exactly"
    tolerance_reason = "cards that give way have moved by centimetres after 2 s, cards that hold by micrometres"
    LENGTH: ClassVar = 1.0
    THICKNESS: ClassVar = 0.04
    FRICTION: ClassVar = (0.15, 0.3)

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Two floors."""
        for mu in self.FRICTION:
            limit = math.degrees(math.atan(2.0 * mu + self.THICKNESS / self.LENGTH))

            def falls(degrees: float, mu: float = mu) -> bool:
                return self._falls(solver, dt, mu, math.radians(degrees))

            yield from threshold_rows(f"mu = {mu:g}, from upright", falls, limit)

    def _falls(self, solver: str, dt: float, mu: float, lean: float) -> bool:
        table = st.MaterialTable()
        table.set_pair("card", "floor", static=mu, dynamic=mu)
        # edge on edge has no normal of its own: friction lets it be any that an engine likes
        table.set_pair("card", "card", static=1.0, dynamic=1.0)
        world = st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)
        world.add(st.Plane(), static=True, material="floor")
        s, c = math.sin(lean), math.cos(lean)
        length, t = self.LENGTH, self.THICKNESS
        # pressed together by a hair, or else one sharp edge may pass the other
        x, z = 0.5 * (length * s + t * c) - 1e-5, 0.5 * (length * c + t * s)
        cards = [
            world.add(
                st.Box((t, 0.6, length)), mass=1.0, position=(side * x, 0, z),
                orientation=about((0, 1, 0), -side * lean), material="card",
            )
            for side in (-1.0, 1.0)
        ]  # fmt: skip
        starts = [card.position for card in cards]
        world.run(2.0)
        return max(float(np.linalg.norm(b.position - a)) for a, b in zip(starts, cards, strict=True)) > 2e-3


class ThreeLogs(Case):
    """The smallest heap."""

    name = "three-logs"
    title = "a log on two others stays up if both they and the floor are rough enough"
    formula = "mu >= tan(15 deg) = 0.268 between logs, mu >= tan(15 deg) / 3 = 0.0893 at the floor"
    source = (
        "balance of a lower log, which only touches its neighbour: friction F is the same at floor and upper "
        "log, and F = "
        "N tan(15 deg) with N = W / 2 between logs and 3 W / 2 at the floor"
    )
    tolerance = "2 %: holds 2 % above the threshold, gives way 2 % below it"
    tolerance_reason = (
        "logs that give way have moved by centimetres after 2 s; springs let the upper log sink by 1e-4 of its radius, "
        "which changes its angle of 30 degrees by that"
    )
    RADIUS: ClassVar = 0.5

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """First the logs' friction is at its threshold, then the floor's."""
        tan = math.tan(math.radians(15.0))
        for what, between, floor in (("between logs", tan, 0.6), ("at the floor", 0.6, tan / 3.0)):
            found = []
            for share in (0.98, 1.02):
                here = between * (share if what == "between logs" else 1.0)
                below = floor * (share if what == "at the floor" else 1.0)
                found.append(self._moved(solver, dt, here, below))
            gives = 0.98 if found[0] > 0.01 else math.nan
            yield Measurement(f"share of mu {what} at which they roll apart", 0.98, gives, 0.01)
            yield Measurement(f"moved in 2 s with 1.02 mu {what}", 0.0, found[1], 2e-3, "m")

    def _moved(self, solver: str, dt: float, between: float, floor: float) -> float:
        """How far the upper log has sunk in 2 s, m."""
        table = st.MaterialTable()
        table.set_pair("log", "log", static=between, dynamic=between)
        table.set_pair("log", "floor", static=floor, dynamic=floor)
        world = st.World(gravity=GRAVITY, dt=dt, solver=solver, materials=table)
        world.add(st.Plane(), static=True, material="floor")
        r, along = self.RADIUS, about((1, 0, 0), 0.5 * math.pi)
        log = st.Capsule(r, 2.0)
        # a hair's breadth apart, so that nothing is between the lower two
        half = r * (1.0 + 1e-6)
        for side in (-1.0, 1.0):
            world.add(log, mass=10.0, position=(side * half, 0, r), orientation=along, material="log")
        top = (0.0, 0.0, r + math.sqrt(4.0 * r * r - half * half))
        upper = world.add(log, mass=10.0, position=top, orientation=along, material="log")
        world.run(2.0)
        return top[2] - float(upper.position[2])


class Arch(Case):
    """Stones without mortar stand while a line of thrust fits into them."""

    name = "arch"
    title = "a half circle of wedge stones stands if it is thicker than a line of thrust needs, and falls if not"
    formula = "stands iff t / R > t_min / R, which is 0.1075 for many stones; with n stones by their own limit analysis"
    source = (
        "Heyman, 'The stone skeleton', Int. J. Solids Struct. 2 (1966): a safe state exists iff forces within "
        "all joints "
        "balance the weights; 0.1075 is that of Milankovitch (1907) for infinitely many joints; the linear "
        "programme for "
        "n stones is solved here"
    )
    tolerance = "15 %: stands at 1.15 t_min, falls at 0.85 t_min; 0.1 t (moved while it stands)"
    tolerance_reason = (
        "contacts that give way let the crown sink, which costs thickness: 14 joints of an arch of 2 m sink by "
        "less than "
        "a twentieth of t_min together; what falls has gone by a stone's size after 4 s"
    )
    solvers = ("soft", "exact")
    STONES: ClassVar = 13
    RADIUS: ClassVar = 2.0
    MU: ClassVar = 0.8

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """The programme's own result near that for many stones; then two arches."""
        many = minimal_thickness(121, self.MU)
        yield Measurement("t / R of 121 stones by the programme here", 0.1075, many, 5e-4)
        least = minimal_thickness(self.STONES, self.MU)
        stands = self._moved(solver, dt, 1.15 * least)
        thickness = 1.15 * least * self.RADIUS
        yield Measurement(f"moved in 4 s at t / R = {1.15 * least:.4f}", 0.0, stands, 0.1 * thickness, "m")
        falls = 0.85 if self._moved(solver, dt, 0.85 * least) > thickness else math.nan
        yield Measurement(f"share of t_min at which it falls (t_min / R = {least:.4f})", 0.85, falls, 0.01)

    def _moved(self, solver: str, dt: float, ratio: float) -> float:
        """How far the stone that moves most has gone in 4 s, m."""
        n, radius, depth = self.STONES, self.RADIUS, 0.5
        world = make_world(solver, dt, static=self.MU)
        world.add(st.Plane(), static=True)
        edges = 0.5 * math.pi - math.pi * np.arange(n + 1) / n  # from the vertical
        stones = []
        for a, b in pairwise(edges):
            outline = [
                (radius * k * math.sin(angle), radius * k * math.cos(angle))
                for angle in (float(a), float(b))
                for k in (1.0 - 0.5 * ratio, 1.0 + 0.5 * ratio)
            ]
            stones.append(world.add(prism(outline, depth), density=2000.0))
        starts = [stone.position for stone in stones]
        world.run(4.0)
        return max(float(np.linalg.norm(b.position - a)) for a, b in zip(starts, stones, strict=True))


def minimal_thickness(stones: int, mu: float) -> float:
    """Least t / R at which forces in the joints of a half circle can balance its weight, by bisection."""
    low, high = 0.02, 0.5
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _has_thrust(stones, middle, mu) else (middle, high)
    return high


def _has_thrust(stones: int, ratio: float, mu: float) -> bool:
    """Whether a safe state exists: joint forces (N, V) and moments M with |V| <= mu N, |M| <= N t / 2."""
    from scipy.optimize import linprog
    from scipy.sparse import lil_matrix

    joints = stones + 1
    angle = 0.5 * math.pi - math.pi * np.arange(joints) / stones
    radial = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    along = np.stack([np.cos(angle), -np.sin(angle)], axis=1)  # from stone k to stone k - 1 through joint k
    balance = lil_matrix((3 * stones, 3 * joints))
    weights = np.zeros(3 * stones)
    half = 0.5 * math.pi / stones
    # the centre of mass of a sector of a ring, for R = 1
    outer, inner = 1.0 + 0.5 * ratio, 1.0 - 0.5 * ratio
    reach = 2.0 / 3.0 * math.sin(half) / half * (outer**3 - inner**3) / (outer**2 - inner**2)
    for k in range(stones):
        center = reach * _unit(0.5 * (angle[k] + angle[k + 1]))
        weights[3 * k + 1] = 1.0
        for joint, sign in ((k, -1.0), (k + 1, 1.0)):
            push, point = sign * along[joint], radial[joint]
            shear = sign * radial[joint]
            for column, force in ((3 * joint, push), (3 * joint + 1, shear)):
                balance[3 * k, column] = force[0]
                balance[3 * k + 1, column] = force[1]
                arm = point - center
                balance[3 * k + 2, column] = arm[0] * force[1] - arm[1] * force[0]
            balance[3 * k + 2, 3 * joint + 2] = sign
    limits = lil_matrix((4 * joints, 3 * joints))
    for j in range(joints):
        for row, (column, share) in enumerate(((1, mu), (1, mu), (2, 0.5 * ratio), (2, 0.5 * ratio))):
            limits[4 * j + row, 3 * j + column] = 1.0 if row % 2 else -1.0
            limits[4 * j + row, 3 * j] = -share
    bounds = [(0.0, None), (None, None), (None, None)] * joints
    found = linprog(
        np.zeros(3 * joints), A_ub=limits.tocsr(), b_ub=np.zeros(4 * joints), A_eq=balance.tocsr(), b_eq=weights,
        bounds=bounds, method="highs",
    )  # fmt: skip
    return bool(found.status == 0)


def _unit(angle: float) -> Array:
    return np.array([math.sin(angle), math.cos(angle)])
