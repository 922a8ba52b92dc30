"""The lecture as plain functions on numpy arrays, to be taught with and tested against.

"PSE Game Physics, Session (7) Friction" (Atanasov, Neumann, Schreiber, 2011), slide by slide. Each function checks its
arguments and calls the function of ``stiction.core`` that the solver itself compiles; nothing is computed twice.
Vectors are (3,), matrices (3, 3) with column vectors (``M @ v``), units SI. Where a slide is unclear or wrong, the
docstring says so and the right law is used; the literal form stays beside it where it can be computed at all.

Two sets of signs, as in the lecture:

*Forces* (first half): ``n`` is the surface's normal and points towards the object; ``f`` acts on the object.

*Impulses* (second half): the contact normal points from body A to body B, the collision velocity is v_A - v_B, so that
its normal part v_C is positive while the bodies approach. In *contact coordinates* the normal comes first, then two
planar directions. An impulse g acts with +g on B and -g on A and takes K g away from the collision velocity.

Every function raises :class:`~stiction.InvalidInputError` for a wrong shape, a number that is not finite, a zero
normal, a negative coefficient, a mass not above zero, an inertia that is not symmetric, a basis that is not
orthonormal, or a K that is not symmetric and positive definite. Normals may have any length but zero.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.core import contact_space
from stiction.core.friction import coulomb, forces, rolling
from stiction.core.vec import Mat33, Vec3
from stiction.errors import InvalidInputError

Array = NDArray[np.float64]

SLIDES: dict[tuple[str, str], tuple[str, ...]] = {
    ("Static friction - Part 2", "|f_static| <= mu_static |r|"): ("lecture.static_friction",),
    ("Static friction - Part 2", "r = -f . n"): ("lecture.reaction_force",),
    ("Static friction - Part 2", "f_planar = f + r"): ("lecture.planar_force",),
    ("Static friction - Part 2", "f_static: the case with the smaller magnitude"): ("lecture.static_friction",),
    ("Dynamic friction - Part 2", "f_dynamic = -v_planar mu_dynamic |r|"): ("lecture.dynamic_friction",),
    ("Dynamic friction - Part 2", "most engines mix the two types"): ("lecture.mixed_friction",),
    ("Rolling friction", "ignored in the lab; here a torque"): ("lecture.resisting_torque",),
    ("Some coefficients", "nine pairs of materials"): ("MaterialTable.lecture",),
    ("How to implement friction?", "resting contacts by micro-collisions"): (
        "core.solve.resting.resolve_resting",
        "core.solve.micro.settle",
    ),
    ("Friction as impulses", "v_collision = v_A - v_B"): ("lecture.collision_velocity",),
    ("Friction as impulses", "v_planar = v_collision - n v_C"): ("lecture.planar_velocity",),
    ("Friction as impulses", "friction collision basis B"): ("lecture.contact_basis",),
    ("Friction as impulses", "the case distinction static / dynamic"): (
        "lecture.coulomb_impulse",
        "lecture.literal_change",
        "lecture.clipped_impulse",
    ),
    ("Angular motion to velocity", "g_max = Delta g v_mu"): ("lecture.maximal_impulse",),
    ("Angular motion to velocity", "Delta g = Delta v^-1"): ("lecture.impulse_per_velocity",),
    ("The skew-symmetric matrix", "S_v x = v x x"): ("lecture.skew",),
    ("The algorithm for angular motion", "u = S_p B"): ("lecture.impulsive_torque",),
    ("The algorithm for angular motion", "M^-T I^-1 M^T"): ("lecture.world_inverse_inertia",),
    ("The algorithm for angular motion", "Delta r = M^-T I^-1 M^T u"): ("lecture.rotation_change",),
    ("The algorithm for angular motion", "Delta v_r = Delta r S_p (-1)"): ("lecture.rotation_to_velocity",),
    ("The algorithm for angular motion", "Delta v_r-contact = B^-1 Delta v_r"): ("lecture.to_contact",),
    ("The algorithm for linear motion", "Delta v_l = m^-1 g, as a matrix"): ("lecture.inverse_mass_matrix",),
    ("The algorithm for linear motion", "to be added to the angular matrix"): (
        "lecture.velocity_per_impulse",
        "lecture.contact_matrix",
    ),
    ("The modified velocity resolution algorithm", "one step (outline only)"): ("core.step.step",),
}
"""(slide, formula) -> the functions that do it, by their names below ``stiction``."""


def slide_table() -> list[tuple[str, str, str]]:
    """The rows (slide, formula, functions) of :data:`SLIDES` in the lecture's order, for a table in print."""
    return [(slide, formula, ", ".join(names)) for (slide, formula), names in SLIDES.items()]


