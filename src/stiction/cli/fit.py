"""``stiction fit``: coefficients from measured motion."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiction.cli.console import complain, out, print_json, say, table
from stiction.cli.progress import Pace, bar
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.fit import Fit, Problem, State


def fit(
    data: Annotated[Path, typer.Argument(metavar="DATA.csv", help="Measured motion.")],
    scene: Annotated[str, typer.Argument(help="What was measured: a built-in scene or a TOML file.")],
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY[=LOW:HIGH]",
            help="A number of the scene to be found, by the path of its key, and its range; KEY+KEY for two that "
            "are equal; repeatable.",
        ),
    ] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a value of the scene; repeatable.")
    ] = None,
    starts: Annotated[int, typer.Option(help="Searches from different values.")] = 3,
    loss: Annotated[str, typer.Option(help="linear, or what outliers move less: soft_l1, huber, cauchy.")] = "linear",
    bootstrap: Annotated[
        int, typer.Option(metavar="N", help="Intervals from N resampled data sets instead of the Jacobian.")
    ] = 0,
    trials: Annotated[
        int, typer.Option(metavar="N", help="Trials of Optuna before the search, for data with many local minima.")
    ] = 0,
    level: Annotated[float, typer.Option(help="Of the intervals: how often they hold the true value.")] = 0.9,
    sigma_mm: Annotated[float, typer.Option(help="Noise of a coordinate in mm; counts beside --sigma-deg.")] = 1.0,
    sigma_deg: Annotated[float, typer.Option(help="Noise of an orientation in degrees.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Of what is drawn at random.")] = 0,
    plot: Annotated[Path | None, typer.Option(help="Draw the residuals (PNG, SVG or PDF).")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Find coefficients of a scene from measured motion, with intervals, and say what the data do not tell.

    \b
    DATA.csv has a line of column names and then a sample a line:
      t            time in s from the start of the scene
      x y z        position in m; those that were measured
      qw qx qy qz  orientation, a unit quaternion; may be left out
      body         its name in the scene; may be left out for one body
    An empty cell is a sample that is missing.

    \b
    Examples (WOOD stands for materials.pairs.wood-concrete):
      stiction fit slide.csv my.toml --free WOOD.dynamic
      stiction fit pull.csv pull --free WOOD.static --free WOOD.dynamic
      stiction fit pull.csv pull --free WOOD.static+WOOD.dynamic=0.1:0.6
      stiction fit ball.csv my.toml --free WOOD.restitution \\
          --free "bodies.ball.velocity[2]=-1:1" --loss soft_l1 --plot left.png
      stiction fit tosses.csv my.toml --free WOOD.dynamic --bootstrap 200
    """
    from stiction.checks import one_of
    from stiction.fit import LOSSES, Problem, parse_all, read_csv
    from stiction.fit import fit as find
    from stiction.fit.report import as_dict, draw
    from stiction.plot.canvas import check_path
    from stiction.scene import load

    one_of("--loss", loss, LOSSES)
    for name, value, least in (("--starts", starts, 1), ("--bootstrap", bootstrap, 0), ("--trials", trials, 0)):
        if value < least:
            raise InvalidInputError(f"{name} must be {least} or more, got {value}.")
    if plot is not None:
        check_path("--plot", plot, make_folder=True)
    loaded = load(scene, list(set_ or []))
    parameters = parse_all(list(free or []), loaded.table)
    tracks = read_csv(data)
    problem = Problem(loaded, tracks, parameters, sigma=1e-3 * sigma_mm, sigma_angle=math.radians(sigma_deg))
    pace = Pace()
    with bar(json) as tell:
        made = find(
            problem,
            starts=starts,
            loss=loss,
            bootstrap=bootstrap,
            trials=trials,
            level=level,
            seed=seed,
            on_progress=lambda state: tell(state.phase, state.done, state.total, _told(state, pace)),
        )
    if json:
        print_json(as_dict(problem, made, level))
    else:
        _show(problem, made, level)
    if plot is not None and not made.interrupted:
        say(f"residuals: {draw(problem, made, plot)}")
    if made.interrupted:
        complain("interrupted: these are the best values so far, without intervals.")
        raise typer.Exit(130)


def _told(state: State, pace: Pace) -> str:
    pace.note(state.done)
    speed = f", {pace.rate:.3g}/s" if pace.rate else ""
    return f"{state.done} of at most {state.total} simulations{speed}, smallest misfit {state.rms:.4g} sigma"


def _show(problem: Problem, made: Fit, level: float) -> None:
    from stiction.fit.report import misfit

    share = f"{100.0 * level:g} % interval"
    numbers = ("value", share, "error")
    result = table(f"{problem.scene.title}: fitted", ["parameter", *numbers, "range"], right=numbers)
    for estimate in made.estimates:
        parameter = estimate.parameter
        limits = "–" if made.interrupted else f"{estimate.low:.5g} … {estimate.high:.5g}"
        error = f"{estimate.error:.2g}" if math.isfinite(estimate.error) else "–"
        value = f"{estimate.value:.5g}" if estimate.seen else f"[yellow]({estimate.value:.3g})[/]"
        result.add_row(parameter.name, value, limits, error, f"{parameter.low:g} … {parameter.high:g}")
    out.print(result)
    left = misfit(problem, made)
    told = [f"{1e3 * left['position']:.3g} mm" if left["position"] is not None else ""]
    told.append(f"{math.degrees(left['angle']):.3g} degrees" if left["angle"] is not None else "")
    out.print(
        f"{problem.count} numbers, {problem.simulations} simulations in {made.seconds:.1f} s; what is left over has a "
        f"root mean square of {' and '.join(part for part in told if part)} a coordinate."
    )
    for remark in made.remarks:
        out.print(f"[yellow]{remark}[/]")
