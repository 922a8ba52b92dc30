"""How well a heap of boxes is solved: ``python benchmarks/contact_heap.py [bodies] [--docs]``.

Drops boxes into a box, lets them settle, and takes out the contact problem of the next step. Tells the error of what
``soft`` makes of it in its one step, warm (with the loads of the step before) and cold (in a new world with the same
bodies at the same places), beside that of Gauss-Seidel sweeps over the points. ``--docs`` writes the table into
docs/contact-problems.md.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from docs_table import write_between
from rich.progress import track

import stiction as st
from stiction.bench.engines.with_stiction import Adapter
from stiction.bench.granular import heap
from stiction.problems import ContactProblem, natural_map, residuals, solve

SECONDS = 10.0
SWEEPS = (10, 100, 1000)
STEPS = 60
"""Over which the warm error is looked at."""


def settled(n: int) -> st.World:
    """A heap of n boxes after ten seconds."""
    adapter = Adapter()
    adapter.build(heap(n, kinds=("box",)), 1.0 / 60.0)
    world: st.World = adapter.world
    for _ in track(range(round(SECONDS)), f"{n} boxes settle"):
        world.run(1.0)
    return world


def without_memory(world: st.World) -> st.World:
    """A new world with the same bodies: no contact has a load yet."""
    made = st.World(gravity=world.gravity, dt=world.dt, materials=world.materials, sleeping=False)
    for body in world:
        state = {"position": body.position, "orientation": body.orientation, "material": body.material}
        if body.mobility == "static":
            made.add(body.shape, static=True, name=body.name, **state)
        else:
            moves = {"velocity": body.velocity, "angular_velocity": body.angular_velocity}
            made.add(body.shape, mass=body.mass, name=body.name, **state, **moves)
    return made


def typical_mass(problem: ContactProblem) -> float:
    """Inverse of the mean diagonal of W, kg."""
    return 1.0 / float(np.trace(problem.W.diagonal(), axis1=1, axis2=2).mean() / 3.0)


def row(name: str, problem: ContactProblem, r: np.ndarray, left: str) -> str:
    """A row of the table: the errors of impulses r, and what else is known of them."""
    rho = typical_mass(problem)
    found = residuals(problem, r)
    scaled = natural_map(problem, r, rho=rho) / rho
    return f"| {name} | {found.natural_map:.1e} | {scaled:.1e} | {found.gap:.1e} | {left} |"


def table_of(n: int) -> str:
    """All of it, as Markdown."""
    world = settled(n)
    speed = float(np.abs(world.velocities).max())
    problem = world.contact_problem()
    assert problem.places is not None
    warm = problem.places.impulses
    errors = []
    cold_world = without_memory(world)
    cold_problem = cold_world.contact_problem()
    assert cold_problem.places is not None
    cold = cold_problem.places.impulses
    cold_world.step()
    cold_left = cold_world.residual()
    world.step()
    warm_left = world.residual()
    for _ in range(STEPS):
        later = world.contact_problem()
        assert later.places is not None
        errors.append(natural_map(later, later.places.impulses))
        world.step()
    lines = [
        f"{n} boxes after {SECONDS:g} s, the fastest at {speed:.0e} m/s: {problem.contacts} points, "
        f"coefficient {problem.mu.min():g}, typical mass {typical_mass(problem):.0f} kg.",
        "",
        "| impulses | natural map | natural map, typical mass | gap | `world.residual()` |",
        "| --- | --- | --- | --- | --- |",
        row("`soft`, warm", problem, warm, f"{warm_left:.1e} m/s"),
        row("`soft`, cold", cold_problem, cold, f"{cold_left:.1e} m/s"),
        row("none", problem, np.zeros_like(warm), "–"),
    ]
    for start, name in ((None, "from zero"), (warm, "from those of `soft`, warm")):
        for sweeps in SWEEPS:
            began = time.perf_counter()
            found = solve(
                problem, start=start, sweeps=sweeps, accelerate=False, finish=False, tolerance=1e-15, warn=False
            )
            print(f"{sweeps} sweeps {name}: {time.perf_counter() - began:.2f} s", file=sys.stderr)
            lines.append(row(f"{sweeps} plain sweeps {name}", problem, found.r, "–"))
    found = solve(problem, start=warm, warn=False, seconds=60.0)
    lines.append(row(f"the default of `solve`, {found.sweeps} sweeps", problem, found.r, "–"))
    lines += ["", f"Over the {STEPS} steps that follow the warm error is {min(errors):.1e} to {max(errors):.1e}."]
    return "\n".join(lines)


def main(arguments: list[str]) -> None:
    """Print the table, and write it into the page if asked to."""
    numbers = [int(text) for text in arguments if text.isdigit()]
    made = table_of(numbers[0] if numbers else 500)
    print(made)
    if "--docs" in arguments:
        write_between("contact-problems.md", "heap", made)


if __name__ == "__main__":
    main(sys.argv[1:])
