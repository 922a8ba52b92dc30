"""``stiction bench``: how fast, beside other engines, and how well it stood meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stiction import outputs
from stiction.cli.console import complain, out, print_json, say, table
from stiction.cli.progress import counting
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.bench import Plan, Table


def bench(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="SCENE ...", help="Scenes (see --list); pyramid and pile if left out.")
    ] = None,
    against: Annotated[
        str, typer.Option(metavar="ENGINES", help="Peers with commas between them, or `all` installed, or `none`.")
    ] = "all",
    sizes: Annotated[
        str | None, typer.Option(metavar="N,N,...", help="Numbers of bodies, instead of each scene's own.")
    ] = None,
    steps: Annotated[int, typer.Option(help="Measured steps of a run.")] = 180,
    settle: Annotated[int, typer.Option(help="Steps before them, in which the scene settles.")] = 120,
    runs: Annotated[int, typer.Option(help="Runs of each engine, taken in turn.")] = 3,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 1.0 / 60.0,
    solver: Annotated[str | None, typer.Option(help="Solver of stiction, instead of its default.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of scenes that are drawn at random.")] = None,
    limit: Annotated[float, typer.Option(help="Wall time in s after which a run stops early.")] = 60.0,
    in_process: Annotated[bool, typer.Option("--in-process", help="Do not start a process for each run.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Draw time against number of bodies (PNG, SVG or PDF).")] = None,
    profile: Annotated[bool, typer.Option("--profile", help="Time of each stage of stiction's step.")] = False,
    list_: Annotated[bool, typer.Option("--list", help="List scenes and engines.")] = False,
) -> None:
    """Time scenes in stiction and in other engines, and say beside the time how deep bodies sink and what stands.

    Peers are installed with: pip install "stiction\\[peers]".

    \b
    Examples:
      stiction bench                      # pyramid and pile, all engines here
      stiction bench pile --against robox3d --sizes 1000,4000 --plot pile.png
      stiction bench card-house arch      # what stands, and how far it moved
      stiction bench heap --against none --profile
    """
    from stiction.bench import Plan, Table, run_plan

    if list_:
        _print_lists(json)
        return
    plan = Plan(
        scenes=tuple(names) if names else Plan.scenes,
        engines=_engines(against),
        sizes=_sizes(sizes),
        runs=runs,
        isolated=not in_process,
        solver=solver,
        dt=dt,
        settle=settle,
        steps=steps,
        limit=limit,
        seed=seed,
        profile=profile,
    )
    if plot is not None:
        from stiction.plot.canvas import check_path

        check_path("--plot", plot, make_folder=True)
        outputs.writable("--plot", plot)

    found = Table()
    interrupted = False
    try:
        total = len(list(plan.groups())) * len(plan.engines) * plan.runs
        with counting(total, json) as progress:
            run_plan(plan, found, progress)
    except KeyboardInterrupt:
        interrupted = True
        complain("interrupted; what was measured until then follows.")
    _show(plan, found, interrupted, json=json, profile=profile)
    if plot is not None and found:
        from stiction.bench import report

        report.plot(found, plot)
        say(f"plot: {plot}")
    if interrupted:
        raise typer.Exit(130)


def _engines(against: str) -> tuple[str, ...]:
    """stiction, and the peers that were asked for; those that are not installed are named and left out."""
    from stiction import checks
    from stiction.bench import installed
    from stiction.bench.engines import OWN, PEERS

    wanted = [name.strip() for name in against.split(",") if name.strip()]
    if wanted == ["none"]:
        return (OWN,)
    if wanted == ["all"]:
        wanted = list(PEERS)
    if not wanted:
        raise InvalidInputError(f"--against must name engines, 'all' or 'none', got {against!r}.")
    for name in wanted:
        checks.one_of("--against", name, (*PEERS, "all", "none"))
        if name not in PEERS:
            raise InvalidInputError(f"--against must be {name!r} alone or a list of engines, got {against!r}.")
    here = installed(wanted)
    for name in wanted:
        if name not in here:
            complain(f"{name} is left out: it is not installed (pip install {name}).")
    return (OWN, *dict.fromkeys(here))


def _sizes(text: str | None) -> tuple[int, ...]:
    if text is None:
        return ()
    try:
        sizes = tuple(int(part.replace("_", "")) for part in text.split(","))
    except ValueError:
        raise InvalidInputError(f"--sizes must be whole numbers with commas between them, got {text!r}.") from None
    if min(sizes) < 1:
        raise InvalidInputError(f"--sizes must be 1 or more, got {text!r}.")
    return sizes


def _show(plan: Plan, found: Table, interrupted: bool, *, json: bool, profile: bool) -> None:
    from stiction.bench import report

    if json:
        print_json(report.as_dict(plan, found, interrupted))
        return
    title = f"{plan.steps} steps of {plan.dt:.4g} s after {plan.settle} to settle, {plan.runs} runs, one thread"
    columns = ["scene", "bodies", "engine", *report.COLUMNS, "end"]
    made = table(title, columns, right=("bodies", *report.COLUMNS), caption=report.LEGEND)
    report.fill(made, found)
    out.print(made)
    for line in report.remarks(found):
        out.print(line)
    machine = report.machine()
    load = "" if machine["load"] is None else f", load {machine['load'][0]:.1f}"
    out.print(f"{machine['cpu']}, {machine['cores']} cores{load}; Python {machine['python']}")
    if profile:
        _show_stages(found)


def _show_stages(found: Table) -> None:
    from stiction.bench import report

    measured = report.stages(found)
    if any(parts is None for parts in measured.values()):
        out.print(f"Stages of a step: {report.NO_PROFILE}.")
    for (scene, bodies), parts in measured.items():
        if parts is None:
            continue
        whole = sum(parts.values())
        made = table(f"Stages of a step: {scene}, {bodies} bodies", ["stage", "ms/step", "share"], right=("ms/step",))
        for stage, ms in parts.items():
            made.add_row(stage.replace("_", " "), f"{ms:.4f}", f"{ms / whole:.0%}" if whole > 0.0 else "")
        out.print(made)


def _print_lists(json: bool) -> None:
    from stiction.bench import SCENES
    from stiction.bench.engines import ENGINES, engine_class
    from stiction.bench.report import engine_state

    if json:
        print_json(
            {
                "scenes": [
                    {"name": name, "title": e.title, "bodies": e.size, "sizes": e.scalable}
                    for name, e in SCENES.items()
                ],
                "engines": [
                    {"name": name, "state": engine_state(name), "settings": engine_class(name).notes}
                    for name in ENGINES
                ],
            }
        )
        return
    made = table("Scenes", ["scene", "bodies", "--sizes", "what it is"], right=("bodies",))
    for name, entry in SCENES.items():
        made.add_row(f"[bold]{name}[/]", str(entry.size), "yes" if entry.scalable else "", entry.title)
    out.print(made)
    made = table("Engines", ["engine", "version", "settings"])
    for name in ENGINES:
        made.add_row(f"[bold]{name}[/]", engine_state(name), engine_class(name).notes)
    out.print(made)
