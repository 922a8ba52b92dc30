r"""
Curling
=======

A curling stone of 20 kg is let go at 2 m/s with a slow turn. Two questions:

*How far does it go?* Without spin it goes :math:`v^2 / (2\mu g)`. Spin protects it: each point of its sole is braked
against its *own* velocity, so a stone that turns has less friction against its motion, and goes farther.

*Does it curl?* In this model it should do so a little, to the wrong side. Friction acts at the ice and inertia above
it, so the front of the sole carries more load. A front that turns to the left is braked to the right. A cup on a
table does just that; a real stone on pebbled ice curls to the other side, because it changes the ice below it. A
rigid sole with one coefficient cannot.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st

plt.style.use("stiction.plot.lecture")
MU, SPEED, RADIUS, HEIGHT, G = 0.0115, 2.0, 0.14, 0.11, 9.81


def throw(spin: float) -> tuple[st.World, np.ndarray]:
    """A stone with that spin (rad/s), and its way (n, 2) in m."""
    world = st.World()
    world.materials.set_pair("granite", "ice", static=MU, dynamic=MU, source="chosen: 25 s from hog line to tee")
    world.add(st.Plane(), static=True, material="ice")
    stone = world.add(
        st.Cylinder(RADIUS, HEIGHT), mass=20, material="granite", name="stone", position=(0, 0, HEIGHT / 2),
        velocity=(SPEED, 0, 0), angular_velocity=(0, 0, spin),
    )  # fmt: skip
    way = [stone.position[:2]]
    while np.linalg.norm(stone.velocity) > 1e-4:
        world.step()
        way.append(stone.position[:2])
    return world, np.array(way)


def formula(spin: float, steps: int = 20_000) -> float:
    """Distance by Coulomb's law over an evenly loaded disc, integrated step by step (no tipping load)."""
    r = RADIUS * np.sqrt((np.arange(30) + 0.5) / 30)[:, None]
    turn = (np.arange(60) + 0.5) * 2 * np.pi / 60
    x, y = r * np.cos(turn), r * np.sin(turn)
    v, w, way, dt = SPEED, spin, 0.0, 2.0 * SPEED / (MU * G) / steps
    for _ in range(steps):
        ux, uy = v - w * y, w * x
        size = np.hypot(ux, uy) + 1e-12
        force, torque = np.mean(ux / size), np.mean((x * uy - y * ux) / size)
        way += v * dt
        v, w = v - MU * G * force * dt, w - MU * G * torque / (RADIUS**2 / 2) * dt
        if v < 1e-4:
            break
    return way


# %%

spins = (0.0, 1.5, 6.0, 20.0)
ways = {}
print("spin (rad/s)   goes (m)   formula (m)   to the side (mm)")
for spin in spins:
    _, ways[spin] = throw(spin)
    exact = SPEED**2 / (2 * MU * G) if spin == 0 else formula(spin)
    print(f"{spin:12} {ways[spin][-1, 0]:10.3f} {exact:13.3f} {1000 * ways[spin][-1, 1]:14.1f}")
    assert abs(ways[spin][-1, 0] / exact - 1) < 0.01

# %%
# Seen from above, the side ways drawn 20 times as large: stones that turn to the left go to the right.

figure, axes = plt.subplots(figsize=(9, 3.8))
for spin, way in ways.items():
    axes.plot(way[:, 0], 1000 * way[:, 1], label=f"{spin:g} rad/s")
    axes.plot(*(way[-1] * (1, 1000)), "o", ms=9, color=axes.lines[-1].get_color())
axes.set(xlabel="along the sheet (m)", ylabel="across (mm)", title="Four stones, thrown alike but for their spin")
axes.legend(title="spin to the left", loc="lower left")
plt.show()
