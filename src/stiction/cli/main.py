"""The command ``stiction``: one function a command, each in a file of its own."""

from __future__ import annotations

import sys
import traceback
import warnings
from typing import Annotated

import typer

from stiction import __version__
from stiction.cli import welcome
from stiction.cli.bench import bench
from stiction.cli.check import check
from stiction.cli.command import INTERRUPTED, Command, common
from stiction.cli.console import complain, hush
from stiction.cli.export import export
from stiction.cli.fit import fit
from stiction.cli.info import info
from stiction.cli.materials import materials
from stiction.cli.new import new
from stiction.cli.plot import plot
from stiction.cli.replay import replay
from stiction.cli.run import run
from stiction.cli.scenes import scenes
from stiction.cli.sweep import sweep
from stiction.cli.verify import verify
from stiction.cli.view import view
from stiction.cli.warmup import warmup
from stiction.errors import InvalidFileError, SimulationError, StictionError, StictionWarning

app = typer.Typer(
    name="stiction",
    help="Rigid-body physics in which friction is right.",
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (
    run,
    view,
    new,
    check,
    replay,
    plot,
    export,
    scenes,
    materials,
    verify,
    bench,
    sweep,
    fit,
    warmup,
    info,
):
    app.command(cls=Command)(common(command))


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"stiction {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Rigid-body physics in which friction is right."""
    if context.invoked_subcommand is None:
        welcome.show()


def main() -> None:
    """Entry point: what goes wrong becomes one sentence and an exit status.

    0 done, 1 what was checked failed, 2 bad input, 3 a world blew up, 70 a fault of stiction itself, 130 Ctrl-C.
    """
    hush(False)
    warnings.simplefilter("always", StictionWarning)
    warnings.showwarning = lambda message, *_, **__: complain(f"warning: {message}")
    try:
        app(prog_name="stiction")
    except SimulationError as error:
        complain(f"error: {error}")
        sys.exit(3)
    except InvalidFileError as error:
        complain(f"error: {error}")
        complain(f"all mistakes of the file: stiction check {error.file}")
        sys.exit(2)
    except StictionError as error:
        complain(f"error: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        complain("interrupted.")
        sys.exit(INTERRUPTED)
    except Exception:
        traceback.print_exc()
        complain("error: this is a fault of stiction itself; please report it with the lines above.")
        sys.exit(70)


if __name__ == "__main__":
    main()
