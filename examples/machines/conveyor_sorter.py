r"""
A conveyor that sorts by friction
=================================

Parcels of three materials fall onto a belt that runs up a slope. What does the belt take along?

Static friction holds a parcel on the belt if :math:`\mu_s \ge \tan\theta`; then it goes up with it. If dynamic
friction is also below :math:`\tan\theta`, a parcel that slips is never caught: it slides down with :math:`a =
g(\sin\theta - \mu_d\cos\theta)`, however fast the belt runs up below it, for friction does not ask how fast. So one
slope between two coefficients tells materials apart.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, TILT, BELT = 9.81, math.radians(18), 0.8
KINDS = {"rubber": (0.9, 0.7, "#1f2a35"), "cardboard": (0.45, 0.38, "#b8860b"), "film": (0.25, 0.2, "#3fa7d6")}

world = st.World(dt=1 / 120)
for kind, (static, dynamic, _) in KINDS.items():
    world.materials.set_pair(kind, "belt", static=static, dynamic=dynamic, source="chosen for this scene")
slope = np.array([math.cos(TILT), 0, math.sin(TILT)])
normal = np.array([-math.sin(TILT), 0, math.cos(TILT)])
turn = (math.cos(TILT / 2), 0, -math.sin(TILT / 2), 0)
world.add(st.Box((9, 1.6, 0.2)), static=True, material="belt", name="belt", orientation=turn, position=-0.1 * normal,
          surface_velocity=(BELT, 0, 0))  # fmt: skip
rng = np.random.default_rng(7)
parcels = []
for k in range(12):
    kind = list(KINDS)[k % 3]
    place = (-0.8 + 0.7 * (k // 3)) * slope + (0.45 * (k % 3) - 0.45) * np.array([0, 1, 0]) + 0.12 * normal
    parcels.append(world.add(st.Box((0.3, 0.24, 0.2)), mass=rng.uniform(2, 8), material=kind, name=f"{kind} {k}",
                             position=place, orientation=turn))  # fmt: skip
before = np.array([parcel.position for parcel in parcels])
colors = {parcel.name: KINDS[parcel.material][2] for parcel in parcels}

figure, panels = plt.subplots(1, 2, figsize=(9.6, 4))
plot.bodies(panels[0], world, (-75, 15), colors=colors)
world.run(0.25)  # they land
early = world.velocities[1:] @ slope
world.run(1.0)
late = world.velocities[1:] @ slope
world.run(1.0)
last = world.velocities[1:] @ slope
plot.bodies(panels[1], world, (-75, 15), colors=colors)

# Speeds up the slope at the end, and what those that slide have gained in a second:

print("parcel         mu_s   mu_d    speed (m/s)   gained, expected   measured (m/s)")
for parcel, a, b, at_last in zip(parcels, early, late, last, strict=True):
    static, dynamic, _ = KINDS[parcel.material]
    held = static >= math.tan(TILT)
    gain = "" if held else f"{-G * (math.sin(TILT) - dynamic * math.cos(TILT)):18.4f} {b - a:16.4f}"
    print(f"{parcel.name:14} {static:<6} {dynamic:<6} {at_last:10.4f} {gain}")
    if held:
        assert abs(at_last - BELT) < 0.01
    else:
        assert abs(b - a + G * (math.sin(TILT) - dynamic * math.cos(TILT))) < 0.02

for axes, text in zip(
    panels, ("Just before they land", "2.25 s later: film slides down, the rest goes up"), strict=True
):
    axes.set_title(text)
    axes.set_axis_off()
plt.show()
