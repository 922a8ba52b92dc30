"""Braking with the left wheels on ice, from above: the built-in scene ``vehicle``, and what its wheels do."""

from __future__ import annotations

import look
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from stiction.scene import Simulation, load

EVERY = 0.5
"""s, between two outlines of a car."""
CARS = (("on asphalt", "first", look.RIGHT), ("half on ice", "second", look.LITERAL))


def outline(axes: Axes, at: np.ndarray, yaw: float, size: tuple[float, ...], color: str) -> None:
    """A car from above, with a notch of colour at its front."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    half = np.array(size[:2]) / 2
    corners = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * half
    axes.add_patch(Polygon(at + corners @ turn.T, facecolor="white", edgecolor=color, lw=1.4, zorder=3))
    nose = np.array([(1, 1), (1, -1), (0.7, -1), (0.7, 1)]) * half
    axes.add_patch(Polygon(at + nose @ turn.T, facecolor=color, edgecolor="none", zorder=4))


def draw() -> None:
    """Draw ``braking-on-ice.png`` and print where the cars end."""
    simulation = Simulation(load("vehicle"))
    world = simulation.world
    figure, (above, below) = look.panels((3, 2), height=5.2, stacked=True)
    ice = world["ice"]
    corner = ice.position[:2] - np.array(ice.shape.size[:2]) / 2
    above.add_patch(Rectangle(corner, *ice.shape.size[:2], facecolor="#dcebf7", edgecolor="none", zorder=0))
    look.note(above, "ice", (59, 2.6), look.MUTED, ha="right")
    look.note(above, "asphalt", (59, -3.4), look.MUTED, ha="right")
    every = round(EVERY / world.dt)
    times, speeds = [], {name: [] for name, _, _ in CARS}
    while True:
        times.append(world.time)
        for name, _, color in CARS:
            body = world[name]
            speeds[name].append(float(np.hypot(*body.velocity[:2])))
            if simulation.step_index % every == 0:
                yaw = 2.0 * np.arctan2(body.orientation[3], body.orientation[0])
                outline(above, body.position[:2], float(yaw), body.shape.size, color)
        if simulation.done:
            break
        simulation.advance()
    for name, _, color in CARS:
        body = world[name]
        below.plot(times, speeds[name], color=color, lw=2.2)
        print(f"{name}: {body.position[0]:.1f} m, {speeds[name][-1]:.1f} m/s")
    look.note(below, "on asphalt", (1.62, 10.0), look.RIGHT, ha="right")
    look.note(below, "left wheels on ice", (2.1, 14.0), look.LITERAL)
    above.set(xlim=(-3, 60), ylim=(-9, 4.5), aspect="equal", xlabel="m", ylabel="m")
    look.title(above, f"from above, every {EVERY:g} s; the front of each car is filled")
    below.set(xlim=(0, times[-1]), ylim=(0, None), xlabel="time (s)", ylabel="speed (m/s)")
    look.title(below, "speed")
    look.save(figure, "braking-on-ice.png")


if __name__ == "__main__":
    draw()
