r"""
A car on split mu
=================

A car brakes hard with its left wheels on ice and its right wheels on asphalt. Why does it turn?

Each side brakes with :math:`\mu N`. Their difference has the arm of half a track, :math:`M = \tfrac12 b\,(\mu_r - \mu_l)\,\tfrac12 m g`, and turns the car
to the side that grips: :math:`\dot\psi = M t / I` at first, and together they brake with :math:`a = \tfrac12(\mu_l + \mu_r) g`.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, MASS, TRACK, SPEED, ASPHALT, ICE = 9.81, 1200.0, 1.5, 25.0, 0.8, 0.1


def brake(left: float) -> tuple[st.World, st.Vehicle, np.ndarray]:
    """A car whose wheels lock; the coefficient below its left wheels. Rows of time, x, y, speed, yaw rate."""
    world = st.World(dt=1 / 120)
    world.materials.set_pair("tyre", "asphalt", static=ASPHALT, dynamic=ASPHALT)
    world.materials.set_pair("tyre", "left lane", static=left, dynamic=left)
    for side, material in ((1, "left lane"), (-1, "asphalt")):
        world.add(st.Box((90, 6, 0.2)), static=True, material=material, name=material, position=(40, 3 * side, -0.1))
    chassis = world.add(st.Box((4.2, 1.7, 0.5)), mass=MASS, name="car", position=(0, 0, 0.55), velocity=(SPEED, 0, 0))
    wheels = st.four_wheels(front=1.3, rear=-1.3, track=TRACK, hub_height=-0.25, tyre="tyre")
    car = st.Vehicle(world, chassis, wheels, brake_torque=20_000)
    car.brake = 1.0
    rows = []
    while world.time < 6 and np.linalg.norm(chassis.velocity) > 0.05:
        rows.append((world.time, *chassis.position[:2], np.linalg.norm(chassis.velocity), chassis.angular_velocity[2]))
        car.step()
    return world, car, np.array(rows)


# %%
# Both sides on asphalt first, then with ice below the left wheels.

runs = {"asphalt on both sides": brake(ASPHALT), "ice on the left": brake(ICE)}
for name, (world, _, rows) in runs.items():
    inertia = world["car"].inertia[2, 2]
    left = ASPHALT if "both" in name else ICE
    start = rows[rows[:, 0] < 0.2]
    slowing, turning = -np.polyfit(start[:, 0], start[:, 3], 1)[0], np.polyfit(start[:, 0], start[:, 4], 1)[0]
    torque = TRACK / 2 * (left - ASPHALT) * MASS * G / 2
    print(f"{name:22} brakes with {slowing:5.2f} m/s^2, expected {(left + ASPHALT) / 2 * G:5.2f};"
          f" turns with {turning:6.3f} rad/s^2, expected {torque / inertia:6.3f}")  # fmt: skip

# %%

figure, (road, chart) = plt.subplots(2, 1, figsize=(9.6, 5.6), height_ratios=(1, 1.2))
world, car, rows = runs["ice on the left"]
plot.bodies(road, world, "top", colors={"car": "#e8590c", "left lane": "#d7ecf7", "asphalt": "#9aa3ab"})
road.plot(rows[:, 1], rows[:, 2], color="#1f2a35", lw=1.2, zorder=3)
road.set(xlim=(-4, 75), ylim=(-6, 6), title="Ice (pale) on the left: the car turns to the side that grips")
road.set_axis_off()
for name, (_, _, rows) in runs.items():
    chart.plot(rows[:, 0], rows[:, 3], label=f"speed, {name}")
chart.plot(rows[:, 0], np.degrees(rows[:, 4]) / 10, color="#6a3d9a", ls="--", label="yaw rate on ice, 10 °/s")
chart.set(xlabel="time (s)", ylabel="m/s")
chart.legend(fontsize=9)
plt.show()
