"""Kernels that are compiled at the same time, by this process and by children of it."""

from __future__ import annotations

from typing import Any, NamedTuple

from stiction.core.parts import Variant, signature


class Task(NamedTuple):
    """A kernel to be compiled, and how long that takes beside others."""

    kernel: Any
    variant: Variant
    cost: float


def prepare(tasks: list[Task]) -> None:
    """Have all kernels ready: loaded from the cache, or compiled."""
    for task in tasks:
        task.kernel.compile(signature(task.kernel, task.variant))
