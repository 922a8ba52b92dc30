r"""
The lecture's table on a ramp
=============================

Nine crates lie on nine lanes of a ramp of 30 degrees, one for each row of the lecture's table of coefficients. Which
of them stay?

A crate stays as long as the component of its weight along the slope is no more than static friction can take:
:math:`\tan\theta \le \mu_s`. If it slides, dynamic friction brakes it, and its acceleration is :math:`a =
g(\sin\theta - \mu_d\cos\theta)`.
"""

import math

import matplotlib.pyplot as plt

from stiction import plot
from stiction.scene import Simulation, load

plt.style.use("stiction.plot.lecture")

# %%
# The ramp is one of the built-in scenes; ``stiction scenes ramp`` prints its file. We run it for 1.2 s.

simulation = Simulation(load("ramp"))
world = simulation.world
crates = [body for body in world if body.mobility == "dynamic"]
start = {crate.name: crate.position for crate in crates}
simulation.advance(72)

# %%
# Measured accelerations, :math:`a = 2 d / t^2` from the way they have gone, beside the formula:

g, angle = 9.81, math.radians(30)
print(f"{'pair':30} mu_s   mu_d   expected   measured (m/s^2)")
for crate in crates:
    pair = world.materials.pair(*crate.name.split(" on "))
    expected = 0.0 if math.tan(angle) <= pair.static else g * (math.sin(angle) - pair.dynamic * math.cos(angle))
    way = math.dist(crate.position, start[crate.name])
    measured = 2 * way / world.time**2
    print(f"{crate.name:30} {pair.static:<6} {pair.dynamic:<6} {expected:8.4f} {measured:10.4f}")
    assert abs(measured - expected) < 0.01 * max(expected, 1)

# %%
# Green crates stick, orange ones slide.

figure, axes = plt.subplots(figsize=(9, 6))
plot.bodies(axes, world, (-55, 28))
axes.set_title(f"Nine pairs of materials at 30°, after {world.time:.1f} s")
axes.set_axis_off()
plt.show()
