"""``stiction sweep``: many runs of a scene, as one table and one map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction.cli.console import complain, out, print_json, say, table
from stiction.cli.progress import bar, span
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.sweep import Outcome, Progress, Sweep, SweepPlan

MOST_ERRORS = 3
"""Different errors that are shown."""


def sweep(
    spec: Annotated[
        str | None, typer.Argument(help="A sweep's TOML file, or the name of a built-in sweep (see --list).")
    ] = None,
    out_: Annotated[
        Path | None, typer.Option("--out", metavar="FOLDER", help="Folder of the sweep; SPEC.sweep if left out.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what the folder holds.")] = False,
    retry: Annotated[bool, typer.Option("--retry", help="With --resume: do failed runs again.")] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Say how many runs, how long and how large, and stop.")] = False,
    backend: Annotated[str, typer.Option(help="Where to run: local, ray, or inline (this process).")] = "local",
    workers: Annotated[int | None, typer.Option(help="Runs at a time; one a core if left out.")] = None,
    address: Annotated[
        str | None, typer.Option(help="With --backend ray: a cluster, such as auto; a Ray here if left out.")
    ] = None,
    table_: Annotated[
        Path | None,
        typer.Option("--table", metavar="FILE", help="The table (.parquet or .csv), instead of the folder's."),
    ] = None,
    map_: Annotated[
        Path | None, typer.Option("--map", metavar="FILE", help="The map (PNG, SVG or PDF), instead of the folder's.")
    ] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Change a value of the scene; repeatable.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print plan or result as JSON.")] = False,
    list_: Annotated[bool, typer.Option("--list", help="List the built-in sweeps.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Print the sweep's file, to start your own from.")] = False,
    functions: Annotated[bool, typer.Option("--functions", help="List what metrics can ask of a run.")] = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON schema of sweep files.")] = False,
) -> None:
    """Run a scene many times with different values, and make a table of what came of it.

    Parquet files need pyarrow, --backend ray needs Ray: pip install "stiction\\[sweep]" or "stiction\\[ray]".

    Exit status 1 if no run finished without an error.

    \b
    Examples:
      stiction sweep slip-tip-hold --plan    # how many runs, how long, how large
      stiction sweep slip-tip-hold           # 441 runs: a table and a map
      stiction sweep slip-tip-hold --show > my.toml
      stiction sweep my.toml --workers 2 --set bodies.crate.mass=20
      stiction sweep my.toml --resume        # go on after a stop or a kill
      stiction sweep my.toml --backend ray --address auto
    """
    from stiction import sweep as sweeps

    if list_ or functions or schema:
        _print_lists(json, functions=functions, schema=schema)
        return
    if spec is None:
        raise InvalidInputError(f"SPEC must be a TOML file or one of {', '.join(sweeps.builtin_names())}, got nothing.")
    if show:
        print(_text(spec), end="")
        return
    if retry and not resume:
        raise InvalidInputError("--retry goes with --resume.")
    sweeps.check_backend(backend, workers, address)
    loaded = sweeps.load(spec, set_ or [])
    if map_ is not None:
        _check_map(loaded, map_)
    if plan:
        _print_plan(loaded, _plan(loaded, 1 if backend == "inline" else workers, quiet=json), json)
        return

    folder = out_ or Path(f"{loaded.name}.sweep")
    with bar(json) as tell:
        outcome = sweeps.run_sweep(
            loaded,
            folder,
            lambda: sweeps.make_backend(backend, workers, address),
            path=table_,
            resume=resume,
            retry=retry,
            on_progress=lambda now: tell(now.phase, now.done, now.total, _told(now)),
        )
    picture = None
    if loaded.table.map is not None and outcome.done:
        from stiction.sweep.figure import draw

        picture = draw(loaded, outcome.columns, map_ or folder / "map.png")
    _show(loaded, outcome, picture, json)
    if outcome.interrupted:
        complain(f"interrupted; go on with: stiction sweep {spec} --out {folder} --resume")
        raise typer.Exit(130)
    if outcome.done == outcome.failed:
        raise typer.Exit(1)


def _text(spec: str) -> str:
    from stiction.scene.load import is_path, read_text
    from stiction.sweep import builtin_text

    return read_text(Path(spec), "sweep file") if is_path(spec) else builtin_text(spec)


def _check_map(loaded: Sweep, path: Path) -> None:
    from stiction.plot.canvas import check_path

    if loaded.table.map is None:
        raise InvalidInputError(f"--map needs a [map] in the sweep, and {loaded.name!r} has none.")
    check_path("--map", path, make_folder=True)


def _plan(loaded: Sweep, workers: int | None, *, quiet: bool) -> SweepPlan:
    from stiction.sweep import make_plan
    from stiction.sweep.backends.local import cores

    if not quiet:
        say("trying some runs …")
    return make_plan(loaded, workers or cores())


def _print_plan(loaded: Sweep, plan: SweepPlan, json: bool) -> None:
    if json:
        print_json({"sweep": loaded.name, **plan.as_dict()})
        return
    made = table(loaded.title, ["", ""])
    varying = ", ".join(f"{name}: {count}" for name, count in plan.parameters.items())
    made.add_row("runs", f"{plan.runs} ({varying})")
    made.add_row("a run", f"{plan.steps} steps, {span(plan.seconds_per_run)}; at most {span(plan.slowest)}")
    made.add_row("together", f"{span(plan.seconds)} with {plan.workers} workers")
    made.add_row("on disk", f"table {_size(plan.table_bytes)}, journals {_size(plan.journal_bytes)}")
    made.add_row("tried", f"{plan.tried} runs, {plan.failed} failed")
    out.print(made)
    if plan.first_error:
        complain(f"a run failed: {plan.first_error}")


def _told(now: Progress) -> str:
    failed = f", {now.failed} failed" if now.failed else ""
    speed = f", {now.rate:.3g}/s, {span(now.left)} left" if now.rate and now.done < now.total else ""
    return f"{now.done}/{now.total}{failed}{speed}"


def _show(loaded: Sweep, outcome: Outcome, picture: Path | None, json: bool) -> None:
    from stiction.sweep.figure import compare

    verdict = compare(loaded, outcome.columns) if picture is not None else None
    if json:
        print_json(
            {
                "sweep": loaded.name,
                "runs": outcome.total,
                "done": outcome.done,
                "failed": outcome.failed,
                "found": outcome.found,
                "deaths": outcome.deaths,
                "workers": outcome.workers,
                "seconds": outcome.seconds,
                "runs_per_second": outcome.rate,
                "interrupted": outcome.interrupted,
                "table": str(outcome.path),
                "map": None if picture is None else str(picture),
                "closed_form": None if verdict is None else vars(verdict),
                "metrics": {name: _spread(outcome.columns[name]) for name in loaded.job.metrics},
            }
        )
        return
    made = table(loaded.title, ["metric", "least", "mean", "most", "none"], right=("least", "mean", "most", "none"))
    for name in loaded.job.metrics:
        spread = _spread(outcome.columns[name])
        made.add_row(name, *(_number(spread[key]) for key in ("least", "mean", "most")), str(spread["none"]))
    out.print(made)
    session = outcome.done - outcome.found
    hands = f"{outcome.workers} worker{'s' if outcome.workers != 1 else ''}"
    speed = f", {outcome.rate:.3g} runs/s with {hands}" if outcome.rate else ""
    found = f" ({outcome.found} of them before)" if outcome.found else ""
    out.print(
        f"{outcome.done} of {outcome.total} runs finished{found}, {outcome.failed} failed; "
        f"{session} in {span(outcome.seconds)}{speed}."
    )
    if outcome.deaths:
        out.print(f"Workers died {outcome.deaths} times; what they had finished was kept, the rest done again.")
    if verdict is not None:
        off = verdict.runs - verdict.agree
        others = (
            f"; of the others, {verdict.beside} lie at its boundary and {off - verdict.beside} do not" if off else ""
        )
        out.print(f"{verdict.agree} of {verdict.runs} runs do what the closed form says{others}.")
    errors = dict.fromkeys(error for error in outcome.columns["error"] if error)
    for error in list(errors)[:MOST_ERRORS]:
        complain(f"a run failed: {error}")
    if len(errors) > MOST_ERRORS:
        complain(f"and {len(errors) - MOST_ERRORS} more kinds of errors: see the column error.")
    say(f"table: {outcome.path}")
    if picture is not None:
        say(f"map: {picture}")


def _spread(values: list[Any]) -> dict[str, Any]:
    """Least, mean and most of a metric; a flag counts as 0 or 1; texts have none of these."""
    known = [float(v) for v in values if v is not None and not isinstance(v, str) and math.isfinite(v)]
    none = sum(value is None or (isinstance(value, float) and math.isnan(value)) for value in values)
    if not known:
        return {"least": None, "mean": None, "most": None, "none": none}
    return {"least": min(known), "mean": sum(known) / len(known), "most": max(known), "none": none}


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _size(size: float) -> str:
    for unit in ("B", "kB", "MB"):
        if size < 1000.0:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} GB"


def _print_lists(json: bool, *, functions: bool, schema: bool) -> None:
    from stiction.sweep import builtin_names, load

    if schema:
        from stiction.sweep.load import json_schema

        print_json(json_schema())
        return
    if functions:
        from stiction.sweep.expressions import CONSTANTS, MATH
        from stiction.sweep.measures import MEASURES, usage

        if json:
            print_json({"measures": MEASURES, "math": sorted(MATH), "constants": CONSTANTS})
            return
        made = table("What metrics can ask of a run", ["function", "gives"])
        for name, text in MEASURES.items():
            made.add_row(f"[bold]{usage(name)}[/]", text)
        out.print(made)
        out.print(f"Besides: {', '.join(sorted(MATH))}; the names time, dt, g, pi, inf, nan.")
        out.print("And every parameter, and every metric that stands before.")
        return
    loaded = {name: load(name) for name in builtin_names()}
    if json:
        print_json([{"name": name, "title": s.title, "runs": len(s.points)} for name, s in loaded.items()])
        return
    made = table(
        "Built-in sweeps", ["sweep", "runs", "what"], right=("runs",), caption="Run one with: stiction sweep NAME"
    )
    for name, entry in loaded.items():
        made.add_row(f"[bold]{name}[/]", str(len(entry.points)), entry.title)
    out.print(made)
