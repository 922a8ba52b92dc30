r"""
A hopper
========

Sand runs out of an hourglass at a steady rate, however high it stands above: walls and friction carry it. Beverloo's
law (1961) says that the flow through a hole of diameter :math:`D` is

.. math:: Q = C \rho \sqrt{g}\,(D - k d)^{5/2}

for grains of diameter :math:`d`, with :math:`k` about 1.4; in a flat silo with a slot the power is 3/2. We drain a
thin silo through three slots and look whether the flow is steady, and how it grows. Through a slot of four grains it
would stop now and then, when grains lean on each other and make an arch over it.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
D, HALF, COLUMNS, ROWS = 0.02, 0.16, 14, 30


def silo(slot: float) -> tuple[st.World, np.ndarray, np.ndarray]:
    """A silo one and a half grains deep, with a slot that wide (m): the world, times, and grains that are out."""
    world = st.World(dt=1 / 240, gravity=(0, 0, -9.81))
    for pair in (("grain", "grain"), ("grain", "wall")):
        world.materials.set_pair(*pair, static=0.5, dynamic=0.5)
    world.materials.set_pair("grain", "glass", static=0.1)
    wall = {"static": True, "material": "wall"}
    for side in (-1, 1):
        world.add(st.Box((0.04, 0.06, 1.0)), position=(side * (HALF + 0.02), 0, 0.5), name=f"wall {side}", **wall)
        half = (HALF - slot / 2) / 2
        world.add(
            st.Box((2 * half, 0.06, 0.04)), position=(side * (slot / 2 + half), 0, -0.02), name=f"floor {side}", **wall
        )
        world.add(st.Box((0.5, 0.02, 1.4)), position=(0, side * (0.75 * D + 0.01), 0.3), name=f"pane {side}",
                  static=True, material="glass")  # fmt: skip
    rng = np.random.default_rng(1)
    grains = []
    for k in range(COLUMNS * ROWS):
        row, column = divmod(k, COLUMNS)
        x = (column - (COLUMNS - 1) / 2) * 1.05 * D + rng.uniform(-4e-4, 4e-4)
        ball = st.Sphere(D / 2 * rng.uniform(0.9, 1.0))
        grains.append(world.add(ball, density=2500, material="grain", position=(x, 0, D * (0.6 + 1.02 * row))))
    first = grains[0].index
    times, out = [], []
    while world.time < 1.6 and (not out or out[-1] < 0.75 * len(grains)):
        world.step(4)
        times.append(world.time)
        out.append(int(np.sum(world.positions[first:, 2] < -0.02)))
    return world, np.array(times), np.array(out)


# %%

runs = {slot: silo(slot * D) for slot in (5, 7, 9)}
rates = {}
print("slot (d)   grains per second")
for slot, (_, times, out) in runs.items():
    steady = (out > 0.15 * COLUMNS * ROWS) & (out < 0.6 * COLUMNS * ROWS)
    rates[slot] = np.polyfit(times[steady], out[steady], 1)[0]
    print(f"{slot:8} {rates[slot]:14.0f}")
power = np.polyfit(np.log(np.array(list(rates)) - 1.4), np.log(list(rates.values())), 1)[0]
print(f"flow grows as (D - 1.4 d) to the power {power:.2f}; a thin silo's law says 1.5")
assert 1.3 < power < 1.8

# %%

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.8), width_ratios=(1, 1.4))
world = runs[7][0]
plot.bodies(left, world, "side", only=[body for body in world if "pane" not in body.name], colors="#d8b26a", edge=0.4)
left.set(ylim=(-0.3, 0.62), title="Slot of 7 grains")
left.set_axis_off()
for slot, (_, times, out) in runs.items():
    right.plot(times, out, label=f"slot of {slot} grains: {rates[slot]:.0f}/s")
right.set(xlabel="time (s)", ylabel="grains that have left", title="Steady to the end")
right.legend()
plt.show()