# --- friction as a force ----------------------------------------------------------------------------------------------


def reaction_force(f: ArrayLike, n: ArrayLike) -> Array:
    """r = -(f . n) n where f presses into the surface, else zero. Slide "Static friction - Part 2".

    The slide writes r = -f . n, which is a number; the force is that number along n. It also leaves out that a surface
    pushes but never pulls.

    Args:
        f: force on the object without contact forces, (3,), N.
        n: normal of the surface, towards the object, (3,), any length but zero.

    Returns:
        (3,), N.
    """
    return _array(forces.reaction_force(_vector("f", f), _direction("n", n)))


def planar_force(f: ArrayLike, n: ArrayLike) -> Array:
    """f_planar = f + r: what is left of f without its component along n. Slide "Static friction - Part 2".

    Args:
        f: force on the object, (3,), N.
        n: normal of the surface, towards the object, (3,).

    Returns:
        (3,), N.
    """
    return _array(forces.planar_force(_vector("f", f), _direction("n", n)))


def static_friction(f: ArrayLike, n: ArrayLike, mu_static: float) -> Array:
    """The case with the smaller magnitude of -f_planar and mu_s |r| against f_planar. Slide "Static friction - Part 2".

    The slide's second case, "f_planar - mu_static |r|", takes a number from a vector and has the sign of the push; what
    is meant is -mu_s |r| f_planar / |f_planar|.

    Args:
        f: force on the object without contact forces, (3,), N.
        n: normal of the surface, towards the object, (3,).
        mu_static: coefficient, dimensionless.

    Returns:
        (3,), N.
    """
    mu = checks.non_negative("mu_static", mu_static)
    return _array(forces.static_friction(_vector("f", f), _direction("n", n), mu))


def dynamic_friction(f: ArrayLike, n: ArrayLike, v: ArrayLike, mu_dynamic: float, literal: bool = False) -> Array:
    """-mu_d |r| v_planar / |v_planar|: the size does not depend on the speed. Slide "Dynamic friction - Part 2".

    The slide's formula, -v_planar mu_dynamic |r|, lacks the division by |v_planar|: its unit is N m/s, it brakes a fast
    object too much and a slow one too little, and it never stops anything.

    Args:
        f: force on the object without contact forces, (3,), N.
        n: normal of the surface, towards the object, (3,).
        v: velocity of the object against the surface, (3,), m/s; its normal component does not count.
        mu_dynamic: coefficient, dimensionless.
        literal: use the slide's formula word for word.

    Returns:
        (3,), N; zero for an object that does not move. (3,), N m/s with ``literal``.
    """
    force, normal = _vector("f", f), _direction("n", n)
    planar = contact_space.planar_velocity(_vector("v", v), normal)
    mu = checks.non_negative("mu_dynamic", mu_dynamic)
    if not isinstance(literal, bool):
        raise InvalidInputError(f"literal must be True or False, got {literal!r}.")
    return _array(forces.dynamic_friction(force, normal, planar, mu, literal))


def mixed_friction(f: ArrayLike, n: ArrayLike, v: ArrayLike, mu: float) -> Array:
    """Static friction at rest, dynamic friction in motion, one coefficient for both. Slide "Dynamic friction - Part 2".

    "Most engines today mix the two types of friction": then nothing can break away, and what moves stops as soon as the
    push falls below the force that set it in motion.

    Args:
        f: force on the object without contact forces, (3,), N.
        n: normal of the surface, towards the object, (3,).
        v: velocity of the object against the surface, (3,), m/s.
        mu: the one coefficient, dimensionless.

    Returns:
        (3,), N.
    """
    force, normal = _vector("f", f), _direction("n", n)
    planar = contact_space.planar_velocity(_vector("v", v), normal)
    return _array(forces.mixed_friction(force, normal, planar, checks.non_negative("mu", mu)))


# --- contact space ----------------------------------------------------------------------------------------------------


