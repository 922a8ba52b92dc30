"""Contacts that begin and end: what a world records while ``record_events`` is on."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from stiction.journal import Step
    from stiction.store import StepFailure, Store

Integers = NDArray[np.int64]

EVENT_DTYPE = np.dtype(
    [
        ("body_a", np.int32),
        ("body_b", np.int32),
        ("kind", np.int8),
        ("step", np.int64),
        ("normal_impulse", np.float64),
        ("sensor", np.bool_),
    ]
)
"""A row an event: indices of the bodies (a < b); an :class:`EventKind`; the step in which it happened, counted from 1
within the last call of ``step``; the normal impulse of that step (N s; 0 where contact ends, and for sensors); whether
one of the two is a sensor."""

TOUCHING_DTYPE = np.dtype([("body_a", np.int32), ("body_b", np.int32), ("sensor", np.bool_)])
"""A row a pair of bodies: indices (a < b), and whether one of the two is a sensor."""


class EventKind(IntEnum):
    """What happened to a pair of bodies: they began to touch, or ended."""

    BEGIN = 1
    END = 2


class ContactEvents(NamedTuple):
    """What happened in the last call of ``step``.

    Attributes:
        changes: a row for each begin and end, by step, then ends before begins, then by bodies: body_a, body_b, kind,
            step, normal_impulse, sensor.
        touching: a row for each pair that touches at the end, by bodies: body_a, body_b, sensor.
    """

    changes: NDArray[Any]
    touching: NDArray[Any]


class EventLog:
    """The pairs that touch, and what changed since the last call of ``step`` began.

    A pair is named by one whole number, the lower body in its upper half, so that names sort as pairs do. Costs a look
    at all pairs and a call of a kernel a step.
    """

    def __init__(self, store: Store) -> None:
        self._names, _ = store.touching_pairs()
        self._parts: list[NDArray[Any]] = []

    def follow(self, store: Store, take: Step, steps: int, settings: Any, table: Any) -> StepFailure | None:
        """Take steps one by one with ``take``, and note what begins and ends in each."""
        self._parts.clear()
        for step in range(1, steps + 1):
            failure = take(1, settings, table)
            if failure is not None:
                return failure
            self._note(store, step)
        return None

    def _note(self, store: Store, step: int) -> None:
        names, impulses = store.touching_pairs()
        if not np.array_equal(names, self._names):
            ended = np.setdiff1d(self._names, names, assume_unique=True)
            began = np.setdiff1d(names, self._names, assume_unique=True)
            at = np.searchsorted(names, began)
            for kind, changed, impulse in ((EventKind.END, ended, 0.0), (EventKind.BEGIN, began, impulses[at])):
                rows = np.zeros(len(changed), EVENT_DTYPE)
                rows["body_a"], rows["body_b"] = _bodies(changed)
                rows["kind"], rows["step"], rows["normal_impulse"] = kind, step, impulse
                self._parts.append(rows)
        self._names = names

    def renumber(self, new: Integers) -> None:
        """Bodies were removed: ``new`` (n,) has the new number of each, -1 for those that are gone."""
        a, b = (new[side] for side in _bodies(self._names))
        stay = (a >= 0) & (b >= 0)
        self._names = name_pairs(a[stay], b[stay])
        for k, rows in enumerate(self._parts):
            a, b = new[rows["body_a"]], new[rows["body_b"]]
            stay = (a >= 0) & (b >= 0)
            kept = rows[stay]
            kept["body_a"], kept["body_b"] = a[stay], b[stay]
            self._parts[k] = kept

    def events(self, sensors: NDArray[np.bool_]) -> ContactEvents:
        """As the world gives them; ``sensors`` (n,) says which bodies are sensors."""
        changes = np.concatenate([np.zeros(0, EVENT_DTYPE), *self._parts])
        touching = np.zeros(len(self._names), TOUCHING_DTYPE)
        touching["body_a"], touching["body_b"] = _bodies(self._names)
        for rows in (changes, touching):
            rows["sensor"] = sensors[rows["body_a"]] | sensors[rows["body_b"]]
        return ContactEvents(changes, touching)


def name_pairs(a: Integers, b: Integers) -> Integers:
    """One number for each pair a < b."""
    return (a << 32) | b


def _bodies(names: Integers) -> tuple[Integers, Integers]:
    return names >> 32, names & 0xFFFFFFFF
