r"""
A gripper lifts an egg
======================

Two fingers hold an egg of 60 g between flat pads and lift it. How hard must they press?

Each pad gives friction of at most :math:`\mu_s N`. To lift with the acceleration :math:`a` it takes :math:`2\mu_s N
\ge m(g + a)`, so

.. math:: N \ge \frac{m\,(g + a)}{2\mu_s}.

Once it slips, it is lost: dynamic friction is weaker. The right grip is a little above the threshold for the
*fastest* part of the lift.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, MASS, STATIC, DYNAMIC, ACCELERATION = 9.81, 0.06, 0.5, 0.4, 3.0
NEED = MASS * (G + ACCELERATION) / (2 * STATIC)


def egg() -> st.ConvexHull:
    """An egg, blunt end down: an ellipse of revolution whose halves differ."""
    points = []
    for angle in np.linspace(-math.pi / 2, math.pi / 2, 13):
        for turn in np.linspace(0, 2 * math.pi, 24, endpoint=False):
            r = 0.022 * math.cos(angle)
            z = (0.034 if angle > 0 else 0.025) * math.sin(angle)
            points.append((r * math.cos(turn), r * math.sin(turn), z))
    return st.ConvexHull(np.unique(np.round(points, 6), axis=0))


def lift(grip: float, seconds: float = 0.8) -> tuple[st.World, list[tuple[float, float, float]]]:
    """Grip for 0.2 s, lift for 0.25 s with the acceleration, go on for as long; time and heights of egg and fingers."""
    world = st.World(dt=1 / 480)
    world.materials.set_pair("egg", "pad", static=STATIC, dynamic=DYNAMIC)
    world.materials.set_pair("egg", "table", static=0.4, dynamic=0.3)
    world.add(st.Plane(), static=True, material="table", name="table")
    held = world.add(egg(), mass=MASS, material="egg", name="egg", position=(0, 0, 0.025))
    pad = st.Box((0.01, 0.03, 0.03))
    fixed = world.add(pad, kinematic=True, material="pad", name="fixed jaw", position=(-0.027, 0, 0.03))
    # the other jaw is guided so that it cannot turn: an inertia like that of the arm behind it
    jaw = world.add(pad, mass=0.1, inertia=(10, 10, 10), material="pad", name="moving jaw", position=(0.0275, 0, 0.03))
    rows = []
    while world.time < seconds:
        t = world.time - 0.2
        up = 0.0 if t < 0 else ACCELERATION * min(t, 0.25)
        fixed.velocity = (0, 0, up)
        # the arm: it presses with the grip, and its servo keeps the jaw level with the fixed one
        servo = 2000 * (fixed.position - jaw.position) + 40 * (fixed.velocity - jaw.velocity)
        jaw.apply_force((-grip, servo[1], servo[2] + jaw.mass * G))
        world.step()
        rows.append((world.time, held.position[2], fixed.position[2]))
    return world, rows


# %%

runs = {share: lift(share * NEED) for share in (0.8, 0.95, 1.1, 1.5)}
print(f"needed: {NEED:.3f} N a side")
for share, (_, rows) in runs.items():
    slipped = (rows[-1][2] - 0.03) - (rows[-1][1] - 0.025)
    print(f"grip {share * NEED:.3f} N ({share:g} of it): egg slipped by {1000 * slipped:6.1f} mm")
    assert (slipped < 0.002) == (share > 1)

# %%

figure, panels = plt.subplots(1, 3, figsize=(9.6, 4.4), width_ratios=(1, 1, 1.5))
for axes, share in zip(panels[:2], (0.95, 1.1), strict=True):
    world, _ = lift(share * NEED, 0.33)
    plot.bodies(axes, world, (-65, 15), only=["egg", "fixed jaw", "moving jaw"], colors={"egg": "#e8c9a0"}, edge=0.4)
    axes.set(title=f"{share:g} of the need, 0.33 s")
    axes.set_axis_off()
for share, (_, rows) in runs.items():
    times, egg_z, jaw_z = np.array(rows).T
    panels[2].plot(times, 1000 * ((jaw_z - 0.03) - (egg_z - 0.025)), label=f"{share:g} of the need")
panels[2].set(xlabel="time (s)", ylabel="slipped (mm)", ylim=(-1, 30), title="The egg against its jaws")
panels[2].legend()
plt.show()
