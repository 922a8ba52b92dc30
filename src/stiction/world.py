"""World: bodies, materials and time."""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.body import Body, checked_inertia
from stiction.contacts import CONTACT_DTYPE
from stiction.errors import InvalidInputError, IterationLimitWarning, NotYetError, SimulationError
from stiction.materials import MaterialTable
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere

Array = NDArray[np.float64]

SOLVERS = ("micro", "soft", "exact")
AVAILABLE_SOLVERS = ("soft", "micro")
SUBSTEPS = 8
"""Of the soft solver."""
DEFAULT_DENSITY = 1000.0
"""kg/m^3, of a body that is given neither mass nor density."""
MOST_STEPS = 10**12
"""Steps of one run at most; more would take years."""
MOBILITIES = ("static", "kinematic", "dynamic")


class Energy(NamedTuple):
    """The ledger of a world, J. It closes: ``kinetic + potential == initial + work + edits + numerical - dissipated``.

    Attributes:
        kinetic, potential: of all dynamic bodies now; heights are measured from the origin along gravity.
        friction, rolling, impacts: what sliding friction, rolling and torsional resistance, and the normal part of
            collisions have dissipated so far.
        work: what applied forces and torques, kinematic bodies and moving surfaces have put in so far.
        edits: what adding, moving or pushing bodies from outside has changed since the first step.
        numerical: what the integrator and the removal of penetrations have made (or, negative, lost) so far.
        initial: kinetic and potential energy at the first step.
    """

    kinetic: float
    potential: float
    friction: float
    rolling: float
    impacts: float
    work: float
    edits: float
    numerical: float
    initial: float

    @property
    def dissipated(self) -> float:
        """Friction, rolling and impacts together, J."""
        return self.friction + self.rolling + self.impacts

    @property
    def residual(self) -> float:
        """By how much the ledger does not close, J: rounding, and nothing else."""
        put_in = self.initial + self.work + self.edits + self.numerical
        return self.kinetic + self.potential - put_in + self.dissipated


class SolverReport(NamedTuple):
    """What the solver did since the world began.

    Attributes:
        visits: contacts resolved: of penetrations, impacts and resting contact.
        limit_hits: steps in which the iteration limit stopped each of them.
        worst: largest error that was left by that: m, m/s, m/s.
    """

    visits: tuple[int, int, int]
    limit_hits: tuple[int, int, int]
    worst: tuple[float, float, float]


