"""The command ``stiction``: one function a command, each in a file of its own."""

from __future__ import annotations

import sys
import warnings
from typing import Annotated

import typer

from stiction import __version__
from stiction.cli.bench import bench
from stiction.cli.console import complain
from stiction.cli.export import export
from stiction.cli.fit import fit
from stiction.cli.materials import materials
from stiction.cli.plot import plot
from stiction.cli.replay import replay
from stiction.cli.run import run
from stiction.cli.scenes import scenes
from stiction.cli.sweep import sweep
from stiction.cli.verify import verify
from stiction.cli.view import view
from stiction.cli.warmup import warmup
from stiction.errors import SimulationError, StictionError, StictionWarning

app = typer.Typer(
    name="stiction",
    help="Rigid-body physics in which friction is right.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (run, view, replay, plot, export, scenes, materials, verify, bench, sweep, fit, warmup):
    app.command()(command)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"stiction {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Rigid-body physics in which friction is right."""


def main() -> None:
    """Entry point: errors of stiction become one sentence and an exit status (2 bad input, 3 blow-up, 130 Ctrl-C)."""
    warnings.simplefilter("always", StictionWarning)
    warnings.showwarning = lambda message, *_, **__: complain(f"warning: {message}")
    try:
        app()
    except SimulationError as error:
        complain(f"error: {error}")
        sys.exit(3)
    except StictionError as error:
        complain(f"error: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        complain("interrupted.")
        sys.exit(130)


if __name__ == "__main__":
    main()
