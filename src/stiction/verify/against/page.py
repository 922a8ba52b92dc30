"""A comparison as one HTML page that needs nothing else: table, picture, formulas, sources, settings."""

from __future__ import annotations

import io
import platform
from collections.abc import Iterator
from html import escape

from stiction.verify.against.columns import OWN
from stiction.verify.against.comparison import Comparison
from stiction.verify.against.plot import colour, deviations, ink_on
from stiction.verify.against.report import LEGEND, cell, honours, reading, remarks, tolerance

STYLE = """
:root { --ink: #22303a; --dim: #66737c; --paper: #fbfcfc; --line: #dfe4e6; --card: #ffffff; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 40px 24px 80px; }
h1 { font-size: 32px; letter-spacing: -0.02em; margin: 0 0 6px; }
h2 { font-size: 20px; margin: 44px 0 12px; }
p.lead { color: var(--dim); max-width: 76ch; margin: 0 0 22px; }
.scores { display: flex; flex-wrap: wrap; gap: 10px; margin: 0 0 26px; }
.scores div { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 10px 16px; }
.scores b { display: block; font-size: 22px; font-variant-numeric: tabular-nums; }
.scores span { color: var(--dim); font-size: 13px; }
.scores .own { border-color: #0b6e75; box-shadow: inset 0 0 0 1px #0b6e75; }
.wide { overflow-x: auto; }
table { border-collapse: separate; border-spacing: 3px; width: 100%; }
th { font-weight: 600; text-align: left; font-size: 13px; padding: 4px 8px; white-space: nowrap; }
td { padding: 5px 8px; font-size: 13px; }
table.map td { text-align: center; border-radius: 5px; font-variant-numeric: tabular-nums; white-space: nowrap; }
table.map td.pass { font-weight: 600; }
table.map thead th { text-align: center; }
table.map thead th.limit { text-align: right; }
table.map td.limit { text-align: right; color: var(--dim); background: none; }
table.map th a { color: inherit; text-decoration: none; border-bottom: 1px dotted var(--dim); }
.scale { display: flex; align-items: center; gap: 8px; color: var(--dim); font-size: 12px; margin: 8px 0 0; }
.scale i { display: inline-block; width: 30px; height: 12px; border-radius: 3px; }
section.case { border-top: 1px solid var(--line); padding: 14px 0 10px; }
section.case h3 { margin: 0; font-size: 16px; }
section.case p { margin: 2px 0 6px; }
section.case :is(th, td), table.plain :is(th, td) { border-bottom: 1px solid var(--line); }
section.case table, table.plain { border-spacing: 0; }
section.case table { table-layout: fixed; }
section.case th { width: 150px; overflow: hidden; text-overflow: ellipsis; }
section.case td.error { width: 130px; text-align: right; font-variant-numeric: tabular-nums; }
section.case i { display: inline-block; width: 10px; height: 10px; border-radius: 3px; margin-right: 8px; }
code { background: #eef2f3; border-radius: 4px; padding: 1px 5px; font-size: 13px; }
.dim { color: var(--dim); font-size: 13px; }
svg { width: 100%; height: auto; background: #fff; border: 1px solid var(--line); border-radius: 10px; }
"""


def page(comparison: Comparison) -> str:
    """The page as text."""
    return "\n".join(_lines(comparison)) + "\n"


