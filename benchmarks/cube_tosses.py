"""Real tosses of a cube: coefficients from one half of them, judged on the other, for stiction and other engines.

``python benchmarks/cube_tosses.py --data PATH [--engines stiction,mujoco] [--write]``. The data are those of DAIRLab's
contact-nets (arXiv 2009.11193, BSD-3-Clause) in one HDF5 file, a dataset ``/toss/NNN`` each: position (m), quaternion
w x y z, velocity (m/s), angular velocity (rad/s, body frame), 148 samples a second. They are read where they lie.

All engines are tuned alike: the same open numbers in the same ranges, the same even points and the same simplex, on the
mean error of the tosses of one half; and both halves take turns, so that every toss is judged by numbers that it had no
part in. All cubes of a half are in one world, 2 m from each other.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from docs_table import write_between
from numpy.typing import NDArray

from stiction.bench import rotations
from stiction.bench.engines import engine_class
from stiction.bench.measure import installed
from stiction.bench.scene import BenchBody, BenchScene, ground, quaternion, vector
from stiction.fit.parameters import Parameter
from stiction.fit.search import Search, settle, starts
from stiction.shapes import Box

Array = NDArray[np.float64]

EDGE, MASS, RATE, G = 0.1048, 0.37, 148.0, 9.81
"""As the data say: m, kg, samples a second, m/s^2."""
SPACING = 2.0
"""m between the places of two tosses; none goes further than 0.7 m."""
CLEAR = 0.004
"""m above the table that the lowest corner has in free flight at least."""
STEPS = {"mujoco": 4, "sapien": 4}
"""Steps a sample: MuJoCo's own step is 2 ms; 2 for all others."""
EVEN, SIZE, MOST = 32, 0.15, 48
"""Even points that are tried; size of the simplex as a share of the ranges, and points that it may try."""
WORLDS = 4
"""Tosses of about the same length share a world, for most of them are at rest long before the longest one is."""

PARAMETERS = (
    Parameter("mu", ("mu",), 0.08, 0.3, 0.18),
    Parameter("restitution", ("restitution",), 0.0, 0.6, 0.125),
    Parameter("edge [m]", ("edge",), 0.1015, 0.105, 0.1035),
    Parameter("inertia [kg m2]", ("inertia",), 0.0007, 0.0011, 0.00081),
)
"""What every engine is tuned by. A solid cube would have an inertia of 0.00068, a hollow one 0.00113 kg m2."""
STATIC = Parameter("mu_s / mu", ("ratio",), 1.0, 2.0, 1.1)
"""And stiction, which has two coefficients."""


def read(path: Path) -> list[Array]:
    """The tosses, (n, 13) each, with unit quaternions and angular velocities in world axes."""
    import h5py

    with h5py.File(path) as file:
        tosses = [np.array(file["toss"][name], dtype=np.float64) for name in sorted(file["toss"])]
    for toss in tosses:
        toss[:, 3:7] /= np.linalg.norm(toss[:, 3:7], axis=1, keepdims=True)
        toss[:, 10:13] = np.einsum("nij,nj->ni", rotations.matrix(toss[:, 3:7]), toss[:, 10:13])
    return tosses


def flight(toss: Array) -> int:
    """Samples before the cube first comes near the table."""
    heights = toss[:, 2] - 0.5 * EDGE * np.abs(rotations.matrix(toss[:, 3:7])[:, 2, :]).sum(axis=1)
    return int(np.argmax(heights < CLEAR))


