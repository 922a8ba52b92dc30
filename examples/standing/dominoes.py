r"""
Dominoes
========

How fast does the wave run? There is no simple closed form, but there is a scale: lengths are measured in the height
:math:`h` of a domino, times in :math:`\sqrt{h/g}`, so speeds are in :math:`\sqrt{g h}`. Dominoes of twice the size
must therefore fall exactly :math:`\sqrt2` times as fast, in the same pattern. That is what we check, and we look at
what spacing does.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
G, COUNT = 9.81, 24


def wave(height: float, spacing: float, push: float = 0.8) -> tuple[float, st.World]:
    """Speed of the wave in sqrt(g h) over the later half of a row, and the row while it falls.

    Args:
        height: of a domino, m; it is h/2 wide and h/6 thick. spacing: from one to the next, in h.
        push: spin of the first one, in sqrt(g / h).
    """
    unit = math.sqrt(height / G)
    world = st.World(dt=unit / 60)
    world.materials.set_pair("domino", "domino", static=0.3, dynamic=0.25)
    world.materials.set_pair("domino", "table", static=0.6, dynamic=0.5)
    world.add(st.Plane(), static=True, material="table", name="table")
    row = [
        world.add(st.Box((height / 6, height / 2, height)), density=600, material="domino",
                  position=(k * spacing * height, 0, height / 2))
        for k in range(COUNT)
    ]  # fmt: skip
    row[0].angular_velocity = (0, push / unit, 0)
    row[0].velocity = (0.5 * push * height / unit, 0, 0)
    fell = [math.nan] * COUNT
    while math.isnan(fell[-1]) and world.time < 80 * unit:
        world.step()
        for k, domino in enumerate(row):
            if math.isnan(fell[k]) and abs(domino.angular_velocity[1]) > 0.1 / unit:
                fell[k] = world.time
        if not math.isnan(fell[int(0.6 * COUNT)]):
            break
    halfway = COUNT // 4
    end = int(0.6 * COUNT)
    return (end - halfway) * spacing * height / (fell[end] - fell[halfway]) / math.sqrt(G * height), world


# %%
# A row forgets how hard its first domino was pushed, but for a hundredth: small differences grow from one blow to the
# next. So a speed is the mean of five rows.

PUSHES = (0.7, 0.8, 0.9, 1.0, 1.1)
small, large = (np.mean([wave(height, 0.5, push)[0] for push in PUSHES]) for height in (0.05, 0.10))
print(f"speed in sqrt(g h): {small:.4f} at h = 5 cm, {large:.4f} at h = 10 cm")
assert abs(small / large - 1) < 0.01

spacings = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
speeds = []
for spacing in spacings:
    speed, world = wave(0.05, spacing)
    speeds.append(speed)
    print(f"spacing {spacing:.1f} h: {speed:.3f} sqrt(g h) = {speed * math.sqrt(G * 0.05):.2f} m/s")
    if spacing == 0.5:
        shown = world

# %%

figure, (above, below) = plt.subplots(2, 1, figsize=(9, 5.4), height_ratios=(1, 1.4))
plot.bodies(above, shown, (-80, 12))
above.set_title("Spacing 0.5 h")
above.set_axis_off()
below.plot(spacings, speeds, "o-", ms=7)
below.set(
    xlabel="spacing, in heights of a domino",
    ylabel=r"speed of the wave in $\sqrt{g h}$",
    ylim=(0, 1.1 * np.max(speeds)),
)
plt.show()