def contact_basis(normal: ArrayLike) -> Array:
    """B, whose columns are the normal and two planar directions. Slide "Friction as impulses", figure.

    B turns contact coordinates into world coordinates. It is orthonormal and right-handed, so B^-1 = B^T; the formula
    is that of Duff et al., J. Comput. Graph. Tech. 6(1), 2017. The slides do not say how the planar directions are
    chosen, and by Coulomb's round cone nothing may depend on it.

    Args:
        normal: from body A to body B, (3,), any length but zero.

    Returns:
        (3, 3), dimensionless.
    """
    return _array(contact_space.contact_basis(_direction("normal", normal)))


def collision_velocity(
    v_a: ArrayLike,
    w_a: ArrayLike,
    r_a: ArrayLike,
    v_b: ArrayLike = (0.0, 0.0, 0.0),
    w_b: ArrayLike = (0.0, 0.0, 0.0),
    r_b: ArrayLike = (0.0, 0.0, 0.0),
) -> Array:
    """v_collision = v_A - v_B at the contact point, v = v_centre + w x r. Slide "Friction as impulses".

    Args:
        v_a, v_b: velocities of the centres of mass, (3,), m/s.
        w_a, w_b: angular velocities in world axes, (3,), rad/s.
        r_a, r_b: arms from the centres of mass to the contact point, (3,), m. Body B rests unless given.

    Returns:
        (3,), world axes, m/s.
    """
    a = (_vector("v_a", v_a), _vector("w_a", w_a), _vector("r_a", r_a))
    b = (_vector("v_b", v_b), _vector("w_b", w_b), _vector("r_b", r_b))
    return _array(contact_space.collision_velocity(*a, *b))


def planar_velocity(v: ArrayLike, n: ArrayLike) -> Array:
    """v_planar = v_collision - n v_C with v_C = n . v_collision. Slide "Friction as impulses".

    Args:
        v: collision velocity, (3,), m/s.
        n: contact normal, (3,), any length but zero.

    Returns:
        (3,), m/s.
    """
    return _array(contact_space.planar_velocity(_vector("v", v), _direction("n", n)))


def skew(v: ArrayLike) -> Array:
    """S_v, the skew-symmetric matrix with S_v x = v x x. Slide "The skew-symmetric matrix".

    Args:
        v: (3,), any unit.

    Returns:
        (3, 3), the unit of v.
    """
    return _array(contact_space.skew(_vector("v", v)))


def impulsive_torque(r: ArrayLike, B: ArrayLike) -> Array:
    """u = S_p B, the torque of a unit impulse in each direction. Slide "The algorithm for angular motion", step 1.

    The slide has p_contact "in object space" and B to world coordinates; both must be in the same axes, the world's.

    Args:
        r: arm p from the centre of mass to the contact point, (3,), m, world axes.
        B: the basis, (3, 3); or the normal alone, (3,), for the algorithm without friction.

    Returns:
        (3, 3), one column a direction, or (3,); m, which is N m s per N s.
    """
    return _array(contact_space.impulsive_torque(_vector("r", r), _either("B", B)))


def world_inverse_inertia(R: ArrayLike, I_inv: ArrayLike) -> Array:
    """R I^-1 R^T, the slides' M^-T I^-1 M^T. Slide "The algorithm for angular motion", step 2.

    For a rotation M^-T = M, so the slide's product is M I^-1 M^T: right for column vectors and M = R, from the body's
    axes to the world's. (With row vectors, whose matrix is R^T, it would go the wrong way.)

    Args:
        R: rotation from the body's axes to the world's, (3, 3).
        I_inv: inverse inertia tensor in the body's axes, (3, 3), 1/(kg m^2).

    Returns:
        (3, 3), world axes, 1/(kg m^2).
    """
    return _array(contact_space.world_inverse_inertia(_rotation("R", R), _symmetric("I_inv", I_inv)))


def rotation_change(I_inv: ArrayLike, u: ArrayLike) -> Array:
    """dr = I^-1 u, the change of angular velocity a unit impulse. Slide "The algorithm for angular motion", step 2.

    Args:
        I_inv: inverse inertia tensor in world axes (:func:`world_inverse_inertia`), (3, 3), 1/(kg m^2).
        u: impulsive torque a unit impulse, (3, 3) or (3,), m.

    Returns:
        The shape of u, 1/(kg m), which is rad/s per N s.
    """
    return _array(contact_space.rotation_change(_symmetric("I_inv", I_inv), _either("u", u)))


