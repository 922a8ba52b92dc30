"""Rewrite the tables of verification.md from runs: ``python docs/make_verification.py`` (about five minutes).

Everything between two markers ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->`` is replaced, the rest stays as it is.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from markers import replaced

from stiction import verify

PAGE = Path(__file__).with_name("verification.md")
COARSE, FINE = 1.0 / 60.0, 1.0 / 240.0
STEPS = {"soft": (COARSE, FINE), "micro": (COARSE, FINE), "exact": (FINE,)}
"""Time steps of each solver, s; the tables of the cases have the first one."""

Runs = dict[tuple[str, float], list[verify.Result]]


def main() -> None:
    """Run all cases with all solvers and write the page."""
    runs: Runs = {}
    for solver, steps in STEPS.items():
        for dt in steps:
            print(f"{solver}, dt = 1/{1.0 / dt:.0f} s", file=sys.stderr)
            runs[solver, dt] = verify.run(
                solver=solver, dt=dt, progress=lambda name: print(f"  {name} ...", file=sys.stderr)
            )
    text = PAGE.read_text(encoding="utf-8")
    text = replaced(text, "counts", _counts(runs), PAGE.name)
    text = replaced(text, "overview", _overview(runs), PAGE.name)
    text = replaced(text, "failures", _failures(runs), PAGE.name)
    text = replaced(text, "limits", _limits(runs), PAGE.name)
    text = replaced(text, "cases", _cases(runs), PAGE.name)
    PAGE.write_text(text, encoding="utf-8")


def _counts(runs: Runs) -> Iterable[str]:
    yield "| solver | time step | measurements | passed | failed | known limits | known limits that pass |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for (solver, dt), rows in runs.items():
        counts = " | ".join(str(n) for n in verify.summarise(rows))
        yield f"| `{solver}` | 1/{1.0 / dt:.0f} s | {len(rows)} | {counts} |"


def _overview(runs: Runs) -> Iterable[str]:
    """One line a case and solver: the row that comes nearest to its tolerance."""
    yield "| case | formula | solver | rows | nearest to its tolerance | expected | measured | error | tolerance |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for case in verify.all_cases():
        name, formula = f"[{case.name}](#{case.name})", _code(case.formula)
        for solver, (dt, *_) in STEPS.items():
            own = [row for row in runs[solver, dt] if row.case == case.name and not row.known_limit]
            if not own:
                continue
            worst = max(own, key=_share)
            mark = f"`{solver}`" + ("" if worst.passed else " **FAILS**")
            numbers = (
                f"{worst.expected:.6g} | {worst.measured:.6g} {worst.unit} | {worst.error:.1e} | {worst.tolerance:.1e}"
            )
            yield f"| {name} | {formula} | {mark} | {len(own)} | {_cell(worst.what)} | {numbers} |"
            name, formula = "", ""


def _share(row: verify.Result) -> float:
    """Error over tolerance; what was not measured at all is the worst."""
    return row.error / row.tolerance if math.isfinite(row.error) else math.inf


def _failures(runs: Runs) -> Iterable[str]:
    """One line a row that failed although nothing excuses it."""
    rows = [(dt, row) for (_, dt), own in runs.items() for row in own if not row.passed and not row.known_limit]
    if not rows:
        yield "None."
        return
    yield "| solver | time step | case | what | expected | measured | error | tolerance |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for dt, row in rows:
        numbers = f"{row.expected:.6g} | {row.measured:.6g} {row.unit} | {row.error:.1e} | {row.tolerance:.1e}"
        link = f"[{row.case}](#{row.case})"
        yield f"| `{row.solver}` | 1/{1.0 / dt:.0f} s | {link} | {_cell(row.what)} | {numbers} |"


def _limits(runs: Runs) -> Iterable[str]:
    """One line a known limit, its size at both time steps; then the reasons."""
    yield "| solver | case | what | expected | tolerance | at 1/60 s | at 1/240 s |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for solver, steps in STEPS.items():
        found = [[row for row in runs[solver, dt] if row.known_limit] for dt in steps]
        for row, *others in zip(*found, strict=True):
            what = _cell(row.what.partition(" (")[0])  # a case may name its worst run in brackets, which depends on dt
            sizes = [_size(row), *map(_size, others)]
            sizes = ["", *sizes] if len(sizes) == 1 else sizes
            numbers = f"{row.expected:.4g} {row.unit} | {row.tolerance:.1e} | {' | '.join(sizes)}"
            yield f"| `{solver}` | [{row.case}](#{row.case}) | {what} | {numbers} |"
    yield ""
    for case in verify.all_cases():
        for solver, reason in case.known_limit.items():
            yield f"- **{case.name}** (`{solver}`): {reason}."


def _size(row: verify.Result) -> str:
    """What was measured, and by how much that is off where it can be told as a share."""
    off = f" ({100.0 * row.error / abs(row.expected):.2g} % off)" if row.expected else ""
    return f"{row.measured:.3g} {row.unit}{off}{', passes' if row.passed else ''}"


def _cases(runs: Runs) -> Iterable[str]:
    """A section a case, with the tolerances and the rows of all solvers."""
    of_case = {
        solver: {name: list(group) for name, group in groupby(runs[solver, dt], key=lambda row: row.case)}
        for solver, (dt, *_) in STEPS.items()
    }
    for case in verify.all_cases():
        yield f"### {case.name}"
        yield ""
        yield f"{case.title[0].upper()}{case.title[1:]}."
        yield ""
        yield f"- Formula: `{case.formula}`"
        yield f"- Source: {case.source}."
        if len(case.solvers) == 1:
            yield f"- For `{case.solvers[0]}` only."
        shared = len({case.tolerance_of(solver) for solver in case.solvers}) == 1
        for solver in case.solvers[:1] if shared else case.solvers:
            tolerance, why = case.tolerance_of(solver)
            yield f"- Tolerance{'' if shared else f' of `{solver}`'}: `{tolerance}`"
            yield f"- Why: {why}."
        yield ""
        yield "| solver | what | expected | measured | error | tolerance | |"
        yield "| --- | --- | --- | --- | --- | --- | --- |"
        for solver in STEPS:
            for row in of_case[solver].get(case.name, []):
                mark = "pass" if row.passed else "known limit" if row.known_limit else "**FAIL**"
                yield (
                    f"| `{solver}` | {_cell(row.what)} | {row.expected:.7g} {row.unit} | {row.measured:.7g} | "
                    f"{row.error:.1e} | {row.tolerance:.1e} | {mark} |"
                )
        yield ""


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _code(text: str) -> str:
    return f"`{_cell(text)}`"


if __name__ == "__main__":
    main()