class World:
    """A world of rigid bodies.

    Args:
        gravity: (3,), m/s^2.
        dt: time step, s.
        solver: ``"soft"``, the default: fast, with memory of contacts from step to step; ``"micro"``, the lecture's;
            ``"exact"`` is not there yet.
        substeps: parts of a step: 8 in ``soft``; ``micro`` has one.
        iterations: how often ``micro`` may resolve a contact in a stage of a step, on average, before the limit is
            reported.
        precision: of contacts in ``soft``: ``"single"``, the default (positions are in double precision always), or
            ``"double"``; ``micro`` has ``"double"``.
        materials: the table of pairs; :meth:`MaterialTable.default` if left out. The table is used, not copied.
        micro_literal: use the slides' friction word for word instead of Coulomb's law, to see the difference.
        restitution_threshold: closing speeds below it are resting contact and do not bounce, m/s.
        sleeping: whether ``soft`` leaves islands of bodies alone while they are truly at rest.

    Raises:
        InvalidInputError: a value is not allowed.
        NotYetError: a solver, substeps or a precision that this version does not have.
    """

    def __init__(
        self,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        dt: float = 1.0 / 60.0,
        solver: str | None = None,
        substeps: int | None = None,
        iterations: int = 100,
        precision: str | None = None,
        materials: MaterialTable | None = None,
        *,
        micro_literal: bool = False,
        restitution_threshold: float = 0.25,
        sleeping: bool = True,
    ) -> None:
        self._gravity = checks.vector("gravity", gravity)
        self._dt = checks.positive("dt", dt, "s")
        self._solver = AVAILABLE_SOLVERS[0] if solver is None else checks.one_of("solver", solver, SOLVERS)
        if self._solver not in AVAILABLE_SOLVERS:
            raise NotYetError(f"solver {solver!r} is not there yet; this version has {', '.join(AVAILABLE_SOLVERS)}.")
        soft = self._solver == "soft"
        self._substeps = (SUBSTEPS if soft else 1) if substeps is None else checks.integer("substeps", substeps, minimum=1)
        if not soft and self._substeps != 1:
            raise NotYetError(f"substeps must be 1 with solver 'micro', got {substeps!r}; use a smaller dt.")
        default = "single" if soft else "double"
        precision = default if precision is None else checks.one_of("precision", precision, ("double", "single"))
        if not soft and precision != "double":
            raise NotYetError("precision 'single' is not there yet with solver 'micro'; it has 'double'.")
        if materials is not None and not isinstance(materials, MaterialTable):
            raise InvalidInputError(f"materials must be a MaterialTable, got {type(materials).__name__}.")
        if not isinstance(micro_literal, bool):
            raise InvalidInputError(f"micro_literal must be True or False, got {micro_literal!r}.")
        if micro_literal and soft:
            raise InvalidInputError("micro_literal must be left out unless solver is 'micro'.")
        if not isinstance(sleeping, bool):
            raise InvalidInputError(f"sleeping must be True or False, got {sleeping!r}.")
        self._sleeping = sleeping
        self._iterations = checks.integer("iterations", iterations, minimum=1)
        self._threshold = checks.non_negative("restitution_threshold", restitution_threshold, "m/s")
        self._micro_literal = micro_literal
        self._materials = MaterialTable.default() if materials is None else materials

        from stiction.core import state
        from stiction.store import Store

        self._state = state
        self._store = Store()
        if soft:
            from stiction.soft_store import SoftStore

            self._store = SoftStore(precision)
        self._bodies: list[Body] = []
        self._by_name: dict[str, Body] = {}
        self._material_names: list[str] = []
        self._table = np.zeros((0, 0, 5))
        self._table_of: tuple[int, int, int] | None = None
        self._warned = False
        self._settings = self._make_settings()

    # --- bodies -------------------------------------------------------------------------------------------------------

    def add(
        self,
        shape: Shape,
        *,
        static: bool = False,
        kinematic: bool = False,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        mass: float | None = None,
        density: float | None = None,
        inertia: ArrayLike | None = None,
        material: str = "default",
        name: str | None = None,
        surface_velocity: ArrayLike | None = None,
    ) -> Body:
        """Add a body and return it.

        Args:
            shape: what it looks like.
            static: it never moves. kinematic: it moves as its velocities say, whatever it meets.
            position: origin of the shape's frame, (3,), m.
            orientation: quaternion (w, x, y, z), (4,), normalised here.
            velocity: of the centre of mass, (3,), m/s.
            angular_velocity: in world axes, (3,), rad/s.
            mass: kg. density: kg/m^3. At most one of them; 1000 kg/m^3 if neither.
            inertia: about the centre of mass in the shape's axes, (3,) or (3, 3), kg m^2; from the shape if left out.
            material: its name in the world's table.
            name: unique; made from shape and number if left out.
            surface_velocity: of a belt relative to the body, in the shape's axes, (3,), m/s.

        Raises:
            InvalidInputError: a value is not allowed; the world is as before.
        """
        state = self._state
        fixed = self._checked_mobility(shape, static, kinematic)
        if name is None:
            name = f"{shape.kind} {len(self._bodies)}"
        if not isinstance(name, str) or not name:
            raise InvalidInputError(f"name must be a text that is not empty, got {name!r}.")
        if name in self._by_name:
            raise InvalidInputError(f"name must be unique in a world, got {name!r} twice.")
        row = {
            state.POSITION: checks.vector("position", position),
            state.ORIENTATION: checks.unit_quaternion("orientation", orientation),
            state.V: checks.vector("velocity", velocity),
            state.W: checks.vector("angular_velocity", angular_velocity),
            state.SURFACE: checks.vector(
                "surface_velocity", (0, 0, 0) if surface_velocity is None else surface_velocity
            ),
        }
        if static and (row[state.V].any() or row[state.W].any()):
            raise InvalidInputError(
                f"velocity and angular_velocity of static body {name!r} must be zero (a kinematic body moves, "
                f"surface_velocity makes a belt)."
            )
        row.update(self._checked_mass(shape, fixed, mass, density, inertia))
        if not isinstance(material, str) or material not in self.materials:
            self.materials.pair(material, material)  # raises, and names the nearest one

        code, row[state.SIZE] = self._code_and_size(shape)
        mobility = state.STATIC if static else state.KINEMATIC if kinematic else state.DYNAMIC
        index = self._store.add(row, code, mobility, self._material_row(material))
        body = Body(self, index, name, shape, material)
        self._bodies.append(body)
        self._by_name[name] = body
        return body

    def _code_and_size(self, shape: Shape) -> tuple[int, Array]:
        """How core names the shape, and its four numbers of SIZE."""
        state = self._state
        match shape:
            case Sphere():
                return state.SPHERE, np.array((shape.radius, 0.0, 0.0, 0.0))
            case Plane():
                return state.PLANE, np.array((*shape.normal, shape.offset))
            case Capsule():
                return state.CAPSULE, np.array((shape.radius, shape.radius, 0.5 * shape.length + shape.radius, 0.0))
            case Cylinder():
                return state.CYLINDER, np.array((shape.radius, shape.radius, 0.5 * shape.length, 0.0))
            case ConvexHull():
                return state.HULL, np.array((*np.abs(shape.points).max(axis=0), self._store.hulls.add(shape)))
        assert isinstance(shape, Box)
        x, y, z = shape.size
        return state.BOX, np.array((0.5 * x, 0.5 * y, 0.5 * z, 0.0))

    def _checked_mobility(self, shape: Any, static: Any, kinematic: Any) -> bool:
        """Whether the body is not dynamic."""
        if not isinstance(shape, Shape):
            raise InvalidInputError(f"shape must be a stiction shape such as Box((1, 1, 1)), got {shape!r}.")
        for name, value in (("static", static), ("kinematic", kinematic)):
            if not isinstance(value, (bool, np.bool_)):
                raise InvalidInputError(f"{name} must be True or False, got {value!r}.")
        if static and kinematic:
            raise InvalidInputError("static and kinematic must not both be True.")
        if isinstance(shape, Plane) and not (static or kinematic):
            raise InvalidInputError("a Plane must be static=True or kinematic=True, for it has no finite mass.")
        if not isinstance(shape, (Sphere, Box, Plane, Capsule, Cylinder, ConvexHull)):
            raise InvalidInputError(f"shape must be one of stiction's shapes, got a {type(shape).__name__}.")
        return bool(static or kinematic)

    def _checked_mass(
        self, shape: Shape, fixed: bool, mass: float | None, density: float | None, inertia: ArrayLike | None
    ) -> dict[int, Any]:
        """Columns of mass and inertia."""
        state = self._state
        if mass is not None and density is not None:
            raise InvalidInputError(f"mass and density must not both be given, got {mass!r} kg and {density!r} kg/m^3.")
        if mass is not None:
            mass = checks.mass("mass", mass)
        if density is not None:
            density = checks.positive("density", density, "kg/m^3")
        if fixed:
            if inertia is not None:
                raise InvalidInputError("inertia must be left out for a body that is not dynamic.")
            return {}
        properties = shape.mass_properties
        if mass is not None:
            density = mass / properties.volume
        density = DEFAULT_DENSITY if density is None else density
        mass = checks.mass("mass (density times volume)", density * properties.volume) if mass is None else mass
        tensor = properties.inertia * density if inertia is None else checked_inertia("inertia", inertia)
        return {
            state.MASS: mass,
            state.INVERSE_MASS: 1.0 / mass,
            state.CENTER: properties.center_of_mass,
            state.INERTIA: tensor,
            state.INVERSE_INERTIA: np.linalg.inv(tensor),
        }

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies in order of creation."""
        return tuple(self._bodies)

    def __len__(self) -> int:
        return len(self._bodies)

    def __iter__(self) -> Iterator[Body]:
        return iter(self._bodies)

    def __getitem__(self, name: str) -> Body:
        """The body of that name."""
        if not isinstance(name, str) or name not in self._by_name:
            raise InvalidInputError(f"no body is called {name!r}{checks.nearest(name, self._by_name)}.")
        return self._by_name[name]

    def __repr__(self) -> str:
        return f"<World of {len(self)} bodies at t = {self.time:g} s, solver {self.solver!r}>"

    # --- arrays -------------------------------------------------------------------------------------------------------

    @property
    def positions(self) -> Array:
        """(n, 3) m, of all bodies in order of creation. A view: writing moves bodies. Ask again after adding one."""
        self._store.watch()
        return self._store.column(self._state.POSITION, 3)

    @property
    def orientations(self) -> Array:
        """(n, 4) unit quaternions (w, x, y, z), a view."""
        self._store.watch()
        return self._store.column(self._state.ORIENTATION, 4)

    @property
    def velocities(self) -> Array:
        """(n, 3) m/s of the centres of mass, a view."""
        self._store.watch()
        return self._store.column(self._state.V, 3)

    @property
    def angular_velocities(self) -> Array:
        """(n, 3) rad/s in world axes, a view."""
        self._store.watch()
        return self._store.column(self._state.W, 3)

    # --- time ---------------------------------------------------------------------------------------------------------

    @property
    def gravity(self) -> Array:
        """(3,) m/s^2."""
        return self._gravity.copy()

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        self._gravity = checks.vector("gravity", value)
        self._settings = self._make_settings()

    @property
    def solver(self) -> str:
        """Name of the solver."""
        return self._solver

    @property
    def micro_literal(self) -> bool:
        """Whether friction is that of the slides word for word."""
        return self._micro_literal

    @property
    def materials(self) -> MaterialTable:
        """The table of material pairs; changes of it take effect with the next step."""
        return self._materials

    @property
    def dt(self) -> float:
        """Time step, s."""
        return self._dt

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self._store.steps

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._store.steps * self._dt

    def step(self, n: int = 1) -> None:
        """Take n steps in one compiled call.

        Applied forces act in the first of them.

        Raises:
            InvalidInputError: n is not a whole number, 1 or more.
            SimulationError: a body's state is no longer finite; the world is back at its last finite state.
        """
        steps = n if type(n) is int and n > 0 else checks.integer("n", n, minimum=1)
        store = self._store
        failure = store.step(steps, self._settings, self._pair_table())
        if failure is not None:
            body = self._bodies[failure.body]
            last = {k: getattr(body, k) for k in ("position", "orientation", "velocity", "angular_velocity")}
            raise SimulationError(
                f"step {failure.step + 1}: the state of body {body.name!r} is no longer finite; "
                f"its last finite position was {last['position']} m, its velocity {last['velocity']} m/s.",
                step=failure.step + 1,
                body=body.name,
                state=last,
            )
        if not self._warned and store.report[:, self._state.LIMITS].any():
            self._warn_of_limit()

    def run(self, seconds: float) -> None:
        """Take as many steps as come nearest to that time, at least one."""
        wanted = checks.positive("seconds", seconds, "s") / self._dt
        if wanted > MOST_STEPS:
            raise InvalidInputError(f"seconds must be {MOST_STEPS * self._dt:g} s or less, got {seconds!r}.")
        self.step(max(1, round(wanted)))

    # --- what happened ------------------------------------------------------------------------------------------------

    def contacts(self, body: Body | None = None) -> NDArray[Any]:
        """Contact points of the last step, one row each (see :data:`stiction.contacts.CONTACT_DTYPE`), a copy.

        Args:
            body: only those of this body.
        """
        if body is not None and (not isinstance(body, Body) or body._world is not self):
            raise InvalidInputError(f"body must be a body of this world, got {body!r}.")
        state, store = self._state, self._store
        store.collect_contacts()
        numbers, tags = store.contacts[: store.m], store.tags[: store.m]
        keep = (numbers[:, state.TOTAL] > 0.0) | (numbers[:, state.SEPARATION] <= 1e-5)
        if body is not None:
            keep &= (tags[:, state.BODY_A] == body.index) | (tags[:, state.BODY_B] == body.index)
        numbers, tags = numbers[keep], tags[keep]
        rows = np.zeros(len(numbers), CONTACT_DTYPE)
        rows["body_a"], rows["body_b"] = tags[:, state.BODY_A], tags[:, state.BODY_B]
        rows["point"] = numbers[:, state.POINT : state.POINT + 3]
        rows["normal"] = numbers[:, state.NORMAL : state.NORMAL + 3]
        rows["separation"] = numbers[:, state.SEPARATION]
        rows["normal_impulse"] = numbers[:, state.TOTAL]
        rows["friction_impulse"] = numbers[:, state.TOTAL_FRICTION : state.TOTAL_FRICTION + 3]
        rows["sticking"] = (numbers[:, state.TOTAL] > 0.0) & (tags[:, state.STATUS] & state.SLIDING != state.SLIDING)
        return rows

    def energy(self) -> Energy:
        """The ledger of energy, J."""
        state, ledger = self._state, self._store.ledger
        kinetic, potential = self._store.energy(self._gravity)
        initial, edits = float(ledger[state.INITIAL]), float(ledger[state.EDITS])
        if math.isnan(initial):
            initial = kinetic + potential
        else:
            edits += kinetic + potential - float(ledger[state.MECHANICAL])
        sums = (state.FRICTION, state.ROLLING_LOSS, state.IMPACTS, state.WORK)
        friction, rolling, impacts, work = (float(ledger[k]) for k in sums)
        numerical = float(ledger[state.NUMERICAL])
        return Energy(kinetic, potential, friction, rolling, impacts, work, edits, numerical, initial)

    def report(self) -> SolverReport:
        """How much the solver worked, and whether it hit a limit."""
        report = self._store.report
        visits, hits = (tuple(int(x) for x in report[:, k]) for k in (self._state.VISITS, self._state.LIMITS))
        worst = tuple(float(x) for x in report[:, self._state.WORST])
        return SolverReport(visits, hits, worst)  # type: ignore[arg-type]  # three rows by construction

    def state_hash(self) -> str:
        """A hash of time, positions, orientations and velocities of all bodies, bit for bit."""
        digest = hashlib.blake2b(str(self.steps).encode(), digest_size=16)
        for array in (self.positions, self.orientations, self.velocities, self.angular_velocities):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    # --- inside -------------------------------------------------------------------------------------------------------

    def _make_settings(self) -> Any:
        x, y, z = (float(g) for g in self._gravity)
        return self._state.Settings(
            x, y, z, self._dt, self._iterations, self._threshold, self.micro_literal, self._substeps, self._sleeping
        )

    def _pair_table(self) -> Array:
        """The coefficients of the materials in use, (k, k, 5), made anew only when something changed."""
        key = (id(self.materials), self.materials.version, len(self._material_names))
        if key != self._table_of:
            self._table = self.materials.to_array(self._material_names)
            self._table_of = key
        return self._table

    def _material_row(self, material: str) -> int:
        if material not in self._material_names:
            self._material_names.append(material)
        return self._material_names.index(material)

    def _warn_of_limit(self) -> None:
        self._warned = True
        report = self.report()
        stages = ("penetrations", "impacts", "resting contact")
        hit = ", ".join(
            f"{stage} ({error:.2g} {unit} left)"
            for stage, count, error, unit in zip(
                stages, report.limit_hits, report.worst, ("m", "m/s", "m/s"), strict=True
            )
            if count
        )
        warnings.warn(
            f"step {self.steps}: the limit of {self._iterations} iterations a contact was hit in {hit}; "
            f"world.report() counts how often.",
            IterationLimitWarning,
            stacklevel=3,
        )

    def _read(self, index: int, column: str, width: int) -> Array:
        start: int = getattr(self._state, column)
        return self._store.bodies[index, start : start + width].copy()

    def _write(self, index: int, column: str, value: Array) -> None:
        start: int = getattr(self._state, column)
        self._store.bodies[index, start : start + len(value)] = value
        self._store.edited(index)

    def _is_asleep(self, index: int) -> bool:
        return bool(self._store.kinds[index, self._state.ASLEEP])

    def _mobility(self, index: int) -> str:
        return MOBILITIES[self._store.kinds[index, self._state.MOBILITY]]

    def _set_mass(self, index: int, mass: float, inertia: Array) -> None:
        self._write(index, "MASS", np.array([mass]))
        self._write(index, "INVERSE_MASS", np.array([1.0 / mass]))
        self._write(index, "INERTIA", inertia.ravel())
        self._write(index, "INVERSE_INERTIA", np.linalg.inv(inertia).ravel().astype(np.float64))

    def _rotation(self, index: int) -> Array:
        from stiction.core.vec import Quat, rotation

        return np.array(rotation(Quat(*self._read(index, "ORIENTATION", 4)))).reshape(3, 3)

    def _world_inverse_inertia(self, index: int) -> Array:
        R = self._rotation(index)
        return np.asarray(R @ self._read(index, "INVERSE_INERTIA", 9).reshape(3, 3) @ R.T)

    def _kinetic_energy(self, index: int) -> float:
        if self._mobility(index) != "dynamic":
            return 0.0
        v = self._read(index, "V", 3)
        w = self._rotation(index).T @ self._read(index, "W", 3)
        mass = self._read(index, "MASS", 1)[0]
        return float(0.5 * mass * v @ v + 0.5 * w @ self._read(index, "INERTIA", 9).reshape(3, 3) @ w)
