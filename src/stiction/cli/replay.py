"""``stiction replay``: what a recording holds, and whether the engine still does the same, step by step."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction.cli.console import out, print_json, say, table
from stiction.cli.progress import progress

if TYPE_CHECKING:
    from stiction.record.recording import Recording
    from stiction.record.replay import ReplayCheck

MOST_ROWS = 20
"""Bodies in the table of differences at most; JSON has all."""


def replay(
    file: Annotated[
        Path, typer.Argument(help="A recording (`stiction run SCENE --record FILE`, `world.record(FILE)`).")
    ],
    check: Annotated[
        bool,
        typer.Option("--check", help="Run the engine again, and compare every step; exit status 1 if one differs."),
    ] = False,
    start: Annotated[
        float | None, typer.Option("--from", metavar="T", help="Begin here, in s of simulated time.")
    ] = None,
    stop: Annotated[float | None, typer.Option("--to", metavar="T", help="End here, in s of simulated time.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the table as JSON.")] = False,
) -> None:
    """Tell what a recording holds; with --check, run it again and tell the first step that differs.

    \b
    Examples:
        stiction run ramp --record ramp.h5
        stiction replay ramp.h5
        stiction replay ramp.h5 --check
        stiction replay ramp.h5 --check --from 1.5 --to 2 --json
    """
    from stiction.record.recording import Recording

    with Recording.open(file) as recording:
        first = recording.step_at("--from", start, recording.first_step)
        last = recording.step_at("--to", stop, recording.last_step)
        if not check:
            _tell(recording, json)
            return
        from stiction.record.replay import check as run_again

        with progress(recording.title, json, "comparing", dt=recording.dt) as on_progress:
            result = run_again(recording, first * recording.dt, last * recording.dt, on_progress)
        if json:
            print_json({"file": str(file), "same": result.same, **asdict(result)})
        else:
            _tell_check(recording, result)
    if not result.same:
        raise typer.Exit(1)


def _facts(recording: Recording) -> dict[str, Any]:
    data = recording.metadata
    return {
        "title": recording.title,
        "steps": recording.last_step - recording.first_step,
        "from": recording.first_step * recording.dt,
        "to": recording.last_step * recording.dt,
        "dt": recording.dt,
        "solver": recording.solver,
        "bodies": len(recording.bodies),
        "frames": len(recording),
        "every": recording.every,
        "precision": recording.precision,
        "contacts": recording.has_contacts,
        "inputs": len(recording.inputs()),
        "snapshots": len(recording.checkpoint_steps),
        "outcome": recording.outcome,
        "bytes": recording.path.stat().st_size,
        "stiction_version": data.get("stiction_version"),
        "machine": data.get("machine", "not known"),
        "format_version": recording.format_version,
        "meta": data.get("meta", {}),
    }


def _tell(recording: Recording, json: bool) -> None:
    facts = _facts(recording)
    if json:
        print_json(facts)
        return
    made = table(recording.title, ["what", "value"])
    rows = {
        "time": f"{facts['from']:g} to {facts['to']:g} s in {facts['steps']} steps of {facts['dt']:.4g} s",
        "solver": facts["solver"],
        "bodies": str(facts["bodies"]),
        "frames": f"{facts['frames']}, every {facts['every']} steps, {facts['precision']} precision",
        "contacts": "kept" if facts["contacts"] else "not kept; found by running again",
        "inputs": str(facts["inputs"]),
        "snapshots": str(facts["snapshots"]),
        "outcome": facts["outcome"],
        "size": f"{facts['bytes'] / 1e6:.2f} MB",
        "made by": f"stiction {facts['stiction_version']} on {facts['machine']}",
        "format": str(facts["format_version"]),
        **{str(key): str(value) for key, value in facts["meta"].items()},
    }
    for key, value in rows.items():
        made.add_row(f"[bold]{key}[/]", value)
    out.print(made)
    say(f"compare it with the engine: stiction replay {recording.path} --check")


def _tell_check(recording: Recording, result: ReplayCheck) -> None:
    span = (
        f"steps {result.first} to {result.last} ({result.first * recording.dt:g} to {result.last * recording.dt:g} s)"
    )
    if result.differs_at is None:
        out.print(f"[green]same[/]: {span} end in the very bits that were recorded.")
    else:
        at = result.differs_at
        out.print(f"[red]differs[/]: of {span}, step {at} ({at * recording.dt:g} s) is the first that differs.")
    if result.bodies:
        numbers = ("position [m]", "angle [rad]", "velocity [m/s]", "spin [rad/s]")
        where = result.bodies[0]
        more = len(result.bodies) - MOST_ROWS
        made = table(
            f"First seen after step {where.step} ({where.time:g} s), {len(result.bodies)} bodies",
            ["body", *numbers], right=numbers, caption=f"and {more} more" if more > 0 else None,
        )  # fmt: skip
        for one in result.bodies[:MOST_ROWS]:
            differences = (one.position, one.angle, one.velocity, one.angular_velocity)
            made.add_row(one.name, *(f"{number:.3g}" for number in differences))
        out.print(made)
    for note in result.notes:
        out.print(f"note: {note}")
