"""Which kernels a step of the soft solver is made of, in which variants, and where its parts are."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from stiction.core import soft_entry, soft_parts
from stiction.core.jit import config
from stiction.core.parts import Variant, address_of, signature
from stiction.core.side_by_side import Task, prepare

COSTS = {
    soft_parts.find: 10.5,
    soft_entry.soft_step: 10.5,
    soft_parts.solve: 9.5,
    soft_parts.impacts: 5.0,
    soft_parts.finish: 4.0,
    soft_parts.pairs: 3.0,
    soft_entry.assist: 0.5,
    soft_entry.dismiss: 0.5,
}
"""How long each took to compile, s, where boxes meet; only the ratios matter."""


@functools.cache
def parts_for(double: bool, team: bool, on: tuple[str, ...]) -> Any:
    """Have all kernels of a step ready; returns what the book says of its parts.

    Args:
        double: precision of the solver.
        team: whether several threads do a step together.
        on: what bodies and pairs need: ``boxes_meet``, ``hulls``, ``bounces``, ``rolls``, ``laws``, ``exact``.

    """
    variant = Variant(double, team, on)
    parts = _parts(variant)
    prepare_steps(variant)
    if config.DISABLE_JIT:
        return [address_of(part, variant) for part in parts]
    page = np.zeros(soft_parts.IMPACTS_PART + 1, np.int64)
    page[: len(parts)] = [address_of(part, variant) for part in parts]
    return page


def prepare_steps(*variants: Variant) -> None:
    """Have the kernels of the steps of several kinds of world ready."""
    if config.DISABLE_JIT:
        return
    tasks = {}
    for variant in variants:
        kernels = [soft_entry.soft_step, *_parts(variant)]
        if variant.team:
            kernels += [soft_entry.assist, soft_entry.dismiss]
        for kernel in kernels:
            tasks[kernel, signature(kernel, variant)] = Task(kernel, variant, COSTS[kernel])
    prepare(list(tasks.values()))


def _parts(variant: Variant) -> list[Any]:
    """The parts of a step, in the order of their addresses on the page."""
    parts = [soft_parts.pairs, soft_parts.find, soft_parts.solve, soft_parts.finish]
    return [*parts, soft_parts.impacts] if "bounces" in variant.on else parts