def flown(toss: Array) -> Array:
    """The first sample, (13,), as all samples of the flight say that it was.

    Velocities of the data are differences to the sample before, so they lag half a sample behind (33 mm/s of falling)
    and carry the noise of two samples. A parabola and an even turn through the flight have neither; the inertia of a
    cube is the same about all axes, so that it turns evenly.
    """
    start, k = toss[0].copy(), flight(toss)
    if k < 5:
        return start
    t = np.arange(k) / RATE
    x = toss[:k, :3] + 0.5 * G * t[:, None] ** 2 * np.array([0.0, 0.0, 1.0])
    start[7:10], start[:3] = np.polyfit(t, x, 1)
    w = toss[1:k, 10:13].mean(axis=0)
    for _ in range(3):  # each round takes off what a straight line finds in the turns that are left over
        size = float(np.linalg.norm(w))
        left = []
        for moment, measured in zip(t, toss[:k, 3:7], strict=True):
            turned = rotations.product(rotations.about(w / size, size * moment), start[3:7])
            off = rotations.product(measured, turned * np.array([1.0, -1.0, -1.0, -1.0]))
            left.append(rotations.rotation_vector(off if off[0] >= 0.0 else -off))
        slope, begin = np.polyfit(t, np.array(left), 1)
        w = w + slope
        angle = float(np.linalg.norm(begin))
        if angle > 0.0:
            start[3:7] = rotations.product(rotations.about(begin / angle, angle), start[3:7])
    start[10:13] = w
    return start


def rest_height(tosses: list[Array]) -> float:
    """Height of the centre of a cube that lies still, m: the data's table is where that is."""
    still = [toss[-8:, 2].mean() for toss in tosses if np.linalg.norm(toss[-1, :3] - toss[-10, :3]) < 0.01]
    return float(np.median(still))