def rotation_to_velocity(r: ArrayLike, dr: ArrayLike) -> Array:
    """dv_r = -S_p dr = dr x p. Slide "The algorithm for angular motion", step 3.

    The slide has S_p on the right, dr S_p (-1), as in the book's product S_p I^-1 S_p (-1), which reads the same from
    both ends. With B inside u it no longer does: S_p must stand on the left, and dr x p = -S_p dr gives the (-1).

    Args:
        r: arm p from the centre of mass to the contact point, (3,), m, world axes.
        dr: change of angular velocity a unit impulse, (3, 3) or (3,), 1/(kg m).

    Returns:
        Change of the contact point's velocity a unit impulse, the shape of dr, 1/kg.
    """
    return _array(contact_space.rotation_to_velocity(_vector("r", r), _either("dr", dr)))


def to_contact(B: ArrayLike, dv: ArrayLike) -> Array:
    """B^-1 dv = B^T dv, into contact coordinates. Slide "The algorithm for angular motion", step 4.

    Args:
        B: the basis, orthonormal, (3, 3).
        dv: (3,) or, one column a direction, (3, 3), any unit, world axes.

    Returns:
        The shape and unit of dv.
    """
    return _array(contact_space.to_contact(_rotation("B", B), _either("dv", dv)))


def inverse_mass_matrix(m: float) -> Array:
    """m^-1 times the unit matrix, "to be added to the angular matrix". Slide "The algorithm for linear motion".

    Args:
        m: mass, kg; ``math.inf`` for a body that cannot move.

    Returns:
        (3, 3), 1/kg.
    """
    return _array(contact_space.inverse_mass_matrix(_inverse_mass("m", m)))


def velocity_per_impulse(m: float, I_inv: ArrayLike, r: ArrayLike, B: ArrayLike) -> Array:
    """One body's share of K, m^-1 1 + B^T (-S_p I^-1 S_p) B. Slide "The algorithm for linear motion".

    Args:
        m: mass, kg; ``math.inf`` (with ``I_inv`` zero) for a body that cannot move.
        I_inv: inverse inertia tensor in world axes, (3, 3), 1/(kg m^2).
        r: arm from the centre of mass to the contact point, (3,), m, world axes.
        B: the basis, orthonormal, (3, 3).

    Returns:
        (3, 3), 1/kg, contact coordinates.
    """
    body = (_inverse_mass("m", m), _symmetric("I_inv", I_inv), _vector("r", r))
    return _array(contact_space.velocity_per_impulse(*body, _rotation("B", B)))


def contact_matrix(
    B: ArrayLike,
    m_a: float,
    I_inv_a: ArrayLike,
    r_a: ArrayLike,
    m_b: float = math.inf,
    I_inv_b: ArrayLike | None = None,
    r_b: ArrayLike = (0.0, 0.0, 0.0),
) -> Array:
    """K, the sum of both bodies' shares. Slide "The algorithm for linear motion"; the sum is left out there.

    Column by column it is the change of collision velocity that a unit impulse makes (with -g on A and +g on B: -K g).
    It comes out symmetric and positive definite, with K_nn = 1/m + n . ((I^-1 (r x n)) x r) a body. u = S_p B contains
    B already, so step 4 takes B^-1 on the left alone; a change of basis of the matrix, B^-1 (.) B, would apply B twice.

    Args:
        B: the basis, orthonormal, (3, 3).
        m_a, m_b: masses, kg; ``math.inf`` for a body that cannot move, as B is unless given.
        I_inv_a, I_inv_b: inverse inertia tensors in world axes, (3, 3), 1/(kg m^2); zero for B unless given.
        r_a, r_b: arms from the centres of mass to the contact point, (3,), m, world axes.

    Returns:
        (3, 3), 1/kg, contact coordinates.
    """
    a = (_inverse_mass("m_a", m_a), _symmetric("I_inv_a", I_inv_a), _vector("r_a", r_a))
    tensor = np.zeros((3, 3)) if I_inv_b is None else I_inv_b
    b = (_inverse_mass("m_b", m_b), _symmetric("I_inv_b", tensor), _vector("r_b", r_b))
    return _array(contact_space.contact_matrix(*a, *b, _rotation("B", B)))


def impulse_per_velocity(K: ArrayLike) -> Array:
    """Delta g = Delta v^-1, the matrix inverse of K. Slide "Angular motion to velocity".

    Args:
        K: contact matrix, symmetric and positive definite, (3, 3), 1/kg.

    Returns:
        (3, 3), kg, contact coordinates.
    """
    return _array(contact_space.impulse_per_velocity(_definite("K", K)))


