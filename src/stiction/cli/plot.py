"""``stiction plot``: figures of a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiction.cli.console import out, print_json, table
from stiction.cli.figures import check_bodies, wanted, write
from stiction.cli.progress import progress
from stiction.errors import InvalidInputError


def plot(
    recording: Annotated[Path | None, typer.Argument(help="A recording (HDF5) that `stiction run` made.")] = None,
    figures: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FILE|KIND|KIND=FILE]...",
            help="What to draw: a kind goes into RECORDING-KIND.png unless a file (PNG, SVG or PDF) is named.",
        ),
    ] = None,
    body: Annotated[list[str] | None, typer.Option(help="Show this body; repeatable.")] = None,
    repeat: Annotated[
        bool,
        typer.Option(
            "--repeat",
            help="Run the scene again, for every step instead of the recorded frames (figures of contacts that "
            "were not recorded run it again in any case).",
        ),
    ] = False,
    list_: Annotated[bool, typer.Option("--list", help="List the kinds of figures.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """Draw figures of a recorded run.

    \b
    Examples:
      stiction run stick-slip --record run.h5
      stiction plot run.h5 raster phase=phase.svg
      stiction plot run.h5 energy
      stiction plot run.h5 hodograph --repeat
      stiction plot --list
    """
    from stiction.plot import KINDS, from_recording, observe

    if list_:
        _list(json)
        return
    if recording is None:
        raise InvalidInputError("recording must be given, unless --list is.")
    if not figures:
        raise InvalidInputError(f"figures must be given: one or more of {', '.join(KINDS)}, or files.")
    track = from_recording(recording)
    chosen = wanted(figures, recording.stem, "figures")
    check_bodies(chosen, body, [one.name for one in track.frames.bodies])
    for figure in chosen:
        if figure.kind.energies and track.energies is None and not repeat:
            raise InvalidInputError(
                f"figures must not hold {figure.kind.name!r} unless --repeat is given: a recording of format 1 has no "
                f"energies; its scene, run again, tells them."
            )
    # most figures are of contacts, which a recording has only where they were asked for
    lacking = repeat or not track.frames.meta.get("contacts", True)
    again = [figure for figure in chosen if lacking and (repeat or figure.kind.contacts)]
    write([figure for figure in chosen if figure not in again], track, body)
    if again:
        from stiction.record.hdf5 import restore

        seconds = float(track.frames.times[-1]) if len(track.frames) > 1 else None
        simulation = restore(recording)
        with progress(track.frames.title, dt=simulation.world.dt) as on_progress:
            write(again, observe(simulation, seconds, on_progress=on_progress), body)


def _list(as_json: bool) -> None:
    from stiction.plot import KINDS

    if as_json:
        print_json([{"kind": kind.name, "text": kind.text} for kind in KINDS.values()])
        return
    made = table("Figures", ["kind", "what it shows"], caption="Draw one with: stiction run SCENE --plot KIND")
    for kind in KINDS.values():
        made.add_row(f"[bold]{kind.name}[/]", kind.text)
    out.print(made)
