"""``stiction verify --fclib``: contact problems of a folder, measured."""

from __future__ import annotations

from pathlib import Path

import typer

from stiction.cli.console import complain, out, print_json, table
from stiction.cli.progress import counting
from stiction.verify.problems import COUNTS, DEFAULT, ProblemResult, Skipped, measure_files, problem_files

LEGEND = (
    "error: |r - P(r - (u + (mu |u_t|, 0, 0)))| / |q|, P projects onto the cones; after 10 to 1000 plain sweeps from "
    "zero (default: accelerated ones)"
)


def verify_problems(folder: Path, *, tolerance: float, sweeps: int, seconds: float, json: bool) -> None:
    """Measure all problems of a folder; exit status 1 if the default method misses the tolerance on one of them."""
    files = problem_files(folder)
    results: list[ProblemResult] = []
    skipped: list[Skipped] = []
    interrupted = False
    try:
        with counting(len(files), json) as on_begin:
            for found in measure_files(files, tolerance=tolerance, sweeps=sweeps, seconds=seconds, progress=on_begin):
                if isinstance(found, Skipped):
                    skipped.append(found)
                    complain(f"skipped: {found.reason}")
                else:
                    results.append(found)
    except KeyboardInterrupt:
        interrupted = True
        complain("interrupted; what was measured until then follows.")
    if json:
        print_json(
            {
                "tolerance": tolerance,
                "interrupted": interrupted,
                "problems": [result.as_dict() for result in results],
                "skipped": [file.as_dict() for file in skipped],
            }
        )
    else:
        _show(results, skipped, len(files), tolerance)
    if interrupted:
        raise typer.Exit(130)
    raise typer.Exit(0 if results and all(result.converged for result in results) else 1)


def _show(results: list[ProblemResult], skipped: list[Skipped], files: int, tolerance: float) -> None:
    after = [str(count) for count in COUNTS]
    columns = ["problem", "local solver", *after, "error", "sweeps", "s", ""]
    title = f"Contact problems, default method to {tolerance:g}"
    made = table(title, columns, right=(*after, "error", "sweeps", "s"), caption=LEGEND)
    for result in results:
        least, most = result.mu
        friction = f"mu {least:g}" if least == most else f"mu {least:g} to {most:g}"
        heads = iter((f"[bold]{result.problem}[/]", f"  {result.contacts} contacts", f"  {friction}"))
        for local, errors in result.errors.items():
            row = [next(heads, ""), local, *("–" if error is None else f"{error:.1e}" for error in errors.values())]
            if local == DEFAULT:
                newton = f" + {result.newton_steps}" if result.newton_steps else ""
                mark = "[green]converged[/]" if result.converged else "[red]MISSED[/]"
                row += [f"{result.error:.1e}", f"{result.sweeps}{newton}", f"{result.seconds:.2f}", mark]
            made.add_row(*row, end_section=local == DEFAULT)
    if results:
        out.print(made)
    if any(result.newton_steps for result in results):
        out.print("sweeps: what follows a + are steps of the proximal Newton method.")
    missed = sum(not result.converged for result in results)
    left = files - len(results) - len(skipped)
    tail = f", {len(skipped)} skipped" if skipped else ""
    tail += f", {left} not measured" if left else ""
    out.print(f"{len(results) - missed} converged, {missed} missed{tail}")
