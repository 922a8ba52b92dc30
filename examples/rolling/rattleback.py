r"""
The rattleback
==============

A stone that has a mind of its own: spun one way it goes on, spun the other way it begins to rattle, stops, and turns
back. Nothing about its shape tells the two ways apart. What does?

Its weight lies askew. An ellipsoid rolls about the long axis of its *shape*, but wants to turn about the axes of its
*inertia*, which are turned by 30° here, as if two leads were glued on. So rocking and turning are coupled, and one of
the two ways feeds the rocking. Friction carries the angular momentum away to the table; no energy is lost by that, for
the stone rolls: the ledger has none for friction.

(Walker, *On a curious dynamical property of celts*, 1895; Garcia and Hubbard, *Spin reversal of the rattleback*, 1988.)
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
A, B, C, LOW, MASS, SPIN = 0.04, 0.02, 0.02, 0.008, 0.1, 7.0
c, s = math.cos(math.radians(-30)), math.sin(math.radians(-30))
askew = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
inertia = MASS * C**2 * askew @ np.diag([0.2, 1.0, 1.1]) @ askew.T


def stone(spin: float) -> tuple[st.World, st.Body]:
    """A rattleback on a table, tilted by 3 degrees, and spun."""
    world = st.World(dt=1 / 4000)  # it rocks twice a turn or more: a step is a hundredth of that
    world.materials.set_pair("stone", "table", static=1.0, dynamic=1.0)
    world.add(st.Plane(), static=True, material="table", name="table")
    tilt = math.radians(3) / 2
    orientation = (math.cos(tilt), math.sqrt(0.5) * math.sin(tilt), math.sqrt(0.5) * math.sin(tilt), 0)
    body = world.add(
        st.Ellipsoid((A, B, C)), mass=MASS, inertia=inertia, center_of_mass=(0, 0, -LOW), material="stone",
        name="stone", orientation=orientation, position=(0, 0, C), angular_velocity=(0, 0, spin),
    )  # fmt: skip
    turn = matrix(body.orientation)
    up = turn[2] * (A, B, C)
    height = np.linalg.norm(up)
    lowest = turn @ (-up * (A, B, C) / height)  # from the middle to the table
    body.position = (0, 0, height)
    body.velocity = np.cross(lowest + turn @ (0, 0, LOW), body.angular_velocity)  # it rolls from the first
    return world, body


def matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a quaternion."""
    w, x, y, z = q
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


# %%

figure = plt.figure(figsize=(9.6, 5.4))
grid = figure.add_gridspec(2, 4, height_ratios=(1, 1.4))
below = figure.add_subplot(grid[1, :])
for spin, color, label in ((-SPIN, "#4e79a7", "the right way"), (SPIN, "#e0a030", "the wrong way")):
    world, body = stone(spin)
    stills = [0.2, 0.6, 0.8, 1.2] if spin > 0 else []
    rows = []
    for _ in range(500):
        world.step(20)
        turn = matrix(body.orientation)
        rows.append((world.time, body.angular_velocity[2], math.degrees(math.asin(turn[2, 0]))))
        if stills and world.time >= stills[0] - 1e-9:
            axes = figure.add_subplot(grid[0, 4 - len(stills)])
            plot.bodies(axes, world, (-60, 20), colors={"stone": color})
            axes.set_title(f"{stills.pop(0):.1f} s: {body.angular_velocity[2]:.1f} rad/s")
            axes.set_axis_off()
    times, spins, pitch = np.array(rows).T
    below.plot(times, spins, color=color, lw=2.5, label=label)
    if spin > 0:
        back = times[np.argmax(spins < 0)]
        beside = below.twinx()
        beside.plot(times, pitch, color="#8a949e", lw=0.8)
        beside.set(ylabel="pitch (°)", ylim=(-25, 25))
    energy = world.energy()
    share = abs(energy.friction) / (0.5 * inertia[2, 2] * SPIN**2)
    print(f"{label}: {spin:.1f} rad/s at first, {spins[-1]:.1f} rad/s after {times[-1]:.1f} s,", end=" ")
    print(f"{100 * share:.3f} % of its energy lost to friction")
    assert spins[-1] < 0 and share < 1e-3
print(f"The wrong way it turns back after {back:.2f} s.")

# Both end up turning the same way. Grey: how the stone pitches, spun the wrong way.

below.axhline(0, color="#c9d1d8", lw=1, zorder=0)
below.set(xlabel="time (s)", ylabel="spin (rad/s)", xlim=(0, times[-1]), ylim=(-1.3 * SPIN, 1.3 * SPIN))
below.legend(fontsize=9, loc="upper right")
below.set_zorder(1)
below.patch.set_visible(False)
plt.show()
