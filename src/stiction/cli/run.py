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
from stiction.cli.progress import progress

if TYPE_CHECKING:
    from stiction.record.frames import Frames
    from stiction.scene import Simulation

FRAMES_PER_SECOND = 60.0
STYLES = {"sticking": "green", "sliding": "dark_orange", "rolling": "magenta", "free": "cyan", "fixed": "dim"}


def run(
    scene: Annotated[str, typer.Argument(help="A built-in scene (see `stiction scenes`) or a TOML file.")],
    html: Annotated[Path | None, typer.Option(help="Write a page that plays the run, offline.")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw speed and friction force over time (PNG, SVG or PDF).")
    ] = None,
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
) -> None:
    """Simulate a scene and print a table: how far each body went, how it moves now, and what friction took."""
    from stiction.record.recorder import Recorder
    from stiction.record.run import run as run_simulation
    from stiction.record.run import summary
    from stiction.scene import Simulation, load

    overrides = list(set_ or [])
    if seconds is not None:
        overrides.append(f"duration={seconds}")
    for option, path in (("--html", html), ("--record", record)):
        if path is not None:
            outputs.writable(option, path, make_folder=True)
    if plot is not None:
        from stiction.plot.run import check_path

        check_path("--plot", plot, make_folder=True)

    simulation = Simulation(load(scene, overrides))
    world = simulation.world
    start = world.positions.copy()
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * world.dt)))
    recorder = Recorder(world, simulation.scene.title, every=every) if html or plot else None

    began = time.perf_counter()
    try:
        keep = {"contacts": record_contacts, "precision": "full" if record_full else "display"}
        title = simulation.scene.title
        with _writer(record, simulation, keep) as writer, progress(title, json) as on_progress:
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
    if recorder is not None:
        _write(recorder.frames(), simulation, html, plot)
    for what, path in (("page", html), ("plot", plot), ("recording", record)):
        if path is not None:
            say(f"{what}: {path}")


@contextmanager
def _writer(path: Path | None, simulation: Simulation, keep: dict[str, Any]) -> Iterator[Any]:
    if path is None:
        yield None
        return
    from stiction.record.writer import RecordingWriter

    with RecordingWriter(path, simulation, **keep) as writer:
        yield writer


def _write(frames: Frames, simulation: Simulation, html: Path | None, plot: Path | None) -> None:
    if html is not None:
        from stiction.view.html import write_html

        write_html(frames, html)
    if plot is not None:
        from stiction.plot.run import plot_run

        plot_run(frames, simulation.world.materials.pair, plot)


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
    out.print(
        f"{world.steps} steps of {world.dt:.4g} s with solver {world.solver!r} in {wall:.2f} s; friction took "
        f"{energy.friction:.4g} J, rolling resistance {energy.rolling:.4g} J, impacts {energy.impacts:.4g} J; "
        f"the ledger closes to {abs(energy.residual):.1e} J."
    )
    report = world.report()
    if any(report.limit_hits):
        hits = dict(zip(("penetrations", "impacts", "resting contact"), report.limit_hits, strict=True))
        out.print("steps in which the iteration limit was hit: " + ", ".join(f"{k} {v}" for k, v in hits.items() if v))
