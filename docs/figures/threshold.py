"""When does a crate on a slope begin to slide? How far it has got after two seconds, over the slope."""

from __future__ import annotations

import warnings

import look
import numpy as np

import stiction as st

STATIC, DYNAMIC, G, SECONDS = 0.6, 0.4, 9.81, 2.0
SLOPES = (0.1, 0.2, 0.3, 0.4, 0.45, 0.5, 0.55, 0.58, 0.59, 0.595, 0.605, 0.61, 0.62, 0.65, 0.7, 0.75, 0.8)
RUNS = (
    ("Coulomb's law, dt = 1/240 s", 1 / 240, False, "o", look.RIGHT),
    ("slides, dt = 1/60 s", 1 / 60, True, "o", look.LITERAL),
    ("slides, dt = 1/240 s", 1 / 240, True, "s", look.LITERAL_FINE),
)


def exact(tan: np.ndarray) -> np.ndarray:
    """Zero up to the static coefficient, then (g sin - mu_d g cos) t^2 / 2, m."""
    angle = np.arctan(tan)
    sliding = 0.5 * G * (np.sin(angle) - DYNAMIC * np.cos(angle)) * SECONDS**2
    return np.where(tan > STATIC, sliding, 0.0)


def distance(tan: float, dt: float, literal: bool) -> float:
    """How far a crate that is set down at rest gets in two seconds, in whatever direction, m, from the engine."""
    gravity = look.tilted_gravity(tan, G)
    world, crate = look.crate_on_floor((1.0, 1.0, 1.0), STATIC, DYNAMIC, dt=dt, literal=literal, gravity=gravity)
    world.run(SECONDS)
    return float(np.linalg.norm(crate.position[:2]))


def draw() -> None:
    """Draw ``threshold.png`` and print what was measured."""
    figure, (linear, logarithmic) = look.panels((1, 1), height=3.6)
    below, above = np.linspace(0.05, STATIC, 2), np.linspace(STATIC + 1e-6, 0.85, 100)
    for axes in (linear, logarithmic):
        axes.axvline(STATIC, color=look.INK, lw=1.0, ls=(0, (5, 2)))
        axes.axvline(DYNAMIC, color=look.INK, lw=1.2, ls=(0, (1, 1.2)))
        axes.plot(below, exact(below), color=look.EXACT, lw=7, solid_capstyle="round")
        axes.plot(above, exact(above), color=look.EXACT, lw=7, solid_capstyle="round")
    for name, dt, literal, marker, color in RUNS:
        with warnings.catch_warnings():
            # within half a percent of the threshold the iteration needs more visits than the limit allows
            warnings.simplefilter("ignore", st.IterationLimitWarning)
            measured = np.array([distance(tan, dt, literal) for tan in SLOPES])
        print(name, dict(zip(SLOPES, measured.round(6).tolist(), strict=True)))
        linear.plot(SLOPES, measured, marker, color=color, ms=5)
        logarithmic.plot(SLOPES, measured, marker + "-", color=color, ms=5, lw=1.0)

    for level, name in ((STATIC, r"$\mu_s$"), (DYNAMIC, r"$\mu_d$")):
        look.note(linear, name, (level - 0.01, 7.45), ha="right", va="top")
    look.title(linear, "distance after 2 s")
    look.note(linear, "closed form (grey)\nand Coulomb's law,\ndt = 1/240 s", (0.1, 4.4), look.RIGHT)
    look.note(linear, "both runs\nof the slides", (0.63, 0.35), look.LITERAL)
    linear.set(xlim=(0.05, 0.85), ylim=(-0.3, 7.5), xlabel=r"slope $\tan\theta$", ylabel="distance (m)")
    look.title(logarithmic, "the same, logarithmic")
    look.note(logarithmic, "slides, 1/60 s", (0.84, 0.2), look.LITERAL, ha="right")
    look.note(logarithmic, "slides, 1/240 s", (0.84, 0.009), look.LITERAL_FINE, ha="right")
    look.note(logarithmic, "Coulomb's law", (0.08, 1.6e-6), look.RIGHT)
    logarithmic.set(xlim=(0.05, 0.85), ylim=(1e-7, 30), yscale="log", xlabel=r"slope $\tan\theta$")
    look.save(figure, "threshold.png")


if __name__ == "__main__":
    draw()
