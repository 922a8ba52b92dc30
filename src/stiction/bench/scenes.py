"""The list of benchmark scenes: name, what it is, its usual size, and whether it comes in other sizes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass

from stiction import checks
from stiction.bench import granular, masonry, stacks
from stiction.bench.scene import BenchScene
from stiction.errors import InvalidInputError


@dataclass(frozen=True)
class SceneEntry:
    """One scene of the list.

    Attributes:
        title: one sentence.
        builder: makes it; the first argument is the number of bodies where the scene comes in sizes.
        size: usual number of dynamic bodies.
        scalable: whether it comes in other sizes.
    """

    title: str
    builder: Callable[..., BenchScene]
    size: int
    scalable: bool = True


SCENES: dict[str, SceneEntry] = {
    "pyramid": SceneEntry("A flat pyramid of boxes, ten in the lowest row.", stacks.pyramid_of, 55),
    "pile": SceneEntry("Columns of ten boxes that fall into place.", stacks.pile, 1000),
    "tower": SceneEntry("Ten boxes upon each other.", stacks.tower, 10),
    "tower-uneven": SceneEntry("Ten boxes upon each other, 5 mm and 0.05 rad off at random.", stacks.uneven_tower, 10),
    "tower-heavy": SceneEntry("Five boxes upon each other, the top 100 times as heavy.", stacks.heavy_tower, 5),
    "card-house": SceneEntry("Five storeys of cards that only friction holds.", masonry.card_house, 40, False),
    "arch": SceneEntry("21 wedge stones in a half circle, without mortar.", masonry.arch, 21, False),
    "heap": SceneEntry("Spheres, boxes, capsules, cylinders and hulls dropped into a box.", granular.heap, 1000),
    "heap-simple": SceneEntry("Spheres and boxes dropped into a box.", granular.simple_heap, 1000),
    "spheres": SceneEntry("Equal spheres dropped into a box.", granular.spheres, 1000),
    "hopper": SceneEntry("Spheres that run out of a funnel.", granular.hopper, 10_000),
    "drum": SceneEntry("Spheres and boxes in a rotating drum.", granular.drum, 500),
}

DEFAULT_SCENES = ("pyramid", "pile")


def make(name: str, n: int | None = None, seed: int | None = None) -> BenchScene:
    """A scene of the list.

    Args:
        name: in the list.
        n: number of dynamic bodies; the usual one if left out. The pyramid takes the nearest number it can have.
        seed: of scenes that are drawn at random; others are what they are.

    Raises:
        InvalidInputError: the name is not in the list, or the scene comes in one size only.
    """
    entry = SCENES[checks.one_of("scene", name, SCENES)]
    seeded = seed is not None and "seed" in inspect.signature(entry.builder).parameters
    arguments = {"seed": seed} if seeded else {}
    if not entry.scalable:
        if n not in (None, entry.size):
            raise InvalidInputError(f"size of scene {name!r} must be {entry.size}, it comes in no other; got {n!r}.")
        return entry.builder(**arguments)
    return entry.builder(entry.size if n is None else checks.integer("size", n, minimum=1), **arguments)
