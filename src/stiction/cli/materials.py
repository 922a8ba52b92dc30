"""``stiction materials``: look up the coefficients of a pair."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction.cli.console import out, print_json, table
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.pair_properties import PairProperties

NUMBERS = ("static", "dynamic", "restitution", "rolling [m]", "torsional [m]")


def materials(
    a: Annotated[str | None, typer.Argument(help="A material, such as rubber.")] = None,
    b: Annotated[str | None, typer.Argument(help="The material it touches, such as concrete.")] = None,
    table_name: Annotated[
        str, typer.Option("--table", help="default, or lecture: the nine rows of the slides.")
    ] = "default",
    json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Print the coefficients of a pair of materials and where they come from; without names, the whole table.

    \b
    Examples:
      stiction materials rubber concrete
      stiction materials --table lecture    # the nine rows of the slides
      stiction materials wood ice --json
    """
    from stiction import checks
    from stiction.materials import MaterialTable

    tables = {"default": MaterialTable.default, "lecture": MaterialTable.lecture}
    chosen = tables[checks.one_of("--table", table_name, tables)]()
    if a is not None and b is None:
        raise InvalidInputError(f"materials must be named in pairs, got only {a!r}; name the one it touches too.")
    rows: list[tuple[str, str, PairProperties]]
    rows = [(a, b, chosen.pair(a, b))] if a is not None and b is not None else list(chosen.pairs())
    if json:
        print_json([_as_dict(x, y, pair) for x, y, pair in rows])
        return
    made = table("Material pairs", ["pair", *NUMBERS, "source"], right=NUMBERS)
    for x, y, pair in rows:
        numbers = (pair.static, pair.dynamic, pair.restitution, pair.rolling, pair.torsional)
        made.add_row(f"{x} - {y}", *(f"{value:g}" for value in numbers), pair.source)
    out.print(made)


def _as_dict(a: str, b: str, pair: PairProperties) -> dict[str, Any]:
    return {"a": a, "b": b, **asdict(pair), "law": pair.law.as_dict()}
