r"""
Measuring friction at home
==========================

A board, a protractor and a telephone's camera are enough for both coefficients.

*Static:* tilt the board slowly until the block lets go; :math:`\mu_s = \tan\theta`. *Dynamic:* keep the board there
and film the block; from the way :math:`d` in the time :math:`t` follows :math:`\mu_d = \tan\theta - 2 d / (g t^2
\cos\theta)`.

Here the experiment is done in the engine, by tilting gravity. It finds what was put in, and shows how a board that is
tilted too fast would mislead: the block lets go in time, but one reads the protractor late.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, STATIC, DYNAMIC = 9.81, 0.52, 0.41

world = st.World(dt=1 / 240)
world.materials.set_pair("block", "board", static=STATIC, dynamic=DYNAMIC)
world.add(st.Box((1.2, 0.3, 0.03)), static=True, material="board", name="board", position=(0.4, 0, -0.015))
block = world.add(st.Box((0.12, 0.08, 0.05)), mass=0.3, material="block", name="block", position=(0, 0, 0.025))

# %%
# Two degrees in a second, until it has moved by a millimetre.

angle = 0.0
while block.position[0] < 0.001:
    angle += math.radians(2) * world.dt
    world.gravity = (G * math.sin(angle), 0, -G * math.cos(angle))
    world.step()
print(f"static: let go at {math.degrees(angle):.2f}°, so {math.tan(angle):.4f}; put in {STATIC}")
assert abs(math.tan(angle) - STATIC) < 0.01

start, speed, began = block.position[0], block.velocity[0], world.time
times, places = [], []
while block.position[0] < 0.7:
    world.step()
    times.append(world.time - began)
    places.append(block.position[0] - start)
acceleration = 2 * np.polyfit(times, places, 2)[0]
dynamic = math.tan(angle) - acceleration / (G * math.cos(angle))
print(f"dynamic: {acceleration:.4f} m/s^2 on the film, so {dynamic:.4f}; put in {DYNAMIC}")
assert abs(dynamic - DYNAMIC) < 0.005

# %%
# The engine tilts gravity instead of the board, so the board looks level here.

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.8), width_ratios=(1.2, 1))
plot.bodies(left, world, (-70, 20), colors={"block": "#e8590c", "board": "#d9c7a3"})
left.set(title=f"Lets go at {math.degrees(angle):.1f}°")
left.set_axis_off()
right.plot(times, places, "o", ms=2.5, label="film, 240 pictures a second")
right.plot(times, np.polyval(np.polyfit(times, places, 2), times), color="#e8590c", lw=1.5, label="parabola")
right.set(xlabel="time (s)", ylabel="way (m)", title=f"$\\mu_d$ = {dynamic:.3f}")
right.legend()
plt.show()
