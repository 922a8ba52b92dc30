"""``stiction export``: a recording in the forms of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiction.cli.console import say
from stiction.cli.progress import progress


def export(
    file: Annotated[Path, typer.Argument(help="A recording.")],
    out: Annotated[Path, typer.Argument(help="What to write; its ending says what: .glb, .parquet or .nc.")],
    start: Annotated[
        float | None, typer.Option("--from", metavar="T", help="Begin here, in s of simulated time.")
    ] = None,
    stop: Annotated[float | None, typer.Option("--to", metavar="T", help="End here, in s of simulated time.")] = None,
) -> None:
    """Write a recording as an animation (glTF, .glb), a table (Parquet) or arrays with names (NetCDF).

    \b
    Examples:
        stiction export ramp.h5 ramp.glb        # Blender: File, Import, glTF 2.0
        stiction export ramp.h5 ramp.parquet    # pandas.read_parquet; needs pyarrow
        stiction export ramp.h5 ramp.nc         # xarray.open_dataset; needs xarray
        stiction export ramp.h5 end.glb --from 2
    """
    from stiction.record.export import check_target, write
    from stiction.record.recording import Recording

    check_target("OUT", out)
    with Recording.open(file) as recording:
        title = recording.title
        with progress(title, doing="exporting", unit="frames", compiles=False) as on_progress:
            write(recording, out, start, stop, on_progress)
    say(f"{out.suffix[1:]}: {out}")
