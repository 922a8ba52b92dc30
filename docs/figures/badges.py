"""The badges of the README, drawn from what pyproject.toml says: licence, Python, types. They claim nothing else."""

from __future__ import annotations

import tomllib
from pathlib import Path

import look

PROJECT = Path(__file__).resolve().parent.parent.parent / "pyproject.toml"
LETTER = 6.6
"""Mean width of a letter at 11 px, in px."""


def badge(left: str, right: str, color: str) -> str:
    """An SVG of two words."""
    a, b = (round(LETTER * len(text)) + 14 for text in (left, right))
    font = 'font-family="Verdana,DejaVu Sans,sans-serif" font-size="11" fill="#fff" text-anchor="middle"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{a + b}" height="20" role="img" aria-label="{left}: {right}">'
        f'<clipPath id="r"><rect width="{a + b}" height="20" rx="3"/></clipPath><g clip-path="url(#r)">'
        f'<rect width="{a}" height="20" fill="#4a5560"/><rect x="{a}" width="{b}" height="20" fill="{color}"/></g>'
        f'<g {font}><text x="{a / 2}" y="14">{left}</text><text x="{a + b / 2}" y="14">{right}</text></g></svg>\n'
    )


def draw() -> None:
    """Write the three of them."""
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))
    texts = {
        "licence": (project["project"]["license"], "#008f68"),
        "python": (project["project"]["requires-python"].removeprefix(">=") + " or newer", "#0072b2"),
        "types": ("mypy strict" if project["tool"]["mypy"]["strict"] else "mypy", "#6a3d9a"),
    }
    for name, (text, color) in texts.items():
        left = "Python" if name == "python" else name
        (look.FOLDER / f"badge-{name}.svg").write_text(badge(left, text, color), encoding="utf-8")


if __name__ == "__main__":
    draw()
