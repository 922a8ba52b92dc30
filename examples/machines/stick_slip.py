r"""
Stick-slip
==========

Why does a door creak? A block is held by a spring on a belt that moves slowly. The belt carries it along until the
spring pulls with :math:`\mu_s m g`; then it lets go, and since dynamic friction is weaker, it leaps back until the
belt catches it again.

With :math:`D = (\mu_s - \mu_d) m g / k` and :math:`\omega = \sqrt{k/m}`, a round on a belt of speed :math:`V` takes

.. math:: T = \frac{2 D}{V} + \frac{2\pi - 2\arctan(D\omega/V)}{\omega}.

One coefficient for both is not enough: with :math:`\mu_s = \mu_d` nothing leaps.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

from stiction.scene import Simulation, load

plt.style.use("stiction.plot.lecture")
G, V, STATIC, DYNAMIC, MASS = 9.81, 0.1, 0.6, 0.3, 1.0
STIFF = {"soft spring": 25.0, "medium spring": 50.0, "stiff spring": 100.0}

# %%
# The built-in scene ``stick-slip`` has three springs, and a fourth block with one coefficient.

simulation = Simulation(load("stick-slip"))
world = simulation.world
names = [*STIFF, "one coefficient"]
places, speeds = [], []
while not simulation.done:
    simulation.advance(1)
    places.append([world[name].position[0] for name in names])
    speeds.append([world[name].velocity[0] for name in names])
places, speeds = np.array(places), np.array(speeds)
times = world.dt * np.arange(1, len(places) + 1)

print("spring            period, formula   measured (s)")
for k, (name, stiffness) in enumerate(STIFF.items()):
    jump, w = (STATIC - DYNAMIC) * MASS * G / stiffness, math.sqrt(stiffness / MASS)
    period = 2 * jump / V + (2 * math.pi - 2 * math.atan(jump * w / V)) / w
    middle = DYNAMIC * MASS * G / stiffness
    x = places[:, k]
    up = np.flatnonzero((x[:-1] < middle) & (x[1:] >= middle))  # the belt carries it past the middle
    ups = times[up] + world.dt * (middle - x[up]) / (x[up + 1] - x[up])
    measured = float(np.mean(np.diff(ups)[1:]))
    print(f"{name:16} {period:14.3f} {measured:14.3f}")
    assert abs(measured - period) < 0.03

# %%
# Left: a saw. Right: the same as a phase portrait; the flat top is the belt's speed.

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2), width_ratios=(1.5, 1))
for k, name in enumerate(names):
    left.plot(times, places[:, k], label=name)
    right.plot(places[:, k], speeds[:, k], lw=1.4)
left.set(xlabel="time (s)", ylabel="stretch of the spring (m)", title="Stick and slip", ylim=(-0.02, 0.32))
left.legend(loc="upper center", ncols=4, fontsize=9, columnspacing=1, handlelength=1.2)
right.set(xlabel="stretch (m)", ylabel="speed (m/s)", title="Phase portrait")
plt.show()
