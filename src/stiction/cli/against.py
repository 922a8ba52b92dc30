"""``stiction verify --against``: stiction and other engines, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from stiction.cli.console import out, print_json, table
from stiction.cli.progress import counting

if TYPE_CHECKING:
    from stiction.verify.against import Comparison


class Outputs(NamedTuple):
    """Files that a comparison is written to, where they are wanted."""

    plot: Path | None
    html: Path | None
    markdown: Path | None


def engines_named(text: str) -> tuple[str, ...]:
    """Names with commas between them; ``all`` means all there are adapters for, ``none`` only stiction."""
    from stiction import checks
    from stiction.verify.against import PEERS

    names = [name.strip() for name in text.split(",") if name.strip()]
    if names == ["all"]:
        return PEERS
    if names == ["none"]:
        return ()
    return tuple(checks.one_of("--against", name, (*PEERS, "all", "none")) for name in names)


def against(
    engines: str, trials: list[str], solver: str | None, dt: float, *, json: bool, list_: bool, outputs: Outputs
) -> None:
    """Compare and print; exit status 1 if stiction fails a trial."""
    from stiction import outputs as files
    from stiction.verify.against import OWN, all_trials, compare

    if list_:
        if json:
            keys = ("name", "title", "formula", "source")
            print_json([{key: getattr(trial, key) for key in keys} for trial in all_trials()])
            return
        made = table("Trials", ["trial", "what", "formula", "source"])
        for trial in all_trials():
            made.add_row(f"[bold]{trial.name}[/]", trial.title, trial.formula, trial.source)
        out.print(made)
        return
    for option, path in outputs._asdict().items():
        if path is not None:
            files.writable(f"--{option}", path)
    with counting(quiet=json) as on_begin:
        found = compare(engines_named(engines), trials, dt, solver, progress=on_begin)
    _write(found, outputs)
    if json:
        print_json(found.as_dict())
    else:
        _print(found)
    passed, asked = found.passed(OWN)
    raise typer.Exit(0 if passed == asked else 1)


def _write(found: Comparison, outputs: Outputs) -> None:
    if outputs.plot is not None:
        from stiction.verify.against.plot import save

        save(found, outputs.plot)
    if outputs.html is not None:
        from stiction.verify.against.page import page

        outputs.html.write_text(page(found), encoding="utf-8")
    if outputs.markdown is not None:
        from stiction.verify.against.report import markdown

        outputs.markdown.write_text(markdown(found), encoding="utf-8")


def _print(found: Comparison) -> None:
    from stiction.verify.against.report import LEGEND, cell, remarks, tolerance

    title = f"Friction, engine by engine, at dt = {found.dt:.4g} s"
    made = table(title, ["trial", *found.engines, "tolerance"], right=(*found.engines, "tolerance"), caption=LEGEND)
    for trial in found.trials:
        cells = []
        for engine in found.engines:
            score = found.score(trial.name, engine)
            style = "dim" if score.passed is None else "green" if score.passed else "red"
            cells.append(f"[{style}]{cell(trial, score)}[/]")
        made.add_row(trial.name, *cells, f"[dim]{tolerance(trial)}[/]")
    made.add_section()
    made.add_row("passed", *("{} of {}".format(*found.passed(engine)) for engine in found.engines), "")
    out.print(made)
    for engine in found.engines:
        out.print(f"[bold]{engine}[/] {found.versions[engine]}: {found.settings[engine]}")
    for line in remarks(found):
        out.print(f"[yellow]{line}[/]")
