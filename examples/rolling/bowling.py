r"""
Bowling: the hook
=================

A bowling ball is thrown with a spin to the side onto a lane that is oiled for its first two thirds. Why does it curve
late?

While it slides, friction points against the slip :math:`\vec u` of its lowest point, whose direction does not change.
So the ball is pushed sideways all the time, with :math:`\mu g`: hardly on the oil, strongly on the dry wood. Its path
is a parabola with a kink in its curvature where the oil ends. Slip dies away with :math:`\tfrac72\mu g`; then the
ball rolls straight on.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, R, OIL, DRY, END_OF_OIL = 9.81, 0.108, 0.04, 0.25, 12.0
SPEED, START, SPIN = 8.0, -0.3, np.array([-12.0, 10.0, 0.0])

world = st.World(dt=1 / 240)
world.materials.set_pair("ball", "lane", static=OIL, dynamic=OIL)
world.materials.set_pair("ball", "pin", static=0.2, restitution=0.6)
world.materials.set_pair("pin", "lane", static=0.4)
world.materials.set_pair("pin", "pin", static=0.2, restitution=0.6)
world.add(st.Box((20, 1.06, 0.1)), static=True, position=(10, 0, -0.05), material="lane", name="lane")
ball = world.add(st.Sphere(R), mass=6.8, material="ball", name="ball", position=(0.2, START, R), velocity=(SPEED, 0, 0),
                 angular_velocity=SPIN)  # fmt: skip
for row in range(4):
    for k in range(row + 1):
        spot = (18.3 + 0.264 * row, 0.305 * (k - row / 2), 0.19)
        world.add(st.Cylinder(0.05, 0.38), mass=1.5, material="pin", name=f"pin {row}{k}", position=spot)

# %%
# The formula: slip, its direction, and both parabolas.

slip = np.array([SPEED, 0, 0]) + np.cross(SPIN, (0, 0, -R))
push = -slip / np.linalg.norm(slip)


def formula(x: float) -> float:
    """How far the ball is to the side when it is at x, m."""
    vx, vy, at, side, left = SPEED, 0.0, 0.2, START, float(np.linalg.norm(slip))
    for mu, until in ((OIL, END_OF_OIL), (DRY, 99.0), (0.0, 99.0)):
        ax, ay, way = mu * G * push[0], mu * G * push[1], min(x, until) - at
        t = 2 * way / (vx + math.sqrt(vx * vx + 2 * ax * way))
        if mu > 0:  # slip goes with 7/2 mu g; without slip the ball rolls straight on
            t = min(t, left / (3.5 * mu * G))
            left -= 3.5 * mu * G * t
        at, side = at + vx * t + 0.5 * ax * t * t, side + vy * t + 0.5 * ay * t * t
        vx, vy = vx + ax * t, vy + ay * t
        if at >= x - 1e-9:
            break
    return side


track = [ball.position]
while ball.position[0] < 18.0:
    if ball.position[0] > END_OF_OIL:  # the table of pairs can be changed at any time
        world.materials.set_pair("ball", "lane", static=DRY, dynamic=DRY)
    world.step()
    track.append(ball.position)
track = np.array(track)
print("x (m)   to the side, formula   measured (m)")
for x in (6.0, 12.0, 15.0, 17.9):
    measured = np.interp(x, track[:, 0], track[:, 1])
    print(f"{x:5} {formula(x):15.4f} {measured:16.4f}")
    assert abs(measured - formula(x)) < 0.01
figure, (lane, pins) = plt.subplots(2, 1, figsize=(9, 6), height_ratios=(1, 1.6))
world.run(0.16)
plot.bodies(pins, world, (-65, 30), colors={"ball": "#0072b2"})
world.run(1.2)
down = sum(body.position[2] < 0.15 for body in world if body.name.startswith("pin"))
print(f"{down} of ten pins are down")

x = np.linspace(0.2, 18, 200)
lane.plot(x, [formula(one) for one in x], color="#c9d1d8", lw=7, label="formula")
lane.plot(track[::20, 0], track[::20, 1], "o", ms=4, color="#0072b2", label="stiction")
lane.axvspan(0, END_OF_OIL, color="#fff3c4", zorder=0)
lane.annotate("oil", (0.5, 0.02), fontsize=11)
lane.set(xlabel="along the lane (m)", ylabel="across (m)", xlim=(0, 19), title="Late hook")
lane.legend(loc="upper left", bbox_to_anchor=(0.08, 1))
corners = plot.project([(x, y, z) for x in (17.4, 20) for y in (-0.53, 0.53) for z in (0, 0.4)], (-65, 30))
pins.set(
    xlim=(corners[:, 0].min(), corners[:, 0].max()),
    ylim=(corners[:, 1].min() - 0.05, corners[:, 1].max()),
    title=f"The strike: {down} of ten pins will be down",
)
pins.set_axis_off()
plt.show()
