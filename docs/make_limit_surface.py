"""Rewrite the table and the figure of design/limit-surface.md: ``python docs/make_limit_surface.py`` (a minute)."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).with_name("figures")))

import look

from stiction.core.friction.patch import onto_surface
from stiction.core.vec import Vec3
from stiction.verify import limit_surface as exact
from stiction.verify.patch_errors import SHAPES, Element, errors

PAGE = Path(__file__).with_name("design") / "limit-surface.md"
CENTERS = 40
BORDER = 0.97
"""Of the way from the middle to the border: farther out nobody can say what a pressure is."""


def main() -> None:
    """Measure all shapes, write the table, draw the figure."""
    text = PAGE.read_text(encoding="utf-8")
    begin, end = "<!-- errors: begin -->\n", "<!-- errors: end -->"
    before, _, rest = text.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise SystemExit(f"{PAGE.name} has no markers.")
    PAGE.write_text(f"{before}{begin}\n" + "\n".join(_table()) + f"\n\n{end}{after}", encoding="utf-8")
    _draw()


def _groups() -> dict[str, list[str]]:
    names = [name for name in SHAPES if not name.startswith("quadrilateral")]
    quadrilaterals = [name for name in SHAPES if name.startswith("quadrilateral")]
    return {**{name: [name] for name in names}, "irregular quadrilaterals, 12": quadrilaterals}


def _table() -> Iterable[str]:
    yield "| face | even | in the kern | T | beyond it | T |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for title, names in _groups().items():
        even, kern, beyond = [], [], []
        for name in names:
            polygon, middle = SHAPES[name], exact.moments(SHAPES[name])[1]
            rng = np.random.default_rng(3)
            kept = exact.regular(4) if name == "disc" else Element(polygon).kept
            weights = rng.dirichlet(np.full(len(kept), 0.7), size=CENTERS)
            near = rng.uniform(size=(CENTERS, 1)) * 0.4
            centers = middle + BORDER * (weights @ kept - middle)
            centers = np.vstack([middle[None], middle + near * (weights @ kept - middle), centers])
            rows = np.stack(errors(polygon, centers, name == "disc"), axis=1)
            whole = [exact.face_without_tension(polygon, c) for c in centers]
            area = exact.moments(polygon)[0]
            inside = np.array([exact.moments(face.polygon)[0] > area * (1.0 - 1e-9) for face in whole])
            even.append(rows[:1])
            kern.append(rows[inside])
            beyond.append(rows[~inside])
        cells = [_errors(np.vstack(even)), *_cells(np.vstack(kern)), *_cells(np.vstack(beyond))]
        yield f"| {title} | " + " | ".join(cells) + " |"


def _errors(rows: np.ndarray) -> str:
    return f"{100 * rows[:, 0].max():.2f}, {100 * rows[:, 1].max():.1f}"


def _cells(rows: np.ndarray) -> tuple[str, str]:
    low, high = 100 * (rows[:, 2].min() - 1.0), 100 * (rows[:, 2].max() - 1.0)
    mean = 100 * np.sqrt((rows[:, 0] ** 2).mean())
    return f"{mean:.1f}; {_errors(rows)}", f"{low:+.1f} to {high:+.1f}"


def _draw() -> None:
    """T_m from the middle to the border of three faces, and three sections of limit surfaces."""
    figure, (left, right) = look.panels((1.0, 1.0), height=3.6)
    ways = {
        "square, to a corner": (exact.rectangle(1, 1), np.array([0.5, 0.5])),
        "square, to a side": (exact.rectangle(1, 1), np.array([0.5, 0.0])),
        "triangle, to its tip": (exact.regular(3), np.array([1.0, 0.0])),
    }
    part = np.linspace(0.0, 0.97, 40)
    for (title, (polygon, end)), color in zip(ways.items(), (look.RIGHT, look.LITERAL, look.LITERAL_FINE), strict=True):
        element, middle = Element(polygon), exact.moments(polygon)[1]
        centers = [middle + f * (end - middle) for f in part]
        wanted = [exact.mean_arm(exact.face_without_tension(polygon, c), c) for c in centers]
        left.plot(part, wanted, color=look.EXACT, lw=6)
        left.plot(part, [element.at(c).torque for c in centers], color=color, lw=1.5, label=title)
    left.set(xlabel="centre of pressure, from the middle to the border", ylabel="torque of spinning, m", ylim=(0, None))
    left.legend(frameon=False, fontsize=9)
    look.title(left, "A load that shifts shortens the arm")

    polygon = SHAPES["slender triangle"]
    middle = exact.moments(polygon)[1]
    patch = Element(polygon).at(middle)
    angle = np.linspace(0.0, np.pi, 400)[1:-1]
    for direction, color, title in ((0, look.RIGHT, "along it"), (1, look.LITERAL, "across it")):
        twists = np.zeros((len(angle), 3))
        twists[:, :2] = np.cos(angle)[:, None] * patch.axes[:, direction]
        twists[:, 2] = np.sin(angle) / patch.torque
        found = exact.friction_about(exact.even_face(polygon), middle, twists)
        right.plot(found[:, :2] @ patch.axes[:, direction], found[:, 2] / patch.torque, color=look.EXACT, lw=6)
        dense = exact.directions(40_000)
        g = np.array([onto_surface(Vec3(*way), patch.surface) for way in dense])
        push = np.zeros_like(twists)
        push[:, direction], push[:, 2] = np.cos(angle), np.sin(angle)
        best = g[(push @ g.T).argmax(axis=1)]
        right.plot(best[:, direction], best[:, 2], color=color, lw=1.5, label=title)
    right.set(
        xlabel="force / mu N",
        ylabel="torque / greatest torque",
        xlim=(-1.1, 1.1),
        ylim=(0, 1.25),
        xticks=np.linspace(-1.0, 1.0, 5),
    )
    right.legend(frameon=False, fontsize=9, title="a slender triangle slides")
    look.title(right, "Friction of a lopsided face (pale: exact)")
    print(look.save(figure, "limit-surface.png"))


if __name__ == "__main__":
    main()
