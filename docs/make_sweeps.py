"""Draw the map of sweeps.md and write its tables: ``python docs/make_sweeps.py`` (half a minute)."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from markers import replace

from stiction.sweep import load, make_backend, run_sweep
from stiction.sweep.expressions import MATH
from stiction.sweep.figure import compare, draw
from stiction.sweep.measures import MEASURES, usage

PAGE = Path(__file__).with_name("sweeps.md")
PICTURE = Path(__file__).with_name("_static") / "slip-tip-hold.png"


def main() -> None:
    """Run the example, draw, write."""
    sweep = load("slip-tip-hold")
    with tempfile.TemporaryDirectory() as folder:
        outcome = run_sweep(sweep, folder, lambda: make_backend("local"))
    draw(sweep, outcome.columns, PICTURE)
    verdict = compare(sweep, outcome.columns)
    if verdict is None or outcome.failed:
        raise SystemExit(f"the example must run, and {outcome.failed} of its runs failed.")
    told = f"{verdict.agree} of {verdict.runs} runs do what the closed form says"
    beside = f"; {verdict.beside} of the others lie at its boundary" if verdict.agree < verdict.runs else ""
    replace(PAGE, "example", [f"![{sweep.title}](_static/{PICTURE.name})", "", f"*{told}{beside}.*"])
    replace(PAGE, "functions", _functions())
    replace(PAGE, "math", [", ".join(f"`{name}`" for name in sorted(MATH)) + "."])


def _functions() -> Iterable[str]:
    yield "| function | what it gives |"
    yield "| --- | --- |"
    for name, text in MEASURES.items():
        yield f"| `{usage(name)}` | {text} |"


if __name__ == "__main__":
    main()
