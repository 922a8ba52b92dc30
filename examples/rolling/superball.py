r"""
The superball: back from under a table
======================================

Throw a ball under a table so that it hits the floor, then the table from below. A marble goes on and comes out on the
other side. A superball comes back into the hand. Why?

Rubber springs back along the surface, too: an impact does not only stop the slip :math:`u = v + r\omega` of the point
of contact but reverses it, :math:`u' = -e_t u`. For a full sphere that means

.. math:: v' = v - \tfrac27 (1 + e_t)\, u, \qquad r\omega' = r\omega - \tfrac57 (1 + e_t)\, u.

With :math:`e_t = 1` no energy is lost, and what three impacts do, floor, table, floor, is :math:`v''' =
-\tfrac{333}{343}\, v`: it comes back as fast as it went (Garwin, 1969). With :math:`e_t = 0`, Coulomb's law alone, an
impact takes the slip and no more: the ball goes on, with 5/7 of its speed, then with 15/49, and stays there.
"""

import matplotlib.pyplot as plt
import numpy as np

import stiction as st

plt.style.use("stiction.plot.lecture")
R, HEIGHT, HAND, SPEED = 0.03, 0.7, 0.5, 6.0


def throw(rebound: float) -> tuple[np.ndarray, float]:
    """The ball's path (n, 3), m, until it is back or for 3/4 s, and the part of its energy that is left."""
    world = st.World(dt=1 / 240)
    world.materials.set_pair("ball", "wood", static=0.9, restitution=1.0, tangential_restitution=rebound)
    world.add(st.Plane(), static=True, material="wood")
    world.add(st.Box((1.1, 1.0, 0.04)), static=True, position=(0.85, 0, HEIGHT + 0.02), material="wood", name="table")
    ball = world.add(st.Sphere(R), mass=0.05, material="ball", position=(0, 0, HAND), velocity=(SPEED / 2, 0, -SPEED))
    before = ball.kinetic_energy + 0.05 * 9.81 * HAND
    path = [ball.position]
    while len(path) < 180 and path[-1][0] > -0.05:
        world.step()
        path.append(ball.position)
    return np.array(path), (ball.kinetic_energy + 0.05 * 9.81 * ball.position[2]) / before


figure, axis = plt.subplots(figsize=(9, 4.2))
axis.axhline(0, color="#5b5b5b", lw=2)
axis.add_patch(plt.Rectangle((0.3, HEIGHT), 1.1, 0.04, color="#c9a26b"))
axis.annotate("table", (0.8, HEIGHT + 0.06), fontsize=11)
for rebound, color, words in ((0.0, "#d55e00", "Coulomb's law alone"), (1.0, "#0072b2", "superball")):
    path, left = throw(rebound)
    print(f"e_t = {rebound:g}: ends at x = {path[-1, 0]:.2f} m with {100 * left:.1f} % of its energy")
    axis.plot(path[:, 0], path[:, 2], color=color, label=f"$e_t = {rebound:g}$: {words}")
    axis.plot(path[::6, 0], path[::6, 2], "o", ms=3.5, color=color)
    if rebound == 1.0:
        assert path[-1, 0] < 0.1, "it comes back"
        assert abs(left - 1.0) < 1e-3
    else:
        assert 0.3 < path[-1, 0] < 1.4, "it stays under the table"
axis.plot(0, HAND, "k*", ms=12)
axis.annotate("hand", (0.03, HAND + 0.03), fontsize=11)
axis.set(xlabel="x (m)", ylabel="height (m)", xlim=(-0.25, 1.7), ylim=(-0.03, 1.05), title="Thrown under a table")
axis.set_aspect("equal")
axis.legend(loc="upper right")
plt.show()
