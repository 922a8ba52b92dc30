"""Write the example of fit.md and draw its figure: ``python docs/make_fit.py`` (a minute).

The tables of cube tosses are written by ``benchmarks/cube_tosses.py``, which needs the data.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from markers import replace

from stiction.fit import Estimate, Problem, Track, fit, parse_all
from stiction.fit.report import draw
from stiction.scene import load

PAGE = Path(__file__).with_name("fit.md")
PICTURE = Path(__file__).with_name("_static") / "fit.png"
PAIR = "materials.pairs.wood-concrete"
TRUTH = (0.52, 0.37)
NOISE = 1e-3


def main() -> None:
    """Make up data, fit them, draw, write."""
    scene = load("pull", ["pushes[0].until=4.2", "duration=5"])
    parameters = parse_all([f"{PAIR}.static", f"{PAIR}.dynamic"], scene.table)
    times = np.arange(0.0, 5.0, 0.01)
    blank = Track("", times, np.zeros((len(times), 3)))
    clean = Problem(scene, [blank], parameters).simulate(TRUTH)[0].positions
    measured = clean + NOISE * np.random.default_rng(1).normal(size=clean.shape)
    problem = Problem(scene, [Track("", times, measured)], parameters)
    made = fit(problem)
    draw(problem, made, PICTURE)
    replace(PAGE, "release", _told(made.estimates, made.remarks))


def _told(estimates: Iterable[Estimate], remarks: Iterable[str]) -> Iterable[str]:
    yield "A crate is pulled harder and harder until it lets go, and released (`pull` with `pushes[0].until=4.2`)."
    yield f"The data are made up: samples every 0.01 s with {1e3 * NOISE:g} mm of noise."
    yield ""
    yield f"![Measured and fitted motion of the crate, and what is left over](_static/{PICTURE.name})"
    yield ""
    yield "| | true | found | 90 % interval | off |"
    yield "| --- | --- | --- | --- | --- |"
    for true, found in zip(TRUTH, estimates, strict=True):
        off = 100.0 * (found.value / true - 1.0)
        limits = f"{found.low:.5f} … {found.high:.5f}"
        yield f"| `{found.parameter.name}` | {true} | {found.value:.5f} | {limits} | {off:+.3f} % |"
    for remark in remarks:
        yield ""
        yield f"*{remark}*"


if __name__ == "__main__":
    main()
