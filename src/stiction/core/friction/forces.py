"""Friction as forces: the first part of the lecture, for one body that is pressed against a surface.

Slides "Static friction - Part 2" and "Dynamic friction - Part 2". An impulse-based engine never computes these forces
("The standard friction-theory could not be applied"); they are here to be taught and to test it against.
``f`` is the force that acts on the object (N), ``n`` the unit normal of the surface, pointing towards the object.
"""

from __future__ import annotations

from stiction.core.jit import jit
from stiction.core.vec import Vec3, dot, length


@jit
def reaction_force(f, n):
    """r = -(f . n) n while f presses into the surface, else zero: a surface pushes, it does not pull.

    The slide writes r = -f . n, a number; the force is that number along n.
    """
    pressed = dot(f, n)
    return n * (-pressed if pressed < 0.0 else 0.0)


@jit
def planar_force(f, n):
    """f_planar = f + r: the total force with its component along the normal removed."""
    return f + n * (-dot(f, n))


@jit
def static_friction(f, n, mu_static):
    """The case with the smaller magnitude of -f_planar and mu_s |r| against f_planar.

    The slide's second case, "f_planar - mu_s |r|", takes a number from a vector; what is meant is
    -mu_s |r| f_planar / |f_planar|.
    """
    planar = planar_force(f, n)
    limit = mu_static * length(reaction_force(f, n))
    size = length(planar)
    if size <= limit:
        return -planar
    return planar * (-limit / size)


@jit
def dynamic_friction(f, n, v_planar, mu_dynamic, literal):
    """-mu_d |r| v_planar / |v_planar|: dynamic friction depends on the direction of sliding alone.

    With ``literal`` the slide's formula -v_planar mu_d |r|, which is not normalised: a viscous force (N m/s) that
    fades with the speed and so never stops anything.
    """
    limit = mu_dynamic * length(reaction_force(f, n))
    speed = length(v_planar)
    if literal:
        return v_planar * -limit
    if speed == 0.0:
        return Vec3(0.0, 0.0, 0.0)
    return v_planar * (-limit / speed)


@jit
def mixed_friction(f, n, v_planar, mu):
    """One coefficient for both: "most engines today mix the two types of friction"."""
    if length(v_planar) == 0.0:
        return static_friction(f, n, mu)
    return dynamic_friction(f, n, v_planar, mu, False)
