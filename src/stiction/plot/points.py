"""The contact points of a run with what belongs to each: its frame, its coefficients, and axes in its plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction.record.frames import Frames

Array = NDArray[np.float64]
Pairs = Callable[[str, str], Any]
"""Gives for the names of two materials what has ``static`` and ``dynamic``, their coefficients."""


@dataclass(frozen=True)
class Points:
    """r contact points.

    Attributes:
        rows: of ``CONTACT_DTYPE``.
        frame: (r,) the frame of each.
        coefficients: (r, 2) static and dynamic.
    """

    rows: NDArray[Any]
    frame: NDArray[np.int64]
    coefficients: Array

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: Any) -> Points:
        """Some of them, as numpy chooses rows."""
        return Points(self.rows[which], self.frame[which], self.coefficients[which])

    @property
    def tangential(self) -> Array:
        """(r, 2) friction impulses in N s along two axes in the plane of each contact.

        The first axis is the world's x laid into that plane (its y where x is nearly the normal), the second one is at
        right angles to it, so that contacts on a level floor are seen from above.
        """
        n = self.rows["normal"]
        towards = np.where(np.abs(n[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        first = towards - n * np.sum(n * towards, axis=1, keepdims=True)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(n, first)
        friction = self.rows["friction_impulse"]
        return np.stack([np.sum(friction * first, axis=1), np.sum(friction * second, axis=1)], axis=1)


def contact_points(frames: Frames, pairs: Pairs, bodies: Sequence[int] | None = None) -> Points:
    """The contact points of all frames.

    Args:
        frames: the run.
        pairs: gives for the names of two materials what has ``static`` and ``dynamic``, their coefficients.
        bodies: numbers of bodies; only contacts of one of them are kept. All of them if left out.
    """
    rows = frames.contacts
    frame = np.repeat(np.arange(len(frames)), np.diff(frames.contact_offsets))
    if bodies is not None:
        mine = np.isin(rows["body_a"], bodies) | np.isin(rows["body_b"], bodies)
        rows, frame = rows[mine], frame[mine]
    materials = [body.material for body in frames.bodies]
    kinds = sorted(set(materials))
    number = np.array([kinds.index(material) for material in materials], np.int64)
    a, b = number[rows["body_a"]], number[rows["body_b"]]
    table = np.zeros((len(kinds), len(kinds), 2))
    for i, j in np.unique(np.stack([a, b], axis=1), axis=0).tolist():
        pair = pairs(kinds[i], kinds[j])
        table[i, j] = float(pair.static), float(pair.dynamic)
    return Points(rows, frame, table[a, b])


def faces(points: Points) -> Points:
    """The points at which two bodies touch in a frame, taken together as one face.

    Its impulses are the sums of theirs, its normal and point the means weighted by load; it sticks if none of its
    points slides. The solver limits the friction of a face as a whole, and shares it out to the points afterwards.
    Points without load are left out.
    """
    rows = points.rows
    keep = rows["normal_impulse"] > 0.0
    rows, frame, coefficients = rows[keep], points.frame[keep], points.coefficients[keep]
    keys = np.stack([frame, rows["body_a"], rows["body_b"]], axis=1)
    unique, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    number = number.ravel()
    made = rows[first]
    load = rows["normal_impulse"]
    made["normal_impulse"] = np.bincount(number, load, len(unique))
    for name, weight in (("friction_impulse", np.ones_like(load)), ("normal", load), ("point", load)):
        total = np.zeros((len(unique), 3))
        np.add.at(total, number, weight[:, None] * rows[name])
        made[name] = total
    made["point"] /= made["normal_impulse"][:, None]
    # normals of a face agree; where two bodies touch all round, as in a hole, they may cancel, and one has to do
    length = np.linalg.norm(made["normal"], axis=1, keepdims=True)
    agree = length > 1e-3 * made["normal_impulse"][:, None]
    made["normal"] = np.where(agree, made["normal"] / np.where(agree, length, 1.0), rows["normal"][first])
    made["separation"] = np.nan
    made["sticking"] = np.bincount(number, ~rows["sticking"], len(unique)) == 0
    return Points(made, frame[first], coefficients[first])


def loaded(points: Points, least: float = 1e-3) -> Points:
    """Those that carry at least that share of the largest usual load: what only brushes tells nothing of friction."""
    load = points.rows["normal_impulse"]
    if not len(load):
        return points
    return points[load > least * float(np.percentile(load, 99))]
