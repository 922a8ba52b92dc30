"""The slides' question: what becomes of friction when the push ends, for a resting and for a moving object?"""

from __future__ import annotations

import warnings

import look
import numpy as np

import stiction as st

STATIC, DYNAMIC, G, DT = 0.5, 0.4, 9.81, 1 / 240
WEIGHT = 600 * G
SECONDS = 5.0
BELOW, ABOVE = (0.2, 1.2), (2.0, 3.49)
"""From when to when the crate is pushed, s: the first push stays below the static limit, the second goes beyond."""


def push(t: float) -> float:
    """The horizontal push at time t as a share of the weight: two ramps, each ended abruptly."""
    if BELOW[0] <= t < BELOW[1]:
        return min(0.7 * (t - BELOW[0]), 0.45)
    if ABOVE[0] <= t < ABOVE[1]:
        return min(0.6 * (t - ABOVE[0]), 0.6)
    return 0.0


def measure() -> np.ndarray:
    """Rows (time, push, friction, speed), forces in shares of the weight, from the engine."""
    world, crate = look.crate_on_floor((1.0, 1.0, 1.0), STATIC, DYNAMIC, dt=DT)
    rows = []
    for k in range(round(SECONDS / DT)):
        share = push((k + 0.5) * DT)
        if share:
            crate.apply_force((share * WEIGHT, 0, 0))
        world.step()
        friction = world.contacts(crate)["friction_impulse"][:, 0].sum() / DT
        rows.append(((k + 1) * DT, share, abs(friction) / WEIGHT, crate.velocity[0]))
    return np.array(rows)


def draw() -> None:
    """Draw ``push_and_release.png`` and print the extremes."""
    with warnings.catch_warnings():
        # just below the limit the iteration needs many more visits; what it leaves there is microns a second
        warnings.simplefilter("ignore", st.IterationLimitWarning)
        t, pushed, friction, speed = measure().T
    figure, (forces, speeds) = look.panels((5, 3), height=4.6, stacked=True)

    for level, name, dashes in ((STATIC, r"$\mu_s N$", (5, 2)), (DYNAMIC, r"$\mu_d N$", (1, 1.2))):
        forces.axhline(level, color=look.INK, lw=1.2, ls=(0, dashes))
        look.note(forces, name, (SECONDS + 0.03, level), look.INK, va="center", annotation_clip=False)
    forces.plot(t, pushed, color=look.MUTED, lw=1.6)
    forces.plot(t, friction, color=look.style.FRICTION, lw=2.6)
    look.note(forces, "push", (3.25, 0.615), look.MUTED, va="bottom", ha="center")
    look.note(forces, "friction", (3.0, 0.36), look.style.FRICTION, va="center")
    look.note(forces, "released at rest:\nnothing left", (1.25, 0.05), look.INK)
    look.note(forces, "breaks\naway", (2.76, 0.53), look.INK, ha="right", va="bottom")
    look.note(forces, "released in motion:\ngoes on until rest", (3.9, 0.1), look.INK)
    forces.set(xlim=(0, SECONDS), ylim=(-0.02, 0.72), ylabel="force / weight")
    forces.tick_params(labelbottom=False)

    speeds.plot(t, speed, color=look.RIGHT, lw=2.4)
    speeds.set(xlim=(0, SECONDS), ylim=(-0.06, 1.7), xlabel="time (s)", ylabel="speed (m/s)")
    figure.align_ylabels([forces, speeds])
    sliding = speed > 0.05
    print(
        f"largest friction while at rest {friction[~sliding].max():.4f}, in motion {np.median(friction[sliding]):.4f}"
    )
    look.save(figure, "push_and_release.png")


if __name__ == "__main__":
    draw()
