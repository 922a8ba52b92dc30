"""A sliding crate comes to rest: Coulomb's law and the slides' two literal rules against the closed form."""

from __future__ import annotations

import look
import numpy as np

from stiction import lecture

SPEED, STATIC, DYNAMIC, G = 5.0, 0.5, 0.4, 9.81
CRATE = (1.0, 1.0, 0.2)
"""A flat one, so that the literal rule's jolts do not throw it over."""


def slide(dt: float, literal: bool, seconds: float = 1.6) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, speeds and the distance covered, from the engine."""
    world, crate = look.crate_on_floor(CRATE, STATIC, DYNAMIC, dt=dt, literal=literal)
    crate.velocity = (SPEED, 0, 0)
    speeds = [SPEED]
    for _ in range(round(seconds / dt)):
        world.step()
        speeds.append(crate.velocity[0])
    return dt * np.arange(len(speeds)), np.array(speeds), float(crate.position[0])


def viscous(seconds: float, dt: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """The slide's force formula, -v mu_d |r|, integrated for one kilogram."""
    times, speeds = dt * np.arange(round(seconds / dt) + 1), [SPEED]
    for _ in times[1:]:
        force = lecture.dynamic_friction((0, 0, -G), (0, 0, 1), (speeds[-1], 0, 0), DYNAMIC, literal=True)
        speeds.append(speeds[-1] + force[0] * dt)
    return times, np.array(speeds)


def draw() -> None:
    """Draw ``stopping.png`` and print the distances."""
    figure, (whole, zoom) = look.panels((3, 2))
    deceleration = DYNAMIC * G
    stop = SPEED / deceleration
    exact_t, exact_v = np.array([0, stop, 1.6]), np.array([SPEED, 0, 0])
    print(f"closed form   {SPEED**2 / (2 * deceleration):.4f} m")

    for axes in (whole, zoom):
        axes.plot(exact_t, exact_v, color=look.EXACT, lw=7, solid_capstyle="round")
    for dt, marker, color in ((1 / 60, "o", look.LITERAL), (1 / 240, "s", look.LITERAL_FINE)):
        times, speeds, distance = slide(dt, literal=False)
        print(f"dt = 1/{1 / dt:.0f}: Coulomb {distance:.4f} m, ", end="")
        every = round(0.1 / dt)
        if dt == 1 / 60:
            whole.plot(times[::every], speeds[::every], "o", color=look.RIGHT, ms=5)
        else:
            whole.plot(times[every // 2 :: every], speeds[every // 2 :: every], "s", color=look.RIGHT, ms=4)
        zoom.plot(times[:: round(dt * 240)], speeds[:: round(dt * 240)], marker, color=look.RIGHT, ms=4)

        times, speeds, distance = slide(dt, literal=True)
        print(f"literal {distance:.4f} m")
        whole.plot(times, speeds, color=color, lw=1.8)
        zoom.plot(times, speeds, marker + "-", color=color, ms=4.5, lw=1.2)
    times, speeds = viscous(1.6)
    whole.plot(times, speeds, color=look.MUTED, lw=1.8, ls=(0, (4, 2)))

    look.title(whole, r"5 m/s on $\mu_d$ = 0.4: speed until rest")
    look.note(
        whole, "closed form (grey), and Coulomb's law\nat dt = 1/60 s (●) and 1/240 s (■)", (0.58, 3.5), look.RIGHT
    )
    look.note(whole, "slide's force\n" + r"$-\mathbf{v}\,\mu_d\,|r|$", (0.36, 1.5), look.MUTED)
    look.note(whole, "slide's impulses", (0.16, 0.15), look.LITERAL)
    look.title(zoom, "first 0.12 s: slide's impulses")
    look.note(zoom, "dt = 1/60 s", (0.052, 1.35), look.LITERAL)
    look.note(zoom, "dt = 1/240 s", (0.0265, 0.3), look.LITERAL_FINE)
    for axes, right in ((whole, 1.6), (zoom, 0.12)):
        axes.set(xlim=(-0.01 * right, right), ylim=(-0.12, 5.4), xlabel="time (s)", ylabel="speed (m/s)")
    zoom.set_ylabel("")
    look.save(figure, "stopping.png")


if __name__ == "__main__":
    draw()