class Tuned:
    """All tosses of a set in one world of an engine, as a function of the open numbers.

    Args:
        name: of the engine. tosses: what was measured. begins: (13,) each, where the simulation starts.
        rest: height of a resting cube, m.

    Attributes:
        parameters: what is open.
        tried: values and (tosses, 2) errors of everything that was asked.
    """

    def __init__(self, name: str, tosses: list[Array], begins: list[Array], rest: float) -> None:
        self.name, self.tosses, self.begins, self.rest = name, tosses, begins, rest
        self.parameters = (*PARAMETERS, STATIC) if name == "stiction" else PARAMETERS
        self.tried: list[tuple[Array, Array]] = []
        order = np.argsort([len(toss) for toss in tosses], kind="stable")
        self.groups = np.array_split(order, min(WORLDS, len(tosses)))

    def residuals(self, x: Any) -> Array:
        """(2 tosses,) square roots of the errors in units of 0.15 widths and 17 degrees: their squares add up."""
        errors = self.errors(np.asarray(x, dtype=np.float64))
        return np.sqrt(errors / [0.15, 17.0]).ravel()

    def errors(self, x: Array) -> Array:
        """(tosses, 2) mean over the time of a toss of the distance in cube widths and of the angle in degrees."""
        found = np.empty((len(self.tosses), 2))
        for group in self.groups:
            positions, orientations = self.simulate(x, group)
            for column, k in enumerate(group):
                toss, n = self.tosses[k], len(self.tosses[k])
                way = np.linalg.norm(positions[:n, column] - toss[:, :3], axis=1)
                cosine = np.abs((orientations[:n, column] * toss[:, 3:7]).sum(axis=1)).clip(0.0, 1.0)
                found[k] = way.mean() / EDGE, np.degrees(2.0 * np.arccos(cosine)).mean()
        self.tried.append((np.array(x), found))
        return found

    def simulate(self, x: Array, group: NDArray[np.int64]) -> tuple[Array, Array]:
        """Positions (samples, group, 3) m and orientations (samples, group, 4) of some tosses, in one world."""
        side = math.ceil(math.sqrt(len(group)))
        places = SPACING * np.array([(k % side - 0.5 * side, k // side - 0.5 * side, 0.0) for k in range(len(group))])
        mu, restitution, edge, inertia = (float(value) for value in x[:4])
        box = Box((edge,) * 3)
        # Rapier adds mass to what its shapes have, so that half of it is left for the inertia
        density = MASS / edge**3 * (0.5 if self.name == "rapier3d" else 1.0)
        bodies = [ground(top=self.rest - 0.5 * edge)]
        for begin, place in zip([self.begins[k] for k in group], places, strict=True):
            pose = vector(begin[:3] + place), quaternion(begin[3:7])
            bodies.append(BenchBody(box, *pose, vector(begin[7:10]), vector(begin[10:13]), density))
        ratio = float(x[4]) if len(x) > 4 else 1.0
        bounce = 0.0 if self.name == "mujoco" else restitution
        scene = BenchScene(
            "tosses",
            tuple(bodies),
            friction=ratio * mu,
            dynamic_friction=mu if ratio > 1.0 else None,
            restitution=bounce,
        )
        per_sample = STEPS.get(self.name, 2)
        engine = engine_class(self.name)()
        if self.name == "stiction":
            add_cubes(engine, scene, 1.0 / (RATE * per_sample), inertia)
        else:
            engine.build(scene, 1.0 / (RATE * per_sample))
            set_rest(engine, inertia, restitution)
        samples = max(len(self.tosses[k]) for k in group)
        positions, orientations = np.empty((samples, len(bodies) - 1, 3)), np.empty((samples, len(bodies) - 1, 4))
        for sample in range(samples):
            if sample:
                for _ in range(per_sample):
                    engine.step()
            positions[sample] = engine.positions()[1:] - places
            orientations[sample] = engine.orientations()[1:]
        if self.name == "robox3d":
            engine.world.destroy()  # Box3D holds 128 worlds at most and crashes at the next one
        return positions, orientations


def add_cubes(engine: Any, scene: BenchScene, dt: float, inertia: float) -> None:
    """Build the scene in stiction with the cubes' own inertia, kg m^2, which scenes for benchmarks do not know."""
    engine.scene, engine.dt = scene, dt
    engine.world = engine._world(scene, dt)
    floor, *cubes = scene.bodies
    engine.world.add(floor.shape, static=True, position=floor.position)
    for body in cubes:
        moves = {"velocity": body.velocity, "angular_velocity": body.angular_velocity}
        own = {"mass": MASS, "inertia": (inertia,) * 3}
        engine.world.add(body.shape, position=body.position, orientation=body.orientation, **own, **moves)


def set_rest(engine: Any, inertia: float, restitution: float) -> None:
    """Give every cube of another engine its inertia, kg m^2, and MuJoCo's contacts the damping of a restitution."""
    cubes = np.flatnonzero(engine.scene.dynamic)
    match engine.name:
        case "mujoco":
            engine.model.body_inertia[engine.model.body_mass > 0.0] = inertia
            engine.mujoco.mj_setConst(engine.model, engine.mujoco.MjData(engine.model))
            logarithm = math.log(max(restitution, 1e-3))
            engine.model.geom_solref[:, 1] = -logarithm / math.hypot(math.pi, logarithm)
        case "pybullet":
            for index in cubes:
                engine.client.changeDynamics(engine.bodies[index], -1, localInertiaDiagonal=[inertia] * 3)
        case "rapier3d":
            for index in cubes:
                edge = engine.scene.bodies[index].shape.size[0]
                rest = inertia - 0.5 * MASS * edge**2 / 6.0
                more = engine.load().MassProperties([0.0, 0.0, 0.0], 0.5 * MASS, [rest] * 3)
                engine.world.rigid_bodies[engine.handles[index]].set_additional_mass_properties(more, True)
        case "robox3d":
            for index in cubes:
                engine.bodies[index].set_mass_data(MASS, np.zeros(3), inertia * np.eye(3))


@dataclass
class Judged:
    """One engine from one kind of start.

    Attributes:
        errors: (tosses, 2) each judged by the values that the other half led to. best: (2, p) values of both halves.
        low, high: (p,) 90 % intervals over resampled tosses, among the values that were tried. parameters: which.
    """

    engine: str
    parameters: tuple[Parameter, ...]
    errors: Array
    best: Array
    low: Array
    high: Array
    seconds: float


def judge(name: str, tosses: list[Array], begins: list[Array], rng: np.random.Generator) -> Judged:
    """Tune on either half, judge on the other."""
    began = time.perf_counter()
    rest = rest_height(tosses)
    halves = [Tuned(name, tosses[k::2], begins[k::2], rest) for k in (0, 1)]
    best = []
    for half in halves:
        search = Search(half)
        first, second = starts(search, 2, rng, EVEN)
        x = min(first, second, key=search.cost)
        best.append(settle(search, x, SIZE * search.span, search.cost, MOST))
    errors = np.empty((len(tosses), 2))
    for k in (0, 1):
        errors[k::2] = halves[k].errors(best[1 - k])
    drawn = np.concatenate([resampled(half, 200, rng) for half in halves])
    low, high = np.quantile(drawn, [0.05, 0.95], axis=0)
    return Judged(name, halves[0].parameters, errors, np.array(best), low, high, time.perf_counter() - began)


def resampled(half: Tuned, draws: int, rng: np.random.Generator) -> Array:
    """(draws, p) which of the tried values would have been the best for tosses drawn anew from those of a half."""
    values = np.array([x for x, _ in half.tried])
    scores = np.array([(found / [0.15, 17.0]).sum(axis=1) for _, found in half.tried])
    n = scores.shape[1]
    return np.array([values[np.argmin(scores[:, rng.integers(0, n, n)].sum(axis=1))] for _ in range(draws)])


def table(results: list[Judged]) -> list[str]:
    """Rows of Markdown."""
    names = [parameter.name for parameter in (*PARAMETERS, STATIC)]
    rows = [
        f"| engine | position error [widths] | rotation error [deg] | {' | '.join(names)} |",
        "| --- " * (3 + len(names)) + "|",
    ]
    for result in results:
        mean, spread = result.errors.mean(axis=0), result.errors.std(axis=0) / math.sqrt(len(result.errors))
        cells = [
            f"{value:.4g} ({a:.3g} … {b:.3g})"
            for value, a, b in zip(result.best.mean(axis=0), result.low, result.high, strict=True)
        ]
        cells += ["–"] * (len(names) - len(cells))
        errors = f"{mean[0]:.3f} ± {spread[0]:.3f} | {mean[1]:.1f} ± {spread[1]:.1f}"
        rows.append(f"| {result.engine} | {errors} | {' | '.join(cells)} |")
    return rows


def main() -> None:
    """Fit, judge, print; write into docs/fit.md if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="cube_tosses.h5")
    parser.add_argument("--engines", default=None, help="with commas between them; stiction and all that are installed")
    parser.add_argument("--starts", default="sample,flight", help="first sample, fitted flight, or both")
    parser.add_argument("--every", type=int, default=1, help="take every so many-th toss only, for a quick look")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true", help="write the tables into docs/fit.md, after each engine")
    options = parser.parse_args()
    wanted = options.engines.split(",") if options.engines else ["stiction", *installed()]
    for name in wanted:
        engine_class(name)
    warnings.simplefilter("ignore")
    tosses = read(options.data)[:: options.every]
    kinds = {"sample": ("started in the first sample", [toss[0] for toss in tosses])}
    kinds["flight"] = ("started as all samples of the flight say", [flown(toss) for toss in tosses])
    try:
        for kind in options.starts.split(","):
            title, begins = kinds[kind]
            results = []
            for name in wanted:
                results.append(judge(name, tosses, begins, np.random.default_rng(options.seed)))
                mean = results[-1].errors.mean(axis=0)
                print(f"{kind}, {name}: {mean[0]:.4f} widths, {mean[1]:.2f} degrees", end=", ", flush=True)
                print(f"{results[-1].best.round(5).tolist()} in {results[-1].seconds:.0f} s", flush=True)
                made = "\n".join([f"{len(tosses)} tosses, {title}:", "", *table(results)])
                if options.write:
                    write_between("fit.md", f"tosses-{kind}", made)
            print(made)
    except KeyboardInterrupt:
        print("interrupted; what was finished is above.")
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
