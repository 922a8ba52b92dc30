"""The figures of concepts.md, made by the engine: a contact and its cone, a face that turns, a step, islands."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import look
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

import stiction as st
from stiction import plot
from stiction.view import style

G = 9.81


def contact() -> None:
    """A crate that is pushed on a plane: its contact points from the side, and one of them in its cone."""
    world, crate = look.crate_on_floor((1.0, 1.0, 0.8), 0.6, 0.4, dt=1 / 60)
    for _ in range(30):
        crate.apply_force((0.45 * crate.mass * G, 0, 0))
        world.step()
    rows = world.contacts()
    figure, (side, cone) = look.panels((1.25, 1), height=3.8)
    plot.bodies(side, world, "side", colors="#b9d7ea")
    for x in sorted(set(rows["point"][:, 0].round(6))):
        here = rows[np.abs(rows["point"][:, 0] - x) < 1e-3]
        load, friction = here["normal_impulse"].sum(), here["friction_impulse"].sum(axis=0)
        scale = 0.55 / rows["normal_impulse"].sum() / 0.6
        for vector, color in (((0, load), look.RIGHT), ((friction[0], friction[2]), look.LITERAL)):
            side.annotate(
                "", (x + scale * vector[0], scale * vector[1]), (x, 0), zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": color, "lw": 2.2, "shrinkA": 0, "shrinkB": 0},
            )  # fmt: skip
        side.plot(x, 0, "o", color=look.INK, ms=6, zorder=6)
    look.note(side, "normal impulses", (-0.42, 0.88), look.RIGHT)
    look.note(side, "friction", (-1.02, 0.08), look.LITERAL)
    look.note(side, "push", (-0.92, 0.44), look.INK)
    side.annotate("", (-0.51, 0.4), (-1.0, 0.4), arrowprops={"arrowstyle": "-|>", "color": look.INK, "lw": 2})
    side.set(xlim=(-1.1, 1.1), ylim=(-0.15, 1.0))
    side.set_axis_off()
    look.title(side, "A manifold: points, one normal, impulses")

    reach = 1.25
    for mu, name, line in ((0.6, r"$\mu_s g_n$", (0, (5, 2))), (0.4, r"$\mu_d g_n$", (0, (1, 1.2)))):
        cone.plot([-mu * reach, 0, mu * reach], [reach, 0, reach], color=look.INK, lw=1.4, ls=line)
        look.note(cone, name, (mu * reach + 0.02, reach - 0.06))
    cone.fill([-0.6 * reach, 0, 0.6 * reach], [reach, 0, reach], color="#e9f3f9", zorder=0)
    load = rows["normal_impulse"].sum()
    tip = rows["friction_impulse"].sum(axis=0)[0] / load
    cone.annotate(
        "",
        (tip, 1),
        (0, 0),
        arrowprops={"arrowstyle": "-|>", "color": look.RIGHT, "lw": 2.4, "shrinkA": 0, "shrinkB": 0},
    )
    look.note(cone, "this crate\nsticks", (0.02, 0.85), look.RIGHT, ha="center")
    cone.set(xlim=(-0.95, 1.05), ylim=(-0.05, 1.35), xlabel="friction", ylabel="normal impulse", xticks=[], yticks=[])
    look.title(cone, "The cone, from the side")
    look.save(figure, "concepts-contact.png")


def exact(corners: bool, ratios: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force over mu N, and torque over mu N times half a side, of a square face that slides with 1 and turns.

    Args:
        corners: only these carry the load. ratios: turning over sliding, times half a side.
    """
    ticks = np.array([-1.0, 1.0]) if corners else (np.arange(80) + 0.5) / 40 - 1
    x, y = np.meshgrid(ticks, ticks)
    force, torque = [], []
    for w in ratios:
        u, v = 1.0 - w * y, w * x
        size = np.hypot(u, v)
        force.append(np.mean(u / size))
        torque.append(np.mean((x * v - y * u) / size))
    return np.array(force), np.array(torque)


