"""Real tosses of a cube: coefficients from one half of them, judged on the other, for stiction and other engines.

``python benchmarks/cube_tosses.py --data PATH [--engines stiction,mujoco] [--write]``. The data are those of DAIRLab's
contact-nets (arXiv 2009.11193, BSD-3-Clause) in one HDF5 file, a dataset ``/toss/NNN`` each: position (m), quaternion
w x y z, velocity (m/s), angular velocity (rad/s, body frame), 148 samples a second. They are read where they lie.

Two things the free flights tell before any engine is asked. In the units of the data a cube falls with less than
9.81 m/s^2, and a cube at rest is lower than half its width by the same share: the data's lengths are too short, so they
are stretched until the cubes fall as they should. And the tracked middle swings about a parabola as if the centre of
mass lay some millimetres beside it, along the cube's own z.

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
from loaded_cubes import LOADED, MASS
from numpy.typing import NDArray

from stiction.bench import rotations
from stiction.bench.measure import installed
from stiction.bench.scene import BenchBody, BenchScene, ground, quaternion, vector
from stiction.fit.parameters import Parameter
from stiction.fit.search import Search, settle, starts
from stiction.shapes import Box

Array = NDArray[np.float64]

EDGE, RATE, G = 0.1048, 148.0, 9.81
"""m, as stated of the cube; samples a second; m/s^2."""
SPACING = 2.0
"""m between the places of two tosses; none goes further than 0.7 m."""
CLEAR = 0.004
"""m above the table that the lowest corner has in free flight at least."""
STEPS = {"mujoco": 4}
"""Steps a sample: MuJoCo's own step is 2 ms; 2 for all others."""
EVEN, SIZE, MOST = 32, 0.15, 72
"""Even points that are tried; size of the simplex as a share of the ranges, and points that it may try."""
SHORTEST = 8
"""Samples of a flight that tells of all cubes."""
WORLDS = 4
"""Tosses of about the same length share a world, for most of them are at rest long before the longest one is."""

PARAMETERS = (
    Parameter("mu", ("mu",), 0.08, 0.3, 0.18),
    Parameter("restitution", ("restitution",), 0.0, 0.6, 0.125),
    Parameter("center of mass [m]", ("center",), 0.0, 0.012, 0.005),
    Parameter("inertia [kg m2]", ("inertia",), 0.0007, 0.0012, 0.00081),
)
"""What every engine is tuned by; the centre of mass is that far from the middle of the cube along its own z. A solid
cube would have an inertia of 0.00068, a hollow one with thin walls 0.00113 kg m2."""
STATIC = Parameter("mu_s / mu", ("ratio",), 1.0, 2.0, 1.1)
"""And stiction, which has two coefficients."""


def read(path: Path) -> list[Array]:
    """The tosses, (n, 13) each, as they are in the file but for unit quaternions and spins in world axes."""
    import h5py

    with h5py.File(path) as file:
        tosses = [np.array(file["toss"][name], dtype=np.float64) for name in sorted(file["toss"])]
    for toss in tosses:
        toss[:, 3:7] /= np.linalg.norm(toss[:, 3:7], axis=1, keepdims=True)
        toss[:, 10:13] = np.einsum("nij,nj->ni", rotations.matrix(toss[:, 3:7]), toss[:, 10:13])
    return tosses


@dataclass(frozen=True)
class Flights:
    """What the samples before the first contacts say of all cubes alike; no engine has a part in it.

    Attributes:
        stretch: factor on the data's lengths with which cubes fall with 9.81 m/s^2. center: (3,) m, of mass, from the
            tracked centre, in the cube's axes, in stretched lengths.
        stretch_error, center_error: standard errors, over tosses drawn anew.
        tosses: that fly long enough to be asked.
    """

    stretch: float
    center: Array
    stretch_error: float
    center_error: Array
    tosses: int


def flights(tosses: list[Array], rng: np.random.Generator) -> Flights:
    """Least squares over all flights: x = x0 + v t + g t^2 / 2 - R c with x0 and v of each toss, g and c of all."""
    parts = []
    for toss in tosses:
        k = flight(toss)
        if k < SHORTEST:
            continue
        t, R = np.arange(k) / RATE, rotations.matrix(toss[:k, 3:7])
        line, _ = np.linalg.qr(np.stack([np.ones(k), t], axis=1))
        A, y = np.zeros((3, k, 4)), np.zeros((3, k))
        for axis in range(3):  # what x0 and v explain is taken off both sides
            A[axis, :, 0] = 0.5 * t * t * (axis == 2)
            A[axis, :, 1:] = -R[:, axis, :]
            A[axis] -= line @ (line.T @ A[axis])
            y[axis] = toss[:k, axis] - line @ (line.T @ toss[:k, axis])
        A, y = A.reshape(-1, 4), y.ravel()
        parts.append((A.T @ A, A.T @ y))
    squares, sides = np.array([a for a, _ in parts]), np.array([b for _, b in parts])
    drawn = [np.arange(len(parts)), *(rng.integers(0, len(parts), len(parts)) for _ in range(200))]
    found = np.array([np.linalg.solve(squares[k].sum(axis=0), sides[k].sum(axis=0)) for k in drawn])
    stretch = -G / found[:, 0]
    centers = found[:, 1:] * stretch[:, None]
    return Flights(stretch[0], centers[0], stretch[1:].std(), centers[1:].std(axis=0), len(parts))


