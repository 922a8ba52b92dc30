"""World: bodies, materials and time."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import checks
from stiction.accounts import Accounts
from stiction.body import Body
from stiction.body_rows import check_mobility, code_and_size, mass_columns
from stiction.errors import InvalidInputError, NotYetError, SimulationError
from stiction.events import ContactEvents, EventLog
from stiction.journal import Journaled
from stiction.materials import MaterialTable
from stiction.queries import Queries
from stiction.shapes import Shape

if TYPE_CHECKING:
    from stiction.view.server import Viewer

Array = NDArray[np.float64]

SOLVERS = ("micro", "soft", "exact")
DEFAULT_SOLVER = "soft"
SUBSTEPS = {"micro": 1, "soft": 8, "exact": 4}
"""Parts of a step."""
ITERATIONS = {"micro": 100, "soft": 100, "exact": 1000}
TOLERANCE = 1e-8
"""m/s, of the exact solver."""
MOST_STEPS = 10**12
"""Steps of one run at most; more would take years."""
MOST_THREADS = 256
NO_LAWS = "laws, grain and adhesion of a pair are not there yet with solver 'micro'; solver 'soft' has them."
PUSHES = {"FORCE", "TORQUE"}
"""Columns that say nothing about where a body is: what touches it need not be looked at again."""
MOBILITIES = ("static", "kinematic", "dynamic")


class World(Queries, Accounts, Journaled):
    """A world of rigid bodies.

    Args:
        gravity: (3,), m/s^2.
        dt: time step, s.
        solver: ``"soft"``, the default: fast, with memory of contacts from step to step; ``"micro"``, the lecture's;
            ``"exact"``, rigid contacts and both coefficients solved to a tolerance, for reference and small worlds.
        substeps: parts of a step: 8 in ``soft``, 4 in ``exact``; ``micro`` has no more than 1.
        iterations: how often ``micro`` may resolve a contact in a stage of a step, on average, before the limit is
            reported, 100 if left out; how many passes over all contacts ``exact`` may make in a substep, 1000.
        precision: of contacts in ``soft``: ``"single"``, the default (positions are in double precision always), or
            ``"double"``; the others have ``"double"``.
        materials: the table of pairs; :meth:`MaterialTable.default` if left out. The table is used, not copied.
        micro_literal: use the slides' friction word for word instead of Coulomb's law, to see the difference.
        restitution_threshold: closing speeds below it are resting contact and do not bounce, m/s.
        sleeping: whether ``soft`` leaves islands of bodies alone while they are truly at rest.
        threads: how many threads ``soft`` works with; every number of them gives the same bits. More than one pays for
            worlds of several hundred contacts and more, where as many processors have nothing else to do.
        tolerance: by how much a contact may miss its laws in ``exact``, m/s; 1e-8 if left out.

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
        iterations: int | None = None,
        precision: str | None = None,
        materials: MaterialTable | None = None,
        *,
        micro_literal: bool = False,
        restitution_threshold: float = 0.25,
        sleeping: bool = True,
        threads: int = 1,
        tolerance: float | None = None,
    ) -> None:
        self._gravity = checks.vector("gravity", gravity)
        self._dt = checks.positive("dt", dt, "s")
        self._solver = DEFAULT_SOLVER if solver is None else checks.one_of("solver", solver, SOLVERS)
        soft, micro = self._solver == "soft", self._solver == "micro"
        default_substeps = SUBSTEPS[self._solver]
        self._substeps = default_substeps if substeps is None else self._checked_substeps(self._solver, substeps)
        default = "single" if soft else "double"
        precision = default if precision is None else checks.one_of("precision", precision, ("double", "single"))
        if not soft and precision != "double":
            raise NotYetError(f"precision 'single' is not there yet with solver {self._solver!r}; it has 'double'.")
        if materials is not None and not isinstance(materials, MaterialTable):
            raise InvalidInputError(f"materials must be a MaterialTable, got {type(materials).__name__}.")
        if not isinstance(micro_literal, bool):
            raise InvalidInputError(f"micro_literal must be True or False, got {micro_literal!r}.")
        if micro_literal and not micro:
            raise InvalidInputError("micro_literal must be left out unless solver is 'micro'.")
        if not isinstance(sleeping, bool):
            raise InvalidInputError(f"sleeping must be True or False, got {sleeping!r}.")
        self._sleeping = sleeping
        threads = checks.integer("threads", threads, minimum=1)
        if threads > MOST_THREADS:
            raise InvalidInputError(f"threads must be {MOST_THREADS} or less, got {threads!r}.")
        if not soft and threads != 1:
            raise NotYetError(f"threads must be 1 with solver {self._solver!r}, got {threads!r}.")
        if tolerance is not None and self._solver != "exact":
            raise InvalidInputError("tolerance must be left out unless solver is 'exact'.")
        self._tolerance = TOLERANCE if tolerance is None else checks.positive("tolerance", tolerance, "m/s")
        self._iterations = (
            ITERATIONS[self._solver] if iterations is None else checks.integer("iterations", iterations, minimum=1)
        )
        self._threshold = checks.non_negative("restitution_threshold", restitution_threshold, "m/s")
        self._micro_literal = micro_literal
        self._materials = MaterialTable.default() if materials is None else materials

        from stiction.core import state
        from stiction.store import Store

        self._state = state
        self._store = Store()
        if not micro:
            from stiction.soft_store import SoftStore

            self._store = SoftStore(precision, threads, self._solver == "exact")
        self._bodies: list[Body] = []
        self._by_name: dict[str, Body] = {}
        self._added = 0
        self._events: EventLog | None = None
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
        center_of_mass: ArrayLike | None = None,
        material: str = "default",
        name: str | None = None,
        surface_velocity: ArrayLike | None = None,
        grain: ArrayLike | None = None,
        layer: int = 1,
        mask: int = checks.ALL_LAYERS,
        sensor: bool = False,
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
            center_of_mass: in the shape's frame, (3,), m, for a body that is loaded on one side; with it goes
                ``inertia``, about that point. From the shape if left out.
            material: its name in the world's table.
            name: unique; made from shape and number if left out.
            surface_velocity: of a belt relative to the body, in the shape's axes, (3,), m/s.
            grain: direction of the surface in the shape's axes, (3,), for pairs of materials that have coefficients
                across it besides those along it: the runner of a skate, brushed metal, wood. Where both bodies have
                one, that of the first one counts. None if left out.
            layer: a whole number whose bits are the layers that the body is on. mask: the layers that it meets, -1 for
                all of them. Two bodies meet if each is on a layer that the other one meets.
            sensor: it notices who overlaps it (:meth:`overlaps`, :meth:`contact_events`), and neither pushes nor is
                pushed; a dynamic one falls freely.

        Raises:
            InvalidInputError: a value is not allowed; the world is as before.
            NotYetError: a sensor in a world of ``micro``.
        """
        state = self._state
        fixed = check_mobility(shape, static, kinematic)
        if name is None:
            name = f"{shape.kind} {self._added}"
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
        direction = None if grain is None else checks.unit_vector("grain", grain)
        if direction is not None and self._solver == "micro":
            raise NotYetError("grain is not there yet with solver 'micro'; solver 'soft' has it.")
        row.update(mass_columns(shape, fixed, mass, density, inertia, center_of_mass))
        bits = checks.layers("layer", layer), checks.layers("mask", mask)
        if not isinstance(sensor, bool):
            raise InvalidInputError(f"sensor must be True or False, got {sensor!r}.")
        if sensor and self._solver == "micro":
            raise NotYetError(f"sensors are not there yet with solver {self._solver!r}; solver 'soft' has them.")
        if not isinstance(material, str) or material not in self.materials:
            self.materials.pair(material, material)  # raises, and names the nearest one

        if self._journal is not None:
            self._journal.catch_up()
        code, row[state.SIZE] = code_and_size(shape, self._store.hulls)
        mobility = state.STATIC if static else state.KINEMATIC if kinematic else state.DYNAMIC
        index = self._store.add(row, code, mobility, self._material_row(material))
        self._store.kinds[index, state.LAYER : state.SENSOR + 1] = *bits, sensor
        self._store.sensors += sensor
        if direction is not None:
            self._store.set_grain(index, direction)
        self._added += 1
        body = Body(self, index, name, shape, material)
        self._bodies.append(body)
        self._by_name[name] = body
        if self._journal is not None:
            self._journal.added(body)
        return body

    def remove(self, body: Body | Iterable[Body]) -> None:
        """Take a body out of the world, or many at once, which is faster than one by one.

        The others keep their order, their indices close the gaps, and what rested on it wakes. A removed body can no
        longer be used, and its name is free again. Ask for the world's arrays again afterwards.

        Raises:
            InvalidInputError: it is not in this world, or given twice; the world is as before.
        """
        gone = [body] if isinstance(body, (Body, str)) or not isinstance(body, Iterable) else list(body)
        keep = np.ones(len(self._bodies), dtype=np.bool_)
        for one in gone:
            self._own("body", one)
            if not keep[one.index]:
                raise InvalidInputError(f"body must not hold {one.name!r} twice.")
            keep[one.index] = False
        if not gone:
            return
        if self._journal is not None:
            self._journal.removing([one.index for one in gone])
        new = self._store.remove(keep)
        if self._events is not None:
            self._events.renumber(new)
        for one in gone:
            del self._by_name[one.name]
            one._index = -1
        self._bodies = [one for one in self._bodies if one._index >= 0]
        for index, one in enumerate(self._bodies):
            one._index = index

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
        """(n, 3) m, of all bodies in order of creation. A view: writing moves bodies.

        Ask for it and the arrays below again after adding or removing a body.
        """
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
        gravity = checks.vector("gravity", value)
        if self._journal is not None:
            self._journal.gravity(gravity)
        self._gravity = gravity
        self._settings = self._make_settings()
        self._wake_all()

    @property
    def solver(self) -> str:
        """Name of the solver."""
        return self._solver

    @property
    def substeps(self) -> int:
        """Parts of a step. Setting it takes effect with the next step; not while the world is being recorded."""
        return self._substeps

    @substeps.setter
    def substeps(self, value: int) -> None:
        self._must_not_be_recorded("substeps")
        self._substeps = self._checked_substeps(self._solver, value)
        self._settings = self._make_settings()

    def set_solver(self, solver: str, *, substeps: int | None = None) -> None:
        """Go on with another solver from the state as it is; time, energies, bodies and materials stay.

        The old solver's memory of contacts is gone, limits are the usual ones, bodies are awake. Ask for arrays again.

        Args:
            solver: ``"soft"``, ``"micro"`` or ``"exact"``.
            substeps: parts of a step; the solver's usual number if left out.

        Raises:
            InvalidInputError: a value is not allowed, or the world is being recorded; the world is as before.
            NotYetError: the solver does not have what the world needs (sensors, grain, laws); the world is as before.
        """
        from stiction.solver_change import move

        self._must_not_be_recorded("solver")
        solver = checks.one_of("solver", solver, SOLVERS)
        substeps = SUBSTEPS[solver] if substeps is None else self._checked_substeps(solver, substeps)
        if solver == "micro" and self.materials.to_array(self._material_names).shape[2] > self._state.STATIC_ACROSS:
            raise NotYetError(NO_LAWS)
        self._store = move(self._store, solver, "single" if solver == "soft" else "double")
        self._solver, self._substeps, self._iterations = solver, substeps, ITERATIONS[solver]
        self._micro_literal = False
        self._settings = self._make_settings()
        if self._events is not None:
            self._events = EventLog(self._store)

    @property
    def awake(self) -> NDArray[np.bool_]:
        """(n,) whether each body takes part in the simulation, see :attr:`Body.awake`."""
        kinds = self._store.kinds[: len(self)]
        awake: NDArray[np.bool_] = kinds[:, self._state.MOBILITY] != self._state.STATIC
        awake &= kinds[:, self._state.ASLEEP] == 0
        return awake

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
        settings, table, journal, events = self._settings, self._pair_table(), self._journal, self._events
        if events is not None:
            step = store.step if journal is None else functools.partial(journal.follow, store.step)
            failure = events.follow(store, step, steps, settings, table)
        elif journal is not None:
            failure = journal.follow(store.step, steps, settings, table)
        else:
            failure = store.step(steps, settings, table)
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
        if not self._warned and any(store.report[:, self._state.LIMITS].tolist()):
            self._warn_of_limit()

    def run(self, seconds: float) -> None:
        """Take as many steps as come nearest to that time, at least one."""
        wanted = checks.positive("seconds", seconds, "s") / self._dt
        if wanted > MOST_STEPS:
            raise InvalidInputError(f"seconds must be {MOST_STEPS * self._dt:g} s or less, got {seconds!r}.")
        self.step(max(1, round(wanted)))

    def show(self, *, title: str = "a world", host: str = "127.0.0.1", port: int = 8080) -> Viewer:
        """A live view of this world in the browser; a notebook shows it in its cell.

        It is paused at first: press play, or keep stepping from here and see what becomes of it. While it plays, step
        from here only ``with viewer.lock:``, for the view steps, too. ``viewer.stop()`` ends it.

        Args:
            title: of the view.
            host: address to listen at; others than this one let other machines in.
            port: where to listen; if it is taken, at a free port. ``viewer.url`` tells.

        Raises:
            InvalidInputError: the host is no address of this machine, or the port no number from 0 to 65535.
        """
        from stiction.view.show import show

        return show(self, title=title, host=host, port=port)

    # --- what happened ------------------------------------------------------------------------------------------------

    @property
    def record_events(self) -> bool:
        """Whether steps record which contacts begin and end, for :meth:`contact_events`.

        False at first, and then it costs nothing. A step that records costs a look at all pairs more.
        """
        return self._events is not None

    @record_events.setter
    def record_events(self, value: bool) -> None:
        if not isinstance(value, bool):
            raise InvalidInputError(f"record_events must be True or False, got {value!r}.")
        if value != self.record_events:
            self._events = EventLog(self._store) if value else None

    def contact_events(self) -> ContactEvents:
        """Which pairs of bodies began and ended to touch in the last call of :meth:`step`, and which touch at its end.

        Two bodies touch in a step in which their contact carries load; a sensor and a body where their shapes overlap
        at its end. Pairs that touched already when recording began give no event for that; removing a body gives none,
        and takes its events along.

        Raises:
            InvalidInputError: ``record_events`` was not set to True.
        """
        if self._events is None:
            raise InvalidInputError(
                "record_events must be set to True before the steps whose contact events are asked for."
            )
        return self._events.events(self._store.kinds[: len(self), self._state.SENSOR] != 0)

    # --- inside -------------------------------------------------------------------------------------------------------

    def _make_settings(self) -> Any:
        x, y, z = (float(g) for g in self._gravity)
        return self._state.Settings(
            x, y, z, self._dt, self._iterations, self._threshold, self.micro_literal, self._substeps, self._sleeping,
            self._tolerance,
        )  # fmt: skip

    def _pair_table(self) -> Array:
        """The coefficients of the materials in use, (k, k, 5), made anew only when something changed."""
        key = (id(self.materials), self.materials.version, len(self._material_names))
        if key != self._table_of:
            table = self.materials.to_array(self._material_names)
            if self._solver == "micro" and table.shape[2] > self._state.STATIC_ACROSS:
                raise NotYetError(NO_LAWS)
            if self._table_of is not None and self._table_of[:2] != key[:2]:
                self._wake_all()
            self._table = table
            self._table_of = key
        return self._table

    def _wake_all(self) -> None:
        for index in range(len(self._bodies)):  # what is at rest may no longer be able to
            self._store.edited(index)

    @staticmethod
    def _checked_substeps(solver: str, value: Any) -> int:
        substeps = checks.integer("substeps", value, minimum=1)
        if solver == "micro" and substeps != 1:
            raise NotYetError(f"substeps must be 1 with solver 'micro', got {value!r}; use a smaller dt.")
        return substeps

    def _material_row(self, material: str) -> int:
        if material not in self._material_names:
            self._material_names.append(material)
        return self._material_names.index(material)

    def _read(self, index: int, column: str, width: int) -> Array:
        start: int = getattr(self._state, column)
        return self._store.bodies[index, start : start + width].copy()

    def _write(self, index: int, column: str, value: Array) -> None:
        if self._journal is not None:
            self._journal.wrote(index, column, value)
        start: int = getattr(self._state, column)
        self._store.bodies[index, start : start + len(value)] = value
        if column not in PUSHES or (self._is_asleep(index) and value.any()):
            self._store.edited(index)

    def _read_kind(self, index: int, column: str) -> int:
        return int(self._store.kinds[index, getattr(self._state, column)])

    def _write_kind(self, index: int, column: str, value: int) -> None:
        if self._journal is not None:
            self._journal.wrote_kind(index, column, value)
        self._store.kinds[index, getattr(self._state, column)] = value
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
