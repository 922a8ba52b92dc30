"""Coefficients of bodies from those of pairs, for engines that have no table of pairs.

Most engines give each body one coefficient and make that of a pair from the two by a rule. Where a scene names pairs,
bodies need coefficients from which the rule makes what the scene has asked for. A mean is linear in them, a product and
a geometric mean are so in their logarithms; for the largest of two, the smallest that a surface needs will do.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from stiction.bench.scene import BenchScene
from stiction.errors import InvalidInputError

Rule = Literal["mean", "geometric mean", "product", "maximum"]

RULES: dict[Rule, str] = {
    "mean": "(a + b) / 2",
    "geometric mean": "sqrt(a b)",
    "product": "a b",
    "maximum": "max(a, b)",
}


def combine(rule: Rule, a: float, b: float) -> float:
    """The coefficient of a pair."""
    if rule == "mean":
        return 0.5 * (a + b)
    if rule == "maximum":
        return max(a, b)
    return a * b if rule == "product" else math.sqrt(a * b)


def of_bodies(scene: BenchScene, rule: Rule) -> list[float]:
    """One coefficient for each body, so that the rule gives every pair of surfaces that the scene names its own.

    Raises:
        InvalidInputError: there are none that would.
    """
    if not scene.pairs:
        return [own_of(scene.friction, rule)] * len(scene.bodies)
    names = sorted({name for a, b, _ in scene.pairs for name in (a, b)})
    wanted = np.array([mu for _, _, mu in scene.pairs])
    if rule == "maximum":
        values = {name: min(mu for a, b, mu in scene.pairs if name in (a, b)) for name in names}
    else:
        rows = np.zeros((len(scene.pairs), len(names)))
        for k, (a, b, _) in enumerate(scene.pairs):
            for name in (a, b):
                rows[k, names.index(name)] += 1.0 if rule == "product" else 0.5
        wanted = wanted if rule == "mean" else np.log(wanted)
        alike = np.full(len(names), wanted.mean() / (2.0 if rule == "product" else 1.0))
        # of all that would do, those nearest to alike: none is below zero without need
        found = alike + np.linalg.lstsq(rows, wanted - rows @ alike, rcond=None)[0]
        values = dict(zip(names, found if rule == "mean" else np.exp(found), strict=True))
    for a, b, mu in scene.pairs:
        if min(values[a], values[b]) < 0.0 or not math.isclose(combine(rule, values[a], values[b]), mu, rel_tol=1e-9):
            raise InvalidInputError(f"no coefficients of bodies make {mu:g} for {a} and {b} by the rule {rule!r}.")
    rest = own_of(scene.friction, rule)
    return [float(values.get(body.surface, rest)) for body in scene.bodies]


def own_of(coefficient: float, rule: Rule) -> float:
    """What each of two alike bodies has if their pair has ``coefficient``."""
    return math.sqrt(coefficient) if rule == "product" else coefficient
