r"""
The cone is round
=================

Push a brick over the floor in any direction: it must go straight, and equally far. Friction of engines that take two
coefficients for two axes (a *pyramid* or a *box*) makes it stop at a square, and swerve. Here 16 bricks, each turned
askew, are sent off in 16 directions. All must stop on the circle of :math:`v^2/(2\mu g)`.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, MU, SPEED = 9.81, 0.4, 3.0

world = st.World()
world.materials.set_pair("brick", "floor", static=MU, dynamic=MU)
world.add(st.Plane(), static=True, material="floor", name="floor")
bricks = []
for heading in np.arange(16) * 2 * math.pi / 16:
    start = 0.9 * np.array([math.cos(heading), math.sin(heading), 0])
    yaw = heading + 0.6
    bricks.append(
        world.add(st.Box((0.24, 0.12, 0.06)), mass=3, material="brick", position=start + np.array([0, 0, 0.03]),
                  orientation=(math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)), velocity=SPEED * start / 0.9)
    )  # fmt: skip
figure, axes = plt.subplots(figsize=(7, 6.4))
plot.bodies(axes, world, "top", only=bricks, colors="#c9d1d8", alpha=0.5)
begin = np.array([brick.position for brick in bricks])
world.run(1.5)

radius = SPEED**2 / (2 * MU * G)
ways = np.array([brick.position for brick in bricks]) - begin
distances = np.linalg.norm(ways, axis=1)
swerve = np.degrees(np.arcsin(np.cross(begin / 0.9, ways)[:, 2] / distances))
print(f"expected {radius:.4f} m; measured from {distances.min():.4f} to {distances.max():.4f} m")
print(f"swerve: {abs(swerve).max():.4f} degrees at most")
assert abs(distances / radius - 1).max() < 0.005 and abs(swerve).max() < 0.1

plot.bodies(axes, world, "top", only=bricks, colors="#0072b2")
turn = np.linspace(0, 2 * math.pi, 200)
axes.plot((0.9 + radius) * np.cos(turn), (0.9 + radius) * np.sin(turn), color="#e8590c", ls="--", lw=1.5, zorder=3)
axes.set_title(f"Sixteen bricks at {SPEED:g} m/s, $\\mu$ = {MU}")
axes.set_axis_off()
plt.show()