def measured(ratio: float) -> tuple[float, float]:
    """The same of a crate in the engine, from what one step changes."""
    world, crate = look.crate_on_floor((1.0, 1.0, 0.01), 0.4, 0.4, dt=1e-3)
    world.step(20)
    share = 1 / math.hypot(1, ratio)
    speed = 3.0
    crate.velocity = (speed * share, 0, 0)
    crate.angular_velocity = (0, 0, speed * share * ratio / 0.5)
    v, w = crate.velocity[0], crate.angular_velocity[2]
    world.step(5)
    t, limit = 5e-3, 0.4 * crate.mass * G
    force = crate.mass * (v - crate.velocity[0]) / t / limit
    return force, crate.inertia[2, 2] * (w - crate.angular_velocity[2]) / t / limit / 0.5


def patch() -> None:
    """Slip over a face that slides and turns, and the limit of force and torque."""
    figure, (slip, limit) = look.panels((1, 1.25), height=4.0)
    ticks = np.linspace(-0.9, 0.9, 9)
    x, y = np.meshgrid(ticks, ticks)
    u, v = 1.0 - 1.6 * y, 1.6 * x
    size = np.hypot(u, v)
    slip.add_patch(Rectangle((-1, -1), 2, 2, fc="#eef2f5", ec=style.GRID_SECTION))
    slip.quiver(x, y, -u / size, -v / size, color=look.LITERAL, scale=16, width=0.008, pivot="mid")
    slip.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), aspect="equal")
    slip.set_axis_off()
    look.title(slip, "Friction over a face that slides and turns")

    ratios = np.concatenate([[0.0], np.geomspace(1e-2, 1e2, 160), [1e6]])
    limit.plot(*exact(False, ratios), color=look.EXACT, lw=7, label="exact integral")
    limit.plot(*exact(True, ratios), color=look.MUTED, lw=1.5, ls=(0, (4, 2)), label="four corners")
    points = np.array([measured(ratio) for ratio in (0.0, 0.3, 0.7, 1.2, 2.0, 4.0, 30.0)])
    limit.plot(*points.T, "o", color=look.RIGHT, ms=6, label="stiction")
    limit.set(xlabel=r"force / $\mu N$", ylabel=r"torque / ($\mu N$ half a side)", xlim=(0, 1.1), ylim=(0, 1.55))
    limit.legend(frameon=False, loc="lower left")
    look.title(limit, "What force and torque go together")
    look.save(figure, "concepts-patch.png")


def step() -> None:
    """The course of a step."""
    figure, (axes,) = look.panels((1,), height=2.3)
    _box(axes, 0.0, 1.5, "find contacts", "#dbe7f0")
    width, start = 0.72, 1.65
    for k in range(8):
        left = start + k * (width + 0.06)
        for j, color in enumerate(("#f7e3c5", "#cfe8dc", "#d9d3ea")):
            axes.add_patch(Rectangle((left + j * width / 3, 0.0), width / 3, 1.0, fc=color, ec="none"))
        axes.add_patch(Rectangle((left, 0.0), width, 1.0, fc="none", ec=style.GRID_SECTION, lw=1))
        axes.text(left + width / 2, -0.16, f"{k + 1}", ha="center", va="top", fontsize=10, color=look.MUTED)
    end = start + 8 * (width + 0.06)
    _box(axes, end + 0.1, 1.5, "bounce", "#dbe7f0")
    for j, (text, color) in enumerate((("forces", "#b9822b"), ("contacts, once", "#1d7a55"), ("move", "#6a3d9a"))):
        axes.text(start + 0.1 + 2.1 * j, 1.22, text, color=color, fontsize=10.5)
    axes.text(start + 2.6, -0.55, "substeps", ha="left", color=look.MUTED, fontsize=10)
    axes.annotate("", (0, 1.75), (end + 1.6, 1.75), arrowprops={"arrowstyle": "<|-|>", "color": look.INK, "lw": 1.2})
    axes.text((end + 1.6) / 2, 1.86, "dt", ha="center", fontsize=11, color=look.INK)
    axes.set(xlim=(-0.1, end + 1.75), ylim=(-0.75, 2.2))
    axes.set_axis_off()
    look.save(figure, "concepts-step.png")


def _box(axes: Axes, left: float, width: float, text: str, color: str) -> None:
    axes.add_patch(Rectangle((left, 0.0), width, 1.0, fc=color, ec=style.GRID_SECTION, lw=1))
    axes.text(left + width / 2, 0.5, text, ha="center", va="center", fontsize=10.5, color=look.INK)