def stretched(tosses: list[Array], factor: float) -> list[Array]:
    """The tosses with all lengths times a factor."""
    made = [toss.copy() for toss in tosses]
    for toss in made:
        toss[:, :3] *= factor
        toss[:, 7:10] *= factor
    return made


def flight(toss: Array) -> int:
    """Samples before the cube first comes near the table."""
    heights = toss[:, 2] - 0.5 * EDGE * np.abs(rotations.matrix(toss[:, 3:7])[:, 2, :]).sum(axis=1)
    return int(np.argmax(heights < CLEAR))


@dataclass(frozen=True)
class Begin:
    """Where a simulation starts, for any centre of mass.

    Attributes:
        state: (13,) as the data have it, for a centre of mass in the middle of the cube.
        place, velocity: (3, 3) what a centre of mass c (3,) in the cube's axes adds to position (of the middle of the
            cube) and to velocity (of the centre of mass), as matrices.
    """

    state: Array
    place: Array
    velocity: Array

    def at(self, c: Array) -> tuple[Array, Array]:
        """Position of the middle of the cube and velocity of the centre of mass, (3,) each."""
        return self.state[:3] + self.place @ c, self.state[7:10] + self.velocity @ c


def sampled(toss: Array) -> Begin:
    """The first sample; its velocity is that of the middle."""
    R = rotations.matrix(toss[0, 3:7])
    return Begin(toss[0], np.zeros((3, 3)), np.cross(toss[0, 10:13], R.T).T)


def flown(toss: Array) -> Begin:
    """The first sample as all samples of the flight say that it was.

    Velocities of the data are differences to the sample before, so they lag half a sample behind (33 mm/s of falling)
    and carry the noise of two samples. A parabola of the centre of mass and an even turn through the flight have
    neither; the inertia of a cube is the same about all axes, so that it turns evenly.
    """
    start, k = toss[0].copy(), flight(toss)
    if k < 5:
        return sampled(toss)
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
    # the centre of mass is at x + R c in every sample, so that the line through it is linear in c too
    slopes, begins = np.polyfit(t, rotations.matrix(toss[:k, 3:7]).reshape(k, 9), 1)
    return Begin(start, begins.reshape(3, 3) - rotations.matrix(start[3:7]), slopes.reshape(3, 3))


def rest_height(tosses: list[Array]) -> float:
    """Height of the centre of a cube that lies still, m: the data's table is where that is."""
    still = [toss[-8:, 2].mean() for toss in tosses if np.linalg.norm(toss[-1, :3] - toss[-10, :3]) < 0.01]
    return float(np.median(still))


class Tuned:
    """All tosses of a set in one world of an engine, as a function of the open numbers.

    Args:
        name: of the engine. tosses: what was measured. begins: where the simulations start.
        rest: height of a resting cube, m.

    Attributes:
        parameters: what is open.
        tried: values and (tosses, 2) errors of everything that was asked.
    """

    def __init__(self, name: str, tosses: list[Array], begins: list[Begin], rest: float) -> None:
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
        mu, restitution, center, inertia = (float(value) for value in x[:4])
        c = np.array([0.0, 0.0, center])
        box = Box((EDGE,) * 3)
        bodies = [ground(top=self.rest - 0.5 * EDGE)]
        for begin, place in zip([self.begins[k] for k in group], places, strict=True):
            position, velocity = begin.at(c)
            spin = vector(begin.state[10:13])
            pose = vector(position + place), quaternion(begin.state[3:7])
            bodies.append(BenchBody(box, *pose, vector(velocity), spin, MASS / EDGE**3))
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
        engine = LOADED[self.name](c, inertia, restitution)
        engine.build(scene, 1.0 / (RATE * per_sample))
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


def judge(name: str, tosses: list[Array], begins: list[Begin], rng: np.random.Generator) -> Judged:
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


def told_of(told: Flights, edge: float) -> str:
    """What the flights say, in words; ``edge`` is twice the height of a cube at rest, m."""
    a, b = told.center, told.center_error
    off = ", ".join(f"{1e3 * value:.1f} ± {1e3 * error:.1f}" for value, error in zip(a, b, strict=True))
    return (
        f"{told.tosses} flights: lengths times {told.stretch:.4f} ± {told.stretch_error:.4f} fall as they should. "
        f"Stretched so, cubes at rest are {1e3 * edge:.1f} mm high; {1e3 * EDGE:.1f} mm were stated. "
        f"The centre of mass lies ({off}) mm from the middle, along the cube's x, y, z."
    )


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
    known = [name for name in LOADED if name in ("stiction", *installed())]
    wanted = options.engines.split(",") if options.engines else known
    if missing := [name for name in wanted if name not in known]:
        parser.error(f"--engines must be among {', '.join(known)}, got {', '.join(missing)}.")
    warnings.simplefilter("ignore")
    raw = read(options.data)[:: options.every]
    told = flights(raw, np.random.default_rng(options.seed))
    tosses = stretched(raw, told.stretch)
    words = told_of(told, 2.0 * rest_height(tosses))
    print(words, flush=True)
    if options.write:
        write_between("fit.md", "tosses-flights", words)
    kinds = {"sample": ("started in the first sample", [sampled(toss) for toss in tosses])}
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
