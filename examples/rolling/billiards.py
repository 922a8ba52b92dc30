r"""
Billiards: follow, stun and draw
================================

A cue ball meets another one head-on. What it does next depends on its spin, and the cloth does the rest.

The impact with restitution :math:`e` leaves the cue ball the speed :math:`v' = v(1 - e)/2`, but its spin
:math:`\omega` stays. Friction with the cloth then makes it roll, with :math:`v'' = (5 v' + 2 r\omega)/7`: with
topspin it *follows*, without spin it nearly *stops*, with backspin it is *drawn* back. The coefficient of the cloth
is not in it; it only says how long that takes.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot
from stiction.scene import Simulation, load

plt.style.use("stiction.plot.lecture")
R, SPEED, E = 0.0286, 1.5, 0.93
SHOTS = {"follow": SPEED / R, "stun": 0.0, "draw": -SPEED / R}

# %%
# Three shots side by side, a metre of cloth each. The balls are smooth to each other, so that the formula is exact.

world = st.World(dt=1 / 500)
world.materials.set_pair("ball", "ball", static=0, restitution=E)
world.materials.set_pair("ball", "cloth", static=0.2, dynamic=0.2)
world.add(st.Box((2.2, 1.2, 0.05)), static=True, material="cloth", position=(0.2, 0, -0.025), name="table")
lanes = dict(zip(SHOTS, (0.35, 0.0, -0.35), strict=True))
for shot, spin in SHOTS.items():
    kind = {"mass": 0.17, "material": "ball"}
    world.add(st.Sphere(R), name=shot, position=(-0.2, lanes[shot], R), velocity=(SPEED, 0, 0),
              angular_velocity=(0, spin, 0), **kind)  # fmt: skip
    world.add(st.Sphere(R), name=f"{shot}, hit", position=(-0.2 + 2 * R + 1e-4, lanes[shot], R), **kind)
colors = {name: "#d9a400" if "hit" in name else "#c9d1d8" for shot in SHOTS for name in (shot, f"{shot}, hit")}

figure, (above, rack) = plt.subplots(1, 2, figsize=(9.6, 4.2), width_ratios=(1, 1.1))
for moment in range(4):
    plot.bodies(
        above, world, "top", only=None if moment == 0 else colors, colors=colors, alpha=(0.45, 0.5, 0.6, 1)[moment]
    )
    world.run(0.25)

print("shot      expected   measured (m/s)")
for shot, spin in SHOTS.items():
    expected = (5 * SPEED * (1 - E) / 2 + 2 * R * spin) / 7
    measured = world[shot].velocity[0]
    print(f"{shot:8} {expected:9.4f} {measured:10.4f}")
    assert abs(measured - expected) < 0.02 * SPEED
    above.annotate(shot, (-0.85, lanes[shot]), va="center", fontsize=11)
above.set(title="Grey hits yellow: every 0.25 s", xlim=(-0.9, 1.3), ylim=(-0.6, 0.6))
above.set_axis_off()

# And the break: the built-in scene ``billiards``, 0.35 s after the cue ball was struck.

simulation = Simulation(load("billiards"))
cue = [simulation.world["cue ball"].position[:2]]
for _ in range(35):
    simulation.advance(10)
    cue.append(simulation.world["cue ball"].position[:2])
plot.bodies(rack, simulation.world, "top", colors={"cloth": "#3b8f6f", "cue ball": "#ffffff"})
rack.plot(*np.array(cue).T, color="white", lw=1.5, zorder=3)
rack.set_title("The break, with the way of the cue ball")
rack.set_axis_off()
plt.show()
