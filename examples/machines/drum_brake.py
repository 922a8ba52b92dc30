r"""
A drum brake
============

Two shoes press on a drum from outside, each with the force :math:`F`, and brake it with the torque :math:`2\mu_d F
R`. A drum of inertia :math:`I` that turns with :math:`\omega_0` stops after

.. math:: t = \frac{I\,\omega_0}{2\,\mu_d F R},\qquad \text{and the heat is } \tfrac12 I\omega_0^2 .

Shoes are bodies between smooth guides, pushed by forces. No joint is needed: the drum lies on a smooth table, and
shoes that press alike keep it in the middle.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
R, FORCE, MU, SPEED = 0.15, 200.0, 0.35, 40.0

world = st.World(dt=1 / 240)
world.materials.set_pair("lining", "drum", static=0.4, dynamic=MU)
for part in ("drum", "lining"):
    world.materials.set_pair(part, "smooth", static=0)
world.add(st.Plane(), static=True, material="smooth", name="table")
drum = world.add(st.Cylinder(R, 0.06), mass=8, material="drum", name="drum", position=(0, 0, 0.03),
                 angular_velocity=(0, 0, SPEED))  # fmt: skip
shoes = {}
for side in (-1, 1):
    shoes[side] = world.add(st.Box((0.10, 0.08, 0.05)), mass=0.8, material="lining", name=f"shoe {side}",
                            position=(side * (R + 0.05), 0, 0.025))  # fmt: skip
    for edge in (-1, 1):
        world.add(st.Box((0.10, 0.02, 0.05)), static=True, material="smooth", name=f"guide {side} {edge}",
                  position=(side * (R + 0.07), edge * 0.05, 0.025))  # fmt: skip

# %%

times, speeds = [0.0], [SPEED]
while world.time < 0.6:
    for side, shoe in shoes.items():
        shoe.apply_force((-side * FORCE, 0, 0))
    world.step()
    times.append(world.time)
    speeds.append(drum.angular_velocity[2])
times, speeds = np.array(times), np.array(speeds)

inertia = drum.inertia[2, 2]
stop = inertia * SPEED / (2 * MU * FORCE * R)
energy = world.energy()
braking = (speeds > 0.2 * SPEED) & (speeds < 0.8 * SPEED)
slowing, begin = np.polyfit(times[braking], speeds[braking], 1)
torque, stopped = -inertia * slowing, -begin / slowing
print(f"torque  {torque:.3f} N m, expected {2 * MU * FORCE * R:.3f} N m")
print(f"stops   after {stopped:.4f} s, expected {stop:.4f} s")
print(f"heat    {energy.friction:.2f} J, expected {inertia * SPEED**2 / 2:.2f} J")
assert abs(torque / (2 * MU * FORCE * R) - 1) < 0.02

# %%

figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.2))
plot.bodies(left, world, (-70, 55), colors={"drum": "#8fa3b5", "shoe -1": "#e8590c", "shoe 1": "#e8590c"})
left.set(title="Two shoes between guides")
left.set_axis_off()
right.plot([0, stop, 0.6], [SPEED, 0, 0], color="#c9d1d8", lw=7, label="formula")
right.plot(times, speeds, label="stiction")
right.set(xlabel="time (s)", ylabel="speed of the drum (rad/s)")
right.legend()
plt.show()
