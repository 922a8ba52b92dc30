r"""
The tippe top
=============

A ball that is heavier below is spun on the table, and turns upside down: its heavy side rises. Where does the energy
come from?

From its spin, and friction is what transfers it; on ice the top would only wobble. Not any friction does, though: by
Coulomb's law alone the top soon rolls, without slip and loss, and stays up (set ``law=st.Coulomb()`` and see). On a
greasy cloth friction grows with slip, and there is always a little. Through all of it, one number stays as it is,
whatever the coefficient: Jellett's :math:`J = -\vec L\cdot\vec a`, the angular momentum along the arm :math:`\vec a`
from the centre of mass to the contact, for friction and load act *at* the contact. At last the top spins on its head
with :math:`\omega = J / (I\,(r + e))`.

(Jellett, *A treatise on the theory of friction*, 1872, ch. 8.)
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
R, E, MASS, SPIN, TILT = 0.02, 0.003, 0.015, 126.5, 0.2
INERTIA = 0.4 * MASS * R * R

world = st.World(dt=1 / 1000)  # 126 rad/s: a step is an eighth of a radian
world.materials.set_pair("top", "table", static=0.0, law=st.FrictionCurve(((0.0, 0.0), (0.063, 0.3))))
world.add(st.Plane(), static=True, material="table", name="table")
top = world.add(
    st.Sphere(R), mass=MASS, material="top", name="top", inertia=(INERTIA,) * 3, center_of_mass=(0, 0, -E),
    position=(0, 0, R), orientation=(math.cos(TILT / 2), math.sin(TILT / 2), 0, 0),
    angular_velocity=(0, -SPIN * math.sin(TILT), SPIN * math.cos(TILT)),
)  # fmt: skip


def axis() -> np.ndarray:
    """The top's own axis, from its heavy side to its light one."""
    w, x, y, z = top.orientation
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def jellett() -> float:
    """J, in kg m^3/s."""
    return INERTIA * top.angular_velocity @ (np.array([0, 0, R]) - E * axis())


# %%

figure = plt.figure(figsize=(9.6, 5.4))
grid = figure.add_gridspec(2, 4, height_ratios=(1, 1.1))
first, rows = jellett(), []
stills = [0.0, 0.9, 1.1, 1.6]
for _ in range(1250):
    if stills and world.time >= stills[0] - 1e-9:
        axes = figure.add_subplot(grid[0, 4 - len(stills)])
        plot.bodies(axes, world, "side", colors={"top": "#e0a030"})
        heavy = plot.project(top.center_of_mass)
        axes.plot(*heavy, "o", color="#1f2a35", ms=7)
        axes.set_title(f"{stills.pop(0):.1f} s")
        axes.set_axis_off()
    world.step(2)
    rows.append((world.time, axis()[2], np.linalg.norm(top.angular_velocity), jellett() / first))
times, tilt, spin, share = np.array(rows).T

last = first / (INERTIA * (R + E))
print(f"cosine of the tilt: {math.cos(TILT):.3f} at first, {tilt[-1]:.3f} at last")
print(f"spin: {SPIN:.0f} rad/s at first, {spin[-1]:.1f} rad/s at last, expected {last:.1f} rad/s")
print(f"Jellett's number has changed by {100 * (share.max() - share.min()):.2f} % at most")
assert tilt[-1] < -0.99 and abs(spin[-1] / last - 1) < 0.01

# The dot is the centre of mass.

below = [figure.add_subplot(grid[1, :2]), figure.add_subplot(grid[1, 2:])]
below[0].plot(times, np.degrees(np.arccos(np.clip(tilt, -1, 1))))
below[0].set(xlabel="time (s)", ylabel="tilt (°)", yticks=(0, 60, 120, 180))
below[1].plot(times, spin, label="spin (rad/s)")
below[1].plot(times, 100 * share, label="Jellett's number (% of the first)")
below[1].axhline(last, color="#c9d1d8", lw=5, zorder=0, label="spin at last, formula")
below[1].set(xlabel="time (s)", ylim=(0, None))
below[1].legend(fontsize=9)
plt.show()
