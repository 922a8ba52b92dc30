r"""
An arch without mortar
======================

Wedge stones in a half circle carry themselves, if the arch is thick enough and its stones do not slip.

Each springing carries half of the weight. How hard the arch pushes outwards is not a matter of statics alone: any
thrust will do whose line stays within the stones. Milankovitch found in 1907 that such a line exists if the arch is
thicker than 0.1075 of its mean radius. Below that it must fall, whatever the friction.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
STONES, RADIUS, G = 15, 2.0, 9.81


def arch(share: float) -> st.World:
    """An arch whose thickness is that share of its mean radius, between two abutments."""
    world = st.World()
    world.materials.set_pair("stone", "stone", static=0.7, dynamic=0.6)
    half, thick = math.pi / (2 * STONES), share * RADIUS
    for side in (-1, 1):
        world.add(st.Box((thick + 0.5, 1, 0.4)), static=True, material="stone", name=f"abutment {side}",
                  position=(side * RADIUS, 0, -0.2))  # fmt: skip
    for k in range(STONES):
        corners = [
            (r * math.cos(a), y, r * math.sin(a))
            for a in (2 * k * half, 2 * (k + 1) * half)
            for r in (RADIUS - thick / 2, RADIUS + thick / 2)
            for y in (-0.3, 0.3)
        ]
        middle = st.ConvexHull(corners).mass_properties.center_of_mass
        world.add(st.ConvexHull(np.array(corners) - middle), density=2400, material="stone", name=f"stone {k}",
                  position=middle)  # fmt: skip
    return world


# %%
# One arch of 0.16 and one of 0.08. Those that stand are weighed at the springings.

worlds = {}
for share in (0.16, 0.08):
    world = worlds[share] = arch(share)
    crown = world[f"stone {STONES // 2}"].position[2]
    world.run(3.0 if share > 0.1075 else 0.6)
    sunk = crown - world[f"stone {STONES // 2}"].position[2]
    print(
        f"thickness {share:.2f} of the radius: crown {1000 * sunk:.1f} mm lower, {'stands' if sunk < 0.05 else 'falls'}"
    )
    assert (sunk < 0.05) == (share > 0.1075)

world = worlds[0.16]
weight = G * sum(body.mass for body in world if body.mobility == "dynamic")
contacts = world.contacts()
for side, name in ((-1, "left"), (1, "right")):
    index = world[f"abutment {side}"].index
    force = np.zeros(3)
    for row in contacts:
        if index in (row["body_a"], row["body_b"]):
            sign = 1 if row["body_a"] == index else -1
            force -= sign * (row["normal_impulse"] * row["normal"] + row["friction_impulse"]) / world.dt
    down, outward = abs(force[2]) / weight, abs(force[0]) / weight
    print(f"{name}: carries {down:.4f} of the weight, pushed outwards with {outward:.3f} of it")
    assert abs(down - 0.5) < 0.01

# %%

figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.6))
for axes, share in zip(panels, worlds, strict=True):
    plot.bodies(axes, worlds[share], (-80, 10), colors="#d9c7a3" if share > 0.1 else "#e8590c")
    axes.set_title(f"{share} of the radius, after {worlds[share].time:.1f} s")
    axes.set_axis_off()
plt.show()
