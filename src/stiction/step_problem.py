"""The contact problem that a world stands before: masses, contacts and momenta of its next step, as one value.

Contacts are those that the step itself will find: a copy of the world takes it, and its manifolds are read where the
bodies are now. What the world's own solver makes of them comes along, so that solvers can be compared.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction.core import state
from stiction.core.contact_space import contact_basis, world_inverse_inertia
from stiction.core.integrate import spin_in_contact
from stiction.core.solve.depth import GENTLE
from stiction.core.solve.exact import PUSH_OUT
from stiction.core.vec import Quat, mat33, rotation, vec3
from stiction.errors import InvalidInputError, NotYetError

if TYPE_CHECKING:
    from stiction.problems import ContactProblem
    from stiction.soft_store import SoftStore

Array = NDArray[np.float64]

TOUCHES = 1e-5
"""m: a point that is no farther open touches, as in :meth:`stiction.World.contacts`."""


class _Points(NamedTuple):
    """The contact points of a step, n of them."""

    a: NDArray[np.int64]
    b: NDArray[np.int64]
    point: Array
    frame: Array  # (n, 3, 3), columns: the normal from a to b, and two in the plane
    gap: Array
    slides: NDArray[np.bool_]
    impulse: Array  # (n, 3) on b, the normal component first


def problem_of_next_step(store: SoftStore, settings: state.Settings, table: Array, title: str) -> ContactProblem:
    """See :meth:`stiction.World.contact_problem`."""
    from stiction.problems import ContactPlaces, ContactProblem

    if table.shape[2] > state.STATIC_ACROSS:
        raise NotYetError(
            "contact_problem is not there yet for pairs with laws, grain or adhesion: a contact problem has one "
            "coefficient a contact."
        )
    points = _points_of(store, settings, table)
    keep = _matters(store, settings, points)
    points = _Points(
        points.a[keep], points.b[keep], points.point[keep], points.frame[keep], points.gap[keep], points.slides[keep],
        points.impulse[keep],
    )  # fmt: skip
    # H has a row of six for each dynamic body that is touched
    touched = np.unique(np.concatenate([points.a, points.b]))
    moving = touched[store.kinds[touched, state.MOBILITY] == state.DYNAMIC]
    if not len(moving):
        raise InvalidInputError("contact_problem must have a contact, got a world in which nothing touches.")
    M, f = _masses(store, settings, moving)
    H = _wrenches(store, points, moving)
    mu = _coefficients(store, table, points)
    places = ContactPlaces(points.point, points.frame, np.stack([points.a, points.b], axis=1), points.impulse)
    w = _given_velocities(store, settings, table, points)
    return ContactProblem.from_global(M, H, f, w, mu, title=title, places=places)


def _points_of(store: SoftStore, settings: state.Settings, table: Array) -> _Points:
    """The points of the next step where the bodies are now, with the impulses that they get in it."""
    after = copy.deepcopy(store)
    failure = after.step(1, settings, table)
    if failure is not None:
        raise InvalidInputError(f"contact_problem must have a finite next step, body {failure.body} leaves it.")
    n = store.n
    after.bodies[:n] = store.bodies[:n]
    after.collect_contacts()
    rows, tags = after.contacts[: after.m], after.tags[: after.m]
    frame = np.array([contact_basis(vec3(row, 0, state.NORMAL)) for row in rows[:, None]]).reshape(-1, 3, 3)
    friction = rows[:, state.TOTAL_FRICTION : state.TOTAL_FRICTION + 3]
    impulse = np.einsum("nij,ni->nj", frame, friction)
    impulse[:, 0] = rows[:, state.TOTAL]
    slides = tags[:, state.STATUS] & state.SLIDING == state.SLIDING
    point = rows[:, state.POINT : state.POINT + 3].copy()
    a, b = tags[:, state.BODY_A].copy(), tags[:, state.BODY_B].copy()
    return _Points(a, b, point, frame, rows[:, state.SEPARATION].copy(), slides, impulse)


def _matters(store: SoftStore, settings: state.Settings, points: _Points) -> NDArray[np.bool_]:
    """Points that touch, that carry a load in the step, or whose gap would close in it if nothing held the bodies.

    The solvers look farther ahead, but what stays open would only make |q| larger, and errors smaller by that.
    """
    touched = np.unique(np.concatenate([points.a, points.b]))
    v = np.zeros((store.n, 6))
    v[:, :3] = store.bodies[: store.n, state.V : state.V + 3]
    v[:, 3:] = store.bodies[: store.n, state.W : state.W + 3]
    gained = np.array([settings.gravity_x, settings.gravity_y, settings.gravity_z]) * settings.dt
    v[touched[store.kinds[touched, state.MOBILITY] == state.DYNAMIC], :3] += gained
    opening = points.gap / settings.dt
    for bodies, sign in ((points.a, -1.0), (points.b, 1.0)):
        velocity = v[bodies, :3] + np.cross(v[bodies, 3:], points.point - _centres(store, bodies))
        opening = opening + sign * np.einsum("ni,ni->n", points.frame[:, :, 0], velocity)
    kept: NDArray[np.bool_] = (points.impulse[:, 0] > 0.0) | (points.gap <= TOUCHES) | (opening < 0.0)
    return kept


def _masses(store: SoftStore, settings: state.Settings, moving: NDArray[np.int64]) -> tuple[Any, Array]:
    """M and f: what the bodies' velocities would be without contacts at the end of the step, times their masses."""
    from scipy.sparse import bsr_array

    blocks, f = np.zeros((2 * len(moving), 3, 3)), np.zeros((len(moving), 6))
    gravity = np.array([settings.gravity_x, settings.gravity_y, settings.gravity_z])
    for k, i in enumerate(moving.tolist()):
        row = store.bodies[i : i + 1]
        q, w = Quat(*row[0, state.ORIENTATION : state.ORIENTATION + 4]), vec3(row, 0, state.W)
        tensors = mat33(row, 0, state.INERTIA), mat33(row, 0, state.INVERSE_INERTIA)
        free, R, _ = spin_in_contact(q, rotation(q), *tensors, w, settings.dt)
        # R I R^T, as for its inverse
        inertia = np.array(world_inverse_inertia(R, mat33(row, 0, state.INERTIA))).reshape(3, 3)
        mass = row[0, state.MASS]
        blocks[2 * k], blocks[2 * k + 1] = mass * np.eye(3), 0.5 * (inertia + inertia.T)
        force, torque = row[0, state.FORCE : state.FORCE + 3], row[0, state.TORQUE : state.TORQUE + 3]
        f[k, :3] = mass * (row[0, state.V : state.V + 3] + gravity * settings.dt) + force * settings.dt
        f[k, 3:] = blocks[2 * k + 1] @ np.array(w + free) + torque * settings.dt
    size = 6 * len(moving)
    diagonal = np.arange(2 * len(moving))
    return bsr_array((blocks, diagonal, np.arange(len(blocks) + 1)), shape=(size, size)).tocsc(), f.ravel()


