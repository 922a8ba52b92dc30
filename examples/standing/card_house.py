r"""
A house of cards
================

Two cards that lean on each other push their feet apart. What friction do they need, and what do three storeys need?

A card of weight :math:`W` at the angle :math:`a` from upright carries nothing but itself in a single tent. Torques
about its tip give the thrust at its foot, :math:`H = \tfrac12 W \tan a`; the foot carries :math:`W`. So the tent
stands as long as :math:`\mu_s \ge \tfrac12\tan a`. With storeys on top a card is a strut that is pressed along its
own length, and the need tends to :math:`\tan a`.
"""

import math

import matplotlib.pyplot as plt

import stiction as st
from stiction import plot

plt.style.use("stiction.plot.lecture")
LEAN, LONG, WIDE, THICK = math.radians(25), 0.09, 0.06, 0.002


def house(storeys: int, mu: float, tips: float | None = None) -> st.World:
    """Leaning cards in pairs, and flat ones from tip to tip; the tips may have a coefficient of their own."""
    world = st.World(dt=1 / 240)
    world.materials.set_pair("card", "card", static=tips or mu, dynamic=tips or mu)
    world.materials.set_pair("card", "table", static=mu, dynamic=mu)
    world.add(st.Plane(), static=True, material="table")
    s, c = math.sin(LEAN), math.cos(LEAN)
    high, pitch = LONG * c + THICK * s, 2 * (LONG * s + THICK * c) + 2e-4
    card = {"material": "card", "density": 900}
    for storey in range(storeys):
        pairs, floor = storeys - storey, storey * (high + THICK)
        for k in range(pairs):
            x = pitch * (k - (pairs - 1) / 2)
            for side in (-1, 1):
                turn = (math.cos(LEAN / 2), 0, -side * math.sin(LEAN / 2), 0)
                middle = x + side * (LONG * s + THICK * c) / 2
                world.add(st.Box((THICK, WIDE, LONG)), position=(middle, 0, floor + high / 2), orientation=turn, **card)
        for k in range(pairs - 1):
            flat = (pitch * (k - (pairs - 2) / 2), 0, floor + high + THICK / 2)
            world.add(st.Box((pitch - 2e-4, WIDE, THICK)), position=flat, **card)
    return world


# %%
# A single tent, with friction at its feet 10 % above and 10 % below the formula, and a house of three storeys. (Where
# two edges meet, any direction between their faces may be the normal. The engine takes that of a face, so the tips of
# the tent need a coefficient above :math:`\tan a`; they get 0.6.)

need = math.tan(LEAN) / 2
worlds = {}
for storeys, mu in ((1, 1.1 * need), (1, 0.9 * need), (3, 0.6), (3, 0.3)):
    world = worlds[storeys, mu] = house(storeys, mu, tips=0.6 if storeys == 1 else None)
    top = world.positions[:, 2].max()
    world.run(0.2)
    early = world.positions[:, 2].max()
    if early > 0.98 * top:
        world.run(2.0)
    stands = world.positions[:, 2].max() > 0.95 * top
    print(f"{storeys} storeys, mu = {mu:.3f}: {'stands' if stands else 'falls'}")
    assert stands == (mu > (need if storeys == 1 else math.tan(LEAN)))

# %%

figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.6))
for axes, mu in zip(panels, (0.6, 0.3), strict=True):
    plot.bodies(axes, worlds[3, mu], (-75, 12), colors=None if mu > 0.4 else "#e8590c")
    axes.set_title(f"Three storeys, $\\mu$ = {mu}")
    axes.set_axis_off()
plt.show()