def _lines(comparison: Comparison) -> Iterator[str]:
    yield "<!doctype html>"
    yield '<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    yield f"<title>Friction, engine by engine</title><style>{STYLE}</style></head><body><main>"
    yield "<h1>Friction, engine by engine</h1>"
    yield f'<p class="lead">The same scenes, formulas and tolerances for all. {escape(LEGEND)} Green and bold is within'
    yield " the tolerance, a dash is a scene that the engine cannot express, <i>never</i> an event that did not come"
    yield " about.</p>"
    yield '<div class="scores">'
    for engine in comparison.engines:
        passed, asked = comparison.passed(engine)
        own = ' class="own"' if engine == OWN else ""
        yield f"<div{own}><b>{passed} of {asked}</b><span>{escape(engine)}</span></div>"
    yield "</div>"
    yield from _map(comparison)
    found = list(honours(comparison))
    yield "<h2>Where stiction fails, or another engine is better</h2>"
    yield '<p class="lead">Better is what comes nearer to the formula by a tenth of the tolerance or more.</p><ul>'
    for line in found or ["Nowhere in this run."]:
        yield f"<li>{escape(line).replace('**', '<b>', 1).replace('**', '</b>', 1)}</li>"
    yield "</ul><h2>Expected against measured</h2>"
    yield '<p class="lead">On which side of the formula each engine is, and how far, in tolerances; the green band is'
    yield " within.</p>"
    yield _svg(comparison)
    yield "<h2>What could not be asked</h2><ul>"
    yield from (f"<li>{escape(line)}</li>" for line in remarks(comparison) or ["Everything could."])
    yield "</ul>"
    yield "<h2>Engines and settings</h2>"
    yield f'<p class="dim">A frame is {1e3 * comparison.dt:.4g} ms. Damping and sleeping are off. Python '
    yield f"{platform.python_version()}, {escape(platform.system())} {escape(platform.machine())}.</p>"
    yield '<table class="plain">'
    for engine in comparison.engines:
        version, settings = comparison.versions[engine], comparison.settings[engine]
        yield f"<tr><th>{escape(engine)}</th><td>{escape(version)}</td><td>{escape(settings)}</td></tr>"
    yield "</table><h2>Cases</h2>"
    yield from _cases(comparison)
    yield "</main></body></html>"


def _map(comparison: Comparison) -> Iterator[str]:
    """The table, which is a heat map at the same time."""
    yield '<div class="wide"><table class="map"><thead><tr><th></th>'
    width = f"{70.0 / len(comparison.engines):.4g}%"
    yield "".join(f'<th style="width:{width}">{escape(engine)}</th>' for engine in comparison.engines)
    yield '<th class="limit">tolerance</th></tr></thead>'
    for trial in comparison.trials:
        yield f'<tr><th><a href="#{trial.name}">{trial.name}</a></th>'
        for engine in comparison.engines:
            score = comparison.score(trial.name, engine)
            fill = colour(score.severity)
            ink = "#9aa3a9" if score.passed is None else ink_on(fill)
            kind = ' class="pass"' if score.passed else ""
            title = escape(reading(trial, score), quote=True)
            text = escape(cell(trial, score))
            yield f'<td{kind} style="background:{fill};color:{ink}" title="{title}">{text}</td>'
        yield f'<td class="limit">{escape(tolerance(trial))}</td></tr>'
    yield "</table></div>"
    within, beyond = (
        "".join(f'<i style="background:{colour(k)}"></i>' for k in side)
        for side in ((-4, -3, -2, -1, -0.1), (0.1, 1, 2, 3, 4))
    )
    yield f'<p class="scale">10⁻⁴ of the tolerance {within} <b>tolerance</b> {beyond} 10⁴ times it</p>'


def _svg(comparison: Comparison) -> str:
    import matplotlib

    stream = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "stiction"}):
        deviations(comparison).savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]


def _cases(comparison: Comparison) -> Iterator[str]:
    for trial in comparison.trials:
        yield f'<section class="case" id="{trial.name}"><h3>{trial.name}</h3>'
        yield f"<p>{escape(trial.title[0].upper() + trial.title[1:])}.</p>"
        yield f'<p><code>{escape(trial.formula)}</code> <span class="dim">{escape(trial.source)}.</span></p>'
        yield f'<p class="dim">Tolerance {escape(tolerance(trial))}: {escape(trial.tolerance_reason)}.</p><table>'
        for engine in comparison.engines:
            score = comparison.score(trial.name, engine)
            yield f"<tr><th>{escape(engine)}</th><td>{escape(reading(trial, score))}</td>"
            swatch = f'<i style="background:{colour(score.severity)}"></i>'
            yield f'<td class="error">{swatch}{escape(cell(trial, score))}</td></tr>'
        yield "</table></section>"
