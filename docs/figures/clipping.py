"""The scaled-back sticking impulse points the wrong way: one corner of a crate, sliding in every direction."""

from __future__ import annotations

import look
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from stiction import lecture

MU, SPEED, CLOSING = 0.4, 5.0, 0.1635
"""The closing speed is what gravity gives in 1/60 s; it hardly matters."""
SHAPES = (
    ("cube, 1 × 1 × 1 m", (1.0, 1.0, 1.0), look.LITERAL),
    ("plank, 2 × 0.4 × 0.2 m", (2.0, 0.4, 0.2), look.LITERAL_FINE),
)


def corner(size: tuple[float, float, float]) -> np.ndarray:
    """K of the corner +x, +y below a box of 1 kg on a floor; contact coordinates are down, y, x."""
    x, y, z = size
    inverse_inertia = np.diag([12 / (y * y + z * z), 12 / (x * x + z * z), 12 / (x * x + y * y)])
    basis = np.column_stack([(0, 0, -1), (0, 1, 0), (1, 0, 0)])  # the normal points down, into the floor
    return lecture.contact_matrix(basis, 1.0, inverse_inertia, np.array([x, y, -z]) / 2)


def friction_angles(size: tuple[float, float, float], directions: np.ndarray) -> np.ndarray:
    """Angles in rad from the slip that remains to friction (reversed), (k, 2): Coulomb's law and the clipped rule."""
    K = corner(size)
    angles = []
    for direction in directions:
        velocity = np.array([CLOSING, SPEED * np.sin(direction), SPEED * np.cos(direction)])
        row = []
        for g, _ in (lecture.coulomb_impulse(K, velocity, MU, MU), lecture.clipped_impulse(K, velocity, MU)):
            left = velocity - K @ g
            row.append(np.arctan2(left[2] * g[1] - left[1] * g[2], left[1:] @ g[1:]))
        angles.append(row)
    return np.array(angles)


def sketch(axes: Axes, size: tuple[float, float, float], color: str) -> None:
    """The crate from above, at the direction in which the clipped rule is worst: slip and friction at one corner."""
    directions = np.radians(np.arange(0.0, 360.0, 1.0))
    off = friction_angles(size, directions)[:, 1]
    worst = int(np.abs(off).argmax())
    at, half = directions[worst], np.array(size[:2]) / 2
    axes.grid(False)
    axes.set(xticks=[], yticks=[], aspect="equal", xlim=(-0.75, 1.45), ylim=(-0.75, 1.45))
    axes.spines[:].set_visible(False)
    axes.add_patch(Rectangle(-half, *(2 * half), facecolor="#f1e4d3", edgecolor=look.INK, lw=1.4))
    arrows = (
        ("slip of the corner", at, look.INK, {"ha": "right", "va": "bottom"}),
        ("Coulomb's law", at + np.pi, look.RIGHT, {"ha": "left", "va": "top"}),
        ("clipped", at + np.pi + off[worst], color, {"ha": "center", "va": "top"}),
    )
    for name, angle, paint, place in arrows:
        tip = half + 0.72 * np.array([np.cos(angle), np.sin(angle)])
        head = {"arrowstyle": "-|>", "color": paint, "lw": 2.2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 14}
        axes.annotate("", tip, half, arrowprops=head)
        look.note(axes, name, tuple(half + 0.76 * np.array([np.cos(angle), np.sin(angle)])), paint, **place)
    fan = at + np.pi + np.linspace(0.0, off[worst], 30)
    axes.plot(half[0] + 0.42 * np.cos(fan), half[1] + 0.42 * np.sin(fan), color=look.MUTED, lw=1.2)
    look.note(
        axes, f"{abs(np.degrees(off[worst])):.0f}° apart", (half[0] + 0.2, half[1] - 0.36), look.MUTED, va="center"
    )
    axes.plot(*half, "o", color=look.INK, ms=6)
    look.title(axes, "cube from above, its worst direction")


def draw() -> None:
    """Draw ``clipping.png`` and print the worst angles."""
    figure, (left, right) = look.panels((2, 3))
    sketch(left, SHAPES[0][1], SHAPES[0][2])
    directions = np.radians(np.arange(0.0, 361.0, 1.0))
    for name, size, color in SHAPES:
        angles = np.degrees(friction_angles(size, directions))
        coulomb, clipped = np.abs(angles).max(axis=0)
        print(f"{name}: at most {coulomb:.0e} degrees by Coulomb's law, {clipped:.1f} clipped")
        right.plot(np.degrees(directions), angles[:, 1], color=color, lw=2.0)
        right.plot(np.degrees(directions), angles[:, 0], color=look.RIGHT, lw=2.4)
    look.note(right, "clipped, " + SHAPES[1][0], (127, 41), SHAPES[1][2], ha="center", va="bottom")
    look.note(right, "clipped, " + SHAPES[0][0], (270, -40), SHAPES[0][2], ha="center", va="top")
    look.note(right, "Coulomb's\nlaw: 0", (366, 0), look.RIGHT, va="center", annotation_clip=False)
    look.title(right, "friction at one corner against the direction of sliding")
    right.set(xlim=(0, 360), xticks=np.arange(0, 361, 45), xlabel="direction of sliding (degrees from x)")
    right.set(ylim=(-52, 52), ylabel="friction off the slip (degrees)")
    look.save(figure, "clipping.png")


if __name__ == "__main__":
    draw()
