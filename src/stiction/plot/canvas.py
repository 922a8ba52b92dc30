"""What all figures share: an empty sheet, quiet axes, the choice of bodies, and the way into a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction import checks, outputs
from stiction.errors import InvalidInputError, OutputError
from stiction.motion import Motion
from stiction.record.frames import Frames
from stiction.view import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (9.6, 5.4)
"""Inches: 16 to 9, and type that can still be read when a page shows it at half its size."""
DPI = 150
LIMITS: dict[str, dict[str, Any]] = {
    "static": {"color": style.INK, "lw": 1.3, "ls": (0, (5, 2))},
    "dynamic": {"color": style.INK, "lw": 1.5, "ls": (0, (1, 1.2))},
}
"""Lines of the Coulomb limits."""
NAME = 28
"""Letters of a body's name that fit beside a line or above a small panel."""


def sheet(title: str, size: tuple[float, float] = SIZE) -> Figure:
    """An empty figure with a title, apart from pyplot, so that nothing global changes.

    Args:
        title: says what is shown, at the left edge.
        size: width and height in inches.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    layout = ConstrainedLayoutEngine(h_pad=0.08, w_pad=0.1)
    figure = Figure(figsize=size, layout=layout, facecolor=style.PAPER)
    figure.suptitle(title, x=0.012, ha="left", fontsize=14, fontweight="bold", color=style.INK)
    return figure


def dress(axes: Axes, size: float = 10.5) -> Axes:
    """Quiet axes: two spines, muted ticks, labels in ink; letters of that size in points."""
    axes.set_facecolor(style.PAPER)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(style.GRID_SECTION)
    axes.tick_params(colors=style.MUTED_INK, labelsize=size, length=3)
    axes.xaxis.label.set(color=style.INK, fontsize=size + 1)
    axes.yaxis.label.set(color=style.INK, fontsize=size + 1)
    return axes


def note(axes: Axes, text: str, xy: tuple[float, float], color: str = style.INK, **options: Any) -> None:
    """A label in the axes, beside what it names, on a ground of paper so that lines do not cross it."""
    ground = {"boxstyle": "square,pad=0.12", "fc": style.PAPER, "ec": "none", "alpha": 0.8}
    axes.annotate(text, xy, **{"color": color, "fontsize": 10, "bbox": ground, **options})


def legend(figure: Figure, handles: list[Any]) -> None:
    """One legend for the whole figure, below it."""
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=min(5, len(handles)),
        frameon=False,
        fontsize=10,
        labelcolor=style.INK,
        handlelength=1.8,
        columnspacing=1.5,
    )


def dot(color: str, label: str) -> Any:
    """A round mark for a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], ls="", marker="o", ms=6, color=color, label=label)


def limit_lines() -> list[Any]:
    """Both Coulomb limits for a legend."""
    from matplotlib.lines import Line2D

    texts = {"static": r"static limit $\mu_s N$", "dynamic": r"dynamic limit $\mu_d N$"}
    return [Line2D([], [], **LIMITS[key], label=text) for key, text in texts.items()]


def stick_and_slide() -> list[Any]:
    """The two states of a contact for a legend."""
    return [dot(style.MOTION_COLORS[m], m.word) for m in (Motion.STICKING, Motion.SLIDING)]


def short(name: str) -> str:
    """A name that fits."""
    return name if len(name) <= NAME else name[: NAME - 1] + "…"


def choose(frames: Frames, bodies: list[str] | None, most: int) -> tuple[list[int], str]:
    """Numbers of the bodies to show, and a note for the title if some that move are left out.

    Args:
        frames: the run.
        bodies: their names; by default the first ones that can move.
        most: how many can be shown.

    Raises:
        InvalidInputError: there are no frames or nothing in them can move; or ``bodies`` is empty, too long, or names
            a body that is not there.
    """
    if not len(frames):
        raise InvalidInputError("frames must hold at least one frame, got 0.")
    names = [body.name for body in frames.bodies]
    if bodies is not None:
        if not 1 <= len(bodies) <= most:
            raise InvalidInputError(f"bodies must be 1 to {most} names, got {len(bodies)}.")
        return [names.index(checks.one_of("bodies", name, names)) for name in bodies], ""
    movers = [n for n, body in enumerate(frames.bodies) if not body.fixed]
    if not movers:
        raise InvalidInputError("frames must hold at least one body that is not fixed, got none.")
    remark = f"  ({most} of {len(movers)} moving bodies)" if len(movers) > most else ""
    return movers[:most], remark


def check_path(name: str, path: str | Path, *, make_folder: bool = False) -> Path:
    """The path, if a picture can be written there.

    Args:
        name: what the sentence calls the parameter.
        path: of the picture.
        make_folder: make the folder if it is missing.

    Raises:
        OutputError: the file cannot be written, or its ending names no known format.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    target = Path(path)
    known = FigureCanvasAgg.get_supported_filetypes()
    if target.suffix[1:].lower() not in known:
        raise OutputError(f"{name} must end in one of {', '.join(sorted(known))}, got {str(target)!r}.")
    return outputs.writable(name, target, make_folder=make_folder)


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure as a picture; the ending (png, svg, pdf) chooses the format, its folder must exist.

    Returns:
        The path.

    Raises:
        OutputError: the picture cannot be written, or its ending names no known format.
    """
    target = check_path("path", path)
    try:
        figure.savefig(target, dpi=DPI)
    except OSError as error:
        raise outputs.not_writable("path", target, error) from error
    return target