def maximal_impulse(K: ArrayLike, v: ArrayLike) -> Array:
    """g_max = Delta g v_mu, the impulse that takes the whole velocity away. Slide "Angular motion to velocity".

    Args:
        K: contact matrix, (3, 3), 1/kg.
        v: the velocity v_mu to take away, (3,), m/s, contact coordinates.

    Returns:
        (3,), N s, contact coordinates.
    """
    return _array(contact_space.maximal_impulse(_definite("K", K), _vector("v", v)))


# --- the case distinction ---------------------------------------------------------------------------------------------


def coulomb_impulse(K: ArrayLike, v: ArrayLike, mu_static: float, mu_dynamic: float) -> tuple[Array, bool]:
    """The impulse that obeys Signorini's condition and Coulomb's law; what ``micro`` uses for every contact.

    Inside the cone |g_t| <= mu_s g_n it is g_max. Otherwise |g_t| = mu_d g_n and the slip that remains is a positive
    multiple of g_t, so that friction is exactly opposite to sliding. Stands for the slide's case distinction
    ("Friction as impulses"), which asks the velocity instead of the impulse and does not normalise the sliding case.

    Args:
        K: contact matrix, (3, 3), 1/kg.
        v: the velocity to take away, (3,), m/s, contact coordinates: the collision velocity, or with a restitution e
            its normal component times 1 + e.
        mu_static, mu_dynamic: coefficients, dimensionless, the dynamic one at most as large.

    Returns:
        The impulse, (3,), N s, contact coordinates, and whether the contact sticks. Zero and False if it opens.

    Raises:
        InvalidInputError: also if ``mu_dynamic`` is above ``mu_static``.
    """
    stick, slide = checks.non_negative("mu_static", mu_static), checks.non_negative("mu_dynamic", mu_dynamic)
    if slide > stick:
        raise InvalidInputError(f"mu_dynamic must not be above mu_static, got {mu_dynamic!r} above {mu_static!r}.")
    g, sticks = coulomb.coulomb_impulse(_definite("K", K), _vector("v", v), stick, slide)
    return _array(g), bool(sticks)


def clipped_impulse(K: ArrayLike, v: ArrayLike, mu: float) -> tuple[Array, bool]:
    """g_max scaled back onto the cone along its own direction: the book's reading of slide "Friction as impulses".

    I. Millington, "Game Physics Engine Development", ch. 15; most engines do the same. Its friction points along
    K^-1 v, not along the slip. J_n must be found anew, for K couples the normal with the plane: with its planar part
    cut, g_max no longer stops the approach.

    Args:
        K: contact matrix, (3, 3), 1/kg.
        v: the velocity to take away, (3,), m/s, contact coordinates.
        mu: the one coefficient, dimensionless.

    Returns:
        The impulse, (3,), N s, contact coordinates, and whether the contact sticks. Zero and False if it opens.
    """
    g, sticks = coulomb.clipped_impulse(_definite("K", K), _vector("v", v), checks.non_negative("mu", mu))
    return _array(g), bool(sticks)


def literal_change(v: ArrayLike, mu_static: float, mu_dynamic: float, restitution: float = 0.0) -> tuple[Array, bool]:
    """v_mu word for word from slide "Friction as impulses"; what ``micro_literal`` uses.

    Take v_planar away if |v_planar| <= v_C mu_static, else v_planar mu_dynamic. The condition is the friction cone in
    velocity space, right only where K is a multiple of the unit matrix (a point mass): a solid sphere sticks up to
    7/2 mu_s v_C. The second case takes the same share of the slip at every collision, however light.

    Args:
        v: collision velocity, (3,), m/s, contact coordinates.
        mu_static, mu_dynamic: coefficients, dimensionless.
        restitution: ratio of the normal speeds after and before, 0 to 1.

    Returns:
        The velocity to take away, (3,), m/s, contact coordinates (g_max = K^-1 v_mu does it), and whether it sticks.
    """
    velocity, e = _vector("v", v), checks.non_negative("restitution", restitution)
    if e > 1.0:
        raise InvalidInputError(f"restitution must be 0 to 1, got {restitution!r}.")
    stick, slide = checks.non_negative("mu_static", mu_static), checks.non_negative("mu_dynamic", mu_dynamic)
    v_mu, sticks = coulomb.literal_change(velocity, e, stick, slide)
    return _array(v_mu), bool(sticks)