def _centres(store: SoftStore, bodies: NDArray[np.int64]) -> Array:
    """Centres of mass, (n, 3) m."""
    found = np.zeros((store.n, 3))
    for i in np.unique(bodies).tolist():
        row = store.bodies[i : i + 1]
        arm = rotation(Quat(*row[0, state.ORIENTATION : state.ORIENTATION + 4])) @ vec3(row, 0, state.CENTER)
        found[i] = row[0, state.POSITION : state.POSITION + 3] + np.array(arm)
    return found[bodies]


def _wrenches(store: SoftStore, points: _Points, moving: NDArray[np.int64]) -> Any:
    """H, (6 bodies, 3 contacts): force and torque of a unit impulse in each direction on b, and its opposite on a."""
    from scipy.sparse import coo_array

    place = np.full(store.n, -1)
    place[moving] = np.arange(len(moving))
    rows, columns, values = [], [], []
    for bodies, sign in ((points.a, -1.0), (points.b, 1.0)):
        arm = points.point - _centres(store, bodies)
        torque = np.cross(arm[:, None, :], points.frame.transpose(0, 2, 1)).transpose(0, 2, 1)
        wrench = sign * np.concatenate([points.frame, torque], axis=1)  # (n, 6, 3)
        (here,) = np.nonzero(place[bodies] >= 0)
        row = 6 * place[bodies[here]][:, None, None] + np.arange(6)[None, :, None]
        column = 3 * here[:, None, None] + np.arange(3)[None, None, :]
        shape = (len(here), 6, 3)
        rows.append(np.broadcast_to(row, shape).ravel())
        columns.append(np.broadcast_to(column, shape).ravel())
        values.append(wrench[here].ravel())
    size = (6 * len(moving), 3 * len(points.a))
    return coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=size).tocsc()


def _coefficients(store: SoftStore, table: Array, points: _Points) -> Array:
    """Of each point: static, or dynamic for what slides."""
    i, j = store.kinds[points.a, state.MATERIAL], store.kinds[points.b, state.MATERIAL]
    chosen: Array = np.where(points.slides, table[i, j, state.DYNAMIC_MU], table[i, j, state.STATIC_MU])
    return chosen


def _given_velocities(store: SoftStore, settings: state.Settings, table: Array, points: _Points) -> Array:
    """w, (3n,): velocities of kinematic bodies and belts, gaps that may close, restitution, and the push-out."""
    w = np.zeros((len(points.a), 3))
    before = np.zeros(len(points.a))
    for bodies, sign in ((points.a, -1.0), (points.b, 1.0)):
        rows = store.bodies[bodies]
        arm = points.point - _centres(store, bodies)
        velocity = rows[:, state.V : state.V + 3] + np.cross(rows[:, state.W : state.W + 3], arm)
        in_frame = sign * np.einsum("nij,ni->nj", points.frame, velocity)
        before += in_frame[:, 0]
        w += np.where((store.kinds[bodies, state.MOBILITY] == state.KINEMATIC)[:, None], in_frame, 0.0)
        for k in np.flatnonzero(rows[:, state.SURFACE : state.SURFACE + 3].any(axis=1)).tolist():
            R = rotation(Quat(*rows[k, state.ORIENTATION : state.ORIENTATION + 4]))
            belt = np.array(R @ vec3(rows, k, state.SURFACE))
            w[k, 1:] += sign * (points.frame[k].T @ belt)[1:]
    h = settings.dt
    # only the exact solver pushes out of a penetration rigidly; soft contacts rest in theirs
    pushed = np.maximum(points.gap * (PUSH_OUT if store.rigid else 0.0) / h, -GENTLE)
    w[:, 0] += np.where(points.gap > 0.0, points.gap / h, pushed)
    i, j = store.kinds[points.a, state.MATERIAL], store.kinds[points.b, state.MATERIAL]
    bounces = before < -settings.threshold
    w[:, 0] += np.where(bounces, table[i, j, state.RESTITUTION] * before, 0.0)
    return w.ravel()
