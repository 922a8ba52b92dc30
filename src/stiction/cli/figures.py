"""What ``--plot`` asks for: a file, a kind of figure, or both as KIND=FILE."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from stiction.cli.console import say
from stiction.errors import InvalidInputError

if TYPE_CHECKING:
    from stiction.plot import Kind, Track


class Figure(NamedTuple):
    """A kind of figure and the picture that it goes into."""

    kind: Kind
    path: Path


def wanted(texts: list[str], stem: str, option: str = "--plot") -> list[Figure]:
    """The figures that some texts ask for, each one whose picture can be written.

    Args:
        texts: each FILE (of kind ``run``), KIND (into ``STEM-KIND.png`` in this folder) or KIND=FILE.
        stem: how names of pictures begin that nobody named.
        option: what a sentence calls the parameter.

    Raises:
        InvalidInputError: a kind is not known.
        OutputError: a picture cannot be written, or its ending names no known format.
    """
    if not texts:
        return []  # plots cost an import
    from stiction.checks import nearest, one_of
    from stiction.plot import KINDS
    from stiction.plot.canvas import check_path
    from stiction.plot.kinds import DEFAULT

    figures = []
    for text in texts:
        kind, equals, path = text.partition("=")
        if text in KINDS:
            kind, path = text, f"{stem}-{text}.png"
        elif equals and not set(kind) & set("./\\"):
            one_of(option, kind, KINDS)
        elif Path(text).suffix:
            kind, path = DEFAULT, text
        else:
            raise InvalidInputError(
                f"{option} must be a file such as run.png, one of {', '.join(KINDS)}, or both as cone=cone.png, "
                f"got {text!r}{nearest(text, KINDS)}."
            )
        figures.append(Figure(KINDS[kind], check_path(option, path, make_folder=True)))
    return figures


def check_bodies(figures: list[Figure], bodies: list[str] | None, known: list[str]) -> None:
    """Whether figures can show bodies of these names; those that show a whole world do not ask.

    Raises:
        InvalidInputError: there are too many names for a figure, or one is not known.
    """
    for kind, _ in figures:
        if kind.most != 0:
            kind.check_bodies(bodies, known)


def write(figures: list[Figure], track: Track, bodies: list[str] | None) -> None:
    """Draw figures of a run, and say where they are."""
    from stiction.plot import draw, save

    for kind, path in figures:
        save(draw(kind.name, track, bodies=bodies if kind.most != 0 else None), path)
        say(f"plot: {path}")
