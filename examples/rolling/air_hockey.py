r"""
Air hockey
==========

A puck floats on air between four cushions: no friction below it, and cushions that give back a part :math:`e` of the
speed with which they are met.

Unfold the table, that is, mirror it at each cushion, and the path is a straight line. Each cushion takes :math:`1 -
e^2` of the energy in the direction across it and nothing along it. After :math:`n_x` and :math:`n_y` bounces the
kinetic energy is

.. math:: E = \tfrac12 m\,(v_x^2 e^{2 n_x} + v_y^2 e^{2 n_y}).
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
LENGTH, WIDTH, R, E = 2.0, 1.0, 0.04, 0.95

world = st.World(dt=1 / 240)
world.materials.set_pair("puck", "air", static=0)
world.materials.set_pair("puck", "cushion", static=0, restitution=E)
world.add(st.Plane(), static=True, material="air", name="table")
for side in (-1, 1):
    world.add(st.Box((0.1, WIDTH + 0.2, 0.05)), static=True, material="cushion", name=f"end {side}",
              position=(side * (LENGTH / 2 + 0.05), 0, 0.025))  # fmt: skip
    world.add(st.Box((LENGTH, 0.1, 0.05)), static=True, material="cushion", name=f"side {side}",
              position=(0, side * (WIDTH / 2 + 0.05), 0.025))  # fmt: skip
puck = world.add(st.Cylinder(R, 0.02), mass=0.1, material="puck", name="puck", position=(0, 0, 0.01),
                 velocity=(3.0, 1.7, 0))  # fmt: skip

# %%
# Eight seconds. A bounce is a change of the sign of a velocity.

way, energy, expected, bounces = [puck.position[:2]], [puck.kinetic_energy], [puck.kinetic_energy], np.zeros(2)
before = np.sign(puck.velocity[:2])
for _ in range(8 * 240):
    world.step()
    now = np.sign(puck.velocity[:2])
    bounces += now != before
    before = now
    way.append(puck.position[:2])
    energy.append(puck.kinetic_energy)
    expected.append(0.05 * (3.0**2 * E ** (2 * bounces[0]) + 1.7**2 * E ** (2 * bounces[1])))
way, energy, expected = np.array(way), np.array(energy), np.array(expected)
print(f"bounces: {bounces[0]:.0f} at the ends, {bounces[1]:.0f} at the sides")
print(f"energy left: {energy[-1]:.5f} J, expected {expected[-1]:.5f} J")
print(f"ledger: impacts took {world.energy().impacts:.5f} J, friction {world.energy().friction:.1e} J")
assert abs(energy[-1] / expected[-1] - 1) < 0.01

# %%

figure, (above, right) = plt.subplots(1, 2, figsize=(9.6, 3.6), width_ratios=(1.5, 1))
plot.bodies(above, world, "top", colors={"puck": "#e8590c", "table": "#f4f8fb"})
above.plot(*way.T, color="#0072b2", lw=1, zorder=3)
above.set(title="Eight seconds of a puck", xlim=(-1.15, 1.15), ylim=(-0.65, 0.65))
above.set_axis_off()
times = np.arange(len(energy)) / 240
right.plot(times, 1000 * expected, color="#c9d1d8", lw=6, label="formula")
right.plot(times, 1000 * energy, color="#0072b2", lw=1.5, label="stiction")
right.set(xlabel="time (s)", ylabel="kinetic energy (mJ)", ylim=(0, None))
right.legend()
plt.show()
