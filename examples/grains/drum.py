r"""
A rotating drum
===============

Grains in a drum that turns slowly form a slope, and avalanches run down it. Their friction decides how steep it is.
And what the drum's motor spends must all end up in heat, once the flow is steady: the ledger of energy says where.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
STAVES, INNER, WIDTH, RATE, GRAIN = 24, 0.5, 0.16, 1.0, 0.03


class Drum:
    """A ring of kinematic staves, half filled with grains (spheres and boxes).

    Args:
        mu: coefficient of friction of all pairs.
    """

    def __init__(self, mu: float) -> None:
        self.world = world = st.World(dt=1 / 240)
        for pair in (("grain", "grain"), ("grain", "stave")):
            world.materials.set_pair(*pair, static=mu, dynamic=mu)
        world.materials.set_pair("grain", "glass", static=0)
        spread = math.pi / STAVES
        stave = st.Box((2 * (INNER + 0.04) * math.tan(spread), WIDTH, 0.04))
        for side in (-1, 1):
            pane = (0, side * (WIDTH / 2 + 0.026), 0)
            world.add(st.Box((1.4, 0.05, 1.4)), static=True, position=pane, material="glass",
                      name=f"pane {side}")  # fmt: skip
        self.staves = []
        for k in range(STAVES):
            a = 2 * spread * k
            place = (INNER + 0.02) * np.array([math.sin(a), 0, math.cos(a)])
            self.staves.append(
                world.add(stave, kinematic=True, material="stave", name=f"stave {k}", position=place,
                          orientation=(math.cos(a / 2), 0, math.sin(a / 2), 0), angular_velocity=(0, RATE, 0))
            )  # fmt: skip
        rng = np.random.default_rng(3)
        self.grains = []
        for x in np.arange(-0.36, 0.37, 0.072):
            for z in np.arange(-0.3, 0.2, 0.072):
                for y in (-0.036, 0.036):
                    if math.hypot(x, z) < INNER - 0.06:
                        shape = st.Box(rng.uniform(0.04, 0.055, 3)) if len(self.grains) % 2 else st.Sphere(GRAIN)
                        self.grains.append(
                            world.add(shape, density=1500, material="grain",
                                      position=np.array((x, y, z)) + rng.uniform(-0.004, 0.004, 3))
                        )  # fmt: skip

    def turn(self, seconds: float) -> None:
        """Staves go round: their velocities follow from where they are."""
        for _ in range(round(seconds / self.world.dt)):
            for stave in self.staves:
                x, _, z = stave.position
                stave.velocity = (RATE * z, 0, -RATE * x)
            self.world.step()

    def slope(self) -> float:
        """Angle of the surface in degrees: a segment of a circle has its centre of mass right below its middle."""
        masses = [grain.mass for grain in self.grains]
        x, _, z = np.average([grain.position for grain in self.grains], axis=0, weights=masses)
        return math.degrees(math.atan2(x, -z))


# %%

drums, slopes = {}, {}
for mu in (0.1, 0.6):
    drum = drums[mu] = Drum(mu)
    drum.turn(4.0)
    before, angles = drum.world.energy(), []
    for _ in range(20):
        drum.turn(0.1)
        angles.append(drum.slope())
    after = drum.world.energy()
    slopes[mu] = float(np.mean(angles))
    work, heat = after.work - before.work, after.dissipated - before.dissipated
    stored = after.kinetic + after.potential - before.kinetic - before.potential
    print(
        f"mu = {mu}: slope {abs(slopes[mu]):.1f}°, motor {work:.2f} J in 2 s, heat {heat:.2f} J, stored {stored:+.2f} J"
    )
assert abs(slopes[0.6]) > abs(slopes[0.1]) + 5

# %%

figure, panels = plt.subplots(1, 2, figsize=(9.6, 5))
for axes, (mu, drum) in zip(panels, drums.items(), strict=True):
    shown = [body for body in drum.world if "pane" not in body.name]
    plot.bodies(axes, drum.world, "side", only=shown, colors="#d8b26a", edge=0.5)
    angle = math.radians(slopes[mu])
    along, up = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    surface = np.percentile(drum.world.positions[2 + STAVES :, ::2] @ up, 92) + GRAIN
    line = np.array([[-0.38], [0.38]]) * along + surface * up
    axes.plot(*line.T, color="#e8590c", lw=2, ls="--", zorder=3)
    axes.set_title(f"$\\mu$ = {mu}: {abs(slopes[mu]):.0f}°")
    axes.set_axis_off()
plt.show()
