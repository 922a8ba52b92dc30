"""``stiction verify``: closed-form cases, measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stiction.cli.console import out, print_json, table
from stiction.cli.progress import counting
from stiction.errors import InvalidInputError

NUMBERS = ("expected", "measured", "error", "tolerance")


def verify(
    cases: Annotated[list[str] | None, typer.Argument(help="Names of cases; all if left out.")] = None,
    solver: Annotated[str | None, typer.Option(help="Solver to measure: soft (the default), micro or exact.")] = None,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 1.0 / 60.0,
    json: Annotated[bool, typer.Option("--json", help="Print every measurement as JSON.")] = False,
    list_: Annotated[bool, typer.Option("--list", help="List the cases with formula and source.")] = False,
    against: Annotated[
        str | None,
        typer.Option(help="Ask other engines too: names with commas between them, all, or none (stiction alone)."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="With --against: draw the comparison (PNG, SVG or PDF).")] = None,
    html: Annotated[Path | None, typer.Option(help="With --against: write it as one HTML page.")] = None,
    markdown: Annotated[Path | None, typer.Option(help="With --against: write it as a Markdown page.")] = None,
    fclib: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Solve the contact problems of a folder instead (FCLIB's or Siconos' files)."),
    ] = None,
    tolerance: Annotated[float, typer.Option(help="With --fclib: error at which a problem is solved.")] = 1e-6,
    sweeps: Annotated[int, typer.Option(help="With --fclib: the most sweeps for a problem.")] = 100_000,
    seconds: Annotated[float, typer.Option(help="With --fclib: wall time in s for a problem.")] = 30.0,
) -> None:
    """Measure closed-form cases and compare; exit status 1 if one fails that this solver should pass.

    \b
    Examples:
      stiction verify                      # all cases, some minutes
      stiction verify slide-to-roll tip-or-slide --dt 0.004
      stiction verify --solver micro --json > micro.json
      stiction verify --against mujoco,rapier3d --plot friction.png
      stiction verify --fclib problems     # a folder of contact problems
    """
    if against is not None:
        from stiction.cli.against import Outputs
        from stiction.cli.against import against as ask_all

        ask_all(against, cases or [], solver, dt, json=json, list_=list_, outputs=Outputs(plot, html, markdown))
        return
    if plot or html or markdown:
        raise InvalidInputError("--plot, --html and --markdown go with --against.")
    if fclib is not None:
        if cases or solver is not None or list_:
            raise InvalidInputError("--fclib DIR measures contact problems alone: name no cases, --solver or --list.")
        from stiction.cli.verify_problems import verify_problems

        verify_problems(fclib, tolerance=tolerance, sweeps=sweeps, seconds=seconds, json=json)

    from stiction.verify import all_cases, run, summarise
    from stiction.world import World

    if list_:
        if json:
            keys = ("name", "title", "formula", "source", "solvers")
            print_json([{key: getattr(case, key) for key in keys} for case in all_cases()])
            return
        made = table("Cases", ["case", "what", "formula", "source", "solvers"])
        for case in all_cases():
            made.add_row(f"[bold]{case.name}[/]", case.title, case.formula, case.source, " ".join(case.solvers))
        out.print(made)
        return

    solver = World(solver=solver).solver
    with counting(len(cases or all_cases()), json) as on_begin:
        results = run(cases or None, solver=solver, dt=dt, progress=on_begin)
    summary = summarise(results)
    if json:
        print_json([row.as_dict() for row in results])
        raise typer.Exit(1 if summary.failed else 0)

    made = table(f"Verification of {solver!r} at dt = {dt:.4g} s", ["case", "what", *NUMBERS, ""], right=NUMBERS)
    for row in results:
        mark = "[green]pass[/]" if row.passed else "[yellow]known limit[/]" if row.known_limit else "[red]FAIL[/]"
        values = (f"{row.expected:.6g}", f"{row.measured:.6g}", f"{row.error:.2g}", f"{row.tolerance:.2g}")
        made.add_row(row.case, row.what, *values, mark)
    out.print(made)
    for name, reason in {row.case: row.reason for row in results if row.known_limit and not row.passed}.items():
        out.print(f"[yellow]{name}[/]: {reason}")
    if summary.surprises:
        out.print(f"[yellow]{summary.surprises} known limits passed: they are limits no more.[/]")
    passed = summary.passed + summary.surprises
    out.print(f"{passed} passed, {summary.failed} failed, {summary.known_limits} known limits of {solver!r}")
    raise typer.Exit(1 if summary.failed else 0)
