"""What a world tells of itself: energy, how much its solver worked, and how well. Part of :class:`stiction.World`."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction import checks
from stiction.body import Body
from stiction.contacts import contact_rows
from stiction.errors import IterationLimitWarning, NotYetError
from stiction.hashing import STATE_WIDTH, state_hash
from stiction.reports import Energy, SolverReport

if TYPE_CHECKING:
    from stiction.journal import Journal
    from stiction.problems import ContactProblem
    from stiction.store import Store

Array = NDArray[np.float64]


def balance(state: Any, ledger: Array, kinetic: float, potential: float) -> Energy:
    """The ledger of energy of a world, J.

    Args:
        state: the module :mod:`stiction.core.state`, which names the columns.
        ledger: the engine's.
        kinetic: J, now. potential: J, now.
    """
    entries = ledger.tolist()
    initial, edits = entries[state.INITIAL], entries[state.EDITS]
    if math.isnan(initial):
        initial = kinetic + potential
    else:
        edits += kinetic + potential - entries[state.MECHANICAL]
    friction, rolling, impacts = entries[state.FRICTION], entries[state.ROLLING_LOSS], entries[state.IMPACTS]
    work, numerical = entries[state.WORK], entries[state.NUMERICAL]
    return Energy(kinetic, potential, friction, rolling, impacts, work, edits, numerical, initial)


class Accounts:
    """The accounts of a world: nothing here changes it but :meth:`profile`, which takes steps."""

    _store: Store
    _state: Any
    _settings: Any
    _solver: str
    _gravity: Array
    _iterations: int
    _warned: bool
    _journal: Journal | None

    if TYPE_CHECKING:

        def step(self, n: int = 1) -> None:
            """Take steps."""

        def _own(self, name: str, body: Any) -> None: ...

        def _pair_table(self) -> Array: ...

    def contacts(self, body: Body | None = None) -> NDArray[Any]:
        """Contact points of the last step, one row each (see :data:`stiction.contacts.CONTACT_DTYPE`), a copy.

        Args:
            body: only those of this body.
        """
        if body is not None:
            self._own("body", body)
        state, (numbers, tags) = self._state, self._raw_contacts()
        if body is not None:
            mine = (tags[:, state.BODY_A] == body.index) | (tags[:, state.BODY_B] == body.index)
            numbers, tags = numbers[mine], tags[mine]
        return contact_rows(numbers, tags)

    def _raw_contacts(self) -> tuple[Array, NDArray[np.int64]]:
        """Views of the engine's rows of contact points, for :func:`contact_rows`; valid until the next step."""
        store = self._store
        store.collect_contacts()
        return store.contacts[: store.m], store.tags[: store.m]

    def energy(self) -> Energy:
        """The ledger of energy, J."""
        return balance(self._state, self._store.ledger, *self._store.energy(self._gravity))

    def _note_friction(self, index: int, lost: float) -> None:
        """Enter into the ledger what friction takes (J) from body ``index`` by forces that are applied from outside.

        They are entered as work when the step is taken; what was friction among them is given back here.
        """
        if self._journal is not None:
            self._journal.entered_friction(index, lost)
        state = self._state
        self._store.ledger[state.FRICTION] += lost
        self._store.ledger[state.WORK] += lost
        self._store.bodies[index, state.FRICTION_WORK] += lost

    def report(self) -> SolverReport:
        """How much the solver worked, and whether it hit a limit."""
        report = self._store.report
        visits, hits = (tuple(int(x) for x in report[:, k]) for k in (self._state.VISITS, self._state.LIMITS))
        worst = tuple(float(x) for x in report[:, self._state.WORST])
        return SolverReport(visits, hits, worst)  # type: ignore[arg-type]  # three rows by construction

    def residual(self) -> float:
        """By how much the last step misses the laws of contact, m/s: 0 for one that is solved.

        It is the largest speed, over all contacts, by which velocities differ from what Signorini's condition and
        Coulomb's law ask for given the impulses of the last substep: a point that closes, or that parts under load, or
        slip that friction would still take away. ``exact`` brings it below its tolerance; in ``soft`` contacts are
        springs on purpose, and it says how far that is from a rigid one.

        Raises:
            NotYetError: in a world of ``micro``, whose :meth:`report` has the largest error.
        """
        if self._solver == "micro":
            raise NotYetError("residual is not there yet with solver 'micro'; report() has its largest error.")
        return self._store.miss(self._settings)

    def residual_log(self) -> Array:
        """The residuals on the way to a solution in the last substep of ``exact``, m/s: after the first pass, and then
        after every fifth.

        Raises:
            NotYetError: with another solver.
        """
        if self._solver != "exact":
            raise NotYetError(f"residual_log is not there with solver {self._solver!r}; solver 'exact' has it.")
        return self._store.miss_log()

    def contact_problem(self) -> ContactProblem:
        """The contact problem that the next step has to solve, to be solved or written elsewhere.

        Contacts are the points that the step will find, each with the static coefficient of its pair, or with the
        dynamic one where the step will have it slide. A gap that is open may close in the step; a closing speed above
        the restitution threshold bounces; a penetration is pushed out in ``exact`` as there, and left alone in
        ``soft``. Rolling and torsional resistance are not part of it. The world is as before; a copy of it takes the
        step. Its mass matrix and contact matrix are in ``global_form``, points, frames and the world's own impulses in
        ``places``.

        >>> import stiction as st
        >>> world = st.World()
        >>> floor = world.add(st.Plane(), static=True)
        >>> crate = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5))
        >>> world.contact_problem().contacts
        4

        Raises:
            InvalidInputError: nothing touches.
            NotYetError: in a world of ``micro``, or where pairs have laws, grain or adhesion.
        """
        if self._solver == "micro":
            raise NotYetError("contact_problem is not there yet with solver 'micro'; 'soft' and 'exact' have it.")
        from stiction.soft_store import SoftStore
        from stiction.step_problem import problem_of_next_step

        assert isinstance(self._store, SoftStore)
        title = f"{self._solver}, step {self._store.steps + 1}"
        return problem_of_next_step(self._store, self._settings, self._pair_table(), title)

    def profile(self, steps: int) -> dict[str, float]:
        """Take steps, and tell how long each stage of them took, in ms a step.

        Of several steps the first one is not counted: it may have to compile.

        Raises:
            InvalidInputError: steps is not a whole number, 1 or more.
            NotYetError: in a world of ``micro``.
        """
        count = checks.integer("steps", steps, minimum=1)
        if self._solver == "micro":
            raise NotYetError(f"profile is not there yet with solver {self._solver!r}; solver 'soft' has it.")
        if count > 1:
            self.step()
            count -= 1
        self._store.reset_profile()
        self.step(count)
        return {stage: 1e3 * seconds / count for stage, seconds in self._store.profile().items()}

    def state_hash(self) -> str:
        """A hash of time, positions, orientations and velocities of all bodies, bit for bit."""
        return state_hash(self._store.steps, self._store.column(self._state.POSITION, STATE_WIDTH))

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
        unit = "passes a substep" if self._solver == "exact" else "iterations a contact"
        warnings.warn(
            f"step {self._store.steps}: the limit of {self._iterations} {unit} was hit in {hit}; "
            f"world.report() counts how often.",
            IterationLimitWarning,
            stacklevel=3,
        )
