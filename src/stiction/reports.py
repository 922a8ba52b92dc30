"""What a world tells about itself: its ledger of energy, and how hard its solver worked."""

from __future__ import annotations

from typing import NamedTuple


class Energy(NamedTuple):
    """The ledger of a world, J. It closes: ``kinetic + potential == initial + work + edits + numerical - dissipated``.

    Attributes:
        kinetic, potential: of all dynamic bodies now; heights are measured from the origin along gravity.
        friction, rolling, impacts: what sliding friction, rolling and torsional resistance, and the normal part of
            collisions have dissipated so far. With ``soft``, impacts hold what the springs of contacts keep or give
            back, too, and so may fall and lie a little below zero: see :attr:`given_back`.
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
    def given_back(self) -> float:
        """What soft contacts have given back beyond what impacts took, J: ``-impacts`` where that is below zero by more
        than rounding, and 0 otherwise.

        A penetration is a spring. What sinks in at an impact, or because its load grows, comes out later, and the
        account of impacts does not know beforehand how much of a loss will be returned.
        """
        rounding = 1e-9 * (abs(self.kinetic) + abs(self.potential) + abs(self.initial) + abs(self.work))
        return -self.impacts if self.impacts < -rounding else 0.0

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
