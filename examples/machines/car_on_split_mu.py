r"""
A car on split mu
=================

A car brakes hard with its left wheels on ice and its right wheels on asphalt. Why does it turn?

Each side brakes with :math:`\mu N`. Their difference has the arm of half a track, :math:`M = \tfrac12 b\,(\mu_r -
\mu_l)\,\tfrac12 m g`, and turns the car to the side that grips: :math:`\dot\psi = M t / I` at first, and together
they brake with :math:`a = \tfrac12(\mu_l + \mu_r) g`.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, MASS, TRACK, SPEED, ASPHALT, ICE = 9.81, 1200.0, 1.5, 25.0, 0.8, 0.1


def brake(left: float, axes: plt.Axes | None = None) -> tuple[st.World, np.ndarray]:
    """A car whose wheels lock: the world, and rows of time, x, y, speed, yaw rate.

    Args:
        left: coefficient below its left wheels. axes: where to draw it twice a second, if given.
    """
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
    if axes is not None:
        plot.bodies(
            axes, world, "top", only=["left lane", "asphalt"], colors={"left lane": "#d7ecf7", "asphalt": "#9aa3ab"}
        )
    while world.time < 6 and np.linalg.norm(chassis.velocity) > 0.05:
        if axes is not None and len(rows) % 60 == 0:
            plot.bodies(axes, world, "top", only=["car"], colors="#e8590c", alpha=0.8)
        rows.append((world.time, *chassis.position[:2], np.linalg.norm(chassis.velocity), chassis.angular_velocity[2]))
        car.step()
    return world, np.array(rows)


# %%
# Both sides on asphalt first, then with ice below the left wheels.

figure, (road, chart) = plt.subplots(2, 1, figsize=(9.6, 5.6), height_ratios=(1, 1.2))
runs = {"asphalt on both sides": brake(ASPHALT), "ice on the left": brake(ICE, road)}
for name, (world, rows) in runs.items():
    inertia = world["car"].inertia[2, 2]
    left = ASPHALT if "both" in name else ICE
    start = rows[rows[:, 0] < 0.2]
    slowing, turning = -np.polyfit(start[:, 0], start[:, 3], 1)[0], np.polyfit(start[:, 0], start[:, 4], 1)[0]
    torque = TRACK / 2 * (left - ASPHALT) * MASS * G / 2
    print(f"{name:22} brakes with {slowing:5.2f} m/s^2, expected {(left + ASPHALT) / 2 * G:5.2f};"
          f" turns with {turning:6.3f} rad/s^2, expected {torque / inertia:6.3f}")  # fmt: skip
    assert abs(slowing - (left + ASPHALT) / 2 * G) < 0.1 and abs(turning - torque / inertia) < 0.05

rows = runs["ice on the left"][1]
road.plot(rows[:, 1], rows[:, 2], color="#1f2a35", lw=1.2, zorder=3)
road.set(xlim=(-4, 84), ylim=(-6, 6), title="Ice (pale) on the left: the car turns to the side that grips. Every 0.5 s")
road.set_axis_off()
for name, (_, rows) in runs.items():
    chart.plot(rows[:, 0], rows[:, 3], label=f"speed, {name} (m/s)")
chart.plot(rows[:, 0], np.degrees(rows[:, 4]) / 10, color="#6a3d9a", ls="--", label="yaw rate, ice on the left (10°/s)")
chart.set(xlabel="time (s)")
chart.legend(fontsize=9)
plt.show()