def resisting_torque(
    I_inv: ArrayLike,
    B: ArrayLike,
    spin: ArrayLike,
    normal_impulse: float,
    rolling_length: float,
    torsional: float = 0.0,
) -> Array:
    """The angular impulse of rolling and torsional resistance. Slide "Rolling friction", there "ignored in this lab".

    |m_t| <= rolling_length g_n against rolling, |m_n| <= torsional g_n against spinning on the spot, never past rest.

    Args:
        I_inv: sum of both bodies' inverse inertia tensors, world axes, (3, 3), 1/(kg m^2).
        B: the basis, orthonormal, (3, 3).
        spin: w_A - w_B, (3,), rad/s, world axes.
        normal_impulse: g_n, N s.
        rolling_length, torsional: the coefficients, m.

    Returns:
        (3,), N m s, contact coordinates, + on B and - on A.
    """
    none, gn = Vec3(0.0, 0.0, 0.0), checks.non_negative("normal_impulse", normal_impulse, "N s")
    roll = checks.non_negative("rolling_length", rolling_length, "m")
    twist = checks.non_negative("torsional", torsional, "m")
    tensor, basis = _definite("I_inv", I_inv), _rotation("B", B)
    return _array(rolling.resisting_torque(tensor, basis, _vector("spin", spin), none, roll, twist, gn))


# --- arrays to core's values and back ---------------------------------------------------------------------------------


def _array(value: Vec3 | Mat33) -> Array:
    result = np.array(value, dtype=np.float64)
    return result.reshape(3, 3) if isinstance(value, Mat33) else result


def _vector(name: str, value: Any) -> Vec3:
    return Vec3(*checks.vector(name, value).tolist())


def _direction(name: str, value: Any) -> Vec3:
    return Vec3(*checks.unit_vector(name, value).tolist())


def _mat33(matrix: Array) -> Mat33:
    return Mat33(*matrix.ravel().tolist())


def _finite(name: str, value: Any, shapes: tuple[tuple[int, ...], ...] = ((3, 3),)) -> Array:
    """A finite float64 array of one of these shapes, a copy."""
    allowed = " or ".join(str(shape) for shape in shapes)
    try:
        result = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} must be finite numbers of shape {allowed}, got {value!r}.") from None
    if result.shape not in shapes:
        raise InvalidInputError(f"{name} must have shape {allowed}, got shape {result.shape} from {value!r}.")
    if not np.isfinite(result).all():
        raise InvalidInputError(f"{name} must be finite numbers of shape {allowed}, got {value!r}.")
    return result


def _either(name: str, value: Any) -> Vec3 | Mat33:
    """A vector for one direction, or a matrix with one direction a column."""
    result = _finite(name, value, ((3,), (3, 3)))
    return _mat33(result) if result.ndim == 2 else Vec3(*result.tolist())


def _rotation(name: str, value: Any) -> Mat33:
    matrix = _finite(name, value)
    if not np.allclose(matrix.T @ matrix, np.eye(3), rtol=0.0, atol=1e-9) or np.linalg.det(matrix) < 0.0:
        raise InvalidInputError(f"{name} must be orthonormal and right-handed, got {matrix.tolist()}.")
    return _mat33(matrix)


def _symmetric(name: str, value: Any) -> Mat33:
    matrix = _finite(name, value)
    if np.abs(matrix - matrix.T).max() > 1e-9 * np.abs(matrix).max():
        raise InvalidInputError(f"{name} must be symmetric, got {matrix.tolist()}.")
    return _mat33(matrix)


def _definite(name: str, value: Any) -> Mat33:
    matrix = _symmetric(name, value)
    eigenvalues = np.linalg.eigvalsh(_array(matrix))
    if eigenvalues[0] <= 1e-12 * eigenvalues[2]:
        raise InvalidInputError(f"{name} must be positive definite, but has the eigenvalue {eigenvalues[0]:g}.")
    return matrix


def _inverse_mass(name: str, value: Any) -> float:
    """1/m; 0 for an infinite mass, which a body has that cannot move."""
    if isinstance(value, (int, float)) and value == math.inf:
        return 0.0
    return 1.0 / checks.positive(name, value, "kg")
