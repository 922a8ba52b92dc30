"""A comparison in words: cells, remarks, a Markdown page."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator

from stiction.verify.against.columns import OWN
from stiction.verify.against.comparison import Comparison
from stiction.verify.against.trial import Score, Trial

LEGEND = (
    "Each cell is the error of the worst variant: in % of what the formula says, or in the unit of the row where the "
    "formula says zero."
)
NOT_EXPRESSIBLE = "not expressible"


def cell(trial: Trial, score: Score) -> str:
    """The error in few characters; a dash where the engine cannot express the scene."""
    if score.skipped is not None:
        return "–"
    if score.failed is not None:
        return "failed"
    if not math.isfinite(score.error):
        return "never"
    if not trial.relative:
        return f"{number(score.error)} {trial.unit}"
    percent = 100.0 * score.error
    return "< 0.001 %" if percent < 0.001 else f"{number(percent)} %"


def number(value: float) -> str:
    """Two or three digits that matter, without an exponent where it can be told without one."""
    if value == 0.0 or 1e-3 <= value < 1e4:
        return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def tolerance(trial: Trial) -> str:
    """As text."""
    return f"{100.0 * trial.tolerance:g} %" if trial.relative else f"{number(trial.tolerance)} {trial.unit}"


def reading(trial: Trial, score: Score) -> str:
    """Expected and measured, in a sentence."""
    if score.skipped is not None:
        return f"{NOT_EXPRESSIBLE}: {score.skipped}"
    if score.failed is not None:
        return f"failed: {score.failed}"
    values = score.values or []
    low, high = min(values, default=math.nan), max(values, default=math.nan)
    spread = f"{low:.5g}" if len(values) < 2 else f"{low:.5g} to {high:.5g}"
    return f"expected {score.expected:.5g}, measured {spread} {trial.unit}"


def remarks(comparison: Comparison) -> list[str]:
    """Which engine could not be asked what and why, and what broke down; each reason once."""
    found: dict[str, list[str]] = {}
    for trial in comparison.trials:
        for engine in comparison.engines:
            score = comparison.score(trial.name, engine)
            if score.skipped is not None:
                found.setdefault(f"{engine}: {NOT_EXPRESSIBLE}: {_reason(score)}", []).append(trial.name)
            elif score.failed is not None:
                found.setdefault(f"{engine} failed, {score.failed}", []).append(trial.name)
    lines = [f"{reason} ({', '.join(names)})" for reason, names in found.items()]
    return [*(f"{name}: not installed ({how})" for name, how in comparison.missing.items()), *lines]


def _reason(score: Score) -> str:
    assert score.skipped is not None
    _, found, what = score.skipped.partition(" has ")
    return what if found else score.skipped


def honours(comparison: Comparison) -> Iterator[str]:
    """Where stiction fails, and where another engine comes nearer than it does, told one a line."""
    for trial in comparison.trials:
        own = comparison.score(trial.name, OWN)
        if own.passed is None:
            continue
        better = sorted(comparison.better(trial.name), key=lambda e: comparison.score(trial.name, e).error)
        peers = ", ".join(f"{engine} {cell(trial, comparison.score(trial.name, engine))}" for engine in better)
        if not own.passed:
            rest = f"; better: {peers}" if peers else "; no other engine comes nearer"
            yield f"**{trial.name}**: stiction fails ({cell(trial, own)}, tolerance {tolerance(trial)}){rest}."
        elif peers:
            yield f"**{trial.name}**: stiction passes with {cell(trial, own)}; better: {peers}."


def markdown(comparison: Comparison, picture: str | None = None) -> str:
    """The report as a page of the documentation, with a picture where there is one."""
    return "\n".join(_lines(comparison, picture)) + "\n"


def _lines(comparison: Comparison, picture: str | None) -> Iterator[str]:
    engines = comparison.engines
    yield "# Friction, engine by engine"
    yield ""
    yield "The same scenes, formulas and tolerances: what friction does in stiction and in other engines."
    yield f"{LEGEND} **Bold** is beyond the tolerance, a dash is a scene that the engine cannot express, *never* an"
    yield "event that did not come about. `python docs/make_friction_report.py` writes this page;"
    yield "`stiction verify --against all` prints the table for the engines that are installed."
    yield ""
    yield "## Result"
    yield ""
    yield f"| case | {' | '.join(engines)} | tolerance |"
    yield f"| --- |{' ---: |' * len(engines)} ---: |"
    for trial in comparison.trials:
        cells = []
        for engine in engines:
            score = comparison.score(trial.name, engine)
            text = cell(trial, score)
            cells.append(text if score.passed in (True, None) else f"**{text}**")
        yield f"| [{trial.name}](#{trial.name}) | {' | '.join(cells)} | {tolerance(trial)} |"
    counts = [comparison.passed(engine) for engine in engines]
    yield f"| passed, of those asked | {' | '.join(f'{a} of {b}' for a, b in counts)} | |"
    yield ""
    if picture is not None:
        yield f"![Errors of each engine in each case, and what was measured against what was expected]({picture})"
        yield ""
    yield "## Where stiction fails, or another engine is better"
    yield ""
    yield "Better is what comes nearer to the formula by a tenth of the tolerance or more."
    yield ""
    found = list(honours(comparison))
    yield from (f"- {line}" for line in found or ["Nowhere in this run."])
    yield ""
    yield "## What could not be asked"
    yield ""
    yield from (f"- {line}." for line in remarks(comparison) or ["Everything could"])
    yield ""
    yield "## Engines and settings"
    yield ""
    yield f"A frame is {1e3 * comparison.dt:.4g} ms; Python {platform.python_version()}. Damping and sleeping are off."
    yield ""
    yield "| engine | version | settings |"
    yield "| --- | --- | --- |"
    for engine in engines:
        yield f"| {engine} | {comparison.versions[engine]} | {comparison.settings[engine]} |"
    yield ""
    yield "A face of a rigid body has no law that says how its load is spread. stiction takes it for even"
    yield "(`docs/design`);"
    yield "engines that keep four corners as contact points stop a spinning crate 1.85 times as fast, which is"
    yield "no error of"
    yield "theirs in Coulomb's law, but one in the question that the spinning cases ask."
    yield ""
    yield "## Cases"
    yield ""
    for trial in comparison.trials:
        yield f"### {trial.name}"
        yield ""
        yield f"{trial.title[0].upper()}{trial.title[1:]}."
        yield ""
        yield f"- Formula: `{trial.formula}`"
        yield f"- Source: {trial.source}."
        yield f"- Tolerance: {tolerance(trial)} ({trial.tolerance_reason})."
        yield ""
        yield "| engine | |"
        yield "| --- | --- |"
        for engine in engines:
            yield f"| {engine} | {reading(trial, comparison.score(trial.name, engine))} |"
        yield ""
