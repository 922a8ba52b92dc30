"""Rewrite the tables of verification.md from a run: ``python docs/make_verification.py`` (about a minute).

Everything between two markers ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->`` is replaced, the rest stays as it is.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from stiction import verify

PAGE = Path(__file__).with_name("verification.md")
SOLVER = "micro"
COARSE, FINE = 1.0 / 60.0, 1.0 / 240.0


def main() -> None:
    """Run all cases at two time steps and write the page."""
    runs = {}
    for dt in (COARSE, FINE):
        print(f"dt = 1/{1.0 / dt:.0f} s", file=sys.stderr)
        runs[dt] = verify.run(solver=SOLVER, dt=dt, progress=lambda name: print(f"  {name} ...", file=sys.stderr))
    text = PAGE.read_text(encoding="utf-8")
    text = _replace(text, "counts", _counts(runs))
    text = _replace(text, "overview", _overview(runs[COARSE]))
    text = _replace(text, "limits", _limits(runs[COARSE], runs[FINE]))
    text = _replace(text, "cases", _cases(runs[COARSE]))
    PAGE.write_text(text, encoding="utf-8")


def _replace(text: str, name: str, lines: Iterable[str]) -> str:
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
    before, _, rest = text.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise SystemExit(f"{PAGE.name} has no markers for {name!r}.")
    return f"{before}{begin}\n" + "\n".join(lines) + f"\n\n{end}{after}"


def _counts(runs: dict[float, list[verify.Result]]) -> Iterable[str]:
    yield "| time step | measurements | passed | failed | known limits | known limits that pass |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for dt, rows in runs.items():
        yield f"| 1/{1.0 / dt:.0f} s | {len(rows)} | " + " | ".join(str(n) for n in verify.summarise(rows)) + " |"


def _overview(rows: list[verify.Result]) -> Iterable[str]:
    """One line a case: its formula, and the row that comes nearest to its tolerance."""
    yield "| case | formula | rows | nearest to its tolerance | expected | measured | error | tolerance |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for name, group in groupby((row for row in rows if not row.known_limit), key=lambda row: row.case):
        own = list(group)
        worst = max(own, key=lambda row: row.error / row.tolerance)
        link = f"[{name}](#{name}){'' if worst.passed else ' **FAILS**'}"
        numbers = (
            f"{worst.expected:.6g} | {worst.measured:.6g} {worst.unit} | {worst.error:.1e} | {worst.tolerance:.1e}"
        )
        yield f"| {link} | {_code(worst.formula)} | {len(own)} | {_cell(worst.what)} | {numbers} |"


def _limits(coarse: list[verify.Result], fine: list[verify.Result]) -> Iterable[str]:
    """One line a known limit, its size at both time steps; then the reasons."""
    yield "| case | what | expected | tolerance | at 1/60 s | at 1/240 s |"
    yield "| --- | --- | --- | --- | --- | --- |"
    limits = [row for row in coarse if row.known_limit]
    for row, other in zip(limits, (row for row in fine if row.known_limit), strict=True):
        what = _cell(row.what.partition(" (")[0])  # a case may name its worst run in brackets, which depends on dt
        sizes = f"{_size(row)} | {_size(other)}"
        yield f"| [{row.case}](#{row.case}) | {what} | {row.expected:.4g} {row.unit} | {row.tolerance:.1e} | {sizes} |"
    yield ""
    for case in verify.all_cases():
        if SOLVER in case.known_limit:
            yield f"- **{case.name}**: {case.known_limit[SOLVER]}."


def _size(row: verify.Result) -> str:
    """What was measured, and by how much that is off where it can be told as a share."""
    off = f" ({100.0 * row.error / abs(row.expected):.2g} % off)" if row.expected else ""
    return f"{row.measured:.3g} {row.unit}{off}{', passes' if row.passed else ''}"


def _cases(rows: list[verify.Result]) -> Iterable[str]:
    """A section a case."""
    cases = {case.name: case for case in verify.all_cases()}
    for name, group in groupby(rows, key=lambda row: row.case):
        case = cases[name]
        yield f"### {name}"
        yield ""
        yield f"{case.title[0].upper()}{case.title[1:]}."
        yield ""
        yield f"- Formula: `{case.formula}`"
        yield f"- Source: {case.source}."
        yield f"- Tolerance: `{case.tolerance}`"
        yield f"- Why: {case.tolerance_reason}."
        yield ""
        yield "| what | expected | measured | error | tolerance | |"
        yield "| --- | --- | --- | --- | --- | --- |"
        for row in group:
            mark = "pass" if row.passed else "known limit" if row.known_limit else "**FAIL**"
            yield (
                f"| {_cell(row.what)} | {row.expected:.7g} {row.unit} | {row.measured:.7g} | {row.error:.1e} | "
                f"{row.tolerance:.1e} | {mark} |"
            )
        yield ""


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _code(text: str) -> str:
    return f"`{_cell(text)}`"


if __name__ == "__main__":
    main()
