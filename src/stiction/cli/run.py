"""``stiction run``: simulate a scene, show what happened, and write what was asked for."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction import outputs
from stiction.cli.console import complain, out, print_json, say, table
from stiction.cli.figures import check_bodies, wanted, write
from stiction.cli.progress import progress

if TYPE_CHECKING:
    from stiction.scene import Simulation

FRAMES_PER_SECOND = 60.0
STYLES = {"sticking": "green", "sliding": "dark_orange", "rolling": "magenta", "free": "cyan", "fixed": "dim"}


def run(
    scene: Annotated[str, typer.Argument(help="A built-in scene (see `stiction scenes`) or a TOML file.")],
    html: Annotated[Path | None, typer.Option(help="Write a page that plays the run, offline.")] = None,
    plot: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE|KIND|KIND=FILE",
            help="Draw a figure (PNG, SVG or PDF): of kind 'run' into FILE, or of one of the kinds that "
            "`stiction plot --list` shows, into FILE or SCENE-KIND.png; repeatable.",
        ),
    ] = None,
    body: Annotated[list[str] | None, typer.Option(help="Show this body in figures; repeatable.")] = None,
    record: Annotated[Path | None, typer.Option(help="Record the run (HDF5), to be replayed bit for bit.")] = None,
    record_contacts: Annotated[
        bool, typer.Option("--record-contacts", help="Keep contact points in the recording, too.")
    ] = False,
    record_full: Annotated[
        bool, typer.Option("--record-full", help="Keep frames of the recording in float64, not only for the eye.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print the table as JSON.")] = False,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a value of the scene; repeatable.")
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="Simulated time, instead of the scene's own.")] = None,
    export_problem: Annotated[
        Path | None,
        typer.Option(help="Write the contact problem of the step after the last (FCLIB .hdf5, Siconos .dat)."),
    ] = None,
) -> None:
    """Simulate a scene and print a table: how far each body went, how it moves now, and what friction took.

    \b
    Examples:
      stiction run ramp --html ramp.html --plot ramp.png
      stiction run pull --plot pull --plot energy=out/energy.svg
      stiction run ramp --set frames.ramp.rotation.angle_deg=25 --json
      stiction run pyramid --seconds 0.5 --export-problem pyramid.hdf5
    """
    from stiction.plot.track import Observer
    from stiction.record.run import run as run_simulation
    from stiction.record.run import summary
    from stiction.scene import Simulation, load

    overrides = list(set_ or [])
    if seconds is not None:
        overrides.append(f"duration={seconds}")
    for option, path in (("--html", html), ("--record", record)):
        if path is not None:
            outputs.writable(option, path, make_folder=True)
    figures = wanted(list(plot or []), Path(scene).stem)
    if export_problem is not None:
        from stiction.problems.problem import check_ending

        check_ending("--export-problem", export_problem)
        outputs.writable("--export-problem", export_problem, make_folder=True)

    simulation = Simulation(load(scene, overrides))
    world = simulation.world
    check_bodies(figures, body, [one.name for one in world])
    start = world.positions.copy()
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * world.dt)))
    finer = any(figure.kind.fine for figure in figures)
    recorder = Observer(world, simulation.scene.title, 1 if finer else every) if html or figures else None

    began = time.perf_counter()
    try:
        keep = {"contacts": record_contacts, "precision": "full" if record_full else "display"}
        title = simulation.scene.title
        with _writer(record, simulation, keep) as writer, progress(title, json, dt=world.dt) as on_progress:
            run_simulation(simulation, recorder=recorder, writer=writer, on_progress=on_progress)
    except KeyboardInterrupt:
        kept = f"; what was recorded until then is in {record}" if record else ""
        complain(f"interrupted at {world.time:.2f} s of {simulation.total_steps * world.dt:.2f} s{kept}.")
        raise typer.Exit(130) from None
    wall = time.perf_counter() - began

    rows = summary(simulation, start)
    if json:
        print_json(_as_dict(simulation, rows))
    else:
        _print_table(simulation, rows, wall)
    if recorder is not None and html is not None:
        from stiction.plot.track import thinned
        from stiction.view.html import write_html

        write_html(thinned(recorder.frames(), every) if finer else recorder.frames(), html)
        say(f"page: {html}")
    if recorder is not None and figures:
        write(figures, recorder.track(), body)
    if export_problem is not None:
        world.contact_problem().write(export_problem)
        say(f"contact problem: {export_problem}")
    if record is not None:
        say(f"recording: {record}")


@contextmanager
def _writer(path: Path | None, simulation: Simulation, keep: dict[str, Any]) -> Iterator[Any]:
    if path is None:
        yield None
        return
    from stiction.record.writer import RecordingWriter

    with RecordingWriter(path, simulation, **keep) as writer:
        yield writer


def _as_dict(simulation: Simulation, rows: list[Any]) -> dict[str, Any]:
    world = simulation.world
    energy = world.energy()
    report = world.report()
    return {
        "scene": simulation.scene.title,
        "expect": simulation.scene.expect,
        "solver": world.solver,
        "dt": world.dt,
        "steps": world.steps,
        "time": world.time,
        "state_hash": world.state_hash(),
        "bodies": [row._asdict() for row in rows],
        "energy": {**energy._asdict(), "dissipated": energy.dissipated, "residual": energy.residual},
        "solver_report": report._asdict(),
    }


def _print_table(simulation: Simulation, rows: list[Any], wall: float) -> None:
    world, scene = simulation.world, simulation.scene
    numbers = ("moved [m]", "speed [m/s]", "friction [J]")
    made = table(scene.title, ["body", "shape", "material", *numbers[:2], "state", numbers[2]], right=numbers)
    for row in rows:
        state = f"[{STYLES[row.motion]}]{row.motion}[/]"
        # adding zero turns -0 into 0
        lost = f"{round(row.friction_work, 2) + 0.0:.2f}"
        moved, speed = f"{row.displacement:.4f}", f"{row.speed:.4f}"
        made.add_row(row.name, row.shape, row.material, moved, speed, state, lost)
    out.print(f"[italic]{scene.expect}[/]")
    out.print(made)
    energy = world.energy()
    given_back = " (soft contacts have given back more than impacts took)" if energy.given_back else ""
    out.print(
        f"{world.steps} steps of {world.dt:.4g} s with solver {world.solver!r} in {wall:.2f} s; friction took "
        f"{energy.friction:.4g} J, rolling resistance {energy.rolling:.4g} J, impacts {energy.impacts:.4g} "
        f"J{given_back}; the ledger closes to {abs(energy.residual):.1e} J."
    )
    report = world.report()
    if any(report.limit_hits):
        hits = dict(zip(("penetrations", "impacts", "resting contact"), report.limit_hits, strict=True))
        out.print("steps in which the iteration limit was hit: " + ", ".join(f"{k} {v}" for k, v in hits.items() if v))
