"""Bodies that stand on an edge: balance against rolling resistance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

import stiction as st
from stiction.verify.case import Case, Measurement
from stiction.verify.setups import G, about, delay, make_world, sink, steps_for


class BalanceOnAnEdge(Case):
    """Rolling resistance moves the load by up to delta, and so holds up what is nearly balanced."""

    name = "balance-on-an-edge"
    title = "a box on its edge stays as long as its centre is within delta of it sideways, and falls beyond"
    formula = "stays iff rho sin(a) <= delta; (I + m rho^2) a'' = m g rho sin(a) - delta N, N = m (g + z'')"
    source = "Newton's and Euler's laws with a moment of rolling resistance of at most delta N; integrated here"
    tolerance = "s / rho (held); |a(t, delta - s) - a(t)| + a' 4 h (falling); s = 7/2 g / omega^2"
    tolerance_reason = (
        "corners sink by s at most (omega h = 1.3), which is by how much the load may lie elsewhere; and a box that is "
        "held may let go 4 h late"
    )
    solvers = ("soft",)
    DELTA: ClassVar = 0.02
    SIDE: ClassVar = 0.6
    SECONDS: ClassVar = 1.0

    def measure(self, solver: str, dt: float) -> Iterator[Measurement]:
        """Below the limit and above it, to both sides; one that falls is seen before its face lands, at 45 degrees."""
        rho = self.SIDE / math.sqrt(2.0)
        depth = sink(solver, dt, 3.5)
        for share in (0.5, 0.97, -0.97, 1.2, -1.35):
            start = math.asin(share * self.DELTA / rho)
            world = make_world(solver, dt, static=1.0, rolling=self.DELTA)
            world.add(st.Plane(), static=True)
            box = world.add(
                st.Box((self.SIDE, 0.5, self.SIDE)), position=(0, 0, rho * math.cos(start)),
                orientation=about((0, 1, 0), 0.25 * math.pi + start),
            )  # fmt: skip
            steps = steps_for(self.SECONDS, dt)
            t = steps * dt
            world.step(steps)
            q = box.orientation
            angle = math.copysign(1.0, share) * (2.0 * math.atan2(float(q[2]), float(q[0])) - 0.25 * math.pi)
            what = f"tilt after {t:.3g} s, centre at {share:g} delta"
            if abs(share) < 1.0:
                yield Measurement(what, abs(start), angle, depth / rho, "rad")
                continue
            expected, rate = self._fall(abs(start), self.DELTA, t)
            off = abs(self._fall(abs(start), self.DELTA - depth, t)[0] - expected)
            yield Measurement(what, expected, angle, off + rate * delay(solver, dt), "rad")

    def _fall(self, a: float, delta: float, t: float, n: int = 1000) -> tuple[float, float]:
        """Angle (rad) and its rate after t, by Runge-Kutta; z = rho cos(a)."""
        rho = self.SIDE / math.sqrt(2.0)
        inertia = self.SIDE**2 / 6.0  # over m, about the centre

        def acceleration(a: float, w: float) -> float:
            push = G * rho * math.sin(a) - delta * (G - rho * w * w * math.cos(a))
            return push / (inertia + rho * rho - delta * rho * math.sin(a))

        w, h = 0.0, t / n
        for _ in range(n):
            k1 = acceleration(a, w)
            k2 = acceleration(a + 0.5 * h * w, w + 0.5 * h * k1)
            k3 = acceleration(a + 0.5 * h * w + 0.25 * h * h * k1, w + 0.5 * h * k2)
            k4 = acceleration(a + h * w + 0.5 * h * h * k2, w + h * k3)
            a, w = a + h * w + h * h / 6.0 * (k1 + k2 + k3), w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return a, w