def islands() -> None:
    """Stacks, leaning boxes and a ball, coloured by which of them hang together."""
    world = st.World(sleeping=False)
    world.add(st.Plane(), static=True, name="floor")
    for k in range(4):
        world.add(st.Box((0.5, 0.5, 0.5)), position=(0, 0, 0.25 + 0.5 * k), name=f"tower {k}")
    for row in range(3):
        for k in range(3 - row):
            world.add(
                st.Box((0.6, 0.5, 0.4)),
                position=(1.6 + 0.65 * (k + row / 2), 0, 0.2 + 0.4 * row),
                name=f"wall {row}{k}",
            )
    world.add(st.Box((0.2, 0.5, 1.2)), position=(4.0, 0, 0.6), name="post")
    world.add(st.Box((0.2, 0.5, 1.2)), position=(4.9, 0, 0.6), name="post 2")
    world.add(st.Box((1.4, 0.5, 0.15)), position=(4.45, 0, 1.275), name="lintel")
    world.add(st.Sphere(0.25), position=(4.45, 0, 1.6), name="ball on top")
    world.add(st.Sphere(0.25), position=(4.45, 0, 0.25), name="ball below")
    world.run(1.0)
    groups = {body.name: body.name for body in world if body.mobility == "dynamic"}
    bodies = world.bodies
    for row in world.contacts():
        names = [bodies[row[key]].name for key in ("body_a", "body_b")]
        if all(name in groups for name in names):
            old, new = groups[names[0]], groups[names[1]]
            groups = {name: new if group == old else group for name, group in groups.items()}
    order = list(dict.fromkeys(groups.values()))
    figure, (axes,) = look.panels((1,), height=3.0)
    plot.bodies(axes, world, "side", colors={name: style.SERIES[order.index(group)] for name, group in groups.items()})
    axes.set_axis_off()
    look.title(axes, f"{len(groups)} bodies, {len(order)} islands; the floor connects nothing")
    look.save(figure, "concepts-islands.png")


def solvers() -> list[str]:
    """The table of the three solvers: what a step of a crate and of a tower costs, and what comes of it."""
    from time import perf_counter

    work = {
        "micro": "the worst contact first, one at a time, no memory",
        "soft": "8 substeps, a visit of each manifold in each",
        "exact": "passes over all contacts until the laws are met to 1e-8 m/s",
    }
    lines = [
        "| solver | work of a step | crate, µs a step | ten boxes, µs a step | crate stops after | tower sinks |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for solver, text in work.items():
        world, crate = look.crate_on_floor((1, 1, 1), 0.5, 0.4, dt=1 / 60, solver=solver)
        crate.velocity = (5, 0, 0)
        world.run(2.0)
        stop = float(crate.position[0])
        crate.velocity = (50, 0, 0)  # slides on while it is timed
        times = [_time(world, perf_counter)]
        world = st.World(solver=solver, sleeping=False)
        world.add(st.Plane(), static=True)
        tower = [world.add(st.Box((1, 1, 1)), position=(0, 0, k + 0.5)) for k in range(10)]
        world.run(1.0)
        sink = 9.5 - float(tower[-1].position[2])
        times.append(_time(world, perf_counter))
        lines.append(f"| `{solver}` | {text} | {times[0]:.0f} | {times[1]:.0f} | {stop:.4f} m | {1000 * sink:.2f} mm |")
    return [
        *lines,
        "",
        f"The closed form for the crate is {25 / (2 * 0.4 * G):.4f} m. Times are those of one machine: read ratios.",
    ]


def _time(world: st.World, clock: object) -> float:
    begin = clock()  # type: ignore[operator]  # time.perf_counter
    world.step(60)
    return 1e6 * (clock() - begin) / 60  # type: ignore[operator]  # the same


def draw() -> None:
    """Draw the figures, and write the table of solvers into the page."""
    for figure in (contact, patch, step, islands):
        figure()
    docs = Path(__file__).resolve().parent.parent
    sys.path.insert(0, str(docs))
    import markers

    table = solvers()
    print("\n".join(table))
    markers.replace(docs / "concepts.md", "solvers", table)


if __name__ == "__main__":
    draw()
